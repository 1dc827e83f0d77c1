"""Commands say where the film equation ends: in columns always, by exit status for one point."""

import pandas as pd
import pytest

from squeezefilm.cli.main import main
from squeezefilm.config.loading import load_config
from squeezefilm.studies.study import film_of
from squeezefilm.tables import read_forces, write_json, write_table

THIN = "Kn = 67 is above 0.18 (viscous flow): the equation does not apply"


@pytest.mark.parametrize(
    ("point", "pad_m", "force", "words"),
    [
        (("1nm", "0.1nm"), 0.01, "force 0.0", THIN),
        (
            ("5um", "1um"),
            1e-5,
            "force 5.80",
            "h0/l = 0.5 is above 0.1: the equation does not apply",
        ),
    ],
)
def test_one_force_outside_is_printed_with_exit_status_1(
    edited, capsys, point, pad_m, force, words
):
    study = edited("paper", finger={"length_x_m": pad_m, "length_y_m": pad_m})
    h0, hv = point
    assert main(["simulate", "--h0", h0, "--hv", hv, "--config", str(study)]) == 1
    said = capsys.readouterr()
    assert said.out.startswith(force)
    (line,) = [each for each in said.out.splitlines() if each.startswith("validity  ")]
    assert words in line
    assert "outside the limits of validity" in said.err


def test_tables_of_the_same_scenes_end_with_0_and_have_the_column(tmp_path, repository, capsys):
    config = ["--config", str(repository / "config" / "paper.yaml")]
    table, scenes, forces = (
        str(tmp_path / f"{name}.csv") for name in ("table", "scenes", "forces")
    )
    assert main(["simulate", "--h0", "1nm,5um", "--hv", "0.1nm", *config, "--output", table]) == 0
    found = pd.read_csv(table)["validity"]
    assert THIN in found[0]
    assert found[1] == "ok"
    rows = [("a", 1e-9, 1e-10, 0.0, 0.0), ("b", 5e-6, 1e-6, 0.0, 0.0)]
    columns = ["point_id", "h0_m", "hv_m", "phi_r_m", "phi_deg"]
    write_table(pd.DataFrame(rows, columns=columns), scenes)
    for words, output in (
        (["simulate"], forces),
        (["simulate", "--dry-run"], table),
        (["budget"], table),
    ):
        assert main([*words, scenes, *config, "--output", output]) == 0
        found = pd.read_csv(output)["validity"]
        assert THIN in found[0]
        assert found[1] == "ok"
    assert read_forces(forces)["validity"][1] == "ok"
    assert main(["response", scenes, *config, "--output", table]) == 0
    assert THIN in pd.read_csv(table)["validity"][0]
    capsys.readouterr()
    assert main(["simulate", "--h0", "5um", "--hv", "1um", *config]) == 0
    assert "\nvalidity  ok\n" in capsys.readouterr().out


@pytest.fixture
def fit(tmp_path, paper):
    path = tmp_path / "fit.json"
    values = {
        "model": "two_factor",
        "theta": [7.8, 1.83, -1.0],
        "points": 60,
        "global_error": 0.005,
        "sum_of_squares": 1e-5,
        "film": film_of(paper, left_out=["inertia; heat"]),
    }
    write_json(values, path)
    return path, values


def test_a_prediction_is_valid_where_its_film_is(fit, tmp_path, capsys):
    path, values = fit
    point = ["predict", str(path), "--hv", "2um", "--h0"]
    assert main([*point, "5um"]) == 0
    assert "\nvalidity  ok\n" in capsys.readouterr().out
    assert main([*point, "20um"]) == 1
    said = capsys.readouterr()
    assert "Re = 7.23 is above 3 (inertia neglected): error unknown" in said.out
    assert "0.0479" in said.out
    assert "outside the limits of validity" in said.err
    output = str(tmp_path / "predicted.csv")
    assert main([*point, "5um,20um", "--output", output]) == 0
    assert [each == "ok" for each in pd.read_csv(output)["validity"]] == [True, False]
    write_json({key: each for key, each in values.items() if key != "film"}, path)
    assert main([*point, "20um"]) == 0
    assert (
        "validity  not known: the fit's file does not describe its film" in capsys.readouterr().out
    )
    write_json(values | {"film": {"gas": {}}}, path)
    assert main([*point, "20um"]) == 2
    assert "fit.json: film.gas: " in capsys.readouterr().err


def test_a_fit_has_the_terms_that_its_forces_have(repository):
    """Where a study leaves a term to be decided, some force with it says that it is included."""
    config = load_config(repository / "config" / "levitation.yaml")
    assert film_of(config, left_out=["inertia; heat", "heat"])["gas"]["inertia"] == "included"
    assert film_of(config, left_out=["inertia; heat", "heat"])["gas"]["heat"] == "none"
