"""The programs that examine error estimates: ``squeezefilm-verification estimates`` and others."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from squeezefilm.cli.main import main
from squeezefilm_workflow.verification.__main__ import COMMAND_GROUPS
from squeezefilm_workflow.verification.estimates import read_stored_films, with_outcomes

STORED = Path(__file__).parent / "data" / "judged_films.csv"


def run(*arguments: object) -> int:
    return main(list(map(str, arguments)), groups=COMMAND_GROUPS)


@pytest.fixture(scope="module")
def tables(tmp_path_factory):
    folder = tmp_path_factory.mktemp("estimates")
    names = "forces", "summary", "grids", "guards"
    paths = {name: folder / f"{name}.csv" for name in names}
    some = "--seed", 377, "--output", paths["forces"], "--summary", paths["summary"]
    some += "--grids", paths["grids"]
    assert run("estimates", "--films", 2, *some) == 0
    first = paths["forces"].read_text()
    assert run("estimates", "--films", 4, *some) == 0
    assert paths["forces"].read_text().startswith(first)
    chosen = "--forces", paths["forces"], "--grids", paths["grids"]
    assert run("guards", *chosen, "--output", paths["guards"]) == 0
    return {name: pd.read_csv(path, comment="#") for name, path in paths.items()}


def test_each_film_is_compared_once_and_counted(tables):
    forces = tables["forces"]
    assert not forces.duplicated(["film", "tolerance"]).any()
    assert {*forces["film"]} == {0, 1, 2, 3}
    counted = tables["summary"].set_index("forces").loc["all"]
    assert counted["films"] == 4
    assert counted["within"] == with_outcomes(forces)["outcome"].eq("within").sum() > 0


def test_recorded_grids_give_the_solver_s_own_estimates(tables):
    """Nothing is solved again: so a guard's share in an estimate is known by switching it off."""
    solved = with_outcomes(tables["forces"])["error_over_estimate"].dropna()
    again = tables["guards"].set_index("guard switched off").loc["none"]
    assert again["forces"] == len(solved)
    assert again["largest error over estimate"] == pytest.approx(solved.max(), rel=1e-2)


def test_a_table_of_other_films_is_not_gone_on_with(tables, tmp_path, capsys):
    path = tmp_path / "forces.csv"
    tables["forces"].to_csv(path, index=False)
    arguments = "--seed", 4, "--output", path, "--summary", tmp_path / "summary.csv"
    assert run("estimates", "--films", 2, *arguments) != 0
    assert "no table of films of seed 4" in capsys.readouterr().err


def test_stored_films_have_their_forces(tmp_path):
    path = tmp_path / "films.csv"
    table = read_stored_films(STORED).iloc[[3, 4]]
    table.assign(force=np.nan, force_error=np.nan).to_csv(path, index=False)
    assert run("stored-films", "--output", path) == 0
    found = read_stored_films(path)
    off = np.abs(found["force"].to_numpy() - table["force"].to_numpy())
    assert (off <= found["force_error"] + table["force_error"].to_numpy()).all()
