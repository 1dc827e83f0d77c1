"""Expansions of the mean overpressure for a gas without inertia, with or without slip."""

from __future__ import annotations

from math import sqrt

import numpy as np

from squeezefilm.reynolds.limits import boundary_layer
from squeezefilm.reynolds.limits.expansion import Expansion, SecondOrder, layer_correction
from squeezefilm.reynolds.limits.films import Films, wide

Number = float | np.ndarray

# d(a)/a², g(a)/a and q(a)/a of the boundary layer at a = 0.
LINEAR = -5 * sqrt(2) / 8, 3 / sqrt(2), -3 / sqrt(2)


def expand(films: Films) -> Expansion:
    """The fast limit and its boundary-layer correction."""
    square, thick = wide(films.epsilon) ** 2, 1 + wide(films.slip)
    gap_square = square * films.square
    # ψ²/2 + slip ψ exceeds its value at rest by rise/2, of which `inner` is the part that makes it
    # harmonic.
    # Under a gap G at rest that is so of ψ²/G², and harmonic is what ∇·(G³∇) maps to zero.
    inner = films.solve_diffusion(-(0.25 + 0.5 * thick) * square * films.diffusion(films.square))
    rise = (0.5 + thick) * gap_square + 2 * inner
    total = np.sqrt(thick**2 + rise)
    root = np.sqrt(1 - gap_square)
    # ψ/√(1 − ε²s²) − 1, free of cancellation.
    density = (rise / (total + thick) + gap_square / (1 + root)) / root
    epsilon = films.epsilon[:, None]
    layer, gross = layer_correction(
        films,
        **_at_rim(films, *epsilon**2 * boundary_layer.ratios(epsilon * np.abs(films.rim))),
        influence=-films.inward(films.solve_diffusion(1 / (2 * total * root))),
    )
    return Expansion(density=density, layer=layer, gross=gross)


def expand_second_order(films: Films) -> Expansion:
    """The same over ε² for ε → 0."""
    thick = 1 + wide(films.slip)
    inner = films.solve(-(0.25 + 0.5 * thick) * films.laplacian(films.square))
    rise = (0.5 + thick) * films.square + 2 * inner
    weight = np.broadcast_to(1 / (2 * thick), films.s.shape)
    layer, gross = layer_correction(
        films, **_at_rim(films, *LINEAR), influence=-films.inward(films.solve(weight))
    )
    return Expansion(density=rise / (2 * thick) + films.square / 2, layer=layer, gross=gross)


def _at_rim(films: Films, d: Number, g: Number, q: Number) -> dict[str, np.ndarray]:
    """What the layer changes: with s as its phase, the slope's part in phase goes by g, else by q.

    Args:
        d, g, q: over the square of the amplitude, or for g and q of its product with the slope.
    """
    turned = films.rim.conj() * films.slope
    return {"d": d * np.abs(films.rim) ** 2, "change": g * turned.real + q * turned.imag}


def second_order(films: Films) -> SecondOrder:
    """Densities v and |p̂|²/(4 (1 + slip)) of the mean over ε² (see ``forces.small_amplitude``)."""
    thick, number = 1 + wide(films.slip), wide(films.layer_number)
    linear = films.solve(1j * number * films.s, shift=1j * number)
    # 2 Re s*∇p̂ = Re ∇(s* p̂) + Re (s*∇p̂ − p̂ ∇s*): the first part is integrated by itself and the
    # divergence of the second needs no derivative of p̂, whose Laplacian is iσ(p̂ + s).
    along = films.s.conj() * linear
    rest = films.solve(-number * along.imag - (linear * films.curvature.conj()).real)
    drive = 0.75 * (1 + 2 * thick) / (3 * thick)
    flow = -drive * (along.real + rest)
    loss = np.abs(linear) ** 2 / (4 * thick)
    return SecondOrder(flow=flow, loss=loss, rim=np.zeros_like(films.epsilon))
