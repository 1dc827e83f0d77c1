"""The force of a film, far better than another solve has it, on grids that share no node with its.

Nothing of how the solver chooses its grids or estimates their errors is used: two grids after each
other have to agree.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import gcd

import numpy as np

from squeezefilm.film.scene import Scene
from squeezefilm.io.solution import Solution
from squeezefilm.reynolds.device import Device
from squeezefilm.reynolds.grid import Grid
from squeezefilm.reynolds.needs import needs_of
from squeezefilm.reynolds.periodic.launch import Batch, launch
from squeezefilm.reynolds.periodic.refinement import START_TOLERANCE
from squeezefilm.reynolds.periodic.resolution import start_grid
from squeezefilm.reynolds.problems import problems_on

# What two judging grids may differ by, and what their iteration may leave, of the tolerance judged.
TIGHTER = 0.01
ITERATION = 0.001
LEAST_ITERATION = 1e-13
# The finer grid's error is taken as so many times their difference: kinks converge slowly.
FACTOR = 2.0
FIRST, NEXT = 1.35, 1.25
MOST_UNKNOWNS = 1_000_000
# Unknowns of the grids of one launch.
LAUNCH = 3_000_000


@dataclass(frozen=True)
class Verdict:
    """A force from the judge's finest grid and its own error; ``nan`` if unknown."""

    force_n: float
    error_n: float

    def is_good_to(self, relative: float) -> bool:
        return bool(self.error_n <= relative * abs(self.force_n))


@dataclass
class _Case:
    """A film that waits for its verdict."""

    index: int
    scene: Scene
    tolerance: float
    judged: Grid
    grid: Grid
    before_n: float = np.nan
    verdict: Verdict = Verdict(np.nan, np.nan)


def judge(
    scenes: Sequence[Scene],
    solutions: Sequence[Solution],
    tolerances: Sequence[float],
    *,
    device: Device,
    most_unknowns: int = MOST_UNKNOWNS,
) -> list[Verdict]:
    """A verdict on each film; ``nan`` for one that was refused, or that no grid judges.

    most_unknowns: of a judging grid; no finer one is tried.
    """
    verdicts = [Verdict(np.nan, np.nan)] * len(scenes)
    waiting = []
    for index, (scene, solution) in enumerate(zip(scenes, solutions, strict=True)):
        if solution.status == "ok":
            judged = _grid_of(scene, solution)
            case = _Case(
                index, scene, tolerances[index], judged, finer_apart(judged, judged, FIRST)
            )
            waiting.append(case)
    waiting = [case for case in waiting if case.grid.count <= most_unknowns]
    while waiting:
        waiting.sort(key=lambda case: (len(needs_of(case.scene).terms), -case.grid.count))
        unfinished = []
        for some in _launches(waiting):
            for case, mean in zip(some, _means(some, device=device), strict=True):
                if not _settled(case, mean * case.scene.force_scale_n):
                    unfinished.append(case)
                verdicts[case.index] = case.verdict
        waiting = [case for case in unfinished if case.grid.count <= most_unknowns]
    return verdicts


def _settled(case: _Case, force_n: float) -> bool:
    """Whether a case is finished with another grid's force; else it has a finer grid to go to."""
    error_n = FACTOR * abs(force_n - case.before_n)
    case.verdict = Verdict(force_n, error_n)
    done = case.verdict.is_good_to(TIGHTER * case.tolerance)
    case.before_n, case.grid = force_n, finer_apart(case.grid, case.judged, NEXT)
    return done


def _means(cases: Sequence[_Case], *, device: Device) -> list[float]:
    batches = []
    for case in cases:
        tolerance = max(ITERATION * case.tolerance, LEAST_ITERATION)
        start = start_grid(case.grid)
        shares = {start: START_TOLERANCE} if start else {}
        shares[case.grid] = tolerance
        batches.append(Batch(list(shares), problems_on([case.scene], shares)))
    found = [stages[-1] for stages in launch(batches, device=device).states()]
    return [
        float(states.mean[0]) if states.status[0] == 0 and states.lowest[0] > 0 else np.nan
        for states in found
    ]


def _launches(cases: Sequence[_Case]) -> list[list[_Case]]:
    """Films of like terms together, no more than there is memory for."""
    launches: list[list[_Case]] = []
    filled, terms = 0, None
    for case in cases:
        its_terms = needs_of(case.scene).terms
        if its_terms != terms or filled + case.grid.count > LAUNCH:
            launches.append([])
            filled, terms = 0, its_terms
        launches[-1].append(case)
        filled += case.grid.count
    return launches


def _grid_of(scene: Scene, solution: Solution) -> Grid:
    """The grid that a force is from; that of a limit has no instants."""
    needs = needs_of(scene)
    return Grid(
        nx=max(4, solution.nx // (2 if needs.fold_x else 1)),
        ny=max(4, solution.ny // (2 if needs.fold_y else 1)),
        nt=max(8, solution.nt),
        fold_x=needs.fold_x,
        fold_y=needs.fold_y,
    )


def finer_apart(grid: Grid, judged: Grid, ratio: float) -> Grid:
    """So many times as fine, with no node in common with the judged grid."""
    return Grid(
        nx=_apart(ratio * grid.nx, judged.nx, fold=grid.fold_x),
        ny=_apart(ratio * grid.ny, judged.ny, fold=grid.fold_y),
        nt=4 * round(ratio * grid.nt / 4 + 0.5),
        fold_x=grid.fold_x,
        fold_y=grid.fold_y,
    )


def _apart(least: float, judged: int, *, fold: bool) -> int:
    """A number of unknowns, of fours, whose nodes cos πk/N are none of the judged axis'."""
    sides = 2 if fold else 1
    points = 4 * round(least / 4 + 0.5)
    while gcd(sides * points + 1, sides * judged + 1) > 1:
        points += 4
    return points
