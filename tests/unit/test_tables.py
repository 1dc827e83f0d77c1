"""A table is read as it is written, or refused with a message that names the file and the place."""

import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from squeezefilm.columns import COLUMNS
from squeezefilm.errors import InputError
from squeezefilm.files import read_json
from squeezefilm.table_writer import table_writer, write_table
from squeezefilm.tables import (
    FORCE_COLUMNS,
    SCENE_COLUMNS,
    read_columns,
    read_forces,
    read_ok_forces,
    read_scenes,
)
from squeezefilm.units import quantity_and_unit_of_column, unit_size

HEADER = ",".join(SCENE_COLUMNS)


@pytest.fixture
def scenes(tmp_path):
    def write(text: str | bytes) -> Path:
        path = tmp_path / "scenes.csv"
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return path

    return write


GERMAN = "point_id;Spalt h0 [µm];Amplitude [µm];phi_r_m;phi_deg\n1;5,0;1,0;0,0;0,0\n"


@pytest.mark.parametrize(
    "text",
    [
        b"\xef\xbb\xbf" + f"{HEADER}\n1,5e-6,1e-6,0,0\n".encode(),
        f"{HEADER}\r\n1,5e-6,1e-6,0,0\r\n",
        f"\n{HEADER}\n\n1,5e-6,1e-6,0,0\n\n\n",
        f"{HEADER}\n1,5e-6,1e-6,0,0",
        f'{HEADER}\n"1","5e-6","1e-6",0,"0"\n',
        " point_id , h0_m,hv_m,phi_r_m,phi_deg\n 1, 5e-6 ,1e-6,0,0\n",
        "phi_deg,phi_r_m,hv_m,h0_m,point_id\n0,0,1e-6,5e-6,1\n",
        "point_id;h0 [µm];hv [µm];phi_r_m;phi_deg\n1;5,0;1;0,0;0\n;;;;\n",
        f"{HEADER}\n1,5e-6,1e-6,0,0\n".replace(",", "\t"),
        f"{HEADER},force_n,status\n1,5e-6,1e-6,0,0,,not converged\n",
        f"# scenes, of today\n{HEADER}\n#,a, b\n1,5e-6,1e-6,0,0\n# end\n",
        f"# {HEADER}\n1,5e-6,1e-6,0,0\n",
        "point_id;h0;hv;phi_r;phi\n;[µm];µm;(mm);°\n1;5,0;1;0;0\n",
        f"Scenes of today; the gap, by hand\n\n{HEADER}\n1,5e-6,1e-6,0,0\n",
        "sep=;\npoint_id;h0 [µm];hv [µm];phi_r_m;phi_deg\n1;5,0;1;0,0;0\n",
        f"# {HEADER}\n1,5e-6,1e-6,0,0\n".replace(",", " "),
        f"  {HEADER}  \n 1,5e-6, 1e-6 , 0, 0 \n".replace(",", "  "),
        f"{HEADER},,\n1,5e-6,1e-6,0,0,,\n",
        "point_id,h_0 [µm],vibration amplitude [µm],phi_r_m,phi_deg\n1,5,1,0,0\n",
        GERMAN.encode("cp1252"),
        f"% {HEADER}\n1 5e-6 1e-6 0 0\n".replace(",", " "),
        f"{HEADER}\n1,5e-6,1e-6,0,0\n".replace("point_id", ""),
        GERMAN.replace(";", "\t").encode("utf-16"),
        "point_id,ギャップ(μm),振幅(μm),phi_r_m,phi_deg\n1,5,1,0,0\n".encode("cp932"),
        "point_id,h0,hv_m,phi_r_m,phi_deg\n1,5 um,1e-6 m,0 m,0\n",
        "|point_id|h0_um|hv_um|phi_r_m|phi_deg|\n|--|--:|--:|--:|--:|\n| 1 | 5 | 1 | 0 | 0 |\n",
    ],
    ids=[
        *("byte order mark", "CRLF", "blank lines", "no last newline", "quotes", "spaces", "order"),
        *("semicolons and decimal commas", "tabs", "results"),
        *("comments", "a header that is a comment", "a line of units", "a title", "sep="),
        *("savetxt", "columns of text", "empty columns", "words of README"),
        *(
            "Excel in German",
            "MATLAB's comment",
            "an index of pandas",
            "its Unicode text",
            "in Japanese",
            "units behind numbers",
            "Markdown",
        ),
    ],
)
def test_what_does_not_matter_is_accepted(text, scenes):
    table = read_scenes(scenes(text))
    assert table.to_dict("records") == [
        {"point_id": "1", "h0_m": 5e-6, "hv_m": 1e-6, "phi_r_m": 0.0, "phi_deg": 0.0}
    ]


@pytest.mark.parametrize("header", ["h0_um,hv_um", "H0 [µm],hv (um)", "h0/µm,Disp. ampl. [µm]"])
def test_factors_have_any_unit_and_a_pad_without_position_is_centred(header, scenes):
    table = read_scenes(scenes(f"point_id,{header}\n1,5,1\n"))
    assert table.loc[0, list(table)[1:]].tolist() == [5e-6, 1e-6, 0.0, 0.0]
    assert list(table) == ["point_id", "h0_m", "hv_m", "x_m", "y_m"]
    turned = read_scenes(scenes("point_id,h0_m,hv_m,phi_r_mm,phi [rad]\n1,5e-6,1e-6,2,1\n"))
    assert turned.loc[0, ["phi_r_m", "phi_deg"]].tolist() == [0.002, 57.2957795130823]


@pytest.mark.parametrize("beside", ["", ",x_mm", ",y_m", ",phi_r_m", ",force_n"])
def test_gap_and_amplitude_are_enough(beside, scenes):
    """Rows are called by their line, and a coordinate that is not there is zero."""
    value = ",0" * bool(beside)
    table = read_scenes(scenes(f"h0_m,hv_m{beside}\n5e-6,1e-6{value}\n\n6e-6,1e-6{value}\n"))
    assert table["point_id"].tolist() == ["line 2", "line 4"]
    assert table["h0_m"].tolist() == [5e-6, 6e-6]
    assert table.iloc[:, 3:].to_numpy().tolist() == [[0.0, 0.0], [0.0, 0.0]]


ROW = "1,5e-6,1e-6,0,0"
WRONG = {
    "nothing": ("", "the table is empty"),
    "a missing column": ("point_id,h0_m\n1,5e-6\n", "column 'hv_m' is missing"),
    "a short row": (f"{HEADER}\n{ROW}\n2,5e-6\n", "line 3: 2 cells where the header has 5"),
    "no rows": (HEADER + "\n", "the table has a header and no rows"),
    "a wrong column, and so a missing one": (
        "point_id,h0_m,hv\n1,5e-6,1e-6\n",
        "column 'hv' needs",
    ),
    "a column that no table has": (
        "h0_m,hv_m,z_mm\n5e-6,1e-6,1\n",
        "unknown column 'z_mm'; the table needs h0_m, hv_m; it may have point_id, a position "
        "(phi_r_m and phi_deg, or x_m and y_m)",
    ),
    "a direction alone": ("h0_m,hv_m,phi_deg\n5e-6,1e-6,1\n", "column 'phi_r_m' is missing"),
    "two decimal signs": (
        "h0_m;hv_m\n5e-6;0.000001\n5e-6;0,000001\n",
        "line 2: hv_m has a point in '0.000001', and line 3: hv_m a comma in '0,000001'",
    ),
    "a column twice": ("h0_m,hv_m,h0_m\n5e-6,1e-6,5e-6\n", "column 'h0_m' stands twice"),
    "two positions": (f"{HEADER},x_m,y_m\n{ROW},0,0\n", "unknown column 'x_m'; a position is"),
    "text for a number": (f"{HEADER}\n1,5um,1e-6,0,0\n", "line 2: h0_m is '5um'"),
    "text in another unit": ("point_id,h0_um,hv_m\n1,5 nm,1e-6\n", "line 2: h0_um is '5 nm'"),
    "what begins as a column does": (
        "gap_um,amp_um\n5,1\n",
        "'amp_um' (did you mean 'hv_um', zero",
    ),
    "several unknown columns": (
        "Nr.;Film h0 (µm);Amplitude hv pk-pk (µm);x\n1;5;2;0\n",
        "unknown column 'Nr.'; unknown column 'Film h0 (µm)' (did you mean 'h0_um'?); unknown "
        "column 'Amplitude hv pk-pk (µm)' (did you mean 'hv_um', zero to peak, half of peak to "
        "peak?); column 'x' needs a unit, one of x_m",
    ),
    "unknown names below a title with commas": (
        "Logger, catman 5.2\nTest: cell, sonotrode 7, 43.27 kHz\n\n"
        "Time;Gap laser [µm];û / µm (0-pk)\n10:31;5.00;2.00\n",
        "unknown column 'Time'; unknown column 'Gap laser [µm]' (did you mean 'h0_um'?); unknown "
        "column 'û / µm (0-pk)' (did you mean 'hv_um', zero to peak?); the table needs h0_m, hv_m",
    ),
    "an unknown column and uncertainties": (
        "h0_um,Hub [µm]\n5 +/- 0.1,1\n",
        "'Hub [µm]' (did you mean 'hv_um', zero to peak?); cells of 'h0_um' have uncertainties "
        "behind ±; delete these; the table needs",
    ),
    "infinity": (f"{HEADER}\n1,5e-6,1e-6,0,-inf\n", "line 2: phi_deg is '-inf'"),
    "a name twice": (f"{HEADER}\n{ROW}\n\n{ROW}\n", "line 4: point_id '1' stands in line 2"),
    "a spreadsheet": (b"PK\3\4", "scenes.csv: no table of text; save a spreadsheet as CSV"),
    "blanks within names and cells": ("h0 um hv um\n5 2\n", "4 names between blanks"),
    "a binary file": (bytes(range(256)), "scenes.csv"),
}


@pytest.mark.parametrize("case", WRONG)
def test_a_wrong_table_is_refused(case, scenes):
    text, message = WRONG[case]
    with pytest.raises(InputError) as refusal:
        read_scenes(scenes(text))
    assert message in str(refusal.value)
    assert "scenes.csv" in str(refusal.value)


def forces(**changes: object) -> pd.DataFrame:
    row: dict[str, object] = dict.fromkeys(FORCE_COLUMNS, 0) | {"point_id": "1", "status": "ok"}
    return pd.DataFrame([row, {**row, "point_id": "2", **changes}])


@pytest.mark.parametrize(
    ("rows", "lines"),
    [
        ("5,2,0\nabc,2,0\n5,,0\n5,2,0", (3, 4)),
        ("5,2,0\n5,abc,0\n-5,2,0", (3, 4)),
        ("5,2,0\n-5,2,0\n5,7,0\n5,2,20", (3, 4, 5)),
        ("5,2\n5,2,0\n5,2,0,1", (2, 4)),
    ],
)
def test_all_invalid_rows_are_named_at_once(rows, lines, tmp_path, refused):
    path = tmp_path / "scenes.csv"
    path.write_text(f"h0_um,hv_um,x_mm\n{rows}\n", encoding="utf-8")
    message = refused("simulate", path, "--output", tmp_path / "forces.csv")
    told = message.removeprefix("squeezefilm: error: ").splitlines()
    assert [line.split(": ")[0] for line in told] == [str(path)] * len(lines)
    assert [int(line.split("line ")[1].split(":")[0]) for line in told] == [*lines]


def test_parquet_without_its_package_ends_before_anything_is_solved(monkeypatch, tmp_path, refused):
    """Forces of points were solved first, and lost."""
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    monkeypatch.setattr("squeezefilm.cli.film.film_of_options", pytest.fail)
    words = ["simulate", "--h0=5um", "--hv=1um,2um", "--output", tmp_path / "curve.parquet"]
    assert "needs pyarrow: pip install 'squeezefilm[parquet]'" in refused(*words)


def test_of_many_invalid_rows_the_first_are_named_and_the_rest_counted(scenes):
    with pytest.raises(InputError, match=r"line 21: .*\nand 30 more$"):
        read_scenes(scenes("h0_m,hv_m\n" + 50 * "x,1e-6\n"))


@pytest.mark.parametrize("suffix", ["csv", "parquet"])
@pytest.mark.parametrize("pieces", [1, 2])
def test_a_table_comes_back_to_the_last_bit_in_how_many_pieces_it_was_written(
    tmp_path, suffix, pieces
):
    force = np.random.default_rng(1).standard_normal(2) * 1e-3
    table = forces(point_id="a b").assign(force_n=force, nx=[16, 24])
    if pieces == 1:
        write_table(table, tmp_path / f"forces.{suffix}")
    else:
        with table_writer(tmp_path / f"forces.{suffix}") as write:
            for row in range(2):
                write(table.iloc[row : row + 1])
    read = read_ok_forces(tmp_path / f"forces.{suffix}")
    for name in ("point_id", "status", "h0_m", "force_n"):
        assert list(read[name]) == list(table[name])
    assert list(read["nx"].astype(int)) == [16, 24]


def test_a_point_that_failed_keeps_its_row_but_cannot_be_used(tmp_path):
    write_table(forces(status="did not converge", force_n=None), tmp_path / "forces.csv")
    table = read_forces(tmp_path / "forces.csv")
    assert list(table["status"]) == ["ok", "did not converge"]
    assert np.isnan(table["force_n"].iloc[1])
    with pytest.raises(InputError, match="point 2: did not converge"):
        read_ok_forces(tmp_path / "forces.csv")
    write_table(forces(force_n=None), tmp_path / "forces.csv")
    with pytest.raises(InputError, match="point 2: force_n is not a finite number"):
        read_forces(tmp_path / "forces.csv")


@pytest.mark.parametrize("text", ["", "{", "[1]", "3", '{"a": 1', "\x00"])
def test_a_wrong_json_file_is_refused(text, tmp_path):
    (tmp_path / "fit.json").write_text(text)
    with pytest.raises(InputError, match=r"fit\.json"):
        read_json(tmp_path / "fit.json")


def test_a_wrong_parquet_table_is_refused(tmp_path):
    table = forces()[list(SCENE_COLUMNS)].astype({"h0_m": float, "hv_m": float})
    table.assign(hv_m=[1e-6, np.nan]).to_parquet(tmp_path / "scenes.parquet")
    with pytest.raises(InputError, match="row 2: hv_m is nan"):
        read_scenes(tmp_path / "scenes.parquet")
    table.assign(hv_m=[True, False]).to_parquet(tmp_path / "scenes.parquet")
    with pytest.raises(InputError, match="row 1: hv_m is True, not a finite number"):
        read_scenes(tmp_path / "scenes.parquet")


def test_a_column_has_one_meaning_and_the_unit_of_its_name(tmp_path, repository):
    lines = (repository / "workflow/squeezefilm/columns.csv").read_text("utf-8").splitlines()
    assert len({each.name for each in COLUMNS.values() if each.meaning}) == len(lines) - 1 > 300
    for each in COLUMNS.values():
        assert (
            quantity_and_unit_of_column(each.name)[1] in ("", each.unit) or each.unit == "text"
        ), each
        assert not each.shown_unit or unit_size(each.shown_unit, of=each.unit) > 0, each
    table = pd.DataFrame({"h0_m": [5e-6], "guess_n": [1.0]})
    with pytest.raises(ValueError, match="no guess_n"):
        write_table(table, tmp_path / "table.csv")


def test_a_table_that_cannot_be_written_is_refused_before_anything_is_solved(tmp_path, refused):
    (tmp_path / "file").touch()
    output = f"--output={tmp_path}/file/forces.csv"
    assert f"{tmp_path}/file is no folder" in refused("simulate", "--h0=5um", "--hv=1um", output)


def test_a_row_of_words_with_a_unit_among_them_is_no_line_of_units(tmp_path) -> None:
    path = tmp_path / "claims.csv"
    path.write_text("claim_id,claim,unit,verdict\nspace,the experimental space,µm,agrees\n")
    table = read_columns(path, columns=("claim_id", "claim", "unit", "verdict"))
    assert table["unit"].tolist() == ["µm"]
