"""The periodic method: grids are refined until each scene's force holds its tolerance."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from squeezefilm.film.scene import Rows
from squeezefilm.parallel import progress_of
from squeezefilm.reynolds.device import Device
from squeezefilm.reynolds.error_estimate import error_text, estimate
from squeezefilm.reynolds.grid import Grid, iteration_flops
from squeezefilm.reynolds.needs import Needs
from squeezefilm.reynolds.periodic.launch import (
    ENDINGS,
    MOST_WORK,
    STATUS,
    Batch,
    Launch,
    State,
    States,
    launch,
)
from squeezefilm.reynolds.periodic.resolution import (
    MOST_UNKNOWNS,
    Group,
    finer_grid,
    first_grids,
    least_fall,
    profile_fall,
)
from squeezefilm.reynolds.terms import Terms, with_velocities
from squeezefilm.solution import Solutions

# Relative error of the force that the iteration may leave on a grid that only starts the next.
START_TOLERANCE = 1e-2
# Share of the allowed error that the iteration may leave where the estimate counts it once; and of
# that on grids that go on from a known state.
LEFT_SHARE = 0.5
GOING_ON = 0.04
# And of that where states are kept, so that a quantity's change from grid to grid shows the grids'
# error alone.
KEPT = 0.04
# Launches under way at a time: the host looks at one while the device is at the other.
IN_FLIGHT = 2
# Scenes of a launch.
LEAST_BATCH, MOST_BATCH = 16, 128
# States of one launch; more go into several.
LAUNCH_BYTES = 256 * 2**20
# Fields of a grid that a work-group needs at least, and the part of the device's memory, one in so
# many, that they may take: devices give no more in one piece.
LEAST_FIELDS = 36
MEMORY_PARTS = 4
# Times that a scene is begun again on finer grids, as Newton's method fails on the finest.
MOST_FAILURES = 3
# Iterations that a state takes at least on a first grid.
LEAST_ITERATIONS = 4
OVER_LIMIT = ENDINGS["OVER_LIMIT"]


@dataclass(frozen=True, eq=False)
class Refinement:
    """Scenes on their way through the grids; columns of shape (n,).

    Attributes:
        change: how the mean pressure changed last (error_estimate.py), (2, n).
        failures: times that Newton's method failed on the last grid.
        waiting: scenes that go on in one of the next launches, those that go together in a list.
    """

    needs: Needs
    solutions: Solutions
    tolerance: float
    room: float
    keep_states: bool
    change: np.ndarray
    failures: np.ndarray
    waiting: dict[tuple[object, ...], list[Group]] = field(default_factory=dict)

    def wait(self, group: Group) -> None:
        key = group.grids, group.terms, group.aspect, group.guess is None
        self.waiting.setdefault(key, []).append(group)

    def next_launch(self, *, most: int) -> list[Group]:
        """Groups of like terms that fill a launch, those of the dearest grids first.

        So that no long solve is left over at the end.
        """
        chosen: list[Group] = []
        scenes, size = 0, 0
        for key in sorted(self.waiting, key=lambda key: -iteration_flops(key[0][-1])):  # type: ignore[index]
            group = _joined(self.waiting[key])
            scene_bytes = 8 * sum([grid.count for grid in group.grids])
            room = max((LAUNCH_BYTES - size) // scene_bytes, 0 if chosen else 1)
            count = min(most - scenes, room, len(group.rows))
            if count <= 0 or (chosen and group.terms != chosen[0].terms):
                continue
            if count < len(group.rows):
                self.waiting[key] = [_some(group, slice(count, None))]
                group = _some(group, slice(count))
            else:
                del self.waiting[key]
            chosen.append(group)
            scenes += count
            size += scene_bytes * count
        return chosen

    def batch(self, group: Group) -> Batch:
        """Return the batch of a group for the device."""
        left = (KEPT if self.keep_states else 1.0) * LEFT_SHARE * self.tolerance
        starts = len(group.grids) - 2
        shares = [max(left, START_TOLERANCE)] * starts + [left] * min(len(group.grids), 2)
        if group.guess is not None:  # so that the finer grid does not take the state over as it is
            shares = [GOING_ON * left] * len(group.grids)
        scenes = self.needs.scenes
        every = len(group.rows) == len(scenes) and (group.rows == np.arange(len(scenes))).all()
        if not every:  # those know their numbers
            scenes = scenes[group.rows]
        return Batch(scenes, group.terms, group.grids, shares, group.guess, self.keep_states)

    def accept_or_refine(self, group: Group, batch: Batch, stages: Sequence[States]) -> int:
        """Write the solutions of scenes whose error is small enough, or that have no better one.

        The others wait for finer grids. Returns how many are finished.
        """
        rows, terms, grids, solutions = group.rows, group.terms, group.grids, self.solutions
        at: Rows = slice(None) if batch.scenes is self.needs.scenes else rows
        said, grid, finer = stages[-1].said, grids[-1], finer_grid(grids[-1], room=self.room)
        nodes = tuple(each.across for each in (grids[0], *grids)[-2:])
        error, allowed, change = estimate(
            said,
            self.change[:, at],
            scenes=batch.scenes,
            terms=terms,
            of_profile=profile_fall(self.needs, *nodes, tolerance=self.tolerance, rows=at),
            least=least_fall(batch.scenes),
            tolerance=self.tolerance,
        )
        if len(grids) == 1:  # a single grid tells no error
            error[:], change[:] = np.inf, np.nan
        self.change[:, at] = change
        for each, states in zip(grids, stages, strict=True):
            newton, krylov = states.said["newton_steps"], states.said["krylov_iterations"]
            solutions.newton_steps[at] += newton
            solutions.krylov_iterations[at] += krylov
            solutions.work[at] += iteration_flops(each, terms) * (newton + krylov)
        # A finer grid takes about as many iterations as the last one did.
        next_work = iteration_flops(finer, terms) * (newton + krylov) if finer else 0.0
        over = solutions.work[at] + next_work > MOST_WORK
        solutions.residual[at] = said["residual"]
        self._write_grid(at, grid)
        reasons: dict[int, str] = {}  # why scenes end without a force

        def end(
            which: np.ndarray, reason: str, *, with_error: bool = False, advice: str = ""
        ) -> None:
            for k in np.flatnonzero(which).tolist():
                text = error_text(error[k], allowed=allowed[k], force=said["mean"][k])
                reasons.setdefault(k, (f"{reason}: {text}" if with_error else reason) + advice)

        begun = np.zeros(len(rows), dtype=bool)
        statuses = [states.status for states in stages[-2:]]
        unknown = np.logical_or.reduce(statuses)
        if unknown.any():
            begun = self._begin_again(group, (statuses[-1] != 0) & ~over, finer)
            hopeless = ((statuses[-1] != 0) | (finer is None)) & ~begun
            for each, status in zip(grids[:-3:-1], statuses[::-1], strict=True):
                self._write_grid(rows[(status != 0) & hopeless], each)
                for ending in range(1, len(STATUS)):
                    advice = fewer_operations(terms) if STATUS[ending] == OVER_LIMIT else ""
                    reason = f"{STATUS[ending]} ({_size(each)}){advice}"
                    end((status == ending) & hopeless, reason)
            # What no coarser grid describes, a finer one may.
            error[unknown] = np.inf
            self.change[:, rows[unknown]] = np.nan
        negative = ~(said["lowest"] > 0)
        if np.count_nonzero(negative):
            error[negative] = np.inf
            if finer is None:
                reason = f"not converged: the pressure is not positive everywhere ({_size(grid)})"
                end(negative & ~begun, reason)
        waiting = ~begun
        if reasons:
            waiting[list(reasons)] = False
        good = ((error <= allowed) & waiting).nonzero()[0]
        accepted, scale_n = rows[good], batch.scenes.force_scale_n
        solutions.status[accepted] = "ok"
        solutions.force_n[accepted] = (said["mean"] * scale_n)[good]
        solutions.force_error_n[accepted] = (error * scale_n)[good]
        if self.keep_states:
            for k in good.tolist():
                # Copies, for the launch's arrays are used again.
                last = zip(grids[-2:], stages[-2:], strict=True)
                kept = tuple(State(each, states.unknowns[k].copy()) for each, states in last)
                solutions.states[rows[k]] = kept
        waiting[good] = False
        if np.count_nonzero(waiting):
            limit, advice = f"within {MOST_WORK:.0e} operations", fewer_operations(terms)
            if finer is None:
                over, limit, advice = waiting, "on the finest grid", ""
            reason = f"not converged: tolerance not reached {limit} ({_size(grid)})"
            end(waiting & over, reason, with_error=True, advice=advice)
            waiting[list(reasons)] = False
            if finer and waiting.any():
                guess = stages[-1].unknowns[waiting]
                self.wait(Group(rows[waiting], (grid, finer), terms, group.aspect, guess))
        for k, reason in reasons.items():
            solutions.status[rows[k]] = reason
        return len(rows) - int(np.count_nonzero(begun) + np.count_nonzero(waiting))

    def _begin_again(self, group: Group, failed: np.ndarray, finer: Grid | None) -> np.ndarray:
        """Let scenes without a state on the last grid wait for finer ones, from rest."""
        again = finer_grid(finer, room=self.room) if finer else None
        which = failed & (self.failures[group.rows] < MOST_FAILURES)
        if finer is None or again is None or with_velocities(group.terms):
            return np.zeros_like(failed)
        if which.any():
            rows = group.rows[which]
            self.wait(Group(rows, (finer, again), group.terms, group.aspect))
            self.failures[rows] += 1
        return which

    def _write_grid(self, rows: Rows, grid: Grid) -> None:
        """The grid that scenes have come to."""
        self.solutions.domain[rows] = self.needs.domains[rows]
        self.solutions.nx[rows], self.solutions.ny[rows] = grid.across
        self.solutions.nt[rows] = grid.nt


def _some(group: Group, part: slice) -> Group:
    guess = None if group.guess is None else group.guess[part]
    return replace(group, rows=group.rows[part], guess=guess)


def _joined(groups: Sequence[Group]) -> Group:
    """Groups that go together as one."""
    if len(groups) == 1:
        return groups[0]
    guesses = [group.guess for group in groups if group.guess is not None]
    rows = np.concatenate([group.rows for group in groups])
    return replace(groups[0], rows=rows, guess=np.concatenate(guesses) if guesses else None)


def solve_periodic(
    needs: Needs,
    rows: Rows = slice(None),
    *,
    tolerance: float,
    device: Device,
    keep_states: bool = False,
    report: Callable[[int], object] = lambda solved: None,
) -> Solutions:
    """The periodic state of each scene, or of those in ``rows``; see ``solver.solve``."""
    solutions = Solutions.of_method("periodic", len(needs))
    solutions.absent_terms[rows] = needs.absent_terms()[rows]
    refinement = Refinement(
        needs=needs,
        solutions=solutions,
        tolerance=tolerance,
        room=min(MOST_UNKNOWNS, device.memory_bytes // (8 * LEAST_FIELDS * MEMORY_PARTS)),
        keep_states=keep_states,
        change=np.full((2, len(needs)), np.nan),
        failures=np.zeros(len(needs), dtype=np.int64),
    )
    room, count = refinement.room, 0
    for group in first_grids(needs, rows, tolerance=tolerance, room=room, kept=keep_states):
        count += len(group.rows)
        if LEAST_ITERATIONS * iteration_flops(group.grids[-1], group.terms) > MOST_WORK:
            grid = group.grids[-1]
            refinement._write_grid(group.rows, grid)
            solutions.status[group.rows] = (
                f"{OVER_LIMIT} ({_size(grid)}){fewer_operations(group.terms)}"
            )
            report(len(group.rows))
            continue
        refinement.wait(group)
    size = min(max(-(-count // IN_FLIGHT), LEAST_BATCH), MOST_BATCH)
    flying: deque[tuple[list[Group], Launch]] = deque()
    with progress_of(count, unit="scene", name="periodic states") as progress:
        while refinement.waiting or flying:
            while refinement.waiting and len(flying) < IN_FLIGHT:
                groups = refinement.next_launch(most=size)
                batches = [refinement.batch(group) for group in groups]
                flying.append((groups, launch(batches, device=device)))
            groups, landing = flying.popleft()
            progress.doing = _size(groups[0].grids[-1])
            landed = zip(groups, landing.batches, landing.states(device), strict=True)
            finished = sum(refinement.accept_or_refine(*each) for each in landed)
            progress.update(finished)
            report(finished)
            # Other launches may have the arrays, as no one looks at the states any more.
            device.release(*landing.arrays)
    return solutions


def fewer_operations(terms: Terms) -> str:
    """Return what lets a scene be solved with fewer operations, for the end of its status."""
    dear = [term.label for term in terms if term.SPACE_PRODUCTS]
    return f"; take a larger tolerance{' or no ' if dear else ''}{' and '.join(dear)}"


def _size(grid: Grid) -> str:
    across, along = grid.across
    return f"{across} × {along} × {grid.nt} points"
