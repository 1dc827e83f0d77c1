"""What leaving things out saves, and that it costs no accuracy: each put back in turn.

Random scenes over the study's four factors are solved as they need, and again with one thing put
back: the mirror halves, a term that is zero, more modes than wanted, time where a limit would do.
A term is put back, as it says itself, so little that it changes nothing but has to be computed.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from numerics import timing
from numerics.timing import Timed
from squeezefilm.film.scene import Scene
from squeezefilm.reynolds import Solution, solve
from squeezefilm.reynolds.device import Device
from squeezefilm.reynolds.error_estimate import ITERATION_SHARE
from squeezefilm.reynolds.grid import Grid
from squeezefilm.reynolds.needs import needs_of
from squeezefilm.reynolds.periodic.launch import solve_batch
from squeezefilm.reynolds.periodic.refinement import solve_periodic
from squeezefilm.reynolds.problems import problems_of
from squeezefilm.reynolds.solution import solution_of
from squeezefilm.reynolds.terms import TERMS

Solve = Callable[..., list[Solution]]
# A grid that is fine enough for every scene of the paper's space, and the one it is checked with.
ONE_FOR_ALL = (
    Grid(nx=28, ny=28, nt=16, fold_x=False, fold_y=False),
    Grid(nx=32, ny=32, nt=20, fold_x=False, fold_y=False),
)


@dataclass(frozen=True)
class Variant:
    """The sample solved in one way.

    Attributes:
        put_back: what is computed although it is not needed; empty for the scenes as they need.
        tolerance: relative error asked for.
        methods: the methods that were taken.
        cpu_seconds: processor time of all threads, median of repeats.
        wall_seconds: time by the clock, median of repeats.
        cpu_ratio: processor time over that of the scenes as they need.
        worst_error: largest relative error against the reference.
        covered: share of scenes whose true error is within the estimate.
    """

    put_back: str
    tolerance: float
    methods: str
    scenes: int
    cpu_seconds: float
    wall_seconds: float
    cpu_ratio: float
    worst_error: float
    covered: float


def measure(
    scenes: Sequence[Scene],
    *,
    tolerances: Sequence[float],
    reference: float,
    repeats: int,
    device: Device,
) -> list[Variant]:
    """The table: for each tolerance the sample as it needs, then with each thing put back.

    Args:
        reference: tolerance of the periodic solve that all are judged by.
    """
    judges = _always_periodic(scenes, tolerance=reference, device=device)
    exact = np.array([each.force_n for each in judges])
    terms = [kind for kind in TERMS if kind.put_back(scenes[0]) != scenes[0]]
    variants = []
    for tolerance in tolerances:
        ways: dict[str, Solve] = {"": solve, "time (always periodic)": _always_periodic}
        ways |= {
            "mirror halves": partial(_changed_needs, fold_x=False, fold_y=False),
            **{kind.ABSENT.what: _with(kind.put_back) for kind in terms if kind.ABSENT},
            "finest modes for all": _one_grid,
            "everything": _with(*(kind.put_back for kind in terms), solve=_one_grid),
        }
        base = 0.0
        for put_back, way in ways.items():
            run = partial(way, scenes, tolerance=tolerance, device=device)
            timed = timing.measure(run, repeats=repeats, long_seconds=math.inf)
            base = base or timed.cpu_seconds
            variants.append(_variant(put_back, timed, exact, tolerance=tolerance, base=base))
    return variants


def _variant(
    put_back: str, timed: Timed[list[Solution]], exact: np.ndarray, *, tolerance: float, base: float
) -> Variant:
    solutions = timed.result
    force = np.array([solution.force_n for solution in solutions])
    estimate = np.array([solution.force_error_n for solution in solutions])
    error = np.abs(force - exact)
    names = [solution.method for solution in solutions]
    return Variant(
        put_back=put_back,
        tolerance=tolerance,
        methods="; ".join(f"{name} {names.count(name)}" for name in dict.fromkeys(names)),
        scenes=len(solutions),
        cpu_seconds=timed.cpu_seconds,
        wall_seconds=timed.wall_seconds,
        cpu_ratio=timed.cpu_seconds / base,
        worst_error=float(np.max(error / np.abs(exact))),
        covered=float(np.mean(error <= estimate)),
    )


def _always_periodic(
    scenes: Sequence[Scene], *, tolerance: float, device: Device
) -> list[Solution]:
    return solve(scenes, tolerance=tolerance, method="periodic", device=device)


def _changed_needs(
    scenes: Sequence[Scene], *, tolerance: float, device: Device, **needs: Any
) -> list[Solution]:
    changed = [replace(needs_of(scene), **needs) for scene in scenes]
    return solve_periodic(scenes, changed, tolerance=tolerance, device=device)


def _with(*changes: Callable[[Scene], Scene], solve: Solve = _always_periodic) -> Solve:
    """The way to solve scenes that are changed first."""

    def changed(scenes: Sequence[Scene], *, tolerance: float, device: Device) -> list[Solution]:
        for change in changes:
            scenes = [change(scene) for scene in scenes]
        return solve(scenes, tolerance=tolerance, device=device)

    return changed


def _one_grid(scenes: Sequence[Scene], *, tolerance: float, device: Device) -> list[Solution]:
    """Every scene on the same two grids over the whole finger, each solved from rest."""
    results = []
    for grid in ONE_FOR_ALL:
        problems = problems_of(scenes, grid, tolerance=ITERATION_SHARE * tolerance)
        results.append(solve_batch(problems=problems, grid=grid, device=device))
    coarse, fine = results
    grid = ONE_FOR_ALL[-1]
    return [
        solution_of(
            scene,
            mean=float(fine.mean[index]),
            error=2 * abs(float(fine.mean[index] - coarse.mean[index]))
            + float(fine.residual[index]),
            status="ok",
            method="periodic",
            nx=grid.nx,
            ny=grid.ny,
            nt=grid.nt,
            newton_steps=int(fine.newton_steps[index]),
            krylov_iterations=int(fine.krylov_iterations[index]),
            residual=float(fine.residual[index]),
        )
        for index, scene in enumerate(scenes)
    ]
