"""The check sees what differs, by how much, and nothing else."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from reporting.check.compare import (
    PASSED,
    SAME,
    UNREADABLE,
    Close,
    Quantity,
    compare,
    differences,
    on_screen,
    read_reference,
    write_reference,
)
from reporting.check.pictures import PLACE_OF_PICTURES, RMS, apart, pictures_of, write_pictures
from reporting.check.quantities import SAMPLE, column_quantities, tolerances
from reporting.commands import reference
from reporting.figures import style
from squeezefilm.cli import main as cli
from squeezefilm.errors import InputError

FORCES = pd.DataFrame(
    {"point_id": [str(row) for row in range(200)], "force_n": np.linspace(0.1, 0.8, 200) ** 2}
)
CLOSE = {"model": Close(relative=1e-6)}


def quantities(table: pd.DataFrame) -> list[Quantity]:
    return list(column_quantities(table, CLOSE, "data", "forces"))


def stored(found: list[Quantity]) -> dict[tuple[str, str, str], dict[str, str]]:
    return {each.key: dict(each.cells) for each in found}


def failures(table: pd.DataFrame) -> pd.DataFrame:
    return table[table["verdict"] != PASSED]


def failed(table: pd.DataFrame) -> list[str]:
    """The names of the quantities that fail beside FORCES."""
    rows = compare(quantities(table), stored(quantities(FORCES)))
    return failures(rows)["quantity"].tolist()


def with_cell(row: int) -> pd.Series:
    return FORCES["force_n"].where(FORCES.index != row, 0.9)


@pytest.mark.parametrize(
    ("force_n", "seen"),
    [
        (FORCES["force_n"], []),
        (FORCES["force_n"] * (1 + 0.9e-6), []),
        (FORCES["force_n"] * (1 + 1.1e-6), ["force_n"]),
        (np.nan, ["force_n"]),
        *((with_cell(row), ["force_n"]) for row in (0, 3, 199)),
    ],
)
def test_what_differs_is_seen_in_its_column_alone(force_n, seen):
    """Any cell, though few rows are kept."""
    assert failed(FORCES.assign(force_n=force_n)) == seen
    assert len(quantities(FORCES)[1].cells) == SAMPLE


def test_what_is_missing_or_new_fails():
    found, known = quantities(FORCES), stored(quantities(FORCES))
    new = Quantity("data", "other", "rows", {"rows": "1"})
    lost = Quantity("data", "forces", UNREADABLE, {"a file": "forces.csv: there is no such table"})
    rows = failures(compare([*found, new], known))
    assert rows[["item", "expected"]].to_numpy().tolist() == [["other", "–"]]
    rows = failures(compare(found[:-1], known))
    assert rows[["quantity", "got"]].to_numpy().tolist() == [["force_n", "missing"]]
    rows = failures(compare([lost], known))
    assert rows["got"].tolist() == [lost.cells["a file"]]


@pytest.mark.parametrize(
    ("tolerance", "expected", "got", "share"),
    [
        (Close(relative=0.1), "2", "2.1", 0.5),
        (Close(of_largest=0.1), "2", "2.4", 2),
        (Close(absolute=1), "-3", "-4", 1),
        (Close(), "2", "2", 0),
        (Close(), "2", "2.1", np.inf),
        (Close(relative=1), "2", "many", np.inf),
        (Close(relative=1e-9), "nan", "nan", 0),
        (SAME, "a", "a", 0),
        (SAME, "(µm)", "(mm)", np.inf),
        (Close(digits=1), "0.987 N", "0.988 N", 1),
        (Close(digits=1), "−2.1e−4", "−2.3e−4", 2),
        (Close(digits=1), "below 1 s", "below 1 min", np.inf),
        (Close(digits=1), "5", "3", 2),
        (Close(relative=0.01, digits=1), "1.000", "1.011", 1),
    ],
)
def test_a_tolerance_is_what_it_says(tolerance, expected, got, share):
    assert tolerance.distances({"a": expected}, {"a": got})["a"] == pytest.approx(share)


def test_tolerances_follow_the_solvers():
    tight, loose = tolerances(1e-6), tolerances(1e-4)
    assert tight["force"].relative == 2e-6
    for kind in ("force", "model", "residual", "parameters", "relative error", "shown"):
        want, have = {"force": "1.0000"}, {"force": "1.00009"}
        distances = [each[kind].distances(want, have)["force"] for each in (loose, tight)]
        assert distances[0] <= min(1, distances[1]), kind


def test_a_reference_is_read_as_it_was_written(tmp_path):
    found = [*quantities(FORCES), Quantity("axis labels", "fig, 08", 'a "b"', {"x, y": "h, (µm)"})]
    write_reference(found, tmp_path, tmp_path)
    assert read_reference(tmp_path) == stored(found)
    assert differences(found, read_reference(tmp_path)) == []
    write_reference(found[:-1], tmp_path, tmp_path)
    assert [path.name for path in tmp_path.glob("*.csv")] == ["data.csv"]


@pytest.mark.parametrize("text", ["", "item,quantity\n", "item,quantity,cell,value\na,b\n"])
def test_a_broken_reference_is_named(tmp_path, text):
    (tmp_path / "data.csv").write_text(text)
    with pytest.raises(InputError, match=r"data\.csv"):
        read_reference(tmp_path)


# --- pictures -----------------------------------------------------------------------------------


def picture(folder: Path, *, label: str = "h0 (µm)", curves: int = 2, band: bool = True) -> None:
    """The one picture of a study: two curves in a band of ±15 %."""
    with style.settings(notes=False):
        figure = style.new_figure()
        axes = figure.subplots()
        x = np.linspace(5, 10, 50)
        for curve in range(curves):
            axes.plot(x, np.exp(-x / 4) * (1 + 0.2 * curve), label=label)
        for side in (-1, 1) if band else ():
            axes.axhline(0.2 + 0.15 * side, color="0.6", linewidth=0.6, linestyle="--")
        axes.set_xlim(5, 10)
        axes.set_ylim(0, 0.4)
        axes.set_xlabel(label)
        axes.legend()
        style.add_note(figure, label)
        style.save_without_text(figure, [folder / PLACE_OF_PICTURES / f"fig08{style.PLAIN}"])


@pytest.fixture
def kept(tmp_path):
    """The folder of a reference with the picture in it; the study's is its parent."""
    (tmp_path / "kept").mkdir()
    picture(tmp_path)
    write_pictures(tmp_path / PLACE_OF_PICTURES, tmp_path / "kept")
    return tmp_path / "kept"


def judged(reference: Path) -> list[str]:
    (key,) = pictures_of(reference)
    found = apart(key, reference.parent / PLACE_OF_PICTURES, reference)
    return compare([Quantity(*key, found, Close(absolute=RMS))], pictures_of(reference))[
        "verdict"
    ].tolist()


def test_a_picture_does_not_depend_on_its_texts(kept):
    picture(kept.parent, label="mean gap between finger and surface (µm)")
    name = f"fig08{style.PLAIN}"
    assert (kept / name).read_bytes() == (kept.parent / PLACE_OF_PICTURES / name).read_bytes()
    assert judged(kept) == [PASSED]


@pytest.mark.parametrize("fault", [{"curves": 1}, {"band": False}, None])
def test_a_dropped_curve_a_missing_band_and_no_picture_are_seen(kept, fault):
    if fault:
        picture(kept.parent, **fault)
    else:
        (kept.parent / PLACE_OF_PICTURES / f"fig08{style.PLAIN}").write_bytes(b"no picture")
    assert judged(kept) == ["failed"]


# --- commands -----------------------------------------------------------------------------------


def test_the_screen_shows_the_worst_of_each_part_and_all_that_failed():
    known = stored(quantities(FORCES))
    sound = on_screen(compare(quantities(FORCES), known))
    assert sound.endswith("All 3 quantities passed.")
    assert "Failed" not in sound
    faulty = on_screen(compare(quantities(FORCES.assign(force_n=1.0)), known))
    assert faulty.endswith("1 of 3 quantities failed.")
    assert "failed" in faulty.partition("Failed:")[2]


def test_a_reference_is_written_only_when_asked_to(tmp_path, repository, monkeypatch, capsys):
    config = repository / "config" / "paper.yaml"
    words = ["reference", str(tmp_path), f"--config={config}", f"--output={tmp_path / 'kept'}"]
    monkeypatch.setattr(reference, "study_quantities", lambda *_: quantities(FORCES))
    assert cli.main(words) == 1
    said = capsys.readouterr()
    assert "data, forces, rows, rows: – → 200" in said.out
    assert "nothing written" in said.err
    assert not (tmp_path / "kept").exists()
    assert cli.main([*words, "--yes"]) == 0
    assert read_reference(tmp_path / "kept") == stored(quantities(FORCES))
    assert cli.main(words) == 0
    assert "nothing changes" in capsys.readouterr().out
