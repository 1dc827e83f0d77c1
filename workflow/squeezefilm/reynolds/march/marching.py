"""Scenes solved by marching in time until they settle: method ``march``, the yardstick."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from squeezefilm.film.scene import Scene
from squeezefilm.io.solution import Solution
from squeezefilm.reynolds.device import Device
from squeezefilm.reynolds.grid import Grid
from squeezefilm.reynolds.march.schemes import SCHEMES, Choice, choose
from squeezefilm.reynolds.march.settling import (
    NO_FINER_GRID,
    SettledForce,
    method_name,
    steps_on,
    too_many_steps,
    transient_force,
)
from squeezefilm.reynolds.modes.galerkin import wants_modes
from squeezefilm.reynolds.needs import LeftOut, Needs
from squeezefilm.reynolds.periodic.first_grids import grid_for
from squeezefilm.reynolds.periodic.resolution import finer_grid
from squeezefilm.reynolds.problems import problems_of
from squeezefilm.reynolds.solution import solution_of
from squeezefilm.reynolds.terms import first_reason

# Periods on each of two grids; five films of ε 0.05–0.44, σ 5–2331 took 4 to 6 on both, at 1e-3.
PERIODS = 3


def solve_marching(
    scenes: Sequence[Scene],
    needs: Sequence[Needs],
    *,
    tolerance: float,
    device: Device,
    report: Callable[[int], object] = lambda solved: None,
) -> list[Solution]:
    """The settled state of each scene; the arguments are those of ``solver.solve``."""
    solutions: dict[int, Solution] = {}
    groups: dict[object, list[int]] = defaultdict(list)
    for index, (scene, need) in enumerate(zip(scenes, needs, strict=True)):
        grid = grid_for(scene, need, tolerance=tolerance)
        groups[grid.nx, grid.ny, grid.fold_x, grid.fold_y, scene.aspect, need.terms].append(index)
    for group in groups.values():
        members = [scenes[index] for index in group]
        forces = transient_force(
            problems_on=lambda grid, members=members: problems_of(  # type: ignore[misc]
                members, grid, tolerance=tolerance
            ),
            grid=grid_for(members[0], needs[group[0]], tolerance=tolerance),
            tolerance=tolerance,
            device=device,
            needs=[needs[index] for index in group],
        )
        for index, force in zip(group, forces, strict=True):
            solutions[index] = _solution(scenes[index], needs[index], force)
            report(1)
    return [solutions[index] for index in range(len(scenes))]


@dataclass(frozen=True)
class Plan:
    """How a scene is marched, on the two grids that it takes at least to know its error.

    Attributes:
        choice: the scheme, and why.
        grid: the finer of the two grids.
        steps: per period on it.
        refused: why the scene is not marched; empty where it is.
    """

    choice: Choice
    grid: Grid
    steps: int
    refused: str

    @property
    def method(self) -> str:
        return "march" if self.refused else method_name(self.choice)

    @property
    def flops(self) -> float:
        """Floating-point operations, to the order of magnitude."""
        nx, ny, _ = self.grid.shape
        step = SCHEMES[self.choice.scheme].step_cost * 4.0 * nx * ny * (nx + ny)
        return 2 * PERIODS * self.steps * step


def plan(scene: Scene, needs: Needs, *, tolerance: float) -> Plan:
    """How a scene is marched, or why not, as far as that is known before."""
    first = replace(grid_for(scene, needs, tolerance=tolerance), nt=4)
    problems = problems_of([scene], first, tolerance=tolerance)
    (choice,) = choose(problems=problems, grid=first, tolerance=tolerance)
    grid, steps, refused = first, 0, _unknown(scene, needs)
    for level, finer in enumerate((first, finer_grid(first))):
        if refused:
            break
        if finer is None:
            refused = NO_FINER_GRID
            break
        grid, problems = finer, problems_of([scene], finer, tolerance=tolerance)
        steps = int(steps_on(grid, level, [choice], problems=problems, scheme=choice.scheme)[0])
        refused = too_many_steps(steps)
    return Plan(choice, grid, steps, refused)


def _unknown(scene: Scene, needs: Needs) -> str:
    """What of a scene cannot be marched at all; empty where all can."""
    if wants_modes(scene):
        return "march is for rectangular fingers"
    return first_reason(term.refused_by_march(scene) for term in needs.terms)


def left_out_by(why: str, needs: Needs) -> tuple[LeftOut, ...]:
    """What a march leaves out: the steps of the other kind, mirror halves and terms."""
    return (LeftOut(why, "cheaper"), *needs.halves_left_out, *needs.terms_left_out)


def _solution(scene: Scene, needs: Needs, force: SettledForce) -> Solution:
    grid: Grid = force.grid
    return solution_of(
        scene,
        mean=force.mean,
        error=force.error,
        left_out=left_out_by(force.left_out, needs),
        status=force.status,
        method=force.method,
        nx=grid.x.full_points,
        ny=grid.y.full_points,
        nt=force.steps_per_period,
        newton_steps=force.newton_steps,
        krylov_iterations=force.krylov_iterations,
        work=float(force.periods * force.steps_per_period * grid.nx * grid.ny),
    )
