"""The periodic method: grids are refined until each scene's force holds its tolerance."""

from __future__ import annotations

from collections import defaultdict, deque
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from squeezefilm.reynolds.device import Device
from squeezefilm.reynolds.needs import Needs
from squeezefilm.reynolds.periodic import STATUS, Batch, Grid, Launch, Problems, States, launch
from squeezefilm.reynolds.resolution import (
    MOMENT_FACTOR,
    MOMENTS,
    ROUND_OFF,
    finer_grid,
    first_grid,
    start_grid,
)
from squeezefilm.reynolds.solution import Solution, left_out_text
from squeezefilm.scene import FUKUI_KANEKO_LEAST_D, Scene

# Share of the tolerance that Newton's iteration may leave; the grids get the rest.
ITERATION_SHARE = 0.2
# Relative error of the force that the iteration may leave on a grid that only starts the next.
START_TOLERANCE = 1e-3
# Launches under way at a time: the host judges one while the device is at the other.
IN_FLIGHT = 2
# Scenes begun together.
LEAST_BATCH, MOST_BATCH = 16, 128
# States of one launch; more go into several.
LAUNCH_BYTES = 256 * 2**20


@dataclass
class _Progress:
    """A scene on its way through the grids.

    first: the grid to go to from a start grid; None once it has been reached.
    """

    index: int
    scene: Scene
    needs: Needs
    grid: Grid
    first: Grid | None = None
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
    size = min(max(-(-len(scenes) // IN_FLIGHT), LEAST_BATCH), MOST_BATCH)
    starts = iter(range(0, len(scenes), size))
    flying: deque[tuple[list[list[_Progress]], Launch]] = deque()

    def fly(waiting: Iterable[_Progress]) -> None:
        for groups in _launches(waiting):
            batches = [_batch_of(group, tolerance=tolerance) for group in groups]
            flying.append((groups, launch(batches, device=device)))

    while True:
        while len(flying) < IN_FLIGHT and (start := next(starts, None)) is not None:
            stop = min(start + size, len(scenes))
            fly(_begun(i, scenes[i], needs[i], tolerance=tolerance) for i in range(start, stop))
        if not flying:
            break
        groups, landing = flying.popleft()
        unfinished = []
        for group, states in zip(groups, landing.states(), strict=True):
            judged = _judge(group, states, tolerance=tolerance)
            for progress, solution in zip(group, judged, strict=True):
                if solution is None:
                    unfinished.append(progress)
                else:
                    solutions[progress.index] = solution
                    report(1)
        fly(unfinished)
    return [solutions[index] for index in range(len(scenes))]


def _begun(index: int, scene: Scene, needs: Needs, *, tolerance: float) -> _Progress:
    first = grid_for(scene, needs, tolerance=tolerance)
    start = start_grid(first)
    if start is None:
        return _Progress(index=index, scene=scene, needs=needs, grid=first)
    return _Progress(index=index, scene=scene, needs=needs, grid=start, first=first)


def grid_for(scene: Scene, needs: Needs, *, tolerance: float) -> Grid:
    """The first grid of a scene's sequence."""
    return first_grid(
        epsilon=scene.epsilon,
        sigma=scene.sigma,
        aspect=scene.aspect,
        needs=needs,
        tolerance=tolerance,
    )


def _launches(waiting: Iterable[_Progress]) -> Iterable[list[list[_Progress]]]:
    """Scenes in groups of one grid and finger shape; groups of like terms are launched together.

    The dearest grids come first, so that no long solve is left over at the end.
    """
    launches: list[dict[object, list[_Progress]]] = []
    current: dict[object, dict[object, list[_Progress]]] = {}
    filled: dict[object, int] = {}
    for progress in sorted(waiting, key=lambda progress: -iteration_flops(progress.grid)):
        needs = progress.needs
        terms = (needs.bearing, needs.flow_terms, needs.polytropic)
        size = 8 * progress.grid.count
        if terms not in current or filled[terms] + size > LAUNCH_BYTES:
            current[terms], filled[terms] = defaultdict(list), 0
            launches.append(current[terms])
        filled[terms] += size
        starts = progress.first is not None
        grids = (progress.grid, progress.grid_before, starts, progress.scene.aspect)
        current[terms][grids].append(progress)
    return [list(groups.values()) for groups in launches]


def _batch_of(group: Sequence[_Progress], *, tolerance: float) -> Batch:
    grid = group[0].grid
    left = ITERATION_SHARE * tolerance
    if group[0].first is not None:
        left = max(left, START_TOLERANCE)
    problems = problems_of([progress.scene for progress in group], grid, tolerance=left)
    return Batch(problems=problems, grid=grid, guess=_first_guess(group))


def problems_of(scenes: Sequence[Scene], grid: Grid, *, tolerance: float) -> Problems:
    """Scenes of one finger shape and like terms, in the dimensionless form of a batch."""
    amplitude, place = _amplitudes(scenes, grid)
    return Problems(
        epsilon=np.array([scene.epsilon for scene in scenes]),
        sigma=np.array([scene.sigma for scene in scenes]),
        bearing=np.array([scene.bearing_number for scene in scenes]),
        inverse_exponent=np.array([1 / scene.gas.polytropic_exponent for scene in scenes]),
        flow=np.array([scene.flow_coefficients for scene in scenes]),
        aspect=scenes[0].aspect,
        amplitude=amplitude,
        place=place,
        tolerance=tolerance,
    )


def _amplitudes(scenes: Sequence[Scene], grid: Grid) -> tuple[np.ndarray, np.ndarray]:
    """The profile on all nodes at each place of the finger, and each scene's place."""
    x, y = np.meshgrid(grid.x.all_nodes, grid.y.all_nodes, indexing="ij")
    profiles: list[np.ndarray] = []
    known: dict[object, int] = {}
    for scene in scenes:
        if scene.place not in known:
            known[scene.place] = len(profiles)
            profiles.append(scene.amplitude(x, y))
    return np.stack(profiles), np.array([known[scene.place] for scene in scenes])


def _first_guess(group: Sequence[_Progress]) -> np.ndarray | None:
    """The states on the coarser grid, interpolated; the film at rest on the first grid."""
    coarse, fine = group[0].grid_before, group[0].grid
    if coarse is None:
        return None
    states = np.stack([p.overpressure for p in group if p.overpressure is not None])
    along_t = states.reshape(-1, coarse.nt) @ coarse.t.interpolation_to(fine.t).T
    along_x = coarse.x.interpolation_to(fine.x) @ along_t.reshape(len(group), coarse.nx, -1)
    panels = along_x.reshape(-1, coarse.ny, fine.nt)
    return (coarse.y.interpolation_to(fine.y) @ panels).reshape(len(group), *fine.shape)


def _judge(
    group: Sequence[_Progress], states: States, *, tolerance: float
) -> list[Solution | None]:
    """Each scene's solution if its error is known to be small enough, else None: a finer grid."""
    coarse, grid = group[0].grid_before, group[0].grid
    mean_pressure = states.overpressure @ np.full(grid.nt, 1 / grid.nt)
    floor = ROUND_OFF * states.largest
    error = np.full(len(group), np.inf)
    if coarse is not None and grid.finer_than(coarse):
        epsilon = np.array([progress.scene.epsilon for progress in group])
        before = np.stack([p.mean_before for p in group if p.mean_before is not None])
        change = _change(before, coarse, mean_pressure, grid)
        error = MOMENT_FACTOR * change + states.residual / (1 - epsilon) + floor
    enough = error <= tolerance * np.abs(states.mean) + floor
    return [
        _judge_scene(
            progress,
            states,
            position,
            error=float(error[position]),
            enough=bool(enough[position]),
            mean_pressure=mean_pressure[position],
        )
        for position, progress in enumerate(group)
    ]


def _judge_scene(
    progress: _Progress,
    states: States,
    position: int,
    *,
    error: float,
    enough: bool,
    mean_pressure: np.ndarray,
) -> Solution | None:
    scene, grid = progress.scene, progress.grid
    krylov = int(states.krylov_iterations[position])
    newton = int(states.newton_steps[position])
    progress.newton_steps += newton
    progress.krylov_iterations += krylov
    progress.work += (krylov + newton) * iteration_flops(grid)

    def finished(*, status: str, force: float = np.nan, error: float = np.nan) -> Solution:
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
            residual=float(states.residual[position]),
            work=progress.work,
        )

    if states.status[position] != 0 and progress.first is not None:
        progress.grid, progress.first = progress.first, None
        return None
    if states.status[position] != 0:
        return finished(status=f"{STATUS[states.status[position]]} ({_size(grid)})")
    thinnest = scene.inverse_knudsen * float(states.thinnest[position])
    if scene.gas.rarefaction == "fukui-kaneko" and thinnest < FUKUI_KANEKO_LEAST_D:
        return finished(
            status=f"gas too rarefied: D falls to {thinnest:.2g}, below {FUKUI_KANEKO_LEAST_D:g}"
        )
    if enough:
        return finished(status="ok", force=float(states.mean[position]), error=error)
    finer = progress.first or finer_grid(grid)
    if finer is None:
        return finished(
            status=f"tolerance not reached on the finest grid ({_size(grid)}): error {error:.1e}"
        )
    progress.overpressure, progress.mean_before = states.overpressure[position], mean_pressure
    progress.grid_before, progress.grid, progress.first = grid, finer, None
    return None


def iteration_flops(grid: Grid) -> float:
    """Floating-point operations of one Krylov iteration's products."""
    nx, ny, nt = grid.shape
    return 2.0 * nx * ny * nt * (3 * nx + 3 * ny + 2 * nt)


def _change(before: np.ndarray, coarse: Grid, after: np.ndarray, fine: Grid) -> np.ndarray:
    """Largest change, from grid to grid, of the mean pressure's lowest cosine moments, per scene.

    before, after: mean overpressure, shape (scenes, nx, ny) of the coarse and the fine grid. The
    first of the moments is the force.
    """
    carried = coarse.x.interpolation_to(fine.x) @ before @ coarse.y.interpolation_to(fine.y).T
    moments = fine.x.moments(MOMENTS) @ (after - carried) @ fine.y.moments(MOMENTS).T
    return np.abs(moments).max(axis=(1, 2))


def _size(grid: Grid) -> str:
    return f"{grid.x.full_points} × {grid.y.full_points} × {grid.nt} points"
