"""A fitted model used from its file alone: forces, working points, and generated code."""

import json
import math
import re
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from reference_forces import FOUR_FACTOR_THETA, SCREEN_THETA

from squeezefilm.cli import main as cli
from squeezefilm.cli.points import write_points
from squeezefilm.io.errors import InputError
from squeezefilm.io.typed_units import quantities, with_error
from squeezefilm.models.data import Factors
from squeezefilm.models.export import LANGUAGES, source
from squeezefilm.models.fit_file import read_fit
from squeezefilm.models.force_model import get_model, make_model
from squeezefilm.models.limit_table import LimitTable
from squeezefilm.models.prediction_interval import PredictionInterval
from squeezefilm.studies.config import load_config
from squeezefilm.studies.tasks.fits import limit_table_values
from squeezefilm.studies.tasks.physics_limits import limit_table_of

THETA = {
    "two_factor": SCREEN_THETA,
    "four_factor": FOUR_FACTOR_THETA,
    "polynomial_5": (4.5632, 2.3185, -1.3051, -5.497e4, -8e3),
    "limit_2": (112.1, -634.6),
}
RANGES = {
    "h0_m": [5e-6, 10e-6],
    "hv_m": [0.2e-6, 2e-6],
    "phi_r_m": [0.0, 2.9e-3],
    "phi_deg": [0.0, 45.0],
    "x_m": [0.0, 2.9e-3],
    "y_m": [0.0, 2.05e-3],
}


@pytest.fixture(scope="module")
def limit_table(repository):
    config = load_config(repository / "config" / "quick.yaml")
    return limit_table_of(config).model_dump(mode="json")


def validation(profile_uncertainty: float = 0.0) -> dict:
    """Of a model that is off by 2 mN and 1 % of the force at most at 95 % of points."""
    ranges = {name: tuple(RANGES[name]) for name in ("h0_m", "hv_m", "phi_r_m", "phi_deg")}
    interval = PredictionInterval(
        ranges=ranges,
        error_95=(2e-3, 0.01 + profile_uncertainty),
        error_99=(4e-3, 0.02 + profile_uncertainty),
        points=1000,
        failed=0,
        calibration_points=500,
        mean_coverage=0.95,
        profile_uncertainty=profile_uncertainty,
    )
    return interval.model_dump(mode="json")


@pytest.fixture
def write_fit(tmp_path, limit_table):
    """A function that writes the fit of a model."""

    def write(of, at, **more) -> Path:
        names = ("h0_m", "hv_m", "phi_r_m") if len(of.factor_names) == 2 else of.factor_names
        values: dict = {
            "model": of.name,
            "theta": list(at),
            "expression": of.expression,
            "parameters": list(of.parameter_names),
            "parameter_units": list(of.parameter_units),
            "points": 60,
            "global_error": 0.005,
            "sum_of_squares": 6e-5,
            "ranges": {name: RANGES[name] for name in names},
            "cross_validation": {"root_mean_square_n": 2e-3, "global_error": 6e-3},
            "validation": validation(),
        }
        if of.column_names:
            values["limit_table"] = limit_table
        path = tmp_path / f"{of.name}.json"
        path.write_text(json.dumps(values | more))
        return path

    return write


def table_of(arguments: list[str], tmp_path: Path) -> pd.DataFrame:
    assert cli.main([*arguments, f"--output={tmp_path}/out.csv"]) == 0
    return pd.read_csv(tmp_path / "out.csv", dtype={"note": str}).fillna({"note": ""})


@pytest.mark.parametrize("name", THETA)
def test_predict_knows_the_model_from_the_file_alone(name, write_fit, tmp_path):
    model = get_model(name)
    # Another name: nothing but the file can tell what the model is.
    renamed = make_model(
        "mine",
        {
            "expression": model.expression,
            "parameters": dict(zip(model.parameter_names, model.parameter_units, strict=True)),
        },
        place="test",
    )
    path = write_fit(renamed, THETA[name])
    table = table_of(
        ["predict", str(path), "--h0=5um,8um", "--hv=0.5um:2um:4", "--phi-r=1mm", "--phi=30deg"],
        tmp_path,
    )
    assert len(table) == 8
    factors = Factors.of(**{c: table[c] for c in ("h0_m", "hv_m", "phi_r_m", "phi_deg")})
    expected = model.evaluate(THETA[name], read_fit(path).complete(factors))
    np.testing.assert_allclose(table["force_n"], expected, rtol=1e-12)
    np.testing.assert_allclose(table["error_95_n"], 2e-3 + 0.01 * expected, rtol=1e-12)
    np.testing.assert_allclose(table["error_99_n"], 4e-3 + 0.02 * expected, rtol=1e-12)


def test_the_uncertainty_of_a_scan_is_part_of_every_error_and_named(write_fit, tmp_path):
    model, theta = get_model("two_factor"), THETA["two_factor"]
    predicted, found = [], []
    for share in (0.0, 0.03):
        more = {"validation": validation(share), "profile_uncertainty": share}
        words = [str(write_fit(model, theta, **more)), "--h0=5um"]
        predicted.append(table_of(["predict", *words, "--hv=1.5um"], tmp_path).iloc[0])
        found.append(table_of(["working-point", *words, "--force=0.4N"], tmp_path).iloc[0])
    for without, within in (predicted, found):
        assert within["error_95_percent"] == pytest.approx(without["error_95_percent"] + 3)
        assert within["profile_uncertainty_percent"] == pytest.approx(3)
        assert "profile_uncertainty_percent" not in without
    without, within = (row["error_95_n"] for row in predicted)
    assert within == pytest.approx(without + 0.03 * predicted[0]["force_n"])
    without, within = (row["hv_error_95_m"] for row in found)
    assert within == pytest.approx(without * (6e-3 + 0.03 * 0.4) / 6e-3)


def test_predict_takes_a_table(write_fit, tmp_path):
    path = write_fit(get_model("two_factor"), THETA["two_factor"])
    (tmp_path / "points.csv").write_text("name,h0_m,hv_m\nA,5e-6,1e-6\nB,6e-6,1e-6\n")
    table = table_of(["predict", str(path), f"--points={tmp_path}/points.csv"], tmp_path)
    assert list(table["name"]) == ["A", "B"]
    assert table["error_95_n"].notna().all()


def test_every_use_of_a_model_says_the_same_sentence(write_fit, capsys):
    path = write_fit(get_model("two_factor"), THETA["two_factor"])
    statement = read_fit(path).statement
    assert "95 % have a force within the stated 95 % error" in statement
    assert "not a promise for each" in statement
    words = [str(path), "--h0=5um"]
    for command in (["predict", *words, "--hv=1um"], ["working-point", *words, "--force=0.4N"]):
        assert cli.main(command) == 0
        assert statement in capsys.readouterr().out
    for language in LANGUAGES:
        assert cli.main(["export", str(path), f"--language={language}"]) == 0
        said = re.sub(r"[\s*/]+", " ", capsys.readouterr().out)
        assert re.sub(r"[\s*/]+", " ", statement.replace("φ", "phi_")) in said


@pytest.mark.parametrize(
    ("options", "note"),
    [
        (["--h0=5um", "--hv=1um"], ""),
        (["--h0=5um", "--hv=2.2um"], "hv_m outside 2e-07"),
        (["--h0=4um", "--hv=1um"], "h0_m outside 5e-06"),
        (["--h0=5um", "--hv=1um", "--phi-r=2.95mm", "--phi=10deg"], "phi_r_m outside"),
        (["--h0=1um", "--hv=0.9um"], "undefined here"),
    ],
)
def test_extrapolation_is_noted(options, note, write_fit, tmp_path):
    path = write_fit(get_model("four_factor"), THETA["four_factor"])
    table = table_of(["predict", str(path), *options], tmp_path)
    assert (note in table["note"][0]) if note else table["note"][0] == ""
    for name in ("error_95_percent", "error_95_n", "error_99_n"):
        assert np.isnan(table[name][0]) == bool(note)


@pytest.mark.parametrize("name", ["two_factor", "four_factor", "limit_2"])
def test_the_working_point_gives_the_wanted_force(name, write_fit, tmp_path):
    path = write_fit(get_model(name), THETA[name])
    arguments = ["working-point", str(path), "--force=0.5N", "--h0=5um:6um:3", "--phi-r=1mm"]
    found = table_of([*arguments, "--phi=20deg"], tmp_path)
    assert len(found) == 3
    factors = Factors.of(**{c: found[c] for c in ("h0_m", "hv_m", "phi_r_m", "phi_deg")})
    fit = read_fit(path)
    force = get_model(name).evaluate(THETA[name], fit.complete(factors))
    np.testing.assert_allclose(force, 0.5, rtol=1e-10)
    # An amplitude larger by its error gives a force larger by the model's.
    more = replace(factors, hv_m=factors.hv_m + found["hv_error_95_m"].to_numpy())
    rise = get_model(name).evaluate(THETA[name], fit.complete(more)) - force
    np.testing.assert_allclose(rise, 2e-3 + 0.01 * 0.5, rtol=3e-2)


def test_a_force_beyond_the_models_reach_is_told(write_fit, tmp_path):
    path = write_fit(get_model("polynomial_5"), THETA["polynomial_5"])
    found = table_of(["working-point", str(path), "--force=100"], tmp_path)
    assert len(found) == 6
    assert found["hv_m"].isna().all()
    assert all("below contact" in note for note in found["note"])


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--h0=5um"], "give --h0 and --hv"),
        (["--h0=5", "--hv=1um"], "--h0 '5' must be a number with a unit of m"),
        (["--h0=5um", "--hv=1N"], "--hv '1N'"),
        (["--h0=2um+3um", "--hv=1um"], "--h0 '2um+3um'"),
        (["--h0=5furlong", "--hv=1um"], "a unit of m (m, mm, um, µm, μm, nm, cm, pm)"),
        (["--h0=5um:6um", "--hv=1um"], "first:last:count"),
        (["--h0=5um:6um:100000000", "--hv=1um"], "count must lie"),
        (["--h0=5um:6um:9999", "--hv=1um:2um:9999"], "at most 1000000"),
        (["--h0=0m", "--hv=1um"], "gaps must be positive"),
        (["--h0=5um", "--hv=1um", "--x=1mm", "--phi-r=1mm"], "not both"),
        (["--points=/nowhere.csv"], "there is no such table"),
        (["--h0=__import__('os')", "--hv=1um"], "must be a number"),
    ],
)
def test_points_that_mean_nothing_are_refused(options, message, write_fit, refused):
    path = write_fit(get_model("two_factor"), THETA["two_factor"])
    assert message in refused("predict", str(path), *options)


def test_quantities_have_units_commas_and_ranges():
    assert quantities("5um, 0.007mm", option="--h0", unit="m") == pytest.approx([5e-6, 7e-6])
    assert quantities("0deg:45deg:4", option="--phi", unit="deg") == [0, 15, 30, 45]
    assert quantities("-5e-3 mm,.5µm", option="--x", unit="m") == pytest.approx([-5e-6, 5e-7])
    assert quantities("1rad", option="--phi", unit="deg") == pytest.approx([180 / math.pi])
    assert quantities("5um", option="--h0", unit="m") == [5e-6]


def test_one_unit_at_the_end_is_that_of_all_numbers():
    assert quantities("0.5, 1,2 um", option="--hv", unit="m") == [5e-7, 1e-6, 2e-6]
    assert quantities("-2:2:3mm", option="--x", unit="m") == [-2e-3, 0, 2e-3]
    assert quantities("0:45:4°", option="--phi", unit="deg") == [0, 15, 30, 45]
    for text in ("1,2", "1:2:3", "5um,6", "5:6um:3", "1:2um", "1:2:3:4um", "5:6:x um", "5:6:1um"):
        with pytest.raises(InputError, match="--h0"):
            quantities(text, option="--h0", unit="m")


@pytest.mark.parametrize(
    ("damage", "message"),
    [
        ({"expression": "__import__('os').getcwd()"}, "no known function"),
        ({"expression": "h0.__class__"}, "no arithmetic"),
        ({"expression": 5}, "expression: Input should be a valid string"),
        ({"expression": "theta0*hv"}, "'theta1' does not occur"),
        ({"parameters": "theta0"}, "parameters: Input should be a valid list"),
        ({"parameters": ["theta0"]}, "parameter_units: give one for each"),
        ({"theta": [1.0]}, "'theta' has 1 numbers"),
        ({"theta": ["x"]}, "theta.0: Input should be a valid number"),
        ({"ranges": {"h0_m": 5}}, "ranges.h0_m: Input should be a valid tuple"),
        ({"validation": {"points": 1}}, "validation.ranges: Field required"),
        ({"film": {"gas": {}}}, "film.gas.viscosity_pa_s: Field required"),
        ({"refused": "no fit"}, "there is no fit: no fit"),
    ],
)
def test_a_damaged_fit_is_refused(damage, message, write_fit, refused):
    path = write_fit(get_model("two_factor"), THETA["two_factor"], **damage)
    error = refused("predict", path, "--h0=5um", "--hv=1um")
    assert message in error
    assert str(path) in error


def sample(count: int = 200) -> dict[str, np.ndarray]:
    rng = np.random.default_rng(5)
    return {
        "h0_m": rng.uniform(5e-6, 10e-6, count),
        "hv_m": rng.uniform(0.0, 2.2e-6, count),
        "phi_r_m": rng.uniform(0, 2.9e-3, count) * (np.arange(count) > 3),
        "phi_deg": rng.uniform(0, 45, count),
    }


EVERY_FUNCTION = make_model(
    "every_function",
    {
        "expression": "t0*sinc(hv/h0)*exp(-abs(x)/r_scale) + t1*tanh(hv/h0)*cos(angle)**3"
        " + t2*log(1 + (hv/h0)**2)*atan(sqrt(hv/h0)) - 0.1*sin(angle)*cosh(hv/h0)/sinh(1 + hv/h0)"
        " + tan(hv/h0)*2**(-h0/y_scale)",
        "parameters": {"r_scale": "m", "y_scale": "m"},
    },
    place="test",
)
EXPORTED = [
    *((get_model(name), theta) for name, theta in THETA.items()),
    (EVERY_FUNCTION, (1e-3, 5e-6, 0.7, 0.2, 0.4)),
]
exported = pytest.mark.parametrize(("model", "theta"), EXPORTED, ids=lambda each: "")


@exported
def test_the_python_function_is_the_model(model, theta, write_fit):
    fit = read_fit(write_fit(model, theta))
    names: dict = {}
    exec(source(fit, "python"), names)
    factors = Factors.of(**sample())
    expected = fit.force_model.evaluate(fit.theta, fit.complete(factors))
    columns = [factors.column(name) for name in model.factor_names]
    found = [names["force_n"](*point) for point in zip(*columns, strict=True)]
    np.testing.assert_allclose(found, expected, rtol=1e-14, atol=1e-15)
    assert np.isfinite(found).all()


@exported
def test_the_c_function_is_the_model(model, theta, write_fit, tmp_path):
    compiler = shutil.which("cc") or shutil.which("gcc")
    if compiler is None:
        pytest.skip("no C compiler (cc or gcc) here")
    fit = read_fit(write_fit(model, theta))
    (tmp_path / "model.h").write_text(source(fit, "c"))
    count = len(model.factor_names)
    arguments = ", ".join(f"p[{index}]" for index in range(count))
    reading = "%lf" * count
    (tmp_path / "main.c").write_text(
        '#include <stdio.h>\n#include "model.h"\n'
        f"int main(void) {{ double p[{count}];\n"
        f'while (scanf("{reading}", {", ".join(f"p + {i}" for i in range(count))}) == {count})\n'
        f'printf("%.17g %d\\n", {fit.model}_force_n({arguments}), '
        f"{fit.model}_in_range({arguments}));\nreturn 0; }}\n"
    )
    program = tmp_path / "main"
    strict = ["-std=c99", "-Wall", "-Wextra", "-Werror", "-Wno-unused-function", "-O1"]
    command = [compiler, *strict, "-o", str(program), str(tmp_path / "main.c"), "-lm"]
    subprocess.run(command, check=True, timeout=60)
    factors = Factors.of(**sample())
    columns = np.column_stack([factors.column(name) for name in model.factor_names])
    text = "\n".join(" ".join(f"{value!r}" for value in map(float, row)) for row in columns)
    output = subprocess.run(
        [str(program)], input=text, capture_output=True, text=True, check=True, timeout=60
    ).stdout
    found, inside = np.array([line.split() for line in output.splitlines()], dtype=float).T
    expected = fit.force_model.evaluate(fit.theta, fit.complete(factors))
    np.testing.assert_allclose(found, expected, rtol=1e-14, atol=1e-15)
    np.testing.assert_array_equal(inside == 0, (factors.hv_m > 2e-6) | (factors.hv_m < 0.2e-6))


@exported
def test_the_javascript_function_is_the_model(model, theta, write_fit):
    node = shutil.which("node")
    if node is None:
        pytest.skip("no node here; tests/browser runs the same code in a browser")
    fit = read_fit(write_fit(model, theta))
    factors = Factors.of(**sample())
    points = np.column_stack([factors.column(name) for name in model.factor_names]).tolist()
    script = (
        f"{source(fit, 'javascript')}\n"
        f"const each = {json.dumps(points)}.map((p) => {fit.model}.force_n(...p));\n"
        f"const inside = {json.dumps(points)}.map((p) => {fit.model}.in_range(...p));\n"
        "console.log(JSON.stringify([each, inside]));"
    )
    output = subprocess.run([node], input=script, capture_output=True, text=True, timeout=60)
    assert output.returncode == 0, output.stderr
    found, inside = json.loads(output.stdout)
    expected = fit.force_model.evaluate(fit.theta, fit.complete(factors))
    np.testing.assert_allclose(np.array(found, dtype=float), expected, rtol=1e-14, atol=1e-15)
    assert np.isfinite(expected).all()
    outside = (factors.hv_m > 2e-6) | (factors.hv_m < 0.2e-6)
    np.testing.assert_array_equal(~np.array(inside), outside)


def test_generated_code_has_the_95_percent_error(write_fit):
    names: dict = {}
    fit = write_fit(get_model("two_factor"), THETA["two_factor"])
    exec(source(read_fit(fit), "python"), names)
    assert names["error_95_n"](-0.5) == pytest.approx(2e-3 + 0.01 * 0.5)
    bare = json.loads(fit.read_text())
    del bare["validation"]
    fit.write_text(json.dumps(bare))
    exec(source(read_fit(fit), "python"), names)
    assert math.isnan(names["error_95_n"](0.5))


def test_outside_its_domain_generated_code_gives_no_number(write_fit):
    names: dict = {}
    fit = read_fit(write_fit(get_model("two_factor"), THETA["two_factor"]))
    exec(source(fit, "python"), names)
    assert math.isnan(names["force_n"](1e-6, 0.99e-6))
    assert math.isnan(names["force_n"](0.0, 1e-6))
    limit: dict = {}
    exec(source(read_fit(write_fit(get_model("limit_2"), THETA["limit_2"])), "python"), limit)
    assert math.isnan(limit["force_n"](5e-6, 1e-6, 5e-3, 0.0))


def test_an_export_goes_to_a_file_or_is_refused(write_fit, tmp_path, refused):
    path = write_fit(get_model("two_factor"), THETA["two_factor"])
    out = tmp_path / "force.h"
    assert cli.main(["export", str(path), "--language=c", f"--output={out}"]) == 0
    assert "two_factor_force_n(double h0_m, double hv_m)" in out.read_text()
    bare = json.loads(write_fit(get_model("limit_2"), THETA["limit_2"]).read_text())
    del bare["limit_table"]
    path.write_text(json.dumps(bare))
    for command in (["export", "--language=python"], ["predict", "--h0=5um", "--hv=1um"]):
        assert "table" in refused(command[0], str(path), *command[1:])


@pytest.mark.parametrize("name", ['x"); system("true', "a b", "*/", "é", ""])
def test_a_fits_name_cannot_carry_code(name, write_fit):
    fit = read_fit(write_fit(get_model("two_factor"), THETA["two_factor"], model=name))
    for language in LANGUAGES:
        with pytest.raises(InputError, match="cannot name a function"):
            source(fit, language)


def test_the_table_of_limits_states_its_error(limit_table):
    table = LimitTable.model_validate(json.loads(json.dumps(limit_table)))
    assert 0 < table.largest_relative_error < 1e-6
    outside = Factors.of(h0_m=[5e-6, 4e-6, 5e-6], hv_m=[4e-6, 1e-6, 1e-6], x_m=[0, 0, 5e-3])
    assert np.isnan(table.complete(outside).column("limit_n")).all()


@pytest.mark.parametrize(
    ("damage", "message"),
    [
        ({"ranges": {}}, "ranges must be of h0_m, epsilon_square"),
        ({"shape": [1, 2, 3, 4]}, "24 coefficients are needed"),
        ({"coefficients": {"evil": [0.0]}}, "coefficients.evil"),
    ],
)
def test_a_damaged_table_of_limits_is_refused(damage, message, limit_table, write_fit):
    model = get_model("limit_2")
    path = write_fit(model, THETA["limit_2"], limit_table=limit_table | damage)
    with pytest.raises(InputError, match=rf"limit_2\.json: limit_table.*{message}"):
        read_fit(path)


def test_where_the_limit_does_not_hold_the_table_says_so(edited):
    values = limit_table_values(load_config(edited(finger={"speed_x_m_per_s": 2})))
    assert "not derived with bearing" in values["refused"]


@pytest.mark.parametrize(
    ("force_n", "error_n", "shown"),
    [
        (0.9620420431, 6.31e-7, "0.9620420 N ± 6e-07 N"),
        (0.9620420431, 0.0096, "0.96 N ± 0.01 N"),
        (12.34, 0.52, "12.3 N ± 0.5 N"),
        (123.4, 12.0, "1.2e+02 N ± 1e+01 N"),
        (-1.2e-75, 4.3e-73, "-1e-75 N ± 4e-73 N"),
        (0.9620420431, math.nan, "0.962 N ± unknown N"),
        (0.0, 0.0, "0 N ± 0 N"),
    ],
)
def test_a_force_has_the_digits_that_its_error_leaves(force_n, error_n, shown):
    assert with_error(force_n, error_n) == shown


def test_a_force_is_printed_to_its_error(capsys):
    write_points(pd.DataFrame({"force_n": [0.0774, 0.4811], "error_95_n": [0.0038, 0.114]}), None)
    rows = [line.split() for line in capsys.readouterr().out.splitlines()[1:]]
    assert [row[:2] for row in rows] == [["0.077", "0.004"], ["0.5", "0.1"]]
