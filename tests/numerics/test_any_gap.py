"""Gaps of any shape on the device: H = G(x, y) + ε (s₁ sin T + s₂ cos T)."""

from dataclasses import dataclass, replace
from math import cos, log, pi, sin

import numpy as np
import pytest
from films import (
    PISTON,
    AsTheGap,
    expansion_of,
    film,
    mean,
    mean_overpressure,
    periodic_state,
    with_pad,
)
from physics_facts import fast_piston

from squeezefilm.film.pad import GapShape
from squeezefilm.film.profiles import Profile, QuadratureProfile, StandingWave, TravellingWave
from squeezefilm.film.scene import Scene
from squeezefilm.film.surfaces import Disc
from squeezefilm.quantities.model_error import error_budgets
from squeezefilm.reynolds.asymptotics.composite import edge_layer_expansion, high_squeeze_limit
from squeezefilm.reynolds.solver import solve

DISC = Disc(0.01)
WAVE = StandingWave(wavelength_m=0.02, direction_deg=0.0, crest_m=0.001)
OTHER = StandingWave(wavelength_m=0.014, direction_deg=60.0, crest_m=0.004)
TWO_MODES = QuadratureProfile(WAVE, OTHER, component_factors=(0.7, 0.7))
FLAT = GapShape()
SHAPE = GapShape(tilt_x_m=2e-6, tilt_y_m=-1e-6, crown_m=0.5e-6)


def travelling(direction_deg: float = 0.0) -> Profile:
    return TravellingWave(0.02, direction_deg)


def begun_later(angle: float) -> QuadratureProfile:
    """The wave that stands, at another instant called the first."""
    return QuadratureProfile(WAVE, WAVE, component_factors=(cos(angle), sin(angle)))


def shaped(scene: Scene, gap: GapShape = SHAPE) -> Scene:
    return with_pad(scene, gap=gap)


@dataclass(frozen=True)
class Raised(GapShape):
    """A gap that is wider by the same everywhere."""

    rise: float = 1e-6

    @property
    def flat(self) -> bool:
        return False

    def rise_m(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        return self.rise + 0 * x


TERMS = [
    {},
    {"rarefaction": "fukui-kaneko"},
    {"polytropic_exponent": 1.4},
    {"bearing": 8.0},
    {"inertia": "included", "thermal": "included"},
]


@pytest.mark.parametrize("terms", TERMS, ids=lambda terms: "-".join(terms) or "squeeze")
def test_a_gap_raised_everywhere_is_that_of_a_film_so_much_thicker(terms):
    """With every term, whose own lines must all know of the gap at rest."""
    scene = film(epsilon=0.3, sigma=400.0, x=0.1, y=0.05, **terms)
    raised = shaped(scene, Raised(rise=0.2 * scene.h0_m))
    thicker = replace(scene, h0_m=1.2 * scene.h0_m)
    assert mean(raised, tolerance=1e-5) == pytest.approx(mean(thicker, tolerance=1e-5), rel=2e-6)


@pytest.mark.parametrize("terms", TERMS, ids=lambda terms: "-".join(terms) or "squeeze")
def test_a_standing_wave_may_begin_at_any_instant(terms):
    """s₁ and s₂ of one wave are that wave; begun on an instant of the grid even to rounding."""
    scene = film(epsilon=0.3, sigma=400.0, x=0.1, profile=WAVE, **terms)
    expected = mean_overpressure(scene, points=16, instants=12)
    for angle in (0.0, pi / 6, 0.7):
        later = replace(scene, actuator=replace(scene.actuator, profile=begun_later(angle)))
        found = mean_overpressure(later, points=16, instants=12)
        assert found == pytest.approx(expected, rel=1e-5 if angle == 0.7 else 1e-8)


@pytest.mark.parametrize(
    ("numbers", "gap", "expected"),
    [
        ({}, GapShape(tilt_x_m=2e-6), 0.04283862),
        ({"x": 0.1, "aspect": 0.7}, SHAPE, 0.04677095),
        ({"profile": travelling()}, GapShape(), 0.09073891),
        ({"profile": TWO_MODES, "bearing": 5.0, "aspect": 1.3}, SHAPE, -0.01909589),
        (
            {"profile": TWO_MODES, "rarefaction": "slip", "polytropic_exponent": 1.4},
            SHAPE,
            0.04842844,
        ),
    ],
)
def test_forces_are_those_of_galerkin_s_method_in_the_pad_s_modes(numbers, gap, expected):
    """Mean overpressures good to 2e-7, by a method that shares the equation alone."""
    scene = shaped(film(epsilon=0.3, sigma=200.0, **numbers), gap)
    assert mean(scene) == pytest.approx(expected, rel=1.5e-6)


def test_a_gap_that_breathes_keeps_its_mean_square():
    """H = G(x, y) (1 + ε sin T): div(G³ ∇⟨(1 + ε sin T)³ P²⟩) = 0 makes that mean 1 + 3ε²/2."""
    epsilon = 0.4
    still = shaped(film(epsilon=epsilon, sigma=50.0))
    scene = replace(still, actuator=replace(still.actuator, profile=AsTheGap(still)))
    grid, states = periodic_state(scene, points=24, instants=24)
    pressure = 1 + states.gauge_pressure_ratio[0]
    mean_square = ((1 + epsilon * np.sin(grid.t.nodes)) ** 3 * pressure**2).mean(axis=-1)
    assert mean_square == pytest.approx(1 + 1.5 * epsilon**2, rel=1e-6)
    assert np.ptp(pressure.mean(axis=-1)) > 0.01


@pytest.mark.parametrize(
    ("numbers", "gap"),
    [
        ({"profile": travelling()}, FLAT),
        ({"profile": TWO_MODES, "aspect": 8.0}, FLAT),
        ({"x": 0.1}, GapShape(tilt_x_m=2e-6)),
        ({"profile": PISTON, "aspect": 0.6}, GapShape(crown_m=-0.7e-6)),
        ({"x": 0.1, "y": 0.05}, SHAPE),
        ({"profile": TWO_MODES}, SHAPE),
        ({"profile": travelling()}, GapShape(crown_m=1e-6)),
    ],
)
def test_limits_of_fast_squeezing_know_any_gap(numbers, gap):
    """What is left falls as σ^(−1/2), and with the rim's layer at least as 1/σ.

    In two phases s₁² + s₂² stands for s², over a gap G the layer is G times as thick and
    ∇·(G³ ∇(ψ²/G²)) = 0.
    """
    sigma = 1e3, 1e5
    left = {high_squeeze_limit: [], edge_layer_expansion: []}
    for each in sigma:
        scene = shaped(film(epsilon=0.4, sigma=each, **numbers), gap)
        (exact,) = solve([scene], tolerance=1e-7, method="periodic")
        for expand, errors in left.items():
            force_n, error_n = expansion_of(expand, scene, tolerance=1e-5)
            errors.append(abs(force_n / exact.force_n - 1))
            assert abs(force_n - exact.force_n) <= error_n
    order = {expand: log(few / many) / log(1e-2) for expand, (many, few) in left.items()}
    assert order[high_squeeze_limit] == pytest.approx(0.5, abs=0.1)
    assert order[edge_layer_expansion] > 0.9


def test_the_fast_limit_of_a_gap_that_breathes_is_the_piston_s():
    """H = G(x, y) (1 + ε sin T): ψ²/G² is the same everywhere."""
    still = shaped(film(epsilon=0.4, sigma=1e4, aspect=0.7))
    scene = replace(still, actuator=replace(still.actuator, profile=AsTheGap(still)))
    breathing_n, _ = expansion_of(high_squeeze_limit, scene, tolerance=1e-9)
    assert breathing_n / scene.force_scale_n == pytest.approx(fast_piston(0.4), rel=1e-10)
    layer_n, _ = expansion_of(edge_layer_expansion, scene, tolerance=1e-9)
    assert abs(layer_n / mean(scene) / scene.force_scale_n - 1) < 1e-4


def test_small_motion_in_two_phases_has_its_second_order():
    for sigma in (5.0, 583.0):
        scene = film(epsilon=0.01, sigma=sigma, profile=TWO_MODES)
        (found,) = solve([scene], tolerance=1e-6, method="composite")
        assert found.force_n / scene.force_scale_n == pytest.approx(mean(scene), rel=3e-4)


def test_the_budget_is_of_the_scene_itself():
    """The budget's inertia beside inertia solved for, where it is small."""
    scene = shaped(film(epsilon=0.3, sigma=300.0, x=0.1, profile=TWO_MODES))
    scene = scene.with_gas(density_kg_per_m3=0.05)
    (budget,) = error_budgets([scene])
    assert budget.status == "ok"
    inert = scene.with_gas(inertia="included")
    change = mean(inert, tolerance=1e-5) / mean(scene) - 1
    assert budget.effects["inertia"].percent == pytest.approx(100 * change, rel=0.03)
