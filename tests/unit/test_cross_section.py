"""The film under the middle of the pad: where the surface is, and what the pressure does."""

from dataclasses import replace

import numpy as np
import pytest

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
