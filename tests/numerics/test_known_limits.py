"""Limits that are known apart from our solvers, by every method that should give them."""

from collections.abc import Callable

import pytest
from films import PISTON, SINC, film, limit, mean_overpressure
from physics_facts import SINC_FAST, SINC_SECOND_ORDER, slow_piston

from squeezefilm.film.profiles import Profile
from squeezefilm.reynolds.asymptotics.composite import high_squeeze_limit, small_amplitude_expansion
from verification import analytic
from verification.films import Film
from verification.numpy_periodic import periodic_state


def on_grid(
    epsilon: float, sigma: float, *, points: int, instants: int, profile: Profile = SINC
) -> float:
    scene = film(epsilon=epsilon, sigma=sigma, profile=profile)
    return mean_overpressure(scene, points=points, instants=instants, fold=True)


def in_numpy(epsilon: float, sigma: float, **settings: float) -> float:
    amplitude = Film("", epsilon, sigma).amplitude
    return periodic_state(epsilon=epsilon, sigma=sigma, amplitude=amplitude, **settings).force


def at_rest(force: Callable[[float], float]) -> float:
    """F/ε² for ε → 0, its next term removed."""
    coarse, fine = (force(epsilon) / epsilon**2 for epsilon in (0.04, 0.02))
    return (4 * fine - coarse) / 3


def at_speed(force: Callable[[float], float], sigma: float) -> float:
    """F for σ → ∞, which is approached like the layer's width, 1/√σ."""
    return 2 * force(4 * sigma) - force(sigma)


SECOND_ORDER: dict[str, Callable[[float], float]] = {
    "periodic state": lambda sigma: at_rest(lambda e: on_grid(e, sigma, points=40, instants=12)),
    "NumPy": lambda sigma: at_rest(lambda e: in_numpy(e, sigma, nx=28, ny=28, tolerance=1e-13)),
    "small amplitude": lambda sigma: (
        1e4 * limit(small_amplitude_expansion, epsilon=[0.01], sigma=[sigma], points=47).mean[0]
    ),
    "two linear solves": lambda sigma: analytic.small_amplitude(
        epsilon=1.0, sigma=sigma, amplitude=Film("", 1.0, sigma).amplitude
    ),
}


@pytest.mark.parametrize("method", SECOND_ORDER)
@pytest.mark.parametrize(("sigma", "known"), SINC_SECOND_ORDER.items())
def test_force_of_the_sinc_at_small_amplitude(method, sigma, known):
    assert SECOND_ORDER[method](sigma) == pytest.approx(known, rel=1e-6)


FAST: dict[str, tuple[Callable[[float], float], float]] = {
    "periodic state": (
        lambda epsilon: at_speed(lambda s: on_grid(epsilon, s, points=96, instants=16), 4e4),
        3e-6,
    ),
    "NumPy": (lambda epsilon: at_speed(lambda s: in_numpy(epsilon, s, nx=36, ny=36), 2500), 2e-4),
    "high-squeeze limit": (
        lambda epsilon: limit(high_squeeze_limit, epsilon=[epsilon], sigma=[1e9]).mean[0],
        1e-6,
    ),
    "a Laplace solve": (
        lambda epsilon: analytic.fast(epsilon=epsilon, amplitude=Film("", epsilon, 1.0).amplitude),
        1e-8,
    ),
}


@pytest.mark.parametrize("method", FAST)
@pytest.mark.parametrize(("epsilon", "known"), SINC_FAST.items())
def test_force_of_the_sinc_at_infinite_squeeze_number(method, epsilon, known):
    force, accuracy = FAST[method]
    assert force(epsilon) == pytest.approx(known, rel=accuracy)


@pytest.mark.parametrize("epsilon", [0.1, 0.5])
def test_slow_motion_of_a_piston_gives_the_incompressible_limit(epsilon):
    force = on_grid(epsilon, 1e-3, points=16, instants=32, profile=PISTON)
    assert force == pytest.approx(slow_piston(epsilon, 1e-3), rel=1e-5)
