"""An outline from a file: what is read, and what is refused with which words."""

import numpy as np
import pytest
from example_outline import OVAL, STUDY, TURN, write_outline

import squeezefilm as sf
from squeezefilm.config.loading import parse_config
from squeezefilm.config.writing import effective_yaml
from squeezefilm.errors import InputError
from squeezefilm.film.outline import read_contour
from squeezefilm.studies.study import check_study

SIDES_M = 0.01, 0.008


@pytest.mark.parametrize(
    ("z_mm", "header", "unit"),
    [
        (OVAL, "x_mm,y_mm", 1.0),
        (OVAL[::-1] + 3 - 1j, "x [um],y [um]", 1000.0),
        (np.append(OVAL, OVAL[0]), "x_m,y_m", 1e-3),
    ],
)
def test_points_make_one_curve_in_any_unit_direction_and_place(z_mm, header, unit, tmp_path):
    contour = read_contour(write_outline(tmp_path, z_mm, header, unit), sides_m=SIDES_M)
    assert contour.area == pytest.approx(np.pi / 4 * 0.8, rel=2e-5)
    assert np.abs(contour.points.real).max() == pytest.approx(0.5, abs=2e-5)
    assert np.abs(contour.points.imag).max() == pytest.approx(0.4, abs=2e-5)
    places = np.array([0.45 + 0.1j, 0.52, 0.39j, 0.3 - 0.38j])
    assert contour.contains_positions(places).tolist() == [True, False, True, False]


SPIKE = OVAL * np.where(np.arange(60) == 7, 1.2, 1.0)
HOOK = np.exp(1j * np.linspace(0, 5.2, 40))
HOOK = np.concatenate([5 * HOOK, 3.5 * HOOK[::-1]])
NOTCH = (1 - 0.85 * np.exp(-((TURN - np.pi) ** 2) / 0.1)) * OVAL


@pytest.mark.parametrize(
    ("z_mm", "scatter_m", "words"),
    [
        (OVAL[:10], 1e-3, "10 points; an outline has 16 to 4000"),
        (SPIKE, 1e-5, "off the smooth curve of 20 waves"),
        (HOOK, 1e-3, "the outline is not star-shaped"),
        (NOTCH, 1e-3, "a notch, a neck or a corner is too sharp"),
    ],
)
def test_what_is_no_outline_is_refused(z_mm, scatter_m, words, tmp_path):
    path = write_outline(tmp_path, z_mm)
    sides_m = 1e-3 * np.ptp(z_mm.real), 1e-3 * np.ptp(z_mm.imag)
    with pytest.raises(InputError, match=rf"patch\.csv: .*{words}"):
        read_contour(path, sides_m=sides_m, scatter_m=scatter_m)


def test_a_study_s_outline_counts_from_its_own_folder(tmp_path):
    write_outline(tmp_path, OVAL)
    config = check_study(parse_config(STUDY, path=tmp_path / "study.yaml"))
    assert config.read_pad().area_m2 == pytest.approx(np.pi * 20e-6, rel=2e-5)
    elsewhere = tmp_path / "results" / "mine"
    again = parse_config(effective_yaml(config, folder=elsewhere), path=elsewhere / "study.yaml")
    assert again.pad.outline.file == "../../patch.csv"


def test_a_film_with_an_outline_off_its_plate_is_refused(tmp_path):
    path = write_outline(tmp_path, OVAL)
    film = sf.Film.of(
        actuator={"frequency": 2e4, "surface_radius": 6e-3, "profile": {"kind": "piston"}},
        pad={"shape": "curve", "length_x": "10 mm", "length_y": "8 mm"}
        | {"outline": {"file": str(path)}},
        gas={"inertia": "none", "thermal": "none"},
    )
    force = film.force("20 um", "5 um")
    assert float(force) > 0
    assert "µm off it: what that leaves open of the force is not in its error" in str(force)
    with pytest.raises(InputError, match="the edge of the pad lies"):
        film.force("20 um", "5 um", phi_r="1.5 mm", phi="0 deg")
