"""The gap under a load against the solver's own forces, and mistakes told."""

from dataclasses import replace
from math import pi

import numpy as np
import pandas as pd
import pytest
from films import film

from squeezefilm.cli.main import main
from squeezefilm.io.errors import InputError
from squeezefilm.reynolds import solve
from squeezefilm.reynolds.device import choose_device
from squeezefilm.reynolds.dynamics.levitation import levitate
from squeezefilm.reynolds.dynamics.resonance import resonance

DEVICE = choose_device()
SETTINGS = {"tolerance": 1e-6, "model_tolerance": 1e-3, "device": DEVICE}


@pytest.mark.parametrize("inertia", ["none", "included"])
def test_the_gap_found_is_the_one_that_the_force_was_simulated_at(inertia):
    scene = film(epsilon=0.4, sigma=1000.0, inertia=inertia)
    settings = SETTINGS | ({"tolerance": 1e-4} if inertia == "included" else {})
    (force,) = solve([scene], tolerance=settings["tolerance"], device=DEVICE)
    found = levitate(scene, load_n=force.force_n, **settings)
    assert found.scene.h0_m == pytest.approx(scene.h0_m, abs=2 * found.h0_error_m)
    assert found.h0_error_m < 1e-4 * scene.h0_m
    assert found.stable


def test_stiffness_is_the_slope_of_the_force():
    """For small motion the force goes like (hv/h0)² S(σ(h0)): with σ → ∞, k = 2 F/h0."""
    scene = film(epsilon=0.02, sigma=1e5)
    (force,) = solve([scene], tolerance=1e-7, device=DEVICE)
    found = levitate(scene, load_n=force.force_n, **SETTINGS)
    assert found.stiffness_n_per_m == pytest.approx(2 * force.force_n / scene.h0_m, rel=0.02)


def test_a_heavy_mass_swings_on_the_slow_spring_and_a_light_one_on_gas_that_stays():
    """Between them gas that is pressed out damps the motion, and to fast a motion is no answer."""
    scene = film(epsilon=0.2, sigma=1e4)
    (force,) = solve([scene], tolerance=1e-6, device=DEVICE)
    found = levitate(scene, load_n=force.force_n, **SETTINGS)
    trapped = scene.force_scale_n / found.scene.h0_m
    # Squeeze numbers of the motion: far below that of the film's corner, about 20, and far above.
    vibration = scene.actuator.angular_frequency_rad_per_s
    slow, fast = 1e-2 * vibration / 1e4, 1e3 * vibration / 1e4
    heavy = resonance(found, mass_kg=found.stiffness_n_per_m / slow**2)
    assert heavy.frequency_hz == pytest.approx(slow / (2 * pi), rel=1e-3)
    light = resonance(found, mass_kg=trapped / fast**2)
    assert light.frequency_hz == pytest.approx(fast / (2 * pi), rel=0.06)
    assert 0 < light.damping_ratio < 0.1
    assert "tenth" in resonance(found, mass_kg=trapped / vibration**2).reason
    ratios = [
        resonance(found, mass_kg=trapped / (rate * vibration / 1e4) ** 2)
        for rate in np.geomspace(1, 1e3, 13)
    ]
    assert max(each.damping_ratio for each in ratios) > 0.4
    damped = [each for each in ratios if np.isnan(each.frequency_hz)]
    assert all(each.damping_ratio > MOST_DAMPING for each in damped)


def test_a_resonance_that_is_not_known_says_why():
    scene = film(epsilon=0.4, sigma=1000.0)
    scene = replace(scene, finger=replace(scene.finger, shape="ellipse"))
    (force,) = solve([scene], tolerance=1e-4, device=DEVICE)
    found = levitate(scene, load_n=force.force_n, **SETTINGS | {"tolerance": 1e-4})
    assert "rectangular" in resonance(found, mass_kg=0.1).reason


def test_a_load_that_no_gap_carries_is_refused_with_the_range():
    with pytest.raises(InputError, match=r"no gap .* carries 1e\+06 N"):
        levitate(film(epsilon=0.4, sigma=1000.0), load_n=1e6, **SETTINGS)


def test_a_table_keeps_every_load_with_a_reason_where_it_has_no_gap(tmp_path):
    output = tmp_path / "levitation.csv"
    words = ["levitate", "--load", "0.5N,1000N", "--hv", "1.5um", "--output", str(output)]
    assert main(words) == 0
    table = pd.read_csv(output)
    assert table.loc[0, "status"] == "ok"
    assert table.loc[0, "h0_m"] == pytest.approx(4.643e-6, rel=1e-3)
    assert "no gap" in table.loc[1, "status"]
    assert pd.isna(table.loc[1, "h0_m"])


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["levitate", "--hv", "1um"], "--load and --hv"),
        (["levitate", "--load", "1um", "--hv", "1um"], "unit of N"),
        (["levitate", "--load", "0.5N,-1N", "--hv", "1um"], "--load '0.5N,-1N' must be positive"),
        (["levitate", "--load", "1000N", "--hv", "1um"], "carries 1000 N"),
        (["levitate", "--load", "0.5N", "--hv", "1um", "--mass", "0g"], "must be positive"),
    ],
)
def test_mistakes_are_told(words, said, capsys):
    assert main(words) != 0
    assert said in capsys.readouterr().err
