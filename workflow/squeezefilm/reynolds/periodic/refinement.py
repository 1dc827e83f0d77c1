"""The periodic method: grids are refined until each scene's force holds its tolerance."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence, Sized
from dataclasses import dataclass, field

import numpy as np

from squeezefilm.film.scene import Rows
from squeezefilm.parallel import track_progress
from squeezefilm.reynolds.device import Device
from squeezefilm.reynolds.error_estimate import estimate_errors, too_large_error_text
from squeezefilm.reynolds.grid import Grid, krylov_iteration_flops
from squeezefilm.reynolds.periodic.launch import (
    MAX_OPERATIONS,
    STATUS_OF_ENDING_NAME,
    STATUS_TEXTS,
    Batch,
    Launch,
    PeriodicStates,
    launch,
)
from squeezefilm.reynolds.periodic.resolution import (
    MAX_UNKNOWNS,
    finer_grid,
    first_grids,
    min_convergence_ratio,
    profile_error_ratio,
)
from squeezefilm.reynolds.plan import SolvePlan
from squeezefilm.reynolds.terms import Terms, have_velocity_terms
from squeezefilm.solution import Solutions

# Relative error of the force that the iteration may leave on a grid that only starts the next.
START_GRID_TOLERANCE = 1e-2
# Share of the allowed error that the iteration may leave where the estimate counts it once; and of
# that on grids that go on from a known state. And the share of films with inertia or heat, on all
# grids: their last change is taken twice at least, with what two iterations left in it.
ITERATION_ERROR_FRACTION = 0.5
CONTINUED_TOLERANCE_FACTOR = 0.04
VELOCITY_ITERATION_ERROR_FRACTION = 0.2
# And of that where states are kept, so that a quantity's change from grid to grid shows the grids'
# error alone.
KEPT_STATE_ITERATION_ERROR_FRACTION = 0.04
# Launches under way at a time: the host looks at one while the device is at the other.
LAUNCHES_IN_FLIGHT = 2
# Scenes of a launch.
MIN_SCENES_PER_LAUNCH, MAX_SCENES_PER_LAUNCH = 16, 128
# States of one launch; more go into several.
MAX_LAUNCH_STATE_BYTES = 256 * 2**20
# Fields of a grid that a work-group needs at least, and the part of the device's memory, one in so
# many, that they may take: devices give no more in one piece.
MIN_FIELDS_PER_WORK_GROUP = 36
DEVICE_MEMORY_DIVISOR = 4
# Times that a scene is begun again on finer grids, as Newton's method fails on the finest.
MAX_NEWTON_FAILURES = 3
# Iterations that a state takes at least on a first grid.
MIN_FIRST_GRID_ITERATIONS = 4
WORK_LIMIT_STATUS = STATUS_OF_ENDING_NAME["OVER_LIMIT"]
# What becomes of a scene after a launch: its force is good, it goes on, or it ends without one.
(
    OUTCOME_ACCEPTED,
    OUTCOME_REFINED,
    OUTCOME_RESTARTED,
    OUTCOME_NO_STATE,
    OUTCOME_NEGATIVE_PRESSURE,
    OUTCOME_GRIDS_EXHAUSTED,
) = range(6)


@dataclass(frozen=True, eq=False)
class Refinement:
    """Scenes on their way through the grids; columns of shape (n,).

    Attributes:
        change: how the mean pressure changed last (error_estimate.py), (2, n).
        newton_failures: times that Newton's method failed on the last grid.
        queued_batches: batches that go on in one of the next launches, those that go together in a
            list.
    """

    plan: SolvePlan
    solutions: Solutions
    tolerance: float
    max_unknowns: float
    keep_states: bool
    last_pressure_change: np.ndarray
    newton_failures: np.ndarray
    queued_batches: dict[object, list[Batch]] = field(default_factory=dict)

    def queue_scenes(
        self,
        rows: np.ndarray,
        terms: Terms,
        grids: tuple[Grid, ...],
        guess: np.ndarray | None = None,
    ) -> None:
        """Let scenes go through some grids, from rest or from a guess, with one of the launches."""
        velocities = have_velocity_terms(terms)
        left = self.tolerance
        left *= VELOCITY_ITERATION_ERROR_FRACTION if velocities else ITERATION_ERROR_FRACTION
        left *= KEPT_STATE_ITERATION_ERROR_FRACTION if self.keep_states else 1.0
        tolerances = [max(left, START_GRID_TOLERANCE)] * (len(grids) - 2) + [left] * min(
            len(grids), 2
        )
        if guess is not None and not velocities:
            # So that the finer grid does not take the state over as it is.
            tolerances = [CONTINUED_TOLERANCE_FACTOR * left] * len(grids)
        batch = Batch(
            self.plan.scenes,
            rows,
            terms,
            grids,
            tolerances,
            guess,
            returns_every_grid=self.keep_states,
            many=are_many(self.plan.scenes),
        )
        key = grids, terms, batch.aspect, guess is None
        self.queued_batches.setdefault(key, []).append(batch)

    def accept_or_refine(self, batch: Batch, stages: Sequence[PeriodicStates]) -> int:
        """Write the solutions of scenes whose error is small enough, or that have no better one.

        The others wait for finer grids. Returns how many are finished.
        """
        rows, terms, grids, solutions = batch.scene_rows, batch.terms, batch.grids, self.solutions
        at: Rows = slice(None) if batch.scenes is self.plan.scenes else rows
        last, grid, finer = stages[-1], grids[-1], finer_grid(grids[-1], capacity=self.max_unknowns)
        nodes = tuple(each.nodes_across for each in (grids[0], *grids)[-2:])
        error, allowed, change = estimate_errors(
            last.result_rows,
            self.last_pressure_change[:, at],
            scenes=batch.scenes,
            terms=terms,
            of_profile=profile_error_ratio(self.plan, *nodes, tolerance=self.tolerance, rows=at),
            least=min_convergence_ratio(batch.scenes, terms),
            tolerance=self.tolerance,
        )
        if len(grids) == 1:  # a single grid tells no error
            error[:], change[:] = np.inf, np.nan
        for states in stages:
            newton, krylov = (
                states.result_rows["newton_steps"],
                states.result_rows["krylov_iterations"],
            )
            solutions.newton_steps[at] += newton
            solutions.krylov_iterations[at] += krylov
            solutions.operation_count[at] += krylov_iteration_flops(states.grid, terms) * (
                newton + krylov
            )
        solutions.residual[at] = last.result_rows["residual"]
        self.write_grid_sizes(at, grid)

        # A finer grid takes about as many iterations as the last one did.
        next_work = krylov_iteration_flops(finer, terms) * (newton + krylov) if finer else 0.0
        too_dear = solutions.operation_count[at] + next_work > MAX_OPERATIONS
        no_state = last.status_indices != 0
        unknown = np.logical_or.reduce([states.status_indices != 0 for states in stages[-2:]])
        negative = ~(last.result_rows["lowest"] > 0)
        outcome = np.where(error <= allowed, OUTCOME_ACCEPTED, OUTCOME_REFINED)
        if unknown.any() or negative.any():
            # What no coarser grid describes, a finer one may.
            change[:, unknown], error[unknown | negative] = np.nan, np.inf
            outcome[unknown | negative] = OUTCOME_REFINED
            if finer is None:
                outcome[negative] = OUTCOME_NEGATIVE_PRESSURE
            outcome[no_state if finer else unknown] = OUTCOME_NO_STATE
            outcome[no_state & ~too_dear & self._restartable_mask(batch)] = OUTCOME_RESTARTED
        outcome[(outcome == OUTCOME_REFINED) & (True if finer is None else too_dear)] = (
            OUTCOME_GRIDS_EXHAUSTED
        )
        self.last_pressure_change[:, at] = change

        accepted = np.flatnonzero(outcome == OUTCOME_ACCEPTED)
        scale_n = batch.scenes.force_scale_n
        solutions.status[rows[accepted]] = "ok"
        solutions.force_n[rows[accepted]] = (last.result_rows["mean"] * scale_n)[accepted]
        solutions.force_error_n[rows[accepted]] = (error * scale_n)[accepted]
        for k in accepted.tolist() if self.keep_states else ():
            solutions.states[rows[k]] = tuple(states[k].copy() for states in stages[-2:])
        if len(accepted) == len(rows):
            return len(rows)

        begun_again = rows[outcome == OUTCOME_RESTARTED]
        if finer and (finest := finer_grid(finer, capacity=self.max_unknowns)) and len(begun_again):
            self.newton_failures[begun_again] += 1
            self.queue_scenes(begun_again, terms, (finer, finest))
        refined = outcome == OUTCOME_REFINED
        if finer and refined.any():
            self.queue_scenes(rows[refined], terms, (grid, finer), last.unknowns[refined])
        self._write_failure_reasons(batch, stages, outcome, error=error, allowed=allowed)
        return len(rows) - len(begun_again) - int(np.count_nonzero(refined))

    def _restartable_mask(self, batch: Batch) -> np.ndarray | bool:
        """Return which scenes without a state may be tried on finer grids, from rest."""
        finer = finer_grid(batch.grids[-1], capacity=self.max_unknowns)
        finest = finer_grid(finer, capacity=self.max_unknowns) if finer else None
        if finest is None or have_velocity_terms(batch.terms):
            return False
        return self.newton_failures[batch.scene_rows] < MAX_NEWTON_FAILURES

    def _write_failure_reasons(
        self,
        batch: Batch,
        stages: Sequence[PeriodicStates],
        outcome: np.ndarray,
        *,
        error: np.ndarray,
        allowed: np.ndarray,
    ) -> None:
        """Write why scenes end without a force."""
        rows, grid, status = batch.scene_rows, batch.grids[-1], self.solutions.status
        for states in stages[-2:]:  # of two that failed the last one's reason counts
            failed = (outcome == OUTCOME_NO_STATE) & (states.status_indices != 0)
            for k in np.flatnonzero(failed).tolist():
                ending = STATUS_TEXTS[states.status_indices[k]]
                advice = fewer_operations_hint(batch.terms) if ending == WORK_LIMIT_STATUS else ""
                status[rows[k]] = f"{ending} ({_grid_text(states.grid)}){advice}"
        before = stages[-2:][0]
        self.write_grid_sizes(
            rows[(outcome == OUTCOME_NO_STATE) & (before.status_indices != 0)], before.grid
        )
        for row in rows[outcome == OUTCOME_NEGATIVE_PRESSURE]:
            status[row] = (
                f"not converged: the pressure is not positive everywhere ({_grid_text(grid)})"
            )
        limit, advice = (
            f"within {MAX_OPERATIONS:.0e} operations",
            fewer_operations_hint(batch.terms),
        )
        if finer_grid(grid, capacity=self.max_unknowns) is None:
            limit, advice = "on the finest grid", ""
        reason = f"not converged: tolerance not reached {limit} ({_grid_text(grid)})"
        for k in np.flatnonzero(outcome == OUTCOME_GRIDS_EXHAUSTED).tolist():
            text = too_large_error_text(
                error[k], allowed=allowed[k], force=stages[-1].mean_pressure_ratio[k]
            )
            status[rows[k]] = f"{reason}: {text}{advice}"

    def write_grid_sizes(self, rows: Rows, grid: Grid) -> None:
        """The grid that scenes have come to."""
        self.solutions.domain[rows] = self.plan.domain[rows]
        self.solutions.nx[rows], self.solutions.ny[rows] = grid.nodes_across
        self.solutions.nt[rows] = grid.nt


def are_many(scenes: Sized) -> bool:
    """Return whether scenes that are solved are many (``compiled_terms``)."""
    return len(scenes) > MAX_SCENES_PER_LAUNCH


def max_unknowns_on_device(device: Device) -> float:
    """Return the most unknowns of a grid that a device has memory for."""
    fields = MIN_FIELDS_PER_WORK_GROUP * DEVICE_MEMORY_DIVISOR
    return min(MAX_UNKNOWNS, device.memory_bytes // (8 * fields))


def take_launch_batches(queued: dict[object, list[Batch]], *, most: int) -> list[Batch]:
    """Take batches of one program that fill a launch, those of the dearest grids first.

    So that no long solve is left over at the end.

    Args:
        queued: batches that wait, those that go together in a list, by their grids, terms and so
            on.
    """
    chosen: list[Batch] = []
    scenes, size = 0, 0
    for key in sorted(queued, key=lambda key: -krylov_iteration_flops(key[0][-1])):  # type: ignore[index]
        batch = Batch.join_batches(queued[key])
        scene_bytes = 8 * sum([grid.unknown_count for grid in batch.grids])
        room = max((MAX_LAUNCH_STATE_BYTES - size) // scene_bytes, 0 if chosen else 1)
        count = min(most - scenes, room, len(batch))
        if count <= 0 or (chosen and batch.program != chosen[0].program):
            continue
        if count < len(batch):
            queued[key] = [batch[count:]]
            batch = batch[:count]
        else:
            del queued[key]
        chosen.append(batch)
        scenes += count
        size += scene_bytes * count
    return chosen


def solve_periodic(
    plan: SolvePlan,
    solutions: Solutions,
    *,
    tolerance: float,
    device: Device,
    keep_states: bool = False,
    report: Callable[[int], object] = lambda solved: None,
) -> None:
    """Solve for the periodic state of each scene whose status is empty; see ``solver.solve``."""
    waiting = solutions.status == ""
    rows = slice(None) if waiting.all() else np.flatnonzero(waiting)
    solutions.absent_terms[rows] = plan.absent_terms[rows]
    refinement = Refinement(
        plan=plan,
        solutions=solutions,
        tolerance=tolerance,
        max_unknowns=max_unknowns_on_device(device),
        keep_states=keep_states,
        last_pressure_change=np.full((2, len(plan.scenes)), np.nan),
        newton_failures=np.zeros(len(plan.scenes), dtype=np.int64),
    )
    room, count = refinement.max_unknowns, int(np.count_nonzero(waiting))
    for alike, terms, grids in first_grids(
        plan, rows, tolerance=tolerance, capacity=room, kept=keep_states
    ):
        if MIN_FIRST_GRID_ITERATIONS * krylov_iteration_flops(grids[-1], terms) <= MAX_OPERATIONS:
            refinement.queue_scenes(alike, terms, grids)
            continue
        refinement.write_grid_sizes(alike, grids[-1])
        reason = f"{WORK_LIMIT_STATUS} ({_grid_text(grids[-1])}){fewer_operations_hint(terms)}"
        solutions.status[alike] = reason
        report(len(alike))
    size = min(max(-(-count // LAUNCHES_IN_FLIGHT), MIN_SCENES_PER_LAUNCH), MAX_SCENES_PER_LAUNCH)
    flying: deque[Launch] = deque()
    with track_progress(count, unit="scene", name="periodic states") as progress:
        while refinement.queued_batches or flying:
            while refinement.queued_batches and len(flying) < LAUNCHES_IN_FLIGHT:
                batches = take_launch_batches(refinement.queued_batches, most=size)
                flying.append(launch(batches, device=device))
            landing = flying.popleft()
            progress.current_step = _grid_text(landing.batches[0].grids[-1])
            landed = zip(landing.batches, landing.wait_for_states(device), strict=True)
            finished = sum(
                refinement.accept_or_refine(*finished_launch) for finished_launch in landed
            )
            progress.update(finished)
            report(finished)
            # Other launches may have the arrays, as no one looks at the states any more.
            device.recycle_arrays(*landing.pooled_host_arrays)


def fewer_operations_hint(terms: Terms) -> str:
    """Return what lets a scene be solved with fewer operations, for the end of its status."""
    dear = [term.label for term in terms if term.SPACE_MATRIX_PRODUCT_COUNT]
    return f"; take a larger tolerance{' or no ' if dear else ''}{' and '.join(dear)}"


def _grid_text(grid: Grid) -> str:
    across, along = grid.nodes_across
    return f"{across} × {along} × {grid.nt} points"
