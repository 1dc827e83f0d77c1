"""Tables I to III: parameters, ranges and errors of the results, tidy and for people."""

from pathlib import Path

import pandas as pd
import pytest

from paper.tables import table_module
from squeezefilm.cli import main as cli
from squeezefilm.io.errors import InputError
from squeezefilm.io.tables import read_json
from squeezefilm.models.fit_file import read_fit


def made(study, number: str, folder: Path) -> tuple[pd.DataFrame, str]:
    paths = [folder / f"table{number}.csv", folder / f"table{number}.md"]
    words = study.words(study.tables[number])
    output = [f"--output={paths[0]}", f"--markdown={paths[1]}"]
    assert cli.main(["table", number, *words, *output]) == 0
    return pd.read_csv(paths[0]), paths[1].read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("number", "fits"),
    [
        ("1", ["screen", "two_factor_design"]),
        ("3", ["four_factor", "four_factor_design", "four_factor_design_distinct"]),
    ],
)
def test_parameters_are_those_of_the_fits(study, number, fits, tmp_path):
    data, _ = made(study, number, tmp_path)
    for name, (_, rows) in zip(fits, data.groupby("fit", sort=False), strict=True):
        fit = read_fit(study.root / "fits" / f"{name}.json")
        assert tuple(rows["value"][:-1]) == pytest.approx(fit.theta)
        assert set(rows["points"]) == {fit.points}


def test_global_errors_are_judged_on_the_first_plan(study, tmp_path):
    for number, stem in (
        ("1", "two_factor_design_on_screen"),
        ("3", "four_factor_design_on_four_factor"),
    ):
        data, _ = made(study, number, tmp_path)
        errors = data[data["quantity"].str.startswith("global error")]["value"].to_list()
        judged = read_json(study.root / "validation" / f"{stem}.json")["global_error"]
        assert errors[1] == pytest.approx(100 * judged)
        assert errors[0] < errors[1]


def test_ranges_of_the_four_factors(study, tmp_path):
    data, _ = made(study, "2", tmp_path)
    ranges = data.set_index("symbol")[["minimum", "maximum"]].T.to_dict("list")
    assert ranges == {"h0": [5, 10], "hv": [0.2, 2], "φr": [0, 2.9], "φφ": [0, 45]}


@pytest.mark.parametrize("number", ["1", "2", "3"])
def test_the_table_for_people_has_every_row_and_states_its_settings(study, number, tmp_path):
    _, markdown = made(study, number, tmp_path)
    rows = [line for line in markdown.splitlines() if line.startswith("|")]
    assert len(rows) == {"1": 4, "2": 4, "3": 6}[number] + 2
    assert len({row.count("|") for row in rows}) == 1
    assert ("simulations at 13 positions" if number == "2" else "test device") in markdown
    if number == "3":  # a zero but for rounding reads zero
        assert "| θ3 | – | 0.016642 | 0 | −0.039971 |" in markdown


def test_an_unknown_table_is_refused():
    with pytest.raises(InputError, match="no table '4'; the tables are 1, 2, 3"):
        table_module("4")
