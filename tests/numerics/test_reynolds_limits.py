"""The periodic solver against analytic limits of the Reynolds equation."""

import numpy as np
import pytest
from films import PISTON, SINC, film, mean_overpressure, periodic_state, spring_and_damping
from physics_facts import (
    CUT_OFF_SIGMA,
    DAMPING_AT_CUT_OFF,
    SINC_CONVERGED,
    SINC_FAST,
    SINC_SECOND_ORDER,
    SPRING_AT_20,
    SPRING_AT_CUT_OFF,
    piston_response,
    slow_piston,
)


@pytest.mark.parametrize(("sigma", "aspect"), [(2.0, 1.0), (60.0, 0.4), (CUT_OFF_SIGMA, 1.0)])
def test_small_motion_of_a_piston_follows_the_linear_series(sigma, aspect):
    scene = film(epsilon=1e-5, sigma=sigma, profile=PISTON, aspect=aspect)
    found = spring_and_damping(scene, points=32)
    assert found == pytest.approx(piston_response(sigma, aspect), rel=2e-5)
    if sigma == CUT_OFF_SIGMA:
        assert found == pytest.approx((SPRING_AT_CUT_OFF, DAMPING_AT_CUT_OFF), abs=2e-7)


@pytest.mark.parametrize(("epsilon", "sigma"), [(0.3, 1.0), (0.44, 2331.0), (0.8, 100.0)])
def test_mean_square_of_gap_times_pressure_weighted_by_gap_is_exact_everywhere(epsilon, sigma):
    """⟨H³P²⟩ = 1 + 3ε²/2 at every point of a piston film, at any squeeze number."""
    grid, states = periodic_state(
        film(epsilon=epsilon, sigma=sigma, profile=PISTON), points=40, instants=48
    )
    gap = 1 + epsilon * np.sin(grid.t.nodes)
    value = np.mean(gap**3 * (1 + states.gauge_pressure_ratio[0]) ** 2, axis=-1)
    assert value == pytest.approx(1 + 1.5 * epsilon**2, rel=1e-8)


def test_mean_force_of_a_piston_grows_like_five_quarters_of_the_spring_number():
    """F = (5/4) ε² S(σ) + O(ε⁴): the relative difference falls with ε²."""
    differences = [
        mean_overpressure(
            film(epsilon=epsilon, sigma=20.0, profile=PISTON), points=24, instants=16, fold=True
        )
        / (1.25 * epsilon**2 * SPRING_AT_20)
        - 1
        for epsilon in (0.2, 0.1, 0.05)
    ]
    orders = np.log2(np.divide(differences[:-1], differences[1:]))
    assert orders == pytest.approx(2.0, abs=0.1)


@pytest.mark.parametrize(("sigma", "force"), SINC_CONVERGED.items())
def test_converged_force_of_the_centred_sinc(sigma, force):
    scene = film(epsilon=0.44, sigma=sigma)
    assert mean_overpressure(scene, points=40, instants=20, fold=True) == pytest.approx(
        force, rel=1e-9
    )


def test_divergence_form_of_the_equation_holds_with_every_term():
    """The state, put into eq. (1) as it stands there, leaves nothing: all terms, all signs."""
    scene = film(epsilon=0.3, sigma=40.0, x=0.12, y=0.2, bearing=30.0, aspect=0.8)
    grid, states = periodic_state(scene, points=36, instants=20, tolerance=1e-12)
    assert states.status_indices[0] == 0
    x, y = np.meshgrid(grid.x.all_nodes, grid.y.all_nodes, indexing="ij")
    sine = np.sin(grid.t.nodes)
    gap = 1 + scene.epsilon * scene.amplitude(x, y)[..., None] * sine
    gap_rate = scene.epsilon * scene.amplitude(x, y)[..., None] * np.cos(grid.t.nodes)
    pressure = 1 + np.pad(states.gauge_pressure_ratio[0], ((1, 1), (1, 1), (0, 0)))

    def d_dx(values: np.ndarray) -> np.ndarray:
        return np.einsum("ij,jyt->iyt", grid.x.derivative_matrix, values)

    def d_dy(values: np.ndarray) -> np.ndarray:
        return np.einsum("ij,xjt->xit", grid.y.derivative_matrix, values) / scene.aspect

    flow = gap**3 * pressure
    pressure_rate = pressure @ grid.t.derivative_matrix.T
    squeeze = scene.sigma * (gap_rate * pressure + gap * pressure_rate)
    slide = scene.bearing_number * d_dx(gap * pressure)
    diffusion = d_dx(flow * d_dx(pressure)) + d_dy(flow * d_dy(pressure))
    inner = (slice(1, -1), slice(1, -1))

    def size(values: np.ndarray) -> float:
        mean_square = np.mean(values[inner] ** 2, axis=-1)
        return float(np.sqrt(grid.x.quadrature_weights @ mean_square @ grid.y.quadrature_weights))

    # Second derivatives have weak singularities in the corners: a mean, not the largest value.
    assert size(diffusion - squeeze - slide) < 1e-5 * size(squeeze)
    assert size(slide) > 0.1 * size(squeeze)


def test_space_converges_faster_than_any_power():
    scene = film(epsilon=0.4, sigma=583.0, x=0.2, y=0.1)
    exact = mean_overpressure(scene, points=48, instants=16)
    errors = [
        abs(mean_overpressure(scene, points=n, instants=16) / exact - 1) for n in (8, 16, 24, 32)
    ]
    assert errors[0] < 1e-2
    assert errors[-1] < 1e-9
    orders = np.log(np.divide(errors[:-1], errors[1:])) / np.log(
        np.divide([16, 24, 32], [8, 16, 24])
    )
    assert orders.max() > 8


def test_time_converges_geometrically_at_the_rate_of_the_gap():
    """Errors fall like ρ^n with ρ = ε / (1 + √(1 − ε²)), the harmonics of 1/(1 + ε sin T)."""
    epsilon = 0.8
    ratio = epsilon / (1 + np.sqrt(1 - epsilon**2))
    scene = film(epsilon=epsilon, sigma=583.0, profile=SINC)
    exact = mean_overpressure(scene, points=24, instants=64, fold=True)
    errors = [
        abs(mean_overpressure(scene, points=24, instants=n, fold=True) / exact - 1)
        for n in (12, 16, 20, 24)
    ]
    rates = np.divide(errors[1:], errors[:-1]) ** (1 / 4)
    assert rates == pytest.approx(ratio, abs=0.06)


@pytest.mark.parametrize("epsilon", [0.1, 0.5])
def test_slow_motion_of_a_piston_gives_the_incompressible_limit(epsilon):
    scene = film(epsilon=epsilon, sigma=1e-3, profile=PISTON)
    force = mean_overpressure(scene, points=16, instants=32, fold=True)
    assert force == pytest.approx(slow_piston(epsilon, 1e-3), rel=1e-5)


@pytest.mark.parametrize(("sigma", "known"), SINC_SECOND_ORDER.items())
def test_second_order_of_the_periodic_state(sigma, known):
    """F/ε² for ε → 0, its next term removed."""
    coarse, fine = (
        mean_overpressure(film(epsilon=e, sigma=sigma), points=40, instants=12, fold=True) / e**2
        for e in (0.04, 0.02)
    )
    assert (4 * fine - coarse) / 3 == pytest.approx(known, rel=1e-6)


@pytest.mark.parametrize(("epsilon", "known"), SINC_FAST.items())
def test_periodic_state_at_infinite_squeeze_number(epsilon, known):
    """Approached like the layer's width, 1/√σ."""
    slower, faster = (
        mean_overpressure(film(epsilon=epsilon, sigma=s), points=96, instants=16, fold=True)
        for s in (4e4, 16e4)
    )
    assert 2 * faster - slower == pytest.approx(known, rel=3e-6)
