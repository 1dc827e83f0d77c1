"""A model refined on a study: the loop's points, their simulations, and what its files tell."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd

from squeezefilm.config.study import Study
from squeezefilm.designs.sequential import Outcome, PointPool, RefinementRound, SequentialDesign
from squeezefilm.designs.space import coordinate_function
from squeezefilm.errors import InputError, RunError
from squeezefilm.film.positions import columns_in_table_form
from squeezefilm.formatting import interval_text
from squeezefilm.models.data import factors_of_table
from squeezefilm.models.fit_file import fit_from_values
from squeezefilm.models.fitting import Fit
from squeezefilm.models.force_model import ExpressionModel, check_columns_known
from squeezefilm.models.prediction_interval import error_by_region_text
from squeezefilm.studies.solver_settings import solver_settings
from squeezefilm.studies.space import points_of_table, space_of_study, table_of_points
from squeezefilm.studies.study import scenes_of_table
from squeezefilm.studies.tasks.fits import fit_values, with_prediction_interval
from squeezefilm.studies.tasks.physics_limits import with_asymptotic_forces
from squeezefilm.tables import (
    ASYMPTOTIC_FORCE_COLUMNS,
    FACTOR_COLUMNS,
    FORCE_COLUMNS,
    REFINEMENT_ROUND_COLUMNS,
)

ERROR_MAP_SAMPLE_POINTS = 1000
"""Points of the fair sample of the space at which nothing is simulated."""
MAX_UNEXPLAINED_FRACTION = 0.3
"""The expansion maps a model's error if it leaves less than this share of it unexplained."""


REFINEMENT_TABLE_NAMES = ("rounds", "forces", "limits", "where")
"""What a refinement leaves as tables."""


class PlanSimulator:
    """The points of a study that the loop knows of, and the means to simulate them."""

    def __init__(self, config: Study, *, centred: bool) -> None:
        settings = config.refine
        space = space_of_study(config, centred=centred)
        kinds = [
            space.grid(settings.candidates, distinct=True),
            space.sample(settings.verification, seed=settings.seed),
            space.sample(ERROR_MAP_SAMPLE_POINTS, seed=settings.seed + 1),
        ]
        self.config = config
        self.table = table_of_points(np.concatenate(kinds), space)
        self.scenes = scenes_of_table(self.table, config)
        self.known = with_asymptotic_forces(self.table, self.scenes)
        self.solved = pd.DataFrame()
        self.pool = PointPool(
            factors_of_table(self.known),
            coordinate_function("scene", space)(points_of_table(self.table, space)),
            *np.split(np.arange(len(self.table)), np.cumsum([len(each) for each in kinds])[:-1]),
        )

    def simulate(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Forces and their errors; raises RunError for a scene that has no force."""
        settings = solver_settings(self.config, outputs=())
        forces = settings.solve(self.scenes[points]).to_frame(pd.Index(points))
        for point, status in forces["status"][forces["status"] != "ok"].items():
            (factors,) = self.point_rows(self.table, [point], FACTOR_COLUMNS).to_dict("records")
            raise RunError(f"no force at {factors}: {status}")
        self.solved = pd.concat([self.solved, forces])
        return forces["force_n"].to_numpy(), forces["force_error_n"].to_numpy()

    def point_rows(self, table: pd.DataFrame, points: Any, columns: Sequence[str]) -> pd.DataFrame:
        """Columns of points in one of the tables, in the form that positions have there."""
        return table.loc[points, columns_in_table_form(columns, table)].reset_index(drop=True)


def refine(
    model: ExpressionModel, config: Study, *, space: str, sample: pd.DataFrame, uncertainty: float
) -> tuple[dict[str, pd.DataFrame], dict[str, Any], dict[str, Any]]:
    """Refine a model by the study's section ``refine``, validate its last fit; print the rounds.

    A model that needs the asymptotic forces where they do not hold is not supported: nothing is
    simulated: the fit and the verdict have the reason, and the tables are empty.

    Args:
        space: ``two_factor`` or ``four_factor``.
        sample: forces of a validation sample.
        uncertainty: fraction of a force, uncertainty by the scan of a measured profile.

    Returns: tables by their names (REFINEMENT_TABLE_NAMES), the last fit, and the verdict.

    Raises InputError where the section allows too few simulations to begin with, and RunError for a
    scene that has no force.
    """
    simulated, settings = PlanSimulator(config, centred=space == "two_factor"), config.refine
    pool, about = simulated.pool, {"model": model.name, "space": space}
    try:
        check_columns_known(model, pool.factors)
    except InputError as error:
        print(error)
        reason = about | {"not_supported": str(error)}
        return (
            dict.fromkeys(REFINEMENT_TABLE_NAMES, pd.DataFrame(columns=["status"])),
            reason,
            reason,
        )
    bound = config.fit.bounds[-1]
    outcome = SequentialDesign(model, pool, settings, simulated.simulate, bound=bound).run(
        _print_round
    )
    print(f"{outcome.verdict}: {outcome.reason}")
    values = _fit_values(model, simulated, outcome, uncertainty=uncertainty)
    fit = fit_from_values(values, source=f"{config.study}: {model.name}")
    fit = with_prediction_interval(fit, config, sample=sample)
    print(fit.statement)
    last, points = outcome.rounds[-1], outcome.simulated_indices
    where, source = _error_map(model, simulated, outcome)
    by_region = error_by_region_text(
        pool.factors.take(pool.fair_sample_indices), where["error_n"][-ERROR_MAP_SAMPLE_POINTS:]
    )
    labels = _purpose_labels(outcome, settings.verification)
    known, forces = (
        table.assign(point_id=pd.Series(labels, index=points))
        for table in (simulated.known, simulated.table.join(simulated.solved))
    )
    tables = {
        "rounds": _rounds_table(outcome, model, simulated),
        "forces": simulated.point_rows(forces, points, FORCE_COLUMNS),
        "limits": simulated.point_rows(known, points, ASYMPTOTIC_FORCE_COLUMNS),
        "where": where,
    }
    verdict = about | {
        "verdict": outcome.verdict,
        "reason": outcome.reason,
        "mean_force_n": outcome.rms_force_n,
        "theta_of_all_points": outcome.theta_of_all_points.tolist(),
        "simulations": last.simulations,
        "verification_points": settings.verification,
        "lack_of_fit_n": _json_number(last.lack_of_fit * outcome.rms_force_n),
        "required": settings.model_dump(include={"global_error", "worst_error"}),
        "estimated": {
            key: _json_number(getattr(last, key)) for key in REFINEMENT_ROUND_COLUMNS[1:]
        },
        "errors_mapped_by": source,
        "error_by_region_text": by_region,
    }
    return tables, fit.to_dict(), verdict


def _print_round(done: RefinementRound) -> None:
    limits = interval_text(done.global_lower, done.global_upper, sign="")
    print(
        f"round {done.number}: {done.simulations} simulations, global error {done.global_error:.2g}"
        f" ({limits}), worst {done.worst_error:.2g}, floor {done.floor:.2g}"
    )


def _purpose_labels(outcome: Outcome, checks: int) -> list[str]:
    """Purpose of each simulation: verification-3, or design-2-5, the fifth, of round two."""
    labels = [f"verification-{number}" for number in range(1, checks + 1)]
    for done in outcome.rounds:
        new = range(len(labels) - checks + 1, len(done.design) + 1)
        labels += [f"design-{done.number}-{number}" for number in new]
    return labels


def _error_map(
    model: ExpressionModel, space: PlanSimulator, outcome: Outcome
) -> tuple[pd.DataFrame, str]:
    """The error of the best fit over the space: candidates, then the fair sample.

    Where the asymptotic expansion explains it at the simulated points it does so in between;
    otherwise the errors at these points are interpolated.
    """
    from scipy.interpolate import RBFInterpolator  # slow to import, and only needed here

    pool, points = space.pool, outcome.simulated_indices
    rows = np.concatenate([pool.candidates, pool.fair_sample_indices])
    own = model.evaluate(outcome.theta_of_all_points, pool.factors)
    seen = own[points] - outcome.force_n
    limit = space.known["limit_n"].to_numpy()
    left = outcome.force_n - limit[points]
    if not model.column_names and np.linalg.norm(left) < MAX_UNEXPLAINED_FRACTION * np.linalg.norm(
        seen
    ):
        error, source = own[rows] - limit[rows], "asymptotic expansion"
    else:
        at = pool.coordinates
        degree = 1 if len(points) > at.shape[1] + 1 else 0
        surface = RBFInterpolator(at[points], seen, kernel="linear", degree=degree)
        error, source = surface(at[rows]), "interpolation"
    layer = np.where(np.isin(rows, pool.candidates), "candidate", "sample")
    where = space.point_rows(space.table, rows, FACTOR_COLUMNS)
    return where.assign(layer=layer, error_n=error), source


def _rounds_table(outcome: Outcome, model: ExpressionModel, space: PlanSimulator) -> pd.DataFrame:
    rounds = pd.DataFrame([vars(each) for each in outcome.rounds])
    rounds["design"] = rounds["design"].map(len)
    rounds = rounds.rename(columns={"number": "round", "design": "fitted_points"})
    worst = space.point_rows(
        space.table, rounds.pop("worst_error_index"), FACTOR_COLUMNS
    ).add_prefix("worst_")
    theta = pd.DataFrame(rounds.pop("theta").tolist(), columns=list(model.parameter_names))
    estimated, fractions = rounds.loc[:, :"worst_error"], rounds.loc[:, "parameter_fraction":]
    return pd.concat([estimated, worst, fractions, theta.add_prefix("parameter_")], axis=1)


def _fit_values(
    model: ExpressionModel, space: PlanSimulator, outcome: Outcome, *, uncertainty: float
) -> dict[str, Any]:
    """The last fit as its file tells it."""
    last = outcome.rounds[-1]
    # A model without parameters is fitted to nothing, and described on what verifies it.
    points = last.design if len(last.design) else outcome.simulated_indices
    factors, forces = space.pool.factors.take(points), space.solved.loc[points]
    force_n, seed = forces["force_n"].to_numpy(), space.config.refine.seed
    fit = Fit.of(model, factors, force_n, last.theta, method="closed loop", bound=0.0, seed=seed)
    absent_terms = space.solved["absent_terms"]
    return {
        **fit_values(
            model, space.config, factors, force_n, fit, absent_terms, uncertainty=uncertainty
        ),
        "points": len(last.design),
    }


def _json_number(value: float) -> float | None:
    """A number for JSON, which knows no infinity."""
    return float(value) if np.isfinite(value) else None
