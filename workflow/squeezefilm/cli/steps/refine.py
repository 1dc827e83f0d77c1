"""Simulate, fit, judge, design, simulate …, until a model is good enough or cannot be.

  squeezefilm refine limit_1 --space four-factor --config C.yaml --rounds ROUNDS.csv \\
      --forces FORCES.csv --limits LIMITS.csv --fit FIT.json --where WHERE.csv --output VERDICT.json

The loop stops when the estimated errors over the space are below the wanted ones of the study's
section `refine`, or says what the limit is: the model, the simulations' own error, or the number
of simulations. Errors are estimated from verification points that are never fitted.

ROUNDS.csv has a row for each round, FORCES.csv every simulation (a point_id tells its kind and
round), LIMITS.csv the physics limits of the same scenes, FIT.json the fitted model with the range
of each parameter, WHERE.csv the model's error over the space, and VERDICT.json how it ended. With
--keep-going a model that needs the physics limits where they do not hold is left out before
anything is simulated: the two JSON files say why, and the tables are empty. --scan is what
`squeezefilm profile` says of a measured profile: part of the fit's error.
"""

from __future__ import annotations

import argparse
from dataclasses import asdict
from typing import Any

import numpy as np
import pandas as pd

from squeezefilm.cli.steps.fit import describe, scan_error_of
from squeezefilm.cli.steps.limits import with_limits
from squeezefilm.designs.closed_loop import Goal, Outcome, Pool, Round, run_loop
from squeezefilm.designs.experiments import ROUND_COLUMNS, WHERE_COLUMNS, check_columns
from squeezefilm.io.errors import InputError, RunError
from squeezefilm.io.tables import (
    FACTOR_COLUMNS,
    FORCE_COLUMNS,
    LIMIT_COLUMNS,
    scene_points,
    write_json,
    write_table,
)
from squeezefilm.models.fit import Fit
from squeezefilm.models.force_model import COLUMNS, ExpressionModel, Factors
from squeezefilm.models.library import SPACES, model_named
from squeezefilm.models.profile_likelihood import parameter_ranges
from squeezefilm.models.trust import Unseen
from squeezefilm.models.weak_spots import in_words, weak_spots
from squeezefilm.reynolds import Solution, solve
from squeezefilm.reynolds.device import choose_device
from squeezefilm.studies.config import Config, load_config
from squeezefilm.studies.space import Space
from squeezefilm.studies.study import directions_of, scene_of

SECTIONS = (
    "gas",
    "actuator",
    "finger",
    "solver",
    "screen",
    "positions",
    "fit",
    "models",
    "refine",
)
TYPICAL = 1000
"""Points of the fair sample of the space at which nothing is simulated."""
CLOSE = 0.3
"""The physics limit maps a model's error if it leaves less than this share of it unexplained."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("model", metavar="MODEL", help="of the library or the study")
    parser.add_argument("--space", default="four-factor", help="two-factor or four-factor")
    parser.add_argument("--scan", metavar="SUMMARY.json", help="of a measured profile")
    parser.add_argument("--config", required=True, metavar="CONFIG.yaml", help="the study")
    parser.add_argument("--rounds", required=True, metavar="ROUNDS.csv", help="what was estimated")
    parser.add_argument("--forces", required=True, metavar="FORCES.csv", help="what was simulated")
    parser.add_argument(
        "--limits", required=True, metavar="LIMITS.csv", help="physics limits there"
    )
    parser.add_argument("--fit", required=True, metavar="FIT.json", help="the fitted model")
    parser.add_argument("--where", required=True, metavar="WHERE.csv", help="errors over the space")
    parser.add_argument("--output", required=True, metavar="VERDICT.json", help="how it ended")
    parser.add_argument(
        "--keep-going",
        action="store_true",
        help="write into the files why the model cannot be used on the study, and exit with 0",
    )


def run(options: argparse.Namespace) -> None:
    config = load_config(options.config).only(SECTIONS)
    name = options.space.replace("-", "_")
    if name not in SPACES:
        raise InputError(f"--space {options.space!r} is unknown; known are {', '.join(SPACES)}")
    model = model_named(options.model, config["models"], place=options.config)
    scan_error = scan_error_of(config, options.scan)
    ground = _Ground.of(config, centred=name == "two_factor")
    try:
        check_columns(model, ground.pool.factors)
    except InputError as error:
        if not options.keep_going:
            raise
        _leave_out(options, {"model": model.name, "space": name, "refused": str(error)})
        return
    settings = config["refine"]
    outcome = run_loop(
        model,
        ground.pool,
        Goal(
            global_error=settings["global_error"],
            worst_error=settings["worst_error"],
            most_simulations=settings["simulations"],
            batch=settings["batch"],
        ),
        ground.simulate,
        separation=settings["separation"],
        bound=config["fit"]["bounds"][-1],
        seed=settings["seed"],
        report=_print_round,
    )
    print(f"{outcome.verdict}: {outcome.reason}")
    last = outcome.rounds[-1]
    labels = _labels(outcome, settings["verification"])
    forces = ground.forces(outcome.simulated, labels)
    where, source = _map(model, ground, outcome)
    spots = weak_spots(
        ground.pool.factors.take(ground.pool.typical), where["error_n"].to_numpy()[-TYPICAL:]
    )
    write_table(_rounds_table(outcome, model, ground), options.rounds)
    write_table(forces, options.forces)
    write_table(ground.limits(outcome.simulated, labels), options.limits)
    write_table(where, options.where)
    fit = _fit_values(model, ground, outcome, seed=settings["seed"], scan_error=scan_error)
    write_json(fit, options.fit)
    write_json(
        {
            "model": model.name,
            "space": name,
            "verdict": outcome.verdict,
            "reason": outcome.reason,
            "weak_spots": spots.to_dict("records"),
            "weak_spots_in_words": in_words(spots),
            "errors_mapped_by": source,
            "mean_force_n": outcome.scale_n,
            "theta_of_all_points": [float(value) for value in outcome.hindsight],
            "simulations": last.simulations,
            "fitted_points": len(last.design),
            "verification_points": settings["verification"],
            "lack_of_fit_n": last.lack_of_fit * outcome.scale_n,
            "wanted": {key: settings[key] for key in ("global_error", "worst_error")},
            "estimated": _finite(
                {
                    key: getattr(last, key)
                    for key in ("global_error", "global_lower", "global_upper", "worst_error")
                }
            ),
            "settings": dict(settings),
        },
        options.output,
    )


def _leave_out(options: argparse.Namespace, verdict: dict[str, Any]) -> None:
    """Files that say why there is nothing in them."""
    write_table(pd.DataFrame(columns=list(ROUND_COLUMNS)), options.rounds)
    write_table(pd.DataFrame(columns=list(FORCE_COLUMNS)), options.forces)
    write_table(pd.DataFrame(columns=list(LIMIT_COLUMNS)), options.limits)
    write_table(pd.DataFrame(columns=list(WHERE_COLUMNS)), options.where)
    write_json(verdict, options.fit)
    write_json(verdict, options.output)
    print(verdict["refused"])


class _Ground:
    """The points of the study that the loop knows of, and the means to simulate them."""

    def __init__(self, config: Config, space: Space, table: pd.DataFrame, parts: list[int]) -> None:
        self.config, self.table = config, table
        self.scenes = [scene_of(point, config) for point in scene_points(table)]
        self.known = with_limits(table, self.scenes)
        self.solutions: dict[int, Solution] = {}
        self.device = choose_device(config["solver"]["device"])
        columns = {name: self.known[name].to_numpy() for name in COLUMNS.values()}
        factors = {name: table[name].to_numpy() for name in FACTOR_COLUMNS}
        bounds = np.cumsum([0, *parts])
        kinds = [np.arange(bounds[i], bounds[i + 1]) for i in range(len(parts))]
        self.pool = Pool(
            Factors.of(**factors, **columns), space.coordinates(space.points(table)), *kinds
        )

    @classmethod
    def of(cls, config: Config, *, centred: bool) -> _Ground:
        settings = config["refine"]
        space = Space.of(config, centred=centred)
        grid = space.grid(settings["candidates"], distinct=True)
        checks = space.sample(settings["verification"], seed=settings["seed"])
        typical = space.sample(TYPICAL, seed=settings["seed"] + 1)
        table = space.table(np.concatenate([grid, checks, typical]))
        return cls(config, space, table, [len(grid), len(checks), len(typical)])

    def simulate(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Forces and their errors; raises RunError for a scene that has no force."""
        solver = self.config["solver"]
        found = solve(
            [self.scenes[point] for point in points],
            tolerance=solver["tolerance"],
            method=solver["method"],
            device=self.device,
        )
        for point, solution in zip(points, found, strict=True):
            if solution.status != "ok":
                factors = self.table.loc[point, list(FACTOR_COLUMNS)].to_dict()
                raise RunError(f"no force at {factors}: {solution.status}")
            self.solutions[int(point)] = solution
        return (
            np.array([solution.force_n for solution in found]),
            np.array([solution.force_error_n for solution in found]),
        )

    def forces(self, points: np.ndarray, labels: list[str]) -> pd.DataFrame:
        rows = self.table.loc[points].assign(point_id=labels).reset_index(drop=True)
        for name in FORCE_COLUMNS:
            if name not in rows.columns:
                rows[name] = [getattr(self.solutions[int(point)], name) for point in points]
        return rows[list(FORCE_COLUMNS)]

    def limits(self, points: np.ndarray, labels: list[str]) -> pd.DataFrame:
        rows = self.known.loc[points].assign(point_id=labels).reset_index(drop=True)
        return rows[list(LIMIT_COLUMNS)]


def _labels(outcome: Outcome, checks: int) -> list[str]:
    """What each simulation was for: verification-3, or design-2-5, the fifth, of round two."""
    labels = [f"verification-{number}" for number in range(1, checks + 1)]
    for done in outcome.rounds:
        before = len(labels) - checks
        labels += [
            f"design-{done.number}-{number}" for number in range(before + 1, len(done.design) + 1)
        ]
    return labels


def _map(model: ExpressionModel, ground: _Ground, outcome: Outcome) -> tuple[pd.DataFrame, str]:
    """The error of the best fit over the space: candidates, then the fair sample.

    Where the physics limit explains it at the simulated points it does so in between; otherwise
    the errors at these points are interpolated.
    """
    pool = ground.pool
    places = np.concatenate([pool.candidates, pool.typical])
    own = model.evaluate(outcome.hindsight, pool.factors)
    seen = own[outcome.simulated] - outcome.force_n
    limit = ground.known["limit_n"].to_numpy()
    left = outcome.force_n - limit[outcome.simulated]
    if not model.column_names and np.linalg.norm(left) < CLOSE * np.linalg.norm(seen):
        error, source = own[places] - limit[places], "physics limit"
    else:
        error, source = _interpolated(pool, outcome.simulated, seen, places), "interpolation"
    rows = ground.table.loc[places, list(FACTOR_COLUMNS)].reset_index(drop=True)
    kinds = np.repeat(["candidate", "sample"], [len(pool.candidates), len(pool.typical)])
    return rows.assign(layer=kinds, error_n=error), source


def _interpolated(
    pool: Pool, points: np.ndarray, values: np.ndarray, places: np.ndarray
) -> np.ndarray:
    from scipy.interpolate import RBFInterpolator  # slow to import, and only needed here

    degree = 1 if len(points) > pool.coordinates.shape[1] + 1 else 0
    surface = RBFInterpolator(
        pool.coordinates[points], values, kernel="linear", degree=degree if degree else 0
    )
    return np.asarray(surface(pool.coordinates[places]))


def _rounds_table(outcome: Outcome, model: ExpressionModel, ground: _Ground) -> pd.DataFrame:
    rows = []
    for done in outcome.rounds:
        worst = ground.table.loc[done.worst_at, list(FACTOR_COLUMNS)]
        row = {
            "round": done.number,
            "simulations": done.simulations,
            "fitted_points": len(done.design),
            "global_error": done.global_error,
            "global_lower": done.global_lower,
            "global_upper": done.global_upper,
            "lack_of_fit": done.lack_of_fit,
            "worst_error": done.worst_error,
            **{f"worst_{name}": worst[name] for name in FACTOR_COLUMNS},
            "parameter_share": done.parameter_share,
            "floor": done.floor,
            "simulation_error": done.simulation_error,
        }
        theta = dict(zip(model.parameter_names, done.theta, strict=True))
        rows.append(row | {f"parameter_{name}": value for name, value in theta.items()})
    return pd.DataFrame(rows)


def _fit_values(
    model: ExpressionModel, ground: _Ground, outcome: Outcome, *, seed: int, scan_error: float
) -> dict[str, Any]:
    """The last fit as its file tells it, with the range of each parameter."""
    last = outcome.rounds[-1]
    # A model without parameters is fitted to nothing, and described on what verifies it.
    points = last.design if len(last.design) else outcome.simulated
    factors = ground.pool.factors.take(points)
    force = np.array([ground.solutions[int(point)].force_n for point in points])
    error = np.array([ground.solutions[int(point)].force_error_n for point in points])
    misses = model.evaluate(last.theta, factors) - force
    fit = Fit(
        model=model.name,
        theta=tuple(float(value) for value in last.theta),
        sum_of_squares=float(np.sum(misses**2)),
        global_error=float(np.linalg.norm(misses) / np.linalg.norm(force)),
        points=len(last.design),
        method="closed loop",
        bound=0.0,
        seed=seed,
        searches=0,
        evaluations=0,
        search_theta=tuple(float(value) for value in last.theta),
    )
    ranges = []
    if len(last.theta):
        for each in parameter_ranges(model, factors, force, last.theta):
            plain = {key: asdict(each)[key] for key in ("name", "unit", "estimate")}
            ends = {"lower": each.lower, "upper": each.upper}
            ranges.append(plain | _finite(ends))
    return {
        **fit.to_dict(),
        **describe(
            model,
            factors,
            force,
            fit,
            force_error_n=error,
            scan_error=scan_error,
            control=_verified(model, ground, last),
        ),
        "directions": directions_of(ground.config).to_dict(),
        "parameter_ranges": ranges,
        "parameter_ranges_note": (
            "95 % profile-likelihood intervals; residuals are the model's lack of fit, the same "
            "each time, so a range says how far a parameter can go while the model describes these "
            "points about as well, and nothing of a scatter; null is open"
        ),
        "error": {
            "held_out_global": last.global_error,
            "held_out_global_upper": last.global_upper,
            "verification_points": len(ground.pool.verification),
        },
    }


def _verified(model: ExpressionModel, ground: _Ground, last: Round) -> Unseen:
    """The model's errors at the verification points, which are never fitted."""
    checks = ground.pool.verification
    solutions = [ground.solutions[int(point)] for point in checks]
    factors = ground.pool.factors.take(checks)
    return Unseen.of(
        factors,
        model_n=model.evaluate(last.theta, factors),
        force_n=[each.force_n for each in solutions],
        force_error_n=[each.force_error_n for each in solutions],
    )


def _finite(values: dict[str, float]) -> dict[str, float | None]:
    """Numbers for JSON, which knows no infinity."""
    return {key: float(value) if np.isfinite(value) else None for key, value in values.items()}


def _print_round(done: Round) -> None:
    print(
        f"round {done.number}: {done.simulations} simulations, global error {done.global_error:.2g}"
        f" ({done.global_lower:.2g} … {done.global_upper:.2g}), worst {done.worst_error:.2g}, "
        f"floor {done.floor:.2g}"
    )
