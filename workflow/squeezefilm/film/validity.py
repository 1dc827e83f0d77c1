"""Limits of validity of the film equation, as data, and which of them a scene exceeds.

Within the limits the budget of a force (quantities/model_error.py) states what the equation
neglects. Beyond them the force is still solved for, and its error as a statement about a real film
is unknown, or the equation does not apply. The list, with reasons and sources, is ``validity.csv``.
"""

from __future__ import annotations

import csv
from collections.abc import Callable
from dataclasses import dataclass
from math import inf, sqrt
from pathlib import Path

from squeezefilm.film.scene import Scene

OK = "ok"
UNKNOWN, NOT_APPLICABLE = "error unknown", "the equation does not apply"
# Squeeze number below which gas is pumped in and out and hardly compressed.
THICK_SIGMA = 20.0
# Inverse Knudsen number at which Fukui and Kaneko's polynomial ends: √π/(2 D) is the list's Kn.
LEAST_INVERSE_KNUDSEN = 5.0
# Roughness Ra of a finely ground or lapped surface, in m.
ROUGHNESS_M = 1e-7


def _sound_speed(scene: Scene) -> float:
    gas = scene.gas
    return sqrt(gas.heat_capacity_ratio * gas.ambient_pressure_pa / gas.density_kg_per_m3)


def _over(value: float, gap: float) -> float:
    return value / gap if gap > 0 else inf


# The list's quantities by their symbols: Kn where the gap at rest is narrowest, Re where widest.
QUANTITIES: dict[str, Callable[[Scene], float]] = {
    "h0/l": lambda s: s.h0_m / min(s.finger.length_x_m, s.finger.length_y_m),
    "Kn": lambda s: _over(s.knudsen, s.rest_range[0]),
    "Re": lambda s: s.modified_reynolds * s.rest_range[1] ** 2,
    "h0/λ": lambda s: s.h0_m * s.actuator.frequency_hz / _sound_speed(s),
    "hv/h0": Scene.closure,
    "Ra/h": lambda s: _over(ROUGHNESS_M, s.narrowest * s.h0_m),
}
# The list's kinds of films; ``auto`` terms are decided before (quantities/model_error.py).
FILMS: dict[str, Callable[[Scene], bool]] = {
    "all": lambda s: True,
    "viscous flow": lambda s: s.gas.rarefaction == "none",
    "first-order slip": lambda s: s.gas.rarefaction == "slip",
    "Fukui and Kaneko's flow factor": lambda s: s.gas.rarefaction == "fukui-kaneko",
    "inertia neglected": lambda s: s.gas.inertia != "included",
    "inertia included": lambda s: s.gas.inertia == "included",
    "heat included": lambda s: s.gas.heat == "included",
    "inertia included, σ below 20": lambda s: s.gas.inertia == "included" and s.sigma < THICK_SIGMA,
}


@dataclass(frozen=True)
class Limit:
    """A quantity of a scene and the values up to which the film equation is known to hold.

    Attributes:
        quantity, symbol: in words and as in formulas; QUANTITIES has its value.
        films: which the limit is for, of FILMS.
        unknown_above: value above which the error of a force is unknown.
        not_above: value above which the equation does not apply.
        source: reason for the values, and where they are from.
    """

    quantity: str
    symbol: str
    films: str
    unknown_above: float
    not_above: float
    source: str

    def exceeded(self, scene: Scene) -> str:
        """Return by what a scene exceeds the limit, in words; empty where it does not."""
        if not FILMS[self.films](scene):
            return ""
        value = QUANTITIES[self.symbol](scene)
        bounds = ((self.not_above, NOT_APPLICABLE), (self.unknown_above, UNKNOWN))
        kind = "" if self.films == "all" else f" ({self.films})"
        for bound, consequence in bounds:
            if not value <= bound:  # a value that is no number lies within no bound
                named = f"{self.quantity} {self.symbol} = {value:.3g}"
                return f"{named} is above {bound:.2g}{kind}: {consequence}"
        return ""


def _read(path: Path) -> tuple[Limit, ...]:
    with path.open(encoding="utf-8", newline="") as file:
        return tuple(
            Limit(quantity, symbol, films, float(unknown or inf), float(never or inf), source)
            for quantity, symbol, films, unknown, never, source in list(csv.reader(file))[1:]
        )


LIMITS = _read(Path(__file__).with_name("validity.csv"))


def exceeded(scene: Scene) -> tuple[str, ...]:
    """Return each limit that a scene exceeds, in words: quantity, value, bound, consequence."""
    return tuple(words for limit in LIMITS if (words := limit.exceeded(scene)))


def validity(scene: Scene) -> str:
    """Return ``ok``, or the limits of validity that a scene exceeds, joined by ``; ``."""
    return "; ".join(exceeded(scene)) or OK
