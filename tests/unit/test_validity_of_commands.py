"""Commands say where the film equation ends: in columns always, by exit status for one point."""

import re

import pandas as pd
import pytest

from squeezefilm.cli.main import main
from squeezefilm.files import write_json
from squeezefilm.models.force_model import get_model
from squeezefilm.studies.study import film_values

MODEL = get_model("two_factor")
THIN = "Kn = 67 is above 0.18 (viscous flow): the equation does not apply"


def test_one_force_outside_is_printed_with_exit_status_1(edited, capsys):
    study = edited("paper", pad={"length_x_m": 0.01, "length_y_m": 0.01})
    assert main(["simulate", "--h0", "1nm", "--hv", "0.1nm", "--config", str(study)]) == 1
    said = capsys.readouterr()
    assert re.search(rf"(?s)^mean force +0\.0.*\nvalidity +.*{re.escape(THIN)}", said.out)
    assert "outside the limits of validity" in said.err


def test_a_budget_and_a_curve_are_had_by_options(edited, tmp_path, capsys, refused):
    where = ["--h0", "5um", "--config", str(edited("paper"))]
    assert main(["error-budget", "--hv", "2.2um", *where]) == 0
    assert re.search("inertia +[+]2.0 %", capsys.readouterr().out)
    curve, picture = str(tmp_path / "curve.csv"), str(tmp_path / "curve.svg")
    simulated = ["simulate", "--hv", "1um", *where, "--output", curve]
    assert main(simulated) == 0
    assert "points along h0_m: 1, lines: 1" in refused("plot", curve, "--output", picture)
    assert main([*simulated, "--x", "0mm,1mm,2mm"]) == 0
    assert main(["plot", curve, "--output", picture]) == 0
    assert "position $x$ (mm)" in (tmp_path / "curve.svg").read_text(encoding="utf-8")


@pytest.fixture
def fit(tmp_path, paper):
    path = tmp_path / "fit.json"
    values = {
        "format": 1,
        "ranges": {},
        "error_scale": [0.0, 1.0],
        "profile_uncertainty": 0.0,
        "directions": None,
        "model": "two_factor",
        "expression": MODEL.expression,
        "parameters": list(MODEL.parameter_names),
        "parameter_units": list(MODEL.parameter_units),
        "theta": [7.8, 1.83, -1.0],
        "points": 60,
        "global_error": 0.005,
        "sum_of_squares": 1e-5,
        "film": film_values(paper, absent_terms=["inertia; thermal effects"]),
    }
    write_json(values, path)
    return path, values


def test_a_prediction_is_valid_where_its_film_is(fit, tmp_path, capsys):
    path, values = fit
    point = ["predict", str(path), "--hv", "2um", "--h0"]
    assert main([*point, "5um"]) == 0
    assert re.search(r"\nvalidity +within limits\n", capsys.readouterr().out)
    assert main([*point, "20um"]) == 1
    said = capsys.readouterr()
    assert "Re = 7.23 is above 3 (inertia neglected): modelling error unverified" in said.out
    assert "0.0479" in said.out
    assert "outside the limits of validity" in said.err
    output = str(tmp_path / "predicted.csv")
    assert main([*point, "5um,20um", "--output", output]) == 0
    assert [each == "ok" for each in pd.read_csv(output)["validity"]] == [True, False]
    write_json(values | {"film": None}, path)
    assert main([*point, "20um"]) == 0
    assert "not known: the fit's file does not describe its film" in capsys.readouterr().out
    write_json(values | {"film": {"gas": {}}}, path)
    assert main([*point, "20um"]) == 2
    assert "fit.json: film.gas: " in capsys.readouterr().err


def test_a_single_point_outside_is_named_without_a_number(refused):
    text = refused("simulate", "--h0", "5mm", "--hv", "2um")
    assert "operating point: h0 = 5000 µm must lie between 0.001 and 1000 µm" in text


def test_responses_of_several_points_are_written_as_a_table(edited, tmp_path, refused):
    words = ["response", "--h0", "5um,6um", "--hv", "2um", "--config", str(edited("paper"))]
    assert "several scenes need --output" in refused(*words)
    output = tmp_path / "responses.csv"
    assert main([*words, "--output", str(output)]) == 0
    corner_hz = pd.read_csv(output)["corner_hz"]
    assert corner_hz.is_monotonic_increasing
    assert len(corner_hz) == 2


def test_a_line_of_several_loads_states_mass_and_modelling_error(edited, tmp_path, capsys):
    words = ["levitate", "--mass", "50g,60g", "--hv", "1.5um", "--config", str(edited("paper"))]
    assert main([*words, "--output", str(tmp_path / "levitation.csv")]) == 0
    first = capsys.readouterr().err.splitlines()[0]
    assert re.match(r"mass 50 g, load 0\.49 N, hv 1\.5 µm: gap 4\.6.*, modelling error -0", first)


def test_a_table_of_several_loads_has_values_with_their_errors(edited, capsys):
    """It had 25 columns in metres."""
    words = ["levitate", "--mass", "50g,90kg", "--hv", "1.5um", "--config", str(edited("paper"))]
    assert main(words) == 1
    said = capsys.readouterr()
    header, first, second, *below = said.out.splitlines()
    assert len(header) <= 180
    assert re.search(r"50 g  0\.49 N  1\.5 µm  4\.6\d+ ± \S+ µm .* kN/m  9\d\d\S* ± \S+ Hz ", first)
    assert second.endswith("see note")
    assert any("row 2: no gap" in line for line in below)
    assert "no gap for 1 of 2 rows; `status` has the reason" in said.err
