"""The film under the middle of the finger: where the surface is, and what the pressure does."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from squeezefilm.numerics.cross_section import COLUMNS, cross_section
from squeezefilm.scene import GapShape, Scene
from squeezefilm.studies.config import load_config
from squeezefilm.studies.study import scene_of
from squeezefilm.tables import ScenePoint


@pytest.fixture(scope="module")
def scene(repository: Path) -> Scene:
    point = ScenePoint("one", 5e-6, 2e-6, 0.0, 0.0)
    return scene_of(point, load_config(repository / "config/paper.yaml"))


def test_the_pressure_rises_while_the_surface_is_up_and_on_the_whole(scene: Scene) -> None:
    film = cross_section(scene)
    assert list(film.columns) == list(COLUMNS)
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


def test_the_surface_swings_by_the_profiles_amplitude(scene: Scene) -> None:
    film = cross_section(scene)
    swing = film.groupby("x_mm")["surface_um"].agg(["min", "max"])
    x_m = 1e-3 * swing.index.to_numpy()
    expected = 2 * np.sinc(109.8 * x_m)
    np.testing.assert_allclose(swing["max"], expected, rtol=1e-9)
    np.testing.assert_allclose(swing["min"], -expected, rtol=1e-9)
    assert (film["finger_um"] == 5).all()


def test_of_another_film_only_the_gap_is_known(scene: Scene) -> None:
    pad = replace(scene.finger, gap=GapShape(bulge_m=1e-6))
    film = cross_section(replace(scene, finger=pad))
    assert film["overpressure_kpa"].isna().all()
    assert film["finger_um"].max() == pytest.approx(6)
    assert film["finger_um"].min() == pytest.approx(5, abs=0.01)
