"""Rarefaction and heating: each term against an exact identity or limit."""

from dataclasses import replace

import numpy as np
import pytest
from films import PISTON, film, mean_overpressure, periodic_state
from scipy.optimize import brentq

from squeezefilm.quantities.model_error import error_budgets
from squeezefilm.reynolds import solve
from squeezefilm.reynolds.terms.rarefaction import flow_coefficients


@pytest.mark.parametrize("rarefaction", ["none", "slip", "fukui-kaneko"])
@pytest.mark.parametrize("exponent", [1.0, 1.4])
def test_mean_flow_potential_of_a_piston_is_that_of_ambient_pressure(rarefaction, exponent):
    """⟨Σ c_k H^(3−k) (g_k(P) − g_k(1))⟩ = 0 at every point: mass flows nowhere in the mean.

    g_k is the integral of ρ^(1−k) from ambient pressure, by quadrature here.
    """
    scene = film(
        epsilon=0.5,
        sigma=150.0,
        profile=PISTON,
        rarefaction=rarefaction,
        knudsen=0.05,
        polytropic_exponent=exponent,
    )
    grid, states = periodic_state(scene, points=32, instants=40)
    assert states.status[0] == 0
    gap = 1 + scene.epsilon * np.sin(grid.t.nodes)
    pressure = 1 + states.overpressure[0]
    nodes, weights = np.polynomial.legendre.leggauss(20)
    path = 1 + (pressure[..., None] - 1) * (nodes + 1) / 2
    flow = np.zeros_like(pressure)
    for k, coefficient in enumerate(flow_coefficients(scene)):
        integral = (path ** ((1 - k) / exponent) * weights).sum(axis=-1) * (pressure - 1) / 2
        flow += coefficient * gap ** (3 - k) * integral
    assert np.abs(flow.mean(axis=-1)).max() < 1e-9
    assert np.abs(flow).max() > 0.1


@pytest.mark.parametrize("knudsen", [0.01, 0.1])
def test_slip_at_infinite_squeeze_number(knudsen):
    """HP → ψ with ψ²/2 + 6Kψ = (1 + 3ε²/2)/2 + 6K(1 + ε²/2), approached like 1/√σ."""
    epsilon = 0.4
    wall = (1 + 1.5 * epsilon**2) / 2 + 6 * knudsen * (1 + epsilon**2 / 2)
    psi = brentq(lambda value: value**2 / 2 + 6 * knudsen * value - wall, 0.1, 10)
    limit = psi / np.sqrt(1 - epsilon**2) - 1
    forces = [
        mean_overpressure(
            film(epsilon=epsilon, sigma=sigma, profile=PISTON, rarefaction="slip", knudsen=knudsen),
            points=96,
            instants=16,
            fold=True,
        )
        for sigma in (4e4, 16e4)
    ]
    assert 2 * forces[1] - forces[0] == pytest.approx(limit, rel=2e-4)
    assert abs(forces[1] - limit) > 10 * abs(2 * forces[1] - forces[0] - limit)


def test_flow_factors_agree_for_a_dense_gas():
    """Fukui and Kaneko's factor is slip with coefficient 1.1466 to first order in Kn."""
    factor = film(epsilon=0.3, sigma=100.0, rarefaction="fukui-kaneko", knudsen=1e-4)
    slip = film(epsilon=0.3, sigma=100.0, rarefaction="slip", knudsen=1.1466e-4)
    forces = [solve([scene], tolerance=1e-8)[0].force_n for scene in (factor, slip)]
    assert forces[0] == pytest.approx(forces[1], rel=1e-6)


def test_fast_adiabatic_compression_is_stiffer_by_the_exponent():
    """At large σ the linear spring number is n times the isothermal one."""
    epsilon, sigma = 1e-4, 1e6

    def spring(exponent: float) -> float:
        scene = film(epsilon=epsilon, sigma=sigma, profile=PISTON, polytropic_exponent=exponent)
        grid, states = periodic_state(scene, points=80, instants=8)
        force = np.einsum("xyt,x,y->t", states.overpressure[0], grid.x.weights, grid.y.weights)
        return float(-2 * np.mean(force * np.sin(grid.t.nodes)) / epsilon)

    assert spring(1.4) / spring(1.0) == pytest.approx(1.4, rel=2e-3)


@pytest.mark.parametrize("more", [{}, {"inertia": "included"}, {"bearing": 3.0}])
def test_slip_is_by_a_length_whatever_makes_it(more):
    """A coefficient c at a path λ is the coefficient 1 at c λ: the force and its budget."""
    short = film(epsilon=0.4, sigma=300.0, rarefaction="slip", knudsen=0.02, **more)
    kinetic = replace(short, gas=replace(short.gas, slip_coefficient=1.147))
    long = film(epsilon=0.4, sigma=300.0, rarefaction="slip", knudsen=1.147 * 0.02, **more)
    plain, one, other = (
        solve([each], tolerance=1e-4)[0].force_n for each in (short, kinetic, long)
    )
    assert one == pytest.approx(other, rel=1e-9)
    assert abs(one / plain - 1) > 1e-3
    first, second = (each.effects["inertia"].percent for each in error_budgets([kinetic, long]))
    assert first == pytest.approx(second, rel=1e-5)
