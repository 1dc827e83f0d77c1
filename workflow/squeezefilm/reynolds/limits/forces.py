"""Mean forces without a single time step: limits of the film equation, with their errors.

Every function takes a batch of B films and returns mean overpressures, each with an estimate of its
absolute error:

    closed_form            piston, σ → ∞ (paper eq. 6)
    fast_limit             any profile, σ → ∞: one Poisson solve
    boundary_layer_limit   with the correction of order 1/√σ: one more
    small_amplitude        second order in ε, any σ: one complex Helmholtz solve
    matched_limit          the last two together: exact in σ to ε², exact in ε to 1/√σ

Arguments they share:
    epsilon, sigma: excursion ratio and squeeze number, shape (B,).
    amplitude: profile s on the nodes ``limit_axis(n).all_nodes`` along x and y, ends included,
        shape (B, nx + 2, ny + 2); nx and ny odd, at least 5. See ``limit_points``.
    aspect: finger's length along y over that along x, a number or shape (B,).
    slip: first-order slip 6 Kn at the mean gap, a number or shape (B,); 0 without slip.

An error has two parts: what the limit leaves out, estimated from the profile's slopes, its values
on the rim and at the corners, ε and σ; and what the grid leaves out, the change against every other
of its nodes. Where a limit does not apply the error is infinite. The constants of the first part
were fitted to periodic states converged to 1e-6: ε 0.01–0.98, σ 0.1–1e6, pistons and sincs with up
to three nodes under the finger, aspects 0.2–5; each is about twice what the worst film needed.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from math import ceil, log10, sqrt

import numpy as np

from squeezefilm.reynolds.limits import boundary_layer
from squeezefilm.reynolds.limits.boundary_layer import all_weights
from squeezefilm.reynolds.spectral import Axis, axis

# Layers of width √(2/σ) must leave room on the shorter side: σ min(1, aspect)² at least this.
LEAST_SIGMA = 10.0
# The error estimates' constants.
RIM_SLOPES, INNER_CURVATURE, CORNERS, MEETING = 4.5, 3.0, 0.9, 4.5
STIFF, FREE, FREE_SIGMA = 0.8, 6.0, 6.0
SLIP_SHARE = 0.5
# Forces on two grids can agree by cancellation where the densities do not.
DENSITY_SHARE = 0.1
# d(a)/a² and g(a)/a of the boundary layer at a = 0.
D_LINEAR = -5 * sqrt(2) / 8
G_LINEAR = 3 / sqrt(2)

Numbers = float | np.ndarray


@dataclass(frozen=True)
class LimitForces:
    """Mean overpressures over film and period in units of p0, and their errors; shape (B,).

    The force is p0 × area × ``mean``.
    """

    mean: np.ndarray
    error: np.ndarray


def limit_axis(points: int) -> Axis:
    """The axis of the limits' grids: ``points`` unknowns, odd, so that every other node is one."""
    if points % 2 == 0 or points < 5:
        raise ValueError(f"{points} points: the grid of a limit has an odd number, at least 5")
    return axis(points, False)


def limit_points(*, tolerance: float, sigma: float = 1.0) -> int:
    """Points per direction that a profile about as smooth as the paper's sinc needs.

    The error estimate, not only the error, then meets the tolerance: every other node must do.

    Args:
        tolerance: relative error of the mean.
        sigma: squeeze number, times aspect² along y, where the method resolves the rim's layers
            (``small_amplitude`` and ``matched_limit``); left out for the other limits.
    """
    digits = log10(1 / tolerance)
    return 2 * ceil(1 + digits + 0.36 * digits * max(sigma, 1.0) ** 0.25) + 1


def closed_form(*, epsilon: np.ndarray, sigma: np.ndarray, aspect: Numbers = 1.0) -> LimitForces:
    """Piston at σ → ∞: √(1 + 3ε²/2)/√(1 − ε²) − 1, the paper's eq. (6)."""
    epsilon, sigma, aspect = np.broadcast_arrays(epsilon, sigma, np.asarray(aspect, dtype=float))
    root = np.sqrt(1 - epsilon**2)
    mass = np.sqrt(1 + 1.5 * epsilon**2)
    mean = 2.5 * epsilon**2 / (root * (mass + root))
    rim = 2 * (1 + 1 / aspect)
    layer = np.abs(boundary_layer.integrals(epsilon)[0]) * rim / np.sqrt(sigma)
    films = _Films(epsilon, sigma, np.ones((len(epsilon), 7, 7)), aspect, np.zeros_like(aspect))
    return _forces(films, mean=mean, error=1.05 * layer + films.layer_remainder)


def fast_limit(
    *,
    epsilon: np.ndarray,
    sigma: np.ndarray,
    amplitude: np.ndarray,
    aspect: Numbers,
    slip: Numbers = 0.0,
) -> LimitForces:
    """The film at σ → ∞: PH = ψ(x, y), ψ²/2 + slip ψ harmonic, ⟨H³P²/2 + slip H²P⟩ kept to the rim.

    The error is the boundary-layer correction and that one's error.
    """
    films = _films(epsilon, sigma, amplitude, aspect, slip)
    fine, coarse = _expand(films), _expand(films.coarser)
    error = 1.05 * np.abs(fine.layer) + films.layer_remainder + films.slip_share * fine.gross
    error = error + _grid_error(films, fine.density, coarse.density)
    return _forces(films, mean=films.mean(fine.density), error=error)


def boundary_layer_limit(
    *,
    epsilon: np.ndarray,
    sigma: np.ndarray,
    amplitude: np.ndarray,
    aspect: Numbers,
    slip: Numbers = 0.0,
) -> LimitForces:
    """The fast limit with the rim's boundary layer, correct to 1/√σ (see boundary_layer.py).

    With slip the layer is taken to be √(1 + slip) thicker, which holds for small amplitude.
    """
    films = _films(epsilon, sigma, amplitude, aspect, slip)
    fine, coarse = _expand(films), _expand(films.coarser)
    error = films.layer_remainder + films.slip_share * fine.gross
    rest = fine.layer - coarse.layer
    error = error + _grid_error(films, fine.density, coarse.density, rest=rest)
    return _forces(films, mean=films.mean(fine.density) + fine.layer, error=error)


def small_amplitude(
    *,
    epsilon: np.ndarray,
    sigma: np.ndarray,
    amplitude: np.ndarray,
    aspect: Numbers,
    slip: Numbers = 0.0,
) -> LimitForces:
    """Second order in ε at any σ: linear pressure p̂, then the mean flow that it drives.

    (1 + slip)∇²p̂ − iσp̂ = iσs and ∇²v = −(3/2)(1 + 2 slip/3)/(1 + slip) ∇·(s ∇Re p̂), zero on the
    rim; the mean is ε² ∫ v − |p̂|²/(4 (1 + slip)).
    """
    films = _films(epsilon, sigma, amplitude, aspect, slip)
    flow, loss = _second_order(films)
    coarse_flow, coarse_loss = _second_order(films.coarser)
    square = films.epsilon**2
    error = films.amplitude_remainder * films.mean(np.abs(flow) + loss)
    error = error + _grid_error(films, flow - loss, coarse_flow - coarse_loss)
    return LimitForces(mean=square * films.mean(flow - loss), error=square * error)


def matched_limit(
    *,
    epsilon: np.ndarray,
    sigma: np.ndarray,
    amplitude: np.ndarray,
    aspect: Numbers,
    slip: Numbers = 0.0,
) -> LimitForces:
    """The boundary-layer limit with its part of order ε² replaced by the exact one.

    The additive composite of two expansions (Van Dyke, Perturbation Methods in Fluid Mechanics,
    1975): what is left is of order ε⁴/σ.
    """
    films = _films(epsilon, sigma, amplitude, aspect, slip)
    fine, coarse = _match(films), _match(films.coarser)
    square = films.epsilon**2
    error = (
        2 * square * np.sqrt(films.depth) * np.abs(fine.change)
        + films.corner_remainder
        + square * films.depth * films.slip_share * fine.gross
    )
    rest = fine.layer - coarse.layer
    error = error + _grid_error(films, fine.density, coarse.density, rest=rest)
    return _forces(films, mean=films.mean(fine.density) + fine.layer, error=error)


@dataclass(frozen=True)
class _Films:
    """A batch on one grid: its operators, and the features that the error estimates need.

    Fields have shape (B, nx + 2, ny + 2); values on the rim (B, 2 (nx + ny + 4)), side after side:
    x = 0, x = 1, y = 0, y = aspect. Lengths are in units of the side along x.
    """

    epsilon: np.ndarray
    sigma: np.ndarray
    s: np.ndarray
    aspect: np.ndarray
    slip: np.ndarray

    @property
    def x(self) -> Axis:
        return axis(self.s.shape[1] - 2, False)

    @property
    def y(self) -> Axis:
        return axis(self.s.shape[2] - 2, False)

    @property
    def coarser(self) -> _Films:
        """The same films on every other node."""
        return _Films(self.epsilon, self.sigma, self.s[:, ::2, ::2], self.aspect, self.slip)

    def mean(self, field: np.ndarray) -> np.ndarray:
        """Mean over the finger, shape (B,)."""
        return (field @ all_weights(self.y)) @ all_weights(self.x)

    def laplacian(self, field: np.ndarray) -> np.ndarray:
        along_y = (field @ _second_derivative(self.y.points).T) / _wide(self.aspect) ** 2
        return _second_derivative(self.x.points) @ field + along_y

    def solve(self, source: np.ndarray, *, shift: np.ndarray | float = 0.0) -> np.ndarray:
        """The u with ∇²u − shift u = source that is zero on the rim; by fast diagonalisation."""
        values_x, vectors_x, inverse_x = self.x.modes
        values_y, vectors_y, inverse_y = self.y.modes
        divisor = values_x[:, None] + values_y / _wide(self.aspect) ** 2 - shift
        modes = inverse_x @ source[:, 1:-1, 1:-1] @ inverse_y.T / divisor
        u = np.zeros(source.shape, dtype=modes.dtype)
        u[:, 1:-1, 1:-1] = vectors_x @ modes @ vectors_y.T
        return u

    def on_rim(self, field: np.ndarray) -> np.ndarray:
        sides = [field[:, 0], field[:, -1], field[:, :, 0], field[:, :, -1]]
        return np.concatenate(sides, axis=1)

    def inward(self, field: np.ndarray) -> np.ndarray:
        """Derivative along the inward normal, on the rim."""
        ends_x, ends_y = self.x.derivative[[0, -1]], self.y.derivative[[0, -1]]
        across_x = ends_x @ field
        across_y = field @ ends_y.T / _wide(self.aspect)
        sides = [across_x[:, 0], -across_x[:, 1], across_y[:, :, 0], -across_y[:, :, 1]]
        return np.concatenate(sides, axis=1)

    def rim_integral(self, values: np.ndarray) -> np.ndarray:
        """Integral along the rim over the finger's area, shape (B,)."""
        nx, ny = self.x.points + 2, self.y.points + 2
        sides = np.repeat([0, 1], [2 * ny, 2 * nx])
        along = np.concatenate([np.tile(all_weights(self.y), 2), np.tile(all_weights(self.x), 2)])
        share = np.where(sides == 0, 1.0, 1 / self.aspect[:, None])
        return np.sum(values * along * share, axis=1)

    @cached_property
    def rim(self) -> np.ndarray:
        """The profile on the rim."""
        return self.on_rim(self.s)

    @cached_property
    def slope(self) -> np.ndarray:
        """The profile's inward derivative on the rim."""
        return self.inward(self.s)

    @cached_property
    def curvature(self) -> np.ndarray:
        """∇²s."""
        return self.laplacian(self.s)

    @cached_property
    def depth(self) -> np.ndarray:
        """1/(1 − ε² max s²): grows as the narrowest gap closes."""
        return 1 / (1 - (self.epsilon * np.abs(self.s).max(axis=(1, 2))) ** 2)

    @property
    def layer_number(self) -> np.ndarray:
        """Squeeze number that sets the layer's thickness: slip makes gas flow more freely."""
        return self.sigma / (1 + self.slip)

    @property
    def slip_share(self) -> np.ndarray:
        """Share of the layer by which slip may change it beyond its thickness."""
        return SLIP_SHARE * self.slip

    @property
    def corner_remainder(self) -> np.ndarray:
        """Error from the corners, where two layers meet: of order ε⁴/σ."""
        corners = (self.s[:, [0, 0, -1, -1], [0, -1, 0, -1]] ** 2).sum(axis=1)
        return CORNERS * self.epsilon**4 * self.depth * corners / (self.layer_number * self.aspect)

    @property
    def layer_remainder(self) -> np.ndarray:
        """Error of the boundary-layer limit: slopes and curvature of s, corners, meeting layers."""
        along_x = self.x.derivative @ self.s
        along_y = self.s @ self.y.derivative.T / _wide(self.aspect)
        uneven = along_x**2 + along_y**2 + np.abs(self.s * self.curvature)
        sigma = self.layer_number
        meeting = np.exp(-np.sqrt(sigma / 2) * np.minimum(1, self.aspect))
        return self.corner_remainder + self.epsilon**2 * (
            RIM_SLOPES * np.sqrt(self.depth) * self.rim_integral(self.on_rim(uneven)) / sigma**1.5
            + INNER_CURVATURE * np.sqrt(self.depth) * self.mean(self.curvature**2) / sigma**2
            + MEETING * self.rim_integral(self.rim**2) * meeting / np.sqrt(sigma)
        )

    @property
    def amplitude_remainder(self) -> np.ndarray:
        """Relative error of the second-order mean: of order ε².

        From 0.4 ε² where the film is stiff to 21/4 ε² where the gas flows freely (σ → 0, where the
        mean goes like ⟨Ḣ²/H⁶⟩ = ε²/2 (1 + 21 ε²/4 + …) and with the power 9/2 of ``depth``).
        """
        effective = self.layer_number / (1 + self.aspect**-2.0)
        free = 1 / (1 + (effective / FREE_SIGMA) ** 2)
        return self.epsilon**2 * (STIFF + FREE * free) * self.depth ** (1 + 3.5 * free)


def _films(
    epsilon: np.ndarray, sigma: np.ndarray, amplitude: np.ndarray, aspect: Numbers, slip: Numbers
) -> _Films:
    for points in amplitude.shape[1:]:
        limit_axis(points - 2)
    numbers = (np.asarray(value, dtype=float) for value in (epsilon, sigma, aspect, slip))
    epsilon, sigma, aspect, slip = np.broadcast_arrays(*numbers)
    return _Films(epsilon, sigma, amplitude, aspect, slip)


@dataclass(frozen=True)
class _Expansion:
    """A mean overpressure to order 1/√σ: the mean of ``density`` over the finger and ``layer``.

    ``gross`` is what ``layer`` is made of without cancellation, ``change`` what the composite's
    second order differs by.
    """

    density: np.ndarray
    layer: np.ndarray
    gross: np.ndarray
    change: np.ndarray | float = 0.0


def _expand(films: _Films) -> _Expansion:
    """The fast limit and its boundary-layer correction."""
    square, thick = _wide(films.epsilon) ** 2, 1 + _wide(films.slip)
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
    layer, gross = _layer(films, weight=1 / (2 * total * root), d=d, g=films.epsilon[:, None] * g)
    return _Expansion(density=density, layer=layer, gross=gross)


def _expand_second_order(films: _Films) -> _Expansion:
    """The same over ε² for ε → 0."""
    thick = 1 + _wide(films.slip)
    inner = films.solve(-(0.25 + 0.5 * thick) * films.laplacian(films.s**2))
    rise = (0.5 + thick) * films.s**2 + 2 * inner
    weight = np.broadcast_to(1 / (2 * thick), films.s.shape)
    layer, gross = _layer(films, weight=weight, d=D_LINEAR * films.rim**2, g=G_LINEAR * films.rim)
    return _Expansion(density=rise / (2 * thick) + films.s**2 / 2, layer=layer, gross=gross)


def _layer(
    films: _Films, *, weight: np.ndarray, d: np.ndarray, g: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """(∮ d dl + ∫ u weight dA) / (√σ area), u harmonic with g ∂s/∂n on the rim; net and gross.

    u jumps at corners, so it is never computed: with ∇²χ = weight, χ = 0 on the rim, Green's
    identity turns ∫ u weight dA into −∮ u ∂χ/∂n dl, n inward.
    """
    influence = -films.inward(films.solve(weight)) * films.slope * g
    scale = 1 / np.sqrt(films.layer_number)
    net = films.rim_integral(d + influence) * scale
    return net, films.rim_integral(np.abs(d) + np.abs(influence)) * scale


def _second_order(films: _Films) -> tuple[np.ndarray, np.ndarray]:
    """Densities v and |p̂|²/(4 (1 + slip)): the mean over ε² is that of their difference."""
    thick, number = 1 + _wide(films.slip), _wide(films.layer_number)
    linear = films.solve(1j * number * films.s, shift=1j * number)
    # 2 s∇Re p̂ = ∇(s Re p̂) + (s∇Re p̂ − Re p̂ ∇s): the first part is integrated by itself and the
    # divergence of the second needs no derivative of p̂, whose Laplacian is iσ(p̂ + s).
    rest = films.solve(-number * films.s * linear.imag - linear.real * films.curvature)
    drive = 0.75 * (1 + 2 * thick) / (3 * thick)
    flow = -drive * (films.s * linear.real + rest)
    loss = np.abs(linear) ** 2 / (4 * thick)
    return flow, loss


def _match(films: _Films) -> _Expansion:
    """The composite: order ε² by order ε² exchanged for the exact one."""
    full, second = _expand(films), _expand_second_order(films)
    flow, loss = _second_order(films)
    square = films.epsilon**2
    density = flow - loss - second.density
    return _Expansion(
        density=full.density + _wide(square) * density,
        layer=full.layer - square * second.layer,
        gross=full.gross,
        change=square * (films.mean(density) - second.layer),
    )


def _grid_error(
    films: _Films, fine: np.ndarray, coarse: np.ndarray, *, rest: np.ndarray | float = 0.0
) -> np.ndarray:
    """Change of the mean against every other node, or a share of the density's where it is larger.

    Args:
        fine, coarse: densities whose means over the finger are compared, on the two grids.
        rest: change of what is not in the densities.
    """
    half = films.coarser
    change = films.mean(fine) - half.mean(coarse) + rest
    return np.maximum(np.abs(change), DENSITY_SHARE * half.mean(np.abs(fine[:, ::2, ::2] - coarse)))


def _forces(films: _Films, *, mean: np.ndarray, error: np.ndarray) -> LimitForces:
    """With an infinite error where layers are too thick or the table of the layer ends."""
    thin = films.layer_number * np.minimum(1, films.aspect) ** 2 >= LEAST_SIGMA
    return LimitForces(mean=mean, error=np.where(thin & np.isfinite(error), error, np.inf))


def _wide(values: np.ndarray) -> np.ndarray:
    return values[:, None, None]


@lru_cache(maxsize=64)
def _second_derivative(points: int) -> np.ndarray:
    first = axis(points, False).derivative
    return first @ first
