"""The check sees what differs, by how much, and nothing else."""

import re
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from squeezefilm.cli import main as cli
from squeezefilm_workflow.reporting import check
from squeezefilm_workflow.reporting.check import (
    MAX_SAMPLED_ROWS,
    PASSED,
    PICTURES_FOLDER,
    ZERO_TOLERANCE,
    CellTolerance,
    CheckedQuantity,
    column_quantities,
    compare_quantities,
    read_reference,
    write_reference,
)
from squeezefilm_workflow.reporting.figures.style import PLAIN_PICTURE_SUFFIX
from squeezefilm_workflow.reporting.pages import render_template

FORCES = pd.DataFrame(
    {"point_id": [str(row) for row in range(200)], "force_n": np.linspace(0.1, 0.8, 200) ** 2}
)
CLOSE = {"model": CellTolerance(relative=1e-6)}


def quantities(table: pd.DataFrame) -> list[CheckedQuantity]:
    return list(column_quantities(table, CLOSE, "data", "forces"))


def stored(found: list[CheckedQuantity]) -> dict[tuple[str, str, str], dict[str, str]]:
    return {each[:3]: dict(each.cell_texts) for each in found}


def failed(table: pd.DataFrame) -> list[str]:
    """The names of the quantities that fail beside FORCES."""
    rows = compare_quantities(quantities(table), stored(quantities(FORCES)))
    return rows.loc[rows["verdict"] != PASSED, "quantity"].tolist()


def test_what_failed_is_shown_once_with_its_file_and_what_to_do(tmp_path):
    found = [item._replace(part="simulations", item="screen") for item in quantities(FORCES)]
    table = compare_quantities(found, stored(found) | {found[2][:3]: {"row 1": "7"}})
    file = tmp_path / "mine/simulations/screen/forces.csv"
    text = check.terminal_text(table, tmp_path / "mine")
    assert len(re.findall(r"\bforce_n\b", text)) == 1
    assert f"{file}: not made yet\n" in text
    file.parent.mkdir(parents=True)
    file.touch()
    assert f"{file}\n" in check.terminal_text(table, tmp_path / "mine")
    assert "`make reference STUDIES=mine`" in text


def test_what_is_missing_is_told_how_it_is_made():
    kept = quantities(FORCES)
    for made, is_told in ((kept, False), (kept[:-1], True)):
        table = compare_quantities(made, stored(kept))
        told = "`make check` makes it" in check.passed_and_failed_text(table, study="mine")
        assert told == is_told


def test_of_what_failed_causes_stand_first():
    found = [
        item._replace(part=part, item=item_name)
        for part, item_name in (("claims", "error"), ("fits", "screen"), ("simulations", "screen"))
        for item in quantities(FORCES)[2:3]
    ]
    table, results = compare_quantities(found, {}), Path("results/mine")
    files = re.findall(r"results/mine/(\w+)", check.terminal_text(table, results))
    assert files == ["simulations", "fits", "claims"]
    failed_files = check.failed_files(table, results)
    values = {"study": "mine", "summary": "", "files": failed_files, "plan_size": 1}
    page = render_template("check.md", **values, worst=table, table=table)
    assert re.findall(r"`results/mine/(\w+)[^`]*`: not made yet", page) == files


def test_each_part_has_its_worst_quantity():
    count, names, forces = quantities(FORCES)
    found = [count._replace(part="a"), names, forces]
    close = {forces[:3]: {**forces.cell_texts, "row 1": "0.0100000001"}}
    worst = check.worst_of_each_part(compare_quantities(found, stored(found[:2]) | close))
    assert worst["part"].tolist() == ["a", "data"]
    assert worst["passed"].tolist() == [1, 2]
    assert worst["quantity"].tolist() == ["–", "force_n"]


def test_a_check_that_passes_tells_how_closely():
    kept = quantities(FORCES)
    close = stored(kept) | {kept[2][:3]: {**kept[2].cell_texts, "row 1": "0.0100000042"}}
    text = check.passed_and_failed_text(compare_quantities(kept, close), study="mine")
    assert text.endswith("the largest difference from the reference is 0.42 of the allowed one.")


def test_the_page_begins_with_verdicts():
    """A window of 400 pixels ended before them."""
    assert check.CHECK_COLUMNS[0] == "verdict"


def test_what_failed_stands_first_on_the_page():
    fits, claims = (
        quantities(FORCES)[1]._replace(part=part, item="screen") for part in ("fits", "claims")
    )
    table = compare_quantities([fits, claims], stored([fits]))
    assert check.failures_first(table)["part"].tolist() == ["claims", "fits"]


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
    assert len(quantities(FORCES)[1].cell_texts) == MAX_SAMPLED_ROWS


def test_a_text_is_seen_in_a_row_that_no_reference_keeps():
    table = FORCES.assign(validity="ok")
    stored_table = stored(quantities(table))
    for row in range(len(table)):
        changed = table.assign(validity=table["validity"].where(table.index != row, "outside"))
        rows = compare_quantities(quantities(changed), stored_table)
        assert rows.loc[rows["verdict"] != PASSED, "quantity"].tolist() == ["validity"], row


@pytest.mark.parametrize(("plan", "points"), [("screen", 60), ("four_factor", 65)])
def test_every_force_that_a_study_fits_is_compared(plan, points, repository):
    """A force between the sampled rows could be in error by fifteen tolerances."""
    stored_forces = read_reference(repository / "tests/reference/paper")[
        ("simulations", plan, "force_n")
    ]
    assert len(stored_forces) == points
    texts = [stored_forces[f"row {row + 1}"] for row in range(points)]
    forces = pd.DataFrame({"force_n": [float(text) for text in texts]})
    closeness = {"force": CellTolerance(relative=2e-6), "model": CellTolerance(relative=2e-6)}
    for row in (None, *range(points)):
        changed = forces["force_n"] * np.where(forces.index == row, 1 + 3e-5, 1)
        _, found = column_quantities(forces.assign(force_n=changed), closeness, "simulations", plan)
        (verdict,) = compare_quantities([found], {found[:3]: stored_forces})["verdict"]
        assert (verdict == PASSED) == (row is None), row


@pytest.mark.parametrize(
    ("tolerance", "expected", "got", "share"),
    [
        (CellTolerance(relative=0.1), "2", "2.1", 0.5),
        (CellTolerance(fraction_of_largest=0.1), "2", "2.4", 2),
        (CellTolerance(absolute=1), "-3", "-4", 1),
        (CellTolerance(), "2", "2", 0),
        (CellTolerance(relative=1), "2", "many", np.inf),
        (CellTolerance(relative=1e-9), "nan", "nan", 0),
        (ZERO_TOLERANCE, "a", "a", 0),
        (ZERO_TOLERANCE, "(µm)", "(mm)", np.inf),
        (CellTolerance(last_digit_units=1), "0.987 N", "0.988 N", 1),
        (CellTolerance(last_digit_units=1), "−2.1e−4", "−2.3e−4", 2),
    ],
)
def test_a_tolerance_is_what_it_says(tolerance, expected, got, share):
    assert tolerance.deviation_ratios({"a": expected}, {"a": got})["a"] == pytest.approx(share)


def test_a_reference_is_read_as_it_was_written(tmp_path):
    found = [
        *quantities(FORCES),
        CheckedQuantity("axis labels", "fig, 08", 'a "b"', {"x, y": "h, (µm)"}),
    ]
    write_reference(found, tmp_path, tmp_path)
    assert read_reference(tmp_path) == stored(found)
    write_reference(found[:-1], tmp_path, tmp_path)
    assert [path.name for path in tmp_path.glob("*.csv")] == ["data.csv"]


def test_a_reference_of_another_study_is_no_list_of_failures(repository, refused):
    """247 of 278 quantities failed, and the remedy was to delete files."""
    quick, paper = repository / "tests/reference/quick", repository / "config/paper.yaml"
    error = refused("check", quick, f"--config={paper}", f"--reference={quick}")
    assert "is the reference of the study quick, and" in error
    assert "has results of paper; `make reference STUDIES=paper` makes one" in error


def test_pictures_go_with_a_reference_into_a_new_folder(tmp_path):
    picture = tmp_path / PICTURES_FOLDER / f"fig08{PLAIN_PICTURE_SUFFIX}"
    picture.parent.mkdir(parents=True)
    picture.write_bytes(b"drawn")
    write_reference(quantities(FORCES), tmp_path, tmp_path / "of/mine")
    assert (tmp_path / "of/mine" / picture.name).read_bytes() == b"drawn"


def test_a_reference_is_written_over_an_old_one(tmp_path, repository, monkeypatch, capsys):
    config = repository / "config" / "paper.yaml"
    words = ["reference", str(tmp_path), f"--config={config}", f"--output={tmp_path / 'kept'}"]
    for table in (FORCES[:30], FORCES):
        monkeypatch.setattr(check, "study_quantities", lambda *_, t=table: quantities(t))
        assert cli.main(words) == 0
        assert "written" in capsys.readouterr().out
        assert read_reference(tmp_path / "kept") == stored(quantities(table))
