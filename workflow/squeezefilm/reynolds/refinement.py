"""The periodic method: grids are refined until each scene's force holds its tolerance."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from squeezefilm.reynolds.device import Device
from squeezefilm.reynolds.needs import Needs
from squeezefilm.reynolds.periodic import STATUS, Grid, Problems, States, solve_batch
from squeezefilm.reynolds.resolution import (
    MOMENT_FACTOR,
    MOMENTS,
    ROUND_OFF,
    finer_grid,
    first_grid,
)
from squeezefilm.reynolds.solution import Solution, left_out_text
from squeezefilm.scene import FUKUI_KANEKO_LEAST_D, Scene

# Share of the tolerance that Newton's iteration may leave; the grids get the rest.
ITERATION_SHARE = 0.03
BATCH = 256


@dataclass
class _Progress:
    """A scene on its way through the grids."""

    index: int
    scene: Scene
    needs: Needs
    grid: Grid
    grid_before: Grid | None = None
    overpressure: np.ndarray | None = None
    mean_before: np.ndarray | None = None
    newton_steps: int = 0
    krylov_iterations: int = 0
    work: float = 0.0


def solve_periodic(
    scenes: Sequence[Scene],
    needs: Sequence[Needs],
    *,
    tolerance: float,
    device: Device,
    report: Callable[[int], object] = lambda solved: None,
) -> list[Solution]:
    """The periodic state of each scene; the arguments are those of ``solver.solve``."""
    solutions: dict[int, Solution] = {}
    for start in range(0, len(scenes), BATCH):
        waiting = [
            _Progress(
                index=index,
                scene=scenes[index],
                needs=needs[index],
                grid=grid_for(scenes[index], needs[index], tolerance=tolerance),
            )
            for index in range(start, min(start + BATCH, len(scenes)))
        ]
        while waiting:
            unfinished = []
            for group in _grouped(waiting):
                states = _solve_group(group, tolerance=tolerance, device=device)
                for position, progress in enumerate(group):
                    solution = _judge(progress, states, position, tolerance=tolerance)
                    if solution is None:
                        unfinished.append(progress)
                    else:
                        solutions[progress.index] = solution
                        report(1)
            waiting = unfinished
    return [solutions[index] for index in range(len(scenes))]


def grid_for(scene: Scene, needs: Needs, *, tolerance: float) -> Grid:
    """The first grid of a scene's sequence."""
    return first_grid(
        epsilon=scene.epsilon,
        sigma=scene.sigma,
        aspect=scene.aspect,
        needs=needs,
        tolerance=tolerance,
    )


def _grouped(waiting: Iterable[_Progress]) -> Iterable[list[_Progress]]:
    """Scenes that can be solved in one launch: same grid, finger shape and terms."""
    groups: dict[object, list[_Progress]] = defaultdict(list)
    for progress in waiting:
        needs = progress.needs
        terms = (needs.bearing, needs.flow_terms, needs.polytropic)
        groups[progress.grid, progress.scene.aspect, terms].append(progress)
    return groups.values()


def _solve_group(group: list[_Progress], *, tolerance: float, device: Device) -> States:
    grid = group[0].grid
    scenes = [progress.scene for progress in group]
    guess = None
    if any(progress.grid_before is not None for progress in group):
        guess = np.stack([_first_guess(progress) for progress in group])
    problems = problems_of(scenes, grid, tolerance=ITERATION_SHARE * tolerance)
    return solve_batch(problems=problems, grid=grid, device=device, guess=guess)


def problems_of(scenes: Sequence[Scene], grid: Grid, *, tolerance: float) -> Problems:
    """Scenes of one finger shape and like terms, in the dimensionless form of a batch."""
    return Problems(
        epsilon=np.array([scene.epsilon for scene in scenes]),
        sigma=np.array([scene.sigma for scene in scenes]),
        bearing=np.array([scene.bearing_number for scene in scenes]),
        inverse_exponent=np.array([1 / scene.gas.polytropic_exponent for scene in scenes]),
        flow=np.array([scene.flow_coefficients for scene in scenes]),
        aspect=scenes[0].aspect,
        amplitude=_amplitudes(scenes, grid),
        tolerance=tolerance,
    )


def _amplitudes(scenes: Sequence[Scene], grid: Grid) -> np.ndarray:
    """The profile under each finger on all nodes; scenes at one position share the evaluation."""
    x, y = np.meshgrid(grid.x.all_nodes, grid.y.all_nodes, indexing="ij")
    known: dict[object, np.ndarray] = {}
    for scene in scenes:
        key = (scene.x_m, scene.y_m)
        if key not in known:
            known[key] = scene.amplitude(x, y)
    return np.stack([known[scene.x_m, scene.y_m] for scene in scenes])


def _first_guess(progress: _Progress) -> np.ndarray:
    """The state on the coarser grid, interpolated; the film at rest on the first grid."""
    if progress.overpressure is None or progress.grid_before is None:
        return np.zeros(progress.grid.shape)
    coarse, fine = progress.grid_before, progress.grid
    along_x = coarse.x.interpolation_to(fine.x) @ progress.overpressure.reshape(coarse.nx, -1)
    along_y = coarse.y.interpolation_to(fine.y) @ along_x.reshape(fine.nx, coarse.ny, coarse.nt)
    return along_y @ coarse.t.interpolation_to(fine.t).T


def _judge(
    progress: _Progress, states: States, position: int, *, tolerance: float
) -> Solution | None:
    """The scene's solution if its error is known to be small enough, else None and a finer grid."""
    scene, grid = progress.scene, progress.grid
    mean = float(states.mean[position])
    overpressure = states.overpressure[position]
    residual = float(states.residual[position])
    krylov = int(states.krylov_iterations[position])
    newton = int(states.newton_steps[position])
    progress.newton_steps += newton
    progress.krylov_iterations += krylov
    progress.work += (krylov + newton) * iteration_flops(grid)

    def finished(*, status: str, force: float, error: float) -> Solution:
        return Solution(
            force_n=force * scene.force_scale_n,
            force_error_n=error * scene.force_scale_n,
            status=status,
            method="periodic",
            left_out=left_out_text(progress.needs.halves_left_out + progress.needs.terms_left_out),
            nx=grid.x.full_points,
            ny=grid.y.full_points,
            nt=grid.nt,
            newton_steps=progress.newton_steps,
            krylov_iterations=progress.krylov_iterations,
            residual=residual,
            work=progress.work,
        )

    if states.status[position] != 0:
        reason = STATUS[states.status[position]]
        return finished(status=f"{reason} ({_size(grid)})", force=np.nan, error=np.nan)
    thinnest = scene.inverse_knudsen * float(states.thinnest[position])
    if scene.gas.rarefaction == "fukui-kaneko" and thinnest < FUKUI_KANEKO_LEAST_D:
        status = f"gas too rarefied: D falls to {thinnest:.2g}, below {FUKUI_KANEKO_LEAST_D:g}"
        return finished(status=status, force=np.nan, error=np.nan)
    mean_pressure = overpressure.mean(axis=-1)
    error = np.inf
    if progress.grid_before is not None and progress.mean_before is not None:
        floor = ROUND_OFF * float(states.largest[position])
        change = _change(progress.mean_before, progress.grid_before, mean_pressure, grid)
        error = MOMENT_FACTOR * change + residual / (1 - scene.epsilon) + floor
        if error <= tolerance * abs(mean) + floor:
            return finished(status="ok", force=mean, error=error)
    finer = finer_grid(grid)
    if finer is None:
        status = f"tolerance not reached on the finest grid ({_size(grid)}): error {error:.1e}"
        return finished(status=status, force=np.nan, error=np.nan)
    progress.overpressure, progress.mean_before = overpressure, mean_pressure
    progress.grid_before, progress.grid = grid, finer
    return None


def iteration_flops(grid: Grid) -> float:
    """Floating-point operations of one Krylov iteration's products."""
    nx, ny, nt = grid.shape
    return 2.0 * nx * ny * nt * (3 * nx + 3 * ny + 2 * nt)


def _change(before: np.ndarray, coarse: Grid, after: np.ndarray, fine: Grid) -> float:
    """Largest change, from grid to grid, of the mean pressure's lowest cosine moments.

    The first of them is the force.
    """
    carried = coarse.x.interpolation_to(fine.x) @ before @ coarse.y.interpolation_to(fine.y).T
    moments = fine.x.moments(MOMENTS) @ (after - carried) @ fine.y.moments(MOMENTS).T
    return float(np.abs(moments).max())


def _size(grid: Grid) -> str:
    return f"{grid.x.full_points} × {grid.y.full_points} × {grid.nt} points"
