"""Small motion of a film, with the profiles of velocity and temperature across the gap exact.

Lengths across the gap by h0, time by 1/ω, pressure by p0, everything in proportion to e^(iT). With
z from the middle of the gap, velocity u under a force f, uniform across the gap, and temperature
rise τ over the ambient temperature obey

    i Re u − ∂²u/∂z² = f,        i Pr Re (τ − ((γ − 1)/γ) p) − ∂²τ/∂z² = 0

and vanish at the walls z = ±1/2: both are (1 − cosh(2 q z)/cosh q) times what they are far from
walls, with q = √(i Re)/2 for u and √(i Pr Re)/2 for τ, and 1 − tanh(q)/q times that in the mean.
Hence the mean velocity is A times that of viscous flow, f/12, and the mean density B times p, the
rise of pressure less that of temperature; continuity is ∇·(A ∇p) = iσ (B p + s).
"""

from math import pi
from typing import NamedTuple

import numpy as np
from scipy.interpolate import BarycentricInterpolator, CubicSpline
from scipy.special import ive

from squeezefilm_workflow.verification.numpy_periodic import chebyshev_grid

MAX_SERIES_WAVE_NUMBER = 2000
"""Of a piston's motion along a side: what is cut off is 1e-11 of the force."""


class FilmFactors(NamedTuple):
    """A of the flow and B of the density; both are 1 without inertia and thermal effects."""

    flow_factor: complex = 1.0
    density_factor: complex = 1.0


VISCOUS_FACTORS = FilmFactors()


def exact_factors(reynolds: float, *, prandtl: float, heat_capacity_ratio: float) -> FilmFactors:
    """A and B with the exact profiles, Re = ρ0 ω h0²/μ above 0; Pr = 0 for an isothermal gas."""

    def mean_over_gap(q: complex) -> complex:
        return 1 - np.tanh(q) / q if q else 0.0

    inertia, thermal = 1j * reynolds, 1j * prandtl * reynolds
    warming = (1 - 1 / heat_capacity_ratio) * mean_over_gap(np.sqrt(thermal) / 2)
    return FilmFactors(12 / inertia * mean_over_gap(np.sqrt(inertia) / 2), 1 - warming)


def depth_averaged_factors(
    reynolds: float, *, prandtl: float, heat_capacity_ratio: float
) -> FilmFactors:
    """A and B of the solver's parabolic profiles (docs: inertia and thermal effects)."""
    inertia, thermal = 1j * reynolds, 1j * prandtl * reynolds
    return FilmFactors(
        1 / (1 + inertia / 10),
        1 - (1 - 1 / heat_capacity_ratio) * thermal / 12 / (1 + thermal / 10),
    )


def piston_response(
    sigma: float, aspect: float = 1.0, factors: FilmFactors = VISCOUS_FACTORS
) -> complex:
    """S + iD of a rectangular piston, whose force is −p0 A ε (S sin T + D cos T).

    Blech's double series (J. Lubr. Technol. 105, 1983) with the factors, summed along the second
    side: waves sin(m π X), m odd, along the first have the parts

        8/(π m)² (iσ/(A q²)) (1 − tanh(q b/2)/(q b/2)),     q² = (m π)² + iσB/A,

    b being the aspect; they fall as 1/m⁴.
    """
    m = np.arange(1, MAX_SERIES_WAVE_NUMBER, 2)
    q = np.sqrt((pi * m) ** 2 + 1j * sigma * factors.density_factor / factors.flow_factor)
    half = q * aspect / 2
    parts = (
        8 / (pi * m) ** 2 * (1j * sigma / (factors.flow_factor * q**2)) * (1 - np.tanh(half) / half)
    )
    return complex(parts.sum())


def disc_response(sigma: float, factors: FilmFactors = VISCOUS_FACTORS) -> complex:
    """S + iD of a circular piston, as ``piston_response``; σ is of the diameter.

    The pressure is a Bessel function, 1 − I0(2 κ r)/I0(κ) over −B with κ² = iσB/(4A), r up to 1/2.
    """
    kappa = np.sqrt(1j * sigma * factors.density_factor / factors.flow_factor) / 2
    ratio = ive(1, kappa) / (kappa * ive(0, kappa))
    return complex((1 - 2 * ratio) / factors.density_factor)


def radial_pressure(
    r: np.ndarray, motion: np.ndarray, edge: complex, *, squeeze: complex, factors: FilmFactors
) -> np.ndarray:
    """p(r)/p0 of a film around a hole, prescribed at r[0], that is closed at r[-1].

    Args:
        r: radii, increasing, shape (n,), by any length, which ``squeeze`` is the squeeze number of.
        motion: that widens the gap, over h0, at these radii.
        edge: p/p0 at r[0].
    """
    grid, length = chebyshev_grid(len(r)), r[-1] - r[0]
    at = r[0] + length * grid.x
    first, second = grid.derivative_matrix / length, grid.second_derivative_matrix / length**2
    rate = 1j * squeeze / factors.flow_factor
    operator = second + first / at[:, None] - rate * factors.density_factor * np.eye(len(at))
    right = rate * CubicSpline(r, motion)(at)
    operator[0], right[0] = np.eye(len(at))[0], edge
    operator[-1], right[-1] = first[-1], 0.0
    return np.asarray(BarycentricInterpolator(at, np.linalg.solve(operator, right), rng=0)(r))
