"""How far each equation of a strip's film is from the resolved one, and how far each will do.

The films are those of one actuator, whose gap is varied: sigma Re = 12 rho0 omega^2 l0^2 / p0 then
stays as it is, about 1050 for the paper's frequency and finger in air (Re 0.45 at 5 um).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

import numpy as np
import pandas as pd

from numerics.films import FREQUENCY_HZ, LENGTH_M, PRESSURE_PA
from numerics.strip.film import StripFilm
from numerics.strip.force import Heat, Inertia, StripForce, force_on, two_grids
from squeezefilm.io.errors import RunError

DENSITY_KG_PER_M3 = 1.204
SIGMA_REYNOLDS = 12 * DENSITY_KG_PER_M3 * (2 * math.pi * FREQUENCY_HZ * LENGTH_M) ** 2 / PRESSURE_PA
EQUATIONS: dict[str, tuple[Inertia, Heat]] = {
    "resolved_heat": ("resolved", "resolved"),
    "resolved": ("resolved", "none"),
    "reynolds": ("none", "none"),
    "first_order": ("first-order", "none"),
    "one_mode": ("one-mode", "none"),
    "one_mode_heat": ("one-mode", "first-order"),
    "one_mode_of_heat": ("one-mode", "one-mode"),
}
AGAINST = {"resolved": ("reynolds", "first_order", "one_mode"), "resolved_heat": tuple(EQUATIONS)}
"""The yardsticks and what is held against each: the isothermal one, and the one with heat."""
BOUNDS = (1e-3, 1e-2)
UNCERTAIN = 1e-3
"""Relative error estimate above which a force is marked."""
FULL = {
    "epsilon": (0.05, 0.1, 0.2, 0.4, 0.6, 0.8),
    "reynolds": (0.05, 0.1, 0.2, 0.45, 0.9, 1.8, 3.6, 7.2, 10.0, 14.0, 20.0),
}
SAMPLE = {"epsilon": (0.2, 0.4), "reynolds": (0.05, 0.45, 1.8, 7.2)}
COLUMNS = (
    "epsilon",
    "reynolds",
    "sigma",
    "equation",
    "force",
    "estimated_error",
    "from_resolved",
    "from_resolved_heat",
    "nx",
    "nz",
    "nt",
    "status",
)
LIMIT_COLUMNS = ("epsilon", "equation", "against", "bound", "reynolds", "verdict")


def strip_table(
    *, epsilon: tuple[float, ...], reynolds: tuple[float, ...], log: Callable[[str], None]
) -> pd.DataFrame:
    """Rows of COLUMNS, one for each film and equation.

    Forces in p0 l0 per length, errors and differences relative. status: ok; uncertain where the
    error estimate is above UNCERTAIN; failed with the reason, and then no force.
    """
    rows = []
    for eps in epsilon:
        for re in reynolds:
            film = StripFilm(epsilon=eps, sigma=SIGMA_REYNOLDS / re, reynolds=re)
            rows += _rows(film)
            statuses = {str(row["status"]) for row in rows[-len(EQUATIONS) :]}
            log(f"ε = {eps:g}, Re = {re:g}: {'; '.join(sorted(statuses))}")
    return pd.DataFrame(rows, columns=list(COLUMNS))


def _rows(film: StripFilm) -> list[dict[str, object]]:
    grids = two_grids(film)
    found: dict[str, StripForce | RunError] = {}
    for equation, (inertia, heat) in EQUATIONS.items():
        try:
            found[equation] = force_on(grids, inertia=inertia, heat=heat)
        except RunError as error:
            found[equation] = error

    def difference(result: StripForce, yardstick: str) -> float:
        exact = found[yardstick]
        return result.force / exact.force - 1 if isinstance(exact, StripForce) else math.nan

    rows = []
    for equation, result in found.items():
        row: dict[str, object] = {
            "epsilon": film.epsilon,
            "reynolds": film.reynolds,
            "sigma": film.sigma,
            "equation": equation,
        }
        if isinstance(result, RunError):
            row["status"] = f"failed: {result}"
        else:
            row |= {
                "force": result.force,
                "estimated_error": result.relative_error,
                "from_resolved": difference(result, "resolved"),
                "from_resolved_heat": difference(result, "resolved_heat"),
                "nx": result.nx,
                "nz": result.nz,
                "nt": result.nt,
                "status": "ok" if result.relative_error <= UNCERTAIN else "uncertain",
            }
        rows.append(row)
    return rows


def strip_limits(table: pd.DataFrame) -> pd.DataFrame:
    """Rows of LIMIT_COLUMNS: the Re up to which an equation is within a bound of a yardstick.

    Between two Re the difference is taken as a power of Re, or as linear in log Re where it changes
    its sign. verdict: reached; below, where the
    smallest Re of the table is beyond the bound and the difference is taken in proportion to Re;
    beyond, where the largest solved is still within it, and Re is that one.
    """
    return pd.DataFrame(_limits(table), columns=list(LIMIT_COLUMNS))


def _limits(table: pd.DataFrame) -> Iterator[dict[str, object]]:
    for (epsilon, equation), rows in table.groupby(["epsilon", "equation"], sort=False):
        for yardstick, equations in AGAINST.items():
            if equation not in equations or equation == yardstick:
                continue
            column = f"from_{yardstick}"
            known = rows[rows[column].notna()].sort_values("reynolds")
            if known.empty:
                continue
            for bound in BOUNDS:
                reynolds, verdict = _crossing(
                    known["reynolds"].to_numpy(float),
                    known[column].to_numpy(float),
                    bound=bound,
                )
                yield {
                    "epsilon": epsilon,
                    "equation": equation,
                    "against": yardstick,
                    "bound": bound,
                    "reynolds": reynolds,
                    "verdict": verdict,
                }


def _crossing(reynolds: np.ndarray, error: np.ndarray, *, bound: float) -> tuple[float, str]:
    """The first Re at which a signed error leaves a bound, and how that is known."""
    above = np.flatnonzero(np.abs(error) > bound)
    if not len(above):
        return float(reynolds[-1]), "beyond"
    first = above[0]
    if first == 0:
        return float(reynolds[0] * bound / abs(error[0])), "below"
    before, after = np.sign(error[first]) * error[first - 1 : first + 1]
    if before > 0:
        share = math.log(bound / before) / math.log(after / before)
    else:  # it changed its sign in between, and is no power
        share = (bound - before) / (after - before)
    left, right = np.log(reynolds[first - 1 : first + 1])
    return float(np.exp(left + share * (right - left))), "reached"
