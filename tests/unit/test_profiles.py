"""Profile shapes: analytic ones, and measured ones made smooth with a known error."""

from typing import Any

import numpy as np
import pytest
from changed_sections import made_profile
from example_scan import scan_text
from scipy.special import jv

from squeezefilm.errors import InputError
from squeezefilm.film.measured.smooth import SmoothedScan, smoothed_scan_of_file
from squeezefilm.film.profiles import Profile, ScanFile
from squeezefilm.film.surfaces import Disc

RADIUS_M = 0.01


def polar_grid() -> tuple[np.ndarray, np.ndarray]:
    r, phi = np.meshgrid(np.linspace(0, RADIUS_M, 41), np.linspace(0, 6.2, 41))
    return r * np.cos(phi), r * np.sin(phi)


def profile(**settings: Any) -> Profile:
    return made_profile(Disc(RADIUS_M), **settings)


@pytest.fixture
def smooth(tmp_path):
    def write(text: str, *, axisymmetric: bool = True) -> SmoothedScan:
        path = tmp_path / "scan.csv"
        path.write_text(text, encoding="utf-8")
        settings = ScanFile("scan.csv", axisymmetric=axisymmetric)
        return smoothed_scan_of_file(path, settings, Disc(RADIUS_M), frequency_hz=43270.0)

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


GOOD = scan_text(noise=0.02, missing=0.03, seed=1)
HEADER, ROWS = GOOD.split("\n", 1)
WRONG = {
    "an unknown column": (GOOD.replace("amplitude_um", "height_um"), "not understood: 'height_um'"),
    "no unit": (
        GOOD.replace("x_mm", "x"),
        "line 1: no unit is known of 'x'; write it into the header, as in x [mm]",
    ),
    "a cell too many": (GOOD.replace("-1.50,-9.75", "-1.50,-9.75,1"), "line 2: 5 cells where"),
    "a point off the disc": (GOOD.replace("-1.50,-9.75", "-1.50,-10.75"), "line 2: the point lies"),
    "few points": ("r_mm,amplitude_um\n1,1\n2,1\n", "2 measured points (0 missing)"),
    "noise alone": (
        "r_mm,amplitude_um\n" + "".join(f"{i / 2},{(-1) ** (i * i // 3)}\n" for i in range(20)),
        "known to ±",
    ),
}


@pytest.mark.parametrize("case", WRONG)
def test_a_wrong_scan_is_refused(case, smooth):
    text, message = WRONG[case]
    with pytest.raises(InputError) as refusal:
        smooth(text, axisymmetric="x_" not in text.split("\n")[0])
    assert "scan.csv" in str(refusal.value)
    assert message in str(refusal.value)
