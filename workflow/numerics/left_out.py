"""What leaving things out saves, and that it costs no accuracy: each put back in turn.

Random scenes over the study's four factors are solved as they need, and again with one thing put
back: the mirror halves, a term that is zero, more modes than wanted, time where a limit would do.
A term is put back by a coefficient so small that it changes nothing but has to be computed.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from statistics import median
from typing import Any

import numpy as np

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

Solve = Callable[..., list[Solution]]
NEGLIGIBLE = 1e-14
SLIDING = {"speed_x_m_per_s": NEGLIGIBLE}
RAREFIED = {"rarefaction": "fukui-kaneko", "mean_free_path_m": NEGLIGIBLE * 1e-6}
HEATED = {"polytropic_exponent": 1 + NEGLIGIBLE}
HEAVY = {"inertia": "included", "density_kg_per_m3": NEGLIGIBLE}
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
    variants = []
    for tolerance in tolerances:
        ways: dict[str, Solve] = {"": solve, "time (always periodic)": _always_periodic}
        ways |= {
            "mirror halves": partial(_changed_needs, fold_x=False, fold_y=False),
            "bearing term": _with(finger=SLIDING),
            "rarefaction": _with(gas=RAREFIED),
            "heating": _with(gas=HEATED),
            "inertia": _with(gas=HEAVY),
            "finest modes for all": _one_grid,
            "everything": _with(finger=SLIDING, gas=RAREFIED | HEATED, solve=_one_grid),
        }
        base = 0.0
        for put_back, way in ways.items():
            solutions, cpu, wall = _timed(
                partial(way, scenes, tolerance=tolerance, device=device), repeats=repeats
            )
            base = base or cpu
            variants.append(
                _variant(
                    put_back, solutions, exact, tolerance=tolerance, cpu=cpu, wall=wall, base=base
                )
            )
    return variants


def _variant(
    put_back: str,
    solutions: Sequence[Solution],
    exact: np.ndarray,
    *,
    tolerance: float,
    cpu: float,
    wall: float,
    base: float,
) -> Variant:
    force = np.array([solution.force_n for solution in solutions])
    estimate = np.array([solution.force_error_n for solution in solutions])
    error = np.abs(force - exact)
    names = [solution.method for solution in solutions]
    return Variant(
        put_back=put_back,
        tolerance=tolerance,
        methods="; ".join(f"{name} {names.count(name)}" for name in dict.fromkeys(names)),
        scenes=len(solutions),
        cpu_seconds=cpu,
        wall_seconds=wall,
        cpu_ratio=cpu / base,
        worst_error=float(np.max(error / np.abs(exact))),
        covered=float(np.mean(error <= estimate)),
    )


def _timed(
    run: Callable[[], list[Solution]], *, repeats: int
) -> tuple[list[Solution], float, float]:
    """The solutions, and median processor and wall seconds after a call that warms the kernels."""
    solutions = run()
    cpu, wall = [], []
    for _ in range(repeats):
        start_cpu, start_wall = time.process_time(), time.perf_counter()
        solutions = run()
        cpu.append(time.process_time() - start_cpu)
        wall.append(time.perf_counter() - start_wall)
    return solutions, median(cpu), median(wall)


def _always_periodic(
    scenes: Sequence[Scene], *, tolerance: float, device: Device
) -> list[Solution]:
    return solve(scenes, tolerance=tolerance, method="periodic", device=device)


def _changed_needs(
    scenes: Sequence[Scene], *, tolerance: float, device: Device, **needs: Any
) -> list[Solution]:
    changed = [replace(needs_of(scene), **needs) for scene in scenes]
    return solve_periodic(scenes, changed, tolerance=tolerance, device=device)


def _with(
    *,
    gas: dict[str, Any] | None = None,
    finger: dict[str, Any] | None = None,
    solve: Solve = _always_periodic,
) -> Solve:
    """The way to solve scenes with another gas or finger."""

    def changed(scenes: Sequence[Scene], *, tolerance: float, device: Device) -> list[Solution]:
        others = [
            replace(
                scene,
                gas=replace(scene.gas, **(gas or {})),
                finger=replace(scene.finger, **(finger or {})),
            )
            for scene in scenes
        ]
        return solve(others, tolerance=tolerance, device=device)

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
