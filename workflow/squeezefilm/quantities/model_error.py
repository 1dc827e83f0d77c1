"""The modelling error of a force: what the film equation neglects, effect by effect, in % of it.

Every effect is taken at first order about the state of the scene's own equation on a coarse grid:
one adjoint solve gives what any source of mass does to the mean force (adjoint.py), and the effects
are such sources (first_order.py). A first order is accurate to about a fiftieth of the effect;
what that misses stands beside it.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from math import isfinite, isnan, nan
from pathlib import Path
from typing import NamedTuple, TypeVar

import numpy as np

from squeezefilm.film.scene import Film, Scene, Scenes
from squeezefilm.film.validity import THICK_SIGMA
from squeezefilm.quantities import first_order
from squeezefilm.quantities.adjoint import Solved, alike, fields_of, sensitivity, with_states
from squeezefilm.quantities.first_order import EDGE_LOSS_LEAST, EDGE_LOSS_MOST, Answers
from squeezefilm.reynolds.device import Device, choose_device
from squeezefilm.reynolds.terms import refused_on_grid, terms_of
from squeezefilm.reynolds.terms.inertia import Inertia
from squeezefilm.reynolds.terms.term import Term
from squeezefilm.reynolds.terms.thermal import Thermal

# Relative error of the force of the states taken, and of the adjoint.
GRID_TOLERANCE = 1e-3
ADJOINT_TOLERANCE = 3e-5
# By which an effect on such grids may be off, as a share of it; in layers of σ above 2e4 by more.
OFF_ON_GRIDS = 1 / 50
# Numbers of a field, all scenes together: more fall out of the caches. Scenes solved together.
MOST_NUMBERS, MOST_SCENES = 2**17, 1024
# Remainder of the first order, as a fraction of it per unit of the modified Reynolds number, and
# its growth with ε²: of strips with velocity and temperature resolved, ε 0.05 to 0.8
# (tests/numerics/test_stored_strip.py).
INERTIA_REMAINDER = (0.12, 0.13)
THERMAL_REMAINDER = (0.33, 0.58)
# Of slip, for each unit of its coefficient 6 Kn (measured, σ 27–6e4, ε 0.05–0.6, Kn up to 0.07).
SLIP_REMAINDER = 1.2
# Of the edge loss, for each unit of C Re, and of that times ε: the lesser (strips with the loss at
# every order, σ 2–2e4, ε 0.05–0.95, up to 0.4 of the force).
EDGE_LOSS_REMAINDER, EDGE_LOSS_PER_EPSILON = 0.022, 0.04
# Of the convected profile, for each unit of the squared bearing number (marched on a strip).
CONVECTED_REMAINDER = 4.0
# The effects, by their names in tables.
NAMES = (
    *("inertia", "thermal", "depth_averaged", "slip", "flow_factor"),
    *("edge_loss", "bearing", "convected"),
)


class Effect(NamedTuple):
    """One effect on the mean force.

    Attributes:
        percent: of the force, at first order, of a convected profile at second; NaN where it is
            not known.
        remainder_percent: size of what higher orders add; NaN where that is not known.
        included: the force has it already.
        estimate: it is no first order, and may be smaller than what it misses.
    """

    percent: float
    remainder_percent: float = nan
    included: bool = False
    estimate: bool = False

    @property
    def usable(self) -> bool:
        """Return whether the first order is larger than its remainder allows."""
        return self.estimate or not abs(self.remainder_percent) > abs(self.percent) / 2

    def below(self, percent: float) -> bool:
        """Return whether it is known to be smaller; not where it is unknown or no first order."""
        return self.usable and abs(self.percent) + self.remainder_percent < percent

    @property
    def off_percent(self) -> float:
        """Return the error of the estimate: higher orders and coarse grids."""
        return self.remainder_percent + OFF_ON_GRIDS * abs(self.percent)


UNKNOWN, NONE = Effect(nan), Effect(0.0, 0.0)


@dataclass(frozen=True)
class ErrorBudget:
    """The effects on one scene's force.

    Attributes:
        effects: by NAMES. ``inertia`` of the gas; ``thermal`` of compression and friction, between
            walls at ambient temperature; ``depth_averaged``, error of both as the scene has them;
            ``slip``, by the flow factor, or as the scene has it; ``flow_factor``, the difference of
            first-order slip from that factor; ``edge_loss``, for the coefficient C = 1,
            with the remainder at the largest C; ``bearing`` of a sliding pad, for a profile at rest
            under it; ``convected``, of the profile moving past it.
        status: ``ok``, or why there are none.
    """

    effects: Mapping[str, Effect] = field(default_factory=lambda: dict.fromkeys(NAMES, UNKNOWN))
    status: str = "ok"

    @property
    def known(self) -> ErrorBudget:
        """The budget as if what is not known in it were nothing."""
        effects = {k: NONE if isnan(each.percent) else each for k, each in self.effects.items()}
        return replace(self, effects=effects)

    @property
    def first_order_invalid(self) -> list[str]:
        """The names of neglected effects beyond first order."""
        effects = self.effects.items()
        return [name for name, each in effects if not (each.usable or each.included)]

    def sums(self, *, neglected_only: bool) -> tuple[float, float]:
        """Lower and upper end of all effects together, or of those that the force does not have.

        The band holds both ends of the edge loss' coefficient and by what the effects may be off,
        all in one direction. NaN where an effect is not known.
        """
        some = [each for each in self.effects.values() if not (neglected_only and each.included)]
        for_one, edge = sum(each.percent for each in some), self.effects["edge_loss"]
        ends = [for_one + (share - 1) * edge.percent for share in (EDGE_LOSS_LEAST, EDGE_LOSS_MOST)]
        off = sum(each.off_percent for each in some) + (EDGE_LOSS_MOST - 1) * edge.off_percent
        return min(ends) - off, max(ends) + off

    @property
    def modelling_error_percent(self) -> tuple[float, float]:
        """Lower and upper end of all neglected effects together."""
        return self.sums(neglected_only=True)


NOT_FOUND = "not converged: GMRES for the adjoint problem of the error budget"


def error_budgets(
    scenes: Sequence[Scene], *, device: Device | None = None, names: Collection[str] = NAMES
) -> list[ErrorBudget]:
    """The budget of each scene's force.

    Every effect is one about the film without inertia and thermal effects, which are two of them.

    Args:
        names: of the effects that are needed; others are those of NONE.
    """
    found: list[ErrorBudget] = []
    for first in range(0, len(scenes), MOST_SCENES):
        some = list(scenes[first : first + MOST_SCENES])
        plain = [each.viscous() for each in some]
        found += map(_with_terms_of, _budgets(plain, device, names), some)
    return found


def _budgets(
    scenes: list[Scene], device: Device | None, names: Collection[str]
) -> list[ErrorBudget]:
    found = [ErrorBudget(status="no vibration, no force")] * len(scenes)
    moving = [k for k, scene in enumerate(scenes) if scene.epsilon]
    solved = with_states([scenes[k] for k in moving], tolerance=GRID_TOLERANCE, device=device)
    with_state: Solved = {}
    for k, solution in zip(moving, solved, strict=True):
        found[k] = ErrorBudget(status=solution.status)
        if solution.states:
            with_state[k] = scenes[k], solution
    for group in alike(with_state, numbers=MOST_NUMBERS):
        shares = _shares(group, device, names)
        for n, k in enumerate(group):
            percent = {name: 100 * float(share[n]) for name, share in shares.items()}
            found[k] = _budget(scenes[k], percent)
    return found


def _with_terms_of(budget: ErrorBudget, scene: Scene) -> ErrorBudget:
    """The budget with what a scene's force has of inertia and thermal effects, and their error."""
    own = {
        name: budget.effects[name]._replace(included=getattr(scene.gas, name) == "included")
        for name in OPEN
    }
    if budget.status == "ok":
        own["depth_averaged"] = Effect(*depth_averaging_percent(scene), estimate=True)
    return replace(budget, effects={**budget.effects, **own})


# Effects that are sources of mass in a scene's own state.
BY_FLUX: dict[tuple[str, ...], Callable[..., np.ndarray | tuple[np.ndarray, ...]]] = {
    ("inertia",): first_order.by_inertia,
    ("thermal",): first_order.by_thermal,
    ("slip", "flow_factor"): first_order.by_slip,
    ("edge_loss",): first_order.by_edge_loss,
}


def _shares(group: Solved, device: Device | None, names: Collection[str]) -> dict[str, np.ndarray]:
    """Change of the mean force by each effect, relative to it, of scenes of like terms."""
    scenes, solutions = map(list, zip(*group.values(), strict=True))
    films = fields_of(scenes, solutions, grid=0)
    with np.errstate(all="ignore"):
        answers = Answers(films, sensitivity(films, tolerance=ADJOINT_TOLERANCE))
        force = films.mean(films.overpressure)
        shares = {
            name: change / force
            for effects, change_by in BY_FLUX.items()
            if not set(effects).isdisjoint(names)
            for name, change in zip(
                effects, np.atleast_2d(change_by(scenes, films, answers)), strict=True
            )
        }
        if "bearing" in names and any(scene.bearing_number for scene in scenes):
            shares["bearing"], shares["convected"] = first_order.by_sliding(
                scenes, films.grid, device=device or choose_device()
            )
    return shares


def _budget(scene: Scene, percent: dict[str, float]) -> ErrorBudget:
    """A scene's budget from its effects; without those that its gas does not allow."""
    if not all(map(isfinite, percent.values())):
        return ErrorBudget(status=NOT_FOUND)
    reynolds, isothermal = scene.modified_reynolds, scene.gas.polytropic_exponent == 1
    remainder = {
        "inertia": (INERTIA_REMAINDER[0] + INERTIA_REMAINDER[1] * scene.epsilon**2) * reynolds,
        "thermal": (THERMAL_REMAINDER[0] + THERMAL_REMAINDER[1] * scene.epsilon**2) * reynolds,
        "slip": SLIP_REMAINDER * 6 * scene.knudsen,
        "flow_factor": SLIP_REMAINDER * 6 * scene.knudsen,
        "edge_loss": edge_loss_remainder(EDGE_LOSS_MOST * reynolds, scene.epsilon),
        "bearing": 0.0,
        "convected": CONVECTED_REMAINDER * scene.bearing_number**2,
    }
    included = {"slip": scene.gas.rarefaction != "none", "bearing": True}
    effects = dict.fromkeys(NAMES, NONE) | {
        name: Effect(each, remainder[name] * abs(each), included.get(name, False))
        for name, each in percent.items()
    }
    if not isothermal:  # it stands for thermal effects; a convected profile's is that of such a gas
        effects |= {name: UNKNOWN for name in ("thermal", "convected") if name in percent}
    return ErrorBudget(effects)


def edge_loss_remainder(coefficient_reynolds: float, epsilon: float) -> float:
    """Return the remainder of the edge loss as a fraction of its first order, for C Re."""
    return coefficient_reynolds * min(EDGE_LOSS_REMAINDER, EDGE_LOSS_PER_EPSILON * epsilon)


# Mean force of a square piston at second order of small motion, over ε² and p0 times the pad's
# area, with the depth-averaged terms and resolved across the gap: isothermal velocity; or, where
# thermal is 1, temperature too (Pr 0.71, γ 1.4, κ 0.7; the solver's averaged force at ε = 0.005).
TABLE = Path(__file__).with_name("depth_averaged.csv")
# Below THICK_SIGMA strips that resolve the profiles were compared up to this Re, and no further.
MOST_REYNOLDS_THICK = 2.0
# By how much the change may be off, as a share of the largest at the same Re, for ε → 0 and for
# each unit of ε: 288 strips that resolve the profiles, piston and sinc, ε 0.02–0.8, σ 0.5–1e4.
OFF, OFF_PER_EPSILON = 0.7, 1.0
OFF_THICK, OFF_THICK_PER_EPSILON = 2.0, 5.0


def depth_averaging_percent(scene: Scene) -> tuple[float, float]:
    """Return what resolving the profiles across the gap changes of a scene's force, and its error.

    An estimate for depth-averaged inertia and thermal effects: a parabola stands for each profile.
    The error grows as Re² at first and depends little on the squeeze number. At Re 40 it is 2.9 to
    11 %, too far from that at 20 to be interpolated: at small σ the force has resonances in Re.

    Returns:
        The change in per cent of the force, and its error: other profiles and
        amplitudes than the table's. 0 where the scene has neither term; NaN beyond the table's Re,
        and beyond Re 2 below its σ. Where no sign is known, the change is 0 and its error up to its
        size: below the table's σ, and for thermal effects alone.
    """
    inertia, thermal = (getattr(scene.gas, name) == "included" for name in OPEN)
    reynolds, sigma = scene.modified_reynolds, scene.sigma
    if not (inertia or thermal):
        return 0.0, 0.0
    from scipy.interpolate import PchipInterpolator

    thick = sigma < THICK_SIGMA
    nodes, known, changes = _depth_averaging_errors(thermal)
    if reynolds > (MOST_REYNOLDS_THICK if thick else known[-1]):
        return nan, nan
    along = reynolds**2 * PchipInterpolator(known, changes)(max(reynolds, known[0]))
    largest = float(np.abs(along).max())
    if thick or not inertia:
        return 0.0, largest * (OFF_THICK + OFF_THICK_PER_EPSILON * scene.epsilon)
    change = float(np.interp(sigma**-0.5, nodes, along))
    return change, largest * (OFF + OFF_PER_EPSILON * scene.epsilon)


@lru_cache(maxsize=2)
def _depth_averaging_errors(thermal: bool) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Nodes in 1/√σ, rising from 0, Reynolds numbers, and the change in per cent over Re² there.

    For thin layers the change goes by powers of 1/√σ, so that two columns give that of σ → ∞.
    """
    table = np.genfromtxt(TABLE, delimiter=",", names=True)
    table = table[table["thermal"] == thermal]
    reynolds, sigma = np.unique(table["reynolds"]), np.unique(table["sigma"])[::-1]
    change = 100 * (table["resolved"] / table["averaged"] - 1) / table["reynolds"] ** 2
    change, nodes = change.reshape(len(reynolds), -1)[:, ::-1], sigma**-0.5
    slope = (change[:, 1] - change[:, 0]) / (nodes[1] - nodes[0])
    change = np.column_stack([change[:, 0] - slope * nodes[0], change])
    return np.append(0.0, nodes), reynolds, change


# Change of the force, relative, from which on a term that is ``auto`` is included. An effect of
# this share of it is included too: its first order is good to a few per cent where it is small.
MODEL_TOLERANCE, NEARLY = 1e-3, 0.8
# Terms that a study may leave to be decided, in the order in which they are.
OPEN: dict[str, Term] = {"inertia": Inertia(), "thermal": Thermal()}


def resolve_auto_terms(
    scenes: Scenes | Sequence[Scene],
    *,
    model_tolerance: float = MODEL_TOLERANCE,
    method: str = "auto",
    device: Device | None = None,
) -> Scenes | Sequence[Scene]:
    """The scenes with each term of OPEN ``included`` or ``none`` in the place of ``auto``.

    It is included where it changes the force by more than the tolerance, relative, or by what is
    not known, or not by a first order; and excluded where the method or the scene's other terms do
    not allow it, which the scene's budget shows.
    """
    if not any(map(_auto, scenes.films if isinstance(scenes, Scenes) else scenes)):
        return scenes
    scenes = Scenes.of(scenes)
    index = scenes.film_index.tolist()
    # Whether a term is supported does not depend on the operating point.
    asked = {
        index[row]: [name for name in _auto(scene) if not _refused(scene, name, method)]
        for row in np.unique(index, return_index=True)[1].tolist()
        for scene in [scenes[row]]
    }
    closed = replace(scenes, films=tuple(map(_closed, scenes.films)))
    rows = np.flatnonzero([bool(asked[film]) for film in index])
    names = {name for some in asked.values() for name in some}
    found = error_budgets(closed[rows], device=device, names=names)
    budgets, limit = dict(zip(rows.tolist(), found, strict=True)), 100 * NEARLY * model_tolerance
    # Unknown effects, as without a budget, are not below.
    chosen = [
        (film, tuple(k for k in asked[film] if not budgets[row].effects[k].below(limit)))
        for row, film in enumerate(index)
    ]
    places = {choice: place for place, choice in enumerate(dict.fromkeys(chosen))}
    films = tuple(
        closed.films[film].with_gas(**dict.fromkeys(included, "included"))
        for film, included in places
    )
    return replace(scenes, films=films, film_index=np.array([places[each] for each in chosen]))


def excluded_terms(scene: Scene, *, method: str = "auto") -> list[str]:
    """Return the terms that are ``auto`` and not supported for a scene, with the reasons."""
    return [
        f"gas.{name} is auto and not included: {reason}"
        for name in _auto(scene)
        if (reason := _refused(scene, name, method))
    ]


AnyFilm = TypeVar("AnyFilm", Scene, Film)


def _auto(scene: Scene | Film) -> list[str]:
    return [name for name in OPEN if getattr(scene.gas, name) == "auto"]


def _closed(scene: AnyFilm) -> AnyFilm:
    """The scene or film without what is to be decided."""
    return scene.with_gas(**dict.fromkeys(_auto(scene), "none"))


def _refused(scene: Scene, name: str, method: str) -> str:
    """Return the reason why the method does not support a term; empty if it does."""
    scene = _closed(scene).with_gas(**{name: "included"})
    if method == "composite":
        derived = OPEN[name].IN_EXPANSIONS
        return "" if derived else "the composite expansion is not derived with it"
    return refused_on_grid(scene, terms_of(scene))


def budget_row(budget: ErrorBudget) -> dict[str, object]:
    """A budget as columns of a table, in per cent of the force.

    ``…_remainder_percent`` is the size of what higher orders add, where it is known. The edge loss
    is for C = 1, and for the largest C in ``edge_loss_upper_percent``; the sums' ends hold both,
    and the errors of all effects. ``included_effects`` names the effects that the force includes,
    ``first_order_invalid`` those beyond first order.
    """
    row: dict[str, object] = {}
    effects = budget.effects.items()
    for name, effect in effects:
        row[f"{name}_percent"] = effect.percent
        if name != "bearing":
            row[f"{name}_remainder_percent"] = effect.remainder_percent
    row["edge_loss_upper_percent"] = EDGE_LOSS_MOST * budget.effects["edge_loss"].percent
    for what, only in (("sum", False), ("modelling_error", True)):
        ends = budget.sums(neglected_only=only)
        row[f"{what}_lower_percent"], row[f"{what}_upper_percent"] = ends
    return row | {
        "included_effects": "; ".join(name for name, each in effects if each.included),
        "first_order_invalid": "; ".join(name for name, each in effects if not each.usable),
        "status": budget.status,
    }
