"""Limits of validity are exceeded where the film equation ends, and not in the paper's space."""

from dataclasses import replace

import numpy as np
import pytest

from squeezefilm.film.pad import GapShape
from squeezefilm.film.profiles import Piston
from squeezefilm.film.validity import (
    ERROR_UNVERIFIED_TEXT,
    NOT_APPLICABLE_TEXT,
    OK,
    exceeded_limit_texts,
    validity_text,
)
from squeezefilm.studies.study import scene_of_study


def at(scene, h0_um, hv_um=1e-3, *, hz=43270.0, side_m=0.01, gap=None, speed=0.0, **gas):
    """A piston over a square pad."""
    return replace(
        scene,
        h0_m=1e-6 * h0_um,
        hv_m=1e-6 * hv_um,
        gas=replace(scene.gas, **gas),
        actuator=replace(scene.actuator, frequency_hz=hz, profile=Piston()),
        pad=replace(
            scene.pad,
            length_x_m=2 * side_m,
            length_y_m=side_m,
            gap=gap or GapShape(),
            speed_x_m_per_s=speed,
        ),
    )


IN = {"inertia": "included"}
SLIP = {"rarefaction": "slip"}
KINETIC = {"rarefaction": "fukui-kaneko"}


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"h0_um": 5, "side_m": 1e-5}, f"h0/l = 0.5 is above 0.1: {NOT_APPLICABLE_TEXT}"),
        (
            {"h0_um": 1e-3, "hv_um": 1e-4},
            f"Kn = 67 is above 0.18 (viscous flow): {NOT_APPLICABLE_TEXT} (use gas.rarefaction: "
            "fukui-kaneko)",
        ),
        (
            {"h0_um": 0.6, **SLIP},
            f"Kn = 0.112 is above 0.1 (first-order slip): {ERROR_UNVERIFIED_TEXT}",
        ),
        (
            {"h0_um": 69.66, "hz": 20e3},
            f"Re = 40.6 is above 10 (inertia neglected): {NOT_APPLICABLE_TEXT}",
        ),
        (
            {"h0_um": 24, **IN, "thermal": "included"},
            f"Re = 10.4 is above 10 (thermal effects included): {ERROR_UNVERIFIED_TEXT}",
        ),
        ({"h0_um": 5, "hz": 8e6}, f"h0/λ = 0.117 is above 0.1: {NOT_APPLICABLE_TEXT}"),
        ({"h0_um": 5, "speed": -1000.0}, f"Ma = 2.91 is above 1: {NOT_APPLICABLE_TEXT}"),
        ({"h0_um": 5, "speed": 120.0}, f"Ma = 0.35 is above 0.3: {ERROR_UNVERIFIED_TEXT}"),
        (
            {"h0_um": 30, "hz": 100.0, "side_m": 1.5e-3, "speed": 100.0},
            f"Re_s = 2 is above 1: {ERROR_UNVERIFIED_TEXT}",
        ),
        (
            {"h0_um": 30, "side_m": 1.5e-3, "speed": 100.0, "gap": GapShape(tilt_x_m=30e-6)},
            f"Re_s = 4.49 is above 1: {ERROR_UNVERIFIED_TEXT}",
        ),
        (
            {"h0_um": 200, "speed": 100.0},
            f"ρUh/μ = 1.33e+03 is above 1000: {ERROR_UNVERIFIED_TEXT}",
        ),
        ({"h0_um": 1, "hv_um": 0.92}, f"Ra/h = 1.25 is above 1: {ERROR_UNVERIFIED_TEXT}"),
    ],
)
def test_beyond_a_limit_the_quantity_bound_and_consequence_are_named(scene, changes, words):
    assert words in validity_text(at(scene, **changes))


def test_a_limit_is_for_its_own_model(scene):
    """Slip and inertia in the equation widen what it holds for."""
    assert validity_text(at(scene, 0.8)) != OK == validity_text(at(scene, 0.8, **SLIP))
    assert exceeded_limit_texts(at(scene, 0.06, **SLIP), ["Kn"])
    assert not exceeded_limit_texts(at(scene, 0.06, **KINETIC), ["Kn"])
    assert validity_text(at(scene, 14)) != OK == validity_text(at(scene, 14, **IN))
    assert (
        len(exceeded_limit_texts(at(scene, 300, 299.99))) == 5
    )  # all but those of Knudsen and sliding


@pytest.mark.parametrize("study", ["paper", "quick"])
def test_the_papers_space_is_within_the_limits(request, study):
    config = request.getfixturevalue(study)
    levels = config.screen.h0_m, config.screen.hv_m
    gaps, amplitudes = (np.linspace(each.start, each.stop, 5) for each in levels)
    for gap in gaps:
        for amplitude in amplitudes:
            assert validity_text(scene_of_study(config, gap, amplitude)) == OK
