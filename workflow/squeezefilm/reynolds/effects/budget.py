"""The budget of a force: what the film equation leaves out, effect by effect, in per cent of it.

Every effect is taken at first order about the state of the scene's own equation on a coarse grid:
one adjoint solve tells what any source of mass does to the mean force (sensitivity.py), and the
effects are such sources. Only sliding asks for more states. An effect is good to about a fiftieth
of itself as a first order; what that misses is said beside it.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from math import isfinite, isnan, nan
from typing import Any, NamedTuple

import numpy as np

from squeezefilm.film.finger import GapShape
from squeezefilm.film.scene import Scene, Scenes
from squeezefilm.reynolds.device import Device, choose_device
from squeezefilm.reynolds.effects import depth_averaged, heat, inertia, rim, sliding, slip
from squeezefilm.reynolds.effects.fields import Fields
from squeezefilm.reynolds.effects.sensitivity import Answers, sensitivity
from squeezefilm.reynolds.grid import Grid
from squeezefilm.reynolds.needs import needs_of
from squeezefilm.reynolds.periodic.launch import Batch, launch
from squeezefilm.reynolds.periodic.resolution import grid_for, unseen_profiles
from squeezefilm.reynolds.periodic.states import STATUS
from squeezefilm.reynolds.problems import problems_of
from squeezefilm.reynolds.terms import Terms, terms_of
from squeezefilm.reynolds.terms.heat import temperature_jump
from squeezefilm.reynolds.terms.rarefaction import fukui_kaneko

# Relative error of the force on the grids taken, and of the iterations on them.
GRID_TOLERANCE = 1e-3
STATE_TOLERANCE = 1e-4
ADJOINT_TOLERANCE = 3e-5
# An effect is of second order in ε, a sum of parts of first order: below this, and where two
# states' differences count, fields are in double precision, else in single.
SMALL = 0.01
# By which an effect on such grids may be off, as a share of it; in layers of σ above 2e4 by more.
OFF_ON_GRIDS = 1 / 50
# A derivative by two states' difference asks for more.
SLIDING_TOLERANCE = 1e-8
# Numbers of a field, all scenes together: more fall out of the caches. And of a launch's states.
MOST_NUMBERS, MOST_LAUNCHED = 2**16, 2**22
# What the first order misses, as a share of it for each unit of the modified Reynolds number, and
# the growth of that with ε²: of strips with velocity and temperature resolved, ε 0.05 to 0.8
# (tests/numerics/test_stored_strip.py).
INERTIA_MISSED = (0.12, 0.13)
HEAT_MISSED = (0.33, 0.58)
# Of slip, for each unit of its coefficient 6 Kn (measured, σ 27–6e4, ε 0.05–0.6, Kn up to 0.07).
SLIP_MISSED = 1.2
# Of the rim, for each unit of C Re, and of that times ε: the lesser (strips with the rim's loss at
# every order, σ 2–2e4, ε 0.05–0.95, up to 0.4 of the force).
RIM_MISSED, RIM_MISSED_PER_EPSILON = 0.022, 0.04
# Of the profile that passes, for each unit of the squared bearing number (marched on a strip).
PASSING_MISSED = 4.0


class Effect(NamedTuple):
    """One effect on the mean force.

    Attributes:
        percent: of the force, at first order, that of a passing profile at second; NaN where it is
            not known.
        missed_percent: size of what higher orders add; NaN where that is not known.
        in_force: the force has it already.
        estimate: it is no first order, and may be smaller than what it misses.
    """

    percent: float
    missed_percent: float = nan
    in_force: bool = False
    estimate: bool = False

    @property
    def usable(self) -> bool:
        """Whether the first order is more than what it misses."""
        return self.estimate or not abs(self.missed_percent) > abs(self.percent) / 2

    @property
    def off_percent(self) -> float:
        """By how much it may be off: what higher orders add, and the coarse grids."""
        return self.missed_percent + OFF_ON_GRIDS * abs(self.percent)


UNKNOWN, NONE = Effect(nan), Effect(0.0, 0.0)


@dataclass(frozen=True)
class Budget:
    """The effects on one scene's force; ``rim`` is for the coefficient C = 1, what its first order
    misses the share at rim.MOST.

    Attributes:
        inertia: of the gas.
        heat: of compression and friction, between walls at ambient temperature.
        depth_averaged: error of inertia and heat as the scene has them (depth_averaged.py).
        slip: rarefaction by Fukui and Kaneko's flow factor, or as the scene has it.
        kinetic: what slip of first order lacks of that flow factor, where the scene has slip.
        rim: loss of pressure where gas streams in; C lies between rim.LEAST and rim.MOST.
        bearing: of a finger that slides, for a profile that stands under it.
        passing: the profile of the surface moving past a finger that slides.
        basis: what the numbers are of, if not of the scene itself.
        status: ``ok``, or why there are none.
    """

    inertia: Effect = UNKNOWN
    heat: Effect = UNKNOWN
    depth_averaged: Effect = UNKNOWN
    slip: Effect = UNKNOWN
    kinetic: Effect = UNKNOWN
    rim: Effect = UNKNOWN
    bearing: Effect = UNKNOWN
    passing: Effect = UNKNOWN
    basis: str = ""
    status: str = "ok"

    @property
    def effects(self) -> dict[str, Effect]:
        return {name: getattr(self, name) for name in NAMES}

    @property
    def known(self) -> Budget:
        """The budget as if what is not known in it were nothing, and another pad this one."""
        unknown: Any = {name: NONE for name, each in self.effects.items() if isnan(each.percent)}
        return replace(self, basis="", **unknown)

    @property
    def above_range(self) -> list[str]:
        """The names of what is left out and too large for a first order."""
        effects = self.effects.items()
        return [name for name, each in effects if not (each.usable or each.in_force)]

    def sums(self, *, left_out_only: bool) -> tuple[float, float]:
        """Least and most of all effects together, or of those that the force does not have.

        The band holds both ends of the rim's coefficient and by what the effects may be off, all in
        one direction. NaN where an effect is not known, or is that of another pad.
        """
        if self.basis:
            return nan, nan
        some = [each for each in self.effects.values() if not (left_out_only and each.in_force)]
        for_one = sum(each.percent for each in some)
        ends = [for_one + (share - 1) * self.rim.percent for share in (rim.LEAST, rim.MOST)]
        off = sum(each.off_percent for each in some) + (rim.MOST - 1) * self.rim.off_percent
        return min(ends) - off, max(ends) + off


NAMES = tuple(each.name for each in fields(Budget) if each.type == "Effect")


def budgets(scenes: Sequence[Scene], *, device: Device | None = None) -> list[Budget]:
    """The budget of each scene's force.

    A pad that the grid kernel does not know is answered for the flat rectangle inside it, and says
    so.
    """
    found: dict[int, Budget] = {}
    groups: dict[Terms, dict[tuple[Grid, float, bool], list[int]]] = defaultdict(
        lambda: defaultdict(list)
    )
    like = [_on_a_grid(scene) for scene in scenes]
    # Every effect is one about the film without inertia and heat, which are two of them.
    without = [_without(each) for each in like]
    for index, scene in enumerate(without):
        needs = needs_of(scene)
        if scene.epsilon == 0:
            found[index] = Budget(status="no vibration, no force")
        elif unseen := unseen_profiles(needs, tolerance=GRID_TOLERANCE):
            found[index] = Budget(status=unseen[0])
        else:
            (grid,) = grid_for(needs, tolerance=GRID_TOLERANCE)
            groups[needs.terms][grid, scene.aspect, scene.epsilon < SMALL].append(index)
    for alike in groups.values():
        for parts in _launches(alike):
            chosen = device or choose_device()
            some = [([without[index] for index in part], grid) for part, grid in parts]
            slides = some[0][0][0].bearing_number != 0
            tolerance = SLIDING_TOLERANCE if slides else STATE_TOLERANCE
            films = _solved(some, tolerance=tolerance, device=chosen)
            for (part, _), (its, _), solved in zip(parts, some, films, strict=True):
                found |= dict(zip(part, _budgets(its, *solved, device=chosen), strict=True))
    return [
        _told(found[index], scene, basis="" if like[index] is scene else BASIS)
        for index, scene in enumerate(scenes)
    ]


NOT_FOUND = "what a source of mass does to the force was not found: GMRES did not converge"
BASIS = "the flat rectangle inside, not of this pad"


def _without(scene: Scene) -> Scene:
    gas = scene.gas
    if gas.inertia == gas.heat == "none":
        return scene
    return replace(scene, gas=replace(gas, inertia="none", heat="none"))


def _told(budget: Budget, scene: Scene, *, basis: str) -> Budget:
    """The budget with what the scene's own force has of inertia and heat, and their error."""
    with_inertia, with_heat = (
        getattr(scene.gas, name) == "included" for name in ("inertia", "heat")
    )
    return replace(
        budget,
        inertia=budget.inertia._replace(in_force=with_inertia),
        heat=budget.heat._replace(in_force=with_heat),
        depth_averaged=Effect(*depth_averaged.error_percent(scene), estimate=True)
        if budget.status == "ok"
        else UNKNOWN,
        basis=basis,
    )


def _on_a_grid(scene: Scene) -> Scene:
    """The scene, or one like it with the flat rectangle inside its pad."""
    finger = scene.finger
    if finger.shape == "rectangle":
        return scene
    flat = replace(
        finger,
        shape="rectangle",
        contour=None,
        length_x_m=finger.rectangle_within * finger.length_x_m,
        length_y_m=finger.rectangle_within * finger.length_y_m,
        gap=GapShape(),
    )
    return replace(scene, finger=flat)


Parts = list[tuple[list[int], Grid]]


def _launches(groups: Mapping[tuple[Grid, float, bool], list[int]]) -> Iterator[Parts]:
    """Scenes of like terms in parts that stay in the caches, some parts for each launch."""
    parts: Parts = []
    launched = 0
    for (grid, *_), group in groups.items():
        step = max(1, MOST_NUMBERS // grid.count)
        for start in range(0, len(group), step):
            part = group[start : start + step]
            if parts and launched + len(part) * grid.count > MOST_LAUNCHED:
                yield parts
                parts, launched = [], 0
            parts.append((part, grid))
            launched += len(part) * grid.count
    if parts:
        yield parts


def _budgets(
    scenes: Sequence[Scene], films: Fields, status: Sequence[str], *, device: Device
) -> list[Budget]:
    """Budgets of scenes of like terms, by their films on one grid and how iterations ended."""
    slides = any(scene.bearing_number != 0 for scene in scenes)
    with np.errstate(all="ignore"):
        sensitive = sensitivity(films, tolerance=ADJOINT_TOLERANCE)
        found = np.isfinite(sensitive).all(axis=(1, 2, 3))
        shares = _shares(scenes, films, sensitive)
        if slides:
            shares |= _shares_of_sliding(scenes, films, device=device)
    percents = zip(*((100 * share).tolist() for share in shares.values()), strict=True)
    return [
        _budget(
            scene,
            dict(zip(shares, percent, strict=True)),
            reason if reason != "ok" or known else NOT_FOUND,
        )
        for scene, reason, known, percent in zip(scenes, status, found, percents, strict=True)
    ]


Solved = tuple[Fields, list[str]]


def _solved(
    groups: Sequence[tuple[Sequence[Scene], Grid]], *, tolerance: float, device: Device
) -> list[Solved]:
    """The films of groups of scenes, all of like terms, and how each iteration ended."""
    terms = terms_of(groups[0][0][0])
    problems = [problems_of(scenes, grid, tolerance=tolerance) for scenes, grid in groups]
    grids = [grid for _, grid in groups]
    batches = [Batch(Scenes.of(scenes), terms, [grid], [tolerance]) for scenes, grid in groups]
    launched = launch(batches, device=device)
    found = []
    for each, grid, (states,) in zip(problems, grids, launched.states(), strict=True):
        single = tolerance >= STATE_TOLERANCE and each.epsilon.min() >= SMALL
        with np.errstate(over="ignore"):  # of a film that was not found
            overpressure = states.overpressure.astype(np.float32 if single else np.float64)
        found.append((Fields(each, grid, overpressure), [STATUS[k] for k in states.status]))
    launched.end()
    return found


def _shares(scenes: Sequence[Scene], films: Fields, sensitive: np.ndarray) -> dict[str, np.ndarray]:
    """Change of the mean force by each effect that needs no more than the films, relative to it.

    All of the scenes have slip, of one kind, or none.
    """
    gases = [scene.gas for scene in scenes]
    reynolds = np.array([scene.modified_reynolds for scene in scenes])
    knudsen = np.zeros(len(scenes))
    heating = reynolds * [(1 - 1 / gas.heat_capacity_ratio) * gas.prandtl for gas in gases]
    kinetic = np.array([fukui_kaneko(scene) for scene in scenes])
    # Of scenes without slip the flow factor's effect is slip's, and nothing is lacking.
    slipping = kinetic.copy()
    if gases[0].rarefaction != "none":
        knudsen += [scene.slip_knudsen or scene.knudsen for scene in scenes]
        flow = films.problems.numbers["flow"]
        slipping[:] = 0
        slipping[:, : flow.shape[1]] = flow
    answers = Answers(films, sensitive)
    by_flow = slip.changes(films, answers, terms=kinetic.shape[1] - 1)
    change = {
        "inertia": inertia.change(films, answers, reynolds=reynolds, knudsen=knudsen),
        "heat": heat.change(
            films,
            answers,
            heating=heating,
            viscosity_exponent=np.array([gas.viscosity_exponent for gas in gases]),
            jump=np.array([temperature_jump(scene) for scene in scenes]),
        ),
        "slip": np.sum(by_flow * slipping[:, 1:], axis=1),
        "kinetic": np.sum(by_flow * (kinetic - slipping)[:, 1:], axis=1),
        "rim": rim.change(films, answers, reynolds=reynolds),
    }
    force = films.mean(films.overpressure)
    return {name: each / force for name, each in change.items()}


def _shares_of_sliding(
    scenes: Sequence[Scene], films: Fields, *, device: Device
) -> dict[str, np.ndarray]:
    """Change of the mean force by sliding, relative to it; by the bearing term at every order."""
    force = films.mean(films.overpressure)

    def solved(groups: Iterable[Sequence[Scene]]) -> list[Fields]:
        on_grid = [(group, films.grid) for group in groups]
        states = _solved(on_grid, tolerance=SLIDING_TOLERANCE, device=device)
        for found, status in states:
            found.overpressure[np.array([each != "ok" for each in status])] = nan
        return [found for found, _ in states]

    (rest,) = solved([[sliding.at_rest(scene) for scene in scenes]])
    places = zip(*map(sliding.line, scenes), strict=True)
    first, second = sliding.change_by_passing(
        solved(places),
        bearing=np.array([scene.bearing_number for scene in scenes]),
    )
    return {
        "bearing": (force - rest.mean(rest.overpressure)) / force,
        "passing": (first + second) / force,
    }


def _budget(scene: Scene, percent: dict[str, float], status: str) -> Budget:
    """A scene's budget from its effects; without those that its gas does not allow."""
    if status != "ok":
        return Budget(status=status)
    if not all(map(isfinite, percent.values())):
        return Budget(status="no force to compare with")
    reynolds = scene.modified_reynolds
    slides = scene.bearing_number != 0
    return Budget(
        inertia=_effect(percent["inertia"], missed=_missed(INERTIA_MISSED, scene)),
        heat=UNKNOWN  # a polytropic exponent stands for it
        if scene.gas.polytropic_exponent != 1
        else _effect(percent["heat"], missed=_missed(HEAT_MISSED, scene)),
        depth_averaged=NONE,  # without inertia and heat
        slip=_effect(
            percent["slip"],
            missed=SLIP_MISSED * 6 * scene.knudsen,
            in_force=scene.gas.rarefaction != "none",
        ),
        kinetic=_effect(percent["kinetic"], missed=SLIP_MISSED * 6 * scene.knudsen),
        rim=_effect(percent["rim"], missed=_rim_missed(rim.MOST * reynolds, scene.epsilon)),
        bearing=Effect(percent["bearing"], 0.0, in_force=True) if slides else NONE,
        passing=_passing(scene, percent),
    )


def _passing(scene: Scene, percent: dict[str, float]) -> Effect:
    if scene.bearing_number == 0:
        return NONE
    if scene.gas.polytropic_exponent != 1:
        return UNKNOWN  # its second order is that of an isothermal gas
    return _effect(percent["passing"], missed=PASSING_MISSED * scene.bearing_number**2)


def _missed(share: tuple[float, float], scene: Scene) -> float:
    """What a first order in Re misses, as a share of it."""
    return (share[0] + share[1] * scene.epsilon**2) * scene.modified_reynolds


def _rim_missed(coefficient_reynolds: float, epsilon: float) -> float:
    """What the rim's first order misses, as a share of it, for C Re."""
    return coefficient_reynolds * min(RIM_MISSED, RIM_MISSED_PER_EPSILON * epsilon)


def _effect(percent: float, *, missed: float, in_force: bool = False) -> Effect:
    return Effect(percent, missed * abs(percent), in_force)
