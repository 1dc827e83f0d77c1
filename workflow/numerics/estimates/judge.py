"""The force of a film, far better than a solve has it, on grids that share no node with its.

How the solver chooses its grids decides where the judge begins, and nothing of how it estimates its
errors is used: the judge goes from grid to grid, each about a fifth finer in everything, until the
last changes say that the error is a hundredth of the tolerance.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from numerics.estimates.stretched import StretchedGrid, coarser_inside, finer_at_rim
from squeezefilm.film.scene import Scene
from squeezefilm.reynolds.device import Device
from squeezefilm.reynolds.grid import Grid
from squeezefilm.reynolds.needs import Needs, needs_of
from squeezefilm.reynolds.periodic.gap_numbers import GapNumbers, gap_numbers
from squeezefilm.reynolds.periodic.launch import Batch, launch
from squeezefilm.reynolds.periodic.resolution import first_grid
from squeezefilm.reynolds.periodic.sizes import iteration_flops
from squeezefilm.reynolds.periodic.states import States
from squeezefilm.reynolds.problems import problems_on

# What the judge may be off by, and what its iteration may leave, of the tolerance judged.
TIGHTER = 0.01
ITERATION = 1e-4
LEAST_ITERATION = 1e-13
# The first grid, as a share of the guess for TIGHTER times the tolerance, and the next.
FIRST, NEXT = 0.7, 1.2
LEAST = 8
# Lowest cosine moments of the mean pressure along each side: they do not all agree by chance.
MOMENTS = 3
# Of changes falling by q from grid to grid q/(1 − q) of the last one is left; so many times that
# is taken, and no less than shares of the last two changes.
FACTOR = 3.0
LAST_SHARE, SHARE_BEFORE = 0.5, 0.02
# How the nodes may crowd at the rim.
STRETCHES = (1.0, 1.5, 2.0, 2.5)
WASTE = 1.3
# Floating-point operations of one grid's iteration, beyond which none finer is tried: some
# minute of a core.
MOST_WORK = 2e12
MOST_UNKNOWNS = 4_000_000


@dataclass(frozen=True)
class Verdict:
    """A force from the judge's finest grid and its own error; ``nan`` if unknown.

    Attributes:
        grid: that grid; None if there is none.
        work: floating-point operations of all of them, roughly.
    """

    force_n: float
    error_n: float
    grid: Grid | None = None
    work: float = 0.0

    def is_good_to(self, relative: float) -> bool:
        return bool(self.error_n <= relative * abs(self.force_n))

    @property
    def size(self) -> str:
        if self.grid is None:
            return ""
        x, y = self.grid.x.full_points, self.grid.y.full_points
        return f"{x} × {y} × {self.grid.nt}"


def judge(
    scene: Scene,
    *,
    tolerance: float,
    device: Device,
    most_work: float = MOST_WORK,
) -> Verdict:
    """The verdict on a film; not good to TIGHTER times the tolerance where no grid judges it.

    most_work: floating-point operations on one grid; no finer one is tried.
    """
    needs = needs_of(scene)
    grid = first_of(scene, needs, tolerance=tolerance)
    iteration = max(ITERATION * tolerance, LEAST_ITERATION)
    verdict = Verdict(np.nan, np.nan)
    # The guess of how many iterations the first grid takes.
    krylov = 20
    before: tuple[Grid, States] | None = None
    moments: list[np.ndarray] = []
    while grid.count <= MOST_UNKNOWNS and krylov * iteration_flops(grid) <= most_work:
        states = _state(scene, grid, iteration, device=device, before=before)
        krylov = int(states.krylov_iterations[0])
        if states.status[0] == 0 and states.lowest[0] > 0:
            before = (grid, states)
            moments.append(_moments(grid, states))
        else:
            before, moments = None, []
        left = float(states.residual[0]) / scene.narrowest
        verdict = Verdict(
            force_n=float(states.mean[0]) * scene.force_scale_n if moments else np.nan,
            error_n=(_error(moments) + left) * scene.force_scale_n,
            grid=grid,
            work=verdict.work + krylov * iteration_flops(grid),
        )
        if verdict.is_good_to(TIGHTER * tolerance):
            break
        grid = _finer(grid)
    return verdict


def first_of(scene: Scene, needs: Needs, *, tolerance: float) -> StretchedGrid:
    """The first grid, with the stretch along each side that wants few nodes."""
    numbers = gap_numbers(scene)

    def guess(sigma: float, bearing: float) -> Grid:
        gap: GapNumbers = {**numbers, "sigma": sigma}
        return first_grid(
            **gap,
            bearing=bearing,
            aspect=scene.aspect,
            needs=needs,
            tolerance=TIGHTER * tolerance,
            share=1.0,
        )

    inside = guess(1.0, 0.0)
    layers = [
        guess(numbers["sigma"] / closer**2, abs(scene.bearing_number) / closer)
        for closer in map(finer_at_rim, STRETCHES)
    ]
    nx, stretch_x = _fewest(inside.nx, [layer.nx for layer in layers])
    ny, stretch_y = _fewest(inside.ny, [layer.ny for layer in layers])
    return StretchedGrid(
        nx=_fours(FIRST * nx),
        ny=_fours(FIRST * ny),
        nt=_fours(FIRST * inside.nt),
        fold_x=needs.fold_x,
        fold_y=needs.fold_y,
        stretch_x=stretch_x,
        stretch_y=stretch_y,
    )


def _fewest(inside: int, layers: Sequence[int]) -> tuple[float, float]:
    """About the fewest points, of those for inside and rim, with the most stretch: for corners."""
    points = [
        max(layer, coarser_inside(stretch) * inside)
        for layer, stretch in zip(layers, STRETCHES, strict=True)
    ]
    return max(
        (stretch, count)
        for stretch, count in zip(STRETCHES, points, strict=True)
        if count <= WASTE * min(points)
    )[::-1]


def _fours(points: float) -> int:
    return max(LEAST, 4 * round(points / 4))


def _finer(grid: StretchedGrid) -> StretchedGrid:
    nx, ny, nt = (max(points + 4, 4 * round(NEXT * points / 4)) for points in grid.shape)
    return replace(grid, nx=nx, ny=ny, nt=nt)


def _state(
    scene: Scene,
    grid: Grid,
    tolerance: float,
    *,
    device: Device,
    before: tuple[Grid, States] | None,
) -> States:
    """The state on a grid, from that on a coarser one if there is one."""
    grids = [before[0], grid] if before else [grid]
    problems = problems_on([scene], dict.fromkeys(grids, tolerance))
    batch = Batch(grids, problems, before[1].unknowns if before else None)
    return launch([batch], device=device).states()[0][-1]


def _moments(grid: Grid, states: States) -> np.ndarray:
    """Of the mean pressure, that of the force first."""
    (mean,) = states.mean_in_time
    return np.asarray(grid.x.moments(MOMENTS) @ mean @ grid.y.moments(MOMENTS).T)


def _error(moments: Sequence[np.ndarray]) -> float:
    """Of the last of some grids; infinite with fewer than three, or without convergence."""
    if len(moments) < 3:
        return np.inf
    first, last = (
        float(np.abs(after - before).max())
        for before, after in zip(moments[-3:], moments[-2:], strict=False)
    )
    if not last < first:
        return np.inf if last > 0 else 0.0
    fall = last / first
    return max(FACTOR * fall / (1 - fall) * last, LAST_SHARE * last, SHARE_BEFORE * first)
