"""Mean force of small motion, with the profiles across the gap resolved: the depth-averaged table.

Lengths across the gap by its height, ζ = z/H; time by 1/ω, pressure by p0, lengths along the film
by the pad's. The film's equations are expanded in ε about rest. With θ the temperature, r = P/θ and
W the flow through surfaces of constant ζ, they are

    ∂(r H)/∂T + ∇·(r H u) + ∂(r W)/∂ζ = 0,
    Re {r (∂u/∂T + (u·∇)u) + (r W/H) ∂u/∂ζ} = −(12/σ) ∇P + ∂(θ^κ ∂u/∂ζ)/∂ζ /H²,

walls at ζ = ±1/2. The first order is in proportion to e^(iT): p by the factors of
``linear_film.exact_factors``, u = U(ζ) F with F = −(12/σ) ∇p, and θ = 1 + (1 − 1/γ) Θ(ζ) p. Of the
second order the mean is asked for. Its flow over the gap has no divergence, a Poisson equation for
the mean pressure, 0 on the edge; its temperature is not needed, for gas at rest carries nothing.
"""

import argparse
from pathlib import Path

import numpy as np

from squeezefilm.cli.options import command, option
from squeezefilm.files import write_text
from squeezefilm.parallel import print_step
from squeezefilm.reynolds import solve
from squeezefilm_workflow.verification.films import PISTON_PROFILE, film_scene
from squeezefilm_workflow.verification.numpy_periodic import chebyshev_grid
from squeezefilm_workflow.verification.published.linear_film import exact_factors

REYNOLDS_VALUES_BY_THERMAL = {
    False: (0.45, 1.0, 4.0, 10.0, 20.0),
    True: (0.45, 1.8, 4.0, 7.0, 10.0),
}
SIGMA_VALUES_BY_THERMAL = {False: (20.0, 100.0, 600.0, 2400.0), True: (25.0, 100.0, 600.0)}
"""Of the table's rows, without and with thermal effects."""
PRANDTL, HEAT_CAPACITY_RATIO, VISCOSITY_EXPONENT = 0.71, 1.4, 0.7
# Nodes along each side of the pad and across half of the gap.
NODES_PER_SIDE, NODES_ACROSS_HALF_GAP = 64, 24
# Excursion ratio of the solver's depth-averaged forces, which is as good as 0: the next order is
# its square.
SMALL_EPSILON = 5e-4


@command(option("--output", "TABLE.csv", "table to write", required=True, type=Path))
def depth_averaged(options: argparse.Namespace) -> None:
    """Compute the table of depth-averaged and resolved forces again.

    squeezefilm-verification depth-averaged --output depth_averaged.csv
    """
    lines = ["thermal,reynolds,sigma,averaged,resolved"]
    for thermal, reynolds, sigma in table_cases():
        print_step(f"Re {reynolds:g}, σ {sigma:g}{', thermal effects' * thermal}")
        averaged = depth_averaged_force(reynolds=reynolds, sigma=sigma, thermal=thermal)
        resolved = depth_resolved_force(reynolds=reynolds, sigma=sigma, thermal=thermal)
        lines.append(f"{thermal:d},{reynolds:g},{sigma:g},{averaged:.6f},{resolved:.6f}")
    write_text("\n".join(lines) + "\n", options.output)


def table_cases() -> list[tuple[bool, float, float]]:
    """Return thermal effects or not, Re and σ of the table's rows."""
    return [
        (thermal, reynolds, sigma)
        for thermal in (False, True)
        for reynolds in REYNOLDS_VALUES_BY_THERMAL[thermal]
        for sigma in SIGMA_VALUES_BY_THERMAL[thermal]
    ]


def depth_averaged_force(*, reynolds: float, sigma: float, thermal: bool) -> float:
    """The solver's force on a square piston over ε² and p0 times its area, as ε → 0."""
    scene = film_scene(
        "", SMALL_EPSILON, sigma, profile=PISTON_PROFILE, reynolds=reynolds
    ).with_gas(
        thermal="included" if thermal else "none",
        prandtl=PRANDTL,
        heat_capacity_ratio=HEAT_CAPACITY_RATIO,
        viscosity_exponent=VISCOSITY_EXPONENT,
    )
    (solution,) = solve([scene], tolerance=1e-6, method="periodic")
    return solution.force_n / (scene.force_scale_n * SMALL_EPSILON**2)


def depth_resolved_force(*, reynolds: float, sigma: float, thermal: bool) -> float:
    """The same with velocity, and temperature where it is included, resolved across the gap."""
    line = chebyshev_grid(NODES_PER_SIDE)
    inner = slice(1, -1), slice(1, -1)
    values, vectors, inverse = line.second_derivative_modes
    decays = np.add.outer(values, values)

    def solve_poisson(source: np.ndarray, decay: complex = 0.0) -> np.ndarray:
        modes = inverse @ source[inner] @ inverse.T / (decays - decay)
        return np.pad(vectors @ modes @ vectors.T, 1)

    def gradient(field: np.ndarray) -> np.ndarray:
        return np.stack([line.derivative_matrix @ field, field @ line.derivative_matrix.T])

    def divergence(flow: np.ndarray) -> np.ndarray:
        return np.asarray(line.derivative_matrix @ flow[0] + flow[1] @ line.derivative_matrix.T)

    def mean_of_product(a: np.ndarray | complex, b: np.ndarray) -> np.ndarray:
        """Mean of the product of two harmonics over a period."""
        return np.real(np.conj(a) * b) / 2

    prandtl = PRANDTL if thermal else 0.0
    warming = (1 - 1 / HEAT_CAPACITY_RATIO) * thermal
    factors = exact_factors(reynolds, prandtl=prandtl, heat_capacity_ratio=HEAT_CAPACITY_RATIO)
    gap = np.full((len(line.x), len(line.x)), -1j)
    rate = 1j * sigma / factors.flow_factor
    pressure = solve_poisson(rate * gap, rate * factors.density_factor)
    force = -12 / sigma * gradient(pressure)
    spread = divergence(force)
    carried = sum(
        mean_of_product(force[k], np.stack([gradient(component)[k] for component in force]))
        for k in (0, 1)
    )

    drive = np.zeros((2, *gap.shape))
    nodes, weights = np.polynomial.legendre.leggauss(NODES_ACROSS_HALF_GAP)
    q, q_heat = np.sqrt(1j * reynolds) / 2, np.sqrt(1j * prandtl * reynolds) / 2
    for zeta, weight in zip((nodes + 1) / 4, weights / 2, strict=True):
        speed, speed_integral = _velocity_profile(q, zeta)
        warmth, warmth_integral = _velocity_profile(q_heat, zeta)
        speed, speed_integral = speed / (1j * reynolds), speed_integral / (1j * reynolds)
        shear = -2 * q * np.sinh(2 * q * zeta) / np.cosh(q) / (1j * reynolds)
        bend = -np.cosh(2 * q * zeta) / np.cosh(q)
        warm, parabola = warming * warmth * pressure, (0.25 - zeta**2) / 2
        through = -1j * ((pressure + gap) * zeta - warming * warmth_integral * pressure)
        through = through - speed_integral * spread
        inertia = (
            mean_of_product(pressure - warm, 1j * speed * force)
            + abs(speed) ** 2 * carried
            + mean_of_product(through, shear * force)
        )
        drive += weight * (
            mean_of_product(pressure - warm + gap, speed * force)
            - parabola * (reynolds * inertia + 2 * mean_of_product(gap, bend * force))
            + VISCOSITY_EXPONENT * zeta * mean_of_product(warm, shear * force)
        )
    second = solve_poisson(sigma * divergence(drive)).real
    return float(line.weights @ second @ line.weights)


def _velocity_profile(q: complex, zeta: float) -> tuple[complex, complex]:
    """1 − cosh(2 q ζ)/cosh q and its integral from the middle."""
    if q == 0:
        return 0.0, 0.0
    return 1 - np.cosh(2 * q * zeta) / np.cosh(q), zeta - np.sinh(2 * q * zeta) / (
        2 * q * np.cosh(q)
    )
