"""Limits of validity of the film equation, as data, and whether there is a film at all.

Within the limits the budget of a force (quantities/model_error.py) states what the equation
neglects. Beyond them the force is still solved for, and the estimate of its modelling error is
unverified, or the equation does not apply. The list, with reasons and sources: ``validity.csv``.
"""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import inf, isfinite
from pathlib import Path
from typing import Any

import numpy as np

from squeezefilm.errors import (
    MAX_ROWS_IN_MESSAGE,
    InputError,
    point_text,
    raise_first_problem,
    raise_row_problems,
)
from squeezefilm.film.pad import Pad
from squeezefilm.film.scene import Scene, Scenes
from squeezefilm.film.surfaces import Surface

OK = "ok"
ERROR_UNVERIFIED_TEXT = "modelling error unverified"
NOT_APPLICABLE_TEXT = "the equation does not apply"
RAREFIED_REMEDY_TEXT = "use gas.rarefaction: fukui-kaneko"
# Squeeze number below which gas is pumped in and out and hardly compressed.
THICK_FILM_SIGMA = 20.0
# Roughness Ra of a finely ground or lapped surface, in m.
LAPPED_ROUGHNESS_M = 1e-7


def _sound_speed(scenes: Scenes) -> Any:
    gas = scenes.gas
    return (gas.heat_capacity_ratio * gas.ambient_pressure_pa / gas.density_kg_per_m3) ** 0.5


def _ratio_to_gap(value: Any, gap: np.ndarray) -> np.ndarray:
    return np.divide(value, gap, out=np.full(gap.shape, inf), where=gap > 0)


def _couette_reynolds(scenes: Scenes) -> Any:
    """ρ |U| h / μ of the widest gap at rest."""
    per_length = scenes.shear_reynolds * scenes.pad.length_x_m / scenes.h0_m
    return per_length * scenes.static_gap_ratio_range[1]


# The list's quantities by their symbols: Kn where the gap at rest is narrowest, Re, Re_s and ρUh/μ
# where widest.
SYMBOL_FUNCTIONS: dict[str, Callable[[Scenes], Any]] = {
    "h0/l": lambda s: s.h0_m / np.minimum(s.pad.length_x_m, s.pad.length_y_m),
    "Kn": lambda s: _ratio_to_gap(s.knudsen, s.static_gap_ratio_range[0]),
    "Re": lambda s: s.modified_reynolds * s.static_gap_ratio_range[1] ** 2,
    "h0/λ": lambda s: s.h0_m * s.actuator.frequency_hz / _sound_speed(s),
    "Ma": lambda s: np.full(len(s), np.abs(s.pad.speed_x_m_per_s) / _sound_speed(s)),
    "Re_s": lambda s: s.shear_reynolds * s.static_gap_ratio_range[1] ** 2,
    "ρUh/μ": _couette_reynolds,
    "hv/h0": lambda s: s.closure,
    "Ra/h": lambda s: _ratio_to_gap(LAPPED_ROUGHNESS_M, s.narrowest_gap_ratio * s.h0_m),
}
# The list's kinds of films; ``auto`` terms are decided before (quantities/model_error.py).
FILM_KIND_CONDITIONS: dict[str, Callable[[Scenes], Any]] = {
    "all": lambda s: True,
    "viscous flow": lambda s: s.gas.rarefaction == "none",
    "first-order slip": lambda s: s.gas.rarefaction == "slip",
    "flow factor": lambda s: s.gas.rarefaction == "fukui-kaneko",
    "inertia neglected": lambda s: s.gas.inertia != "included",
    "inertia included": lambda s: s.gas.inertia == "included",
    "thermal effects included": lambda s: s.gas.thermal == "included",
    "inertia included, σ below 20": lambda s: (
        (s.gas.inertia == "included") & (s.sigma < THICK_FILM_SIGMA)
    ),
}


@dataclass(frozen=True)
class ValidityLimit:
    """A quantity of a scene and the values up to which the film equation is known to hold.

    Attributes:
        quantity, symbol: in words and as in formulas; SYMBOL_FUNCTIONS has its value.
        film_kind: which the limit is for, of FILM_KIND_CONDITIONS.
        unverified_above: value above which the modelling error of a force is unverified.
        not_applicable_above: value above which the equation does not apply.
        source: reason for the values, and where they are from.
    """

    quantity: str
    symbol: str
    film_kind: str
    unverified_above: float
    not_applicable_above: float
    source: str

    @cached_property
    def lowest_bound(self) -> float:
        """The value up to which nothing is exceeded."""
        return min(self.not_applicable_above, self.unverified_above)

    def bound_and_consequence_texts(self, value: float) -> tuple[str, str]:
        """Return the bound that a value exceeds, and what that means."""
        never = not value <= self.not_applicable_above
        bound = self.not_applicable_above if never else self.unverified_above
        kind = "" if self.film_kind == "all" else f" ({self.film_kind})"
        remedy = f" ({RAREFIED_REMEDY_TEXT})" if never and self.symbol == "Kn" else ""
        consequence = NOT_APPLICABLE_TEXT if never else ERROR_UNVERIFIED_TEXT
        return f"{float(f'{bound:.2g}'):g}{kind}", f"{consequence}{remedy}"


def _message_texts(exceeded: Sequence[tuple[ValidityLimit, float]]) -> list[str]:
    """Return a text for each quantity and consequence of limits that values exceed."""
    bounds: dict[tuple[str, str], list[str]] = {}
    for limit, value in exceeded:
        number = f"{value:.3g}" if isfinite(value) else "infinite (the gap closes)"
        bound, consequence = limit.bound_and_consequence_texts(value)
        named = f"{limit.quantity} {limit.symbol} = {number}"
        bounds.setdefault((named, consequence), []).append(bound)
    return [
        f"{named} is above {' and '.join(several)}: {consequence}"
        for (named, consequence), several in bounds.items()
    ]


def _read_limits(path: Path) -> tuple[ValidityLimit, ...]:
    with path.open(encoding="utf-8", newline="") as file:
        return tuple(
            ValidityLimit(
                quantity, symbol, films, float(unknown or inf), float(never or inf), source
            )
            for quantity, symbol, films, unknown, never, source in list(csv.reader(file))[1:]
        )


VALIDITY_LIMITS = _read_limits(Path(__file__).with_name("validity.csv"))


def exceeded_limit_texts(
    scene: Scene, symbols: Iterable[str] = SYMBOL_FUNCTIONS
) -> tuple[str, ...]:
    """Return each limit of some quantities that a scene exceeds, in words.

    Quantity, value, bound, consequence.
    """
    return tuple(exceeded_limits_by_scene(Scenes.of([scene]), symbols)[0])


def validity_text(scene: Scene) -> str:
    """Return ``ok``, or the limits of validity that a scene exceeds, joined by ``; ``."""
    return "; ".join(exceeded_limit_texts(scene)) or OK


def validity_texts(scenes: Scenes) -> np.ndarray:
    """Return the same for each of some scenes."""
    return np.array(
        ["; ".join(exceeded) or OK for exceeded in exceeded_limits_by_scene(scenes)], dtype=object
    )


def exceeded_limits_by_scene(
    scenes: Scenes, symbols: Iterable[str] = SYMBOL_FUNCTIONS
) -> list[list[str]]:
    """Return the limits of some quantities that each scene exceeds, in words."""
    exceeded: list[list[tuple[ValidityLimit, float]]] = [[] for _ in range(len(scenes))]
    limits = [limit for limit in VALIDITY_LIMITS if limit.symbol in symbols]
    values = {symbol: SYMBOL_FUNCTIONS[symbol](scenes) for symbol in symbols}
    # A value that is no number lies within no bound.
    bounds = [[limit.lowest_bound] for limit in limits]
    beyond = ~(np.array([values[limit.symbol] for limit in limits]) <= bounds)
    for at in np.flatnonzero(beyond.any(axis=1)).tolist():
        limit = limits[at]
        for row in np.flatnonzero(
            beyond[at] & FILM_KIND_CONDITIONS[limit.film_kind](scenes)
        ).tolist():
            exceeded[row].append((limit, float(values[limit.symbol][row])))
    return [_message_texts(limits) for limits in exceeded]


GAP_RANGE_M = (1e-9, 1e-3)
ACTUATOR_EDGE_TOLERANCE = 1e-9


def check_scenes(scenes: Scenes) -> None:
    """Reject scenes as ``check_scene`` does, all of them that have no solution in one message."""
    place = "operating point" if scenes.point_id.tolist() == ["1"] else None
    invalid = np.flatnonzero(~solvable_scene_mask(scenes)).tolist()
    problems = []
    for row in invalid[:MAX_ROWS_IN_MESSAGE]:
        try:
            check_scene(scenes[row], place=place)
        except InputError as error:
            problems.append(str(error))
    # A pad that does not fit is one problem of all its rows.
    distinct = list(dict.fromkeys(problems))
    raise_row_problems(distinct, count=len(invalid) - len(problems) + len(distinct))


def solvable_scene_mask(scenes: Scenes) -> np.ndarray:
    """Return which scenes have a solution and lie on the actuator, shape (n,)."""
    h0_m, hv_m = scenes.h0_m, scenes.hv_m
    sound = (GAP_RANGE_M[0] <= h0_m) & (h0_m <= GAP_RANGE_M[1]) & (hv_m >= 0) & (hv_m < h0_m)
    for film, rows, scenes_of_film in scenes.split_by_film():
        sound[rows] &= on_surface_mask(
            film.pad.edge_points_m(),
            film.actuator.surface,
            x_m=scenes_of_film.x_m,
            y_m=scenes_of_film.y_m,
        )
    sound[sound] = (scenes if sound.all() else scenes[sound]).closure < 1
    return sound


def on_surface_mask(
    outline_m: np.ndarray, surface: Surface, *, x_m: np.ndarray, y_m: np.ndarray
) -> np.ndarray:
    """Return at which positions of its centre a pad lies on the surface, shape (n,).

    Args:
        outline_m: points of the pad's edge from its centre, shape (points, 2).
    """
    edge_x_m, edge_y_m = (np.add.outer(at, outline_m[:, k]) for k, at in enumerate((x_m, y_m)))
    distance = surface.relative_distance(edge_x_m, edge_y_m)
    return np.asarray((distance <= 1 + ACTUATOR_EDGE_TOLERANCE).all(axis=1))


def off_surface_text(outline_m: np.ndarray, surface: Surface, *, x_m: float, y_m: float) -> str:
    """Return where a pad reaches beyond the surface and how far its centre may lie.

    Args:
        outline_m: points of the pad's edge from its centre: a rectangle's corners, or more.
    """
    edge_x_m, edge_y_m = np.add(outline_m, (x_m, y_m)).T
    farthest = np.argmax(surface.relative_distance(edge_x_m, edge_y_m))
    return (
        f"with its centre at x = {x_m * 1e3:.2f} mm, y = {y_m * 1e3:.2f} mm "
        f"{'a corner' if len(outline_m) == 4 else 'the edge'} of the pad lies "
        f"{surface.position_text(edge_x_m[farthest], edge_y_m[farthest])}, off the actuator's "
        f"{surface.text}; {surface.allowed_positions_text(outline_m, x_m, y_m)}"
    )


def contact_text(h0_m: float, hv_m: float) -> str:
    """Return that an amplitude reaches the mean gap."""
    return f"hv = {1e6 * hv_m:g} µm reaches h0 = {1e6 * h0_m:g} µm: surface and pad touch"


def check_pad_fits(pad: Pad, surface: Surface) -> None:
    """Reject a pad that reaches beyond the actuator with its centre at the actuator's."""
    outline_m = pad.edge_points_m()
    if not surface.relative_distance(*outline_m.T).max() <= 1 + ACTUATOR_EDGE_TOLERANCE:
        raise InputError(
            f"pad: {surface.pad_extent_text(outline_m)} and must lie on the actuator's "
            f"{surface.text} ({surface.config_key}); give a smaller pad or a larger surface"
        )


def check_scene(scene: Scene, *, place: str | None = None) -> None:
    """Reject a scene that has no solution or lies off the actuator.

    Args:
        place: words for the scene in a message, instead of its name.

    Raises InputError naming the point, the factor and what is allowed.
    """
    source, h0_m, hv_m = place or point_text(scene.point_id), scene.h0_m, scene.hv_m
    least_um, largest_um = (1e6 * gap_m for gap_m in GAP_RANGE_M)
    raise_first_problem(
        source,
        {
            f"h0 = {1e6 * h0_m:g} µm must lie between {least_um:g} and {largest_um:g} µm: the model"
            " of a gas film is not valid outside this range": not GAP_RANGE_M[0]
            <= h0_m
            <= GAP_RANGE_M[1],
            f"hv = {1e6 * hv_m:g} µm must not be negative": not hv_m >= 0,
            f"{contact_text(h0_m, hv_m)}; the amplitude must stay below the mean gap": hv_m >= h0_m,
        },
    )
    pad, surface = scene.pad, scene.actuator.surface
    outline_m, x_m, y_m = pad.edge_points_m(), scene.x_m, scene.y_m
    if not on_surface_mask(outline_m, surface, x_m=np.array([x_m]), y_m=np.array([y_m])).all():
        check_pad_fits(pad, surface)
        where = off_surface_text(outline_m, surface, x_m=x_m, y_m=y_m)
        raise InputError(f"{source}: {where}")
    contact = "they touch within the noise of the measured profile"
    if not scene.pad.gap.flat:
        contact = "the tilted or crowned pad touches the surface; pad.gap leaves too little"
    raise_first_problem(
        source, {f"h0 = {1e6 * h0_m:g} µm, hv = {1e6 * hv_m:g} µm: {contact}": scene.closure() >= 1}
    )
