"""Profile shapes: analytic ones, and measured ones made smooth with a known error."""

from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd
import pytest
from example_scan import scan_text
from scipy.special import jv

from paper.figures import vibration
from reporting.figures import style
from reporting.results import Results
from squeezefilm.config.loading import load_config
from squeezefilm.errors import InputError
from squeezefilm.film.measured.read import read_scan
from squeezefilm.film.measured.smooth import SmoothedScan, smoothed_scan
from squeezefilm.film.measured.tables import described, profile_table, summary_of
from squeezefilm.film.profiles import Modes, Profile, Sinc, make_profile
from squeezefilm.film.surfaces import Disc
from squeezefilm.quantities.model_error import resolve_auto_terms
from squeezefilm.reynolds import solve
from squeezefilm.studies.study import profile_of, scenes_in, smoothed_scan_of
from squeezefilm.tables import FACTOR_COLUMNS

RADIUS_M = 0.01


def polar_grid() -> tuple[np.ndarray, np.ndarray]:
    r, phi = np.meshgrid(np.linspace(0, RADIUS_M, 41), np.linspace(0, 6.2, 41))
    return r * np.cos(phi), r * np.sin(phi)


def profile(**settings: Any) -> Profile:
    return make_profile(surface=Disc(RADIUS_M), **settings)


@pytest.fixture
def smooth(tmp_path):
    def write(text: str, *, axisymmetric: bool = True) -> SmoothedScan:
        path = tmp_path / "scan.csv"
        path.write_text(text, encoding="utf-8")
        smoothed_scan.cache_clear()
        return smoothed_scan(path, surface=Disc(RADIUS_M), axisymmetric=axisymmetric)

    return write


def table(*columns: np.ndarray, header: str) -> str:
    rows = zip(*columns, strict=True)
    return "\n".join([header, *(",".join(f"{value:.9g}" for value in row) for row in rows)]) + "\n"


def raster(points: int = 25) -> tuple[np.ndarray, np.ndarray]:
    line = np.linspace(-RADIUS_M, RADIUS_M, points) * 0.99
    x, y = (values.ravel() for values in np.meshgrid(line, line))
    inside = np.hypot(x, y) < RADIUS_M * 0.99
    return x[inside], y[inside]


def bessel(nodal_diameters: int, **settings: float) -> dict[str, Any]:
    mode = {"wave_number_rad_per_m": 700.0, "edge_share": 0.0, "direction_deg": 20.0}
    return {"kind": "bessel", "nodal_diameters": nodal_diameters} | mode | settings


ANALYTIC = [
    {"kind": "standing-wave", "wavelength_m": 0.012, "direction_deg": 30, "crest_m": 0.002},
    {"kind": "standing-wave", "wavelength_m": 0.08, "direction_deg": 30, "crest_m": 0.015},
    {"kind": "standing-wave", "wavelength_m": 10.0, "direction_deg": 0, "crest_m": -2.5},
    {"kind": "formula", "expression": "3 * cos(500*x) * exp(-(r/0.01)**2)"},
    *(bessel(n, edge_share=share) for n, share in [(0, 0.0), (0, 0.02), (2, 0.0), (3, -0.01)]),
]


@pytest.mark.parametrize("settings", ANALYTIC, ids=lambda s: f"{s['kind']} {len(str(s))}")
def test_the_largest_amplitude_on_the_disc_is_one(settings):
    r, phi = np.meshgrid(np.linspace(0, RADIUS_M, 401), np.linspace(0, 2 * np.pi, 721))
    values = profile(**settings).amplitude(x_m=r * np.cos(phi), y_m=r * np.sin(phi))
    assert np.abs(values).max() == pytest.approx(1, abs=1e-4)
    assert np.abs(values).max() <= 1 + 1e-9


def test_a_mode_with_nodal_diameters_turns_its_sign_across_them():
    shape = profile(**bessel(2, wave_number_rad_per_m=600.0, direction_deg=10.0))
    angle = np.radians(10 + np.array([0, 45, 90, 180]))
    values = shape.amplitude(x_m=0.004 * np.cos(angle), y_m=0.004 * np.sin(angle))
    largest = jv(2, np.linspace(0, 6, 100_001)).max()
    assert values == pytest.approx(jv(2, 2.4) / largest * np.array([1, 0, -1, 1]), abs=1e-9)


def test_without_noise_the_profile_comes_back(smooth):
    x, y = raster()
    shape = profile(**ANALYTIC[0])
    amplitude = 2e-6 * shape.amplitude(x_m=x, y_m=y)
    text = table(x * 1e3, y * 1e6, amplitude * 1e9, header="x_mm,y_um,amplitude_nm")
    smoothed = smooth(text, axisymmetric=False)
    places = dict(zip(("x_m", "y_m"), polar_grid(), strict=True))
    found, sought = smoothed.profile.amplitude(**places), shape.amplitude(**places)
    # The sign of the whole is a matter of half a period.
    assert found * np.sign(found[0, 0] * sought[0, 0]) == pytest.approx(sought, abs=2e-3)
    assert smoothed.peak_m == pytest.approx(2e-6, rel=2e-3)


def test_a_scan_along_a_radius_gives_an_axisymmetric_profile(smooth):
    r = np.linspace(0, RADIUS_M, 60)
    noise = 0.01 * np.random.default_rng(3).standard_normal(60)
    signed = np.sinc(109.8 * r) + noise
    text = table(r * 1e3, np.abs(signed), np.sign(signed), header="r_mm,amplitude_um,sign")
    x_m, y_m = polar_grid()
    found = smooth(text).profile.amplitude(x_m=x_m, y_m=y_m)
    assert found == pytest.approx(np.sinc(109.8 * np.hypot(x_m, y_m)), abs=0.02)
    assert np.ptp(found, axis=0) == pytest.approx(np.zeros(41), abs=1e-12)
    with pytest.raises(InputError, match=r"axisymmetric: true"):
        smooth(text, axisymmetric=False)


def test_phase_and_sign_and_polar_places_say_the_same(smooth):
    x, y = raster()
    s = np.sinc(109.8 * np.hypot(x, y))
    by_sign = table(x, y, np.abs(s), np.sign(s), header="x_m,y_m,amplitude_m,sign")
    angle, phase = np.arctan2(y, x), np.where(s < 0, 200.0, 20.0)
    by_phase = table(
        np.hypot(x, y),
        np.degrees(angle),
        np.abs(s),
        phase,
        header="r_m,phi_deg,amplitude_m,phase_deg",
    )
    x_m, y_m = polar_grid()
    first, second = (smooth(t).profile.amplitude(x_m=x_m, y_m=y_m) for t in (by_sign, by_phase))
    assert first == pytest.approx(second, abs=1e-6)


@pytest.mark.parametrize("axisymmetric", [True, False])
def test_the_stated_error_covers_the_true_one(smooth, axisymmetric):
    """Two standard errors hold at about 95 % of the places, over scans with other noise."""
    x_m, y_m = polar_grid()
    exact = np.sinc(109.8 * np.hypot(x_m, y_m))
    held = []
    for seed in range(8 if axisymmetric else 3):  # a scan of the plane has 45 modes, a radius few
        text = scan_text(noise=0.02, missing=0.03, seed=seed)
        smoothed = smooth(text, axisymmetric=axisymmetric)
        assert smoothed.noise_m / smoothed.peak_m == pytest.approx(0.02, rel=0.15)
        difference = smoothed.profile.amplitude(x_m=x_m, y_m=y_m) * smoothed.peak_m / 1.2e-6 - exact
        held.append(np.abs(difference) <= 2 * smoothed.standard_error(x_m=x_m, y_m=y_m))
    assert 0.85 < np.mean(held) <= 1


def test_forces_of_the_worked_example_are_within_two_percent(repository):
    """The example in config/ is the sinc with 2 % noise: exact forces are known."""
    config = load_config(repository / "config" / "vibrometer.yaml")
    places = [(5e-6, 2e-6, 0.0, 0.0), (10e-6, 0.2e-6, 0.0, 0.0), (5e-6, 2e-6, 0.0029, 45.0)]
    measured = scenes_in(pd.DataFrame(places, columns=FACTOR_COLUMNS), config)
    exact = [
        replace(scene, actuator=replace(scene.actuator, profile=Sinc(109.8))) for scene in measured
    ]
    ours, true = (
        np.array([s.force_n for s in solve(resolve_auto_terms(scenes), tolerance=1e-4)])
        for scenes in (measured, exact)
    )
    assert ours == pytest.approx(true, rel=0.02)
    smoothed = smoothed_scan_of(config)
    assert smoothed is not None
    assert isinstance(profile_of(config), Modes)
    assert profile_of(config) == smoothed.profile
    assert smoothed.degree < 10  # noise is left out: points that were left out are not fitted


def test_the_worked_example_is_the_paper_s_sinc_with_noise(repository):
    text = (repository / "config" / "vibrometer.csv").read_text(encoding="utf-8")
    assert text == scan_text(noise=0.02, missing=0.03, seed=1)


GOOD = scan_text(noise=0.02, missing=0.03, seed=1)
HEADER, ROWS = GOOD.split("\n", 1)
WRONG = {
    "an unknown column": (
        GOOD.replace("amplitude_um", "height_um"),
        "unknown columns: 'height_um'",
    ),
    "no unit": (GOOD.replace("x_mm", "x"), "line 1: column 'x' needs a unit, one of x_m, x_mm"),
    "a column twice": (GOOD.replace("y_mm", "x_m"), "line 1: the column 'x' stands twice"),
    "no y": (GOOD.replace("y_mm", "phi_deg"), "line 1: the place of a point is x and y"),
    "phase and sign": ("x_m,y_m,amplitude_m,sign,phase_deg\n1,1,1,1,1\n", "not both"),
    "a word": (GOOD.replace("-1.50,-9.75", "left,-9.75"), "line 2: x is 'left', not a finite"),
    "a cell too many": (GOOD.replace("-1.50,-9.75", "-1.50,-9.75,1"), "line 2: 5 cells where"),
    "a point off the disc": (GOOD.replace("-1.50,-9.75", "-1.50,-10.75"), "line 2: the point lies"),
    "a negative amplitude with a phase": (
        GOOD.replace("9.75,0.0828", "9.75,-0.0828"),
        "line 2: amplitude must not be negative",
    ),
    "a sign that is none": ("r_mm,amplitude_um,sign\n" + "1,1,2\n" * 9, "line 2: sign must be"),
    "a negative radius": ("r_mm,amplitude_um\n" + "-1,1\n" * 9, "line 2: r must not be negative"),
    "few points": ("r_mm,amplitude_um\n1,1\n2,1\n", "2 measured points (0 missing)"),
    "one place": ("r_mm,amplitude_um\n" + "5,1\n5,1.1\n" * 9, "measured within 5.0 mm of r ="),
    "noise alone": (
        "r_mm,amplitude_um\n" + "".join(f"{i % 10},{(-1) ** (i * i // 3)}\n" for i in range(20)),
        "known to ±",
    ),
    "no motion": ("r_mm,amplitude_um\n" + "".join(f"{i},0\n" for i in range(9)), "is zero"),
    "nothing": ("", "the scan is empty"),
    "a quote left open": ('x_mm,"y_mm\n', "cannot be read"),
}


@pytest.mark.parametrize("case", WRONG)
def test_a_wrong_scan_is_refused(case, smooth):
    text, message = WRONG[case]
    with pytest.raises(InputError) as refusal:
        smooth(text, axisymmetric="x_" not in text.split("\n")[0])
    assert "scan.csv" in str(refusal.value)
    assert message in str(refusal.value)


def test_a_scan_that_cannot_be_read_is_named(tmp_path):
    with pytest.raises(InputError, match="no such scan"):
        read_scan(tmp_path / "none.csv")
    with pytest.raises(InputError, match="cannot be read"):
        read_scan(tmp_path)


@pytest.mark.parametrize(
    "settings",
    [
        {"kind": "piston"},
        bessel(0, wave_number_rad_per_m=200),
        {"kind": "standing-wave", "wavelength_m": 0.01, "direction_deg": 20, "crest_m": 0},
        {"kind": "measured", "file": "vibrometer.csv", "axisymmetric": False},
    ],
    ids=lambda settings: str(settings["kind"]),
)
def test_a_profile_of_any_kind_can_be_drawn(settings, repository, tmp_path):
    """Also without a node line, and flat."""
    config = load_config(repository / "config" / "vibrometer.yaml")
    actuator = {**config["actuator"], "profile": settings}
    study = replace(config, sections={**config, "actuator": actuator})
    for draw in (vibration.fig05, vibration.fig06):
        with style.settings():
            figure, _ = draw(Results(tmp_path, study))
        axes = figure.axes[0]
        assert [*axes.lines, *axes.collections, *axes.images]


def test_a_scan_s_table_has_its_outliers_and_residuals(smooth):
    lines = scan_text(noise=0.02, missing=0.1, seed=2).splitlines()
    lines[77] = lines[77].split(",")[0] + ",0.75,2.0,0"
    smoothed = smooth("\n".join(lines), axisymmetric=False)
    summary = summary_of(smoothed, noise=0.01, error=0.01)
    table = profile_table(smoothed)
    assert summary["outlier_lines"] == list(table.loc[table["layer"] == "outliers", "line"]) == [78]
    assert set(table["layer"]) == {"points", "outliers", "profile"}
    assert "outliers, not fitted 1 (lines 78)" in described(summary)
    points = table[table["layer"] == "points"]
    assert points["residual_um"].std() == pytest.approx(smoothed.noise_m * 1e6, rel=0.1)
