"""A scan is read as it was exported: whatever its encoding, separator, header and quantities."""

from collections.abc import Callable
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import pyuff

from squeezefilm.film.measured import smooth
from squeezefilm.film.measured.read import UNIVERSAL, Scan, column_of, read_scan
from squeezefilm.film.measured.smooth import smoothed_scan
from squeezefilm.film.measured.tables import summary_of
from squeezefilm.film.surfaces import Disc
from squeezefilm.io.errors import InputError
from squeezefilm.studies import study as studies
from squeezefilm.studies.config import load_config

FREQUENCY_HZ = 43270.0
RADIUS_M = 0.01


def points(count: int = 15, noise: float = 0.0) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """x and y in mm and the signed amplitude in µm, over the disc."""
    line = np.linspace(-9.9, 9.9, count)
    x, y = (values.ravel() for values in np.meshgrid(line, line))
    inside = np.hypot(x, y) < 9.9
    x, y = x[inside], y[inside]
    random = np.random.default_rng(1).standard_normal(len(x))
    return x, y, 1.2 * (np.sinc(0.1098 * np.hypot(x, y)) + noise * random)


X, Y, U = points()


def text(header: str, *columns: np.ndarray, comma: bool = False) -> str:
    """Rows of cells with semicolons between where commas are decimal."""
    rows = [[f"{value:.9g}" for value in row] for row in zip(*columns, strict=True)]
    if comma:
        rows = [[cell.replace(".", ",") for cell in row] for row in rows]
    between = ";" if comma else ","
    return "\n".join([header, *(between.join(row) for row in rows)]) + "\n"


PHASE = np.where(U < 0, 180.0, 0.0)
PLAIN = text("x_mm,y_mm,amplitude_um,phase_deg", X, Y, abs(U), PHASE)
TURNED = U * np.exp(0.7j)
SPEED = U * 2 * np.pi * FREQUENCY_HZ * 1e-3  # mm/s
COMMAS = text("x_mm;y_mm;amplitude_µm;phase_deg", X, Y, abs(U), PHASE, comma=True)
FORMS: dict[str, bytes] = {
    "plain": PLAIN.encode(),
    "byte order mark": b"\xef\xbb\xbf" + PLAIN.encode(),
    "semicolons and decimal commas": COMMAS.encode(),
    "latin-1": COMMAS.encode("latin-1"),
    "utf-16 with a mark": COMMAS.encode("utf-16"),
    "utf-16 without": COMMAS.encode("utf-16-le"),
    "big-endian": b"\xfe\xff" + COMMAS.encode("utf-16-be"),
    "carriage returns": PLAIN.replace("\n", "\r\n").encode(),
    "tabs": PLAIN.replace(",", "\t").encode(),
    "blanks": PLAIN.replace(",", "   ").encode(),
    "quoted decimal commas": text("x_mm,y_mm,amplitude_um,phase_deg", X, Y, abs(U), PHASE)
    .replace(",", '","')
    .replace("\n", '"\n"')
    .replace(".", ",")
    .removesuffix('"')
    .join(['"', ""])
    .encode(),
    "brackets": PLAIN.replace(
        "x_mm,y_mm,amplitude_um,phase_deg", "X [mm],Y [mm],Amplitude [µm],Phase [°]"
    ).encode(),
    "round brackets": PLAIN.replace(
        "x_mm,y_mm,amplitude_um,phase_deg",
        "X Position (mm),Position Y (mm),Displacement Magnitude (um),Phase (deg)",
    ).encode(),
    "a header that is a comment": f"# made today\n# {PLAIN}".encode(),
    "lines before the header": f"Scan data\nDevice;3\n\n{PLAIN}".encode(),
    "other columns": text(
        "Index,x_mm,y_mm,z_mm,amplitude_um,phase_deg,Coherence",
        *(X, X, Y, Y, abs(U), PHASE, U),
    ).encode(),
    "real and imaginary part": text(
        "x_mm,y_mm,Real [um],Imag [um]", X, Y, TURNED.real, TURNED.imag
    ).encode(),
    "both": text(
        "x_mm,y_mm,real_um,imag_um,amplitude_um,phase_deg", X, Y, U, 0 * U, abs(U), PHASE
    ).encode(),
    "velocity": text(
        "x_mm,y_mm,Velocity [mm/s],Phase [rad]", X, Y, abs(SPEED), np.radians(PHASE)
    ).encode(),
}


def same(scan: Scan, *, digits: float = 1e-6) -> None:
    """Whether a scan has the points above, but for one phase of all."""
    assert scan.y_m is not None
    assert scan.x_m == pytest.approx(X / 1e3, rel=digits, abs=1e-12)
    assert scan.y_m == pytest.approx(Y / 1e3, rel=digits, abs=1e-12)
    one = scan.amplitude_m[np.argmax(np.abs(U))]
    turned = scan.amplitude_m * abs(one) / one
    assert np.abs(turned - U * 1e-6).max() < digits * 1.2e-6
    assert scan.signed


@pytest.mark.parametrize("form", FORMS)
def test_a_scan_is_read_in_every_form(form, tmp_path):
    path = tmp_path / "scan.csv"
    path.write_bytes(FORMS[form])
    same(read_scan(path, frequency_hz=FREQUENCY_HZ))


def notes(path: Path, content: str) -> str:
    path.write_text(content, encoding="utf-8")
    return "; ".join(read_scan(path, frequency_hz=FREQUENCY_HZ).notes)


def test_what_is_left_out_is_said(tmp_path):
    path = tmp_path / "scan.txt"
    assert notes(path, PLAIN) == ""
    said = notes(path, FORMS["other columns"].decode())
    assert said == "columns left out: 'Index', 'z_mm', 'Coherence'"
    assert "'real_um', 'imag_um'" in notes(path, FORMS["both"].decode())
    assert "2 lines before the header left out" in notes(
        path, FORMS["lines before the header"].decode()
    )
    assert "divided by the angular frequency" in notes(path, FORMS["velocity"].decode())
    decibels = PLAIN.replace("\n", ",Level [dB]\n", 1).replace("\n", ",3\n").replace("],3", "]")
    assert "'Level [dB]'" in notes(path, decibels)


def with_header(header: str) -> str:
    return PLAIN.replace("x_mm,y_mm,amplitude_um,phase_deg", header)


WRONG = {
    "decibels": (with_header("x_mm,y_mm,Amplitude [dB],phase_deg"), "decibels are not taken"),
    "decibels to a unit": (with_header("x_mm,y_mm,amplitude_dB re 1 m,phase_deg"), "decibels are"),
    "commas for both": (
        PLAIN.replace(".", ","),
        "where the header has 4; decimal commas need another separator",
    ),
    "point and comma": (
        COMMAS.replace("9,9", "9.9", 1).replace("phase_deg", "phase_deg;z"),
        "cells where the header has",
    ),
    "both decimal signs": (COMMAS.replace("8,48571429", "8.48571429", 1), "has a point in"),
    "no header": (PLAIN.split("\n", 1)[1], "line 1: no header names the columns"),
    "nothing known": ("a,b,c\n1,2,3\n", "line 1: unknown column 'a', 'b', 'c'; a scan has"),
    "words between semicolons": (
        "Punkt Nr;Lage x;Weg y\n1;2;3\n",
        "unknown column 'Punkt Nr', 'Lage x', 'Weg y'; a scan has",
    ),
    "half of a number": (with_header("x_mm,y_mm,real_um,phase_deg"), "go together"),
    "two amplitudes": (
        with_header("x_mm,y_mm,amplitude_um,velocity_mm/s"),
        "stands twice: 'amplitude_um' and 'velocity_mm/s'",
    ),
    "no unit": (with_header("x_mm,y_mm,amplitude,phase_deg"), "'amplitude' needs a unit"),
    "unit of an acceleration": (with_header("x_mm,y_mm,amplitude [m/s²],phase_deg"), "one of"),
}


@pytest.mark.parametrize("case", WRONG)
def test_what_cannot_be_read_is_refused_with_a_word(case, tmp_path):
    content, message = WRONG[case]
    path = tmp_path / "scan.csv"
    path.write_text(content, encoding="utf-8")
    with pytest.raises(InputError) as refusal:
        read_scan(path, frequency_hz=FREQUENCY_HZ)
    assert message in str(refusal.value)
    assert "scan.csv: line" in str(refusal.value)


def test_a_velocity_needs_the_frequency(tmp_path):
    path = tmp_path / "scan.csv"
    path.write_bytes(FORMS["velocity"])
    with pytest.raises(InputError, match="need the actuator's frequency"):
        read_scan(path)


@pytest.mark.parametrize(
    "name", ["x_mm", "X [mm]", "x (MM)", "X/mm", "x, mm", "Pos. X mm", "X(mm)"]
)
def test_a_column_has_many_names(name):
    column = column_of(name)
    assert column is not None
    assert (column.quantity, column.unit) == ("x", "mm")


Edit = Callable[[dict[str, Any]], object]


def universal(path: Path, *, edit: Edit = lambda function: None, unit: float = 1.0) -> Path:
    """A universal file of the points, at three frequencies."""
    file = pyuff.UFF(str(path))
    nodes = np.arange(1, len(X) + 1)
    length = 1000.0  # millimetres
    sets: list[dict[str, Any]] = [
        pyuff.prepare_164(
            units_code=5,
            units_description="mm",
            temp_mode=1,
            length=length,
            force=1.0,
            temp=1.0,
            temp_offset=273.15,
            return_full_dict=True,
        ),
        pyuff.prepare_15(
            node_nums=nodes,
            def_cs=0 * nodes,
            disp_cs=0 * nodes,
            color=0 * nodes,
            x=X,
            y=Y,
            z=0 * X,
            return_full_dict=True,
        ),
    ]
    for node, value in zip(nodes, TURNED, strict=True):
        function = {
            "binary": 0,
            "func_type": 4,
            "rsp_node": int(node),
            "rsp_dir": 3,
            "ref_node": 1,
            "ref_dir": 3,
            "data": np.array([0.1, 1.0, 0.3]) * value * 1e-6 * unit,
            "x": FREQUENCY_HZ + np.array([-400.0, 30.0, 460.0]),
            "id1": "scan",
            "rsp_ent_name": "p",
            "ref_ent_name": "p",
            "abscissa_spacing": 1,
            "abscissa_spec_data_type": 18,
            "ordinate_spec_data_type": 8,
            "orddenom_spec_data_type": 0,
        }
        edit(function)
        sets.append(pyuff.prepare_58(**function))
    file.write_sets(sets, mode="overwrite")
    return path


def test_a_universal_file_is_read_at_the_frequency(tmp_path):
    same(read_scan(universal(tmp_path / "scan.uff"), frequency_hz=FREQUENCY_HZ), digits=1e-4)
    omega = 2 * np.pi * FREQUENCY_HZ

    def velocity(function: dict[str, Any]) -> None:
        function["ordinate_spec_data_type"] = 11

    path = universal(tmp_path / "speed.unv", edit=velocity, unit=omega)
    scan = read_scan(path, frequency_hz=FREQUENCY_HZ)
    same(scan, digits=1e-4)
    assert scan.notes == ("read at 43300 Hz",)


def test_a_universal_file_that_says_something_else_is_refused(tmp_path):
    wrong: list[tuple[dict[str, Any], str]] = [
        ({"func_type": 1, "abscissa_spec_data_type": 17}, "a function of time"),
        ({"func_type": 2}, "a power spectrum"),
        ({"ordinate_spec_data_type": 12}, "neither displacements"),
        ({"rsp_node": 999}, "the node 999 of a function has no place"),
        ({"rsp_node": 1}, "node 1 has several functions"),
        ({"x": np.array([1.0, 2.0, 3.0])}, "lines go from 1 to 3 Hz, and the actuator"),
    ]
    for change, message in wrong:
        path = universal(tmp_path / "scan.uff", edit=lambda one, change=change: one.update(change))
        with pytest.raises(InputError, match=message):
            read_scan(path, frequency_hz=FREQUENCY_HZ)
    (tmp_path / "text.uff").write_text(PLAIN)
    with pytest.raises(InputError, match=r"text\.uff"):
        read_scan(tmp_path / "text.uff", frequency_hz=FREQUENCY_HZ)
    for suffix in UNIVERSAL:
        with pytest.raises(InputError, match="there is no such scan"):
            read_scan(tmp_path / f"none{suffix}", frequency_hz=FREQUENCY_HZ)


@pytest.mark.parametrize("nothing", ["nan", "NaN", ""])
def test_points_without_an_amplitude_are_named_and_move_nothing(tmp_path, nothing):
    """Profile and noise are those of the scan without these rows; `simulate` has the note."""
    x, y, u = points(noise=0.02)
    whole = text("x_mm,y_mm,amplitude_um,sign", x, y, abs(u), np.sign(u)).splitlines()
    lacking = [12, 31]
    with_gaps = [
        ",".join([*line.split(",")[:2], nothing, "1"]) if at in lacking else line
        for at, line in enumerate(whole, start=1)
    ]
    without = [line for at, line in enumerate(whole, start=1) if at not in lacking]
    found = []
    for name, lines in (("gaps.csv", with_gaps), ("without.csv", without)):
        path = tmp_path / name
        path.write_text("\n".join(lines) + "\n")
        found.append(smoothed_scan(path, surface=Disc(RADIUS_M), axisymmetric=False))
    gaps, rest = found
    assert gaps.noise_m == rest.noise_m
    assert gaps.profile.coefficients == rest.profile.coefficients
    said = "2 points without an amplitude, excluded from profile and noise (lines 12, 31)"
    assert gaps.warnings == (f"note: {said}",)
    assert rest.warnings == ()


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_a_function_without_an_amplitude_is_named_and_adds_no_noise(tmp_path, value):
    """Pyuff writes NaN as zeros and infinity as the largest number: both were read as such."""

    def noisy(one: dict[str, Any], *, damaged: int) -> None:
        random = np.random.default_rng(one["rsp_node"])
        one["data"] = one["data"] * (value if one["rsp_node"] == damaged else 1)
        one["data"] = one["data"] + 5e-8 * random.standard_normal()

    noise = []
    for damaged in (0, 70):
        path = universal(
            tmp_path / f"{damaged}.uff", edit=lambda one, at=damaged: noisy(one, damaged=at)
        )
        scan = smoothed_scan(
            path, surface=Disc(RADIUS_M), axisymmetric=False, frequency_hz=FREQUENCY_HZ
        )
        noise.append(scan.noise_m)
    assert noise[1] == pytest.approx(noise[0], rel=0.05)
    said = "1 point without an amplitude, excluded from profile and noise (function 70)"
    assert scan.warnings[-1] == f"note: {said}"
    assert scan.scan.missing == 1


def test_a_scan_that_is_mostly_missing_is_refused(tmp_path):
    rows = PLAIN.splitlines()
    path = tmp_path / "scan.csv"
    kept = len(rows) // 3
    empty = [",".join([*row.split(",")[:2], "nan", "0"]) for row in rows[kept:]]
    path.write_text("\n".join([*rows[:kept], *empty]) + "\n")
    with pytest.raises(InputError, match=r"of \d+ points have no amplitude; at most 50%"):
        read_scan(path)


def test_too_many_points_are_averaged_over_cells_with_a_stated_loss(tmp_path, monkeypatch):
    """The profile is that of all points, but for no more than is said, and noise."""
    x, y, u = points(count=130, noise=0.02)
    path = tmp_path / "scan.csv"
    path.write_text(text("x_mm,y_mm,amplitude_um,sign", x, y, abs(u), np.sign(u)))
    settings = {"surface": Disc(RADIUS_M), "axisymmetric": False}
    all_points = smoothed_scan(path, **settings)
    assert all_points.averaging_loss == 0
    monkeypatch.setattr(smooth, "MOST_POINTS", 900)
    smoothed_scan.cache_clear()
    fewer = smoothed_scan(path, **settings)
    smoothed_scan.cache_clear()
    assert 500 < len(fewer.x_m) <= 900
    assert f"{len(x)} points averaged over {len(fewer.x_m)} cells" in fewer.scan.notes[-1]
    x_m, y_m, _ = Disc(RADIUS_M).net()
    there = {"x_m": x_m, "y_m": y_m}
    exact = np.sinc(109.8 * np.hypot(x_m, y_m))
    off = np.abs(fewer.profile.amplitude(**there) - exact)
    assert 1e-4 < fewer.averaging_loss < 0.02
    assert np.mean(off <= fewer.averaging_loss + 2 * fewer.standard_error(**there)) > 0.9
    assert summary_of(fewer, noise=0, error=0)["averaging_loss_share"] == fewer.averaging_loss


def test_the_stated_loss_is_that_of_a_profile_without_noise(tmp_path, monkeypatch):
    x, y, u = points(count=200)
    scan = Scan(tmp_path, x / 1e3, y / 1e3, u.astype(complex), np.arange(len(x)), 0, True)
    monkeypatch.setattr(smooth, "MOST_POINTS", 400)
    fewer = smooth.binned(scan)
    assert fewer.y_m is not None
    means = fewer.amplitude_m.real / 1.2
    off = np.abs(means - np.sinc(109.8 * np.hypot(fewer.x_m, fewer.y_m))).max()
    laplacian = 2 / 3 * (np.pi * 109.8) ** 2  # of the sinc at its maximum, in magnitude
    assert off == pytest.approx(fewer.cell_m**2 / 24 * laplacian, rel=0.2)


@pytest.fixture
def measured(repository, tmp_path):
    for name in ("vibrometer.yaml", "vibrometer.csv"):
        (tmp_path / name).write_bytes((repository / "config" / name).read_bytes())
    return tmp_path / "vibrometer.yaml"


def test_a_scan_is_smoothed_once_and_read_as_it_was(measured, tmp_path, monkeypatch, script):
    config = load_config(measured)
    fresh = studies.smoothed_scan_of(config)
    assert fresh is not None
    files = [tmp_path / name for name in ("one.npz", "two.npz")]
    for file in files:
        script("smooth", measured, input={}, output=file)
    assert files[0].read_bytes() == files[1].read_bytes()
    monkeypatch.setenv(studies.SMOOTHED_VARIABLE, str(files[0]))
    monkeypatch.setattr(smooth, "smoothed", None)  # whoever smooths again fails
    smoothed_scan.cache_clear()
    kept = studies.smoothed_scan_of(config)
    assert kept is not None
    for field in fields(fresh):
        if field.name != "scan":
            assert np.array_equal(getattr(kept, field.name), getattr(fresh, field.name)), field.name
    assert kept.profile == fresh.profile
    assert kept.scan.notes == fresh.scan.notes
    assert np.array_equal(kept.scan.amplitude_m, fresh.scan.amplitude_m)
    scan = measured.with_suffix(".csv")
    scan.write_text(scan.read_text().replace("0.0828", "0.0829"))
    with pytest.raises(InputError, match=r"smoothed from another vibrometer\.csv"):
        studies.smoothed_scan_of(config)


def test_a_study_is_checked_and_planned_without_smoothing_its_scan(measured, monkeypatch):
    from squeezefilm.studies.chunks import chunk_counts

    monkeypatch.setattr(smooth, "smoothed", None)
    smoothed_scan.cache_clear()
    for axisymmetric in ("true", "false"):
        text = measured.read_text().replace("axisymmetric: true", f"axisymmetric: {axisymmetric}")
        measured.write_text(text)
        config = studies.check_study(load_config(measured))
        assert chunk_counts(config)["screen"] >= 1
        assert studies.symmetry_of(config).width_deg == (45 if axisymmetric == "true" else 360)
    scan = measured.with_suffix(".csv")
    scan.write_text(scan.read_text().replace("-1.50,-9.75", "-1.50,-10.75"))
    with pytest.raises(InputError, match="line 2: the point lies"):
        studies.check_study(config)
