"""The check sees what differs, by how much, and nothing else."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from reporting.check.compare import FAILED, PASSED, compare, to_table
from reporting.check.designs import Efficient
from reporting.check.pictures import (
    PLACE,
    expected_pictures,
    picture_quantities,
    write_pictures,
)
from reporting.check.quantities import SAMPLE, Quantity, column_quantities
from reporting.check.reference import differences, read_reference, write_reference
from reporting.check.show import on_screen, read_check, status
from reporting.check.tolerances import GIVEN, SAME, AtMost, Close, Closeness, LastDigit
from reporting.commands import reference
from reporting.figures import PLAIN
from reporting.figures.parts import style
from squeezefilm.cli import main as cli
from squeezefilm.io.errors import InputError
from squeezefilm.io.tables import write_table

FORCES = pd.DataFrame(
    {"point_id": [str(row) for row in range(200)], "force_n": np.linspace(0.1, 0.8, 200) ** 2}
)
CLOSE = Close(relative=1e-6)


def quantities(table: pd.DataFrame) -> list[Quantity]:
    return list(column_quantities("data", "forces", table, tolerances={"force_n": CLOSE}))


def stored(found: list[Quantity]) -> dict[tuple[str, str, str], dict[str, str]]:
    return {(each.part, each.item, each.name): dict(each.cells) for each in found}


def failures(table: pd.DataFrame) -> pd.DataFrame:
    return table[table["verdict"] != PASSED]


def failed(table: pd.DataFrame) -> list[str]:
    """The names of the quantities that fail beside FORCES."""
    rows = to_table(compare(quantities(table), stored(quantities(FORCES))))
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


def test_a_gap_that_is_in_the_reference_too_is_no_fault():
    gap = FORCES["force_n"].where(FORCES.index != 0)
    both = stored(quantities(FORCES.assign(force_n=gap)))
    assert not failures(to_table(compare(quantities(FORCES.assign(force_n=gap)), both))).size


def test_what_is_missing_or_new_fails():
    found, known = quantities(FORCES), stored(quantities(FORCES))
    new = Quantity("data", "other", "rows", {"rows": "1"})
    lost = Quantity("data", "forces", "readable", missing="forces.csv: there is no such table")
    rows = failures(to_table(compare([*found, new], known)))
    assert rows[["item", "expected"]].to_numpy().tolist() == [["other", "not in the reference"]]
    rows = failures(to_table(compare(found[:-1], known)))
    assert rows[["quantity", "got"]].to_numpy().tolist() == [["force_n", "missing"]]
    rows = failures(to_table(compare([lost], known)))
    assert rows["got"].tolist() == [lost.missing]


@pytest.mark.parametrize(
    ("tolerance", "expected", "got", "share"),
    [
        (Close(relative=0.1), "2", "2.1", 0.5),
        (Close(of_largest=0.1), "2", "2.4", 2),
        (Close(absolute=1), "-3", "-4", 1),
        (Close(), "2", "2", 0),
        (Close(), "2", "2.1", np.inf),
        (Close(relative=1), "2", "many", np.inf),
        (GIVEN, "nan", "nan", 0),
        (SAME, "a", "a", 0),
        (SAME, "(µm)", "(mm)", np.inf),
        (AtMost(2), "whatever", "1", 0.5),
        (AtMost(0), "whatever", "0", 0),
        (AtMost(0), "whatever", "1", np.inf),
        (AtMost(1), "0", "nan", np.inf),
        (LastDigit(), "0.987 N", "0.988 N", 1),
        (LastDigit(), "−2.1e−4", "−2.3e−4", 2),
        (LastDigit(), "below 1 s", "below 1 min", np.inf),
        (LastDigit(), "5", "3", 2),
        (LastDigit(relative=0.01), "1.000", "1.011", 1),
    ],
)
def test_a_tolerance_is_what_it_says(tolerance, expected, got, share):
    assert tolerance.worst({"a": expected}, {"a": got}).distance == pytest.approx(share)


def test_tolerances_follow_the_solvers():
    tight, loose = Closeness(solver=1e-6), Closeness(solver=1e-4)
    assert tight.force.relative == 2e-6
    for name in ("force", "model", "residual", "parameters", "relative_error", "shown"):
        want, have = {"force": "1.0000"}, {"force": "1.00009"}
        distances = [getattr(each, name).worst(want, have).distance for each in (loose, tight)]
        assert distances[0] <= min(1, distances[1]), name


THETA = {"theta0": "7.6", "theta1": "1.9", "theta2": "-1"}


def design(*points: tuple[float, float]) -> dict[str, str]:
    factors = ("h0_m", "hv_m")
    return THETA | {
        f"point {number} {factor}": str(value)
        for number, point in enumerate(points, start=1)
        for factor, value in zip(factors, point, strict=True)
    }


def test_a_design_is_worth_the_same_anywhere_on_a_line_of_equal_excursion():
    ends = (5e-6, 2e-6), (10e-6, 0.2e-6)
    here, there = design(*ends, (6.91e-6, 2e-6)), design(*ends, (3.455e-6, 1e-6))
    other = design(*ends, (9e-6, 2e-6))
    efficient = Efficient("two_factor")
    assert efficient.worst(here, there).distance < 1e-6
    assert efficient.worst(here, other).distance > 1
    assert efficient.worst(other, here).distance == 0  # a better design is welcome
    expected, got = efficient.worst(here, other).shown
    assert expected == "1"
    assert float(got) < 0.999


def test_a_reference_is_read_as_it_was_written(tmp_path):
    found = [*quantities(FORCES), Quantity("axis labels", "fig, 08", 'a "b"', {"x, y": "h, (µm)"})]
    write_reference(found, tmp_path)
    assert read_reference(tmp_path) == stored(found)
    assert differences(found, read_reference(tmp_path)) == []
    write_reference(found[:-1], tmp_path)
    assert [path.name for path in tmp_path.glob("*.csv")] == ["data.csv"]


@pytest.mark.parametrize("text", ["", "item,quantity\n", "item,quantity,cell,value\na,b\n"])
def test_a_broken_reference_is_named(tmp_path, text):
    (tmp_path / "data.csv").write_text(text)
    with pytest.raises(InputError, match=r"data\.csv"):
        read_reference(tmp_path)


def test_no_reference_is_made_of_half_a_study(tmp_path):
    with pytest.raises(InputError, match="needs a finished study"):
        write_reference([Quantity("data", "a", "readable", missing="a.csv: none")], tmp_path)
    with pytest.raises(InputError, match="make reference"):
        read_reference(tmp_path)


# --- pictures -----------------------------------------------------------------------------------


def picture(folder: Path, *, label: str = "h0 (µm)", curves: int = 2, band: bool = True) -> None:
    """The one picture of a study: two curves in a band of ±15 %."""
    with style.settings():
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
        style.add_note(figure, pd.DataFrame({"note": [""]}))
        style.save_without_text(figure, [folder / PLACE / f"fig08{PLAIN}"])


@pytest.fixture
def kept(tmp_path):
    """The folder of a reference with the picture in it; the study's is its parent."""
    (tmp_path / "figures").mkdir()
    (tmp_path / "figures" / "fig08.csv").write_text("note\n")
    (tmp_path / "kept").mkdir()
    picture(tmp_path)
    write_pictures(tmp_path, tmp_path / "kept")
    return tmp_path / "kept"


def judged(reference: Path) -> list[str]:
    found = picture_quantities(reference.parent, reference)
    return [row.verdict for row in compare(found, expected_pictures(reference))]


def test_a_picture_does_not_depend_on_its_texts(kept):
    picture(kept.parent, label="mean gap between finger and surface (µm)")
    first, second = kept / f"fig08{PLAIN}", kept.parent / PLACE / f"fig08{PLAIN}"
    assert first.read_bytes() == second.read_bytes()
    assert judged(kept) == [PASSED]


@pytest.mark.parametrize("fault", [{"curves": 1}, {"band": False}])
def test_a_dropped_curve_and_a_missing_band_are_seen(kept, fault):
    picture(kept.parent, **fault)
    assert judged(kept) == [FAILED]


def test_a_picture_that_is_missing_or_none_is_told(kept):
    path = kept.parent / PLACE / f"fig08{PLAIN}"
    path.write_bytes(b"no picture")
    assert judged(kept) == [FAILED]
    path.unlink()
    assert judged(kept) == [FAILED]
    picture(kept.parent)
    (kept / f"fig08{PLAIN}").unlink()
    assert judged(kept) == [FAILED]


# --- commands -----------------------------------------------------------------------------------


def test_the_verdict_is_shown_and_decides_the_status(tmp_path, capsys, refused):
    known = stored(quantities(FORCES))
    for table, expected in ((FORCES, 0), (FORCES.assign(force_n=1.0), 1)):
        rows = to_table(compare(quantities(table), known))
        write_table(rows, tmp_path / "check.csv")
        assert status(read_check(tmp_path / "check.csv")) == expected
        assert cli.main(["verdict", str(tmp_path / "check.csv")]) == expected
        shown = capsys.readouterr().out
        assert shown.strip() == on_screen(rows).strip()
        assert ("failed" in shown) == bool(expected)
    assert "none.csv" in refused("verdict", str(tmp_path / "none.csv"))


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
