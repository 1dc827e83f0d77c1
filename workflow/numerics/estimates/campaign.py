"""Random films solved at tolerances of their own, each force held against a judge's."""

from __future__ import annotations

import math
import re
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from numerics.estimates.any_gap import random_gap_film
from numerics.estimates.films import random_film
from numerics.estimates.judge import MOST_WORK, TIGHTER, Verdict, judge
from numerics.films import Film, balanced_points
from squeezefilm.film.scene import Scene
from squeezefilm.io.errors import InputError
from squeezefilm.io.progress import say
from squeezefilm.io.solution import Solution
from squeezefilm.io.tables import write_table
from squeezefilm.reynolds import solve
from squeezefilm.reynolds.device import Device
from squeezefilm.reynolds.needs import needs_of
from squeezefilm.reynolds.periodic.gap_numbers import gap_numbers
from squeezefilm.reynolds.solver import ways_of

TOLERANCES = (1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7)
METHODS = ("periodic", "auto")


@dataclass(frozen=True)
class Draw:
    """Films by their numbers, and the tolerances that take turns.

    film: called with a number and ``seed``.
    """

    film: Callable[..., Film]
    tolerances: tuple[float, ...]

    def tolerance(self, number: int) -> float:
        return self.tolerances[number % len(self.tolerances)]


DRAWS = {
    "even-gap": Draw(random_film, TOLERANCES),
    "any-gap": Draw(random_gap_film, TOLERANCES[:-1]),
}
# What a force has beside its own error where it was not held against a judge.
NOT_HELD = ("refused", "not judged")


def campaign(
    *,
    first: int,
    films: int,
    seed: int,
    output: Path,
    device: Device,
    draw: str = "even-gap",
    most_work: float = MOST_WORK,
) -> pd.DataFrame:
    """Rows for each film, numbered from ``first`` on, a row for each of METHODS; dear ones last.

    ``verdict`` is ``kept``, ``outside tolerance``, ``outside estimate``, ``refused`` or, where no
    grid is good to TIGHTER times the tolerance, ``not judged``. The tolerances take turns.

    Args:
        draw: one of DRAWS.
        output: table that is written anew after every film; the films in it are not solved again.
        most_work: see ``judge``.
    """
    table = pd.read_csv(output) if output.exists() else pd.DataFrame({"film": []})
    if "film" not in table:
        raise InputError(f"{output}: no table of films, which a run would go on with")
    numbers = range(first, first + films)
    drawn = {number: DRAWS[draw].film(number, seed=seed) for number in numbers}
    dear = {n: _dear(film, tolerance=DRAWS[draw].tolerance(n)) for n, film in drawn.items()}
    for number in sorted(numbers, key=lambda number: dear[number]):
        if number in set(table["film"]):
            continue
        tolerance = DRAWS[draw].tolerance(number)
        rows = _rows(drawn[number], tolerance=tolerance, device=device, most_work=most_work)
        rows = [{"film": number, **row} for row in rows]
        table = pd.concat([table, pd.DataFrame(rows)] if len(table) else [pd.DataFrame(rows)])
        write_table(table, output)
        say(f"film {number}: {rows[0]['kind']}, {', '.join(row['verdict'] for row in rows)}")
    return table


def _dear(film: Film, *, tolerance: float) -> float:
    """Roughly in proportion to what a film costs, so that the table soon has most of them."""
    gap = gap_numbers(film.scene)
    sigma = max(gap["sigma"], (5 * film.bearing / (1 - gap["epsilon"])) ** 2)
    like = replace(film, epsilon=gap["epsilon"], sigma=sigma)
    points = balanced_points(like, tolerance, fold=(False, False))
    return math.prod(points) * max(points) / (1 - gap["epsilon"])


def _rows(
    film: Film, *, tolerance: float, device: Device, most_work: float
) -> list[dict[str, Any]]:
    scene = film.scene
    solutions: list[Solution] = []
    seconds = []
    for method in METHODS:
        begin = time.process_time()
        if solutions and _takes_a_grid(scene, tolerance=tolerance, method=method):
            solutions.append(solutions[0])
        else:
            solutions += solve([scene], tolerance=tolerance, method=method, device=device)
        seconds.append(time.process_time() - begin)
    begin = time.process_time()
    verdict = Verdict(np.nan, np.nan)
    if any(each.status == "ok" for each in solutions):
        verdict = judge(scene, tolerance=tolerance, device=device, most_work=most_work)
    judged = time.process_time() - begin
    return [
        {
            **_numbers(film),
            "tolerance": tolerance,
            "asked": asked,
            **_held(solution, verdict, tolerance=tolerance),
            "solve_seconds": took,
            "judge_seconds": judged,
            "status": solution.status,
        }
        for asked, solution, took in zip(METHODS, solutions, seconds, strict=True)
    ]


def _takes_a_grid(scene: Scene, *, tolerance: float, method: str) -> bool:
    """Whether a method leaves a scene to the periodic state, as it is solved for by that name."""
    (way,) = ways_of([scene], [needs_of(scene)], tolerance=tolerance, method=method)
    return way.limit is None


def _numbers(film: Film) -> dict[str, Any]:
    return {
        "kind": film.name,
        "epsilon": film.epsilon,
        "sigma": film.sigma,
        "bearing": film.bearing,
        "x": film.x,
        "y": film.y,
        "narrowest": film.scene.narrowest,
    }


def _held(solution: Solution, verdict: Verdict, *, tolerance: float) -> dict[str, Any]:
    """A force beside the judge's; errors are relative."""
    force = abs(verdict.force_n) or np.nan
    row = {
        "method": solution.method,
        "force_n": solution.force_n,
        "estimate": solution.force_error_n / (abs(solution.force_n) or np.nan),
        "error": abs(solution.force_n - verdict.force_n) / force,
        "judge": verdict.error_n / force,
        "grid": f"{solution.nx} × {solution.ny} × {solution.nt}",
        "judge_grid": verdict.size,
    }
    return {**row, "verdict": _verdict(row, solution.status, tolerance=tolerance)}


def _verdict(row: dict[str, Any], status: str, *, tolerance: float) -> str:
    if status != "ok":
        return "refused"
    if not row["judge"] <= TIGHTER * tolerance:
        return "not judged"
    if row["error"] > tolerance + row["judge"]:
        return "outside tolerance"
    if row["error"] > row["estimate"] + row["judge"]:
        return "outside estimate"
    return "kept"


def summary(table: pd.DataFrame) -> pd.DataFrame:
    """How many films had which verdict, and the median of estimate over error, by tolerance.

    An error below the judge's own counts as that. The last row of a method is of all tolerances.
    """
    rows = []
    for asked, some in table.groupby("asked", sort=False):
        for name, group in [*some.groupby("tolerance"), ("all", some)]:
            held = group[~group["verdict"].isin(NOT_HELD)]
            ratio = held["estimate"] / np.maximum(held["error"], held["judge"])
            counts = group["verdict"].value_counts().to_dict()
            label = name if name == "all" else f"{name:g}"
            rows.append({"asked": asked, "tolerance": label, "films": len(group), **counts})
            rows[-1]["median estimate over error"] = float(ratio.median())
    return pd.DataFrame(rows).fillna(0)


def refusals(table: pd.DataFrame) -> pd.Series:
    """How many films were refused, by method and cause: statuses without their numbers."""
    refused = table[table["verdict"] == "refused"]
    causes = refused["status"].map(lambda status: re.split(r"[:(]| about ", status)[0].strip())
    return causes.groupby([refused["asked"], causes]).size()
