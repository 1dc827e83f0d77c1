"""The film under the middle of the pad: where the surface is, and what the pressure does."""

from dataclasses import replace

import numpy as np
import pytest

from squeezefilm.api.film import Film
from squeezefilm.reynolds.device import choose_device
from squeezefilm_workflow.reporting.cross_section import cross_section

DEVICE = choose_device()


@pytest.fixture(scope="module")
def scene(scene):
    return replace(scene, hv_m=2e-6)


def test_the_pressure_rises_while_the_surface_is_up_and_on_the_whole(scene):
    film = cross_section(scene, device=DEVICE)
    rim = film[film["x_mm"].abs() > 5 - 1e-9]
    assert (rim["gauge_pressure_kpa"] == 0).all()
    middle = film.loc[film["x_mm"].abs().idxmin() % 43 :: 43]
    up = middle[middle["surface_um"] > 1.9]
    assert (up["gauge_pressure_kpa"] > 20).all()
    assert (middle.loc[middle["surface_um"] < -1.9, "gauge_pressure_kpa"] < 0).all()
    mean = film.groupby("x_mm")["gauge_pressure_kpa"].mean()
    assert (mean.iloc[1:-1] > 0).all()
    # Even about the middle, as the profile is.
    np.testing.assert_allclose(mean, mean[::-1], atol=1e-4)


def test_there_is_a_pressure_of_a_film_whose_inertia_leaves_no_smooth_field(repository):
    """At the corners flow with inertia converges slowly, to more than a picture shows."""
    film = Film.read(repository / "config" / "levitation.yaml")
    scene = film.scene(h0=25e-6, hv=9e-6).with_gas(inertia="included", thermal="included")
    assert cross_section(scene, device=DEVICE)["gauge_pressure_kpa"].notna().all()
