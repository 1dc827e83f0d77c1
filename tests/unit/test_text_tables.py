"""Tables of kinds that nobody told us of are read by what they have in common, or asked about."""

import html
import json

import numpy as np
import pandas as pd
import pytest

from squeezefilm.errors import InputError
from squeezefilm.film.measured.read import read_scan
from squeezefilm.tables import read_measurements, read_scenes

X_MM, Y_MM = (
    each.ravel() for each in np.meshgrid(np.linspace(-18, 18, 7), np.linspace(-12, 12, 5))
)
SIGNED_UM = np.round(1.5 * np.cos(0.15 * X_MM) * (1 + 0.02 * Y_MM), 4)
SCAN = pd.DataFrame(
    {
        "x_mm": X_MM,
        "y_mm": Y_MM,
        "amplitude_um": abs(SIGNED_UM),
        "phase_deg": np.where(SIGNED_UM < 0, 180.0, 0.0),
    }
)
SPOKEN = ["x [mm]", "y [mm]", "amplitude [µm]", "phase [°]"]


def lines(header: str, between: str, start: str = "", end: str = "", comma: bool = False) -> str:
    rows = [[f"{value:.6g}" for value in row] for row in SCAN.to_numpy()]
    texts = [start + between.join(row) + end for row in rows]
    return "\n".join([header, *(text.replace(".", ",") if comma else text for text in texts)])


def rule(sign: str) -> str:
    return "+" + "+".join([14 * sign] * 4) + "+"


def tags(name: str, cells: list[str]) -> str:
    return "<tr>" + "".join(f"<{name}>{html.escape(cell)}</{name}>" for cell in cells) + "</tr>"


FORMS: dict[str, str | bytes] = {
    "a database": f"{rule('-')}\n"
    + lines(f"| {' | '.join(SPOKEN)} |\n{rule('=')}", " | ", "| ", " |")
    + f"\n{rule('-')}\n(35 rows)\n",
    "bars alone": lines("|".join(SPOKEN), "|"),
    "LaTeX": lines(
        "\\begin{tabular}{rrrr}\n\\toprule\n"
        "$x$ (mm) & $y$ (mm) & Amplitude ($\\mu$m) & Phase ($^\\circ$) \\\\\n\\midrule",
        " & ",
        end=" \\\\ \\hline",
    )
    + "\n\\end{tabular}\n",
    "a frame in a terminal": lines(
        "│ x_mm │ y_mm │ amplitude_um │ phase_deg │\n├──┼──┼──┼──┤", " │ "
    ),
    "HTML": "<table>"
    + tags("th", SPOKEN)
    + "\n".join(tags("td", [f"{cell:g}" for cell in row]) for row in SCAN.to_numpy())
    + "</table>",
    "records": SCAN.set_axis(SPOKEN, axis=1).to_json(orient="records"),
    "a record in each line": SCAN.to_json(orient="records", lines=True),
    "lists": json.dumps([list(SCAN), *SCAN.to_numpy().tolist()]),
    "Mathematica": "{"
    + lines('{"x_mm", "y_mm", "amplitude_um", "phase_deg"},', ", ", "{", "*^0},").rstrip(",")
    + "}",
    "Fortran": lines("! x [mm]  y [mm]  amplitude [um]  phase [deg]", "D+00  ", end=".D0"),
    "a title above a comment": lines("Plate 3, today\n# x_mm y_mm amplitude_um phase_deg", " "),
    "units above the names": lines("mm;mm;µm;°\nx;y;Amplitude;Phase", ";", comma=True),
    "prepositions": lines("x in mm\ty in mm\tamplitude in µm\tphase in degrees", "\t"),
    "Polish": lines(
        "Położenie X [mm];Położenie Y [mm];Amplituda drgań [µm];Faza [°]", ";", comma=True
    ).encode("cp1250"),
    "Russian": lines("X, мм;Y, мм;Амплитуда, мкм;Фаза, град", ";", comma=True).encode("cp1251"),
    "Korean": lines("X 좌표 (mm),Y 좌표 (mm),진폭 (μm),위상 (도)", ",").encode("cp949"),
    "Swedish": lines("x-läge [mm];y-läge [mm];utböjning [µm];fas [grader]", ";", comma=True),
}


@pytest.mark.parametrize("form", FORMS)
def test_a_scan_of_a_new_kind_is_read(form, tmp_path):
    content = FORMS[form]
    path = tmp_path / "scan.txt"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    scan = read_scan(path, frequency_hz=43270.0)
    assert [1e3 * scan.x_m, 1e3 * scan.y_m] == [pytest.approx(X_MM), pytest.approx(Y_MM)]
    assert 1e6 * scan.amplitude_m == pytest.approx(SIGNED_UM, abs=1e-9)


AMBIGUOUS = {
    "thousands between quotes": ('h0 [nm],hv [nm]\n"5,000","1,000"\n', "5.000 or 5000? Write 5000"),
    "thousands with points": ("h0 [nm];hv [nm]\n5.000;1.000\n6.000;500\n", "5.000 or 5000?"),
    "a point beside commas": (
        "h0 [nm];hv [nm]\n5012,5;1.000\n",
        "line 2: hv [nm] has a point in '1.000', and line 2: h0 [nm] a comma in '5012,5'",
    ),
    "an uncertainty in a cell": (
        "h0_um,hv_um\n5±0.1,1\n",
        "cells of 'h0_um' have uncertainties behind ±; delete these",
    ),
    "rows that are columns": ("h0_um,5,6,7\nhv_um,1,1,1\n", "line 1: no header names the columns"),
    "no header": ("5e-6,1e-6\n6e-6,1e-6\n", "line 1: no header names the columns: '5e-6,1e-6'"),
    "a unit in some cells": (
        "h0,hv\n5 um,1 um\n6 um,900\n",
        "line 3: hv [um] is '900', and '1 um'",
    ),
    "another unit in a cell": ("h0,hv\n5 um,1 um\n6 um,900 nm\n", "is '900 nm', and '1 um' above"),
}


@pytest.mark.parametrize("case", AMBIGUOUS)
def test_what_may_be_read_in_two_ways_is_asked(case, tmp_path):
    text, message = AMBIGUOUS[case]
    path = tmp_path / "scenes.csv"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError) as refusal:
        read_scenes(path)
    assert message in str(refusal.value)


def test_thousands_of_a_scan_are_asked(tmp_path):
    """1.031 beside 716 was 1.031 nm."""
    path = tmp_path / "scan.csv"
    rows = "\n".join(f"{x:g};{1000 * u:,.0f};0" for x, u in zip(X_MM, SIGNED_UM, strict=True))
    path.write_text("x [mm];Amplitude [nm];Phase [°]\n" + rows.replace(",", "."), encoding="utf-8")
    with pytest.raises(InputError, match="between thousands"):
        read_scan(path, frequency_hz=43270.0)


@pytest.mark.parametrize("name", ["u(F)/mN", "± [mN]", "force uncertainty (k=2) [mN]", "SD [mN]"])
def test_the_unit_tells_which_column_may_be_meant(name, tmp_path):
    path = tmp_path / "measured.csv"
    path.write_text(f"h0 [µm];hv [µm];force [mN];{name}\n5;1;10;1\n", encoding="utf-8")
    with pytest.raises(InputError, match=r"mean 'force_uncertainty_mn', the standard one\?"):
        read_measurements(path)


def test_a_quote_that_does_not_end_hides_no_row(tmp_path):
    path = tmp_path / "scenes.csv"
    path.write_text('point_id,h0_um,hv_um\n"a,5,1\nb,6,1\n', encoding="utf-8")
    with pytest.raises(InputError, match="line 2: 1 cells where the header has 3"):
        read_scenes(path)


def test_a_load_cell_and_cells_with_uncertainties_are_told_at_once(tmp_path):
    path = tmp_path / "measured.csv"
    path.write_text(
        "h0 [µm];hv [µm];Load cell [mN];Std load cell [mN]\n5 ± 0.1;1;10 ± 1;1\n", encoding="utf-8"
    )
    with pytest.raises(InputError) as refusal:
        read_measurements(path)
    assert "'Load cell [mN]' (did you mean 'force_mn'?)" in str(refusal.value)
    assert "(did you mean 'force_uncertainty_mn', the standard one?)" in str(refusal.value)
    assert (
        "cells of 'h0 [µm]', 'Load cell [mN]' have uncertainties behind ±; write standard ones "
        "into columns of their own" in str(refusal.value)
    )


def test_scenes_have_inches_as_scans_have(tmp_path):
    path = tmp_path / "scenes.csv"
    path.write_text(
        "Gap (mil),Amplitude 0-pk (µin),x [in],y_inch\n0.2,80,0.05,0.04\n", encoding="utf-8"
    )
    row = read_scenes(path).iloc[0]
    expected = [5.08e-6, 2.032e-6, 1.27e-3, 1.016e-3]
    assert row[["h0_m", "hv_m", "x_m", "y_m"]].tolist() == pytest.approx(expected)
    path.write_text(lines("x [in],y [in],amplitude [uin],phase [°]", ","), encoding="utf-8")
    scan = read_scan(path, frequency_hz=43270.0)
    assert scan.x_m == pytest.approx(X_MM * 0.0254)
    assert scan.amplitude_m == pytest.approx(SIGNED_UM * 25.4e-9)


@pytest.mark.parametrize("row", ["| 5 | 1 |  |", "|5|1||"])
def test_an_empty_cell_between_bars_is_a_cell(row, tmp_path):
    """The row had 2 cells where the header has 3, or the header was judged by its blanks."""
    path = tmp_path / "scenes.md"
    rows = ["Rig, 13 May", "", "| gap h0 [µm] | hv [µm] | y [µm] |", "|---:|---:|---|", row]
    path.write_text("\n".join([*rows, "| 5 | 2 | 100 |"]), encoding="utf-8")
    with pytest.raises(InputError, match=r"line 5: y .* is '', not a finite number"):
        read_scenes(path)
