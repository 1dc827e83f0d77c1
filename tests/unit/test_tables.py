"""A table is read as it is written, or refused with a message that names the file and the place."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from squeezefilm.errors import InputError
from squeezefilm.tables import (
    FORCE_COLUMNS,
    SCENE_COLUMNS,
    read_columns,
    read_forces,
    read_json,
    read_ok_forces,
    read_scenes,
    table_writer,
    write_json,
    write_table,
)

HEADER = ",".join(SCENE_COLUMNS)


@pytest.fixture
def scenes(tmp_path):
    def write(text: str | bytes) -> Path:
        path = tmp_path / "scenes.csv"
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return path

    return write


def test_a_plan_is_read_in_its_order_with_text_for_names(scenes):
    table = read_scenes(scenes(f"{HEADER}\n007,5e-6,1e-6,0,0\na b,6e-06,.1e-5,0.001,45\n"))
    assert list(table["point_id"]) == ["007", "a b"]
    assert list(table["h0_m"]) == [5e-6, 6e-6]
    assert list(table["hv_m"]) == [1e-6, 1e-6]


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
    ],
    ids=["byte order mark", "CRLF", "blank lines", "no last newline", "quotes", "spaces", "order"],
)
def test_what_does_not_matter_is_accepted(text, scenes):
    table = read_scenes(scenes(text))
    assert table.to_dict("records") == [
        {"point_id": "1", "h0_m": 5e-6, "hv_m": 1e-6, "phi_r_m": 0.0, "phi_deg": 0.0}
    ]


ROW = "1,5e-6,1e-6,0,0"
WRONG = {
    "nothing": ("", "the table is empty"),
    "blank lines alone": ("\n\n", "the table is empty"),
    "no rows": (f"{HEADER}\n", "a header and no rows"),
    "no header": (f"{ROW}\n{ROW}\n", "column 'point_id' is missing"),
    "a missing column": ("point_id,h0_m\n1,5e-6\n", "column 'hv_m' is missing"),
    "a column twice": (f"{HEADER},h0_m\n{ROW},1\n", "column 'h0_m' stands twice"),
    "a strange column": (f"{HEADER},colour\n{ROW},red\n", "unknown column 'colour'"),
    "a header in capitals": (f"{HEADER.upper()}\n{ROW}\n", "column 'point_id' is missing"),
    "a short row": (f"{HEADER}\n{ROW}\n2,5e-6\n", "line 3: 2 cells where the header has 5"),
    "a long row": (f"{HEADER}\n{ROW},7\n", "line 2: 6 cells where the header has 5"),
    "a comma for a point": (f"{HEADER}\n1,5,0e-6,1e-6,0,0\n", "line 2: 6 cells"),
    "semicolons": (HEADER.replace(",", ";") + "\n", "separated by semicolons"),
    "no position": ("point_id,h0_m,hv_m\n1,5e-6,1e-6\n", "phi_r_m and phi_deg, or x_m and y_m"),
    "two positions": (f"{HEADER},x_m,y_m\n{ROW},0,0\n", "'x_m' beside 'phi_r_m': a position is"),
    "text for a number": (f"{HEADER}\n1,5um,1e-6,0,0\n", "line 2: h0_m is '5um'"),
    "an empty number": (f"{HEADER}\n1,,1e-6,0,0\n", "line 2: h0_m is ''"),
    "NaN": (f"{HEADER}\n1,NaN,1e-6,0,0\n", "line 2: h0_m is 'NaN'"),
    "infinity": (f"{HEADER}\n1,5e-6,1e-6,0,-inf\n", "line 2: phi_deg is '-inf'"),
    "beyond a float": (f"{HEADER}\n1,1e999,1e-6,0,0\n", "line 2: h0_m is '1e999'"),
    "an underscore": (f"{HEADER}\n1,5e-6,1e-6,1_0,0\n", "line 2: phi_r_m is '1_0'"),
    "a truth value": (f"{HEADER}\n1,True,1e-6,0,0\n", "line 2: h0_m is 'True'"),
    "no name": (f"{HEADER}\n{ROW}\n ,5e-6,1e-6,0,0\n", "line 3: point_id is empty"),
    "a name twice": (f"{HEADER}\n{ROW}\n\n{ROW}\n", "line 4: point_id '1' stands in line 2"),
    "a name twice but for spaces": (f"{HEADER}\n{ROW}\n 1 ,5e-6,1e-6,0,0\n", "stands in line 2"),
    "an open quote": (f'{HEADER}\n"1,5e-6,1e-6,0,0\n', "cannot be read"),
    "other letters": (
        f"{HEADER}\nü,5e-6,1e-6,0,0\n".encode("latin-1"),
        "scenes.csv: line 2: the table must be text in UTF-8; save it in this encoding",
    ),
    "a binary file": (bytes(range(256)), "scenes.csv"),
    "a NUL": (f"{HEADER}\n1,5e-6\0,1e-6,0,0\n", "scenes.csv"),
}


@pytest.mark.parametrize("case", WRONG)
def test_a_wrong_table_is_refused(case, scenes):
    text, message = WRONG[case]
    with pytest.raises(InputError) as refusal:
        read_scenes(scenes(text))
    assert message in str(refusal.value)
    assert "scenes.csv" in str(refusal.value)


def test_what_is_no_file_is_refused(tmp_path):
    for name in ("none.csv", "none.parquet"):
        with pytest.raises(InputError, match="no such table"):
            read_scenes(tmp_path / name)
    with pytest.raises(InputError, match="cannot be read"):
        read_scenes(tmp_path)


def forces(**changes: object) -> pd.DataFrame:
    row: dict[str, object] = dict.fromkeys(FORCE_COLUMNS, 0) | {"point_id": "1", "status": "ok"}
    return pd.DataFrame([row, {**row, "point_id": "2", **changes}])


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


def test_a_table_is_not_written_under_the_name_of_something_else(tmp_path):
    with pytest.raises(InputError, match=r"a.xlsx: a table is written as .csv, .* not as .xlsx"):
        write_table(pd.DataFrame({"h0_m": [1.0]}), tmp_path / "a.xlsx")
    assert not list(tmp_path.iterdir())


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


def test_a_json_file_has_no_number_that_is_none(tmp_path):
    with pytest.raises(ValueError, match="not JSON compliant"):
        write_json({"a": float("nan")}, tmp_path / "fit.json")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("suffix", ["csv", "parquet"])
def test_some_rows_of_a_plan_are_read_alone(tmp_path, suffix):
    ids = [str(number) for number in range(10)]
    table = pd.concat([forces().iloc[:1]] * 10).assign(point_id=ids)[list(SCENE_COLUMNS)]
    path = tmp_path / f"scenes.{suffix}"
    with table_writer(path) as write:
        for first in range(0, 10, 3):
            write(table.iloc[first : first + 3])
    for rows in (slice(0, 10), slice(0, 1), slice(2, 4), slice(3, 6), slice(9, 10), slice(4, 10)):
        read = read_scenes(path, rows=lambda count, rows=rows: rows if count == 10 else slice(0))
        assert list(read["point_id"]) == ids[rows]


WRONG_PARQUET: dict[str, tuple[dict[str, object], str]] = {
    "a missing column": ({"h0_m": None}, "column 'h0_m' is missing"),
    "a strange column": ({"colour": ["red", "red"]}, "unknown column 'colour'"),
    "text for numbers": ({"h0_m": ["5um", "6um"]}, "column 'h0_m' holds"),
    "numbers for names": ({"point_id": [1, 2]}, "column 'point_id' holds int64"),
    "not a number": ({"hv_m": [1e-6, np.nan]}, "row 2: hv_m is nan"),
    "infinity": ({"hv_m": [np.inf, 1e-6]}, "row 1: hv_m is inf"),
    "a name twice": ({"point_id": ["1", "1"]}, "row 2: point_id '1' stands in row 1"),
    "no name": ({"point_id": ["1", ""]}, "row 2: point_id is empty"),
}


@pytest.mark.parametrize("case", WRONG_PARQUET)
def test_a_wrong_parquet_table_is_refused(case, tmp_path):
    changes, message = WRONG_PARQUET[case]
    table = forces()[list(SCENE_COLUMNS)].astype({"h0_m": float, "hv_m": float})
    for name, values in changes.items():
        table = table.drop(columns=name) if values is None else table.assign(**{name: values})
    table.to_parquet(tmp_path / "scenes.parquet")
    with pytest.raises(InputError, match=message):
        read_scenes(tmp_path / "scenes.parquet")


def test_a_parquet_file_that_is_none_is_refused(tmp_path):
    path = tmp_path / "scenes.parquet"
    write_table(forces()[list(SCENE_COLUMNS)], path)
    whole = path.read_bytes()
    for content in (b"", b"PAR1", whole[:-10], bytes(len(whole))):
        path.write_bytes(content)
        with pytest.raises(InputError, match=r"scenes\.parquet: the table cannot be read"):
            read_scenes(path)


@pytest.mark.parametrize(
    ("name", "read"),
    [("fit.json", read_json), ("table.csv", lambda path: read_columns(path, columns=("a",)))],
)
def test_a_file_in_another_encoding_is_named_with_its_line(tmp_path, name, read):
    path = tmp_path / name
    path.write_bytes("a\nb\nGröße".encode("latin-1"))
    with pytest.raises(InputError, match=rf"{name}: line 3: the \w+ must be text in UTF-8"):
        read(path)
