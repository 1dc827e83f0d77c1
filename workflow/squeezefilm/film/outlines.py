"""Smooth outlines of pads in conformal coordinates, in which the film equation keeps its form.

The inside of an outline is the image of the strip |μ| ≤ rim, ν around, under

    x + iy = Σ_n a_n cosh n(μ + iν),

each point twice, at (μ, ν) and (−μ, −ν). One coefficient is an ellipse in elliptic coordinates. The
map is analytic, so that Δ = (∂²/∂μ² + ∂²/∂ν²) / |dz/dζ|².
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, lru_cache
from math import atanh, log, pi, sqrt
from typing import Protocol

import numpy as np

# Sides of the ellipse on which a map is based: nearer to a disc the foci fall together, and the map
# of the disc itself would need no ν at the centre.
LEAST_ASPECT = 1.05
# Points around by which a map is found, and how well it meets the outline, relative to its size.
MAP_POINTS = 256
MAP_EXACT = 1e-12
# The same for outlines that are known less well.
CURVE_POINTS = 512
CURVE_EXACT = 1e-8
MOST_STEPS = 30


Curve = Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]]


class Folds(Protocol):
    """Whether a film is even about its pad's middle along x, y."""

    @property
    def fold_x(self) -> bool: ...

    @property
    def fold_y(self) -> bool: ...


@dataclass(frozen=True, eq=False)
class Outline:
    """A pad's outline; lengths are in units of the pad's length along x, from its centre.

    Attributes:
        coefficients: a_n, n = 0, 1, …, complex.
        rim: μ on the outline.
        aspect: length along y.
        turned: the longer side lies along y: ν = 0 is at the end of the y axis.
        exact: what the coefficients left out are, over the outline's size.
        even_x, even_y: whether the outline is even about its middle along x, y.
    """

    coefficients: np.ndarray
    rim: float
    aspect: float
    turned: bool
    even_x: bool
    even_y: bool
    exact: float = MAP_EXACT

    @cached_property
    def area(self) -> float:
        n = np.arange(len(self.coefficients))
        return float(pi / 2 * (n * np.abs(self.coefficients) ** 2) @ np.sinh(2 * n * self.rim))

    def folds(self, film: Folds) -> tuple[bool, bool]:
        """Whether a film under it is the same at ν and −ν, and at ν and π − ν."""
        return (film.fold_x, film.fold_y) if self.turned else (film.fold_y, film.fold_x)

    def positions(self, across: np.ndarray, nu: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Places in [0, 1] across the pad's sides, for μ from −rim to rim in [0, 1] and ν."""
        z = self.place(self.rim * (2 * across - 1), nu)
        return 0.5 + z.real, 0.5 + z.imag / self.aspect

    def place(self, mu: np.ndarray, nu: np.ndarray) -> np.ndarray:
        """x + iy of coordinates of a common shape."""
        return self._sum(self.coefficients, np.cosh, mu + 1j * np.asarray(nu))

    def slope(self, mu: np.ndarray, nu: np.ndarray) -> np.ndarray:
        """d(x + iy)/d(μ + iν)."""
        n = np.arange(len(self.coefficients))
        return self._sum(n * self.coefficients, np.sinh, mu + 1j * np.asarray(nu))

    def stretch(self, mu: np.ndarray, nu: np.ndarray) -> np.ndarray:
        """J, the area of the pad per area of μ and ν."""
        return np.asarray(np.abs(self.slope(mu, nu)) ** 2)

    @cached_property
    def mean_stretch(self) -> float:
        """J's mean over the strip."""
        return self.area / (2 * pi * self.rim)

    @cached_property
    def strip(self) -> float:
        """Half the width in ν, as a complex number, in which J has no zero, about."""
        waves = len(self.coefficients) - 1
        return min(self.rim, -log(self.exact) / waves) if waves > 1 else self.rim

    @cached_property
    def typical_stretch(self) -> float:
        """J's mean on the rim, where the film has its layers."""
        return float(np.mean(self.rim_stretch))

    @cached_property
    def rim_stretch(self) -> tuple[float, float]:
        """J's least and largest value on the rim."""
        around = self.stretch(np.array(self.rim), np.linspace(0, 2 * pi, 4 * MAP_POINTS))
        return float(around.min()), float(around.max())

    def coordinates(self, x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """What ``positions`` takes for places inside, shape (N,), about; by Newton's method."""
        x, y = x - 0.5, (y - 0.5) * self.aspect
        mu, nu = np.meshgrid(np.linspace(0, self.rim, 33), np.linspace(0, 2 * pi, 128))
        zeta = (mu + 1j * nu).ravel()
        z = x + 1j * y
        nearest = np.abs(self.place(zeta.real, zeta.imag)[None] - z[:, None]).argmin(axis=1)
        found = zeta[nearest]
        for _ in range(8):
            slope = self.slope(found.real, found.imag)
            step = (self.place(found.real, found.imag) - z) / np.where(slope == 0, 1, slope)
            found = found - step * np.minimum(1, 0.1 / np.maximum(np.abs(step), 1e-300))
        return (1 + np.clip(found.real / self.rim, -1, 1)) / 2, found.imag

    @staticmethod
    def _sum(coefficients: np.ndarray, function: np.ufunc, zeta: np.ndarray) -> np.ndarray:
        total = np.zeros(np.shape(zeta), dtype=complex)
        for n in np.flatnonzero(coefficients):
            total += coefficients[n] * function(n * zeta)
        return total


@lru_cache(maxsize=256)
def ellipse(aspect: float) -> Outline:
    """An ellipse of axes 1 along x and ``aspect`` along y."""
    longer, shorter = max(1.0, aspect) / 2, min(1.0, aspect) / 2
    turn = 1j if aspect > 1 else 1.0
    if longer >= LEAST_ASPECT * shorter:
        coefficients = np.array([0, turn * sqrt(longer**2 - shorter**2)])
        rim = atanh(shorter / longer)
    else:
        rim = atanh(1 / LEAST_ASPECT)
        coefficients = turn * _mapped_ellipse(longer, shorter, rim)
    return Outline(coefficients, rim, aspect, aspect > 1, even_x=True, even_y=True)


def _mapped_ellipse(longer: float, shorter: float, rim: float) -> np.ndarray:
    def curve(angle: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        c, s = np.cos(angle), np.sin(angle)
        return longer * c + 1j * shorter * s, -longer * s + 1j * shorter * c

    coefficients = conformal_map(curve, rim).real
    coefficients[::2] = 0  # of both symmetries
    return coefficients


def conformal_map(
    curve: Curve,
    rim: float,
    *,
    points: int = MAP_POINTS,
    exact: float = MAP_EXACT,
    first_guess: Callable[[np.ndarray], np.ndarray] = np.copy,
) -> np.ndarray:
    """The coefficients a_n by which the strip up to ``rim`` is mapped inside a closed curve.

    Newton's method for the curve's parameter over ν: on the rim the Fourier coefficients of
    x + iy obey Z_(−n) = exp(−2 n rim) Z_n.

    Args:
        curve: x + iy and its derivative at parameters, of period 2π, against the clock.
        points: around, by which it is found.
        exact: how well it meets the curve, relative to its size.
        first_guess: of the curve's parameter at ν.

    Raises:
        ValueError: if the map does not meet the curve.
    """
    half = points // 2
    nu = 2 * pi * np.arange(points) / points
    n = np.arange(1, half)
    decay = np.exp(-2 * n * rim)
    waves = np.exp(-1j * np.outer(n, nu)) / points
    angle = first_guess(nu)
    for _ in range(MOST_STEPS):
        z, slope = curve(angle)
        spectrum = np.fft.fft(z) / points
        off = spectrum[:half:-1] - decay * spectrum[1:half]
        size = float(np.abs(z - z.mean()).max())
        if np.abs(off).max() <= exact * size:
            break
        jacobian = (waves.conj() - decay[:, None] * waves) * slope
        rows = np.vstack([jacobian.real, jacobian.imag])
        step = np.linalg.lstsq(rows, -np.concatenate([off.real, off.imag]), rcond=1e-10)[0]
        angle = angle + step * min(1.0, 0.3 / float(np.abs(step).max()))
    else:
        raise ValueError("no conformal map of the outline was found")
    coefficients = np.zeros(half, dtype=complex)
    coefficients[0] = spectrum[0]
    coefficients[1:] = 2 * spectrum[1:half] * np.exp(-n * rim)
    kept = np.abs(coefficients[1:]) * np.cosh(np.minimum(n * rim, 700)) > exact * size
    last = int(np.flatnonzero(kept).max(initial=0)) + 2
    if last >= half - 2:
        raise ValueError("the conformal map of the outline has too many waves")
    return coefficients[:last]
