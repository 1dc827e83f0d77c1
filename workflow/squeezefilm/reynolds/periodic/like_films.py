"""Films that differ by terms alone, on the same grids: there they share most of their errors.

The difference of their forces needs far coarser grids than the forces do: near contact (σ 2.3e4,
ε 0.93) 16 × 16 × 24 points give what inertia changes to 1 %, where the force takes 160 × 160 × 140
for an error of a twentieth of this change.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import inf
from typing import Any

import numpy as np

from squeezefilm.errors import apply_with_bisection
from squeezefilm.film.scene import Scenes, equal_row_groups
from squeezefilm.lazy import cl
from squeezefilm.parallel import track_progress
from squeezefilm.reynolds.device import Device
from squeezefilm.reynolds.error_estimate import (
    THIN_LAYER_CONVERGENCE_RATIO,
    VELOCITY_CHANGE_SIZE_FRACTION,
    error_per_change,
    resolved_change,
)
from squeezefilm.reynolds.grid import Grid, krylov_iteration_flops
from squeezefilm.reynolds.periodic.launch import Batch, PeriodicStates, launch
from squeezefilm.reynolds.periodic.refinement import (
    MAX_SCENES_PER_LAUNCH,
    START_GRID_TOLERANCE,
    max_unknowns_on_device,
    take_launch_batches,
)
from squeezefilm.reynolds.periodic.resolution import (
    finer_grid,
    first_grids,
    unresolved_profile_reasons,
)
from squeezefilm.reynolds.plan import SolvePlan
from squeezefilm.reynolds.terms import Terms, distinct_term_sets
from squeezefilm.reynolds.terms.outline import RadialFilm, SmoothOutline

# Relative error that the iteration may leave, over that which the grids are for, and the same of
# each grid over that of the one before.
ITERATION_TOLERANCE_FRACTION, REFINED_TOLERANCE_FRACTION = 1e-2, 0.1


@dataclass(frozen=True, eq=False)
class FilmOnGrids:
    """A film on two grids, the finer one last, or on one.

    Attributes:
        period_means: its gauge pressure's means over a period, (nx, ny) on each grid.
        mean_pressure_ratios: their means over the pad.
        residual, residual_error: what the iteration left of the mass, and of the last mean.
        operation_count: floating-point operations on the grids.
        states: those on the grids, where they were asked for.
    """

    grids: tuple[Grid, ...]
    period_means: tuple[np.ndarray, ...]
    mean_pressure_ratios: tuple[float, ...]
    residual: float
    residual_error: float
    operation_count: float
    states: tuple[PeriodicStates, ...]

    def relative_difference(
        self, film: FilmOnGrids, *, without: FilmOnGrids
    ) -> tuple[float, float]:
        """Return the difference of two films' forces over this one's, and the error of that.

        The error is estimated as that of a force, by the difference of the fields in place of a
        field: by how it changes from grid to grid, with the fall of thin layers. One grid tells no
        error: it is infinite. Films at rest, which all have no force, do not differ.
        """
        if film is without or not any(film.mean_pressure_ratios + without.mean_pressure_ratios):
            return 0.0, 0.0
        *coarser, fine = np.subtract(film.mean_pressure_ratios, without.mean_pressure_ratios) / (
            self.mean_pressure_ratios
        )
        if not coarser:
            return float(fine), inf
        (coarse,) = coarser
        differences = [b - a for a, b in zip(without.period_means, film.period_means, strict=True)]
        before, after = zip(self.grids, [each[None] for each in differences], strict=True)
        mean = abs(self.mean_pressure_ratios[1])
        resolved = float(resolved_change(before, after)[0]) / mean
        change = max(abs(fine - coarse), VELOCITY_CHANGE_SIZE_FRACTION * resolved)
        left = (film.residual_error + without.residual_error) / mean
        return float(fine), float(error_per_change(THIN_LAYER_CONVERGENCE_RATIO)) * change + left


def films_on_grids_of(
    plan: SolvePlan,
    scenes: Scenes,
    rows: Sequence[int],
    *,
    tolerance: float,
    grid_count: int,
    device: Device,
    keep_states: bool = False,
) -> dict[int, FilmOnGrids]:
    """Solve some scenes on grids of their like; by row, where all grids have a state.

    Args:
        plan: that of scenes of other terms, whose first grids to a tolerance these are.
        grid_count: up to which grid, from the coarser of these on; the last two are solved on.
    """
    if not device.is_cpu:
        from squeezefilm.reynolds.self_test import check_device

        check_device(device)
    how: dict[str, Any] = {
        "tolerance": tolerance,
        "grid_count": grid_count,
        "device": device,
    }

    def solve_rows(rows: np.ndarray) -> list[FilmOnGrids | None]:
        found: dict[int, FilmOnGrids] = {}
        queued: dict[object, list[Batch]] = {}
        for batch in _batches_on_grids_of(plan, scenes, rows, **how):
            queued.setdefault((batch.grids, batch.terms, batch.aspect), []).append(batch)
        try:
            with track_progress(len(rows), unit="scene", name="periodic states") as progress:
                while queued:
                    batches = take_launch_batches(queued, most=MAX_SCENES_PER_LAUNCH)
                    launched = launch(batches, device=device)
                    states = launched.wait_for_states(device)
                    for batch, stages in zip(batches, states, strict=True):
                        stages = stages[-min(grid_count, 2) :]
                        found |= _films_of_batch(batch, stages, keep_states=keep_states)
                        progress.update(len(batch.scene_rows))
                    device.recycle_arrays(*launched.pooled_host_arrays)
        except Exception:
            device.queue.finish()  # kernels under way write into arrays that this sets free
            raise
        return [found.get(row) for row in rows.tolist()]

    solved = apply_with_bisection(solve_rows, np.array(rows), failed=_no_film_on_device)
    return {row: film for row, film in zip(rows, solved, strict=True) if film}


def _no_film_on_device(error: Exception) -> None:
    """Leave a film unknown that the device has no room for; any other error is a fault."""
    if not isinstance(error, cl.Error | MemoryError):
        raise error


def _batches_on_grids_of(
    plan: SolvePlan,
    scenes: Scenes,
    rows: np.ndarray,
    *,
    tolerance: float,
    grid_count: int,
    device: Device,
) -> Iterator[Batch]:
    """Batches of the scenes whose like have two grids that resolve the profile."""
    term_sets, term_set_index = distinct_term_sets(scenes)
    unresolved = unresolved_profile_reasons(plan, tolerance=tolerance)
    rows = rows[[row not in unresolved for row in rows.tolist()]]
    if not rows.size:
        return
    capacity = max_unknowns_on_device(device)
    refinements = grid_count - 2
    left = ITERATION_TOLERANCE_FRACTION * REFINED_TOLERANCE_FRACTION**refinements * tolerance
    for alike, _, grids in first_grids(plan, rows, tolerance=tolerance, capacity=capacity):
        grids = grids[:-1] if grid_count == 1 else grids
        for _ in range(refinements):
            finer = finer_grid(grids[-1], capacity=capacity)
            grids = (grids[-1], *([finer] if finer else []))
        if len(grids) >= min(grid_count, 2):
            tolerances = [START_GRID_TOLERANCE] * (len(grids) - 2) + [left] * min(len(grids), 2)
            for part in equal_row_groups(term_set_index[alike]):
                terms = _terms_on_grid(term_sets[term_set_index[alike[part[0]]]], grids[0])
                yield Batch(scenes, alike[part], terms, grids, tolerances)


def _terms_on_grid(terms: Terms, grid: Grid) -> Terms:
    """Return terms as a grid has them: a film without angle may be on one over the whole pad."""
    if grid.outline is None:
        return terms
    return tuple(SmoothOutline() if isinstance(term, RadialFilm) else term for term in terms)


def _films_of_batch(
    batch: Batch, stages: Sequence[PeriodicStates], *, keep_states: bool
) -> dict[int, FilmOnGrids]:
    fine = stages[-1]
    means = [states.gauge_pressure_ratio.mean(axis=-1) for states in stages]
    # A mass error w moves the pressure by about n w/H.
    stiffness = batch.scenes.gas.polytropic_exponent / batch.scenes.narrowest_gap_ratio
    residual = fine.result_rows["residual"]
    operations = sum(
        krylov_iteration_flops(states.grid, batch.terms)
        * (states.result_rows["newton_steps"] + states.result_rows["krylov_iterations"])
        for states in stages
    )
    solved = np.all([states.status_indices == 0 for states in stages], axis=0)
    return {
        int(batch.scene_rows[k]): FilmOnGrids(
            tuple(states.grid for states in stages),
            tuple(mean[k] for mean in means),
            tuple(float(states.mean_pressure_ratio[k]) for states in stages),
            residual=float(residual[k]),
            residual_error=float((stiffness * residual)[k]),
            operation_count=float(operations[k]),
            states=tuple(states[k].copy() for states in stages) if keep_states else (),
        )
        for k in np.flatnonzero(solved).tolist()
    }
