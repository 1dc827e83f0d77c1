"""Methods without time steps against known values, the periodic solver and their own errors."""

from pathlib import Path
from unittest.mock import patch

import numpy as np
import pytest
from films import PISTON, SINC, film, limit, mean_overpressure
from physics_facts import SINC_FAST, SINC_SECOND_ORDER, fast_piston

from squeezefilm.film.profiles import Sinc
from squeezefilm.reynolds.asymptotics import core, edge_layer
from squeezefilm.reynolds.asymptotics import films as estimates
from squeezefilm.reynolds.asymptotics.composite import (
    composite_expansion,
    edge_layer_expansion,
    expand_scenes,
    expansion_nodes_per_axis,
    high_squeeze_limit,
    small_amplitude_expansion,
)
from squeezefilm.reynolds.asymptotics.films import expansion_axis
from squeezefilm.reynolds.plan import solve_plan_of
from squeezefilm_workflow.verification.edge_layers import layer_coefficients, table_excursions
from squeezefilm_workflow.verification.estimates import film_of_row, read_stored_films

STORED = read_stored_films(Path(__file__).parent / "data" / "expanded_films.csv")
EXPANSIONS = {
    "edge layer": edge_layer_expansion,
    "second order": small_amplitude_expansion,
    "composite": composite_expansion,
}


@pytest.mark.parametrize(
    ("a", "d", "g"),
    [(0.05, -0.002210, 0.106105), (0.2, -0.035542, 0.426760), (0.4, -0.145800, 0.867386)],
)
def test_boundary_layer_functions_at_known_excursions(a, d, g):
    """Values found with an independent solver, to its digits; d is even and g odd."""
    assert edge_layer.layer_integrals(np.array([a, -a])) == (
        pytest.approx([d, d], abs=3e-6),
        pytest.approx([g, -g], abs=2e-5),
    )


@pytest.mark.parametrize("row", [0, 3, 20])
def test_the_layer_of_a_row_of_the_table_is_found_again(row):
    """``squeezefilm-verification edge-layers``."""
    table = np.loadtxt(edge_layer.LAYER_TABLE_PATH, delimiter=",", skiprows=1)
    a = table_excursions()[row]
    assert (a, *layer_coefficients(a)) == pytest.approx(table[row], rel=1e-8)


def test_boundary_layer_of_small_excursions_is_linear():
    a = 1e-3
    d, g = edge_layer.layer_integrals(np.array([a]))
    assert d / a**2 == pytest.approx(-5 * np.sqrt(2) / 8, rel=1e-6)
    assert g / a == pytest.approx(3 / np.sqrt(2), rel=1e-6)
    ratios = edge_layer.scaled_layer_integrals(np.array(a))
    assert ratios == pytest.approx([d[0] / a**2, g[0] / a, -3 / np.sqrt(2)], rel=1e-6)
    assert np.isnan(edge_layer.layer_integrals(np.array([0.99]))[0]).all()


@pytest.mark.parametrize("aspect", [1.0, 0.3])
def test_high_squeeze_limit_of_a_piston_is_the_closed_form(aspect):
    """The paper's eq. (6)."""
    epsilon, sigma = np.array([0.01, 0.5, 0.97]), np.full(3, 1e4)
    expected = [fast_piston(each) for each in epsilon]
    forces = limit(high_squeeze_limit, epsilon=epsilon, sigma=sigma, profile=PISTON, aspect=aspect)
    assert forces.mean_pressure_ratio == pytest.approx(expected, rel=1e-11)


@pytest.mark.parametrize(("sigma", "known"), SINC_SECOND_ORDER.items())
def test_force_of_the_sinc_at_small_amplitude(sigma, known):
    found = limit(small_amplitude_expansion, epsilon=[0.01], sigma=[sigma], points=47)
    assert 1e4 * found.mean_pressure_ratio[0] == pytest.approx(known, rel=1e-6)


@pytest.mark.parametrize(("epsilon", "known"), SINC_FAST.items())
def test_force_of_the_sinc_at_infinite_squeeze_number(epsilon, known):
    found = limit(high_squeeze_limit, epsilon=[epsilon], sigma=[1e9])
    assert found.mean_pressure_ratio[0] == pytest.approx(known, rel=1e-6)


def test_order_of_the_limits_in_the_squeeze_number():
    """The fast limit is left by 1/√σ, the boundary layer's by 1/σ where only corners are left."""
    sigma = np.array([500.0, 2000.0, 8000.0])
    converged = np.array(
        [
            mean_overpressure(
                film(epsilon=0.4, sigma=number, profile=PISTON), points=56, instants=20, fold=True
            )
            for number in sigma
        ]
    )
    epsilon = np.full(3, 0.4)
    orders = []
    for method in (high_squeeze_limit, edge_layer_expansion):
        mean = limit(method, epsilon=epsilon, sigma=sigma, profile=PISTON).mean_pressure_ratio
        errors = np.abs(mean - converged)
        orders.append(np.log(errors[:-1] / errors[1:]) / np.log(4))
    assert orders[0] == pytest.approx(0.5, abs=0.05)
    assert orders[1] == pytest.approx(1.0, abs=0.1)


@pytest.mark.parametrize(
    ("method", "relative_error"),
    [
        (edge_layer_expansion, 1e-2),
        (small_amplitude_expansion, 2e-2),
        (composite_expansion, 5e-4),
    ],
)
def test_slip_off_the_centre(method, relative_error):
    place = {"x": 0.1, "y": 0.2, "aspect": 0.7}
    scene = film(epsilon=0.2, sigma=800.0, rarefaction="slip", knudsen=0.05, **place)
    converged = mean_overpressure(scene, points=32, instants=16)
    forces = limit(method, epsilon=[0.2], sigma=[800.0], slip=0.3, **place)
    assert forces.mean_pressure_ratio[0] == pytest.approx(converged, rel=relative_error)
    assert abs(forces.mean_pressure_ratio[0] - converged) <= forces.pressure_ratio_error[0]


def test_slip_at_large_squeeze_number():
    """ψ²/2 + slip ψ harmonic, rim value (1 + 3ε²s²/2)/2 + slip (1 + ε²s²/2): constant for s = 1."""
    epsilon, slip = 0.5, 0.3
    harmonic = (1 + 1.5 * epsilon**2) / 2 + slip * (1 + epsilon**2 / 2)
    mass = -slip + np.sqrt(slip**2 + 2 * harmonic)
    forces = limit(high_squeeze_limit, epsilon=[epsilon], sigma=[1e6], profile=PISTON, slip=slip)
    assert forces.mean_pressure_ratio[0] == pytest.approx(
        mass / np.sqrt(1 - epsilon**2) - 1, rel=1e-12
    )
    assert mass < np.sqrt(1 + 1.5 * epsilon**2)


def test_limits_say_where_they_do_not_hold():
    thick = limit(edge_layer_expansion, epsilon=[0.3, 0.3], sigma=[5.0, 500.0])
    assert np.isinf(thick.pressure_ratio_error).tolist() == [True, False]
    beyond = limit(edge_layer_expansion, epsilon=[0.99], sigma=[1e4], profile=PISTON)
    assert np.isinf(beyond.pressure_ratio_error).all()
    with pytest.raises(ValueError, match="odd number"):
        expansion_axis(12)


@pytest.mark.parametrize(
    ("method", "largest_median"),
    [
        (high_squeeze_limit, 3),
        (edge_layer_expansion, 30),
        (small_amplitude_expansion, 12),
        (composite_expansion, 60),
    ],
)
def test_error_estimates_hold_on_random_films(method, largest_median, random_films):
    ratios = []
    for numbers, profile, converged in random_films:
        points = expansion_nodes_per_axis(
            tolerance=1e-3, sigma=numbers["sigma"] * max(1.0, numbers["aspect"]) ** 2
        )
        epsilon, sigma = [numbers["epsilon"]], [numbers["sigma"]]
        place = {name: numbers[name] for name in ("x", "y", "aspect")}
        forces = limit(
            method, epsilon=epsilon, sigma=sigma, profile=profile, points=points, **place
        )
        ratios.append(
            forces.pressure_ratio_error[0] / abs(forces.mean_pressure_ratio[0] - converged)
        )
    assert min(ratios) > 1
    # Honest, but not by despair.
    assert np.median(ratios) < largest_median


def error_over_estimate(row) -> float:
    plan, layers = solve_plan_of(film_of_row(row).scene), row["expansion"] != "edge layer"
    found = expand_scenes(EXPANSIONS[row["expansion"]], plan, [0], tolerance=1e-4, layers=layers)
    return float(
        (
            abs(found.mean_pressure_ratio - row["force"])
            / (found.pressure_ratio_error + row["force_error"])
        ).item()
    )


# Where constants stand, and the values with which they change nothing.
SWITCHED_OFF = {"FREE_FLOW_SIGMA": (estimates, 1e-9), "HARMONIC_SUM_PRECISION": (core, 1.0)}


@pytest.mark.parametrize("number", STORED.index)
def test_no_constant_of_an_expansion_s_estimate_is_there_for_nothing(number):
    """The error of a film is within the estimate, and outside without each constant."""
    row = STORED.loc[number]
    assert error_over_estimate(row) < 1
    for name in row["guard"].split(", "):
        module, value = SWITCHED_OFF.get(name, (estimates, 0.0))
        with patch.object(module, name, value):
            assert error_over_estimate(row) > 1


@pytest.fixture(scope="module")
def random_films():
    """Films with their forces converged to about 1e-7."""
    generator = np.random.default_rng(7)
    films = []
    for profile in (PISTON, SINC, Sinc(wave_number_per_m=180.0)) * 4:
        numbers = {
            "epsilon": generator.uniform(0.02, 0.8),
            "sigma": 10 ** generator.uniform(1.6, 3.5),
            "x": generator.uniform(-0.3, 0.3),
            "y": generator.uniform(-0.3, 0.3),
            "aspect": 10 ** generator.uniform(-0.3, 0.3),
        }
        scene = film(profile=profile, **numbers)
        films.append((numbers, profile, mean_overpressure(scene, points=32, instants=36)))
    return films
