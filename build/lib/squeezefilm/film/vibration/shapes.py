"""Vibration shapes s(x, y) of an actuator's surface, with maximum 1."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from math import cos, inf, pi, radians, sin
from typing import Protocol

import numpy as np

from squeezefilm.formulas.expressions import Expression, parse

MOST_KEPT = 1_000_000
"""Values of modes, points times modes, that are kept to be used again: 8 MB."""


class Profile(Protocol):
    """A normalised amplitude of vibration over the actuator's surface."""

    def amplitude(self, *, x_m: np.ndarray, y_m: np.ndarray) -> np.ndarray:
        """Amplitude over its maximum at positions from the actuator's centre, any common shape."""
        ...

    def __hash__(self) -> int: ...


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

    Over its largest magnitude on the disc, which is below the crest's where no crest or trough lies
    on it; on a disc without bounds, if its radius is left out.
    """

    wavelength_m: float
    direction_deg: float
    crest_m: float
    surface_radius_m: float = inf

    def amplitude(self, *, x_m: np.ndarray, y_m: np.ndarray) -> np.ndarray:
        along = x_m * cos(radians(self.direction_deg)) + y_m * sin(radians(self.direction_deg))
        wave: np.ndarray = np.cos(2 * pi * (along - self.crest_m) / self.wavelength_m)
        return wave / self.largest

    @property
    def largest(self) -> float:
        """Largest magnitude on the disc: 1 if the phase passes a multiple of π there."""
        middle = -2 * pi * self.crest_m / self.wavelength_m
        reach = 2 * pi * self.surface_radius_m / self.wavelength_m
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
    surface_radius_m: float

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
    surface_radius_m: float

    def amplitude(self, *, x_m: np.ndarray, y_m: np.ndarray) -> np.ndarray:
        return _value_of_formula(self.expression, x_m, y_m) / largest_of_formula(self)


@dataclass(frozen=True)
class Modes:
    """A sum of Zernike modes on the actuator's disc: a measured profile, smoothed (scans.py).

    ``orders`` are the modes' (n, m), cosine for m ≥ 0 and sine for m < 0. ``largest`` is the
    largest magnitude on the disc: above 1 by what noise has put on the maximum.
    """

    orders: tuple[tuple[int, int], ...]
    coefficients: tuple[float, ...]
    surface_radius_m: float
    largest: float = 1.0

    def amplitude(self, *, x_m: np.ndarray, y_m: np.ndarray) -> np.ndarray:
        x, y = np.broadcast_arrays(x_m, y_m)
        x, y = x / self.surface_radius_m, y / self.surface_radius_m
        if x.size * len(self.orders) > MOST_KEPT:
            modes = _modes_at(self.orders, x, y)
        else:
            modes = _modes_again(self.orders, x.shape, x.tobytes(), y.tobytes())
        return modes @ np.array(self.coefficients)


def _modes_at(orders: tuple[tuple[int, int], ...], x: np.ndarray, y: np.ndarray) -> np.ndarray:
    from squeezefilm.film.vibration.zernike import modes_at  # SciPy's functions are slow to import

    return modes_at(orders, x=x, y=y)


@lru_cache(maxsize=16)
def _modes_again(
    orders: tuple[tuple[int, int], ...], shape: tuple[int, ...], x: bytes, y: bytes
) -> np.ndarray:
    """The modes at points given as bytes: profiles with other noise are asked at the same ones."""
    return _modes_at(orders, *(np.frombuffer(each).reshape(shape) for each in (x, y)))


def largest_magnitude(
    shape: Callable[[np.ndarray, np.ndarray], np.ndarray], *, radius_m: float
) -> float:
    """Largest |shape(x_m, y_m)| on the disc: the best of a polar grid, then improved.

    NaN when the shape is not finite everywhere on the grid.
    """
    from scipy.optimize import minimize

    radius, angle = np.meshgrid(
        np.linspace(0, radius_m, 101), np.linspace(0, 2 * pi, 192, endpoint=False), indexing="ij"
    )
    with np.errstate(all="ignore"):
        sizes = np.abs(shape(radius * np.cos(angle), radius * np.sin(angle)))
    if not np.all(np.isfinite(sizes)):
        return np.nan
    best = np.unravel_index(np.argmax(sizes), sizes.shape)
    start = np.array([radius[best] / radius_m, angle[best]])

    def negative(place: np.ndarray) -> float:
        r, phi = min(abs(place[0]), 1.0) * radius_m, place[1]
        return -float(np.abs(shape(np.array(r * np.cos(phi)), np.array(r * np.sin(phi)))))

    simplex = start + np.array([[0, 0], [-0.005, 0], [0, 0.03]])
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
    """Largest |amplitude| of a mode on the disc before it is scaled to 1."""
    # Along the direction of the antinode; the cosine is 1 there.
    return largest_magnitude(
        lambda x_m, y_m: _radial_mode(
            np.hypot(x_m, y_m),
            order=mode.nodal_diameters,
            wave_number_rad_per_m=mode.wave_number_rad_per_m,
            edge_share=mode.edge_share,
        ),
        radius_m=mode.surface_radius_m,
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
    """Largest |value| of a formula on the disc; its amplitude is that share of it."""
    return largest_magnitude(
        lambda x_m, y_m: _value_of_formula(formula.expression, x_m, y_m),
        radius_m=formula.surface_radius_m,
    )
