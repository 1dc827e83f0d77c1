"""Expansions of the mean gauge pressure in 1/√σ and in ε: core, edge layer, and second order.

At σ → ∞ the mass HP = ψ(x, y) rests but in a layer at the pad's edge. Without inertia ψ²/2 + slip ψ
exceeds its value at rest by what is harmonic with its value on the edge.

With inertia (terms/inertia.py), without slip, it obeys, with a = ε s,

    ∇·(α ∇ψ² + β ψ² ∇a²) = 0,   α = 1 − a² β,   ψ² on the edge as the layer there leaves it.

The flux is −(1/σ) ψ (A ∇ψ − ψ B ∇a) with A/H + c ∂A/∂T = 1, c = Re ψ/10, B likewise with sin T/H;
α and (1 − α)/a = a β are the means of A and of −B, for B = (A − 1)/a. With θ the angle in which the
gap is H = √(1 − a²) Σ (∓ρ)^|k| exp ikθ, dT = H dθ/√(1 − a²), each harmonic of A stands by itself:

    α = κ + 2 κ Σ_k ρ^2k / (1 + k² κ² c²),   κ = √(1 − a²),   ρ² = (1 − κ)/(1 + κ),   k = 1, 2, …
"""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, log

import numpy as np

from squeezefilm.reynolds.asymptotics import edge_layer
from squeezefilm.reynolds.asymptotics.films import Films, broadcast_over_field, find_fixed_point

# Of the sums over harmonics.
HARMONIC_SUM_PRECISION, MAX_HARMONICS = 1e-10, 200


@dataclass(frozen=True)
class MeanPressureExpansion:
    """A mean gauge pressure to order 1/√σ: the mean of ``mean_density`` over the pad and
    ``layer_contribution``.

    ``layer_magnitude_sum`` is what ``layer_contribution`` is made of without cancellation. Shapes
    (B, nx + 2, ny + 2), (B,) and (B,).
    """

    pressure_integrand: np.ndarray
    layer_contribution: np.ndarray
    layer_magnitude_sum: np.ndarray


@dataclass(frozen=True)
class SecondOrderMean:
    """The mean gauge pressure over ε² for ε → 0: that of ``flow_density`` − ``loss_density``, and
    ``edge_driven_mean``.

    ``edge_driven_mean``, shape (B,), is what the edge drives by itself.
    """

    flow_density: np.ndarray
    loss_density: np.ndarray
    edge_driven_mean: np.ndarray


def layer_correction(
    films: Films, *, d: np.ndarray, change: np.ndarray, influence: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """(∮ d dl + ∫ u weight dA) / (√σ area), u with ``change`` on the edge; net and gross.

    u jumps at corners, so it is never computed. With χ the solution of the adjoint equation with
    the source weight that is zero on the edge, Green's identity turns ∫ u weight dA into
    −∮ u ∂χ/∂n dl, n inward: ``influence`` is −∂χ/∂n. Under a gap G at rest the layer is G times as
    thick, and Green's identity is that of ∇·(G³∇).
    """
    gap = films.static_gap_on_edge
    thick = gap / np.sqrt(films.sigma / (1 + films.slip))[:, None]
    by_core = gap**3 * influence * change
    net = films.edge_integral(thick * (d + by_core))
    return net, films.edge_integral(thick * (np.abs(d) + np.abs(by_core)))


def high_squeeze_expansion(films: Films) -> MeanPressureExpansion:
    """The high-squeeze limit and its edge layer's correction, without inertia."""
    square, thick = broadcast_over_field(films.epsilon) ** 2, 1 + broadcast_over_field(films.slip)
    gap_square = square * films.profile_squared
    # ψ²/2 + slip ψ exceeds its value at rest by rise/2, of which `inner` is the part that makes it
    # harmonic.
    # Under a gap G at rest that is so of ψ²/G², and harmonic is what ∇·(G³∇) maps to zero.
    inner = films.solve_diffusion(
        -(0.25 + 0.5 * thick) * square * films.diffusion_of_field(films.profile_squared)
    )
    rise = (0.5 + thick) * gap_square + 2 * inner
    total = np.sqrt(thick**2 + rise)
    root = np.sqrt(1 - gap_square)
    # ψ/√(1 − ε²s²) − 1, free of cancellation.
    density = (rise / (total + thick) + gap_square / (1 + root)) / root
    epsilon = films.epsilon[:, None]
    d, g, q = epsilon**2 * edge_layer.scaled_layer_integrals(epsilon * np.abs(films.edge_profile))
    # With s as its phase, the slope's part in phase goes by g, else by q.
    turned = films.edge_profile.conj() * films.edge_normal_slope
    layer, gross = layer_correction(
        films,
        d=d * np.abs(films.edge_profile) ** 2,
        change=g * turned.real + q * turned.imag,
        influence=-films.inward_normal_derivative(films.solve_diffusion(1 / (2 * total * root))),
    )
    return MeanPressureExpansion(
        pressure_integrand=density, layer_contribution=layer, layer_magnitude_sum=gross
    )


def second_order_mean(films: Films) -> SecondOrderMean:
    """Densities v and |p̂|²/(4 (1 + slip)) of the mean over ε² (``small_amplitude_expansion``)."""
    thick, number = (
        1 + broadcast_over_field(films.slip),
        broadcast_over_field(films.layer_squeeze_number),
    )
    linear = films.solve_helmholtz(1j * number * films.s, shift=1j * number)
    # 2 Re s*∇p̂ = Re ∇(s* p̂) + Re (s*∇p̂ − p̂ ∇s*): the first part is integrated by itself and the
    # divergence of the second needs no derivative of p̂, whose Laplacian is iσ(p̂ + s).
    along = films.s.conj() * linear
    rest = films.solve_helmholtz(
        -number * along.imag - (linear * films.profile_laplacian.conj()).real
    )
    drive = 0.75 * (1 + 2 * thick) / (3 * thick)
    flow = -drive * (along.real + rest)
    loss = np.abs(linear) ** 2 / (4 * thick)
    return SecondOrderMean(
        flow_density=flow, loss_density=loss, edge_driven_mean=np.zeros_like(films.epsilon)
    )


def core_coefficient_and_slope(
    gap_square: np.ndarray, rate_square: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the core coefficient β(a², c²) and ∂β/∂c², shaped as the arguments."""
    kappa = np.sqrt(1 - gap_square)
    rho_square = (1 - kappa) / (1 + kappa)
    most = float(rho_square.max())
    harmonics = ceil(log(HARMONIC_SUM_PRECISION) / log(most)) if 0 < most < 1 else 1
    scaled = kappa**2 * rate_square
    beta, change = np.zeros_like(scaled), np.zeros_like(scaled)
    power = 2 * kappa / (1 + kappa) ** 2
    for k in range(1, min(harmonics, MAX_HARMONICS) + 1):
        addend = power * k**2 / (1 + k**2 * scaled)
        beta += addend * scaled
        change += addend * kappa**2 / (1 + k**2 * scaled)
        power = power * rho_square
    return beta, change


def expand_with_inertia(films: Films) -> MeanPressureExpansion:
    """The high-squeeze limit and its edge layer's correction, with inertia and without slip."""
    gap_square = broadcast_over_field(films.epsilon) ** 2 * films.s**2
    over_gap = films.gradient(gap_square)
    at_edge, d, g, h = edge_layer.inertia_layer_functions(
        films.epsilon[:, None] * films.edge_profile, films.reynolds
    )
    at_edge = films.blend_edge_values(at_edge)
    curvature = films.laplacian(at_edge)
    rate_square = broadcast_over_field(films.reynolds / 10) ** 2

    def next_psi_squared_rise(rise: np.ndarray) -> np.ndarray:
        beta, _ = core_coefficient_and_slope(gap_square, rate_square * (1 + rise))
        flux = (
            beta * (gap_square * along - (1 + rise) * slope)
            for along, slope in zip(films.gradient(rise), over_gap, strict=True)
        )
        return at_edge + films.solve_helmholtz(films.divergence(*flux) - curvature)

    rise = find_fixed_point(next_psi_squared_rise, at_edge)
    total, root = np.sqrt(1 + rise), np.sqrt(1 - gap_square)
    density = (rise / (total + 1) + gap_square / (1 + root)) / root

    # The core's equation is linear in a small change u of ψ²: ∇·(α∇u + b u) = 0.
    beta, change = core_coefficient_and_slope(gap_square, rate_square * (1 + rise))
    drift = [
        beta * slope + rate_square * change * ((1 + rise) * slope - gap_square * along)
        for along, slope in zip(films.gradient(rise), over_gap, strict=True)
    ]
    weight = 1 / (2 * total * root)

    def next_adjoint_iterate(chi: np.ndarray) -> np.ndarray:
        along = films.gradient(chi)
        flux = films.divergence(*(gap_square * beta * gradient for gradient in along))
        return films.solve_helmholtz(weight + flux + drift[0] * along[0] + drift[1] * along[1])

    chi = find_fixed_point(next_adjoint_iterate, films.solve_helmholtz(weight))
    layer, gross = layer_correction(
        films,
        d=d,
        change=g * films.epsilon[:, None] * films.edge_normal_slope
        + h * films.inward_normal_derivative(rise),
        influence=-films.edge_values(1 - gap_square * beta) * films.inward_normal_derivative(chi),
    )
    return MeanPressureExpansion(
        pressure_integrand=density, layer_contribution=layer, layer_magnitude_sum=gross
    )


def second_order_mean_with_inertia(films: Films) -> SecondOrderMean:
    """The mean over ε² for ε → 0, any σ (see ``composite.small_amplitude_expansion``).

    With m = 1/(1 + i Re/10) and λ = iσ/m the linear pressure obeys ∇²p̂ = λ(p̂ + s) and the mean
    one

        ∇²v = −∇·(s ∇Re p̂) + ½ ∇·Re((C p̂* + E s) ∇p̂) − K ∇²|∇p̂|²,
        C = 8/7 − 15 m/7,   E = 15/7 − 22 m/7,   K = (9/28) (Re/10) |m|²/σ.

    Products are brought under Laplacians, so that no derivative of p̂ is needed inside.
    """
    ratio, number = broadcast_over_field(films.reynolds / 10), broadcast_over_field(films.sigma)
    mobility = 1 / (1 + 1j * ratio)
    lag = 1j * number / mobility
    square_factor, profile_factor = 8 / 7 - 15 / 7 * mobility, 15 / 7 - 22 / 7 * mobility
    linear = films.solve_helmholtz(lag * films.s, shift=lag)
    curved = lag * (linear + films.s)
    crossed = linear.conj() * curved
    direct = 0.25 * films.s * ((profile_factor - 2) * linear).real
    source = (
        0.25 * ((profile_factor - 2) * (films.s * curved - linear * films.profile_laplacian)).real
    )
    source = source + 0.5 * ((square_factor * crossed).real - square_factor.real * crossed.real)
    kinetic = 9 / 28 * ratio * np.abs(mobility) ** 2 / number
    # Over the pad |∇p̂|² has the mean of −Re p̂*∇²p̂.
    flow = direct + films.solve_helmholtz(source) + kinetic * crossed.real
    loss = -0.25 * square_factor.real * np.abs(linear) ** 2
    influence = -films.inward_normal_derivative(films.solve_helmholtz(np.ones(films.s.shape)))
    at_edge = kinetic[:, 0] * np.abs(films.inward_normal_derivative(linear)) ** 2
    return SecondOrderMean(
        flow_density=flow,
        loss_density=loss,
        edge_driven_mean=films.edge_integral(influence * at_edge),
    )
