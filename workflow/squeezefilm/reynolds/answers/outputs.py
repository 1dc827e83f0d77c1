"""Answers beside the mean force, from the periodic state, each with an error: docs/outputs.md.

The state is solved on two grids or more, and an answer's error is what its change between the last
two leaves, as a force's is; no answer is taken to be better than a share of what others say.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from math import isfinite

import numpy as np

from squeezefilm.film.scene import Scene, Scenes
from squeezefilm.io.errors import each_on_its_own, unexpected
from squeezefilm.io.solution import OUTPUTS, Outputs, Solution, checked_outputs
from squeezefilm.reynolds.answers.numbers import answered
from squeezefilm.reynolds.answers.refused import formula_refusals
from squeezefilm.reynolds.answers.samples import on_grid
from squeezefilm.reynolds.answers.stiffness import static_stiffness
from squeezefilm.reynolds.device import Device, choose_device
from squeezefilm.reynolds.effects.automatic import MODEL_TOLERANCE, decided
from squeezefilm.reynolds.error_estimate import UNKNOWN_FALL, left_after, margin_of
from squeezefilm.reynolds.grid import Grid
from squeezefilm.reynolds.needs import Needs, needs_of
from squeezefilm.reynolds.periodic.launch import Batch, launch
from squeezefilm.reynolds.periodic.resolution import finer_grid, grid_for, profile_fall
from squeezefilm.reynolds.periodic.sizes import iteration_flops
from squeezefilm.reynolds.periodic.states import STATUS, States
from squeezefilm.reynolds.plan import plans_of
from squeezefilm.reynolds.self_test import check_device
from squeezefilm.reynolds.terms import states_refused, stiffness_of

# Below this, iterations would end in rounding; above, grids tell little of their errors.
LEAST_TOLERANCE, MOST_TOLERANCE = 1e-8, 1e-2
# Share of the tolerance that the iteration may leave.
LEFT_SHARE = 0.02
# Operations of a scene's iterations beyond which no finer grid is tried, unknowns of a state that
# the host has room for, and pairs of grids.
MOST_WORK, MOST_UNKNOWNS = 1e11, 2_000_000
MOST_PAIRS = 8
# States fetched at a time.
MOST_TOGETHER = 2**21
FROM_STATE = frozenset(OUTPUTS) - {"static_stiffness"}
NO_STATE = "no periodic state was found"
COARSE = "no two grids were found that tell the error"


@dataclass
class _Progress:
    """A scene on its way through the grids.

    Attributes:
        grid: the next one; the answers' errors are told by the one after it.
        guess: the unknowns on it, if they are known already.
        best: the answers so far, whose errors are above the tolerance.
    """

    index: int
    scene: Scene
    needs: Needs
    grid: Grid
    guess: np.ndarray | None = None
    best: Outputs | None = None
    work: float = 0.0
    pairs: int = 0


def with_outputs(
    scenes: Sequence[Scene],
    solutions: Sequence[Solution],
    *,
    outputs: Sequence[str],
    tolerance: float,
    model_tolerance: float = MODEL_TOLERANCE,
    method: str = "auto",
    device: Device | None = None,
) -> list[Solution]:
    """The scenes' forces, as ``solve`` gave them with the same arguments, with answers beside them.

    They are those of the periodic state, by whichever method its force was found. Nothing is
    solved where no output is asked for.
    """
    if not outputs:
        return list(solutions)
    asked = checked_outputs(outputs)
    chosen = device or choose_device()
    scenes = decided(scenes, model_tolerance=model_tolerance, method=method, device=chosen)
    known = [k for k, solution in enumerate(solutions) if isfinite(solution.force_n)]
    some = [scenes[k] for k in known]
    found = [Outputs(refused=dict.fromkeys(OUTPUTS, "no force"))] * len(scenes)
    parts: Sequence[Outputs] = [Outputs()] * len(some)
    if FROM_STATE & set(asked):
        parts = each_on_its_own(
            partial(_from_states, tolerance=_tolerated(tolerance), device=chosen),
            some,
            failed=lambda error: _refused(unexpected(error)),
        )
    if "static_stiffness" in asked:
        forces = [solutions[k] for k in known]
        more = static_stiffness(some, forces, tolerance=tolerance, device=chosen)
        parts = [one.beside(other) for one, other in zip(parts, more, strict=True)]
    for k, part in zip(known, parts, strict=True):
        found[k] = part
    return [
        replace(solution, outputs=each.only(asked))
        for solution, each in zip(solutions, found, strict=True)
    ]


def refusals(scene: Scene, *, tolerance: float) -> dict[str, str]:
    """Why outputs will be missing, or parts of them, as far as that is known before solving.

    By their names in OUTPUTS. Inertia must be decided.
    """
    plans = plans_of(needs_of(scene), tolerance=_tolerated(tolerance), method="periodic")
    return dict.fromkeys(OUTPUTS, plans[0].refused) if plans else formula_refusals(scene)


def _tolerated(tolerance: float) -> float:
    return min(max(tolerance, LEAST_TOLERANCE), MOST_TOLERANCE)


def _refused(reason: str) -> Outputs:
    return Outputs(refused=dict.fromkeys(FROM_STATE, reason))


def _from_states(scenes: Sequence[Scene], *, tolerance: float, device: Device) -> list[Outputs]:
    """All answers that follow from a periodic state, or why there are none."""
    found: dict[int, Outputs] = {}
    waiting: list[_Progress] = []
    plans = plans_of(needs_of(scenes), tolerance=tolerance, method="periodic")
    for index, scene in enumerate(scenes):
        need = needs_of(scene)
        if index in plans:
            found[index] = _refused(plans[index].refused)
        else:
            (first,) = grid_for(need, tolerance=tolerance)
            waiting.append(_Progress(index, scene, need, first))
    if waiting and not device.processor:
        check_device(device)
    while waiting:
        further: list[_Progress] = []
        for group, grids in _groups(waiting):
            for progress, output in zip(
                group, _solved(group, grids, tolerance=tolerance, device=device), strict=True
            ):
                if output is None:
                    further.append(progress)
                else:
                    found[progress.index] = output
        waiting = further
    return [found[index] for index in range(len(scenes))]


def _groups(
    waiting: Sequence[_Progress],
) -> Iterator[tuple[list[_Progress], tuple[Grid, ...]]]:
    """Scenes that go in one launch: of like terms, pads and grids, and no more than fit."""
    alike: dict[object, list[_Progress]] = defaultdict(list)
    for each in waiting:
        key = (each.needs.terms, each.grid, each.guess is None, each.scene.aspect)
        alike[key].append(each)
    for group in alike.values():
        grid = group[0].grid
        finer = finer_grid(grid, room=MOST_UNKNOWNS)
        grids = (grid, finer) if finer else (grid,)
        step = max(1, MOST_TOGETHER // grids[-1].count)
        for start in range(0, len(group), step):
            yield group[start : start + step], grids


def _solved(
    group: Sequence[_Progress], grids: tuple[Grid, ...], *, tolerance: float, device: Device
) -> list[Outputs | None]:
    """The answers of some scenes by two grids; None where two finer ones are to be tried."""
    if len(grids) < 2:
        return [each.best or _refused(COARSE) for each in group]
    scenes = [each.scene for each in group]
    known = [each.guess for each in group if each.guess is not None]
    guess = np.stack(known) if known else None
    left = [LEFT_SHARE * tolerance] * len(grids)
    batch = Batch(Scenes.of(scenes), group[0].needs.terms, grids, left, guess)
    (states,) = launch([batch], device=device).states()
    return [_one(each, grids, states, k, tolerance=tolerance) for k, each in enumerate(group)]


def _one(
    progress: _Progress,
    grids: tuple[Grid, ...],
    states: Sequence[States],
    k: int,
    *,
    tolerance: float,
) -> Outputs | None:
    scene, terms, (coarse, fine) = progress.scene, progress.needs.terms, grids
    progress.grid = fine
    for grid, state in zip(grids, states, strict=True):
        progress.work += float(state.krylov_iterations[k]) * iteration_flops(grid, terms)
    ending = [STATUS[state.status[k]] for state in states]
    progress.pairs += 1
    tried_enough = progress.work > MOST_WORK or progress.pairs == MOST_PAIRS
    if ending[-1] != "ok" or not states[-1].lowest[k] > 0:
        progress.guess = None
        return (progress.best or _refused(NO_STATE)) if tried_enough else None
    progress.guess = states[-1].unknowns[k].copy()
    if ending[0] != "ok":
        return (progress.best or _refused(COARSE)) if tried_enough else None
    thinnest = states[-1].thinnest[[k]]
    if refused := states_refused(progress.needs.scenes, terms, thinnest=thinnest):
        return _refused(refused[0])
    before, film = (
        on_grid(scene, grid, state.unknowns[k]) for grid, state in zip(grids, states, strict=True)
    )
    (of_profile,) = profile_fall(progress.needs, coarse.across, fine.across, tolerance=tolerance)
    fall = max(UNKNOWN_FALL, of_profile)
    # A mass error w moves the pressure by about n w/H.
    residual = float(states[-1].residual[k]) / (1 - scene.closure())
    found = answered(
        before,
        film,
        factor=float(margin_of(terms) * left_after(fall)),
        left=stiffness_of(scene, terms) * residual,
        tolerance=tolerance,
    )
    progress.best = found.outputs
    return found.outputs if found.holds or tried_enough else None
