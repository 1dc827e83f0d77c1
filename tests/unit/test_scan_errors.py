"""What is said of the forces of a measured profile holds: noise, strays, signs, other phases."""

import pickle
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import pytest
from changed_sections import made_profile
from scipy.stats import binom

from squeezefilm.cli.main import main
from squeezefilm.config.loading import load_config
from squeezefilm.errors import InputError
from squeezefilm.film.measured.placement import check_points
from squeezefilm.film.measured.scan import Scan
from squeezefilm.film.measured.smooth import SmoothedScan, smooth_scan
from squeezefilm.film.measured.smoothed_file import read_smoothed_scan, write_smoothed_scan
from squeezefilm.film.profiles import Profile, ScanFile, TravellingWave
from squeezefilm.film.scene import Scene
from squeezefilm.film.surfaces import Disc, Rectangle
from squeezefilm.reynolds import solve
from squeezefilm.reynolds.device import choose_device
from squeezefilm.studies.study import scene_of_study
from squeezefilm.studies.tasks import scan_errors
from squeezefilm.studies.tasks.scan_errors import NEGLECTED_NOISE_FRACTION, scan_errors_table
from squeezefilm_workflow.reporting.figures.maps import _draw_over_radius

RADIUS_M = 0.01
FREE_SHAPE = ScanFile("scan.csv")
KEPT_WITH = {"settings": FREE_SHAPE, "surface": Disc(RADIUS_M), "frequency_hz": 43270.0}
SINC = {"kind": "sinc", "wave_number_per_m": 109.8}
DIAMETERS = {
    "kind": "bessel",
    "nodal_diameters": 2,
    "wave_number_rad_per_m": 500.0,
    "edge_share": 0.0,
    "direction_deg": 20.0,
}
WAVE = {"kind": "standing-wave", "wavelength_m": 0.014, "direction_deg": 30, "crest_m": 0.001}
DOME = {"kind": "formula", "expression": "1 - 0.3*(r/0.01)**2"}


def profile(settings: dict[str, Any]) -> Profile:
    return made_profile(Disc(RADIUS_M), **settings)


def raster(step_mm: float) -> tuple[np.ndarray, np.ndarray]:
    steps = int(9.9 / step_mm)
    line = step_mm * np.arange(-steps, steps + 1) / 1e3
    x, y = (values.ravel() for values in np.meshgrid(line, line))
    inside = np.hypot(x, y) <= 9.9e-3
    return x[inside], y[inside]


def scan_of(
    shape: Profile, *, noise: float, seed: int, strays: int = 0, step_mm: float = 0.75
) -> Scan:
    """A scan of 1 µm at the maximum, with strays of three times that."""
    random = np.random.default_rng(seed)
    x_m, y_m = raster(step_mm)
    u = shape.amplitude(x_m=x_m, y_m=y_m) + noise * random.standard_normal(len(x_m))
    u[random.choice(len(u), strays, replace=False)] += 3 * random.choice([-1, 1], strays)
    lines = np.arange(len(u)) + 2
    return Scan(
        Path("scan.csv"), x_m, y_m, 1e-6 * u.astype(complex), lines, 0, has_phase_or_sign=True
    )


def unsigned(scan: Scan) -> Scan:
    return replace(scan, amplitude_m=np.abs(scan.amplitude_m) + 0j, has_phase_or_sign=False)


def smooth(scan: Scan, **settings: Any) -> SmoothedScan:
    return smooth_scan(scan, ScanFile("scan.csv", **settings), Disc(RADIUS_M))


@pytest.fixture(scope="module")
def scene(repository):
    config = load_config(repository / "config" / "paper.yaml")
    return scene_of_study(config, 5e-6, 2e-6)


def on(scene: Scene, shape: Profile) -> Scene:
    return replace(scene, actuator=replace(scene.actuator, profile=shape))


def test_ninety_five_percent_of_the_intervals_hold_the_force(scene):
    """60 scans of three modes: one maximum, four equal ones, and crests all along lines.

    Half of them have strays. If each interval holds the force at 95 %, fewer than asked here do so
    in one of forty such tests.
    """
    device = choose_device()
    held = []
    for settings in (SINC, DIAMETERS, WAVE):
        shape = profile(settings)
        (true,) = solve([on(scene, shape)], tolerance=1e-4, device=device)
        for strays, seed in product((0, 3), range(10)):
            scan = smooth(scan_of(shape, noise=0.03, seed=seed, strays=strays))
            errors = scan_errors_table([on(scene, scan.profile)], scan, device=device).iloc[0]
            difference = float(errors.force_n) - true.force_n
            held.append(abs(difference) <= errors.scan_error_n + 1e-3 * true.force_n)
    assert sum(held) >= binom.ppf(0.025, len(held), 0.95)


@pytest.mark.parametrize("epsilon", [0.1, 0.9])
def test_noise_in_a_few_directions_spreads_forces_as_draws_do(scene, monkeypatch, epsilon):
    """A large pad and a small one; to half of what fifty draws leave open, 1/√98."""
    device = choose_device()
    few, drawn = [], []
    for settings, side_m, x_m in ((WAVE, 10e-3, 3e-3), (DIAMETERS, 4e-3, 5e-3)):
        scan = smooth(scan_of(profile(settings), noise=0.03, seed=2))
        pad = replace(scene.pad, length_x_m=side_m, length_y_m=side_m)
        film = on(replace(scene, hv_m=epsilon * scene.h0_m, x_m=x_m, pad=pad), scan.profile)
        for spreads, fraction in ((few, NEGLECTED_NOISE_FRACTION), (drawn, -1.0)):
            monkeypatch.setattr(scan_errors, "NEGLECTED_NOISE_FRACTION", fraction)
            spreads += scan_errors_table([film], scan, device=device)["spread_n"].tolist()
    assert few == pytest.approx(drawn, rel=0.05)
    assert few != drawn


COARSE = {
    "dome": (380.0, 0, 2.0),
    "45 points": (380.0, 0, 2.5),
    "three rings": (900.0, 0, 1.2),
    "two diameters": (500.0, 2, 1.75),
}


@pytest.mark.parametrize("shape", COARSE)
def test_what_a_smooth_shape_misses_is_no_noise(scene, shape):
    """Few points without any noise: 0.042 ± 0.002 N was given for 0.0375 N (`dome`)."""
    wave_number, diameters, step_mm = COARSE[shape]
    mode = {"nodal_diameters": diameters, "wave_number_rad_per_m": wave_number}
    true = profile(DIAMETERS | mode)
    pad = replace(scene.pad, length_x_m=4e-3, length_y_m=4e-3)
    scenes = [replace(scene, pad=pad, x_m=x_m) for x_m in (0.0, 5e-3)]
    scan = smooth(scan_of(true, noise=0.0, seed=1, step_mm=step_mm))
    device = choose_device()
    errors = scan_errors_table([on(each, scan.profile) for each in scenes], scan, device=device)
    forces = solve([on(each, true) for each in scenes], tolerance=1e-4, device=device)
    for (_, row), force in zip(errors.iterrows(), forces, strict=True):
        assert abs(row["force_n"] - force.force_n) <= row["scan_error_n"] + 1e-3 * force.force_n
        assert row["scan_error_fraction"] < 0.15


def test_waves_along_one_side_with_a_slope_along_the_other_are_covered(scene):
    """Modes that follow the waves left the slope out: a quarter of the intervals failed."""
    surface, device = Rectangle(0.06, 0.04), choose_device()
    wave = "cos(2*pi*x/0.024) * (1 + 0.15*y/0.02)"
    true = made_profile(surface, kind="formula", expression=wave)
    columns = np.meshgrid(np.linspace(-0.03, 0.03, 31), np.linspace(-0.02, 0.02, 21))
    x_m, y_m = (column.ravel() for column in columns)
    pads = [
        replace(scene, x_m=x_m, y_m=y_m)
        for x_m, y_m in product((-0.02, 0, 0.02), (-0.013, 0, 0.013))
    ]
    forces = solve([on(pad, true) for pad in pads], tolerance=1e-4, device=device)
    exact_n = np.array([force.force_n for force in forces])
    held = []
    for seed in range(8):
        noise = 0.015 * np.random.default_rng(seed).standard_normal(len(x_m))
        amplitude_m = 1e-6 * (true.amplitude(x_m=x_m, y_m=y_m) + noise + 0j)
        lines = np.arange(len(x_m)) + 2
        scan = Scan(Path("scan.csv"), x_m, y_m, amplitude_m, lines, 0, has_phase_or_sign=True)
        smooth = smooth_scan(scan, FREE_SHAPE, surface)
        errors = scan_errors_table([on(pad, smooth.profile) for pad in pads], smooth, device=device)
        held.append(np.abs(errors["force_n"] - exact_n) <= errors["scan_error_n"])
    assert np.mean(held) >= 0.9


@pytest.mark.parametrize("times", [2, 3])
def test_rows_that_stand_repeatedly_tell_nothing_more(times):
    """Every row twice was overfitted: rows of a place predict each other."""
    once = scan_of(profile(DIAMETERS), noise=0.02, seed=1, step_mm=1.2)
    columns = ("x_m", "y_m", "amplitude_m", "lines")
    repeated = {name: np.tile(getattr(once, name), times) for name in columns}
    one, other = smooth(once), smooth(replace(once, **repeated))
    assert other.fit.degree == one.fit.degree
    assert other.noise_m == pytest.approx(one.noise_m, rel=1e-9)
    x_m, y_m = raster(1.5)
    one_error, other_error = (each.standard_error(x_m=x_m, y_m=y_m) for each in (one, other))
    assert other_error == pytest.approx(one_error, rel=1e-6)
    assert f"at {len(once.x_m)} places: the mean" in " ".join(other.warnings)


def test_the_scale_may_be_taken_where_the_scan_measured():
    """697 points of five waves, none beyond 28.5 mm of 30: there the maximum is noise."""
    lines_m = np.linspace(-0.0285, 0.0285, 41), np.linspace(-0.019, 0.019, 17)
    x_m, y_m = (each.ravel() for each in np.meshgrid(*lines_m))
    noise = 0.015 * np.random.default_rng(1).standard_normal(len(x_m))
    u = 1.2e-6 * (np.cos(2 * np.pi * x_m / 0.012 + 0.3) + noise)
    lines = np.arange(len(u)) + 2
    scan = Scan(Path("scan.csv"), x_m, y_m, u.astype(complex), lines, 0, has_phase_or_sign=True)
    surface = Rectangle(0.06, 0.04)
    default = smooth_scan(scan, FREE_SHAPE, surface)
    (note,) = default.warnings
    assert "between or beyond the last rows" in note
    assert "actuator.profile.scale: measured" in note
    measured = smooth_scan(scan, ScanFile("scan.csv", scale="measured"), surface)
    assert measured.warnings == ()
    assert measured.peak_m == pytest.approx(1.2e-6, rel=0.01)
    assert measured.peak_bias_m < 0.2 * default.peak_bias_m


def test_strays_are_not_fitted(scene):
    shape = profile(DIAMETERS)
    with_strays, without = (
        smooth(scan_of(shape, noise=0.01, seed=5, strays=strays)) for strays in (3, 0)
    )
    assert with_strays.outlier_mask.sum() == 3
    assert "note: 3 outliers excluded (lines " in with_strays.warnings[-1]
    assert without.warnings == ()
    assert np.abs(with_strays.residual_m[with_strays.outlier_mask]) == pytest.approx(3e-6, rel=0.05)
    forces = [
        s.force_n
        for s in solve([on(scene, s.profile) for s in (with_strays, without)], tolerance=1e-3)
    ]
    assert forces[0] == pytest.approx(forces[1], rel=0.02)


def test_an_unsigned_scan_is_taken_if_the_study_says_so():
    scan = unsigned(scan_of(profile(DOME), noise=0.02, seed=1))
    with pytest.raises(InputError, match=r"(?s)node line.*actuator\.profile\.sign: unknown"):
        check_points(scan, FREE_SHAPE, Disc(RADIUS_M))
    (warning,) = smooth(scan, sign="unknown").warnings
    assert "all amplitudes are taken to one side" in warning


def with_two_phases(share: float) -> Scan:
    """A dome with another shape a quarter of a period later: its rms a share of all motion's."""
    x_m, y_m = raster(0.75)
    first = profile(DOME).amplitude(x_m=x_m, y_m=y_m)
    second = np.sin(150 * x_m)
    ratio = share / np.sqrt(1 - share**2)
    second *= ratio * np.sqrt(np.mean(first**2) / np.mean(second**2))
    u = 1e-6 * (first + 1j * second)
    return Scan(Path("scan.csv"), x_m, y_m, u, np.arange(len(u)), 0, has_phase_or_sign=True)


@pytest.mark.parametrize("begin", [0.0, 0.7])
def test_a_scan_of_a_travelling_wave_is_one(scene, begin):
    """Both parts, which way it travels, and the force of the wave that was measured."""
    x_m, y_m = raster(0.75)
    wave = TravellingWave(0.014, direction_deg=30.0)
    noise = 0.003 * np.random.default_rng(1).standard_normal((2, len(x_m)))
    u = wave.amplitude(x_m=x_m, y_m=y_m) + noise[0] + 1j * noise[1]
    lines = np.arange(len(u))
    measured = Scan(
        Path("scan.csv"), x_m, y_m, 1e-6 * u * np.exp(1j * begin), lines, 0, has_phase_or_sign=True
    )
    scan = smooth(measured)
    found = scan.profile.amplitude(x_m=x_m, y_m=y_m)
    together = np.vdot(found, u)
    assert np.abs(found * together / abs(together) - u).max() < 0.05
    sought, fitted = solve([on(scene, each) for each in (wave, scan.profile)], tolerance=1e-4)
    errors = scan_errors_table([on(scene, scan.profile)], scan, device=choose_device()).iloc[0]
    assert errors.quadrature_n == 0
    assert abs(fitted.force_n - sought.force_n) < errors.scan_error_n + fitted.force_error_n
    assert errors.measurement_noise_n < 0.1 * fitted.force_n


def test_a_smoothed_scan_in_two_phases_is_read_as_it_was_written(tmp_path):
    path = tmp_path / "scan.csv"
    path.write_text("as measured")
    scan = smooth(replace(with_two_phases(0.5), path=path))
    write_smoothed_scan(scan, tmp_path / "smoothed.npz", **KEPT_WITH)
    again = read_smoothed_scan(tmp_path / "smoothed.npz", path, **KEPT_WITH)
    assert scan.profile.is_complex
    assert again.profile == scan.profile
    assert again.scan.notes == scan.scan.notes
    assert np.array_equal(again.measured_amplitude_m, scan.measured_amplitude_m)
    first, second = (each.bootstrap_profiles(count=3, seed=1) for each in (scan, again))
    assert first == second
    assert len({*first, scan.profile}) == 4
    path.write_text("measured again")
    read_smoothed_scan.cache_clear()
    with pytest.raises(InputError, match=r"smoothed from another scan\.csv"):
        read_smoothed_scan(tmp_path / "smoothed.npz", path, **KEPT_WITH)


class Trap:
    """An object whose pickle leaves a file behind when it is read."""

    def __init__(self, path):
        self.path = path

    def __reduce__(self):
        return (Path.touch, (self.path,))


def test_a_file_in_a_smoothed_scans_place_is_not_executed(tmp_path):
    scan, stored, trace = (tmp_path / name for name in ("scan.csv", "smoothed.npz", "executed"))
    scan.write_text("as measured")
    for write in (
        lambda: stored.write_bytes(pickle.dumps(Trap(trace))),
        lambda: np.savez(stored, made_from=np.array([Trap(trace)], dtype=object)),
    ):
        write()
        read_smoothed_scan.cache_clear()
        with pytest.raises(InputError, match=r"smoothed\.npz: not a smoothed scan"):
            read_smoothed_scan(stored, scan, **KEPT_WITH)
        assert not trace.exists()


def test_outliers_do_not_set_the_axes_of_the_profile():
    """Two points at fifty times the amplitude hid the residuals of all others."""
    r_mm = np.linspace(0, 10, 50)
    points = {"layer": "points", "r_mm": r_mm, "amplitude_um": np.cos(r_mm / 5)}
    profile = {"layer": "profile", "r_mm": r_mm, "error_um": 0.01}
    profile |= {f"profile_{end}_um": np.cos(r_mm / 5) for end in ("min", "max")}
    strays = {"layer": "outliers", "r_mm": [1.0, 2.0], "amplitude_um": [50.0, -50.0]}
    strays |= {"residual_um": [49.0, -49.0]}
    tables = [pd.DataFrame(each) for each in (points | {"residual_um": 0.02}, profile, strays)]
    amplitude, residual = plt.subplots(1, 2)[1]
    _draw_over_radius(amplitude, residual, pd.concat(tables).assign(noise_um=0.02))
    assert max(amplitude.get_ylim()) < 2
    assert max(residual.get_ylim()) < 0.2
    for axes in (amplitude, residual):
        labels = axes.get_legend_handles_labels()[1]
        assert (labels.count("outliers (2)"), labels.count("2 beyond the axis")) == (1, 1)
        markers = [line.get_marker() for line in axes.get_lines()]
        assert (markers.count("^"), markers.count("v")) == (1, 1)
    plt.close("all")


def test_the_scan_of_a_film_without_a_study_is_smoothed(repository, tmp_path, capsys):
    film, table = tmp_path / "film.yaml", tmp_path / "profile.csv"
    scan = repository / "config/vibrometer.csv"
    film.write_text(
        f"""
actuator:
  {{frequency: 43 kHz, surface_radius: 10 mm, profile: {{kind: measured, file: {scan}}}}}
pad: {{length_x: 10 mm, length_y: 10 mm}}
""",
        encoding="utf-8",
    )
    assert main(["profile", f"--config={film}", f"--table={table}"]) == 0
    printed = capsys.readouterr().out
    assert "force   `squeezefilm simulate` shows it with each force" in printed
    assert "points                         532" in printed
    assert "points" in set(pd.read_csv(table)["layer"])
    assert main(["profile", f"--config={film}", f"--forces={table}"]) == 2
    assert "--forces: " in capsys.readouterr().err
