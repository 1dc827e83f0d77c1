"""Expansions of the mean overpressure for a gas without inertia, with or without slip."""

from __future__ import annotations

from math import sqrt

import numpy as np

from squeezefilm.reynolds.limits import boundary_layer
from squeezefilm.reynolds.limits.expansion import Expansion, SecondOrder, layer_correction
from squeezefilm.reynolds.limits.films import Films, wide

# d(a)/a² and g(a)/a of the boundary layer at a = 0.
D_LINEAR = -5 * sqrt(2) / 8
G_LINEAR = 3 / sqrt(2)


def expand(films: Films) -> Expansion:
    """The fast limit and its boundary-layer correction."""
    square, thick = wide(films.epsilon) ** 2, 1 + wide(films.slip)
    gap_square = square * films.s**2
    # ψ²/2 + slip ψ exceeds its value at rest by rise/2, of which `inner` is the part that makes it
    # harmonic.
    inner = films.solve(-(0.25 + 0.5 * thick) * square * films.laplacian(films.s**2))
    rise = (0.5 + thick) * gap_square + 2 * inner
    total = np.sqrt(thick**2 + rise)
    root = np.sqrt(1 - gap_square)
    # ψ/√(1 − ε²s²) − 1, free of cancellation.
    density = (rise / (total + thick) + gap_square / (1 + root)) / root
    d, g = boundary_layer.integrals(films.epsilon[:, None] * films.rim)
    layer, gross = layer_correction(
        films,
        d=d,
        change=films.slope * films.epsilon[:, None] * g,
        influence=-films.inward(films.solve(1 / (2 * total * root))),
    )
    return Expansion(density=density, layer=layer, gross=gross)


def expand_second_order(films: Films) -> Expansion:
    """The same over ε² for ε → 0."""
    thick = 1 + wide(films.slip)
    inner = films.solve(-(0.25 + 0.5 * thick) * films.laplacian(films.s**2))
    rise = (0.5 + thick) * films.s**2 + 2 * inner
    weight = np.broadcast_to(1 / (2 * thick), films.s.shape)
    layer, gross = layer_correction(
        films,
        d=D_LINEAR * films.rim**2,
        change=films.slope * G_LINEAR * films.rim,
        influence=-films.inward(films.solve(weight)),
    )
    return Expansion(density=rise / (2 * thick) + films.s**2 / 2, layer=layer, gross=gross)


def second_order(films: Films) -> SecondOrder:
    """Densities v and |p̂|²/(4 (1 + slip)) of the mean over ε² (see ``forces.small_amplitude``)."""
    thick, number = 1 + wide(films.slip), wide(films.layer_number)
    linear = films.solve(1j * number * films.s, shift=1j * number)
    # 2 s∇Re p̂ = ∇(s Re p̂) + (s∇Re p̂ − Re p̂ ∇s): the first part is integrated by itself and the
    # divergence of the second needs no derivative of p̂, whose Laplacian is iσ(p̂ + s).
    rest = films.solve(-number * films.s * linear.imag - linear.real * films.curvature)
    drive = 0.75 * (1 + 2 * thick) / (3 * thick)
    flow = -drive * (films.s * linear.real + rest)
    loss = np.abs(linear) ** 2 / (4 * thick)
    return SecondOrder(flow=flow, loss=loss, rim=np.zeros_like(films.epsilon))
