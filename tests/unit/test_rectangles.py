"""A rectangular surface: its modes, its symmetry, and what a study on one is refused for."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from example_scan import EXAMPLES, PLATE, scan_text

from squeezefilm.config.loading import Config, load_config, parse_config
from squeezefilm.errors import InputError
from squeezefilm.film.measured.smooth import smoothed_scan
from squeezefilm.film.profiles import StandingWave, largest_magnitude
from squeezefilm.film.surfaces import Disc, Rectangle
from squeezefilm.film.symmetry import Mirrors, symmetry_from_dict
from squeezefilm.film.validity import check_scene, validity
from squeezefilm.models.data import Factors
from squeezefilm.quantities.model_error import resolve_auto_terms
from squeezefilm.reynolds import solve
from squeezefilm.studies.plans import box_of, centred_grid, finger_positions, random_plan
from squeezefilm.studies.space import Space
from squeezefilm.studies.study import check_study, scene_of, symmetry_of
from squeezefilm.tables import read_scenes, write_table

WAVE = {"kind": "formula", "expression": "cos(2*pi*x/0.024)*(1 - 0.2*(y/0.01)**2)"}
PAD = {"shape": "rectangle", "length_x_m": 0.010, "length_y_m": 0.008}


@pytest.fixture(scope="module")
def plate(repository: Path) -> Config:
    return load_config(repository / "config" / "plate.yaml")


def study(config: Config, **changes: dict[str, Any]) -> Config:
    """The plate under a rectangular pad, its wave known by formula, with other keys in sections."""
    first = {"finger": PAD, "actuator": {"profile": WAVE}}
    sections = dict(config.sections)
    for name, keys in (*first.items(), *changes.items()):
        sections[name] = sections[name] | keys
    return Config(path=config.path, sections=sections)


def test_modes_span_the_polynomials_of_their_degree():
    orders = Rectangle(2.0, 2.0).orders_up_to(4)
    x, y = np.random.default_rng(1).uniform(-1, 1, (2, 60))
    modes = Rectangle(2.0, 2.0).modes_at(orders, x=x, y=y)
    powers = np.stack([x**i * y**j for i in range(5) for j in range(5 - i)], axis=1)
    assert modes.shape == powers.shape == (60, 15)
    left, *_ = np.linalg.lstsq(modes, powers, rcond=None)
    np.testing.assert_allclose(modes @ left, powers, atol=1e-12)
    single = Rectangle(2.0, 2.0).modes_at(orders, x=np.array(x[0]), y=np.array(y[0]))
    np.testing.assert_array_equal(single, modes[0])


def test_the_largest_amplitude_is_sought_on_all_of_the_rectangle():
    assert largest_magnitude(lambda x, y: 3 * x + y, surface=Rectangle(0.04, 0.02)) == (
        pytest.approx(0.07)
    )
    wave = StandingWave(0.2, 90.0, 0.0, surface=Rectangle(0.01, 0.02))
    crest = replace(wave, crest_m=0.05)  # the middle is a node, the side has most
    assert wave.crest_share == 1.0
    top = crest.amplitude(x_m=np.array(0.0), y_m=np.array(0.01))
    assert abs(float(top)) == pytest.approx(1.0)


def test_a_scan_is_smoothed_within_its_error(tmp_path):
    path = tmp_path / "scan.csv"
    path.write_text(scan_text(noise=0.02, missing=0.03, seed=5, surface="plate"), encoding="utf-8")
    smoothed = smoothed_scan(path, surface=PLATE, axisymmetric=False)
    even = np.outer(np.arange(500) + 0.5, 1.32471795724474602596 ** np.array([-1.0, -2.0])) % 1
    x_m, y_m = ((2 * even - 1) * PLATE.half_m).T  # all over it, but its very corners
    exact = EXAMPLES["plate"][1].amplitude(x_m=x_m, y_m=y_m)
    found = smoothed.profile.amplitude(x_m=x_m, y_m=y_m)
    found *= np.sign(found @ exact)  # half a period apart
    error = smoothed.standard_error(x_m=x_m, y_m=y_m)
    assert np.mean(np.abs(found - exact) <= 2 * error + 0.002) > 0.9
    assert error.max() < 0.03


def test_a_point_off_the_rectangle_is_named(tmp_path):
    path = tmp_path / "scan.csv"
    text = scan_text(noise=0.0, missing=0.0, seed=1, surface="plate") + "16.00,3.00,1.0,0\n"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match=r"x = 16\.00 mm, y = 3\.00 mm, off .* 30\.00 × 20\.00 mm"):
        smoothed_scan(path, surface=PLATE, axisymmetric=False)


@pytest.mark.parametrize(("x_m", "y_m"), [(0.0101, 0.0), (0.0, -0.0061)])
def test_the_finger_must_lie_on_the_plate(plate, x_m, y_m):
    config = study(plate)
    scene_of(config, 5e-6, 2e-6, x_m=0.010, y_m=-0.006)
    with pytest.raises(
        InputError, match=r"a corner of the finger lies at x = .*, off the actuator"
    ):
        scene_of(config, 5e-6, 2e-6, x_m=x_m, y_m=y_m)


def test_positions_are_on_both_sides_unless_mirrors_make_them_the_same(plate):
    config = study(plate)
    positions = {"x_m": [0.005, 0.0095], "y_m": [0, 0.005]}
    config = Config(path=config.path, sections=config.sections | {"positions": positions})
    assert symmetry_of(config) == Mirrors(x=True, y=True)
    mirrored = finger_positions(config)
    assert mirrored[:4] == [(0.0, 0.0), (0.0, 0.005), (0.005, 0.0), (0.005, 0.005)]
    assert len(mirrored) == 3 * 2  # those on the mirrors are among them
    assert box_of(config).ranges["x_m"] == (0.0, 0.0095)
    sliding = study(config, finger={"speed_x_m_per_s": 0.1})
    assert symmetry_of(sliding) == Mirrors(x=False, y=True)
    assert box_of(sliding).ranges["x_m"] == (-0.0095, 0.0095)
    assert len(finger_positions(sliding)) == 1 + 4 * 2
    assert symmetry_of(plate) == Mirrors(x=False, y=False)  # a scan, with its noise


def test_mirrored_positions_have_the_same_force(plate):
    config = study(plate)
    places = [(0.004, 0.003), (-0.004, 0.003), (0.004, -0.003), (-0.004, -0.003)]
    scenes = [scene_of(config, 5e-6, 2e-6, x_m=x, y_m=y) for x, y in places]
    forces = [each.force_n for each in solve(resolve_auto_terms(scenes), tolerance=1e-6)]
    assert forces == pytest.approx([forces[0]] * 4, rel=3e-6)
    found = Mirrors(x=True, y=False)
    folded = found.represent(x_m=np.array([-1.0, 2.0]), y_m=np.array([-3.0, 4.0]))
    assert folded["x_m"].tolist() == [1.0, 2.0]
    assert folded["y_m"].tolist() == [-3.0, 4.0]
    assert symmetry_from_dict(found.to_dict(), place="fit") == found


def test_tables_keep_the_form_of_the_positions(plate, tmp_path):
    table = random_plan(points=4, seed=1, **box_of(study(plate)).ranges)
    assert list(table.columns)[3:] == ["x_m", "y_m"]
    write_table(table, tmp_path / "scenes.csv")
    assert read_scenes(tmp_path / "scenes.csv").equals(table)
    centred = centred_grid(
        h0_m=np.array([5e-6]), hv_m=np.array([1e-6]), position=Rectangle.position
    )
    assert list(centred.columns) == ["point_id", "h0_m", "hv_m", "x_m", "y_m"]


def test_all_of_the_box_lies_on_the_plate(plate):
    space = Space.of(study(plate), centred=False)
    points = space.grid(400, distinct=True)
    assert len(points) == 4**4
    assert len(np.unique(np.round(space.coordinates(points), 12), axis=0)) == len(points)
    check_scene(space.film.scene(*space.box.upper))


def test_a_position_is_kept_in_the_form_it_was_given():
    polar = Factors.of(h0_m=5e-6, hv_m=1e-6, phi_r_m=0.002, phi_deg=30)
    cartesian = Factors.of(h0_m=5e-6, hv_m=1e-6, x_m=polar.x_m, y_m=polar.y_m)
    assert (polar.position, cartesian.position) == (Disc.position, Rectangle.position)
    assert cartesian.phi_r_m == pytest.approx(polar.phi_r_m)
    assert cartesian.phi_deg == pytest.approx(polar.phi_deg)


REFUSED = {
    "polar positions": (
        ("x: [9.5 mm], y: [5 mm]", "phi_r: [2 mm], phi: [0 deg]"),
        "positions: on a rectangle they are x and y",
    ),
    "an axis": (("plate.csv}", "plate.csv, axisymmetric: true}"), "a rectangle has no axis"),
    "positions off the plate": (("9.5 mm]", "10.5 mm]"), "the rim of the finger lies at x ="),
}


@pytest.mark.parametrize(("change", "message"), REFUSED.values(), ids=REFUSED)
def test_a_study_that_makes_no_sense_is_refused(repository, change, message):
    path = repository / "config" / "plate.yaml"
    text = path.read_text(encoding="utf-8")
    assert change[0] in text
    with pytest.raises(InputError) as refusal:
        check_study(parse_config(text.replace(*change), path=path))
    assert message in str(refusal.value)


@pytest.mark.parametrize("name", ["plate", "levitation"])
def test_an_example_is_a_sound_study_and_not_the_paper_s(repository, name):
    path = repository / "config" / f"{name}.yaml"
    assert not check_study(load_config(path))["paper"]
    assert len(path.read_text(encoding="utf-8").splitlines()) <= 25
    assert yaml.safe_load(path.read_text(encoding="utf-8"))["study"] == name


def test_the_committed_scan_is_the_example(repository):
    text = scan_text(noise=0.02, missing=0.03, seed=1, surface="plate")
    assert (repository / "config" / "plate.csv").read_text(encoding="utf-8") == text


def test_the_part_floats_beyond_a_reynolds_number_of_ten_and_validity_says_so(repository):
    config = load_config(repository / "config" / "levitation.yaml")
    scene = scene_of(config, 35e-6, 8e-6, x_m=0.004)
    assert scene.modified_reynolds > 10
    with_heat = replace(scene, gas=replace(scene.gas, inertia="included", heat="included"))
    assert "Re = 10.2 is above 10 (heat included): error unknown" in validity(with_heat)
