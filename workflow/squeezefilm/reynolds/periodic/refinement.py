"""The periodic method: grids are refined until each scene's force holds its tolerance."""

from __future__ import annotations

from collections import defaultdict, deque
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from squeezefilm.film.scene import Scene
from squeezefilm.io.solution import Solution
from squeezefilm.reynolds.device import Device
from squeezefilm.reynolds.error_estimate import (
    ITERATION_SHARE,
    Change,
    error_text,
    estimate,
)
from squeezefilm.reynolds.grid import Grid
from squeezefilm.reynolds.needs import Needs
from squeezefilm.reynolds.periodic.changes import (
    changes_of,
    how_many_tell,
    judged_from_coarser,
    least_fall_of,
    margin_of,
)
from squeezefilm.reynolds.periodic.first_grids import first_grids
from squeezefilm.reynolds.periodic.launch import STATUS, Batch, Launch, States, launch
from squeezefilm.reynolds.periodic.resolution import (
    MOST_UNKNOWNS,
    finer_grid,
    least_fall,
    nodes_for_profile,
    profile_fall,
    up_to,
)
from squeezefilm.reynolds.periodic.sizes import iteration_flops
from squeezefilm.reynolds.problems import problems_on
from squeezefilm.reynolds.terms import size_share_of, state_refused, stiffness_of

# Relative error of the force that the iteration may leave on a grid that only starts the next.
START_TOLERANCE = 1e-3
# Share of the allowed error that the iteration may leave where the estimate counts it once; and of
# that on grids that differ in time alone, or that go on from a known state.
LEFT_SHARE = 0.5
TIMELY = 0.04
# Share of the allowed error up to which that in time is left as it is.
TIME_SHARE = 0.3
# Times that a scene is begun again on finer grids, as Newton's method fails on the finest.
MOST_FAILURES = 3
# Launches under way at a time: the host judges one while the device is at the other.
IN_FLIGHT = 2
# Scenes begun together.
LEAST_BATCH, MOST_BATCH = 16, 128
# States of one launch; more go into several.
LAUNCH_BYTES = 256 * 2**20
# Fields of a grid that a work-group needs at least, and the part of the device's memory, one in so
# many, that they may take: devices give no more in one piece.
LEAST_FIELDS = 36
MEMORY_PARTS = 4


@dataclass
class _Progress:
    """A scene on its way through the grids.

    Attributes:
        grids: those of the next launch; the last ones tell the error.
        state: the unknowns on the first of them, if they are known already.
        change: the last change of the mean pressure, if there is one.
        in_time: error in time, where the last change does not show it.
        failures: times that Newton's method failed on the last grid.
    """

    index: int
    scene: Scene
    needs: Needs
    grids: tuple[Grid, ...]
    state: np.ndarray | None = None
    change: Change | None = None
    in_time: float = 0.0
    failures: int = 0
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
    room = min(MOST_UNKNOWNS, device.memory_bytes // (8 * LEAST_FIELDS * MEMORY_PARTS))
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
            fly(
                _begun(i, scenes[i], needs[i], tolerance=tolerance, room=room)
                for i in range(start, stop)
            )
        if not flying:
            break
        groups, landing = flying.popleft()
        unfinished = []
        for group, stages in zip(groups, landing.states(), strict=True):
            judged = _judge(group, stages, tolerance=tolerance, room=room)
            for progress, solution in zip(group, judged, strict=True):
                if solution is None:
                    unfinished.append(progress)
                else:
                    solutions[progress.index] = solution
                    report(1)
        landing.end()
        fly(unfinished)
    return [solutions[index] for index in range(len(scenes))]


def _begun(index: int, scene: Scene, needs: Needs, *, tolerance: float, room: float) -> _Progress:
    grids = first_grids(scene, needs, tolerance=tolerance, room=room)
    return _Progress(index=index, scene=scene, needs=needs, grids=grids)


def _launches(waiting: Iterable[_Progress]) -> Iterable[list[list[_Progress]]]:
    """Scenes of the same grids and finger shape in groups, groups of like terms in launches.

    The dearest grids come first, so that no long solve is left over at the end.
    """
    launches: list[dict[object, list[_Progress]]] = []
    current: dict[object, dict[object, list[_Progress]]] = {}
    filled: dict[object, int] = {}
    for progress in sorted(waiting, key=lambda progress: -iteration_flops(progress.grids[-1])):
        needs = progress.needs
        terms = needs.terms
        size = 8 * sum(grid.count for grid in progress.grids)
        if terms not in current or filled[terms] + size > LAUNCH_BYTES:
            current[terms], filled[terms] = defaultdict(list), 0
            launches.append(current[terms])
        filled[terms] += size
        alike = (progress.grids, progress.state is None, progress.scene.aspect)
        current[terms][alike].append(progress)
    return [list(groups.values()) for groups in launches]


def _batch_of(group: Sequence[_Progress], *, tolerance: float) -> Batch:
    scenes = [progress.scene for progress in group]
    grids = group[0].grids
    share = LEFT_SHARE if margin_of(group[0].needs.terms) == 1 else ITERATION_SHARE
    left = share * tolerance
    telling = how_many_tell(grids)
    shares = [max(left, START_TOLERANCE)] * (len(grids) - telling) + [left] * telling
    if telling > 2:  # so that it does not hide the error in time
        shares[-telling] = shares[-telling + 1] = TIMELY * left
    known = [progress.state for progress in group if progress.state is not None]
    if known:  # so that the finer grid does not take the state over as it is
        shares = [TIMELY * left] * len(grids)
    tolerances = dict(zip(grids, shares, strict=True))
    problems = problems_on(scenes, tolerances, terms=group[0].needs.terms)
    guess = np.stack(known) if known else None
    return Batch(grids=grids, problems=problems, guess=guess, every=False)


def _judge(
    group: Sequence[_Progress], stages: Sequence[States], *, tolerance: float, room: float
) -> list[Solution | None]:
    """Each scene's solution if its error is known to be small enough, else None: a finer grid."""
    grids, states = group[0].grids, stages[-1]
    narrowest = np.array([progress.scene.narrowest for progress in group])
    terms = group[0].needs.terms
    # A mass error w moves the pressure by about n w/H.
    stiffness = [stiffness_of(each.scene, terms) for each in group] if terms else [1.0]
    per_residual = stiffness / narrowest
    change, fall, in_time = changes_of(
        grids,
        stages,
        known=[progress.change for progress in group],
        in_time=np.array([progress.in_time for progress in group]),
        sizes=np.array([size_share_of(each.scene, terms) if terms else 0.0 for each in group]),
        least_falls=np.array([least_fall(each.scene) for each in group]),
        per_residual=per_residual,
        terms=terms,
        tolerance=tolerance,
    )
    across = [grid.across for grid in (grids[0], *grids)[-2:]]
    falls = [profile_fall(each.needs, *across, tolerance=tolerance) for each in group]
    of_profile = np.array(falls)
    found = estimate(
        change=change.telling(of_profile) if change else None,
        left=per_residual * states.residual + in_time,
        largest=states.largest,
        narrowest=narrowest,
        mean=states.mean,
        tolerance=tolerance,
        fall=np.maximum(np.maximum(fall, of_profile), least_fall_of(terms)),
        margin=margin_of(terms),
    )
    for at in np.flatnonzero(~found.holds).tolist():
        group[at].change, group[at].in_time = change and change[at], float(in_time[at])
    finer = finer_grid(grids[-1], room=room)
    _add_work(group, stages)
    failed = np.array([each.status != 0 for each in stages[-how_many_tell(grids) :]]).T
    of_states = states.mean, states.lowest, states.thinnest, states.residual
    # As plain numbers: entries of arrays are slow to take one by one.
    told = failed, found.error, found.allowed, *of_states
    return [
        _judge_scene(
            progress, stages, position, _Told(*its), finer=finer, tolerance=tolerance, room=room
        )
        for position, (progress, *its) in enumerate(
            zip(group, *(each.tolist() for each in told), strict=True)
        )
    ]


def _add_work(group: Sequence[_Progress], stages: Sequence[States]) -> None:
    """To each scene's progress the work of a launch."""
    newton = np.array([each.newton_steps for each in stages])
    krylov = np.array([each.krylov_iterations for each in stages])
    terms = group[0].needs.terms
    flops = np.array([iteration_flops(grid, terms) for grid in group[0].grids])
    work = flops @ (newton + krylov)
    sums = (newton.sum(axis=0).tolist(), krylov.sum(axis=0).tolist(), work.tolist())
    for progress, its_newton, its_krylov, its_work in zip(group, *sums, strict=True):
        progress.newton_steps += its_newton
        progress.krylov_iterations += its_krylov
        progress.work += its_work


class _Told(NamedTuple):
    """What is known of a scene after a launch; all but ``failed`` on the last grid.

    Attributes:
        failed: whether there is no state, on each of the grids that tell the error.
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
    progress: _Progress,
    stages: Sequence[States],
    position: int,
    told: _Told,
    *,
    finer: Grid | None,
    tolerance: float,
    room: float,
) -> Solution | None:
    scene, grid = progress.scene, progress.grids[-1]
    failed, error, allowed, force = told.failed, told.error, told.allowed, told.mean

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
            residual=told.residual,
            work=progress.work,
        )

    if failed[-1] and finer and _begun_again(progress, finer, tolerance=tolerance, room=room):
        return None
    if failed[-1] or (any(failed) and finer is None):
        at = -1 - failed[::-1].index(True)
        its_grid, ending = progress.grids[at], stages[at].status[position]
        return finished(status=f"{STATUS[ending]} ({_size(its_grid)})", grid=its_grid)
    if any(failed):  # what no coarser grid describes, a finer one may
        error, progress.change = np.inf, None
    if not told.lowest > 0:
        if finer is None:
            return finished(status=f"the pressure is not positive everywhere ({_size(grid)})")
        error = np.inf
    if refused := state_refused(scene, progress.needs.terms, thinnest=told.thinnest):
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
    if TIME_SHARE * allowed > progress.in_time > 0:
        finer = replace(finer, nt=grid.nt)
    elif progress.change:
        progress.change, progress.in_time = progress.change + progress.in_time, 0.0
    progress.grids, progress.state = (grid, finer), stages[-1].unknowns[position].copy()
    return None


def _begun_again(progress: _Progress, finer: Grid, *, tolerance: float, room: float) -> bool:
    """Whether a scene that has no state on a grid is to be tried on finer ones, from rest."""
    again = finer_grid(finer, room=room)
    if margin_of(progress.needs.terms) > 1 or again is None or progress.failures == MOST_FAILURES:
        return False
    judged = judged_from_coarser(progress.needs.terms, tolerance=tolerance)
    seen = nodes_for_profile(progress.needs, tolerance=tolerance)
    grids = up_to(again, seen) if judged else ()
    progress.grids = grids or (finer, again)
    progress.state, progress.change, progress.in_time = None, None, 0.0
    progress.failures += 1
    return True


def _size(grid: Grid) -> str:
    return f"{grid.x.full_points} × {grid.y.full_points} × {grid.nt} points"
