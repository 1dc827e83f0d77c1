"""Measured forces beside computed ones: the residuals, and what they are worth."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from squeezefilm.api.film import Film
from squeezefilm.api.forces import Force, solve_with_settings
from squeezefilm.config.study import Study
from squeezefilm.film.validity import OK
from squeezefilm.lazy import pd
from squeezefilm.quantities.derivatives import scene_with_quantity_changed
from squeezefilm.studies.solver_settings import SolverSettings
from squeezefilm.studies.study import measured_force_table

# Probability of χ² below which differences count as larger than their uncertainty; and how many
# standard uncertainties above which the difference of a single point is named.
MIN_CHI_SQUARE_PROBABILITY, MAX_RESIDUAL_OVER_UNCERTAINTY = 0.05, 2.0
# Columns of what makes the uncertainty of a measured force.
FORCE_UNCERTAINTY_COLUMNS = [f"force_uncertainty{part}_n" for part in ("", "_h0", "_hv")]


def compare_measurements(config: Study) -> pd.DataFrame:
    """Return a study's measured forces beside computed ones, a row for each point.

    ``force_uncertainty_h0_n`` and ``…_hv_n`` are what the uncertainties of gap and amplitude make
    of the force: half of its change over ± one of them (JCGM 100:2008, 5.1.3, note 2), which needs
    no derivative, so that it is there for any pad and with inertia. ``modelling_error_lower_n`` and
    ``…_upper_n`` are NaN where the error is not known, as beyond a limit of validity and beyond the
    range of a first order. Further columns are those of ``with_residuals``.

    Raises InputError for a wrong table of measurements.
    """
    points, film = measured_force_table(config), Film(config, {"outputs": ()})
    forces = film.solved(film.scenes(points), budget=True)
    computed = pd.DataFrame(
        [_computed_force_columns(force) for force in forces], index=points.index
    )
    table = points.rename(columns={"force_n": "measured_force_n"}).assign(**computed)
    for factor, column in zip(("h0", "hv"), FORCE_UNCERTAINTY_COLUMNS[1:], strict=True):
        off_m = points[f"{factor}_uncertainty_m"].to_numpy()
        table[column] = _propagated_uncertainty_n(f"{factor}_m", off_m, forces, film.solver())
    lacking = (table["status"] == OK) & table[FORCE_UNCERTAINTY_COLUMNS].isna().any(axis=1)
    table.loc[lacking, "status"] = "no force at h0 or hv plus or minus its uncertainty"
    return with_residuals(table)


def _computed_force_columns(force: Force) -> dict[str, Any]:
    """Return a computed force and its errors, by names of columns."""
    known = force.validity == OK
    bounds = force.modelling_error_percent if known else (np.nan, np.nan)
    lower_n, upper_n = sorted(percent / 100 * force.force_n for percent in bounds)
    return {
        "force_n": force.force_n,
        "force_error_n": force.solution.force_error_n,
        "profile_uncertainty_n": force.scan["scan_error_n"] if force.scan else 0.0,
        "modelling_error_lower_n": lower_n,
        "modelling_error_upper_n": upper_n,
        "validity": force.validity,
        "status": force.status,
    }


def _propagated_uncertainty_n(
    name: str, off_m: np.ndarray, forces: Sequence[Force], settings: SolverSettings
) -> np.ndarray:
    """Return the uncertainty (N) of each force due to that of a factor; NaN if not known."""
    parts_n = np.array([0.0 * force.force_n for force in forces])
    rows = np.flatnonzero((off_m > 0) & np.isfinite(parts_n)).tolist()
    ends = [
        scene_with_quantity_changed(forces[k].scene, name, sign * off_m[k])
        for sign in (1, -1)
        for k in rows
    ]
    more, less = solve_with_settings(ends, settings=settings).force_n.reshape(2, -1)
    parts_n[rows] = np.abs(more - less) / 2
    return parts_n


def with_residuals(table: pd.DataFrame) -> pd.DataFrame:
    """Return a comparison with its residuals.

    ``measurement_uncertainty_n`` is the root of the squares of FORCE_UNCERTAINTY_COLUMNS;
    ``residual_n`` the measured force less the computed one; ``unexplained_n`` its part beyond the
    sum of numerical error, profile uncertainty and modelling error: NaN where the last is not
    known.
    """
    uncertainty_n = np.sqrt((table[FORCE_UNCERTAINTY_COLUMNS] ** 2).sum(axis=1, skipna=False))
    residual_n = table["measured_force_n"] - table["force_n"]
    error_n = table["force_error_n"] + table["profile_uncertainty_n"]
    above = residual_n - table["modelling_error_upper_n"] - error_n
    below = residual_n - table["modelling_error_lower_n"] + error_n
    unexplained_n = np.maximum(above, 0.0) + np.minimum(below, 0.0)
    return table.assign(
        measurement_uncertainty_n=uncertainty_n,
        residual_n=residual_n,
        residual_over_uncertainty=residual_n / uncertainty_n,
        unexplained_n=unexplained_n,
    )


def chi_square_summary(table: pd.DataFrame) -> dict[str, Any]:
    """Return χ² of a comparison's solved points, of residuals and of their unexplained parts.

    Nothing is fitted, so that each point is a degree of freedom. A χ² of which a part is not known
    is None. ``verdict`` says in words what the differences are worth, no more than is known.
    """
    from scipy.stats import chi2

    solved = table[table["status"] == OK].set_index("point_id")
    uncertainty_n, count = solved["measurement_uncertainty_n"], len(solved)
    ratios = solved[["residual_n", "unexplained_n"]].div(uncertainty_n, axis=0)
    # What is not known of a residual adds nothing: a lower bound of χ².
    squares, beyond = (ratios**2).sum().tolist()
    chance = float(chi2.sf(squares, max(count, 1)))
    chance_beyond = float(chi2.sf(beyond, max(count, 1)))
    off, unknown = ratios["unexplained_n"].abs(), int(ratios["unexplained_n"].isna().sum())
    larger = "larger than measurement uncertainty"
    if not count:
        worth = "not known: none has a computed force"
    elif chance >= MIN_CHI_SQUARE_PROBABILITY:
        worth = "within measurement uncertainty"
    elif chance_beyond < MIN_CHI_SQUARE_PROBABILITY:
        names = ", ".join(off.index[off > MAX_RESIDUAL_OVER_UNCERTAINTY]) or "no single point"
        most = f"by more than {MAX_RESIDUAL_OVER_UNCERTAINTY:g} uncertainties at {names}"
        worth = f"{larger} and the known errors of the computed forces, {most}"
    else:
        scan = "and the uncertainty of the scan " * bool(solved["profile_uncertainty_n"].any())
        missing = f"is not known at {unknown} of them, so that it is open whether it explains them"
        worth = f"{larger}; the modelling error {missing if unknown else scan + 'can explain them'}"
    return {
        "degrees_of_freedom": count,
        "chi_square": squares,
        "probability": chance,
        "chi_square_unexplained": None if unknown else beyond,
        "probability_unexplained": None if unknown else chance_beyond,
        "verdict": f"taken together ({count} of {len(table)} points), differences are {worth}",
    }
