"""Mean overpressures as expansions in 1/√σ and in ε: their terms, field by field."""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt

import numpy as np

from squeezefilm.reynolds.limits import boundary_layer
from squeezefilm.reynolds.limits.films import Films, wide

# d(a)/a² and g(a)/a of the boundary layer at a = 0.
D_LINEAR = -5 * sqrt(2) / 8
G_LINEAR = 3 / sqrt(2)


@dataclass(frozen=True)
class Expansion:
    """A mean overpressure to order 1/√σ: the mean of ``density`` over the finger and ``layer``.

    ``gross`` is what ``layer`` is made of without cancellation, ``change`` what the composite's
    second order differs by.
    """

    density: np.ndarray
    layer: np.ndarray
    gross: np.ndarray
    change: np.ndarray | float = 0.0


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
        films, weight=1 / (2 * total * root), d=d, g=films.epsilon[:, None] * g
    )
    return Expansion(density=density, layer=layer, gross=gross)


def expand_second_order(films: Films) -> Expansion:
    """The same over ε² for ε → 0."""
    thick = 1 + wide(films.slip)
    inner = films.solve(-(0.25 + 0.5 * thick) * films.laplacian(films.s**2))
    rise = (0.5 + thick) * films.s**2 + 2 * inner
    weight = np.broadcast_to(1 / (2 * thick), films.s.shape)
    layer, gross = layer_correction(
        films, weight=weight, d=D_LINEAR * films.rim**2, g=G_LINEAR * films.rim
    )
    return Expansion(density=rise / (2 * thick) + films.s**2 / 2, layer=layer, gross=gross)


def layer_correction(
    films: Films, *, weight: np.ndarray, d: np.ndarray, g: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """(∮ d dl + ∫ u weight dA) / (√σ area), u harmonic with g ∂s/∂n on the rim; net and gross.

    u jumps at corners, so it is never computed: with ∇²χ = weight, χ = 0 on the rim, Green's
    identity turns ∫ u weight dA into −∮ u ∂χ/∂n dl, n inward.
    """
    influence = -films.inward(films.solve(weight)) * films.slope * g
    scale = 1 / np.sqrt(films.layer_number)
    net = films.rim_integral(d + influence) * scale
    return net, films.rim_integral(np.abs(d) + np.abs(influence)) * scale


def second_order(films: Films) -> tuple[np.ndarray, np.ndarray]:
    """Densities v and |p̂|²/(4 (1 + slip)): the mean over ε² is that of their difference."""
    thick, number = 1 + wide(films.slip), wide(films.layer_number)
    linear = films.solve(1j * number * films.s, shift=1j * number)
    # 2 s∇Re p̂ = ∇(s Re p̂) + (s∇Re p̂ − Re p̂ ∇s): the first part is integrated by itself and the
    # divergence of the second needs no derivative of p̂, whose Laplacian is iσ(p̂ + s).
    rest = films.solve(-number * films.s * linear.imag - linear.real * films.curvature)
    drive = 0.75 * (1 + 2 * thick) / (3 * thick)
    flow = -drive * (films.s * linear.real + rest)
    loss = np.abs(linear) ** 2 / (4 * thick)
    return flow, loss


def match(films: Films) -> Expansion:
    """The composite: order ε² by order ε² exchanged for the exact one."""
    full, second = expand(films), expand_second_order(films)
    flow, loss = second_order(films)
    square = films.epsilon**2
    density = flow - loss - second.density
    return Expansion(
        density=full.density + wide(square) * density,
        layer=full.layer - square * second.layer,
        gross=full.gross,
        change=square * (films.mean(density) - second.layer),
    )
