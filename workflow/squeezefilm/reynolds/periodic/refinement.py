"""The periodic method: grids are refined until each scene's force holds its tolerance."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from squeezefilm.film.scene import Scenes, rows_alike
from squeezefilm.reynolds.device import Device
from squeezefilm.reynolds.error_estimate import (
    ITERATION_SHARE,
    Change,
    change_of,
    error_text,
    estimate,
    least_fall_of,
    margin_of,
    step_between,
)
from squeezefilm.reynolds.grid import Grid, iteration_flops
from squeezefilm.reynolds.needs import Needs
from squeezefilm.reynolds.periodic.launch import STATUS, Batch, Launch, State, States, launch
from squeezefilm.reynolds.periodic.resolution import (
    MOST_UNKNOWNS,
    finer_grid,
    first_grids,
    least_fall,
    profile_fall,
)
from squeezefilm.reynolds.terms import Terms, size_share_of, states_refused, stiffness_of
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


@dataclass(frozen=True, eq=False)
class Group:
    """Scenes of like terms and finger shape that go through the same grids.

    Attributes:
        rows: which scenes they are, (k,).
        grids: those of the next launch; the change to the last tells its error.
        guess: states on the first of them, if they are known already, (k, fields, nx, ny, nt).
    """

    rows: np.ndarray
    grids: tuple[Grid, ...]
    terms: Terms
    aspect: float
    guess: np.ndarray | None = None

    @property
    def key(self) -> tuple[object, ...]:
        """Equal for groups that go together."""
        return self.grids, self.terms, self.aspect, self.guess is None

    @property
    def bytes(self) -> int:
        """Of a scene's states."""
        return 8 * sum(grid.count for grid in self.grids)

    def split(self, count: int) -> tuple[Group, Group]:
        """The first scenes, and the others."""
        first, rest = (
            Group(
                self.rows[part],
                self.grids,
                self.terms,
                self.aspect,
                None if self.guess is None else self.guess[part],
            )
            for part in (slice(count), slice(count, None))
        )
        return first, rest

    @staticmethod
    def joined(groups: Sequence[Group]) -> Group:
        """Groups of one key as one."""
        if len(groups) == 1:
            return groups[0]
        first = groups[0]
        guesses = [group.guess for group in groups if group.guess is not None]
        return Group(
            np.concatenate([group.rows for group in groups]),
            first.grids,
            first.terms,
            first.aspect,
            np.concatenate(guesses) if guesses else None,
        )


@dataclass(frozen=True, eq=False)
class Refinement:
    """Scenes on their way through the grids; columns of shape (n,).

    Attributes:
        change: the last change of the mean pressure; NaN where there is none.
        failures: times that Newton's method failed on the last grid.
    """

    needs: Needs
    solutions: Solutions
    tolerance: float
    room: float
    keep_states: bool
    change: Change
    failures: np.ndarray
    waiting: dict[tuple[object, ...], list[Group]] = field(default_factory=dict)

    def wait(self, group: Group) -> None:
        """Have scenes go on in one of the next launches."""
        self.waiting.setdefault(group.key, []).append(group)

    def begin(self) -> None:
        """Have each scene wait on its first grids."""
        needs = self.needs
        sequences, which = first_grids(
            needs, tolerance=self.tolerance, room=self.room, kept=self.keep_states
        )
        aspect = needs.scenes.aspect + np.zeros(len(needs))
        for rows in rows_alike(which * len(needs.kinds) + needs.kind + 1j * aspect):
            one = rows[0]
            grids, terms = sequences[which[one]], needs.kinds[needs.kind[one]]
            self.wait(Group(rows, grids, terms, float(aspect[one])))

    def next_launch(self, *, most: int) -> list[Group]:
        """Groups of like terms that fill a launch, those of the dearest grids first.

        So that no long solve is left over at the end.
        """
        chosen: list[Group] = []
        scenes, size = 0, 0
        for key in sorted(self.waiting, key=lambda key: -iteration_flops(key[0][-1])):  # type: ignore[index]
            group = Group.joined(self.waiting[key])
            room = max((LAUNCH_BYTES - size) // group.bytes, 0 if chosen else 1)
            count = min(most - scenes, room)
            if count <= 0 or (chosen and group.terms != chosen[0].terms):
                continue
            some, rest = group.split(count) if count < len(group.rows) else (group, None)
            if rest is None:
                del self.waiting[key]
            else:
                self.waiting[key] = [rest]
            chosen.append(some)
            scenes += len(some.rows)
            size += some.bytes * len(some.rows)
        return chosen

    def batch(self, group: Group) -> Batch:
        """What the device is to solve for a group."""
        share = LEFT_SHARE if margin_of(group.terms) == 1 else ITERATION_SHARE
        left = (KEPT if self.keep_states else 1.0) * share * self.tolerance
        starts = len(group.grids) - 2
        shares = [max(left, START_TOLERANCE)] * starts + [left] * min(len(group.grids), 2)
        if group.guess is not None:  # so that the finer grid does not take the state over as it is
            shares = [GOING_ON * left] * len(group.grids)
        scenes = self.needs.scenes
        if not np.array_equal(group.rows, np.arange(len(scenes))):
            scenes = scenes[group.rows]  # all of them know their numbers already
        return Batch(
            scenes,
            group.terms,
            group.grids,
            shares,
            guess=group.guess,
            every=self.keep_states,
        )

    def accept_or_refine(self, group: Group, batch: Batch, stages: Sequence[States]) -> int:
        """Write the solutions of scenes whose error is small enough, or that have no better one.

        The others wait for finer grids. Returns how many are finished.
        """
        rows, terms, grid = group.rows, group.terms, group.grids[-1]
        said, solutions = stages[-1].said, self.solutions
        self._add_work(group, stages)
        self._write(rows, grid, residual=said["residual"])
        error, allowed = self._errors(group, batch.scenes, said)
        finer = finer_grid(grid, room=self.room)
        open_ = np.ones(len(rows), dtype=bool)

        def finish(which: np.ndarray, status: Callable[[int], str]) -> None:
            for k in np.flatnonzero(which & open_).tolist():
                solutions.status[rows[k]] = status(k)
                open_[k] = False

        def too_large(k: int) -> str:
            return error_text(error[k], allowed=allowed[k], force=said["mean"][k])

        again = 0
        if any(each.said["status"].any() for each in stages[-2:]):
            failed = np.stack([each.said["status"] != 0 for each in stages[-2:]])
            begun = self._begin_again(group, failed[-1], finer)
            again = int(begun.sum())
            open_ &= ~begun
            hopeless = failed[-1] | (finer is None)
            for stage in range(-1, -1 - len(failed), -1):
                its, status = group.grids[stage], stages[stage].said["status"]
                self._write(rows[failed[stage] & hopeless & open_], its)
                finish(
                    failed[stage] & hopeless,
                    lambda k, its=its, status=status: f"{STATUS[status[k]]} ({_size(its)})",  # type: ignore[misc]
                )
            # What no coarser grid describes, a finer one may.
            unknown = failed.any(axis=0)
            error[unknown] = np.inf
            self.change.largest[rows[unknown]] = self.change.size[rows[unknown]] = np.nan
        negative = ~(said["lowest"] > 0)
        if negative.any():
            error[negative] = np.inf
            if finer is None:
                where = f"the pressure is not positive everywhere ({_size(grid)})"
                finish(negative, lambda k: where)
        if refused := states_refused(batch.scenes, terms, thinnest=said["thinnest"]):
            finish(np.isin(np.arange(len(rows)), list(refused)), lambda k: refused[k])
        good = np.flatnonzero((error <= allowed) & open_)
        open_[good] = False
        accepted, scale_n = rows[good], batch.scenes.force_scale_n
        solutions.status[accepted] = "ok"
        solutions.force_n[accepted] = (said["mean"] * scale_n)[good]
        solutions.force_error_n[accepted] = (error * scale_n)[good]
        if self.keep_states:
            for k in good.tolist():
                solutions.states[rows[k]] = _kept(group.grids, stages, k)
        if not open_.any():
            return len(rows) - again
        if finer is None:
            end = f"tolerance not reached on the finest grid ({_size(grid)})"
            finish(open_.copy(), lambda k: f"{end}: {too_large(k)}")
        most_work = min((term.MOST_WORK for term in terms), default=np.inf)
        end = f"tolerance not reached with bearable work ({_size(grid)})"
        finish(solutions.work[rows] > most_work, lambda k: f"{end}: {too_large(k)}")
        if finer and open_.any():
            guess = stages[-1].unknowns[open_]
            self.wait(Group(rows[open_], (grid, finer), terms, group.aspect, guess))
        return len(rows) - again - int(open_.sum())

    def _errors(
        self, group: Group, scenes: Scenes, said: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Errors of a group's mean overpressures, and how large they may be; keep the changes."""
        rows, grids, terms = group.rows, group.grids, group.terms
        coarse, fine = (grids[0], *grids)[-2:]
        alone = len(grids) == 1  # a single grid tells no error
        # A mass error w moves the pressure by about n w/H.
        per_residual = stiffness_of(scenes, terms) / scenes.narrowest
        of_profile = profile_fall(
            self.needs, coarse.across, fine.across, tolerance=self.tolerance, rows=rows
        )
        change, fall = change_of(
            said,
            known=self.change[rows],
            step=step_between(coarse, fine),
            sizes=size_share_of(scenes, terms),
            per_residual=per_residual,
            terms=terms,
            tolerance=self.tolerance,
        )
        falls = [fall, least_fall(scenes, coarse.across[0]), of_profile]
        found = estimate(
            change=None if alone else change.telling(of_profile),
            left=per_residual * said["residual"],
            largest=said["largest"],
            narrowest=scenes.narrowest,
            mean=said["mean"],
            tolerance=self.tolerance,
            fall=np.maximum(np.maximum.reduce(falls), least_fall_of(terms)),
            margin=margin_of(terms),
        )
        more = ~found.holds
        self.change.largest[rows[more]] = np.nan if alone else change.largest[more]
        self.change.size[rows[more]] = np.nan if alone else change.size[more]
        return found.error, found.allowed

    def _begin_again(self, group: Group, failed: np.ndarray, finer: Grid | None) -> np.ndarray:
        """Have scenes without a state on the last grid wait for finer ones, from rest."""
        again = finer_grid(finer, room=self.room) if finer else None
        which = failed & (self.failures[group.rows] < MOST_FAILURES)
        if finer is None or again is None or margin_of(group.terms) > 1:
            return np.zeros_like(failed)
        if which.any():
            rows = group.rows[which]
            self.wait(Group(rows, (finer, again), group.terms, group.aspect))
            self.failures[rows] += 1
            self.change.largest[rows] = self.change.size[rows] = np.nan
        return which

    def _add_work(self, group: Group, stages: Sequence[States]) -> None:
        """Count the work of a launch."""
        solutions, rows = self.solutions, group.rows
        for grid, states in zip(group.grids, stages, strict=True):
            newton, krylov = states.said["newton_steps"], states.said["krylov_iterations"]
            solutions.newton_steps[rows] += newton
            solutions.krylov_iterations[rows] += krylov
            solutions.work[rows] += iteration_flops(grid, group.terms) * (newton + krylov)

    def _write(self, rows: np.ndarray, grid: Grid, **columns: np.ndarray) -> None:
        """The grid that scenes have come to, and what is observed there."""
        nx, ny = grid.across
        for name, values in {"nx": nx, "ny": ny, "nt": grid.nt, **columns}.items():
            self.solutions.columns[name][rows] = values


def solve_periodic(
    needs: Needs,
    *,
    tolerance: float,
    device: Device,
    keep_states: bool = False,
    report: Callable[[int], object] = lambda solved: None,
) -> Solutions:
    """The periodic state of each scene; the arguments are those of ``solver.solve``."""
    count = len(needs)
    solutions = Solutions.of_method("periodic", count)
    solutions.left_out[:] = needs.left_out()
    refinement = Refinement(
        needs=needs,
        solutions=solutions,
        tolerance=tolerance,
        room=min(MOST_UNKNOWNS, device.memory_bytes // (8 * LEAST_FIELDS * MEMORY_PARTS)),
        keep_states=keep_states,
        change=Change(*np.full((2, count), np.nan)),
        failures=np.zeros(count, dtype=np.int64),
    )
    refinement.begin()
    size = min(max(-(-count // IN_FLIGHT), LEAST_BATCH), MOST_BATCH)
    flying: deque[tuple[list[Group], Launch]] = deque()
    while refinement.waiting or flying:
        while refinement.waiting and len(flying) < IN_FLIGHT:
            groups = refinement.next_launch(most=size)
            batches = [refinement.batch(group) for group in groups]
            flying.append((groups, launch(batches, device=device)))
        groups, landing = flying.popleft()
        landed = zip(groups, landing.batches, landing.states(), strict=True)
        report(sum(refinement.accept_or_refine(*each) for each in landed))
        landing.end()
    return solutions


def _kept(grids: Sequence[Grid], stages: Sequence[States], k: int) -> tuple[State, ...]:
    """A scene's states on the last two grids: copies, for the launch's arrays are used again."""
    last = zip(grids[-2:], stages[-2:], strict=True)
    return tuple(State(grid, states.unknowns[k].copy()) for grid, states in last)


def _size(grid: Grid) -> str:
    return f"{grid.x.full_points} × {grid.y.full_points} × {grid.nt} points"
