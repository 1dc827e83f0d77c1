"""Whether scenes' errors are small enough after a launch, and if not, on which grids they go on."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from squeezefilm.film.scene import Scene
from squeezefilm.io.solution import Solution
from squeezefilm.reynolds.error_estimate import (
    Change,
    change_of,
    error_text,
    estimate,
    least_fall_of,
    margin_of,
    step_between,
)
from squeezefilm.reynolds.grid import Grid
from squeezefilm.reynolds.needs import Needs
from squeezefilm.reynolds.periodic.resolution import finer_grid, least_fall, profile_fall
from squeezefilm.reynolds.periodic.sizes import iteration_flops
from squeezefilm.reynolds.periodic.states import STATUS, States
from squeezefilm.reynolds.terms import size_share_of, state_refused, stiffness_of

# Times that a scene is begun again on finer grids, as Newton's method fails on the finest.
MOST_FAILURES = 3


@dataclass(slots=True)
class Progress:
    """A scene on its way through the grids.

    Attributes:
        grids: those of the next launch; the change to the last tells its error.
        state: the unknowns on the first of them, if they are known already.
        change: the last change of the mean pressure, if there is one.
        failures: times that Newton's method failed on the last grid.
    """

    index: int
    scene: Scene
    needs: Needs
    grids: tuple[Grid, ...]
    state: np.ndarray | None = None
    change: Change | None = None
    failures: int = 0
    newton_steps: int = 0
    krylov_iterations: int = 0
    work: float = 0.0


class Landed(NamedTuple):
    """Scenes of the same grids back from the device, and their states on each of these."""

    group: Sequence[Progress]
    stages: Sequence[States]

    @property
    def grids(self) -> tuple[Grid, ...]:
        return self.group[0].grids

    @property
    def last_two(self) -> tuple[Grid, Grid]:
        """The grids between which the last change was; the only one twice."""
        return (self.grids[0], *self.grids)[-2], self.grids[-1]


def judged_alike(
    groups: Sequence[Sequence[Progress]], states: Sequence[Sequence[States]]
) -> Iterable[list[Landed]]:
    """The groups of a launch, those together that were on as many grids."""
    alike: dict[int, list[Landed]] = defaultdict(list)
    for landed in map(Landed, groups, states):
        alike[len(landed.grids)].append(landed)
    return alike.values()


def judge(
    groups: Sequence[Landed], *, tolerance: float, room: float
) -> Iterable[tuple[Progress, Solution | None]]:
    """Each scene's solution if its error is known to be small enough, else None: a finer grid."""
    each_scene = [progress for group, _ in groups for progress in group]
    counts = [len(group) for group, _ in groups]
    stages = [_said(same) for same in zip(*(stages for _, stages in groups), strict=True)]
    said, terms = stages[-1], each_scene[0].needs.terms
    narrowest = np.array([progress.scene.narrowest for progress in each_scene])
    # A mass error w moves the pressure by about n w/H.
    stiffness = [stiffness_of(each.scene, terms) for each in each_scene] if terms else [1.0]
    per_residual = stiffness / narrowest
    least_falls, of_profile = _slow_falls(groups, tolerance=tolerance)
    change, fall = change_of(
        said,
        known=[progress.change for progress in each_scene],
        steps=np.repeat([step_between(*landed.last_two) for landed in groups], counts),
        sizes=np.array([size_share_of(each.scene, terms) if terms else 0.0 for each in each_scene]),
        per_residual=per_residual,
        terms=terms,
        tolerance=tolerance,
    )
    alone = len(stages) == 1  # a single grid tells no error
    fall = np.maximum.reduce([fall, least_falls, of_profile])
    found = estimate(
        change=None if alone else change.telling(of_profile),
        left=per_residual * said["residual"],
        largest=said["largest"],
        narrowest=narrowest,
        mean=said["mean"],
        tolerance=tolerance,
        fall=np.maximum(fall, least_fall_of(terms)),
        margin=margin_of(terms),
    )
    for at in np.flatnonzero(~found.holds).tolist():
        each_scene[at].change = None if alone else change[at]
    _add_work(groups, stages)
    failed = np.array([each["status"] != 0 for each in stages[-2:]]).T
    of_states = (said[name] for name in ("mean", "lowest", "thinnest", "residual"))
    # As plain numbers: entries of arrays are slow to take one by one.
    outcomes = (each.tolist() for each in (failed, found.error, found.allowed, *of_states))
    outcome = map(_Outcome, *outcomes)
    for group, states in groups:
        finer = finer_grid(group[0].grids[-1], room=room)
        for position, (progress, its) in enumerate(zip(group, outcome, strict=False)):
            solution = _judge_scene(
                progress, states, position, its, finer=finer, tolerance=tolerance, room=room
            )
            yield progress, solution


def _said(states: Sequence[States]) -> np.ndarray:
    """What is said of several groups of scenes, in rows of one array."""
    # As plain numbers: NumPy is slow to find that structured types are the same.
    rows = np.concatenate([each.said[:, None].view(np.int64) for each in states])
    return rows.view(states[0].said.dtype)[:, 0]


def _slow_falls(groups: Sequence[Landed], *, tolerance: float) -> tuple[np.ndarray, np.ndarray]:
    """By which factors the scenes' changes fall at most: those of thin layers, of the profiles."""
    of_layers, of_profiles = [], []
    for landed in groups:
        coarse, fine = (grid.across for grid in landed.last_two)
        for each in landed.group:
            of_layers.append(least_fall(each.scene, coarse[0]))
            of_profiles.append(profile_fall(each.needs, coarse, fine, tolerance=tolerance))
    return np.array(of_layers), np.array(of_profiles)


def _add_work(groups: Sequence[Landed], stages: Sequence[np.ndarray]) -> None:
    """To each scene's progress the work of a launch."""
    newton = np.array([said["newton_steps"] for said in stages])
    krylov = np.array([said["krylov_iterations"] for said in stages])
    terms = groups[0].group[0].needs.terms
    flops = [[iteration_flops(grid, terms) for grid in landed.grids] for landed in groups]
    each_scene = np.repeat(flops, [len(group) for group, _ in groups], axis=0).T
    work = each_scene * (newton + krylov)
    sums = (each.sum(axis=0).tolist() for each in (newton, krylov, work))
    scenes = (progress for group, _ in groups for progress in group)
    for progress, its_newton, its_krylov, its_work in zip(scenes, *sums, strict=True):
        progress.newton_steps += its_newton
        progress.krylov_iterations += its_krylov
        progress.work += its_work


class _Outcome(NamedTuple):
    """What is known of a scene after a launch; all but ``failed`` on the last grid.

    Attributes:
        failed: whether there is no state, on each of the last two grids.
        error, allowed: of the mean overpressure.
        mean, lowest, thinnest, residual: as in ``States``.
    """

    failed: list[bool]
    error: float
    allowed: float
    mean: float
    lowest: float
    thinnest: float
    residual: float


def _judge_scene(
    progress: Progress,
    stages: Sequence[States],
    position: int,
    outcome: _Outcome,
    *,
    finer: Grid | None,
    tolerance: float,
    room: float,
) -> Solution | None:
    scene, grid = progress.scene, progress.grids[-1]
    failed, error, allowed, force = outcome.failed, outcome.error, outcome.allowed, outcome.mean

    def finished(
        *, status: str, grid: Grid = grid, mean: float = np.nan, error: float = np.nan
    ) -> Solution:
        scale_n = scene.force_scale_n
        return Solution(
            force_n=mean * scale_n,
            force_error_n=error * scale_n,
            left_out=progress.needs.left_out,
            status=status,
            method="periodic",
            nx=grid.across[0],
            ny=grid.across[1],
            nt=grid.nt,
            newton_steps=progress.newton_steps,
            krylov_iterations=progress.krylov_iterations,
            residual=outcome.residual,
            work=progress.work,
        )

    if failed[-1] and finer and _begun_again(progress, finer, room=room):
        return None
    if failed[-1] or (any(failed) and finer is None):
        at = -1 - failed[::-1].index(True)
        its_grid, ending = progress.grids[at], stages[at].status[position]
        return finished(status=f"{STATUS[ending]} ({_size(its_grid)})", grid=its_grid)
    if any(failed):  # what no coarser grid describes, a finer one may
        error, progress.change = np.inf, None
    if not outcome.lowest > 0:
        if finer is None:
            return finished(status=f"the pressure is not positive everywhere ({_size(grid)})")
        error = np.inf
    if refused := state_refused(scene, progress.needs.terms, thinnest=outcome.thinnest):
        return finished(status=refused)
    if error <= allowed:
        return finished(status="ok", mean=force, error=error)
    if finer is None:
        reason = error_text(error, allowed=allowed, force=force)
        return finished(
            status=f"tolerance not reached on the finest grid ({_size(grid)}): {reason}"
        )
    if progress.work > min((term.MOST_WORK for term in progress.needs.terms), default=np.inf):
        reason = error_text(error, allowed=allowed, force=force)
        return finished(
            status=f"tolerance not reached with bearable work ({_size(grid)}): {reason}"
        )
    progress.grids, progress.state = (grid, finer), stages[-1].unknowns[position].copy()
    return None


def _begun_again(progress: Progress, finer: Grid, *, room: float) -> bool:
    """Whether a scene that has no state on a grid is to be tried on finer ones, from rest."""
    again = finer_grid(finer, room=room)
    if margin_of(progress.needs.terms) > 1 or again is None or progress.failures == MOST_FAILURES:
        return False
    progress.grids, progress.state, progress.change = (finer, again), None, None
    progress.failures += 1
    return True


def _size(grid: Grid) -> str:
    return f"{grid.x.full_points} × {grid.y.full_points} × {grid.nt} points"
