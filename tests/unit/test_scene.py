"""A scene has the dimensionless numbers of the paper, and no physically empty scene passes."""

from dataclasses import replace
from math import nan

import numpy as np
import pytest

from squeezefilm.film.profiles import Piston, Sinc, make_profile
from squeezefilm.film.surfaces import Disc
from squeezefilm.film.validity import check_scene
from squeezefilm.io.errors import InputError
from squeezefilm.io.positions import cartesian


def test_dimensionless_numbers_of_the_paper(scene):
    assert scene.epsilon == pytest.approx(0.44)
    assert scene.sigma == pytest.approx(2331, abs=0.5)
    assert replace(scene, h0_m=10e-6).sigma == pytest.approx(583, abs=0.5)
    assert scene.knudsen == pytest.approx(0.0134)
    assert scene.modified_reynolds == pytest.approx(0.45, abs=0.005)
    assert replace(scene, h0_m=10e-6).modified_reynolds == pytest.approx(1.8, abs=0.02)
    assert scene.force_scale_n == pytest.approx(10.1325)
    assert scene.bearing_number == 0
    stroking = replace(scene, finger=replace(scene.finger, speed_x_m_per_s=0.1))
    assert stroking.bearing_number == pytest.approx(0.043, abs=0.0005)


def test_sinc_is_one_in_the_middle_and_zero_at_its_node():
    profile = make_profile(kind="sinc", surface=Disc(0.01), wave_number_per_m=109.8)
    assert profile == Sinc(109.8)
    x_m = np.array([0.0, 1 / 109.8, 0.5 / 109.8])
    values = profile.amplitude(x_m=x_m, y_m=np.zeros(3))
    assert values == pytest.approx([1, 0, 2 / np.pi], abs=1e-15)
    assert profile.amplitude(x_m=np.zeros(3), y_m=x_m) == pytest.approx(values)
    assert (Piston().amplitude(x_m=x_m, y_m=x_m) == 1).all()


def test_the_profile_is_seen_from_where_the_finger_is(scene):
    moved = replace(scene, **cartesian(2.9e-3, 30.0))
    middle = moved.amplitude(np.array([0.5]), np.array([0.5]))
    assert middle == pytest.approx(np.sinc(109.8 * 2.9e-3))
    # The middle of the actuator lies off the finger's middle by the finger's displacement.
    x = np.array([0.5 - moved.x_m / moved.finger.length_x_m])
    y = np.array([0.5 - moved.y_m / moved.finger.length_y_m])
    assert moved.amplitude(x, y) == pytest.approx(1)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"hv_m": 5e-6}, "surface and finger touch"),
        ({"hv_m": -1e-6}, "hv_m = -1e-06 must not be negative"),
        ({"h0_m": 0.0}, "h0_m = 0 must"),
        ({"h0_m": 1.0}, "h0_m = 1 must"),
        ({"h0_m": nan}, "h0_m is not a finite number"),
        (cartesian(2.94e-3, 45.0), "off the actuator's 10.00 mm disc"),
    ],
)
def test_a_scene_without_a_film_is_refused(scene, changes, message):
    with pytest.raises(InputError, match="point 1: ") as refusal:
        check_scene(replace(scene, **changes))
    assert message in str(refusal.value)


@pytest.mark.parametrize(
    "changes",
    [{"hv_m": 0.0}, {"hv_m": 4.999e-6}, cartesian(2.92e-3, 45.0), cartesian(3.6e-3, 0.0)],
)
def test_a_scene_at_the_limit_passes(scene, changes):
    check_scene(replace(scene, **changes))
