"""Random films solved at tolerances of their own, each force held against a judge's."""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd

from numerics.estimates.films import random_film
from numerics.estimates.judge import MOST_UNKNOWNS, TIGHTER, judge
from numerics.films import Film
from squeezefilm.io.progress import say
from squeezefilm.io.solution import Solution
from squeezefilm.reynolds import solve
from squeezefilm.reynolds.device import Device

TOLERANCES = (1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7)
BATCH = 21


def campaign(
    *,
    first: int,
    films: int,
    seed: int,
    method: str,
    device: Device,
    most_unknowns: int = MOST_UNKNOWNS,
) -> pd.DataFrame:
    """A row for each film, numbered from ``first`` on; the tolerances take turns.

    ``verdict`` is ``kept``, ``outside tolerance``, ``outside estimate``, ``refused`` or, where no
    grid is good to TIGHTER times the tolerance, ``not judged``.
    """
    rows: list[dict[str, Any]] = []
    for start in range(first, first + films, BATCH):
        numbers = range(start, min(start + BATCH, first + films))
        rows += _rows(numbers, seed=seed, method=method, device=device, most_unknowns=most_unknowns)
        say(f"{len(rows)} of {films} films")
    return pd.DataFrame(rows)


def _rows(
    numbers: Sequence[int], *, seed: int, method: str, device: Device, most_unknowns: int
) -> list[dict[str, Any]]:
    some = [random_film(number, seed=seed) for number in numbers]
    scenes = [film.scene for film in some]
    tolerances = [TOLERANCES[number % len(TOLERANCES)] for number in numbers]
    solved: dict[int, Solution] = {}
    seconds = 0.0
    for tolerance in TOLERANCES:
        which = [index for index, each in enumerate(tolerances) if each == tolerance]
        begin = time.process_time()
        these = [scenes[index] for index in which]
        found = solve(these, tolerance=tolerance, method=method, device=device)
        seconds += time.process_time() - begin
        solved.update(zip(which, found, strict=True))
    say(f"solved in {seconds:.0f} processor seconds")
    solutions = [solved[index] for index in range(len(some))]
    verdicts = judge(scenes, solutions, tolerances, device=device, most_unknowns=most_unknowns)
    rows = []
    for number, film, tolerance, solution, verdict in zip(
        numbers, some, tolerances, solutions, verdicts, strict=True
    ):
        rows.append(
            {
                "film": number,
                **_numbers(film),
                "tolerance": tolerance,
                "method": solution.method,
                "force_n": solution.force_n,
                "estimate": solution.force_error_n / abs(solution.force_n or np.nan),
                "error": abs(solution.force_n - verdict.force_n) / abs(verdict.force_n or np.nan),
                "judge": verdict.error_n / abs(verdict.force_n or np.nan),
                "nx": solution.nx,
                "ny": solution.ny,
                "nt": solution.nt,
                "batch_seconds": seconds,
                "status": solution.status,
            }
        )
        rows[-1]["verdict"] = _verdict(rows[-1])
    return rows


def _numbers(film: Film) -> dict[str, Any]:
    return {
        "kind": film.name,
        "epsilon": film.epsilon,
        "sigma": film.sigma,
        "bearing": film.bearing,
        "x": film.x,
        "y": film.y,
    }


def _verdict(row: dict[str, Any]) -> str:
    if row["status"] != "ok":
        return "refused"
    if not row["judge"] <= TIGHTER * row["tolerance"]:
        return "not judged"
    if row["error"] > row["tolerance"] + row["judge"]:
        return "outside tolerance"
    if row["error"] > row["estimate"] + row["judge"]:
        return "outside estimate"
    return "kept"


def summary(table: pd.DataFrame) -> pd.DataFrame:
    """How many films had which verdict, and the median of estimate over error, by tolerance.

    An error below the judge's own counts as that.
    """
    judged = table[~table["verdict"].isin(["refused", "not judged"])]
    ratio: pd.Series = judged["estimate"] / np.maximum(judged["error"], judged["judge"])
    counts = pd.crosstab(table["tolerance"], table["verdict"], margins=True, margins_name="all")
    counts["median estimate over error"] = ratio.groupby(judged["tolerance"]).median()
    counts.loc["all", "median estimate over error"] = ratio.median()
    return counts
