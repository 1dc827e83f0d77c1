"""Mean forces without a single time step: expansions of the film equation, with their errors.

Every function takes a batch of B films (films.py) and returns mean overpressures, each with an
estimate of its absolute error:

    high_squeeze_limit         σ → ∞: one Poisson solve
    edge_layer_expansion       with the correction of order 1/√σ: one more
    small_amplitude_expansion  second order in ε, any σ: one complex Helmholtz solve
    composite_expansion        the last two together: exact in σ to ε², exact in ε to 1/√σ

An error has two parts: what the expansion leaves out, estimated from the profile's slopes, its
values on the rim and at the corners, ε and σ; and what the grid leaves out, the change against
every other of its nodes. Where an expansion does not apply the error is infinite. The constants of
the first part were fitted to periodic states converged to 1e-6: ε 0.01–0.98, σ 0.1–1e6, pistons and
sincs with up to three nodes under the finger, aspects 0.2–5; each is about twice what the worst
film needed. Those of inertia were fitted to its second order in ε on such films and to strips at
any ε. Layers with inertia are known up to Re = 10 and excursions that depend on it (edge_layer.py).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import log10

import numpy as np

from squeezefilm.reynolds.asymptotics import core
from squeezefilm.reynolds.asymptotics.core import Expansion, Part, SecondOrder, joined
from squeezefilm.reynolds.asymptotics.films import INERTIA_SQUARE, Films, grid_error, wide

# Layers of width √(2/σ) must leave room on the shorter side: σ min(1, aspect)² at least this.
LEAST_SIGMA = 10.0


@dataclass(frozen=True)
class AsymptoticForces:
    """Mean overpressures over film and period in units of p0, and their errors; shape (B,).

    The force is p0 × area × ``mean``.
    """

    mean: np.ndarray
    error: np.ndarray


def expansion_points(*, tolerance: float, sigma: np.ndarray) -> np.ndarray:
    """Points per direction that a profile about as smooth as the paper's sinc needs.

    The error estimate, not only the error, then meets the tolerance: every other node must do.

    Args:
        tolerance: relative error of the mean.
        sigma: squeeze number, times aspect² along y, where the method resolves the rim's layers
            (``small_amplitude_expansion`` and ``composite_expansion``); 1 for the others.
    """
    digits = log10(1 / tolerance)
    points = 2 * np.ceil(1 + digits + 0.36 * digits * np.maximum(sigma, 1.0) ** 0.25) + 1
    return points.astype(np.int64)


def high_squeeze_limit(films: Films) -> AsymptoticForces:
    """The film at σ → ∞: PH = ψ(x, y), ψ²/2 + slip ψ harmonic, ⟨H³P²/2 + slip H²P⟩ kept to the rim.

    Under a gap G that is shaped at rest ∇·(G³ ∇(ψ²/G²)) = 0, and all else by the local ε s/G.
    With inertia core and rim are others (core.py). The error is the edge layer's correction
    and that one's error.
    """
    return _together(films, _fast)


def edge_layer_expansion(films: Films) -> AsymptoticForces:
    """The high-squeeze limit with the edge's boundary layer, correct to 1/√σ (see edge_layer.py).

    In two phases the next order is ε²/σ: the film then drives gas along itself.

    With slip the layer is taken to be √(1 + slip) thicker, which holds for small amplitude. With
    inertia the next order is ε²/σ (edge_layer.py), without it ε²/σ^(3/2).
    """
    return _together(films, _with_layer)


def small_amplitude_expansion(films: Films) -> AsymptoticForces:
    """Second order in ε at any σ: linear pressure p̂, then the mean flow that it drives.

    (1 + slip)∇²p̂ − iσp̂ = iσs and ∇²v = −(3/2)(1 + 2 slip/3)/(1 + slip) ∇·(s ∇Re p̂), zero on the
    rim; the mean is ε² ∫ v − |p̂|²/(4 (1 + slip)). With inertia, see core.py.
    """
    _even(films)
    return _together(films, _small)


def composite_expansion(films: Films) -> AsymptoticForces:
    """The edge layer's expansion with its part of order ε² replaced by the exact one.

    The additive composite of two expansions (Van Dyke, Perturbation Methods in Fluid Mechanics,
    1975): what is left is of order ε⁴/σ.
    """
    _even(films)
    return _together(films, _composite)


def _even(films: Films) -> None:
    if films.rest is not None:
        raise ValueError("the second order in ε is derived for gaps that are even at rest")


def _fast(films: Films) -> AsymptoticForces:
    fine, coarse = _expand(films), _expand(films.coarser)
    error = 1.05 * np.abs(fine.layer) + films.layer_remainder + films.slip_share * fine.gross
    error = error + grid_error(films, fine.density, coarse.density)
    return _forces(films, mean=films.mean(fine.density), error=error)


def _with_layer(films: Films) -> AsymptoticForces:
    fine, coarse = _expand(films), _expand(films.coarser)
    error = films.layer_remainder + films.slip_share * fine.gross
    rest = fine.layer - coarse.layer
    error = error + grid_error(films, fine.density, coarse.density, rest=rest)
    return _forces(films, mean=films.mean(fine.density) + fine.layer, error=error)


def _small(films: Films) -> AsymptoticForces:
    fine, coarse = _second_order(films), _second_order(films.coarser)
    square = films.epsilon**2
    error = films.amplitude_remainder * films.mean(np.abs(fine.flow) + np.abs(fine.loss))
    error = error + grid_error(
        films, fine.flow - fine.loss, coarse.flow - coarse.loss, rest=fine.rim - coarse.rim
    )
    mean = films.mean(fine.flow - fine.loss) + fine.rim
    return AsymptoticForces(mean=square * mean, error=_known(square * error))


def _composite(films: Films) -> AsymptoticForces:
    fine, coarse = _joined(films), _joined(films.coarser)
    square = films.epsilon**2
    error = (
        2 * square * np.sqrt(films.depth) * np.abs(fine.change)
        + films.corner_remainder
        + square * films.depth * films.streaming_remainder
        + INERTIA_SQUARE * square * films.depth * films.inertia_remainder
        + square * films.depth * films.slip_share * fine.gross
    )
    rest = fine.layer - coarse.layer
    error = error + grid_error(films, fine.density, coarse.density, rest=rest)
    return _forces(films, mean=films.mean(fine.density) + fine.layer, error=error)


@dataclass(frozen=True)
class _Joined(Expansion):
    """An expansion, and what its second order differs by from another's."""

    change: np.ndarray


def _joined(films: Films) -> _Joined:
    """The composite: order ε² by order ε² exchanged for the exact one."""
    full, exact, square = _expand(films), _second_order(films), films.epsilon**2
    second = _either(films, core.expand_second_order, core.expand_second_order_with_inertia)
    density = exact.flow - exact.loss - second.density
    layer = exact.rim - second.layer
    return _Joined(
        density=full.density + wide(square) * density,
        layer=full.layer + square * layer,
        gross=full.gross,
        change=square * (films.mean(density) + layer),
    )


def _expand(films: Films) -> Expansion:
    return _either(films, core.expand, core.expand_with_inertia)


def _second_order(films: Films) -> SecondOrder:
    return _either(films, core.second_order, core.second_order_with_inertia)


def _either(
    films: Films, without: Callable[[Films], Part], with_inertia: Callable[[Films], Part]
) -> Part:
    """Each film by the expansion that its Reynolds number asks for."""
    still = films.reynolds == 0
    if still.all():
        return without(films)
    if not still.any():
        return with_inertia(films)
    return joined(still, without(films.take(still)), with_inertia(films.take(~still)))


def _forces(films: Films, *, mean: np.ndarray, error: np.ndarray) -> AsymptoticForces:
    """With an infinite error where layers are too thick or the table of the layer ends."""
    thin = films.decay_number * np.minimum(1, films.aspect) ** 2 >= LEAST_SIGMA
    return AsymptoticForces(mean=mean, error=_known(np.where(thin, error, np.inf)))


def _together(films: Films, method: Callable[[Films], AsymptoticForces]) -> AsymptoticForces:
    """Forces of films that may have slip, inertia or both.

    Both together: that with slip, and the change by inertia in a film without slip whose gas flows
    as freely, σ/(1 + slip) and Re (1 + 2 slip/3), as it is for small motion of dense gas.
    """
    if not np.any((films.slip != 0) & (films.reynolds != 0)):
        return method(films)
    none = np.zeros_like(films.slip)
    alike = replace(
        films,
        sigma=films.layer_number,
        slip=none,
        reynolds=films.reynolds * (1 + 2 / 3 * films.slip),
    )
    slipping = method(replace(films, reynolds=none))
    moving, still = method(alike), method(replace(alike, reynolds=none))
    change = moving.mean - still.mean
    error = np.maximum(slipping.error, moving.error) + films.slip_share * np.abs(change)
    return AsymptoticForces(mean=slipping.mean + change, error=_known(error))


def _known(error: np.ndarray) -> np.ndarray:
    """Infinite where a number is missing."""
    return np.where(np.isfinite(error), error, np.inf)
