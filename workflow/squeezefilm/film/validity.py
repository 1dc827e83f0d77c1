"""Limits of validity of the film equation, as data, and which of them a scene exceeds.

Within the limits the budget of a force (reynolds/effects) says what the equation neglects. Beyond
them the force is still solved for, and its error as a statement about a real film is unknown, or
the equation does not apply.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import inf, pi, sqrt

from squeezefilm.film.scene import Scene

OK = "ok"
UNKNOWN, NOT_APPLICABLE = "error unknown", "the equation does not apply"
# Inverse Knudsen number below which Fukui and Kaneko's polynomial ends (terms/rarefaction.py).
LEAST_INVERSE_KNUDSEN = 5.0
# Above this D falls below that: gas neither slips nor flows as a viscous fluid.
TRANSITION_KNUDSEN = sqrt(pi) / (2 * LEAST_INVERSE_KNUDSEN)
# Squeeze number below which gas is pumped in and out and hardly compressed.
THICK_SIGMA = 20.0


@dataclass(frozen=True)
class Limit:
    """A quantity of a scene and the values up to which the film equation is known to hold.

    Attributes:
        quantity, symbol: in words and as in formulas.
        of: the quantity of a scene, dimensionless.
        holds_for: the scenes that the limit is for, in words; ``applies`` selects them.
        unknown_above: value above which the error of a force is unknown.
        not_above: value above which the equation does not apply.
        source: reason for the values, and where they are from.
    """

    quantity: str
    symbol: str
    of: Callable[[Scene], float]
    source: str
    unknown_above: float = inf
    not_above: float = inf
    holds_for: str = "all"
    applies: Callable[[Scene], bool] = lambda scene: True

    def exceeded(self, scene: Scene) -> str:
        """Return by what a scene exceeds the limit, in words; empty where it does not."""
        if not self.applies(scene):
            return ""
        value = self.of(scene)
        # A value that is no number lies within no bound.
        for bound, consequence in (
            (self.not_above, NOT_APPLICABLE),
            (self.unknown_above, UNKNOWN),
        ):
            if not value <= bound:
                return (
                    f"{self.quantity} {self.symbol} = {value:.3g} is above {bound:.2g}"
                    f"{'' if self.holds_for == 'all' else f' ({self.holds_for})'}: {consequence}"
                )
        return ""


def _rarefaction(model: str) -> Callable[[Scene], bool]:
    return lambda scene: scene.gas.rarefaction == model


def _inertia(scene: Scene) -> bool:
    """Whether inertia is in the equation; ``auto`` is decided before (effects/automatic.py)."""
    return scene.gas.inertia == "included"


def _largest_knudsen(scene: Scene) -> float:
    """Knudsen number where the gap at rest is narrowest."""
    least, _ = scene.rest_range
    return scene.knudsen / least if least > 0 else inf


def _largest_reynolds(scene: Scene) -> float:
    """Modified Reynolds number where the gap at rest is widest."""
    return scene.modified_reynolds * scene.rest_range[1] ** 2


def _thinness(scene: Scene) -> float:
    return scene.h0_m / min(scene.finger.length_x_m, scene.finger.length_y_m)


def _gap_in_wavelengths(scene: Scene) -> float:
    """Mean gap over the length of a sound wave in the free gas."""
    gas = scene.gas
    speed = sqrt(gas.heat_capacity_ratio * gas.ambient_pressure_pa / gas.density_kg_per_m3)
    return scene.h0_m * scene.actuator.frequency_hz / speed


# Roughness Ra of a finely ground or lapped surface, in m.
ROUGHNESS_M = 1e-7


def _roughness_over_gap(scene: Scene) -> float:
    narrowest_m = scene.narrowest * scene.h0_m
    return ROUGHNESS_M / narrowest_m if narrowest_m > 0 else inf


KNUDSEN = "Knudsen number"
REYNOLDS = "modified Reynolds number"
BY_SLIP_AT_FIRST_ORDER = (
    "the budget's first order of slip is more than what it misses up to here; beyond D = 5 the "
    "flow is neither viscous nor slipping (Fukui and Kaneko, J. Tribology 112, 1990)"
)
LIMITS: tuple[Limit, ...] = (
    Limit(
        "gap over the pad's shorter side",
        "h0/l",
        _thinness,
        unknown_above=0.01,
        not_above=0.1,
        source=(
            "flow around the edge is of the order of h0/l: it lengthens a pad by about 1.3 h0 "
            "(Veijola, Pursula and Råback, J. Micromech. Microeng. 15, 2005), and no term has it; "
            "above a tenth there is no thin film"
        ),
    ),
    Limit(
        KNUDSEN,
        "Kn",
        _largest_knudsen,
        unknown_above=0.07,
        not_above=TRANSITION_KNUDSEN,
        holds_for="viscous flow",
        applies=_rarefaction("none"),
        source=BY_SLIP_AT_FIRST_ORDER,
    ),
    Limit(
        KNUDSEN,
        "Kn",
        _largest_knudsen,
        unknown_above=0.1,
        not_above=TRANSITION_KNUDSEN,
        holds_for="first-order slip",
        applies=_rarefaction("slip"),
        source=(
            "first-order slip is derived for small Kn (Burgdorfer, J. Basic Eng. 81, 1959) and "
            "lacks a tenth of the flow at Kn 0.1 (Fukui and Kaneko, J. Tribology 112, 1990)"
        ),
    ),
    Limit(
        KNUDSEN,
        "Kn",
        _largest_knudsen,
        not_above=TRANSITION_KNUDSEN,
        holds_for="Fukui and Kaneko's flow factor",
        applies=_rarefaction("fukui-kaneko"),
        source="the flow factor's branch for D >= 5 (Fukui and Kaneko, J. Tribology 112, 1990)",
    ),
    Limit(
        REYNOLDS,
        "Re",
        _largest_reynolds,
        unknown_above=3.0,
        not_above=10.0,
        holds_for="inertia neglected",
        applies=lambda scene: not _inertia(scene),
        source=(
            "the budget's first order of inertia is more than what it misses up to Re 3; at Re 10 "
            "inertia changes the force of a square by 31 to 190 % (second-order theory for a "
            "square piston, resolved across the gap)"
        ),
    ),
    Limit(
        REYNOLDS,
        "Re",
        _largest_reynolds,
        unknown_above=20.0,
        holds_for="inertia included",
        applies=_inertia,
        source=(
            "compared with strips that resolve the velocity across the gap up to here (ε up to "
            "0.8), and with second-order theory for a square piston: there 2.9 to 11 % off at Re 40"
        ),
    ),
    Limit(
        REYNOLDS,
        "Re",
        _largest_reynolds,
        unknown_above=10.0,
        holds_for="heat included",
        applies=lambda scene: scene.gas.heat == "included",
        source="compared with strips and second-order theory that resolve the temperature, to here",
    ),
    Limit(
        REYNOLDS,
        "Re",
        _largest_reynolds,
        unknown_above=2.0,
        holds_for=f"inertia included, σ below {THICK_SIGMA:g}",
        applies=lambda scene: _inertia(scene) and scene.sigma < THICK_SIGMA,
        source=(
            "gas is hardly compressed: against strips that resolve the velocity across the gap "
            "within 0.2 % up to here, 5 % off at Re 5 (σ 7, ε 0.7) and 9 % at Re 10 (σ 5, ε 0.4)"
        ),
    ),
    Limit(
        "gap over the sound's wavelength",
        "h0/λ",
        _gap_in_wavelengths,
        unknown_above=0.02,
        not_above=0.1,
        source=(
            "the pressure is uniform across the gap but for (2π h0/λ)²/2 of it: 0.8 % at 0.02, "
            "a fifth at 0.1"
        ),
    ),
    Limit(
        "surface's excursion over the gap at rest",
        "hv/h0",
        lambda scene: scene.closure(),
        unknown_above=0.95,
        source="nearly touching: the force hangs on the last hundredths of the gap",
    ),
    Limit(
        "roughness of 0.1 µm over the narrowest gap",
        "Ra/h",
        _roughness_over_gap,
        unknown_above=1.0,
        source="nearly touching: a finely ground or lapped surface has Ra 0.1 µm",
    ),
)


def exceeded(scene: Scene) -> tuple[str, ...]:
    """Return each limit that a scene exceeds, in words: quantity, value, bound, consequence."""
    return tuple(words for limit in LIMITS if (words := limit.exceeded(scene)))


def validity(scene: Scene) -> str:
    """Return ``ok``, or the limits of validity that a scene exceeds, joined by ``; ``."""
    return "; ".join(exceeded(scene)) or OK
