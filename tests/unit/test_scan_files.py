"""A scan is read as it was exported: whatever its encoding, separator, header and quantities."""

from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import pyuff
import yaml
from scipy.io import savemat

import squeezefilm as sf
from squeezefilm.errors import InputError
from squeezefilm.film.measured.centre import centre_of_symmetry
from squeezefilm.film.measured.read import read_scan
from squeezefilm.film.measured.scan import Scan
from squeezefilm.film.measured.smooth import smoothed_scan_of_file
from squeezefilm.film.profiles import ScanFile
from squeezefilm.film.surfaces import Disc, Rectangle

FREQUENCY_HZ = 43270.0
RADIUS_M = 0.01
FREE_SHAPE = ScanFile("scan.csv")
AXISYMMETRIC = ScanFile("scan.csv", axisymmetric=True)
smoothed_scan = partial(smoothed_scan_of_file, frequency_hz=FREQUENCY_HZ)


def points(count: int = 15, noise: float = 0.0) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """x and y in mm and the signed amplitude in µm, over the disc."""
    line = np.linspace(-9.9, 9.9, count)
    x, y = (values.ravel() for values in np.meshgrid(line, line))
    inside = np.hypot(x, y) < 9.9
    x, y = x[inside], y[inside]
    random = np.random.default_rng(1).standard_normal(len(x))
    return x, y, 1.2 * (np.sinc(0.1098 * np.hypot(x, y)) + noise * random)


X, Y, U = points()


def text(header: str, *columns: np.ndarray, comma: bool = False, separator: str = "") -> str:
    """Rows of cells with semicolons between where commas are decimal."""
    rows = [[f"{value:.9g}" for value in row] for row in zip(*columns, strict=True)]
    if comma:
        rows = [[cell.replace(".", ",") for cell in row] for row in rows]
    between = separator or (";" if comma else ",")
    return "\n".join([header, *(between.join(row) for row in rows)]) + "\n"


PHASE = np.where(U < 0, 180.0, 0.0)
PLAIN = text("x_mm,y_mm,amplitude_um,phase_deg", X, Y, abs(U), PHASE)


def with_header(header: str) -> str:
    return PLAIN.replace("x_mm,y_mm,amplitude_um,phase_deg", header)


def grouped(decimal: str, between: str) -> bytes:
    """Amplitudes in nm as spreadsheets write them, with signs between thousands."""
    numbers = [f"{1e3 * abs(u):,.5f}".translate({44: between, 46: decimal}) for u in U]
    places = [f"{x:.9g};{y:.9g}".replace(".", decimal) for x, y in zip(X, Y, strict=True)]
    rows = [
        f'{place};"{number}";{180 * (u < 0)}'
        for place, number, u in zip(places, numbers, U, strict=True)
    ]
    return "\r\n".join(["sep=;", "X [mm];Y [mm];Amplitude [nm];Phase [°]", *rows]).encode()


def abaqus_report() -> bytes:
    """A header of two lines, and sums below the rows."""
    widths = "{:>16}{:>20}{:>20}{:>20}\n".format
    lines = [
        "Field Output Report, written Sat Nov 28 12:00:00 2026\n\n",
        widths("Node", "COORD.COOR1 [m]", "COORD.COOR2 [m]", "U.U3 [m]"),
        widths("Label", "@Loc 1", "@Loc 1", "@Loc 1"),
        "-" * 72 + "\n",
        *(
            widths(node, f"{x:.9E}", f"{y:.9E}", f"{u:.9E}")
            for node, (x, y, u) in enumerate(zip(X / 1e3, Y / 1e3, U * 1e-6, strict=True))
        ),
        "\n",
        widths("Minimum", *(f"{1e-6 * U.min():.6E}" for _ in range(3))),
        "         At Node               1               2               3\n",
        widths("Total", *(f"{1e-6 * U.sum():.6E}" for _ in range(3))),
    ]
    return "".join(lines).encode()


def abaqus_prints() -> dict[str, bytes]:
    """Tables that Abaqus separates by blanks, with blanks in names: probed values, a .dat file."""
    places = list(enumerate(zip(X / 1e3, Y / 1e3, U * 1e-6, strict=True), start=1))
    parts = [f"   DISC-1 {node:9d} {x:16.8E} {y:16.8E} 0. {u:16.8E}" for node, (x, y, u) in places]
    nodes = [f"{node:8d}       {x:16.8E} {y:16.8E} {u:16.8E}" for node, (x, y, u) in places]
    tables = {
        "Abaqus, probed values": [
            *("Probe Values Report", "Source", "-------", "   Variable: U, U3"),
            "   Part Instance    Node ID     X [m]      Y [m]      Z [m]      U, U3 [m]",
            *("-" * 80, *parts),
        ],
        "Abaqus, blanks between and in names": [
            "Part Instance Node ID X [m] Y [m] Z [m] U, U3 [m]",
            *parts,
        ],
        "Abaqus, printed file": [
            *("   Abaqus 2023", "  THE FOLLOWING TABLE IS PRINTED FOR ALL NODES"),
            *("    NODE FOOT-   COOR1 [m]    COOR2 [m]    U3 [m]", "         NOTE"),
            *(*nodes, "", " MAXIMUM     0.0  0.0  1.0E-06", " AT NODE       1    1     5"),
        ],
    }
    return {name: "\n".join(lines).encode() for name, lines in tables.items()}


TURNED = U * np.exp(0.7j)
SPEED = U * 2 * np.pi * FREQUENCY_HZ * 1e-3  # mm/s
CELLS = {
    "x": X,
    "y": Y,
    "r": np.hypot(X, Y),
    "angle": np.degrees(np.arctan2(Y, X)),
    "number": np.arange(len(X)),
    "zero": 0 * X,
    "drive": 0 * X + FREQUENCY_HZ / 1e3,
    "signed": U,
    "size": abs(U),
    "sign": np.where(U < 0, -1.0, 1.0),
    "phase": PHASE,
    "radians": np.radians(PHASE),
    "real": TURNED.real,
    "imaginary": TURNED.imag,
    "speed": abs(SPEED),
    "speed_real": SPEED * np.cos(0.7),
    "speed_imaginary": SPEED * np.sin(0.7),
    "acceleration": abs(SPEED) * 2 * np.pi * FREQUENCY_HZ / 1e3,
    "level_re_nm": 20 * np.log10(1e3 * abs(U)),
    "level_re_mm_s": 20 * np.log10(abs(SPEED)),
    "level_re_nm_s": 20 * np.log10(1e6 * abs(SPEED)),
}


def listed_form(
    header: str,
    columns: str = "x y size phase",
    separator: str = "",
    decimal: str = ".",
    encoding: str = "utf-8",
) -> bytes:
    """A table of scan_forms.yaml."""
    named = (column.partition("/") for column in columns.split())
    cells = [CELLS[name] / float(over or 1) for name, _, over in named]
    return text(header, *cells, comma=decimal == ",", separator=separator).encode(encoding)


LISTED_FORMS = yaml.safe_load(Path(__file__).with_name("scan_forms.yaml").read_text("utf-8"))
FORMS: dict[str, bytes] = abaqus_prints() | {
    **{name: listed_form(**form) for name, form in LISTED_FORMS.items()},
    "blanks and tabs": PLAIN.replace(",", " ", 1).replace(",", "\t").encode(),
    "blanks, and a quote in a comment": PLAIN.replace(",", " ").encode() + b'# 5" disc, "probe\n',
    "savetxt": b"# x_m y_m uz_m\n"
    + b"".join(
        f"{x / 1e3:.9e} {y / 1e3:.9e} ({u.real:.9e}{u.imag:+.9e}j)\n".encode()
        for x, y, u in zip(X, Y, TURNED * 1e-6, strict=True)
    ),
    "savetxt of older NumPy": b"# x_m y_m uz_m\n"
    + b"".join(
        f"{x / 1e3:.9e} {y / 1e3:.9e} ({u.real:.9e}+{u.imag:.9e}j)\n".encode()
        for x, y, u in zip(X, Y, TURNED * 1e-6, strict=True)
    ),
    "complex cells": (
        "% Length unit,mm\n% x,y,w (µm) @ freq=43270\n"
        + "".join(
            f"{x:.9g},{y:.9g},{u.real:.9g}{u.imag:+.9g}i\n"
            for x, y, u in zip(X, Y, TURNED, strict=True)
        )
    ).encode(),
    "thousands in German": grouped(",", "."),
    "thousands in English": grouped(".", ","),
    "thousands without decimals": "\n".join(
        ["x_mm,y_mm,amplitude_pm,phase_deg"]
        + [
            f'{x:.9g},{y:.9g},"{1e6 * abs(u):,.0f}",{180 * (u < 0)}'
            for x, y, u in zip(X, Y, U, strict=True)
        ]
    ).encode(),
    "thousands in French": grouped(",", "\u202f"),
    "exponents of Fortran": text("x_m,y_m,uz_m", X / 1e3, Y / 1e3, U * 1e-6)
    .replace("e-", "D-")
    .encode(),
    "lines below the rows": f"{PLAIN}\nMean,,0.5,\nEnd of data\n".encode(),
    "Abaqus report": abaqus_report(),
    "LabVIEW": (
        "X_Columns\tNo\n***End_of_Header***\t\nX_Dimension\tTime\tTime\tTime\tTime\n"
        "X0\t0\t0\t0\t0\nX_Value\tX [mm]\tY [mm]\tAmplitude [um]\tPhase [deg]\tComment\n"
        + "".join(
            f"\t{x:.9g}\t{y:.9g}\t{abs(u):.9g}\t{180.0 * (u < 0)}\n"
            for x, y, u in zip(X, Y, U, strict=True)
        )
    ).encode(),
    "signs": b"x_mm,y_mm,amplitude_um,Sign (+/-)\n"
    + "".join(
        f"{x:.9g},{y:.9g},{abs(u):.9g},{'-' if u < 0 else '+'}\n"
        for x, y, u in zip(X, Y, U, strict=True)
    ).encode(),
    "typeset minus signs": text("x_mm,y_mm,amplitude_um", X, Y, U).replace("-", "−").encode(),
    "dashes for minus signs": text("x_mm,y_mm,amplitude_um", X, Y, U).replace("-", "–").encode(),
    "LabVIEW, units above": (
        "***End_of_Header***\t\t\t\t\t\nChannels\t4\t\t\t\t\nY_Unit_Label\tmm\tmm\tµm\tdeg\t\n"
        "X0\t0,0\t0,0\t0,0\t0,0\t\n***End_of_Header***\t\t\t\t\t\n"
        "X_Value\tPos X\tPos Y\tAmplitude\tPhase\tComment\n"
        + "".join(
            f"{at}\t{x:.9f}\t{y:.9f}\t{abs(u):.9f}\t{180.0 * (u < 0)}\n".replace(".", ",")
            for at, (x, y, u) in enumerate(zip(X, Y, U, strict=True))
        )
    ).encode("latin-1"),
    "Markdown": "\n".join(
        [
            "# Scan 3",
            "",
            "| x / mm | y / mm | amplitude / µm | phase / ° |",
            "| --: | :-: | -- | --- |",
        ]
        + [
            f"| {x:.9g} | {y:.9g} | {abs(u):.9g} | {180 * (u < 0)} |"
            for x, y, u in zip(X, Y, U, strict=True)
        ]
    ).encode(),
    "R": "\n".join(
        ['"x_mm" "y_mm" "amplitude_um" "phase_deg"']
        + [
            f'"P{at}" {x:.9g} {y:.9g} {abs(u):.9g} {180 * (u < 0)}'
            for at, (x, y, u) in enumerate(zip(X, Y, U, strict=True))
        ]
    ).encode(),
    "typed by hand": "\n".join(
        ["Disc 3, 43.27 kHz (MH)", "moved by hand", "", "x / mm   y / mm   A / µm   sign"]
        + [
            f"{x:.9g}  {y:.9g}  {abs(u):.9g} ± 0.1  {1 - 2 * (u < 0)}"
            for x, y, u in zip(X, Y, U, strict=True)
        ]
        + ["", "(the edge is hard to measure)"]
    ).encode(),
    "units behind numbers": "\n".join(
        ["x,y,amp,phase"]
        + [
            f"{x:.9g} mm,{y:.9g} mm,{abs(u):.9g} µm,{180.0 * (u < 0)}°"
            for x, y, u in zip(X, Y, U, strict=True)
        ]
    ).encode(),
}


def same(scan: Scan, *, digits: float = 1e-6) -> None:
    """Whether a scan has the points above, but for one phase of all."""
    assert scan.x_m == pytest.approx(X / 1e3, rel=digits, abs=1e-12)
    assert scan.y_m == pytest.approx(Y / 1e3, rel=digits, abs=1e-12)
    one = scan.amplitude_m[np.argmax(np.abs(U))]
    turned = scan.amplitude_m * abs(one) / one
    assert np.abs(turned - U * 1e-6).max() < digits * 1.2e-6
    assert scan.has_phase_or_sign


@pytest.mark.parametrize("form", FORMS)
def test_a_scan_is_read_in_every_form(form, tmp_path):
    path = tmp_path / "scan.csv"
    path.write_bytes(FORMS[form])
    same(read_scan(path, frequency_hz=FREQUENCY_HZ))


def read(path: Path, content: str, **how: Any) -> Scan:
    path.write_text(content, encoding="utf-8")
    return read_scan(path, frequency_hz=FREQUENCY_HZ, **how)


def write(path: Path, content: str) -> Path:
    path.write_text(content, encoding="utf-8")
    return path


def notes(path: Path, content: str) -> str:
    path.write_text(content, encoding="utf-8")
    return "; ".join(read_scan(path, frequency_hz=FREQUENCY_HZ).notes)


def test_what_is_ignored_is_noted(tmp_path):
    path = tmp_path / "scan.txt"
    assert notes(path, PLAIN) == ""
    said = notes(path, FORMS["other columns"].decode())
    assert said == "ignored columns: 'Index', 'z_mm', 'Coherence'"
    assert "'real_um', 'imag_um'" in notes(path, FORMS["both"].decode())
    assert "divided by the angular frequency" in notes(path, FORMS["velocity"].decode())
    last = len(PLAIN.splitlines())
    below = notes(path, FORMS["lines below the rows"].decode())
    assert below == f"2 lines beside the rows ignored (lines {last + 2}, {last + 3})"
    assert "times 1.414" in notes(path, FORMS["effective values"].decode())


LISTED_FAULTS = yaml.safe_load(Path(__file__).with_name("scan_faults.yaml").read_text("utf-8"))
WRONG = {
    name: (with_header(fault["header"]), fault["message"]) for name, fault in LISTED_FAULTS.items()
} | {
    "an unknown column before an empty cell": (
        with_header("x_mm,y_mm,ampltude_um,phase_deg").replace("-", "", 1).replace("1.4", ","),
        "'amplitude_um' is missing; a scan has a row for each point and columns such as x_mm, y_mm,"
        " amplitude_um, phase_deg or r_mm, amplitude_um; the columns are x, y, phase; not "
        "understood: 'ampltude_um'",
    ),
    "a point and a comma": (
        text("x_mm;y_mm;amplitude_um", X, Y, U, comma=True).replace(",", ".", 1),
        "one of them must be the decimal sign",
    ),
    "names between blanks": (
        with_header("X Mess Wert Y Mess Wert Amplitude Phase").replace(",", " "),
        "the header has 8 names between blanks, and the rows below 4 cells; put two blanks between",
    ),
    "more cells than names": (
        PLAIN.replace("y_mm,", "").replace(",", " "),
        "the header has 3 names between blanks, and the rows below 4 cells; name every column",
    ),
    "rows with other separators than the header": (
        PLAIN.replace("x_mm,y_mm", "x_mm;y_mm", 1)
        .replace("_um,", "_um;")
        .replace("y_mm,", "y_mm;"),
        "1 cells where the header has 4; separate the rows' cells as the header's",
    ),
    "a header of words that are not known": (
        "Disc 3, by hand\n" + PLAIN.replace("x_mm,y_mm,amplitude_um,phase_deg", "Q;P;W"),
        "line 2: no header names the columns: 'Q;P;W'",
    ),
    "words in place of a number": (
        PLAIN.replace(",0\n", ",kaputt\n", 1),
        "phase is 'kaputt', not a finite number; write nan as the amplitude of what was not",
    ),
    "a place only in the first row of several": (
        PLAIN.replace(f"\n{X[1]:.9g},", "\n,", 1),
        "x is '', not a finite number; every row needs its place, also where it is that of the row",
    ),
    "an amplitude and its angle in a cell": (
        text("x_mm,y_mm,amplitude_um", X, Y, U).replace("\n", " @ 30\n").replace(" @ 30", "", 1),
        "@ 30', not a finite number; a complex amplitude is written as 1.2-0.3i or (1.2,-0.3)",
    ),
    "a header of unknown words before separators": (
        with_header("Quer r 1;Hoch phi 2;Hub amplitude 3;Takt phase 4").replace(",", ";"),
        "line 1: no header names the columns: 'Quer r 1;Hoch phi 2;",
    ),
    "a phase of the reference that varies": (
        text(
            "x_mm,y_mm,Vib Amplitude [um],Vib Phase [deg],Ref1 Phase [deg]",
            *(X, Y, abs(U), (PHASE + 7.0 * np.arange(len(X))) % 360, 7.0 * np.arange(len(X))),
        ),
        "subtract it from 'Vib Phase [deg]' and leave it out",
    ),
    "a second table": (
        f"first part\n{PLAIN}\nsecond part\n{PLAIN}",
        f"line {len(PLAIN.splitlines()) + 4}: the header stands again: a second table",
    ),
    "columns of many points": (
        text(",".join(["Frequency (Hz)", *(f"P{at} Re (um)" for at in range(9))]), *([X] * 10)),
        "'P4 Re (um)', 'P5 Re (um)', …",
    ),
    "no header": (PLAIN.split("\n", 1)[1], "line 1: no header names the columns"),
    "a matrix with axes": (
        "Amplitude [nm], signed\n\ny \\ x [mm];"
        + "\n".join(
            [";".join(f"{1.25 * at - 5:g}" for at in range(9)).replace(".", ",")]
            + [f"{10 - 2 * at};" + ";".join(["0,5"] * 9) for at in range(11)]
        ),
        "a table of amplitudes with axes; leave out these and words, have x in its rows, ascending,"
        " and the largest y first, and write lines above it: '# Width: 30 mm', '# Height: 20 mm', "
        "'# Value units: um' (the number of values times their step: in the first row 9 × 1.25, in "
        "the first column 11 × 2)",
    ),
    "a matrix": (
        "\n".join(["\t".join(["0.5"] * 20)] * 20),
        "or, of a matrix of amplitudes, lines above it: '# Width: 30 mm', '# Height: 20 mm', ",
    ),
    "positions and amplitudes apart": (
        "[Geometry]\n"
        + text("Node,X,Y", np.arange(len(X)), X, Y)
        + "\n[Shape]\nQuantity:,Acceleration\nDOF,Real,Imag\n"
        + "\n".join(f"disc:{node}:+Z,{u},0" for node, u in enumerate(U)),
        f"the second, 'DOF', 'Real', 'Imag', from line {len(X) + 6} on; write one table, with both "
        "in the row of a point; the columns are x, y, real, imaginary; not understood: 'Node'; and "
        "no unit is known of 'X', 'Y', 'Real', 'Imag'",
    ),
}


@pytest.mark.parametrize(("column", "cell"), [("x", "(1.2"), ("amplitude", "1.2×10^-6")])
def test_a_cell_is_given_no_remedy_of_another(column, cell, tmp_path):
    row = {"x": "1.2", "y": "1", "amplitude": "1"} | {column: cell}
    with pytest.raises(InputError, match=r"not a finite number$"):
        read(tmp_path / "scan.csv", "x_mm,y_mm,amplitude_um\n1,2,3\n" + ",".join(row.values()))


@pytest.mark.parametrize("case", WRONG)
def test_what_cannot_be_read_is_refused_with_a_word(case, tmp_path):
    content, message = WRONG[case]
    path = tmp_path / "scan.csv"
    path.write_text(content, encoding="utf-8")
    with pytest.raises(InputError) as refusal:
        read_scan(path, frequency_hz=FREQUENCY_HZ)
    assert message in str(refusal.value)
    assert "scan.csv: line" in str(refusal.value)


def test_r_of_a_lock_in_amplifier_is_no_place(tmp_path):
    content = with_header("x_mm,y_mm,R (V),Theta (deg)")
    with pytest.raises(InputError, match=r"call 'R \(V\)', 'Theta \(deg\)' of a lock-in"):
        read(tmp_path / "scan.csv", content)


SIGN_LEVEL_STATUS = {
    "English": ("Sign", "Level", "Status"),
    "German": ("Vorzeichen", "Pegel", "Zustand"),
    "French": ("Signe", "Niveau", "État"),
    "Spanish": ("Signo", "Nivel", "Estado"),
    "Italian": ("Segno", "Livello", "Stato"),
    "Portuguese": ("Sinal", "Nível", "Qualidade"),
    "Dutch": ("Teken", "Niveau", "Toestand"),
    "Japanese": ("符号", "レベル", "状態"),
}


@pytest.mark.parametrize("language", SIGN_LEVEL_STATUS)
def test_sign_level_and_status_are_known_in_eight_languages(language, tmp_path):
    """None of them is taken for an amplitude, and the level is not needed beside it."""
    header = "x_mm,y_mm,{1} [dB],amplitude_um,{0},{2}".format(*SIGN_LEVEL_STATUS[language])
    content = text(header, X, Y, X, abs(U), np.sign(U), X**0)
    same(read(tmp_path / "scan.csv", content))
    bare = text(header.replace(" [dB],amplitude_um", ""), X, Y, abs(U), np.sign(U), X**0)
    with pytest.raises(InputError, match=r"write one, as in .* \[dB re 1 um\]"):
        read(tmp_path / "scan.csv", bare)


@pytest.mark.parametrize(
    ("name", "good", "bad"),
    [
        ("Status", "OK", "A/D Overrange"),
        ("Scan Status", "Optimal", "Not Measured"),
        ("Status", "Optimal", "Not Available"),
        ("Zustand", "gültig", "ungültig"),
        ("Valid", "1", "0"),
        ("Overrange", "", "x"),
        ("Judge", "GO", "--"),
        ("Validité", "oui", "non"),
        ("状態", "良", "不良"),
        ("状态", "正常", "超量程"),
        ("vtkValidPointMask", "1", "0"),
    ],
)
def test_rows_that_a_status_calls_invalid_are_excluded(name, good, bad, tmp_path):
    """Rows 3 and 5 have an amplitude a hundred times too large, row 5 a word for it."""
    lines = text("x_mm,y_mm,amplitude_um,sign", X, Y, abs(U), np.sign(U)).splitlines()
    rows = [f"{line},{good}" for line in lines[1:]]
    whole = read(tmp_path / "whole.csv", "\n".join([f"{lines[0]},{name}", *rows]))
    same(whole)
    for at, amplitude in ((3, "100"), (5, "overload")):
        x, y, _, sign, _ = rows[at].split(",")
        rows[at] = f"{x},{y},{amplitude},{sign},{bad}"
    scan = read(tmp_path / "scan.csv", "\n".join([f"{lines[0]},{name}", *rows]))
    assert len(scan.x_m) == len(X) - 2
    assert abs(scan.amplitude_m).max() < 1.3e-6
    (note,) = scan.notes
    assert note.startswith(f"2 rows invalid by column '{name}' (")
    assert note.endswith("2) excluded (lines 5, 7)")


def test_an_unclear_status_is_asked_for(tmp_path):
    lines = PLAIN.splitlines()
    words = ["ok", "doubtful"] + ["ok"] * (len(lines) - 3)
    content = "\n".join([f"{lines[0]},Status", *map(",".join, zip(lines[1:], words, strict=True))])
    with pytest.raises(InputError, match=r"has doubtful \(1 rows\).*rows: Status = ok"):
        read(tmp_path / "scan.csv", content)
    assert len(read(tmp_path / "scan.csv", content, rows="Status = ok").x_m) == len(X) - 1


@pytest.mark.parametrize(
    "form",
    ["{:.9g} {} {:.9g}im", "{:.9g} {} {:.9g}*I", "({:.9g}{}{:.9g}j)", '"({:.9g},{}{:.9g})"'],
)
def test_complex_cells_are_read_as_languages_write_them(form, tmp_path):
    cells = [form.format(u.real, "+-"[u.imag < 0], abs(u.imag)) for u in TURNED.tolist()]
    rows = [f"{x:.9g},{y:.9g},{cell}" for x, y, cell in zip(X, Y, cells, strict=True)]
    same(read(tmp_path / "scan.csv", "\n".join(["x_mm,y_mm,amplitude_um", *rows])))


def test_exponents_of_mathematica_are_read(tmp_path):
    content = text("x_m,y_m,uz_m", X / 1e3, Y / 1e3, U * 1e-6).replace("e-", "*^-")
    same(read(tmp_path / "scan.csv", content))


@pytest.mark.parametrize(
    "header",
    [
        "Pos/mm,Amplitude/µm",
        "% Arc length (mm)      Displacement field, Z component (um)",
        "% Bogenlänge (mm)      Verschiebungsfeld, Z-Komponente (um)",
    ],
)
def test_a_position_alone_is_one_on_a_line(header, tmp_path):
    r = np.linspace(-9.9, 9.9, 41)
    content = text(header, r, np.sinc(0.1098 * r))
    if header.startswith("%"):
        content = header + content.removeprefix(header).replace(",", "      ")
    scan = read(tmp_path / "scan.csv", content)
    assert scan.is_radial
    assert scan.x_m == pytest.approx(r / 1e3)


def test_another_coordinate_that_is_not_understood_is_asked_for(tmp_path):
    content = with_header("x_mm,height_mm,amplitude_um,phase_deg")
    with pytest.raises(InputError, match=r"'height_mm' tells apart.*or call it x, y or phi"):
        read(tmp_path / "scan.csv", content)


@pytest.mark.parametrize("name", ["x_mm", "r_mm", "Y [mm]"])
def test_a_line_across_the_middle_is_an_axisymmetric_shape(name, tmp_path):
    """From one side to the other; a distance below zero is on the other side."""
    path, r = tmp_path / "scan.csv", np.linspace(-9.9, 9.9, 41)
    path.write_text(text(f"{name},displacement_um", r, np.sinc(0.1098 * r)), encoding="utf-8")
    surface = Disc(RADIUS_M)
    profile = smoothed_scan(path, AXISYMMETRIC, surface).profile
    x_m, y_m, _ = surface.net_points_and_weights()
    exact = np.sinc(109.8 * np.hypot(x_m, y_m))
    assert profile.amplitude(x_m=x_m, y_m=y_m) == pytest.approx(exact, abs=2e-3)
    with pytest.raises(InputError, match="axisymmetric: true"):
        smoothed_scan(path, FREE_SHAPE, surface)


def measured_at(name: str, values: list[float], factors: list[float]) -> str:
    """All points once for each value of a column, each time a factor larger."""
    column = np.repeat(values, len(X))
    x, y = (np.tile(each, len(values)) for each in (X, Y))
    u = np.concatenate([factor * U for factor in factors])
    return text(f"{name},x_mm,y_mm,amplitude_um,sign", column, x, y, abs(u), np.sign(u))


def test_of_several_measurements_at_a_place_one_is_asked_for(tmp_path):
    """Scans at 10 and 60 V in one table were fitted together, as one shape."""
    content = measured_at("drive_v", [10, 60], [1, 3])
    with pytest.raises(InputError, match=r"'drive_v' tells apart.*rows: drive_v = 10"):
        read(tmp_path / "scan.csv", content)
    for rows in ("drive_v = 10", "Drive_V=10.0"):
        same(read(tmp_path / "scan.csv", content, rows=rows))
    with pytest.raises(InputError, match=r"no row has this value; it has 10 \(\d+ rows\), 60"):
        read(tmp_path / "scan.csv", content, rows="drive_v = 20")
    with pytest.raises(InputError, match=r"one of 'drive_v'"):
        read(tmp_path / "scan.csv", content, rows="voltage = 10")


def test_of_a_frequency_column_the_rows_at_the_actuators_are_read(tmp_path):
    content = measured_at("Frequency [kHz]", [42.77, 43.27, 43.77], [3, 1, 2])
    scan = read(tmp_path / "scan.csv", content)
    same(scan)
    assert "rows at 43270 Hz in 'Frequency [kHz]'" in scan.notes
    bare = content.replace("Frequency [kHz]", "FREQ")
    assert "rows at 43270 Hz in 'FREQ'" in read(tmp_path / "scan.csv", bare).notes
    for lines in ([30e3], [30e3, 31e3]):
        elsewhere = measured_at("freq_hz", lines, [1] * len(lines))
        with pytest.raises(InputError, match="the actuator vibrates at 43270 Hz"):
            read(tmp_path / "scan.csv", elsewhere)


def test_rows_of_a_mode_are_those_near_the_actuators_frequency(tmp_path):
    """The first mode was proposed, and read without a word on its frequency, 30 % away."""
    random = np.random.default_rng(1).random(len(X))
    for name in ("FREQ", "Frequenz", "f (Hz)"):
        content = measured_at(name, [30e3, 43.2e3], [2, 1])
        mode = np.repeat([5, 6], len(X)).astype(int)
        header, *rows = content.splitlines()
        rows = [f"{number},{row}" for number, row in zip(mode, rows, strict=True)]
        path = tmp_path / "scan.csv"
        same(read(path, "\n".join([f"mode,{header}", *rows])))
        same(read(path, "\n".join([f"mode,{header}", *rows]), rows="mode = 6"))
        with pytest.raises(InputError, match=r"30000 Hz, and the actuator vibrates at 43270 Hz"):
            read(path, "\n".join([f"mode,{header}", *rows]), rows="mode = 5")
    near = text("x_mm,y_mm,FREQ,amplitude_um,phase_deg", X, Y, 0 * X + 42e3, abs(U), PHASE)
    assert "rows at 42000 Hz in 'FREQ'" in read(path, near).notes
    drifting = text("x_mm,y_mm,f_hz,amplitude_um,phase_deg", X, Y, 3e4 + random, abs(U), PHASE)
    with pytest.raises(InputError, match="the actuator vibrates at 43270 Hz"):
        read(path, drifting)
    force = text("x_mm,y_mm,F,amplitude_um,phase_deg", X, Y, 0 * X + 3, abs(U), PHASE)
    with pytest.raises(InputError, match="leave it out if it is no frequency"):
        read(path, force)


def test_cells_that_were_not_measured_are_no_numbers(tmp_path):
    """``n.m.`` was taken for a number with a decimal point."""
    lines = text("x_mm;y_mm;uz_um", X, Y, U, comma=True).splitlines()
    for at, cell in ((3, "n.m."), (9, "n. d."), (20, "o.R.")):
        lines[at] = ";".join([*lines[at].split(";")[:2], cell])
    scan = read(tmp_path / "scan.csv", "\n".join(lines))
    assert (len(scan.x_m), scan.missing_count) == (len(X) - 3, 3)


def test_of_row_names_and_places_on_a_line_none_is_guessed(tmp_path):
    """Places at whole millimetres, and a column without a name: an uncertainty."""
    r = np.arange(1.0, 12.0)
    content = text("r_mm,uz_um", r, np.sinc(r / 9), 0 * r + 0.1)
    with pytest.raises(InputError, match="3 cells where the header has 2"):
        read(tmp_path / "scan.csv", content)
    rows = [
        f"P{at} {x:.9g} {y:.9g} {u:.9g} 0" for at, (x, y, u) in enumerate(zip(X, Y, U, strict=True))
    ]
    with pytest.raises(
        InputError, match="the header has 4 names between blanks, and the rows below 5"
    ):
        read(tmp_path / "scan.csv", "\n".join(["name x_mm y_mm uz_um", *rows]))


def test_too_few_points_are_named_with_what_else_there_is(tmp_path):
    content = "Disc 3\n\nr / mm     A / µm\n0   10,4 ± 0,1\n2   10,3 ± 0,1\n4   9,6\n\n(Rand)\n"
    with pytest.raises(InputError, match=r"3 measured points .*at least 8; .*kind: formula"):
        read(tmp_path / "scan.csv", content)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("$MeshFormat\n2.2 0 8\n", "x_mm, y_mm, uz_mm"),
        (" x-axis,1,2\nsecond,Volt,Volt\n0,1,2\n", "a time series of an oscilloscope"),
        ("X,CH1,Start,Increment,\nSequence,Volt,0,1e-6\n0,1,,\n", "a time series of an osc"),
        ("Time,Channel A\n(us),(V)\n\n0,1\n", "a time series of an oscilloscope"),
        ("LECROYWS3054,12345,Waveform\nTime,Ampl\n0,1\n", "a time series of an oscilloscope"),
        ("TIME,CH1\n0,1\n1,2\n", r"scan.csv: line 1: a time series \('TIME'\) is no shape"),
        ("Zygo XYZ Data File - Format 1\n0 0 1.2\n", "as a table: x_mm, y_mm, amplitude_um"),
        (
            "aBCR-1.0\nManufacID = X\nNumPoints = 9\n*\n1 2\n",
            r"ISO 25178-71.*its first row at the la",
        ),
        ("    1C\n    1UPGM  CalculiX\n", "x_mm, y_mm, uz_mm"),
        ("# vtk DataFile Version 3.0\nmode\nASCII\n", r"add units to its header: Points:0 \[m\]"),
    ],
)
def test_files_of_programs_are_named_with_what_to_write(content, message, tmp_path):
    with pytest.raises(InputError, match=message):
        read(tmp_path / "scan.csv", content)


def test_a_single_frequency_of_columns_is_noted_or_too_far(tmp_path):
    """A mode of a model, some per cent away; at another frequency the shape is another."""
    header = "x_mm,y_mm,w (um) @ freq={}".format
    scan = read(tmp_path / "scan.csv", text(header(44100), X, Y, U))
    same(scan)
    assert "columns at 44100 Hz" in scan.notes
    with pytest.raises(InputError, match=r"at 20110 Hz.*43270 Hz \(actuator.frequency\)"):
        read(tmp_path / "scan.csv", text(header(20110), X, Y, U))


@pytest.mark.parametrize(
    "line",
    [
        "NUMERO D'ORDRE: 7 FREQ: {}E+00",
        "Frequency:\t{} Hz",
        "# Excitation frequency (Hz): {}",
        '"Freq(Hz)","{}"',
        "   Frame: Mode  7: Value =  7.39147E+10 Freq =   {}     (cycles/time)",
    ],
)
def test_the_frequency_above_the_header_is_noted_or_too_far(line, tmp_path):
    """The shape of another mode was read without a word."""
    path = tmp_path / "scan.csv"
    assert read(path, f"{line.format(43270)}\n{PLAIN}").notes[1:] == ()
    assert "read at 42000 Hz" in read(path, f"{line.format(42000)}\n{PLAIN}").notes
    with pytest.raises(InputError, match=r"20110 Hz, and the actuator vibrates at 43270 Hz"):
        read(path, f"{line.format(20110)}\n{PLAIN}")
    for other in ("Demodulation bandwidth (Hz): 100", "Frequency range: 0 - 80 kHz"):
        assert "Hz" not in str(read(path, f"# {other}\n{PLAIN}").notes)


def test_of_tables_one_after_the_other_that_at_the_frequency_is_read(tmp_path):
    """As Code_Aster writes modes; a unit may be written into the first header alone."""
    header, rows = PLAIN.split("\n", 1)
    header = header.replace("x_mm", "x [mm]")
    other = text("", X, Y, 3 * abs(Y), PHASE)
    above = "\n ------>\n NUMERO D'ORDRE: {} FREQ: {}\n\n".format
    content = f"{above(7, 41203)}{header}{other}{above(8, 4.327e4)}{header.replace(' [mm]', '')}\n"
    scan = read(tmp_path / "scan.csv", content + rows)
    same(scan)
    assert "read at 43270 Hz, of tables at 41203, 43270 Hz" in scan.notes


def test_pages_of_one_table_are_joined(tmp_path):
    """A heading on every page, with a title above it, as APDL prints paths."""
    header, *rows = PLAIN.splitlines()
    pages = [[header, *rows[at : at + 50], "", " ***** PATH SUMMARY *****"] for at in (0, 50, 100)]
    pages.append([header, *rows[150:]])
    scan = read(tmp_path / "scan.csv", "\n".join(line for page in pages for line in page))
    same(scan)
    assert scan.notes == (f"{len(pages)} tables with one header joined",)


def test_of_all_nodes_of_a_body_those_of_the_surface_are_asked_for(tmp_path):
    """Nodes inside lie at no place of the surface's, so that no place has two amplitudes."""
    tilt = 1 + 0.1 * X
    same(read(tmp_path / "scan.csv", text("x_mm,y_mm,z_mm,uz_um", X, Y, tilt, U)))
    inside = np.linspace(0, 7, len(X))
    x, y, z = np.r_[X, 0.97 * X], np.r_[Y, 0.97 * Y], np.r_[0 * X + 8, inside]
    content = text("x_mm,y_mm,Z Location,uz_um", x, y, z, np.r_[U, 0.5 * U])
    with pytest.raises(InputError, match=r"heights.*rows: Z Location = 8 or another"):
        read(tmp_path / "scan.csv", content)
    same(read(tmp_path / "scan.csv", content, rows="Z Location = 8"))


def test_a_surface_across_the_plane_of_x_and_y_is_named(tmp_path):
    """An origin was proposed that another message refused."""
    header = "X-Position (mm),Y-Position (mm),Z-Position (mm),Gerichtete Verformung (mm)"
    content = text(header, X, 0 * X + 5, Y, U / 1e3)
    message = r"'Y-Position \(mm\)' is 5 everywhere, and 'Z-.* is not: .*swap the two names"
    with pytest.raises(InputError, match=message):
        read(tmp_path / "scan.csv", content)
    y, z = "Y-Position (mm)", "Z-Position (mm)"
    same(read(tmp_path / "scan.csv", content.replace(f"{y},{z}", f"{z},{y}")))


@pytest.mark.parametrize(
    ("x", "y", "message"),
    [
        (
            np.abs(X),
            np.abs(Y),
            r"as in x \[mm\].* on one side of x = 0 .*axisymmetric: true.*origin",
        ),
        (X + 20, Y + 20, r"as in x \[mm\].* on one side of x = 0 .*axisymmetric: true.*origin"),
        (X, 0 * Y, r"as in x \[mm\].*; and points on a line need .*axisymmetric: true$"),
        (X, Y, r"as in x \[mm\], y \[mm\], uz \[um\]. Lengths are .*wrong\)$"),
    ],
)
def test_units_and_what_the_places_need_are_asked_for_together(x, y, message, tmp_path):
    path = tmp_path / "scan.csv"
    path.write_text(f"{text('x,y,uz', x, y, U)}Total,9,9,9\n")
    with pytest.raises(InputError, match=message):
        smoothed_scan(path, FREE_SHAPE, Disc(RADIUS_M))


UNSIGNED = r".*; and the amplitudes have no phase and no sign.*sign: unknown if .* no node line$"


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (text("x,y,amplitude", X, Y, abs(U)), f"line 1: no unit is known of 'x'{UNSIGNED}"),
        (text("x,y,uz", X, Y, U), r"line 1: no unit is known of 'x'.*wrong\)$"),
        (text("x_mm,y_mm,amplitude_um", X, Y, abs(U)).split("\n", 1)[1], f"no header{UNSIGNED}"),
        (
            text("x_mm,y_mm,uz_um", X, Y, abs(U)).split("\n", 1)[1].replace(",0.", ",-0."),
            r"no header.*r_mm, amplitude_um$",
        ),
        (text("", abs(X), U).strip(), r"no header.*; and points on a line need .*: true$"),
    ],
)
def test_what_a_study_must_say_of_points_is_in_the_first_message(content, message, tmp_path):
    """And nothing that it says already."""
    path = tmp_path / "scan.csv"
    path.write_text(content)
    with pytest.raises(InputError, match=message):
        smoothed_scan(path, FREE_SHAPE, Disc(RADIUS_M))
    with pytest.raises(InputError) as refusal:
        smoothed_scan(path, ScanFile("scan.csv", axisymmetric=True, sign="unknown"), Disc(RADIUS_M))
    assert "actuator.profile" not in str(refusal.value)


def test_an_ignored_column_that_may_be_the_sign_is_named(tmp_path):
    """With `phas_deg` in the header the message was that there is no phase, and no more."""
    path = tmp_path / "scan.csv"
    path.write_text(text("x_mm,y_mm,amplitude_um,phas_deg,run", X, Y, abs(U), 90 * np.sign(U), X))
    with pytest.raises(InputError, match=r"; ignored columns: 'phas_deg', 'run'") as refusal:
        smoothed_scan(path, FREE_SHAPE, Disc(RADIUS_M))
    assert str(refusal.value).endswith("; did you mean phase_deg by 'phas_deg'?")


def test_a_component_beside_a_magnitude_has_its_sign(tmp_path):
    """As ParaView writes vectors; amplitudes, by their name or by a node line, have none."""
    header, raised = '"{0}:2 [um]","{0}:Magnitude","Points:0 [mm]","Points:1 [mm]"', U + 1.5
    rectified = (abs(U), abs(U), X, Y)
    columns = (raised, raised, X, Y)
    path = tmp_path / "scan.csv"
    assert read(path, text(header.format("u"), *columns)).has_phase_or_sign
    assert not read(path, text(header.format("u_amplitude"), *columns)).has_phase_or_sign
    assert not read(path, text(header.format("u"), *rectified)).has_phase_or_sign
    same(read(path, text(header.format("u"), U, *rectified[1:])))


@pytest.mark.parametrize(
    "name",
    [
        *("u:2 [um]", "UZ [um]", "w (um)", "u_z [um]", "displacement:2 [um]", "W[um]"),
        *("Directional Deformation (um)", "Richtungsverformung (um)", "v_z [mm/s]"),
    ],
)
def test_a_component_of_one_sign_has_its_sign(name, tmp_path):
    """The face of a horn was refused; near a node line, and of few points, it still is."""
    path, raised = tmp_path / "scan.csv", U + 1.5
    scan = read(path, text(f"x_mm,y_mm,{name}", X, Y, raised))
    assert scan.has_phase_or_sign
    assert scan.amplitude_m.real.min() > 0
    assert any("a component, has one sign everywhere" in note for note in scan.notes)
    assert not read(path, text(f"x_mm,y_mm,{name}", X, Y, abs(U))).has_phase_or_sign
    few = text(f"x_mm,y_mm,{name}", X[:60], Y[:60], raised[:60])
    assert not read(path, few).has_phase_or_sign


@pytest.mark.parametrize(
    "name",
    [
        *("amplitude_um", "uAmpZ (um)", "Amplitude Z [um]", "abs(w) (um)", "UZ RMS [um]"),
        *("UZ [um pk]", "UZ [um p-p]", "displacement_um", "UZ [dB re 1 um]"),
    ],
)
def test_an_amplitude_of_one_sign_is_in_doubt(name, tmp_path):
    content = text(f"x_mm,y_mm,{name}", X, Y, U + 1.5)
    with pytest.raises(InputError, match="no phase and no sign"):
        smoothed_scan(write(tmp_path / "scan.csv", content), FREE_SHAPE, Disc(RADIUS_M))


def test_sides_of_a_surface_are_told_by_no_amplitude_below_zero(tmp_path):
    path = write(tmp_path / "scan.csv", text("x_mm,y_mm,displacement_um", X, Y, U + 1.5))
    said = smoothed_scan(path, ScanFile("scan.csv", sign="unknown"), Disc(RADIUS_M)).warnings
    assert any("has no phase and no amplitude below zero" in note for note in said)


def test_displacements_in_the_plane_are_no_places(tmp_path):
    """u_x and u_y were, so that they were twice."""
    content = text("x_mm,y_mm,u_x [um],u_y [um],u_z [um]", X, Y, 0 * X + 3, 0 * X, U)
    same(read(tmp_path / "scan.csv", content))


def test_of_rows_along_each_axis_those_along_the_normal_are_suggested(tmp_path):
    """The first, along x, was: a motion in the plane had a force."""
    path = tmp_path / "scan.csv"
    rows = [
        f"{direction},{x:.9g},{y:.9g},{u:.9g}"
        for x, y, motion in zip(X, Y, U, strict=True)
        for direction, u in (("+X", 3), ("+Y", 2), ("+Z", motion))
    ]
    content = "\n".join(["Direction,x_mm,y_mm,Displacement [um]", *rows])
    with pytest.raises(InputError, match=r"by actuator.profile.rows: Direction = \+Z$"):
        read(path, content)
    same(normal := read(path, content, rows="Direction = +Z"))
    assert not any("plane" in note for note in normal.notes)
    aside = read(path, content, rows="Direction = +x")
    assert any("'Direction = +x' is a motion in the plane" in note for note in aside.notes)
    with pytest.raises(InputError, match="none is along z"):
        read(path, "\n".join(line for line in content.splitlines() if "+Z" not in line))


def labview(names: str, unit_line: str = "", first: str = "") -> str:
    """LabVIEW's file with its own first column empty."""
    cells = (f"{first}\t{x:.9g}\t{y:.9g}\t{u:.9g}\n" for x, y, u in zip(X, Y, U, strict=True))
    head = "X_Columns\tNo\n***End_of_Header***\n" + unit_line
    return f"{head}X_Dimension\tTime\tTime\tTime\n***End_of_Header***\nX_Value\t{names}\n" + (
        "".join(cells)
    )


def test_the_first_column_of_labview_is_no_place(tmp_path):
    """X_Value was asked for its unit where places were not understood."""
    path = tmp_path / "scan.lvm"
    units = "Y_Unit_Label\tmm\tmm\tum\n"
    same(read(path, labview("Tisch X\tTisch Y\tAmplitude", units)))
    same(read(path, labview("Tisch X [mm]\tTisch Y [mm]\tAmplitude [um]", first="0.1")))
    message = r"'X_Value', 'Qx X .*; call 'Qx X \[mm\]', 'Qy Y \[mm\]' x_mm, y_mm if the place$"
    with pytest.raises(InputError, match=message):
        read(path, labview("Qx X\tQy Y\tAmplitude", units))
    with pytest.raises(InputError, match=r"call 'LaserX_mm_' x_mm if the place"):
        read(path, text("LaserX_mm_,uz_um", X, U))


def test_names_that_matlab_joins_are_read(tmp_path):
    same(read(tmp_path / "scan.csv", with_header("StageX_mm_,StageY_mm_,Amp_um_,Phase_deg_")))


@pytest.mark.parametrize(
    "name",
    [
        "Level (dB re 1e-9 m/s, RMS)",
        "Level (dB re 1e-9 m/s RMS)",
        "Velocity level (dB re 1e-9 m/s, RMS)",
    ],
)
def test_decibels_of_effective_values_are_read(name, tmp_path):
    level = CELLS["level_re_nm_s"] - 20 * np.log10(np.sqrt(2))
    same(
        read(
            tmp_path / "scan.csv",
            text(f"x_mm;y_mm;{name};phase_deg", X, Y, level, PHASE, separator=";"),
        )
    )


def test_a_value_is_proposed_before_a_coordinate(tmp_path):
    """Z-Position was to be called the amplitude."""
    content = text("x_mm,y_mm,Z-Position (mm),Ausschlag (mm)", X, Y, 0 * X + 5, U)
    with pytest.raises(InputError, match=r"call 'Ausschlag \(mm\)' amplitude_um") as refusal:
        read(tmp_path / "scan.csv", content)
    assert "call 'Z-Position" not in str(refusal.value)


OCTAVE = "# Created by Octave 8.4.0\n# name: xyw\n# type: matrix\n# rows: 9\n# columns: 3\n"


def test_a_matrix_of_octave_needs_names(tmp_path):
    """It was called several variables, and refused with names, too."""
    path, names, rows = tmp_path / "scan.txt", "x_mm y_mm uz_um", text("", X, Y, U, separator=" ")
    with pytest.raises(InputError, match="one matrix without names; add a line above its numbers"):
        read(path, OCTAVE + rows[1:])
    same(read(path, OCTAVE + names + rows))
    with pytest.raises(InputError, match="variables that Octave saved, one below the other"):
        read(path, OCTAVE.replace("columns: 3", "columns: 1") + "1\n2\n")


@pytest.mark.parametrize("others", [[], [41.2]])
def test_a_frequency_without_its_unit_is_asked_for_it(others, tmp_path):
    names = [f"w (um) @ freq={each}" for each in [43.27, *others]]
    content = text(",".join(["x_mm", "y_mm", *names]), X, Y, *([U] * len(names)))
    with pytest.raises(InputError, match=r"write the unit: @ freq=43\.27 kHz$"):
        read(tmp_path / "scan.csv", content)


def test_rows_that_vic_3d_did_not_correlate_are_excluded(tmp_path):
    sigma = np.where(np.arange(len(X)) % 7 == 3, -1.0, 0.012)
    names, w = "X[mm],Y[mm],W[mm],sigma[pixel]", np.where(sigma < 0, 0, U / 1e3)
    scan = read(tmp_path / "scan.csv", text(names, X, Y, w, sigma))
    assert len(scan.x_m) == (sigma > 0).sum()
    assert f"{(sigma < 0).sum()} rows invalid by column 'sigma[pixel]'" in "; ".join(scan.notes)
    stress = read(tmp_path / "scan.csv", text("x_mm,y_mm,uz_um,sigma", X, Y, U, -2 + 0 * X))
    same(stress)


def test_a_matrix_with_its_size_is_read(tmp_path):
    """Gwyddion's: cells, the first row at the top; one without a size is asked for it."""
    columns, rows = 30, 20
    x_mm, y_mm = (np.arange(columns) + 0.5) * 0.6, 8 - (np.arange(rows) + 0.5) * 0.4
    matrix = 1 + x_mm / 10 - y_mm[:, None] / 20
    body = "\n".join("\t".join(f"{1e-6 * u:.9e}" for u in row) for row in matrix)
    path = tmp_path / "scan.txt"
    sizes = "# Channel: Amplitude\n# Width: 18.0 mm\n# Height: 0.8 cm\n# Value units: m\n"
    scan = read(path, sizes + body)
    assert scan.x_m == pytest.approx(np.tile(x_mm, rows) / 1e3)
    assert scan.y_m == pytest.approx(np.repeat(y_mm, columns) / 1e3)
    assert scan.amplitude_m.real == pytest.approx(1e-6 * matrix.ravel())
    assert "20 × 30 values is read at the middles of its cells" in scan.notes[0]
    with pytest.raises(InputError, match=r"the unit 'px' of 'x \[px\]' is not known"):
        read(path, sizes.replace("18.0 mm", "30 px") + body)
    with pytest.raises(InputError, match="no header names the columns"):
        read(path, sizes.replace("18.0 mm", "18.0. mm") + body)
    with pytest.raises(InputError, match="variables that Octave saved"):
        read(path, "# Created by Octave 8.4.0, Mon Mar 11\n# name: xy_mm\n 0 0\n")


@pytest.mark.parametrize("part", ["column", "row"])
def test_a_matrix_with_its_axis_is_refused(part, tmp_path):
    """The axis was read as amplitudes."""
    random = np.random.default_rng(1)
    matrix = 400 * np.cos(np.arange(31) / 4) + 5 * random.standard_normal((25, 31))
    axis = np.linspace(-12, 12, 25 if part == "column" else 31)
    matrix = np.column_stack([axis, matrix]) if part == "column" else np.vstack([axis, matrix])
    body = "\n".join("\t".join(f"{u:.2f}" for u in row) for row in matrix)
    sizes = "# Width: 31 mm\n# Height: 25 mm\n# Value units: nm\n"
    with pytest.raises(InputError, match=f"the first {part} of the matrix, -1.*has even steps"):
        read(tmp_path / "scan.txt", sizes + body)


def test_cells_tell_a_status_whose_name_is_not_known(tmp_path):
    states = np.where(np.arange(len(X)) == 4, "Ungültig", "Optimal")
    rows = zip(PLAIN.splitlines(), ["Messung", *states], strict=True)
    content = "\n".join(map(",".join, rows))
    path = tmp_path / "scan.csv"
    assert notes(path, content) == (
        "1 row invalid by column 'Messung' (Ungültig 1) excluded (line 6)"
    )
    assert "column 'Messung' is not used, and has Ungültig; if these rows are invalid" in notes(
        path, content.replace("Optimal", "3b")
    )


def test_few_directions_are_told(tmp_path):
    """Twelve rays give modes of no more than five nodal diameters."""
    r, degrees = (each.ravel() for each in np.meshgrid(np.arange(1, 11), np.arange(0, 360, 30)))
    amplitude = np.sinc(0.1098 * r) + 0.01 * np.random.default_rng(1).standard_normal(len(r))
    path = tmp_path / "scan.csv"
    path.write_text(text("r_mm,phi_deg,amplitude_um", r, degrees, amplitude), encoding="utf-8")
    told = "12 directions are too few for modes above degree 5; scan more, or say actuator.profile."
    assert told in "".join(smoothed_scan(path, FREE_SHAPE, Disc(RADIUS_M)).warnings)
    assert told not in "".join(smoothed_scan(path, AXISYMMETRIC, Disc(RADIUS_M)).warnings)


def test_points_rounded_beyond_the_edge_are_on_it(tmp_path):
    """By their coordinates' last digit; others name the size with which they are on it."""
    path, surface = tmp_path / "scan.csv", Disc(RADIUS_M)
    angles = 2 * np.pi * np.arange(90) / 90
    x, y = np.append(X, 10 * np.cos(angles)), np.append(Y, 10 * np.sin(angles))

    def smooth(scale: float, digits: int, surface: Disc | Rectangle = surface) -> tuple[str, ...]:
        at = (np.round(scale * each, digits) for each in (x, y))
        path.write_text(text("x_mm,y_mm,amplitude_um", *at, np.sinc(0.1098 * np.hypot(x, y))))
        return smoothed_scan(path, FREE_SHAPE, surface).warnings

    assert smooth(1.0, 9) == ()
    for digits in (1, 4):
        assert (
            "µm beyond the edge (actuator.surface_radius) are taken for" in smooth(1.0, digits)[0]
        )
    with pytest.raises(InputError, match=r"ends there, say actuator.surface_radius: 10.2001 mm$"):
        smooth(1.02, 4)
    assert "are taken for rounded ones" in smooth(1.02, 4, Disc(10.2e-3))[0]
    with pytest.raises(
        InputError,
        match=r"there, say actuator.surface: \{shape: rectangle, len.*x: "
        r"20.4 mm, length_y: 22 mm\}$",
    ):
        smooth(1.02, 4, Rectangle(0.02, 0.022))


def test_a_line_along_a_plate_is_its_shape_where_that_is_the_same_across(tmp_path):
    """Along x or y, with the wave where the scan has it; a shape that varies across is doubted."""
    path, plate = tmp_path / "scan.csv", Rectangle(0.09, 0.03)
    along = np.linspace(0, 90, 61)
    noise = 0.01 * np.random.default_rng(1).standard_normal((2, 61))
    wave = 1.9 * (np.cos(np.pi * along / 30 + 0.4) + noise[0] + 1j * noise[1])
    content = text("Position [mm],real_um,imag_um", along, wave.real, wave.imag)
    path.write_text(content)
    origin_m = (0.045, 0.0)
    scan = smoothed_scan(path, ScanFile("scan.csv", along="x", origin_m=origin_m), plate)
    x_m, y_m, _ = plate.net_points_and_weights()
    found = scan.profile.amplitude(x_m=x_m, y_m=y_m)
    exact = np.cos(np.pi * (x_m + 0.045) / 0.03 + 0.4)
    assert np.ptp(found, axis=1).max() < 1e-12
    assert np.sign(np.sum(found * exact)) * found == pytest.approx(exact, abs=0.03)
    with pytest.raises(InputError, match=r"do not lie along y .*; name their column y"):
        smoothed_scan(path, ScanFile("scan.csv", along="y", origin_m=origin_m), plate)
    path.write_text(content.replace("Position", "y"))
    turned = smoothed_scan(
        path, ScanFile("scan.csv", along="y", origin_m=(0.0, 0.045)), Rectangle(0.03, 0.09)
    )
    values = turned.profile.amplitude(x_m=y_m, y_m=x_m)
    assert values == pytest.approx(found, abs=1e-6)
    x, y = (each.ravel() for each in np.meshgrid(np.linspace(-45, 45, 61), np.linspace(-15, 15, 7)))
    path.write_text(text("x_mm,y_mm,uz_um", x, y, np.cos(np.pi * x / 30) * (1 + y / 40)))
    warned = smoothed_scan(path, ScanFile("scan.csv", along="x"), plate).warnings
    assert "varies across too" in warned[-1]
    with pytest.raises(InputError, match=r"profile.along: is of a rectangle; a disc has axisymm"):
        sf.Film.of(
            actuator={
                "frequency": FREQUENCY_HZ,
                "surface_radius": RADIUS_M,
                "profile": {"kind": "measured", "file": str(path), "along": "x"},
            },
            pad={"length_x": "4 mm", "length_y": "4 mm"},
        )


def test_points_on_an_axis_are_a_line_and_its_wants_are_told_together(tmp_path):
    path, r = tmp_path / "scan.csv", np.linspace(40, 60, 101)
    path.write_text(text("x_mm,y_mm,uz_um", r, 0 * r, np.sinc(0.1098 * (r - 50))))
    wants = r"axisymmetric: true; and line 102: .*origin: \[50 mm, 0 mm\], the middle"
    with pytest.raises(InputError, match=wants):
        smoothed_scan(path, FREE_SHAPE, Disc(RADIUS_M))
    marked = with_header("x_mm,y_mm,amplitude_um,phase_deg") + "1,1,-99.9999,0\n"
    with pytest.raises(InputError, match=r"negative .* marks an invalid row, write nan"):
        read(path, marked)


def test_zeros_of_points_not_measured_are_named(tmp_path):
    path, zeros = tmp_path / "scan.csv", np.random.default_rng(2).random(len(X)) < 0.15
    path.write_text(text("x_mm,y_mm,uz_um", X, Y, np.where(zeros, 0, U)), encoding="utf-8")
    with pytest.raises(InputError, match=r"amplitude is 0; write nan where nothing was"):
        smoothed_scan(path, AXISYMMETRIC, Disc(RADIUS_M))


def test_what_a_part_of_a_surface_lacks_is_named(tmp_path):
    """A quarter of a model, and a line along a plate."""
    path, part = tmp_path / "scan.csv", (X >= 0) & (Y <= 0)
    path.write_text(text("x_mm,y_mm,uz_um", X[part], Y[part], U[part]), encoding="utf-8")
    with pytest.raises(InputError, match=r"of a half or a quarter.*axisymmetric: true"):
        smoothed_scan(path, FREE_SHAPE, Disc(RADIUS_M))
    plate = Rectangle(2 * RADIUS_M, RADIUS_M)
    path.write_text(text("x_mm,uz_um", X, U), encoding="utf-8")
    with pytest.raises(InputError, match=r"line.*across it.*profile.along: x \(or y") as refusal:
        smoothed_scan(path, FREE_SHAPE, plate)
    assert "wavelength" not in str(refusal.value)  # which the file does not say


def test_a_time_series_is_no_shape_and_a_repeated_scan_is_one(tmp_path):
    """Each place at twelve instants; and each twice, with the time of day at each row."""
    instants = [float(each) for each in range(12)]
    content = measured_at("time_us", instants, [float(np.cos(each)) for each in instants])
    with pytest.raises(InputError, match=r"'time_us' has several instants.*no shape"):
        read(tmp_path / "scan.csv", content)
    header, *rows = measured_at("time", [0, 0], [1, 1]).splitlines()
    timed = [row.replace("0,", f"{at},", 1) for at, row in enumerate(rows)]
    assert len(read(tmp_path / "scan.csv", "\n".join([header, *timed])).x_m) == 2 * len(X)


def universal(path: Path, *, unit: float = 1.0, damaged: float = 1.0, **changes: object) -> Path:
    """A universal file of the points, at three frequencies, and function 70 times a factor."""
    file = pyuff.UFF(str(path))
    nodes = np.arange(1, len(X) + 1)
    sets: list[dict[str, Any]] = [
        pyuff.prepare_164(
            units_code=5,
            units_description="mm",
            temp_mode=1,
            length=1000.0,  # millimetres
            force=1.0,
            temp=1.0,
            temp_offset=273.15,
            return_full_dict=True,
        ),
        pyuff.prepare_15(nodes, 0 * nodes, 0 * nodes, 0 * nodes, X, Y, 0 * X, True),
    ]
    for node, value in zip(nodes, TURNED, strict=True):
        size = 1e-6 * unit * (damaged if node == 70 else 1)
        function = {
            "binary": 0,
            "func_type": 4,
            "rsp_node": int(node),
            "rsp_dir": 3,
            "ref_node": 1,
            "ref_dir": 3,
            "data": np.array([0.1, 1.0, 0.3]) * value * size,
            "x": FREQUENCY_HZ + np.array([-400.0, 30.0, 460.0]),
            "id1": "scan",
            "rsp_ent_name": "p",
            "ref_ent_name": "p",
            "abscissa_spacing": 1,
            "abscissa_spec_data_type": 18,
            "ordinate_spec_data_type": 8,
            "orddenom_spec_data_type": 0,
        }
        sets.append(pyuff.prepare_58(**function | changes))
    file.write_sets(sets, mode="overwrite")
    return path


def test_a_universal_file_is_read_at_the_frequency(tmp_path):
    same(read_scan(universal(tmp_path / "scan.uff"), frequency_hz=FREQUENCY_HZ), digits=1e-4)
    omega = 2 * np.pi * FREQUENCY_HZ
    path = universal(tmp_path / "speed.unv", unit=omega, ordinate_spec_data_type=11)
    scan = read_scan(path, frequency_hz=FREQUENCY_HZ)
    same(scan, digits=1e-4)
    assert scan.notes == ("read at 43300 Hz",)
    along_x = universal(tmp_path / "x.unv", rsp_dir=1).read_text().split("    -1\n")
    path.write_text(path.read_text() + "    -1\n".join(["", *along_x[5:]]))
    scan = read_scan(path, frequency_hz=FREQUENCY_HZ)
    same(scan, digits=1e-4)
    assert scan.notes[0] == f"{len(X)} functions along x or y ignored"


def test_of_several_references_one_is_asked_for(tmp_path):
    """Each node has a response to a shaker at node 1, and one to another at node 5."""
    path, other = universal(tmp_path / "scan.unv"), tmp_path / "other.unv"
    functions = universal(other, unit=3.0, ref_node=5, ref_dir=-3).read_text().split("    -1\n")
    path.write_text(path.read_text() + "    -1\n".join(["", *functions[5:]]))
    count = len(X)
    message = rf"references are 1\+Z \({count} functions\), 5-Z .*rows: reference = 1\+Z"
    with pytest.raises(InputError, match=message):
        read_scan(path, frequency_hz=FREQUENCY_HZ)
    for rows in ("reference = 1", "Reference=1+Z"):
        same(read_scan(path, frequency_hz=FREQUENCY_HZ, rows=rows), digits=1e-4)
    with pytest.raises(InputError, match=r"'2' is not one of them: its references are 1\+Z"):
        read_scan(path, frequency_hz=FREQUENCY_HZ, rows="reference = 2")


def test_a_hammer_that_roves_over_the_points_measures_their_shape(tmp_path):
    """One accelerometer, at node 1, and a reference for each node: the same by reciprocity."""
    path = universal(tmp_path / "scan.unv", rsp_node=1, rsp_dir=-3)
    first, *others = path.read_text().split("p         1   3")
    roving = [f"p{node:10d}   3{rest}" for node, rest in enumerate(others, start=1)]
    scan = read_scan(write(path, "".join([first, *roving])), frequency_hz=FREQUENCY_HZ)
    same(scan, digits=1e-4)
    assert scan.notes[0] == "one response: a shape over the references, by reciprocity"


def test_only_what_is_needed_of_a_universal_file_is_read(tmp_path):
    """A coherence beside each response, and a set that no reader understands, were errors."""
    path = universal(tmp_path / "scan.unv")
    beside = universal(tmp_path / "beside.unv", func_type=6, ordinate_spec_data_type=0)
    functions = beside.read_text().split("    -1\n")
    path.write_text(path.read_text() + "    -1\n".join(["", *functions[5:]]))
    with path.open("a") as file:
        file.write("    -1\n  2414\n         1\nbad\n    -1\n")
    scan = read_scan(path, frequency_hz=FREQUENCY_HZ)
    same(scan, digits=1e-4)
    assert f"{len(X)} coherences ignored" in scan.notes
    with path.open("a") as file:
        file.write("    -1\n    58\nbad\n    -1\n")
    with pytest.raises(InputError, match=r"set \d+ \(data set 58\)"):
        read_scan(path, frequency_hz=FREQUENCY_HZ)


def with_modes(path: Path, shapes: dict[float, np.ndarray], **changes: Any) -> Path:
    """A universal file of the points and mode shapes (data set 55) by their frequencies."""
    points_alone = universal(path).read_text().split("    -1\n")[:4]
    path.write_text("    -1\n".join(points_alone) + "    -1\n")
    for number, (frequency_hz, shape) in enumerate(shapes.items(), start=1):
        mode = {
            "model_type": 1,
            "analysis_type": 2,
            "data_ch": 2,
            "spec_data_type": 8,
            **{f"id{line}": "NONE" for line in range(1, 6)},
            "r1": 0 * shape,
            "r2": 0 * shape,
            "r3": shape,
            "node_nums": np.arange(1, len(X) + 1),
            "n_data_per_node": 3,
            "load_case": 1,
            "mode_n": number,
            "freq": frequency_hz,
            "data_type": 5 if np.iscomplexobj(shape) else 2,
        }
        pyuff.UFF(str(path)).write_sets([pyuff.prepare_55(**mode | changes)], mode="add")
    return path


def test_the_mode_shape_at_the_frequency_is_read(tmp_path):
    path = with_modes(tmp_path / "modes.unv", {30e3: X, 43.1e3: U * 1e-6, 52e3: Y})
    scan = read_scan(path, frequency_hz=FREQUENCY_HZ)
    same(scan, digits=1e-4)
    assert scan.notes == ("mode shape 2 at 43100 Hz along z",)
    harmonic = {"analysis_type": 5, "freq_step_n": 1}
    path = with_modes(tmp_path / "shape.unv", {FREQUENCY_HZ: TURNED * 1e-6}, **harmonic)
    same(read_scan(path, frequency_hz=FREQUENCY_HZ), digits=1e-4)


def results_at_nodes(path: Path, motion: np.ndarray, analysis: int) -> Path:
    """A universal file of the points and results (data set 2414), as FE programs write them."""
    points_alone = universal(path).read_text().split("    -1\n")[:4]
    parts = np.stack([motion.real, motion.imag] if np.iscomplexobj(motion) else [motion], axis=1)
    along_x_and_y = [0.0] * 2 * parts.shape[1]

    def integers(*values: int) -> str:
        return "".join(f"{value:10d}" for value in values)

    def reals(*values: float) -> str:
        return "".join(f"{value:13.5E}" for value in values)

    lines = [
        *("    -1", "  2414", integers(1), "DISPLACEMENT", integers(1), *["NONE"] * 5),
        integers(1, analysis, 3, 8, 5 if np.iscomplexobj(motion) else 2, 3),
        integers(0, 0, 1, 0, 1, 2, 0, 0),
        integers(0, 0),
        reals(0, FREQUENCY_HZ, 0, 0, 0, 0),
        reals(0, 0, 0, 0, 0, 0),
    ]
    for node, row in enumerate(parts, start=1):
        lines += [integers(node), reals(*along_x_and_y, *row)]
    path.write_text("    -1\n".join(points_alone) + "    -1\n" + "\n".join([*lines, "    -1", ""]))
    return path


@pytest.mark.parametrize(("motion", "analysis"), [(U, 2), (TURNED, 3), (TURNED, 5)])
def test_results_at_nodes_are_a_shape(motion, analysis, tmp_path):
    """A normal mode, a complex mode, a frequency response."""
    path = results_at_nodes(tmp_path / "results.unv", motion * 1e-6, analysis)
    scan = read_scan(path, frequency_hz=FREQUENCY_HZ)
    same(scan, digits=1e-4)
    assert "at 43270 Hz along z" in scan.notes[0]


def test_of_modes_that_may_be_meant_one_is_asked_for(tmp_path):
    path = with_modes(tmp_path / "modes.unv", {43.1e3: U * 1e-6, 43.5e3: Y, 52e3: X})
    with pytest.raises(InputError, match=r"several are near 43270 Hz.*rows: mode = 1"):
        read_scan(path, frequency_hz=FREQUENCY_HZ)
    same(read_scan(path, frequency_hz=FREQUENCY_HZ, rows="mode = 1"), digits=1e-4)
    with pytest.raises(InputError, match=r"2 at 43500 Hz, 3 at 52000 Hz: none is at 20000 Hz"):
        read_scan(path, frequency_hz=20e3)


@pytest.mark.parametrize("ending", [".mat", ".npz", ".npy"])
def test_named_arrays_are_a_table(ending, tmp_path):
    path, columns = tmp_path / f"scan{ending}", {"x_mm": X, "y_mm": Y, "amplitude_um": TURNED}
    if ending == ".mat":
        savemat(path, columns)
    elif ending == ".npz":
        np.savez(path, **columns)
    else:
        np.save(path, np.rec.fromarrays(list(columns.values()), names=list(columns)))
    same(read_scan(path, frequency_hz=FREQUENCY_HZ))


def test_rows_of_arrays_are_counted_without_their_names(tmp_path):
    measured = np.where(np.arange(len(X)) == 4, np.nan, U)
    savemat(tmp_path / "scan.mat", {"x_mm": X, "y_mm": Y, "uz_um": measured})
    scan = read_scan(tmp_path / "scan.mat", frequency_hz=FREQUENCY_HZ)
    assert scan.notes[-1].endswith("(row 5)")


@pytest.mark.parametrize(
    ("name", "start", "message"),
    [
        ("scan.xlsx", b"PK\x03\x04", "save a spreadsheet as CSV"),
        ("scan.svd", b"\xd0\xcf\x11\xe0", "as universal file or as text"),
        ("scan.mat", b"MATLAB 7.3 MAT-file".ljust(124) + b"\x00\x02IM", "'-v7'"),
        ("scan.npy", b"", "the arrays cannot be read"),
        ("scan.bin", bytes(200), "no table of text"),
        ("scan.vtu", b"<?xml version='1.0'?>", "as CSV .in ParaView"),
        ("scan.vtk", b"# vtk DataFile Version 3.0\n", "as CSV .in ParaView"),
        ("disc.pch", b"$SUBTITLE=DISC\n$LABEL   = \n", "Nastran.*as a universal file"),
        ("disc.f06", b"1\n   N A S T R A N\n", "Nastran.*x, y and T3, with units"),
        ("plate.f06", b"1  PLATE\n   R E A L   E I G E N V E C T O R   N O .", "Nastran.*T3"),
        ("disc.lis", b" LIST ALL SELECTED NODES.   DSYS=      0\n", "ANSYS.*Node Location"),
        ("disc.lis", b"\n PRINT U    NODAL SOLUTION PER NODE\n", "ANSYS.*Node Location"),
        ("plate.dat", b"\n displacements (vx,vy,vz) for set N and time  0.\n", "CalculiX.*uz_mm"),
        ("scan.txt", b"x_mm y_mm w_um\n\n   1.0e-03 *\n\n", "as MATLAB displays it.*writetable"),
        ("scan.json", b'[\n {"x_mm": 1.0,', "write the points as CSV"),
        ("scan.dat", b'VARIABLES = "X", "Y"\n1 2\n', "Tecplot.*such as x_mm y_mm amplitude_um"),
        ("scan.itx", b"IGOR\rWAVES/D x_mm\r", "save the waves as delimited text"),
        ("grid.txt", b"% Model: disc.mph\n% Grid\n1 2 3\n", "data format Spreadsheet"),
        ("scan.tdms", b"TDSm", "as text .* or CSV"),
        ("scan.opju", b"CPYUA 4.3", "from Origin as text or CSV"),
    ],
)
def test_a_file_that_is_no_table_is_named_with_what_to_export(name, start, message, tmp_path):
    (tmp_path / name).write_bytes(start + bytes(range(256)) * 4)
    with pytest.raises(InputError, match=message):
        read_scan(tmp_path / name, frequency_hz=FREQUENCY_HZ)


def test_a_scan_that_misses_its_surface_is_told_where_it_would_fit(tmp_path):
    """Coordinates from elsewhere, or in another unit than the header's."""
    path, surface = tmp_path / "scan.csv", Disc(RADIUS_M)
    path.write_text(text("x_mm,y_mm,amplitude_um", X + 100, Y - 20, U))
    with pytest.raises(InputError, match=r"all lie on it with .*origin: \[100 mm, -20 mm\]"):
        smoothed_scan(path, FREE_SHAPE, surface)
    same(read_scan(path, frequency_hz=FREQUENCY_HZ, origin_m=(0.1, -0.02)))
    path.write_text(text("x_m,y_m,amplitude_um", X, Y, U))
    with pytest.raises(InputError, match="positions 1000 times smaller"):
        smoothed_scan(path, AXISYMMETRIC, surface)
    path.write_text(text("x_mm,y_mm,amplitude_um", X / 1e3, Y / 1e3, U))
    with pytest.raises(InputError, match=r"at the centre.*positions 1000 times larger"):
        smoothed_scan(path, ScanFile("scan.csv", scale="measured"), surface)
    path.write_text(text("x_mm,y_mm,amplitude_um", X + 10, 2 * Y + 20, U))
    with pytest.raises(InputError, match=r"off the .*; they fit with x and y exchanged$"):
        smoothed_scan(path, FREE_SHAPE, Rectangle(0.04, 0.02))


def off_centre_grid(step: float, offset: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A grid that is not about the disc's centre, which is at 12.5 mm, 11 mm."""
    line = np.arange(-12 + offset, 12, step)
    x, y = (values.ravel() for values in np.meshgrid(line, line))
    x, y = x[(inside := np.hypot(x, y) < 9.9)], y[inside]
    noise = 0.01 * np.random.default_rng(1).standard_normal(len(x))
    return x + 12.5, y + 11, np.sinc(0.1098 * np.hypot(x, y)) + noise


def test_the_centre_that_is_proposed_is_the_shapes_own(tmp_path):
    """The middle of the extents misses it by up to half a step: the force was 8 % too large."""
    path, surface = tmp_path / "scan.csv", Disc(RADIUS_M)
    x, y, u = off_centre_grid(0.9, 0.35)
    path.write_text(text("x_mm,y_mm,amplitude_um", x, y, u))
    with pytest.raises(InputError, match="symmetric") as refusal:
        smoothed_scan(path, FREE_SHAPE, surface)
    _, _, origin = str(refusal.value).partition("origin: [")
    named = [float(each.removesuffix("mm")) for each in origin.partition("]")[0].split(",")]
    assert named == pytest.approx([12.5, 11], abs=0.03)
    origin_m = (named[0] / 1e3, named[1] / 1e3)
    scan = smoothed_scan(path, ScanFile("scan.csv", origin_m=origin_m), surface)
    assert not scan.warnings
    wrong = smoothed_scan(path, ScanFile("scan.csv", origin_m=(12.4e-3, 10.9e-3)), surface)
    assert "0.14 mm from actuator.profile.origin" in wrong.warnings[0]


def test_waves_along_lines_tell_no_centre():
    """Their shape is symmetric about every point of a crest, whatever noise makes of it."""
    lines_m = np.meshgrid(np.arange(-28, 28.1, 2) / 1e3, np.arange(-18, 18.1, 2) / 1e3)
    x_m, y_m = (each.ravel() for each in lines_m)
    plate = Rectangle(0.06, 0.04)
    orders = plate.orders_up_to(12)
    for seed in range(4):
        noise = 0.04 * np.random.default_rng(seed).standard_normal(len(x_m))
        u = np.cos(2 * np.pi * (x_m + 0.3 * y_m) / 0.024 + 0.7) + noise
        assert centre_of_symmetry(x_m, y_m, u, plate, orders) is None


def test_an_origin_that_is_proposed_puts_all_points_on_the_surface(tmp_path):
    """The same origin was proposed again when it was obeyed: points are off it everywhere."""
    path = tmp_path / "scan.csv"
    path.write_text(text("x_mm,y_mm,amplitude_um", 1.07 * X + 30, 1.07 * Y, U))
    with pytest.raises(InputError, match=r"about .* \[30 mm, 0 mm\], they reach beyond it by 1.5%"):
        smoothed_scan(path, FREE_SHAPE, Disc(RADIUS_M))
    noise = np.random.default_rng(1).standard_normal(len(X))
    path.write_text(text("x_mm,y_mm,amplitude_um", 0.95 * X + 30, 0.95 * Y, U + noise))
    with pytest.raises(InputError, match=r"middle of their extents, which may be 1.9 mm off"):
        smoothed_scan(path, FREE_SHAPE, Disc(RADIUS_M))


def test_accelerations_are_divided_by_the_angular_frequency_twice(tmp_path):
    factor = -((2 * np.pi * FREQUENCY_HZ) ** 2)
    path = universal(tmp_path / "scan.unv", unit=factor, ordinate_spec_data_type=12)
    scan = read_scan(path, frequency_hz=FREQUENCY_HZ)
    same(scan, digits=1e-4)
    assert scan.amplitude_m == pytest.approx(TURNED * 1e-6, rel=1e-4)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"func_type": 1, "abscissa_spec_data_type": 17}, "a function of time"),
        ({"ordinate_spec_data_type": 13}, "not all displacements"),
    ],
)
def test_a_universal_file_that_says_something_else_is_refused(tmp_path, changes, message):
    path = universal(tmp_path / "scan.uff", **changes)
    with pytest.raises(InputError, match=rf"scan\.uff: .*{message}"):
        read_scan(path, frequency_hz=FREQUENCY_HZ)


@pytest.mark.parametrize(
    "nothing", ["nan", "", "nan+nanj", "NaN + NaNi", "-nan(ind)", "#WERT!", "missing"]
)
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
        found.append(smoothed_scan(path, FREE_SHAPE, Disc(RADIUS_M)))
    gaps, rest = found
    assert gaps.noise_m == rest.noise_m
    assert gaps.profile.coefficients == rest.profile.coefficients
    said = "2 points without an amplitude, excluded from profile and noise (lines 12, 31)"
    assert gaps.warnings == (f"note: {said}",)
    assert rest.warnings == ()


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_a_function_without_an_amplitude_is_named_and_excluded(tmp_path, value):
    """Pyuff writes NaN as zeros and infinity as the largest number: both were read as such."""

    path = universal(tmp_path / "scan.uff", damaged=value)
    scan = read_scan(path, frequency_hz=FREQUENCY_HZ)
    said = "1 point without an amplitude, excluded from profile and noise (function 70)"
    assert scan.notes[-1] == said
    assert (scan.missing_count, len(scan.x_m)) == (1, len(X) - 1)
    assert np.abs(scan.amplitude_m).max() < 1.3e-6


def test_a_scan_that_was_replaced_is_read_again(tmp_path):
    """In one session of Python the force stayed that of the old file."""
    path = tmp_path / "scan.csv"
    profile = {"kind": "measured", "file": str(path)}
    film = sf.Film.of(
        actuator={"frequency": FREQUENCY_HZ, "surface_radius": RADIUS_M, "profile": profile},
        pad={"length_x": "4 mm", "length_y": "4 mm"},
    )
    path.write_text(text("x_mm,y_mm,amplitude_um", X, Y, U))
    first = film.scan
    assert film.scan is first
    path.write_text(text("x_mm,y_mm,amplitude_um", X, Y, 2 * U))
    assert film.scan.peak_m == pytest.approx(2 * first.peak_m)
    path.unlink()
    with pytest.raises(InputError, match="there is no such scan"):
        assert film.scan
