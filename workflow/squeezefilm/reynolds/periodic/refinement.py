"""The periodic method: grids are refined until each scene's force holds its tolerance."""

from __future__ import annotations

from collections import defaultdict, deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from squeezefilm.film.scene import Scene
from squeezefilm.io.solution import Solution
from squeezefilm.reynolds.device import Device
from squeezefilm.reynolds.error_estimate import ITERATION_SHARE, margin_of
from squeezefilm.reynolds.needs import Needs
from squeezefilm.reynolds.periodic.judging import Landed, Progress, judge, judged_alike
from squeezefilm.reynolds.periodic.launch import Batch, Launch, launch
from squeezefilm.reynolds.periodic.resolution import MOST_UNKNOWNS, first_grids
from squeezefilm.reynolds.periodic.sizes import iteration_flops
from squeezefilm.reynolds.periodic.states import State
from squeezefilm.reynolds.problems import problems_on
from squeezefilm.reynolds.terms import Terms

# Relative error of the force that the iteration may leave on a grid that only starts the next.
START_TOLERANCE = 1e-2
# Share of the allowed error that the iteration may leave where the estimate counts it once; and of
# that on grids that go on from a known state.
LEFT_SHARE = 0.5
GOING_ON = 0.04
# And of that where states are kept, so that a quantity's change from grid to grid shows the grids'
# error alone.
KEPT = 0.04
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


def solve_periodic(
    scenes: Sequence[Scene],
    needs: Sequence[Needs],
    *,
    tolerance: float,
    device: Device,
    keep_states: bool = False,
    report: Callable[[int], object] = lambda solved: None,
) -> list[Solution]:
    """The periodic state of each scene; the arguments are those of ``solver.solve``."""
    solutions: dict[int, Solution] = {}
    room = min(MOST_UNKNOWNS, device.memory_bytes // (8 * LEAST_FIELDS * MEMORY_PARTS))
    size = min(max(-(-len(scenes) // IN_FLIGHT), LEAST_BATCH), MOST_BATCH)
    starts = iter(range(0, len(scenes), IN_FLIGHT * size))
    flying: deque[tuple[list[list[Progress]], Launch]] = deque()

    def fly(waiting: Iterable[Progress]) -> None:
        for groups in _launches(waiting, most=size):
            batches = [
                _batch_of(group, tolerance=tolerance, keep_states=keep_states) for group in groups
            ]
            flying.append((groups, launch(batches, device=device)))

    while True:
        while len(flying) < IN_FLIGHT and (start := next(starts, None)) is not None:
            stop = min(start + IN_FLIGHT * size, len(scenes))
            fly(
                _begun(i, scenes[i], needs[i], tolerance=tolerance, room=room, kept=keep_states)
                for i in range(start, stop)
            )
        if not flying:
            break
        groups, landing = flying.popleft()
        unfinished = []
        for landed in judged_alike(groups, landing.states()):
            states = [kept for batch in landed for kept in _last_two(batch)] if keep_states else []
            judged = judge(landed, tolerance=tolerance, room=room)
            for place, (progress, solution) in enumerate(judged):
                if solution is None:
                    unfinished.append(progress)
                else:
                    if keep_states and solution.status == "ok":
                        solution.states = states[place]
                    solutions[progress.index] = solution
                    report(1)
        landing.end()
        fly(unfinished)
    return [solutions[index] for index in range(len(scenes))]


def _last_two(batch: Landed) -> Iterator[tuple[State, ...]]:
    """Each scene's states on the last two grids: copies, for the launch's arrays are used again."""
    last = list(zip(batch.grids[-2:], batch.stages[-2:], strict=True))
    for k in range(len(batch.group)):
        yield tuple(State(grid, states.unknowns[k].copy()) for grid, states in last)


def _begun(
    index: int, scene: Scene, needs: Needs, *, tolerance: float, room: float, kept: bool
) -> Progress:
    grids = first_grids(scene, needs, tolerance=tolerance, room=room, kept=kept)
    return Progress(index=index, scene=scene, needs=needs, grids=grids)


def _launches(waiting: Iterable[Progress], *, most: int) -> Iterable[list[list[Progress]]]:
    """Scenes of the same grids and finger shape in groups, groups of like terms in launches.

    The dearest grids come first, so that no long solve is left over at the end.

    Args:
        most: scenes of a launch.
    """
    alike: dict[object, list[Progress]] = defaultdict(list)
    for progress in waiting:
        kind = progress.grids, progress.state is None, progress.scene.aspect, progress.needs.terms
        alike[kind].append(progress)
    launches: list[list[list[Progress]]] = []
    current: dict[Terms, _Filled] = {}
    for group in sorted(alike.values(), key=lambda group: -iteration_flops(group[0].grids[-1])):
        terms = group[0].needs.terms
        size = 8 * sum(grid.count for grid in group[0].grids)
        while group:
            filled = current.get(terms)
            if filled is None or filled.scenes == most or filled.size + size > LAUNCH_BYTES:
                filled = current[terms] = _Filled([])
                launches.append(filled.groups)
            room = max((LAUNCH_BYTES - filled.size) // size, 1)
            some = group[: min(most - filled.scenes, room)]
            filled.groups.append(some)
            filled.scenes += len(some)
            filled.size += size * len(some)
            group = group[len(some) :]
    return launches


@dataclass
class _Filled:
    """A launch that is being put together: its groups, the scenes in it, and their states' size."""

    groups: list[list[Progress]]
    scenes: int = 0
    size: int = 0


def _batch_of(group: Sequence[Progress], *, tolerance: float, keep_states: bool) -> Batch:
    scenes = [progress.scene for progress in group]
    grids = group[0].grids
    share = LEFT_SHARE if margin_of(group[0].needs.terms) == 1 else ITERATION_SHARE
    left = (KEPT if keep_states else 1.0) * share * tolerance
    shares = [max(left, START_TOLERANCE)] * (len(grids) - 2) + [left] * min(len(grids), 2)
    known = [progress.state for progress in group if progress.state is not None]
    if known:  # so that the finer grid does not take the state over as it is
        shares = [GOING_ON * left] * len(grids)
    tolerances = dict(zip(grids, shares, strict=True))
    problems = problems_on(scenes, tolerances, terms=group[0].needs.terms)
    guess = np.stack(known) if known else None
    return Batch(grids=grids, problems=problems, guess=guess, every=keep_states)
