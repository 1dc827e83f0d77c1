"""The edge's boundary layer at large squeeze number: two functions of the local excursion ratio.

Within √(1/σ) of the pad's edge the film exchanges gas with the surroundings. With ξ = n√σ, n the
distance from the edge, the mass M = HP of the layer obeys

    ∂²/∂ξ² (H M²/2) = ∂M/∂T,   H = 1 + a sin T,   M = H at ξ = 0,   M → ψ = √(1 + 3a²/2) inside,

where a = ε s is the excursion ratio at that point of the edge. What the force sees of the layer is

    d(a) = ∫₀^∞ ⟨P − ψ/H⟩ dξ, even in a,     g(a) = 3 ∫₀^∞ ⟨sin T M²⟩ dξ, odd in a.

Where the surface moves with two quadrature components the layer at a point is that of
a = ε √(s₁² + s₂²), at another instant; the gap's slope then has a part a quarter of a
period from the motion itself, whose effect on the force is q(a) = 3 ∫₀^∞ ⟨cos T M²⟩ dξ.

``squeezefilm-verification edge-layers`` computes them. They are stored as d/a², g/a and q/a at
Chebyshev nodes in −ln(1 − a²), from where Chebyshev series give them.

With the gas' inertia the core sees ψ² on the edge, the layer's own gauge pressure d, and the
changes g and h of the edge's ψ² with the slopes of the profile and of the core.

The same command computes them. They are stored as (ψ² − 1)/a², d/a², g/a and h/a² at Chebyshev
points: in Re up to MAX_TABLE_REYNOLDS and, for each Re, in −ln(1 − a²) up to a = ``largest(Re)``.
Somewhere beyond, waves steepen to a shock in the layer, and no periodic state was found that a
finer grid would not change.

Within √(1/σ) of the pad's edge, with ξ = n√σ, n the distance from the edge, and ū = v/√σ the mean
velocity over the gap, mass w = HP and flux q = wv obey

    ∂w/∂T + ∂q/∂ξ = 0,    H = 1 + a sin T at the edge point, a = ε s,
    q + (Re/10) H {w ∂q/∂T − (17/7) q ∂w/∂T − (9/7)(q²/w) ∂w/∂ξ} + H w ∂w/∂ξ − w² ∂H/∂ξ = 0,

which is w times the one-mode momentum equation (terms/inertia.py)

    ū + (Re P H²/10) {∂ū/∂T + (9/7)(ū·∇)ū − (1/7) ū ∂ ln(PH)/∂T} = −(H²/σ) ∇P.

P = 1 at ξ = 0; inside w goes to a constant ψ and the flux to rest. With w = ∂X/∂ξ and q = −∂X/∂T
mass is conserved by itself and no mean flux is left: one equation for X, by collocation in ξ and T,
Newton's method and dense matrices.

At the next order in 1/√σ the profile's slope ∂a/∂n and the core's ∂ψ/∂n reach into the layer, which
answers linearly: far inside, ψ is changed by a multiple of either.
"""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path

import numpy as np
from numpy.polynomial import chebyshev

from squeezefilm.reynolds.spectral import Axis

LAYER_TABLE_PATH = Path(__file__).with_name("edge_layer.csv")
LAYER_TABLE_WITH_INERTIA_PATH = Path(__file__).with_name("edge_layer_with_inertia.csv")
MAX_TABLE_REYNOLDS = 10.0
REYNOLDS_NUMBER_COUNT, EXCURSION_COUNT_WITH_INERTIA = 14, 18
MAX_TABLE_EXCURSION = 0.98
EXCURSION_COUNT = 41


def layer_integrals(a: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """d and g at excursion ratios |a| ≤ MAX_TABLE_EXCURSION, any shape; beyond, both are NaN."""
    d, g, _ = scaled_layer_integrals(a)
    return np.square(a) * d, a * g


def scaled_layer_integrals(a: np.ndarray) -> np.ndarray:
    """d/a², g/a and q/a at excursion ratios |a| ≤ MAX_TABLE_EXCURSION, shape (3, …); NaN beyond."""
    size = np.abs(np.asarray(a, dtype=float))
    table_coordinate = (
        2
        * log_narrowing_factor(np.minimum(size, MAX_TABLE_EXCURSION))
        / log_narrowing_factor(MAX_TABLE_EXCURSION)
        - 1
    )
    # All polynomials at once: chebval goes through them one by one.
    polynomials = np.cos(
        np.multiply.outer(np.arange(EXCURSION_COUNT), np.arccos(np.clip(table_coordinate, -1, 1)))
    )
    values = np.tensordot(_layer_table_coefficients().T, polynomials, axes=1)
    return np.where(size > MAX_TABLE_EXCURSION * (1 + 1e-12), np.nan, values)


@lru_cache(maxsize=256)
def quadrature_weights_with_ends(line: Axis) -> np.ndarray:
    """Clenshaw–Curtis weights on all nodes of an unfolded axis, ends included, shape (n + 2,)."""
    order = line.unknown_count + 1
    end = 1 / order**2 if order % 2 else 1 / (order**2 - 1)
    return np.concatenate([[end / 2], line.quadrature_weights, [end / 2]])


def log_narrowing_factor(a: np.ndarray | float) -> np.ndarray:
    """Return −ln(1 − a²), in which the tables have Chebyshev points."""
    return -np.log1p(-np.square(a))


@lru_cache(maxsize=1)
def _layer_table_coefficients() -> np.ndarray:
    """Chebyshev coefficients of d/a², g/a and q/a in −ln(1 − a²), shape (EXCURSION_COUNT, 3)."""
    rows = np.loadtxt(LAYER_TABLE_PATH, delimiter=",", skiprows=1)
    nodes = 2 * log_narrowing_factor(rows[:, 0]) / log_narrowing_factor(MAX_TABLE_EXCURSION) - 1
    return np.linalg.solve(chebyshev.chebvander(nodes, EXCURSION_COUNT - 1), rows[:, 1:])


def max_excursion_with_inertia(reynolds: np.ndarray | float) -> np.ndarray:
    """The largest excursion ratio of the table: 0.9 without inertia, 0.4 at Re = 10."""
    return 0.9 / (1 + np.asarray(reynolds, dtype=float) / 8)


def inertia_layer_functions(a: np.ndarray, reynolds: np.ndarray) -> np.ndarray:
    """ψ² − 1, d, g and h at excursion ratios ``a``, (B, …), of films with ``reynolds``, (B,).

    They have the shape (4, B, …) and are NaN beyond the table. ψ² is changed by
    (g ∂a/∂n + h ∂ψ²/∂n)/√σ, n inward.
    """
    reynolds = np.asarray(reynolds, dtype=float)
    films = a.reshape(len(reynolds), -1)
    most = max_excursion_with_inertia(reynolds)[:, None]
    inside = (np.abs(films) <= most) & (reynolds[:, None] <= MAX_TABLE_REYNOLDS)
    table_coordinate = (
        2 * log_narrowing_factor(np.minimum(np.abs(films), most)) / log_narrowing_factor(most) - 1
    )
    powers = chebyshev.chebvander(table_coordinate, EXCURSION_COUNT_WITH_INERTIA - 1)
    of_film = chebyshev.chebvander(
        2 * np.minimum(reynolds, MAX_TABLE_REYNOLDS) / MAX_TABLE_REYNOLDS - 1,
        REYNOLDS_NUMBER_COUNT - 1,
    )
    series = np.einsum("br,kra->bka", of_film, _inertia_table_coefficients())
    values = np.einsum("bka,bma->kbm", series, powers)
    ratio = np.where(inside, films, np.nan)
    scaled = values * np.stack([ratio**2, ratio**2, ratio, ratio**2])
    return np.asarray(scaled.reshape(4, *a.shape))


@lru_cache(maxsize=1)
def _inertia_table_coefficients() -> np.ndarray:
    """Chebyshev coefficients of the functions in Re and a, (4, REYNOLDS_NUMBER_COUNT,
    EXCURSION_COUNT_WITH_INERTIA)."""
    # Rows Re, a, (ψ² − 1)/a², d/a², g/a, h/a².
    rows = np.loadtxt(LAYER_TABLE_WITH_INERTIA_PATH, delimiter=",", skiprows=1)
    values = np.moveaxis(
        rows[:, 2:].reshape(REYNOLDS_NUMBER_COUNT, EXCURSION_COUNT_WITH_INERTIA, 4), 2, 0
    )
    of_reynolds, of_a = (
        np.linalg.inv(chebyshev.chebvander(chebyshev.chebpts1(count), count - 1))
        for count in (REYNOLDS_NUMBER_COUNT, EXCURSION_COUNT_WITH_INERTIA)
    )
    series: np.ndarray = of_reynolds @ values @ of_a.T
    return series
