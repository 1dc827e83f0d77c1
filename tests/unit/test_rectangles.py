"""A rectangular surface: its modes, its symmetry, and what a study on one is refused for."""

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from changed_sections import changed
from example_scan import EXAMPLES, PLATE, scan_text

from squeezefilm.config.loading import load_config, with_changed_keys
from squeezefilm.config.study import Study
from squeezefilm.errors import InputError
from squeezefilm.film.measured.scan import Scan
from squeezefilm.film.measured.smooth import SmoothedScan, smooth_scan, smoothed_scan_of_file
from squeezefilm.film.profiles import ScanFile
from squeezefilm.film.surfaces import Rectangle
from squeezefilm.film.symmetry import MirrorAxes, symmetry_from_dict
from squeezefilm.quantities.model_error import resolve_auto_terms
from squeezefilm.reynolds import solve
from squeezefilm.studies.space import pad_positions, space_of_study
from squeezefilm.studies.study import check_study, scene_of_study, scenes_of_table

WAVE = {"kind": "formula", "expression": "cos(2*pi*x/0.024)*(1 - 0.2*(y/0.01)**2)"}
FREE_SHAPE = ScanFile("scan.csv")
PAD = {"shape": "rectangle", "length_x_m": 0.010, "length_y_m": 0.008}


@pytest.fixture(scope="module")
def plate(repository: Path) -> Study:
    return load_config(repository / "config" / "plate.yaml")


def study(config: Study, **changes: dict[str, Any]) -> Study:
    """The plate under a rectangular pad, its wave known by formula, with other keys in sections."""
    return changed(changed(config, pad=PAD, actuator={"profile": WAVE}), **changes)


def raster(columns: int, rows: int) -> tuple[np.ndarray, np.ndarray]:
    """Points all over a plate of 60 × 40 mm, its edges included."""
    lines = np.linspace(-0.03, 0.03, columns), np.linspace(-0.02, 0.02, rows)
    x_m, y_m = (values.ravel() for values in np.meshgrid(*lines))
    return x_m, y_m


SHAPES = {
    "wave along x": lambda x_m, y_m: np.cos(2 * np.pi * x_m / 0.012 + 0.3),
    "oblique wave": lambda x_m, y_m: np.cos(2 * np.pi * (0.866 * x_m + 0.5 * y_m) / 0.012),
    "bowl": lambda x_m, y_m: 1 - 0.3 * (x_m / 0.03) ** 2 - 0.4 * (y_m / 0.02) ** 2,
}


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize(("columns", "rows"), [(41, 17), (41, 21), (25, 17)])
def test_an_ordinary_scan_gives_the_profile_within_its_error(shape, columns, rows):
    """Five waves of 12 mm on 60 × 40 mm, points 1.5 × 2.5 mm apart: corners were ±400 %."""
    surface, exact = Rectangle(0.06, 0.04), SHAPES[shape]
    x_m, y_m = raster(columns, rows)
    noise = np.random.default_rng(1).normal(scale=0.015, size=len(x_m))
    amplitude_m = 1e-6 * (exact(x_m, y_m) + noise + 0j)
    lines = np.arange(len(x_m)) + 2
    scan = Scan(Path("scan.csv"), x_m, y_m, amplitude_m, lines, 0, has_phase_or_sign=True)
    smooth = smooth_scan(scan, FREE_SHAPE, surface)
    x_m, y_m, _ = surface.net_points_and_weights()
    found_m = smooth.peak_m * smooth.profile.amplitude(x_m=x_m, y_m=y_m)
    off_m = np.abs(np.abs(found_m) - np.abs(1e-6 * exact(x_m, y_m)))
    error_m = smooth.peak_m * smooth.standard_error(x_m=x_m, y_m=y_m)
    assert error_m.max() < 0.03e-6
    assert np.mean(off_m > 2 * error_m) < 0.1
    assert np.all(off_m < 5 * error_m)


def test_a_scan_that_is_too_coarse_names_the_spacing_that_would_do():
    """Points 7.5 × 10 mm apart on waves of 12 mm."""
    surface = Rectangle(0.06, 0.04)

    def smooth(columns: int, rows: int) -> SmoothedScan:
        x_m, y_m = raster(columns, rows)
        noise = np.random.default_rng(5).normal(scale=0.02, size=len(x_m))
        amplitude_m = 1e-6 * (np.cos(2 * np.pi * x_m / 0.012) + noise + 0j)
        lines = np.arange(len(x_m)) + 2
        scan = Scan(Path("scan.csv"), x_m, y_m, amplitude_m, lines, 0, has_phase_or_sign=True)
        return smooth_scan(scan, FREE_SHAPE, surface)

    with pytest.raises(InputError, match=r"modes of degree \d+; .*actuator\.surface") as refusal:
        smooth(9, 5)
    (spacing_mm,) = re.findall(r"points up to there, every ([\d.]+) mm", str(refusal.value))
    smooth(int(60 / float(spacing_mm)) + 2, int(40 / float(spacing_mm)) + 2)


def test_a_scan_is_smoothed_within_its_error(tmp_path):
    path = tmp_path / "scan.csv"
    path.write_text(scan_text(noise=0.02, missing=0.03, seed=5, surface="plate"), encoding="utf-8")
    smoothed = smoothed_scan_of_file(path, FREE_SHAPE, PLATE, frequency_hz=20e3)
    even = np.outer(np.arange(500) + 0.5, 1.32471795724474602596 ** np.array([-1.0, -2.0])) % 1
    x_m, y_m = ((2 * even - 1) * PLATE.half_extents_m).T  # all over it, but its very corners
    exact = EXAMPLES["plate"][1].amplitude(x_m=x_m, y_m=y_m)
    found = smoothed.profile.amplitude(x_m=x_m, y_m=y_m)
    found *= np.sign(found @ exact)  # half a period apart
    error = smoothed.standard_error(x_m=x_m, y_m=y_m)
    assert np.mean(np.abs(found - exact) <= 2 * error + 0.002) > 0.9
    assert error.max() < 0.03


@pytest.mark.parametrize(("x_m", "y_m"), [(0.0101, 0.0), (0.0, -0.0061)])
def test_the_pad_must_lie_on_the_plate(plate, x_m, y_m):
    config = study(plate)
    scene_of_study(config, 5e-6, 2e-6, x_m=0.010, y_m=-0.006)
    off = r"a corner of the pad lies at x = .*, off the actuator's .*x = ±10 mm, y = ±6 mm$"
    with pytest.raises(InputError, match=off):
        scene_of_study(config, 5e-6, 2e-6, x_m=x_m, y_m=y_m)


@pytest.mark.parametrize("rotation_deg", [0, 90])
def test_a_pad_larger_than_the_plate_is_a_problem_of_the_pad(plate, rotation_deg):
    sides = {"length_x_m": 0.031, "length_y_m": 0.005}
    if rotation_deg:
        sides = {"length_x_m": 0.005, "length_y_m": 0.031}
    config = study(plate, pad={**sides, "rotation_deg": rotation_deg})
    said = r"pad: it is 31 × 5 mm along x and y .* 30 × 20 mm rectangle \(actuator\.surface\)"
    with pytest.raises(InputError, match=rf"plate\.yaml: {said}"):
        check_study(config)
    with pytest.raises(InputError, match=rf"^{said}[^\n]*$"):
        scenes_of_table({"h0_m": [5e-6, 6e-6], "hv_m": [1e-6, 1e-6]}, config)


def test_positions_are_on_both_sides_unless_mirrors_make_them_the_same(plate):
    config = with_changed_keys(study(plate), {"positions": {"x": [0.005, 0.0095], "y": [0, 0.005]}})
    assert config.symmetry() == MirrorAxes(x=True, y=True)
    mirrored = pad_positions(config)
    assert mirrored[:4] == [(0.0, 0.0), (0.0, 0.005), (0.005, 0.0), (0.005, 0.005)]
    assert len(mirrored) == 3 * 2  # those on the mirrors are among them
    assert space_of_study(config).limits["x_m"] == (0.0, 0.0095)
    sliding = study(config, pad={"speed_x_m_per_s": 0.1})
    assert sliding.symmetry() == MirrorAxes(x=False, y=True)
    assert space_of_study(sliding).limits["x_m"] == (-0.0095, 0.0095)
    assert len(pad_positions(sliding)) == 1 + 4 * 2
    assert plate.symmetry() == MirrorAxes(x=False, y=False)  # a scan, with its noise


def test_mirrored_positions_have_the_same_force(plate):
    config = study(plate)
    places = [(0.004, 0.003), (-0.004, 0.003), (0.004, -0.003), (-0.004, -0.003)]
    scenes = [scene_of_study(config, 5e-6, 2e-6, x_m=x, y_m=y) for x, y in places]
    forces = [each.force_n for each in solve(resolve_auto_terms(scenes), tolerance=1e-6)]
    assert forces == pytest.approx([forces[0]] * 4, rel=3e-6)
    found = MirrorAxes(x=True, y=False)
    folded = found.representative_positions(x_m=np.array([-1.0, 2.0]), y_m=np.array([-3.0, 4.0]))
    assert folded["x_m"].tolist() == [1.0, 2.0]
    assert folded["y_m"].tolist() == [-3.0, 4.0]
    assert symmetry_from_dict(found.to_dict(), source="fit") == found


def test_a_plate_s_surface_has_its_key_where_settings_are_shown(repository):
    actuator = load_config(repository / "config/plate.yaml").sections_as_dict("actuator")[
        "actuator"
    ]
    assert actuator["surface"] == {"shape": "rectangle", "length_x_m": 0.03, "length_y_m": 0.02}
    assert "rectangle" not in actuator
