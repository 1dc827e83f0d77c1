"""The film under the middle of the finger: where the surface is, and what the pressure does."""

from dataclasses import replace

import numpy as np
import pytest

from reporting.cross_section import cross_section
from squeezefilm.film.finger import GapShape
from squeezefilm.reynolds.modes.galerkin import pressure_at
from squeezefilm.reynolds.solver import solve


@pytest.fixture(scope="module")
def scene(scene):
    return replace(scene, hv_m=2e-6)


def test_the_pressure_rises_while_the_surface_is_up_and_on_the_whole(scene):
    film = cross_section(scene)
    rim = film[film["x_mm"].abs() > 5 - 1e-9]
    assert (rim["overpressure_kpa"] == 0).all()
    middle = film.loc[film["x_mm"].abs().idxmin() % 43 :: 43]
    up = middle[middle["surface_um"] > 1.9]
    assert (up["overpressure_kpa"] > 20).all()
    assert (middle.loc[middle["surface_um"] < -1.9, "overpressure_kpa"] < 0).all()
    mean = film.groupby("x_mm")["overpressure_kpa"].mean()
    assert (mean.iloc[1:-1] > 0).all()
    # Even about the middle, as the profile is.
    np.testing.assert_allclose(mean, mean[::-1], atol=1e-4)


def test_the_surface_swings_by_the_profiles_amplitude(scene):
    film = cross_section(scene)
    swing = film.groupby("x_mm")["surface_um"].agg(["min", "max"])
    x_m = 1e-3 * swing.index.to_numpy()
    expected = 2 * np.sinc(109.8 * x_m)
    np.testing.assert_allclose(swing["max"], expected, rtol=1e-9)
    np.testing.assert_allclose(swing["min"], -expected, rtol=1e-9)
    assert (film["finger_um"] == 5).all()


OTHERS = {
    "the paper's": {},
    "a long pad": {"length_x_m": 0.009, "length_y_m": 0.014},
    "an ellipse, turned": {"shape": "ellipse", "length_y_m": 0.008, "rotation_deg": 20},
    "a bulging pad": {"gap": GapShape(bulge_m=1e-6)},
    "a tilted pad": {"gap": GapShape(tilt_x_m=3e-6)},
    "a sliding pad": {"speed_x_m_per_s": 0.1},
    "off the centre": {"length_y_m": 0.008},
}


@pytest.mark.parametrize("pad", OTHERS)
def test_the_pressure_carries_the_force_that_is_simulated(scene, pad):
    """Its mean over pad and period is the solver's force, by another method where it has one."""
    scene = replace(scene, finger=replace(scene.finger, **OTHERS[pad]))
    if pad == "off the centre":
        scene = replace(scene, x_m=0.0026, y_m=0.0015)
    # The mean over the pad, by Gauss; an ellipse along radii.
    nodes, weights = np.polynomial.legendre.leggauss(24)
    x, y = (values.ravel() for values in np.meshgrid((1 + nodes) / 2, (1 + nodes) / 2))
    share = np.outer(weights, weights).ravel() / 4
    if scene.finger.shape == "ellipse":
        radius, angle = np.sqrt(x) / 2, 2 * np.pi * y
        x, y = 0.5 + radius * np.cos(angle), 0.5 + radius * np.sin(angle)
    pressure = pressure_at(scene, x=x, y=y, instants=24, tolerance=1e-4)
    force_n = scene.force_scale_n * float(share @ pressure.mean(axis=1))
    (solution,) = solve([scene], tolerance=1e-5, method="periodic")
    assert force_n == pytest.approx(solution.force_n, rel=2e-4)


def test_of_a_film_without_a_state_only_the_gap_is_known(scene):
    film = cross_section(replace(scene, finger=replace(scene.finger, speed_x_m_per_s=100.0)))
    assert film["overpressure_kpa"].isna().all()
    assert film["surface_um"].notna().all()
