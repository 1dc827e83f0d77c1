"""The modelling error of a force: what the film equation neglects, effect by effect, in % of it.

An effect is the difference of two solved forces, with and without it: slip, inertia and thermal
effects are terms of the solver, the edge loss and flow around the edge are a pressure on it that is
solved for (edge_effects.py), and inertia and heat of gas that a sliding wall drags are a source of
mass (sheared_gas.py), as is a profile that it carries along (moving_profile.py). Effects interact,
so all that are neglected together are one solve more, and not the sum of the rows. What cannot be
solved for is unknown, and so is the total then.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache, partial
from itertools import chain
from math import isfinite, isnan, nan
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

import numpy as np

from squeezefilm.film.scene import Film, Scene, Scenes
from squeezefilm.film.validity import THICK_FILM_SIGMA, exceeded_limits_by_scene
from squeezefilm.quantities import edge_effects, moving_profile, sheared_gas
from squeezefilm.quantities.edge_effects import JOINT_LAWS, SEPARATE_LAWS
from squeezefilm.reynolds.device import Device, choose_device
from squeezefilm.reynolds.periodic.like_films import FilmOnGrids, films_on_grids_of
from squeezefilm.reynolds.plan import solve_plan_of
from squeezefilm.reynolds.solver import solve
from squeezefilm.reynolds.terms import terms_of, unsupported_on_grid_reason
from squeezefilm.reynolds.terms.inertia import Inertia
from squeezefilm.reynolds.terms.rarefaction import slip_flow
from squeezefilm.reynolds.terms.term import Term
from squeezefilm.reynolds.terms.thermal import Thermal
from squeezefilm.solution import MODELLING_ERROR_COLUMNS, Solution

# Tolerance of the first grids of a film with all effects, on which its forces with and without
# each are solved for; on up to so many grids where their error is more than a fraction of the
# largest effect, unless a force took more operations than EXPENSIVE_OPERATION_COUNT, a fraction of
# a second.
FIRST_GRID_TOLERANCE, MAX_GRID_COUNT = 1e-3, 4
RELATIVE_EFFECT_TOLERANCE, EXPENSIVE_OPERATION_COUNT = 0.01, 1e10
# Scenes whose budgets are solved for together, so that not all states are held.
SCENES_PER_BUDGET_BATCH = 16
# Terms that a study may leave to be decided, in the order in which they are.
AUTO_TERMS: dict[str, Term] = {"inertia": Inertia(), "thermal": Thermal()}
# The effects, by their names in tables.
SLIDING_EFFECT_NAMES = ("sheared_gas", "moving_profile", "ram_pressure")
EFFECT_NAMES = (
    *(*AUTO_TERMS, "depth_averaged", *SLIDING_EFFECT_NAMES),
    *("slip", "flow_factor", "edge_loss", "edge_flow", "bearing"),
)
# Name of all neglected effects at once, where each alone was solved for.
ALL_EFFECTS_LABEL = "all effects together"


class Effect(NamedTuple):
    """One effect on the mean force.

    Attributes:
        percent: of the force; NaN where it is unknown.
        error_percent: by which that may be off.
        included: the force has it already.
    """

    percent: float
    error_percent: float = nan
    included: bool = False


UNKNOWN_EFFECT, NO_EFFECT = Effect(nan), Effect(0.0, 0.0)
# Relative changes of forces by effects beside their states, and the errors, (2, changes).
ForceChanges = dict[str, dict[Scene, np.ndarray]]


@dataclass(frozen=True)
class ErrorBudget:
    """The effects on one scene's force.

    Attributes:
        effects: by EFFECT_NAMES. ``inertia`` of the gas; ``thermal`` of compression and friction,
            between walls at ambient temperature; ``depth_averaged``, error of both as averages over
            the gap; ``slip`` of first order, with the flow factor's flow in a gap at rest, or as
            the scene has it; ``flow_factor``, its difference from that; ``edge_loss`` for C = 1;
            ``edge_flow``, flow around the edge.

            Of a sliding pad: ``bearing``; ``sheared_gas``, inertia and heat beside those of the
            flow by pressure; ``moving_profile``, motion of the profile past the pad;
            ``ram_pressure`` of gas that the surface drags to the edge, of which a bound is known.
        edge_loss_upper_percent: the edge loss for the largest C.
        modelling_error_percent: lower and upper end of all neglected effects together, with C from
            its smallest to its largest; NaN where an effect is unknown.
        numerical_error_percent: the largest error of an effect by grids and iterations.
        status: ``ok``, or why there are none.
    """

    effects: Mapping[str, Effect] = field(
        default_factory=lambda: dict.fromkeys(EFFECT_NAMES, UNKNOWN_EFFECT)
    )
    edge_loss_upper_percent: float = nan
    modelling_error_percent: tuple[float, float] = (nan, nan)
    numerical_error_percent: float = nan
    status: str = "ok"

    @property
    def neglected_effects(self) -> dict[str, Effect]:
        """The effects that the force does not have."""
        return {name: effect for name, effect in self.effects.items() if not effect.included}

    @property
    def unknown_effect_names(self) -> list[str]:
        """The names of neglected effects that could not be solved for, or that of all together."""
        alone = [name for name, effect in self.neglected_effects.items() if isnan(effect.percent)]
        together_known = isfinite(sum(self.modelling_error_percent))
        return alone if alone or together_known else [ALL_EFFECTS_LABEL]

    @property
    def higher_orders_percent(self) -> float:
        """Difference of all neglected effects together from the sum of each alone."""
        alone = sum(effect.percent for effect in self.neglected_effects.values())
        alone += (self.edge_loss_upper_percent - self.effects["edge_loss"].percent) / 2
        return sum(self.modelling_error_percent) / 2 - alone

    @property
    def known_error_percent(self) -> float:
        """Largest size of the modelling error; of the known effects alone where one is unknown."""
        if isfinite(sum(self.modelling_error_percent)):
            return max(map(abs, self.modelling_error_percent))
        known = [effect for effect in self.neglected_effects.values() if not isnan(effect.percent)]
        sizes = [abs(effect.percent) + effect.error_percent for effect in known]
        edge_loss = self.effects["edge_loss"]
        if not isnan(edge_loss.percent):
            sizes.append(abs(self.edge_loss_upper_percent - edge_loss.percent))
        return sum(sizes)


def error_budgets(scenes: Sequence[Scene], *, device: Device | None = None) -> list[ErrorBudget]:
    """The budget of each scene's force; what of their gases is ``auto`` must be decided."""
    device = device or choose_device()
    budgets: list[ErrorBudget] = []
    for first in range(0, len(scenes), SCENES_PER_BUDGET_BATCH):
        films = [EffectVariants(scene) for scene in scenes[first : first + SCENES_PER_BUDGET_BATCH]]
        budgets += _error_budgets_of_variants(films, device)
    return budgets


def ambient_slip_coefficient(scene: Scene) -> float:
    """Return the coefficient of slip with the flow factor's flow in the gap h0 at rest."""
    inverse = scene.inverse_knudsen
    return float(slip_flow(inverse) / inverse / scene.knudsen)


class EffectVariants:
    """The variants of a scene whose forces give its error budget.

    Attributes:
        scene: whose budget it is.
        reference: the scene that neglected effects are added to: itself, but that first-order slip
            stands for the flow factor, which inertia and thermal effects are not derived with.
        pairs: by effect, the film with it and the film without: the scene itself and its like
            without an effect that it includes, the reference with a neglected one and itself. Of
            the flow factor the film with that flow, and with first-order slip, without inertia and
            thermal effects; there is none where the scene has it.
        together: the reference with all neglected effects that are solvable.
        unsolvable: neglected effects that the solver has no term for.
        still: under a sliding pad, the films without vibration; of a level gap, which has no
            force then, and of a pad at rest there are none.
    """

    def __init__(self, scene: Scene) -> None:
        gas = scene.gas
        slipping = gas.rarefaction == "fukui-kaneko"
        self.scene = scene
        self.reference = scene.with_gas(rarefaction="slip") if slipping else scene
        self.pairs: dict[str, tuple[Scene, Scene]] = {}
        self.unsolvable: list[str] = []
        added: dict[str, Any] = {}
        for name in AUTO_TERMS:
            with_effect = self.reference.with_gas(**{name: "included"})
            if getattr(gas, name) == "included":
                self.pairs[name] = scene, scene.with_gas(**{name: "none"})
            elif unsupported_on_grid_reason(with_effect, terms_of(with_effect)):
                self.unsolvable.append(name)
            else:
                self.pairs[name] = with_effect, self.reference
                added[name] = "included"
        slip: dict[str, Any] = {"rarefaction": "slip"}
        if gas.rarefaction == "none":
            slip["slip_coefficient"] = ambient_slip_coefficient(scene)
            self.pairs["slip"] = scene.with_gas(**slip), scene
            added |= slip
        else:
            self.pairs["slip"] = scene, scene.with_gas(rarefaction="none")
        self.together = self.reference.with_gas(**added)
        if not slipping:
            viscous = scene.viscous()
            rarefied = viscous.with_gas(rarefaction="fukui-kaneko")
            self.pairs["flow_factor"] = rarefied, viscous.with_gas(**slip)
        if scene.bearing_number:
            at_rest = replace(scene, pad=replace(scene.pad, speed_x_m_per_s=0.0))
            self.pairs["bearing"] = scene, at_rest
        self.still: EffectVariants | None = None
        if scene.bearing_number and not scene.pad.gap.flat:
            self.still = EffectVariants(replace(scene, hv_m=0.0)) if scene.epsilon else self

    @property
    def has_force(self) -> bool:
        """Return whether vibration or sliding presses on the pad."""
        return bool(self.scene.epsilon or self.still)

    @property
    def gas_term_variant_pairs(self) -> list[tuple[Scene, Scene]]:
        """The films with and without inertia, and with and without thermal effects."""
        return [self.pairs.get(name, (self.reference,) * 2) for name in AUTO_TERMS]

    @property
    def variants_of_same_motion(self) -> list[Scene]:
        """The films of the same motion, whose forces differ by what the gas does alone."""
        by_gas = [pair for name, pair in self.pairs.items() if name != "bearing"]
        return [self.scene, self.reference, self.together, *chain(*by_gas)]

    @property
    def scenes(self) -> list[Scene]:
        """Return all variants; equal ones may occur."""
        still = (
            [self.still.together, *chain(*self.still.gas_term_variant_pairs)] if self.still else []
        )
        return [*self.variants_of_same_motion, *self.pairs.get("bearing", ()), *still]


def _error_budgets_of_variants(
    films: Sequence[EffectVariants], device: Device
) -> list[ErrorBudget]:
    budgets = [ErrorBudget(status="no vibration, no force") for _ in films]
    waiting = [k for k, film in enumerate(films) if film.has_force]
    for grid_count in range(2, 1 + MAX_GRID_COUNT):
        if not waiting:
            break
        moving = [films[k] for k in waiting]
        variants = _solve_variants(moving, grid_count=grid_count, device=device)
        changes = _changes_beside_states(moving, variants, device=device)
        resolved = []
        for k, of_film, changes_of_film in zip(waiting, variants, changes, strict=True):
            budgets[k] = _error_budget_of_variants(films[k], of_film, changes_of_film)
            resolved.append(_is_resolved(budgets[k], films[k], of_film))
        waiting = [k for k, done in zip(waiting, resolved, strict=True) if not done]
    unsolved = [k for k, film in enumerate(films) if film.has_force and budgets[k].status != "ok"]
    how: dict[str, Any] = {"tolerance": FIRST_GRID_TOLERANCE, "method": "periodic"}
    for k, solution in zip(
        unsolved, solve([films[k].scene for k in unsolved], **how, device=device), strict=True
    ):
        budgets[k] = ErrorBudget(status=solution.status)
    return budgets


def _solve_variants(
    films: Sequence[EffectVariants], *, grid_count: int, device: Device
) -> list[dict[Scene, FilmOnGrids]]:
    """Return the variants of each film that have states, on grids of that with all effects."""
    scenes = [(k, scene) for k, film in enumerate(films) for scene in dict.fromkeys(film.scenes)]
    solved = films_on_grids_of(
        solve_plan_of([films[k].together for k, _ in scenes]),
        Scenes.of([scene for _, scene in scenes]),
        range(len(scenes)),
        tolerance=FIRST_GRID_TOLERANCE,
        grid_count=grid_count,
        device=device,
        keep_states=True,
    )
    variants: list[dict[Scene, FilmOnGrids]] = [{} for _ in films]
    for row, film_on_grids in solved.items():
        k, scene = scenes[row]
        variants[k][scene] = film_on_grids
    return variants


def _changes_beside_states(
    films: Sequence[EffectVariants],
    variants: Sequence[Mapping[Scene, FilmOnGrids]],
    *,
    device: Device,
) -> list[ForceChanges]:
    """Return the changes of each film's forces by effects that the solver has no terms for."""
    alone = [(k, film.scene) for k, film in enumerate(films)]
    together = [(k, film.together) for k, film in enumerate(films)]
    sliding = [(k, scene) for k, scene in together if scene.bearing_number]
    still = [(k, film.still.together) for k, film in enumerate(films) if film.still]
    changes: list[ForceChanges] = [{} for _ in films]
    edge_changes = edge_effects.edge_effect_changes
    for name, force_changes, of_films in (
        ("separate_edge_effects", partial(edge_changes, laws=SEPARATE_LAWS), alone),
        ("joint_edge_effects", partial(edge_changes, laws=JOINT_LAWS), together),
        ("ram_pressure", edge_effects.ram_pressure_changes, sliding),
        ("sheared_gas", sheared_gas.sheared_gas_force_changes, [*dict.fromkeys(sliding + still)]),
        ("moving_profile", moving_profile.moving_profile_changes, sliding),
    ):
        solutions = [_solution_of_variant(variants[k].get(scene)) for k, scene in of_films]
        found = force_changes([scene for _, scene in of_films], solutions, device=device)
        for (k, scene), change in zip(of_films, np.moveaxis(found, -1, 0), strict=True):
            changes[k].setdefault(name, {})[scene] = change
    return changes


def _solution_of_variant(film: FilmOnGrids | None) -> Solution:
    if film is None:
        return Solution(method="periodic", status="no state")
    return Solution(method="periodic", status="ok", states=film.states, residual=film.residual)


def _is_resolved(
    budget: ErrorBudget, film: EffectVariants, variants: Mapping[Scene, FilmOnGrids]
) -> bool:
    """Return whether effects are known as closely as the largest needs, or as it pays.

    It does not where one is unknown for want of a state: on finer grids it stays so, and with it
    the total. The iteration of an edge effect may settle there.
    """
    effects_with_states = budget.effects.keys() - {"edge_loss", "edge_flow"}
    if any(isnan(budget.effects[name].percent) for name in effects_with_states):
        return True
    known = [variants[scene] for scene in film.scenes if scene in variants]
    dearest = max((variant.operation_count for variant in known), default=0.0)
    if len(known) < len(film.scenes) or dearest > EXPENSIVE_OPERATION_COUNT:
        return True
    largest = max(abs(effect.percent) for effect in budget.effects.values())
    return budget.numerical_error_percent <= RELATIVE_EFFECT_TOLERANCE * largest


def _error_budget_of_variants(
    film: EffectVariants, variants: Mapping[Scene, FilmOnGrids], changes: ForceChanges
) -> ErrorBudget:
    """A scene's budget from the forces of its films and what is beside these."""
    scene = film.scene
    if scene not in variants:
        return ErrorBudget(status="no state")
    own = variants[scene]

    def change_percent(with_effect: Scene, without: Scene) -> tuple[float, float]:
        """Return the difference of two forces and its error, in per cent of the own force."""
        if with_effect not in variants or without not in variants:
            return nan, nan
        change, error = own.relative_difference(variants[with_effect], without=variants[without])
        return 100 * change, 100 * error

    effects = dict.fromkeys(EFFECT_NAMES, NO_EFFECT)
    # First-order slip stands for the flow factor, by whose difference an effect may be off.
    apart, apart_error = change_percent(scene, film.reference)
    doubt = (abs(apart) + apart_error) / 100
    numerical_errors = []
    for name, (with_effect, without) in film.pairs.items():
        percent, error = change_percent(with_effect, without)
        numerical_errors.append(error)
        included = with_effect == scene
        effects[name] = Effect(percent, error + doubt * abs(percent) * (not included), included)
    for name in film.unsolvable:
        effects[name] = UNKNOWN_EFFECT
    effects["depth_averaged"] = Effect(*depth_averaging_change_percent(film.together))
    edge_loss, edge_loss_upper, edge_flow = _effects_of_changes(
        changes["separate_edge_effects"][scene]
    )
    if isnan(edge_loss_upper.error_percent):  # of one end nothing is told
        edge_loss = UNKNOWN_EFFECT
    # Those of the film with all other effects, over that film's force.
    with_all = _mean_pressure_ratio(variants, film.together) / own.mean_pressure_ratios[1]
    joint = with_all * changes["joint_edge_effects"][film.together]
    *edges, resistance, inertance = _effects_of_changes(joint)
    edge_flow_error = sum(
        effect.error_percent + float(ratio) * abs(effect.percent)
        for effect, ratio in zip(
            (resistance, inertance), edge_effects.edge_flow_error_ratios(scene), strict=True
        )
    )
    effects["edge_loss"] = edge_loss
    effects["edge_flow"] = Effect(edge_flow.percent, edge_flow.error_percent + edge_flow_error)
    together, error = change_percent(film.together, film.reference)
    # Grids may agree by chance on the edge's effects together, and not on each.
    edge_error = float(np.max([edge.error_percent for edge in (*edges, edge_loss, edge_flow)]))
    numerical_errors.append(error + edge_error)
    error += doubt * abs(together)
    if "flow_factor" in film.pairs:
        percent, flow_error, _ = effects["flow_factor"]
        # Of a film without inertia and thermal effects, which it may interact with.
        interaction = 0.0 if film.together.viscous() == film.together else abs(percent)
        effects["flow_factor"] = Effect(percent, flow_error + interaction)
    if scene.bearing_number:
        effects |= _sliding_effects(film, variants, changes)
    ends = [edge.percent for edge in edges]
    error += edge_error + edge_flow_error
    for name in ("flow_factor", "depth_averaged", *SLIDING_EFFECT_NAMES):
        together += effects[name].percent
        error += effects[name].error_percent
    if film.unsolvable:
        together = nan
    return ErrorBudget(
        # Without an error, as where an iteration settles on the finer grid alone, one is unknown.
        {
            name: UNKNOWN_EFFECT if isnan(effect.error_percent) else effect
            for name, effect in effects.items()
        },
        edge_loss_upper_percent=edge_loss_upper.percent,
        modelling_error_percent=(
            float(together + min(ends) - error),
            float(together + max(ends) + error),
        ),
        numerical_error_percent=float(np.max(numerical_errors)),
    )


def _effects_of_changes(changes: np.ndarray) -> list[Effect]:
    """Return effects by relative changes of a force and their errors, (2, effects)."""
    return [Effect(100 * float(change), 100 * abs(float(error))) for change, error in changes.T]


def _mean_pressure_ratio(variants: Mapping[Scene, FilmOnGrids], scene: Scene) -> float:
    """Return the mean gauge pressure over p0 of a variant; NaN where it has no state."""
    return variants[scene].mean_pressure_ratios[1] if scene in variants else nan


def _sliding_effects(
    film: EffectVariants, variants: Mapping[Scene, FilmOnGrids], changes: ForceChanges
) -> dict[str, Effect]:
    """Return the effects beside the Couette flow that a pad's sliding has, of OF_SLIDING."""
    scene, force = film.scene, partial(_mean_pressure_ratio, variants)

    def effect_percent(name: str) -> tuple[float, float]:
        change, error = changes[name][film.together][:, 0] * force(film.together) / force(scene)
        return 100 * float(change), 100 * abs(float(error))

    def gas_effects(film: EffectVariants) -> np.ndarray:
        """Changes of the force by inertia, by thermal effects and by gas that the wall drags."""
        forces = [[*map(force, pair)] for pair in film.gas_term_variant_pairs]
        dragged = changes["sheared_gas"][film.together][0, 0]
        return np.append(-np.diff(forces), force(film.together) * dragged)

    sheared, error = effect_percent("sheared_gas")
    by_gas = gas_effects(film)
    by_vibration = by_gas - gas_effects(film.still) if film.still else by_gas
    size, vibrating = (float(np.abs(each).sum()) for each in (by_gas, by_vibration))
    missed = sheared_gas.first_order_remainder_of_scene(scene, vibrating=vibrating / size)
    error += 100 * missed * size / abs(force(scene))
    error += 6 * scene.knudsen * abs(sheared)  # of the wall's velocity no slip is known
    ram, ram_error = effect_percent("ram_pressure")
    effects = {
        "sheared_gas": Effect(sheared, nan if film.unsolvable else float(error)),
        "moving_profile": Effect(*effect_percent("moving_profile")),
        "ram_pressure": Effect(0.0, abs(ram) + ram_error),
    }
    return {
        name: effect if isfinite(effect.error_percent) else UNKNOWN_EFFECT
        for name, effect in effects.items()
    }


# Mean force of a square piston at second order of small motion, over ε² and p0 times the pad's
# area, with the depth-averaged terms and resolved across the gap: isothermal velocity; or, where
# thermal is 1, temperature too (Pr 0.71, γ 1.4, κ 0.7; the solver's averaged force at ε = 0.005).
DEPTH_AVERAGING_FILE = Path(__file__).with_name("depth_averaged.csv")
# Below THICK_FILM_SIGMA strips that resolve the profiles were compared up to this Re, and no
# further.
MAX_REYNOLDS_OF_THICK_FILM = 2.0
# By how much the change may be off, as a share of the largest at the same Re, for ε → 0 and for
# each unit of ε: 288 strips that resolve the profiles, piston and sinc, ε 0.02–0.8, σ 0.5–1e4.
DEPTH_ERROR_FRACTION, DEPTH_ERROR_PER_EPSILON = 0.7, 1.0
THICK_DEPTH_ERROR_FRACTION, THICK_DEPTH_ERROR_PER_EPSILON = 2.0, 5.0


def depth_averaging_change_percent(scene: Scene) -> tuple[float, float]:
    """Return a force's change (%) by profiles resolved across the gap, and its error.

    An estimate for depth-averaged inertia and thermal effects: a parabola stands for each profile.
    The error grows as Re² at first and depends little on the squeeze number. At Re 40 it is 2.9 to
    11 %, too far from that at 20 to be interpolated: at small σ the force has resonances in Re.

    Returns:
        The change in per cent of the force, and its error: other profiles and
        amplitudes than the table's. 0 where the scene has neither term; NaN beyond the table's Re,
        and beyond Re 2 below its σ. Where no sign is known, the change is 0 and its error up to its
        size: below the table's σ, and for thermal effects alone.
    """
    inertia, thermal = (getattr(scene.gas, name) == "included" for name in AUTO_TERMS)
    reynolds, sigma = scene.modified_reynolds, scene.sigma
    if not (inertia or thermal):
        return 0.0, 0.0
    thick = sigma < THICK_FILM_SIGMA
    nodes, known, changes = _depth_averaging_table(thermal)
    if reynolds > (MAX_REYNOLDS_OF_THICK_FILM if thick else known[-1]):
        return nan, nan
    per_square = [np.interp(reynolds, known, column) for column in changes.T]
    along = reynolds**2 * np.array(per_square)
    largest = float(np.abs(along).max())
    if thick or not inertia:
        return 0.0, largest * (
            THICK_DEPTH_ERROR_FRACTION + THICK_DEPTH_ERROR_PER_EPSILON * scene.epsilon
        )
    change = float(np.interp(sigma**-0.5, nodes, along))
    return change, largest * (DEPTH_ERROR_FRACTION + DEPTH_ERROR_PER_EPSILON * scene.epsilon)


@lru_cache(maxsize=2)
def _depth_averaging_table(thermal: bool) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Nodes in 1/√σ, rising from 0, Reynolds numbers, and the change in per cent over Re² there.

    For thin layers the change goes by powers of 1/√σ, so that two columns give that of σ → ∞.
    """
    table = np.genfromtxt(DEPTH_AVERAGING_FILE, delimiter=",", names=True)
    table = table[table["thermal"] == thermal]
    # np.unique imports masked arrays, which takes longer than the whole table.
    reynolds = np.array(sorted(set(table["reynolds"])))
    sigma = np.array(sorted(set(table["sigma"]), reverse=True))
    change = 100 * (table["resolved"] / table["averaged"] - 1) / table["reynolds"] ** 2
    change, nodes = change.reshape(len(reynolds), -1)[:, ::-1], sigma**-0.5
    slope = (change[:, 1] - change[:, 0]) / (nodes[1] - nodes[0])
    change = np.column_stack([change[:, 0] - slope * nodes[0], change])
    return np.append(0.0, nodes), reynolds, change


# Change of the force, relative, below which a term that is ``auto`` is not included. It is looked
# for on the coarser of the first grids of a force to so many times that, or to the largest
# tolerance, where the term stays if it changes the force by more than so many times that; then on
# both, and on up to so many grids where these leave it open.
AUTO_TERM_TOLERANCE, CLEAR_CHANGE_FACTOR = 1e-3, 4.0
DECIDING_GRID_FACTOR, MAX_DECIDING_GRID_TOLERANCE, MAX_DECIDING_GRID_COUNT = 10.0, 1e-2, 4


def resolve_auto_terms(
    scenes: Scenes | Sequence[Scene],
    *,
    model_tolerance: float = AUTO_TERM_TOLERANCE,
    method: str = "auto",
    device: Device | None = None,
) -> Scenes | Sequence[Scene]:
    """The scenes with each term of AUTO_TERMS ``included`` or ``none`` in the place of ``auto``.

    Terms are excluded where the force without them differs by less than the model tolerance,
    relative, from that with all of them, both solved for on the same grids; and where the method or
    the scene's other terms do not allow them, which the scene's budget shows.
    """
    if not any(map(_undecided_term_names, scenes.films if isinstance(scenes, Scenes) else scenes)):
        return scenes
    scenes, device = Scenes.of(scenes), device or choose_device()
    closed = replace(scenes, films=tuple(map(_scene_without_undecided_terms, scenes.films)))
    # Whether a term is supported does not depend on the operating point.
    supported = {
        int(film): tuple(
            name
            for name in _undecided_term_names(scene)
            if not _unsupported_reason(scene, name, method)
        )
        for film, row in zip(*np.unique(scenes.film_index, return_index=True), strict=True)
        for scene in [scenes[int(row)]]
    }
    included = [supported[int(film)] for film in scenes.film_index]
    full = _scenes_with_included_terms(closed, included)
    plan = solve_plan_of(full)
    how: dict[str, Any] = {
        "tolerance": min(DECIDING_GRID_FACTOR * model_tolerance, MAX_DECIDING_GRID_TOLERANCE),
        "device": device,
    }
    with_all: list[dict[int, FilmOnGrids]] = [{} for _ in range(MAX_DECIDING_GRID_COUNT)]
    # Beyond a limit of the terms a change that passes through zero is no reason to go without them.
    decided = {
        row
        for row, (names, exceeded) in enumerate(
            zip(included, exceeded_limits_by_scene(full, symbols=["Re"]), strict=True)
        )
        if exceeded or not names
    }
    for fewer in ((), ("inertia",), ("thermal",)):
        tried = _scenes_with_included_terms(closed, [fewer] * len(scenes))
        undecided = [
            row
            for row, names in enumerate(included)
            if row not in decided and set(fewer) < set(names)
        ]
        for grid_count, solved in enumerate(with_all, start=1):
            new = [row for row in undecided if row not in solved]
            solved |= films_on_grids_of(plan, full, new, **how, grid_count=grid_count)
            # Where the whole equation has no state all terms stay: the scene's solution says why.
            both = [row for row in undecided if row in solved]
            without = films_on_grids_of(plan, tried, both, **how, grid_count=grid_count)
            for row, film in without.items():
                change, error = solved[row].relative_difference(film, without=solved[row])
                if abs(change) + error < model_tolerance:
                    included[row] = fewer
                    decided.add(row)
                clear = min(error, (CLEAR_CHANGE_FACTOR - 1) * model_tolerance)
                if abs(change) - model_tolerance > clear or row in decided:
                    undecided.remove(row)
    return _scenes_with_included_terms(closed, included)


def unsupported_auto_term_texts(scene: Scene, *, method: str = "auto") -> list[str]:
    """Return the terms that are ``auto`` and not supported for a scene, with the reasons."""
    return [
        f"gas.{name} is auto and not included: {reason}"
        for name in _undecided_term_names(scene)
        if (reason := _unsupported_reason(scene, name, method))
    ]


SceneOrFilmT = TypeVar("SceneOrFilmT", Scene, Film)


def _undecided_term_names(scene: Scene | Film) -> list[str]:
    return [name for name in AUTO_TERMS if getattr(scene.gas, name) == "auto"]


def _scene_without_undecided_terms(scene: SceneOrFilmT) -> SceneOrFilmT:
    """The scene or film without what is to be decided."""
    return scene.with_gas(**dict.fromkeys(_undecided_term_names(scene), "none"))


def _scenes_with_included_terms(scenes: Scenes, included: Sequence[tuple[str, ...]]) -> Scenes:
    """The scenes with the terms that each is to include."""
    choices = list(zip(scenes.film_index.tolist(), included, strict=True))
    index = {choice: number for number, choice in enumerate(dict.fromkeys(choices))}
    films = tuple(
        scenes.films[film].with_gas(**dict.fromkeys(names, "included")) for film, names in index
    )
    return replace(scenes, films=films, film_index=np.array([index[each] for each in choices]))


def _unsupported_reason(scene: Scene, name: str, method: str) -> str:
    """Return the reason why the method does not support a term; empty if it does."""
    scene = _scene_without_undecided_terms(scene).with_gas(**{name: "included"})
    if method == "composite":
        derived = AUTO_TERMS[name].SUPPORTS_EXPANSIONS
        return "" if derived else "the composite expansion is not derived with it"
    return unsupported_on_grid_reason(scene, terms_of(scene))


def budget_row(budget: ErrorBudget) -> dict[str, object]:
    """A budget as columns of a table, in per cent of the force.

    The edge loss is for C = 1, and for the largest C in ``edge_loss_upper_percent``.
    ``included_effects`` names the effects that the force includes, ``unknown_effects`` those
    that could not be solved for.
    """
    row: dict[str, object] = {}
    for name, effect in budget.effects.items():
        row[f"{name}_percent"] = effect.percent
        row[f"{name}_error_percent"] = effect.error_percent
    row["edge_loss_upper_percent"] = budget.edge_loss_upper_percent
    row["higher_orders_percent"] = budget.higher_orders_percent
    row |= zip(MODELLING_ERROR_COLUMNS, budget.modelling_error_percent, strict=True)
    included = [name for name, effect in budget.effects.items() if effect.included]
    return row | {
        "included_effects": "; ".join(included),
        "unknown_effects": "; ".join(budget.unknown_effect_names) if budget.status == "ok" else "",
        "status": budget.status,
    }
