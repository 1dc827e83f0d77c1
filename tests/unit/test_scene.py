"""A scene has the dimensionless numbers of the paper, and no physically empty scene passes."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from squeezefilm.errors import InputError
from squeezefilm.film.pad import GapShape, Pad
from squeezefilm.film.positions import cartesian_from_polar
from squeezefilm.film.profiles import Piston, Sinc
from squeezefilm.film.scene import Scenes
from squeezefilm.film.validity import check_scene
from squeezefilm.studies.study import scene_of_study, scenes_of_table


def test_dimensionless_numbers_of_the_paper(scene):
    assert scene.epsilon == pytest.approx(0.44)
    assert scene.sigma == pytest.approx(2331, abs=0.5)
    assert replace(scene, h0_m=10e-6).sigma == pytest.approx(583, abs=0.5)
    assert scene.knudsen == pytest.approx(0.0134)
    assert scene.modified_reynolds == pytest.approx(0.45, abs=0.005)
    assert replace(scene, h0_m=10e-6).modified_reynolds == pytest.approx(1.8, abs=0.02)
    assert scene.force_scale_n == pytest.approx(10.1325)
    assert scene.bearing_number == 0
    stroking = replace(scene, pad=replace(scene.pad, speed_x_m_per_s=0.1))
    assert stroking.bearing_number == pytest.approx(0.043, abs=0.0005)


def test_sinc_is_one_in_the_middle_and_zero_at_its_node():
    profile = Sinc(109.8)
    assert profile == Sinc(109.8)
    x_m = np.array([0.0, 1 / 109.8, 0.5 / 109.8])
    values = profile.amplitude(x_m=x_m, y_m=np.zeros(3))
    assert values == pytest.approx([1, 0, 2 / np.pi], abs=1e-15)
    assert profile.amplitude(x_m=np.zeros(3), y_m=x_m) == pytest.approx(values)
    assert (Piston().amplitude(x_m=x_m, y_m=x_m) == 1).all()


def test_the_profile_is_seen_from_where_the_pad_is(scene):
    moved = replace(scene, **cartesian_from_polar(2.9e-3, 30.0))
    middle = moved.amplitude(np.array([0.5]), np.array([0.5]))
    assert middle == pytest.approx(np.sinc(109.8 * 2.9e-3))
    # The middle of the actuator lies off the pad's middle by the pad's displacement.
    x = np.array([0.5 - moved.x_m / moved.pad.length_x_m])
    y = np.array([0.5 - moved.y_m / moved.pad.length_y_m])
    assert moved.amplitude(x, y) == pytest.approx(1)


def test_scenes_as_columns_have_the_numbers_of_each(scene):
    """Of two films in turn, one of them under a tilted pad."""
    tilted = replace(scene, pad=replace(scene.pad, gap=GapShape(tilt_x_m=1e-6)))
    each = [replace(film, h0_m=h0_m) for h0_m in (5e-6, 8e-6) for film in (scene, tilted)]
    scenes = Scenes.of(each)
    assert list(scenes) == each
    for name in ("epsilon", "sigma", "modified_reynolds", "force_scale_n"):
        alone = [getattr(one, name) for one in each]
        assert getattr(scenes, name) == pytest.approx(alone, rel=1e-15), name
    assert scenes.closure == pytest.approx([one.closure() for one in each], rel=1e-15)
    assert scenes.closure[1] > scenes.closure[0]
    alone = np.concatenate([Scenes.of([one]).static_gap_ratio_range for one in each], axis=1)
    assert np.array(scenes.static_gap_ratio_range) == pytest.approx(alone, rel=1e-15)


def test_some_of_many_scenes_have_their_own_films_alone(scene):
    """What depends on films alone is found for each of them."""
    each = [scene.with_gas(viscosity_pa_s=viscosity) for viscosity in (1e-5, 2e-5, 3e-5, 2e-5)]
    some = Scenes.of(each)[np.array([3, 1])]
    assert len(some.films) == 1
    assert list(some) == [each[3], each[1]]
    assert len(Scenes.of(each)[np.array([2, 0])].films) == 2
    assert list(Scenes.of(each)[np.array([2, 0])]) == [each[2], each[0]]


@pytest.mark.parametrize("polar", [True, False])
def test_a_table_becomes_the_scenes_of_its_rows(paper, polar):
    points = pd.DataFrame({"point_id": ["a", "b"], "h0_m": [5e-6, 9e-6], "hv_m": [2e-6, 1e-6]})
    places = {"phi_r_m": [0.0, 2e-3], "phi_deg": [0.0, 30.0]}
    if not polar:
        places = {"x_m": [0.0, 1e-3], "y_m": [0.0, -2e-3]}
    table = points.assign(**places)
    scenes = scenes_of_table(table, paper)
    x_m, y_m = (1e-3 * 3**0.5, 1e-3) if polar else (1e-3, -2e-3)
    assert scenes[0] == replace(scene_of_study(paper, 5e-6, 2e-6), point_id="a")
    expected = replace(scene_of_study(paper, 9e-6, 1e-6, x_m=x_m, y_m=y_m), point_id="b")
    assert (scenes[1].x_m, scenes[1].y_m) == pytest.approx((x_m, y_m), abs=1e-18)
    assert replace(scenes[1], x_m=x_m, y_m=y_m) == expected
    with pytest.raises(InputError, match="point b: hv = 1 µm reaches h0 = 1 µm"):
        scenes_of_table(table.assign(h0_m=[5e-6, 1e-6]), paper)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"hv_m": 5e-6}, "surface and pad touch"),
        (
            cartesian_from_polar(2.94e-3, 45.0),
            "off the actuator's disc of radius 10 mm; in this direction its centre may lie at most "
            "2.92 mm out",
        ),
        ({"pad": Pad(20e-3, 10e-3)}, "pad: it reaches 11.18 mm from its centre"),
    ],
)
def test_a_scene_without_a_film_is_refused(scene, changes, message):
    with pytest.raises(InputError, match=r"^point 1: |^pad: ") as refusal:
        check_scene(replace(scene, **changes))
    assert message in str(refusal.value)
