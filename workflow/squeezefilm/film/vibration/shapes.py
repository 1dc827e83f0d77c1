"""Vibration shapes s(x, y) of an actuator's surface, with maximum 1."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from math import cos, inf, pi, radians, sin
from typing import Protocol

import numpy as np

from squeezefilm.film.vibration.surfaces import Disc, Surface
from squeezefilm.formulas.expressions import Expression, parse

MOST_KEPT = 1_000_000
"""Values of modes, points times modes, that are kept to be used again: 8 MB."""


UNBOUNDED = Disc(inf)


class Profile(Protocol):
    """A normalised amplitude of vibration over the actuator's surface."""

    def amplitude(self, *, x_m: np.ndarray, y_m: np.ndarray) -> np.ndarray:
        """Amplitude over its maximum at positions from the actuator's centre, any common shape."""
        ...

    def __hash__(self) -> int: ...


@dataclass(frozen=True)
class TwoPhases:
    """A vibration in two phases a quarter of a period apart, s₁ sin T + s₂ cos T.

    s₁ and s₂ are shares of two profiles, such that the largest of √(s₁² + s₂²) on the surface is 1.
    It has no ``amplitude``: what was derived for a vibration in one phase does not know it.
    ``largest`` is above 1 by what noise has put on a measured maximum.
    """

    first: Profile
    second: Profile
    shares: tuple[float, float] = (1.0, 1.0)
    largest: float = 1.0

    def parts(self, *, x_m: np.ndarray, y_m: np.ndarray) -> np.ndarray:
        """s₁ and s₂, shape (2, …)."""
        profiles = zip(self.shares, (self.first, self.second), strict=True)
        return np.stack([share * each.amplitude(x_m=x_m, y_m=y_m) for share, each in profiles])


Vibration = Profile | TwoPhases


def phasor_of(vibration: Vibration, *, x_m: np.ndarray, y_m: np.ndarray) -> np.ndarray:
    """s, or s₁ + i s₂ of a vibration in two phases; begun at another instant, it is turned."""
    parts = parts_of(vibration, x_m=x_m, y_m=y_m)
    return parts[0] if len(parts) == 1 else parts[0] + 1j * parts[1]


def shown_of(vibration: Vibration, *, x_m: np.ndarray, y_m: np.ndarray) -> np.ndarray:
    """What pictures show: s, or how far the surface moves in two phases, √(s₁² + s₂²)."""
    phasor = phasor_of(vibration, x_m=x_m, y_m=y_m)
    return np.abs(phasor) if np.iscomplexobj(phasor) else phasor


def parts_of(vibration: Vibration, *, x_m: np.ndarray, y_m: np.ndarray) -> np.ndarray:
    """s, or s₁ and s₂ of a vibration in two phases, shape (phases, …)."""
    if isinstance(vibration, TwoPhases):
        return vibration.parts(x_m=x_m, y_m=y_m)
    return vibration.amplitude(x_m=x_m, y_m=y_m)[None]


@dataclass(frozen=True)
class Sinc:
    """s = sin(πkr)/(πkr), the paper's eq. (2) with k = 109.8 per metre (MATLAB's sinc)."""

    wave_number_per_m: float

    def amplitude(self, *, x_m: np.ndarray, y_m: np.ndarray) -> np.ndarray:
        return np.sinc(self.wave_number_per_m * np.hypot(x_m, y_m))


@dataclass(frozen=True)
class Piston:
    """s = 1: a flat surface that moves as a whole, the case of the paper's eq. (6)."""

    def amplitude(self, *, x_m: np.ndarray, y_m: np.ndarray) -> np.ndarray:
        return np.ones(np.broadcast(x_m, y_m).shape)


@dataclass(frozen=True)
class StandingWave:
    """s ~ cos(2π u/λ), u the distance along ``direction_deg`` from a crest at ``crest_m``.

    Over its largest magnitude on the surface, which is below the crest's where no crest or trough
    lies on it; on one without bounds, if it is left out.
    """

    wavelength_m: float
    direction_deg: float
    crest_m: float
    surface: Surface = UNBOUNDED

    def amplitude(self, *, x_m: np.ndarray, y_m: np.ndarray) -> np.ndarray:
        along = x_m * cos(radians(self.direction_deg)) + y_m * sin(radians(self.direction_deg))
        wave: np.ndarray = np.cos(2 * pi * (along - self.crest_m) / self.wavelength_m)
        return wave / self.largest

    @property
    def largest(self) -> float:
        """Largest magnitude on the surface: 1 if the phase passes a multiple of π there."""
        middle = -2 * pi * self.crest_m / self.wavelength_m
        reach = 2 * pi * self.surface.reach_along(self.direction_deg) / self.wavelength_m
        if abs(middle - pi * round(middle / pi)) <= reach:
            return 1.0
        return max(abs(cos(middle - reach)), abs(cos(middle + reach)))


@dataclass(frozen=True)
class BesselMode:
    """A disc's bending mode, s ~ [J_n(kr) + c I_n(kr)] cos n(φ − φ0), over its largest magnitude.

    n is the number of nodal diameters, k the bending wave number and c, zero for a membrane, the
    share of the edge's near field (Leissa, Vibration of Plates, 1969, eq. 2.1).
    """

    nodal_diameters: int
    wave_number_rad_per_m: float
    edge_share: float
    direction_deg: float
    surface: Surface

    def amplitude(self, *, x_m: np.ndarray, y_m: np.ndarray) -> np.ndarray:
        angle = np.arctan2(y_m, x_m) - radians(self.direction_deg)
        radial = _radial_mode(
            np.hypot(x_m, y_m),
            order=self.nodal_diameters,
            wave_number_rad_per_m=self.wave_number_rad_per_m,
            edge_share=self.edge_share,
        )
        return radial * np.cos(self.nodal_diameters * angle) / largest_radial(self)


@dataclass(frozen=True)
class Formula:
    """An expression in x, y, r (metres) and phi (radians), over its largest magnitude."""

    expression: str
    surface: Surface

    def amplitude(self, *, x_m: np.ndarray, y_m: np.ndarray) -> np.ndarray:
        return _value_of_formula(self.expression, x_m, y_m) / largest_of_formula(self)


@dataclass(frozen=True)
class Modes:
    """A sum of smooth modes on the surface: a measured profile, smoothed (scans.py).

    ``orders`` are the modes' two numbers (zernike.py, legendre.py). ``largest`` is the largest
    magnitude on the surface: above 1 by what noise has put on the maximum.
    """

    orders: tuple[tuple[int, int], ...]
    coefficients: tuple[float, ...]
    surface: Surface
    largest: float = 1.0

    def amplitude(self, *, x_m: np.ndarray, y_m: np.ndarray) -> np.ndarray:
        x, y = np.broadcast_arrays(x_m, y_m)
        half_x_m, half_y_m = self.surface.half_m
        x, y = x / half_x_m, y / half_y_m
        if x.size * len(self.orders) > MOST_KEPT:
            modes = self.surface.modes_at(self.orders, x=x, y=y)
        else:
            modes = _modes_again(self.surface, self.orders, x.shape, x.tobytes(), y.tobytes())
        return modes @ np.array(self.coefficients)


@lru_cache(maxsize=16)
def _modes_again(
    surface: Surface,
    orders: tuple[tuple[int, int], ...],
    shape: tuple[int, ...],
    x: bytes,
    y: bytes,
) -> np.ndarray:
    """The modes at points given as bytes: profiles with other noise are asked at the same ones."""
    x_, y_ = (np.frombuffer(each).reshape(shape) for each in (x, y))
    return surface.modes_at(orders, x=x_, y=y_)


def largest_magnitude(
    shape: Callable[[np.ndarray, np.ndarray], np.ndarray], *, surface: Surface
) -> float:
    """Largest |shape(x_m, y_m)| on the surface: the best of a net, then improved.

    NaN when the shape is not finite everywhere on the net.
    """
    from scipy.optimize import minimize

    net, place, steps = surface.search()
    with np.errstate(all="ignore"):
        sizes = np.abs(shape(*place(net[0], net[1])))
    if not np.all(np.isfinite(sizes)):
        return np.nan
    best = np.unravel_index(np.argmax(sizes), sizes.shape)
    start = np.array([each[best] for each in net])

    def negative(at: np.ndarray) -> float:
        x_m, y_m = place(at[0], at[1])
        return -float(np.abs(shape(np.array(x_m), np.array(y_m))))

    simplex = start + steps
    found = minimize(negative, start, method="Nelder-Mead", options={"initial_simplex": simplex})
    return max(float(sizes.max()), -float(found.fun))


def _radial_mode(
    r_m: np.ndarray, *, order: int, wave_number_rad_per_m: float, edge_share: float
) -> np.ndarray:
    from scipy.special import iv, jv

    phase = wave_number_rad_per_m * r_m
    mode: np.ndarray = jv(order, phase)
    return mode + edge_share * iv(order, phase) if edge_share else mode


@lru_cache(maxsize=16)
def largest_radial(mode: BesselMode) -> float:
    """Largest |amplitude| of a mode on the surface before it is scaled to 1."""
    # Along the direction of the antinode; the cosine is 1 there.
    return largest_magnitude(
        lambda x_m, y_m: _radial_mode(
            np.hypot(x_m, y_m),
            order=mode.nodal_diameters,
            wave_number_rad_per_m=mode.wave_number_rad_per_m,
            edge_share=mode.edge_share,
        ),
        surface=mode.surface,
    )


@lru_cache(maxsize=16)
def _parsed(expression: str) -> Expression:
    return parse(expression, names=("x", "y", "r", "phi"), place="actuator.profile.expression")


def _value_of_formula(expression: str, x_m: np.ndarray, y_m: np.ndarray) -> np.ndarray:
    x, y = np.broadcast_arrays(x_m, y_m)
    value = _parsed(expression).evaluate(x=x, y=y, r=np.hypot(x, y), phi=np.arctan2(y, x))
    return np.broadcast_to(value, x.shape)


@lru_cache(maxsize=16)
def largest_of_formula(formula: Formula) -> float:
    """Largest |value| of a formula on the surface; its amplitude is that share of it."""
    return largest_magnitude(
        lambda x_m, y_m: _value_of_formula(formula.expression, x_m, y_m),
        surface=formula.surface,
    )
