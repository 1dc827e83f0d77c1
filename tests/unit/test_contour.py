"""An outline from a file: what is read, and what is refused with which words."""

from pathlib import Path

import numpy as np
import pytest
import yaml

import squeezefilm as sf
from squeezefilm.config.loading import parse_config
from squeezefilm.config.written import effective_text
from squeezefilm.errors import InputError
from squeezefilm.film.finger import Finger
from squeezefilm.film.outline import read_contour
from squeezefilm.studies.study import check_study, finger_of

SIDES_M = 0.01, 0.008
TURN = 2 * np.pi * np.arange(60) / 60
OVAL = 5 * np.cos(TURN) + 4j * np.sin(TURN)


def written(folder: Path, z_mm: np.ndarray, header: str = "x_mm,y_mm", unit: float = 1.0) -> Path:
    path = folder / "patch.csv"
    rows = "".join(f"{z.real:.9g},{z.imag:.9g}\n" for z in z_mm * unit)
    path.write_text(f"{header}\n{rows}", encoding="utf-8")
    return path


def refusal(path: Path, **settings: float) -> str:
    with pytest.raises(InputError) as refused:
        read_contour(path, sides_m=SIDES_M, **settings)
    assert str(refused.value).startswith(f"{path}: ")
    return str(refused.value)


@pytest.mark.parametrize(
    ("z_mm", "header", "unit"),
    [
        (OVAL, "x_mm,y_mm", 1.0),
        (OVAL[::-1] + 3 - 1j, "x [um],y [um]", 1000.0),
        (np.append(OVAL, OVAL[0]), "x_m,y_m", 1e-3),
        (np.roll(OVAL, 20), "x_mm,y_mm", 1.0),
    ],
)
def test_points_make_one_curve_in_any_unit_direction_and_place(z_mm, header, unit, tmp_path):
    contour = read_contour(written(tmp_path, z_mm, header, unit), sides_m=SIDES_M)
    assert contour.area == pytest.approx(np.pi / 4 * 0.8, rel=2e-5)
    assert np.abs(contour.points.real).max() == pytest.approx(0.5, abs=2e-5)
    assert np.abs(contour.points.imag).max() == pytest.approx(0.4, abs=2e-5)
    finger_share = Finger(0.01, 0.008, 0.0, shape="curve", contour=contour).rectangle_within
    assert finger_share == pytest.approx(np.sqrt(0.5), rel=2e-3)
    places = np.array([0.45 + 0.1j, 0.52, 0.39j, 0.3 - 0.38j])
    assert contour.within(places).tolist() == [True, False, True, False]


SPIKE = OVAL * np.where(np.arange(60) == 7, 1.2, 1.0)
HOOK = np.exp(1j * np.linspace(0, 5.2, 40))
HOOK = np.concatenate([5 * HOOK, 3.5 * HOOK[::-1]])
LOOP = (3 + 5 * np.cos(TURN)) * np.exp(1j * TURN)
NOTCH = (1 - 0.85 * np.exp(-((TURN - np.pi) ** 2) / 0.1)) * OVAL


@pytest.mark.parametrize(
    ("z_mm", "words"),
    [
        (OVAL[:10], "10 points; an outline has 16 to 4000"),
        (OVAL[:45], "is not closed: its last point is 6.81"),
        (np.insert(OVAL, 20, OVAL[20]), "line 23: the point before stands again"),
        (SPIKE, "off the smooth curve of 20 waves"),
        (
            OVAL * 1.01,
            "is 10.0999 mm × 8.08004 mm, and the study says 10 mm × 8 mm: write",
        ),
        (HOOK, "the outline is not star-shaped"),
        (LOOP, "the outline is not star-shaped"),
        (NOTCH, "a notch, a neck or a corner is too sharp"),
    ],
)
def test_what_is_no_outline_is_refused(z_mm, words, tmp_path):
    settings = {"scatter_m": 1e-3} if words.startswith(("the outline is not", "a notch")) else {}
    path = written(tmp_path, z_mm)
    if settings:
        sides_m = 1e-3 * np.ptp(z_mm.real), 1e-3 * np.ptp(z_mm.imag)
        with pytest.raises(InputError) as refused:
            read_contour(path, sides_m=sides_m, **settings)
        assert words in str(refused.value)
    else:
        assert words in refusal(path)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "the outline is empty"),
        ("x,y\n1,2\n", "line 1: there is no column x or y with its unit"),
        ("x_mm,y_mm\n1,2\n1\n", "line 3: 1 cells where the header has 2"),
        ("x_mm,y_mm\n1,two\n", "line 2: y is 'two', not a finite number"),
    ],
)
def test_what_is_no_table_of_points_is_refused(text, words, tmp_path):
    path = tmp_path / "patch.csv"
    path.write_text(text, encoding="utf-8")
    assert words in refusal(path)


STUDY = """
study: mine
actuator: {frequency: 20 kHz, surface_radius: 30 mm, profile: {kind: piston}}
finger: {shape: curve, length_x: 10 mm, length_y: 8 mm, outline: {file: patch.csv}}
screen:
  h0: {start: 20 µm, stop: 35 um}
  hv: {start: 2 µm, stop: 18.5 µm, levels: 5}
extrapolation: {force: 500 mN}
"""


def study(folder: Path, **finger: object):
    values = yaml.safe_load(STUDY)
    values["finger"] |= finger
    text = yaml.safe_dump({name: value for name, value in values.items()}, allow_unicode=True)
    return parse_config(text, path=folder / "study.yaml")


def test_a_study_s_outline_counts_from_its_own_folder(tmp_path):
    written(tmp_path, OVAL)
    config = check_study(study(tmp_path))
    assert finger_of(config).area_m2 == pytest.approx(np.pi * 20e-6, rel=2e-5)
    elsewhere = tmp_path / "results" / "mine"
    again = parse_config(effective_text(config, folder=elsewhere), path=elsewhere / "study.yaml")
    assert again["finger"]["outline"]["file"] == "../../patch.csv"


def test_a_study_without_or_with_too_many_outlines_is_refused(tmp_path):
    with pytest.raises(InputError, match=r"finger.outline: it is there, and finger.shape is ell"):
        study(tmp_path, shape="ellipse")
    with pytest.raises(InputError, match=r"study.yaml: line 1[0-9]: finger.outline: it is missing"):
        study(tmp_path, outline=None)


def test_a_film_with_an_outline_off_its_plate_is_refused(tmp_path):
    path = written(tmp_path, OVAL)
    film = sf.Film.of(
        actuator={
            "frequency": 20e3,
            "surface_radius": 6e-3,
            "profile": {"kind": "piston"},
        },
        finger={"shape": "curve", "length_x": "10 mm", "length_y": "8 mm"}
        | {"outline": {"file": str(path)}},
        gas={"inertia": "none", "heat": "none"},
    )
    force = film.force("20 um", "5 um")
    assert float(force) > 0
    assert "µm off it: what that leaves open of the force is not in its error" in str(force)
    with pytest.raises(InputError, match="the rim of the finger lies"):
        film.force("20 um", "5 um", phi_r="1.5 mm", phi="0 deg")
