"""Heat in the periodic state: first order, resolved strips, slip, refusals, ``auto``."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from films import film, mean_overpressure
from random_scenes import moved_by_leaving_out, random_scenes

from squeezefilm.film.profiles import Formula
from squeezefilm.film.scene import Scene
from squeezefilm.film.surfaces import Disc
from squeezefilm.quantities.model_error import (
    error_budgets,
    resolve_auto_terms,
)
from squeezefilm.reynolds import solve
from squeezefilm.reynolds.spectral import axis
from squeezefilm.reynolds.terms.heat import Heat
from squeezefilm.reynolds.terms.inertia import LAG_PER_REYNOLDS

STRIP = Formula("sinc(109.8*x)", surface=Disc(1.0))


def warm(reynolds: float, **numbers: object) -> Scene:
    """A scene of tests with heat, by its modified Reynolds number."""
    scene = film(heat="included", **numbers)  # type: ignore[arg-type]
    density = scene.gas.density_kg_per_m3 * reynolds / scene.modified_reynolds
    return with_gas(scene, density_kg_per_m3=density)


def with_gas(scene: Scene, **gas: object) -> Scene:
    return replace(scene, gas=replace(scene.gas, **gas))  # type: ignore[arg-type]


def effect_percent(scene: Scene, *, tolerance: float) -> float:
    """Change of the force by heat."""
    pair = [scene, with_gas(scene, heat="none")]
    solved = solve(pair, tolerance=tolerance, method="periodic")
    assert [each.status for each in solved] == ["ok", "ok"]
    return 100 * (solved[0].force_n / solved[1].force_n - 1)


@pytest.mark.parametrize(
    "numbers",
    [
        {"sigma": 583.0, "inertia": "included"},
        {"sigma": 40.0, "inertia": "none", "x": 0.2, "y": 0.1},
        {"sigma": 583.0, "inertia": "included", "rarefaction": "slip", "knudsen": 0.03},
    ],
)
def test_a_little_heat_moves_the_force_by_the_first_order(numbers: dict[str, object]) -> None:
    """Beside slip too: its jump of temperature makes 30 % of the effect here."""
    scene = warm(0.01, epsilon=0.4, **numbers)
    (budget,) = error_budgets([with_gas(scene, heat="none", inertia="none")])
    found = effect_percent(scene, tolerance=1e-8)
    assert found == pytest.approx(budget.effects["heat"].percent, rel=0.015)


def mean_warmth(rate: complex, jump: float) -> complex:
    """Mean over the gap of θ″ − rate θ = −1, whose ends are jump times its slope inwards."""
    line = axis(24, False)
    square = (line.derivative @ line.derivative - rate * np.eye(26)).astype(complex)
    right = np.full(26, -1.0, dtype=complex)
    for end, inwards in ((0, 1), (-1, -1)):
        square[end] = np.eye(26)[end] - inwards * jump * line.derivative[end]
        right[end] = 0
    rim = (1 - line.weights.sum()) / 2
    return complex([rim, *line.weights, rim] @ np.linalg.solve(square, right))


@pytest.mark.parametrize("knudsen", [0.0, 0.0134, 0.05])
def test_the_jump_of_temperature_is_that_of_a_gas_that_conducts_across_the_gap(
    knudsen: float,
) -> None:
    """Warming to round-off, its lag to first order in the jump, what is missed no more than 6j²."""
    scene = film(epsilon=0.2, sigma=200.0, heat="included", knudsen=knudsen or 1e-12)
    scene = with_gas(scene, rarefaction="slip")
    numbers = {name: float(value) for name, value in Heat().numbers(scene).items()}  # type: ignore[arg-type]
    jump = 2 * 1.4 / (2.4 * 0.71) * knudsen
    at_rest, slow = (mean_warmth(rate, jump) for rate in (0.0, 1e-4j))
    assert at_rest.real == pytest.approx((1 + numbers["jump_warms"]) / 12, rel=1e-9)
    lag = -slow.imag / (1e-4 * at_rest.real)
    missed = lag / (LAG_PER_REYNOLDS * (1 + numbers["jump_lags"])) - 1
    assert 3 * jump**2 - 1e-6 < missed < 6 * jump**2 + 1e-6


def test_grids_converge_to_the_force_with_heat() -> None:
    scene = warm(1.8, epsilon=0.4, sigma=583.0, inertia="included", x=0.1)
    coarse, fine, finest = (
        mean_overpressure(scene, points=points, instants=instants)
        for points, instants in ((20, 12), (28, 16), (36, 20))
    )
    assert abs(fine / finest - 1) < 2e-5
    assert abs(coarse - finest) > 5 * abs(fine - finest)


@pytest.mark.parametrize("gas", [{"prandtl": 1e-3}, {"heat_capacity_ratio": 1.0}])
def test_without_heat_s_numbers_the_force_is_the_isothermal_one(gas: dict[str, float]) -> None:
    scene = with_gas(warm(1.0, epsilon=0.4, sigma=583.0, inertia="included"), **gas)
    # Friction and compression warm in proportion to Pr (γ − 1)/γ.
    assert abs(effect_percent(scene, tolerance=1e-7)) < 1e-3


def test_heat_that_auto_leaves_out_moves_no_force_by_more_than_allowed(scene: Scene) -> None:
    scenes = random_scenes(scene, count=30, seed=7, most_reynolds=2.0, inertia="auto", heat="auto")
    moved = moved_by_leaving_out(scenes, term="heat", model_tolerance=5e-3)
    assert 3 < len(moved) < 27
    assert 1e-3 < moved.max() < 5e-3


def test_auto_includes_heat_where_a_first_order_says_nothing(scene: Scene) -> None:
    thick = replace(with_gas(scene, heat="auto"), h0_m=15e-6, hv_m=1e-6)
    assert thick.modified_reynolds > 2
    assert resolve_auto_terms([thick], model_tolerance=0.5)[0].gas.heat == "included"
