"""Flow around a film's edge: its impedance by finite elements, and the law that the budget has."""

from dataclasses import replace
from math import log, pi

import pytest

from squeezefilm.film.scene import Scene
from squeezefilm.quantities.edge_effects import (
    EDGE_INERTANCE,
    EDGE_RESISTANCE,
    edge_flow_error_ratios,
    edge_inertance,
)
from squeezefilm_workflow.verification.edge_flow import edge_impedance


def test_slow_flow_sees_the_gap_0_64_gaps_longer():
    """Veijola, Pursula and Råback (2005) have 1.3 for the two sides."""
    assert edge_impedance(0.0) == pytest.approx(EDGE_RESISTANCE, rel=0.02)
    assert edge_impedance(0.0) == pytest.approx(1.3 / 2, rel=0.03)


@pytest.mark.parametrize("reynolds", [0.2, 2.0, 8.0])
@pytest.mark.parametrize("radius", [50.0, 400.0])
def test_the_impedance_is_a_resistance_and_an_inertance(reynolds, radius):
    impedance = edge_impedance(reynolds, open_radius=radius)
    inertance = EDGE_INERTANCE + log(radius) / (6 * pi)
    # The wave of sound that leaves the edge is no part of the resistance here.
    assert impedance.real == pytest.approx(EDGE_RESISTANCE, rel=0.03 + 0.03 * reynolds)
    assert impedance.imag / reynolds == pytest.approx(inertance, rel=0.08)


@pytest.mark.parametrize("slip_length", [0.02, 0.1])
def test_slip_eases_flow_around_the_edge_within_the_error(scene: Scene, slip_length: float):
    knudsen = slip_length  # a slip coefficient of 1
    thin = replace(scene, h0_m=scene.gas.mean_free_path_m / knudsen)
    error_ratio, _ = edge_flow_error_ratios(thin)
    resistance = edge_impedance(0.0, slip_length=slip_length).real
    assert resistance == pytest.approx(EDGE_RESISTANCE, rel=error_ratio)
    assert resistance < 0.97 * EDGE_RESISTANCE


def test_the_inertance_counts_gas_as_far_as_a_wave_of_sound_is_near(scene: Scene):
    """Up to the pad's shorter side where that is nearer; and more for a thinner gap."""
    slow = replace(scene, actuator=replace(scene.actuator, frequency_hz=100.0))
    side_m = min(scene.pad.length_x_m, scene.pad.length_y_m)
    assert edge_inertance(slow) == pytest.approx(
        EDGE_INERTANCE + log(side_m / scene.h0_m) / (6 * pi)
    )
    thin = replace(scene, h0_m=scene.h0_m / 2)
    assert edge_inertance(thin) == pytest.approx(edge_inertance(scene) + log(2) / (6 * pi))
    assert edge_inertance(scene) <= edge_inertance(slow)
