"""Scenes solved by marching in time until they settle: method ``march``, the yardstick."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Sequence

from squeezefilm.reynolds.device import Device
from squeezefilm.reynolds.galerkin import wants_modes
from squeezefilm.reynolds.grid import Grid
from squeezefilm.reynolds.needs import LeftOut, Needs
from squeezefilm.reynolds.refinement import grid_for, problems_of
from squeezefilm.reynolds.settling import SettledForce, transient_force
from squeezefilm.reynolds.solution import Solution, left_out_text, refusal
from squeezefilm.scene import Scene

# Neither scheme is preconditioned for sliding: beyond this, steps become many or slow.
LARGEST_BEARING = 30.0


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
        reason = _refused(scene, need)
        if reason is not None:
            solutions[index] = refusal(reason, method="march")
            report(1)
            continue
        grid = grid_for(scene, need, tolerance=tolerance)
        groups[grid.nx, grid.ny, grid.fold_x, grid.fold_y, scene.aspect, need.bearing].append(index)
    for group in groups.values():
        members = [scenes[index] for index in group]
        forces = transient_force(
            problems_on=lambda grid, members=members: problems_of(  # type: ignore[misc]
                members, grid, tolerance=tolerance
            ),
            grid=grid_for(members[0], needs[group[0]], tolerance=tolerance),
            tolerance=tolerance,
            device=device,
        )
        for index, force in zip(group, forces, strict=True):
            solutions[index] = _solution(scenes[index], needs[index], force)
            report(1)
    return [solutions[index] for index in range(len(scenes))]


def _refused(scene: Scene, needs: Needs) -> str | None:
    """Why a scene cannot be marched, if so."""
    if wants_modes(scene):
        return "march knows rectangular fingers with a flat gap only"
    if needs.flow_terms > 1 or needs.polytropic:
        return "march knows viscous isothermal flow only"
    if abs(scene.bearing_number) > LARGEST_BEARING:
        return f"march takes bearing numbers up to {LARGEST_BEARING:g}"
    return None


def _solution(scene: Scene, needs: Needs, force: SettledForce) -> Solution:
    grid: Grid = force.grid
    left_out = (LeftOut(force.left_out, "cheaper"), *needs.halves_left_out, *needs.terms_left_out)
    return Solution(
        force_n=force.mean * scene.force_scale_n,
        force_error_n=force.error * scene.force_scale_n,
        status=force.status,
        method=force.method,
        left_out=left_out_text(left_out),
        nx=grid.x.full_points,
        ny=grid.y.full_points,
        nt=force.steps_per_period,
        newton_steps=force.newton_steps,
        krylov_iterations=force.krylov_iterations,
        residual=0.0,
        work=float(force.periods * force.steps_per_period * grid.nx * grid.ny),
    )
