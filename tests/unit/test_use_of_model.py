"""A fitted model used from its file alone: forces, amplitudes, and generated code."""

import json
import math
import re
import shutil
import subprocess
from itertools import product
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from reference_forces import FOUR_FACTOR_THETA, SCREEN_THETA

from squeezefilm.api.models import Fit
from squeezefilm.cli import main as cli
from squeezefilm.config.loading import load_config
from squeezefilm.errors import InputError
from squeezefilm.models.data import Factors
from squeezefilm.models.export import NAN_OF_LANGUAGE, source_code
from squeezefilm.models.fit_file import read_fit
from squeezefilm.models.force_model import get_model, make_model
from squeezefilm.models.limit_table import LimitTable
from squeezefilm.models.prediction_interval import PredictionInterval
from squeezefilm.studies.study import film_values
from squeezefilm.studies.tasks.physics_limits import limit_table_of_study
from squeezefilm.units import parse_quantities, value_and_error_texts

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
    return limit_table_of_study(config).model_dump(mode="json")


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
            "format": 1,
            "error_scale": [0.0, 1.0],
            "profile_uncertainty": 0.0,
            "directions": None,
            "film": None,
            "model": of.name,
            "theta": list(at),
            "expression": of.expression,
            "constants": dict(of.constants),
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


def table_of(arguments: list[str], tmp_path: Path, *, status: int = 0) -> pd.DataFrame:
    assert cli.main([*arguments, f"--output={tmp_path}/out.csv"]) == status
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
            "constants": model.constants,
        },
        source="test",
    )
    path = write_fit(renamed, THETA[name])
    table = table_of(
        ["predict", str(path), "--h0=5um,8um", "--hv=0.5um:2um:4", "--phi-r=1mm", "--phi=30deg"],
        tmp_path,
    )
    assert len(table) == 8
    factors = Factors.of(**{c: table[c] for c in ("h0_m", "hv_m", "phi_r_m", "phi_deg")})
    expected = model.evaluate(THETA[name], read_fit(path).with_asymptotic_forces(factors))
    np.testing.assert_allclose(table["force_n"], expected, rtol=1e-12)
    np.testing.assert_allclose(table["error_95_n"], 2e-3 + 0.01 * expected, rtol=1e-12)
    np.testing.assert_allclose(table["error_99_n"], 4e-3 + 0.02 * expected, rtol=1e-12)


@pytest.mark.parametrize(
    ("options", "note"),
    [
        (["--h0=5um", "--hv=1um"], ""),
        (["--h0=5um", "--hv=2.2um"], "hv = 2.2 µm outside 0.2 … 2 µm"),
        (["--h0=5um", "--hv=1um", "--phi-r=2.95mm", "--phi=10deg"], "r = 2.95 mm outside"),
        (["--h0=1um", "--hv=0.9um"], "the formula has no value here"),
    ],
)
def test_extrapolation_is_noted(options, note, write_fit, tmp_path):
    path = write_fit(get_model("four_factor"), THETA["four_factor"])
    no_value = "no value" in note
    table = table_of(["predict", str(path), *options], tmp_path, status=int(no_value))
    assert (note in table["note"][0]) if note else table["note"][0] == ""
    for name in ("error_95_percent", "error_95_n", "error_99_n"):
        assert np.isnan(table[name][0]) == bool(note)


@pytest.mark.parametrize("command", [["predict", "--hv=2.2um"], ["amplitude-for", "--force=1.2N"]])
def test_a_point_outside_has_the_reason_in_place_of_its_error(command, write_fit, capsys):
    """The sentence about 95 % of the points says nothing of this one."""
    name, *options = command
    path = write_fit(get_model("two_factor"), THETA["two_factor"])
    assert cli.main([name, str(path), "--h0=5um", *options]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert re.fullmatch(
        r"prediction error \(95 %\) +not validated: hv = 2\.\d+ µm outside 0\.2 … 2 µm", lines[1]
    )
    assert "not available" not in "".join(lines)
    assert "95 % have" not in "".join(lines)


@pytest.mark.parametrize("command", [["predict", "--hv=1um"], ["amplitude-for", "--force=0.2N"]])
@pytest.mark.parametrize(
    ("option", "taken"),
    [
        ([], "x = 0 m, y = 0 m"),
        (["--x=1mm"], "x = 1 mm, y = 0 m"),
        (["--phi-r=1mm"], "phi_r = 1 mm, phi = 0 °"),
    ],
)
def test_the_operating_point_has_the_position_that_is_taken(
    command, option, taken, write_fit, capsys
):
    name, *options = command
    path = write_fit(get_model("four_factor"), THETA["four_factor"])
    assert cli.main([name, str(path), "--h0=6um", *options, *option]) == 0
    (line,) = re.findall("operating point.*", capsys.readouterr().out)
    assert line.endswith(f", {taken}")


@pytest.mark.parametrize(
    ("model", "command", "reason"),
    [
        ("four_factor", ["predict", "--hv=1um", "--x=8mm"], "pad lies 13.928 mm from the centre"),
        (
            "four_factor",
            ["amplitude-for", "--force=0.2N", "--x=8mm"],
            "may lie at most 3.66 mm out",
        ),
        ("four_factor", ["predict", "--hv=6um"], "reaches h0 = 5 µm: surface and pad touch"),
        ("limit_2", ["predict", "--h0=12um", "--hv=1um"], "expansion ends at h0 = 5 and 10 µm"),
        ("limit_2", ["amplitude-for", "--h0=12um", "--force=0.2N"], "expansion ends at h0 = 5 and"),
        ("limit_2", ["amplitude-for", "--force=15N"], "µm, not 15 N; the table of the expansion"),
    ],
)
def test_a_point_without_a_result_ends_with_the_reason_and_status_1(
    model, command, reason, write_fit, repository, tmp_path, capsys
):
    """One point prints the reason alone, once; a table has it in its row."""
    paper = load_config(repository / "config" / "paper.yaml")
    film = film_values(paper, absent_terms=["inertia; thermal effects"])
    name, *options = command
    arguments = [name, str(write_fit(get_model(model), THETA[model], film=film)), "--h0=5um"]
    assert cli.main([*arguments, *options]) == 1
    printed = capsys.readouterr()
    assert not printed.out
    assert printed.err.count(reason) == 1
    # The other row is there all the same.
    table = table_of([*arguments[:-1], *options, f"--h0={_h0_of(options)},6um"], tmp_path, status=1)
    result = "force_n" if name == "predict" else "hv_m"
    assert np.isnan(table[result][0])
    assert reason in f"{table['validity'][0]} {table['note'][0]}"
    assert reason not in capsys.readouterr().err


def test_without_a_table_of_the_expansion_at_a_gap_no_amplitude_is_tried(write_fit, capsys):
    path = write_fit(get_model("limit_2"), THETA["limit_2"])
    assert cli.main(["amplitude-for", str(path), "--h0=12um", "--force=0.2N"]) == 1
    reason = "no amplitude hv: the table of the expansion ends at h0 = 5 and 10 µm\n"
    assert capsys.readouterr().err.endswith(reason)


def test_notes_on_rows_stand_below_their_table(write_fit, capsys):
    """Each row had its note in a column of 200 characters."""
    path = write_fit(get_model("two_factor"), THETA["two_factor"])
    assert cli.main(["predict", str(path), "--h0=5um,6um", "--hv=1um,2.2um"]) == 0
    header, *rows, below = capsys.readouterr().out.split("\n", maxsplit=5)
    assert "note" not in header
    assert [row.split()[0] for row in rows] == ["1", "2", "3", "4"]
    assert re.search(r"\n +rows 2, 4: not validated: hv = 2\.2 µm outside", below)


def test_a_table_of_points_is_read_as_a_table_of_scenes(write_fit, refused, tmp_path):
    """A position under a misspelt name was ignored: the force was that at the centre."""
    fit, path = write_fit(get_model("four_factor"), THETA["four_factor"]), tmp_path / "points.csv"
    for table, message in {
        "h0_um,hv_um,xx_mm\n5,1,2\n": "unknown column 'xx_mm' (did you mean 'x_mm'?)",
        "h0_um,hv_um\n5,abc\n": f"{path}: line 2: hv_um is 'abc', not a finite number",
    }.items():
        path.write_text(table, encoding="utf-8")
        assert message in refused("predict", fit, "--points", path)


def test_a_fit_without_a_sample_states_why_it_has_no_force_too(write_fit, capsys):
    path = write_fit(get_model("limit_2"), THETA["limit_2"], validation=None)
    assert cli.main(["predict", str(path), "--h0=12um", "--hv=1um"]) == 1
    error = capsys.readouterr().err
    assert error.endswith("--sample`); the table of the expansion ends at h0 = 5 and 10 µm\n")


def _h0_of(options: list[str]) -> str:
    return next((each[5:] for each in options if each.startswith("--h0=")), "5um")


def test_a_fit_without_the_surface_does_not_say_that_the_pad_lies_on_it(write_fit, repository):
    plate = load_config(repository / "config" / "plate.yaml")
    film = film_values(plate, absent_terms=["inertia; thermal effects"])
    points = pd.DataFrame({"h0_m": 5e-6, "hv_m": 1e-6, "x_m": [0.0, 1e-3, 20e-3], "y_m": 0.0})

    def validity(film: dict) -> list[str]:
        path = write_fit(get_model("four_factor"), THETA["four_factor"], film=film)
        Fit.read(path).save(path)
        return list(Fit.read(path).predict_at(points)["validity"])

    assert validity(film)[:2] == ["ok", "ok"]
    assert "the edge of the pad lies at x = " in validity(film)[2]
    del film["surface"]
    assert [text[:9] for text in validity(film)] == ["ok", "ok", "not known"]


def test_a_region_that_the_interval_covers_badly_is_noted(write_fit):
    """At 10 µm 76 % of the sample lay within the 95 % error, and the force had no note."""
    own = validation()
    high = {"quantity": "h0_m", "third": "high", "lower": 8e-6, "upper": None}
    high |= {"coverage": 0.76, "points": 167}
    path = write_fit(get_model("two_factor"), THETA["two_factor"])
    known = write_fit(
        get_model("four_factor"), THETA["four_factor"], validation=own | {"coverage": [high]}
    )
    found = Fit.read(known).predict(h0="5um,9um", hv="1um")
    text = "the 95 % error holds 76 % of 167 validation points in the high third of the gap h0"
    assert list(found["note"]) == ["", text]
    assert np.isfinite(found["error_95_n"]).all()
    assert list(Fit.read(path).predict(h0="5um,9um", hv="1um")["note"]) == ["", ""]


def test_the_validation_states_the_part_of_an_error_that_it_measures(write_fit, tmp_path):
    """A 95 % error of 2.1 % stood beside a coverage of 0.4 %: the rest was the scan's."""
    model, theta = get_model("two_factor"), THETA["two_factor"]
    path = write_fit(model, theta, validation=validation(0.016), profile_uncertainty=0.016)
    predicted = table_of(["predict", str(path), "--h0=5um,6um", "--hv=1um"], tmp_path)
    amplitudes = table_of(["amplitude-for", str(path), "--force=0.2N", "--h0=5um,6um"], tmp_path)
    for table in (predicted, amplitudes):
        assert list(table["profile_uncertainty_percent"]) == [1.6, 1.6]
        own = 1.0 + 100 * 2e-3 / table["force_n"]
        np.testing.assert_allclose(table["error_95_without_scan_percent"], own, rtol=1e-9)
        np.testing.assert_allclose(table["error_95_percent"], own + 1.6, rtol=1e-9)
    assert "within the stated 95 % error less the 1.6 % of the scan" in read_fit(path).statement
    without = read_fit(write_fit(model, theta))
    assert "within the stated 95 % error, as measured" in without.statement


@pytest.mark.parametrize("name", ["two_factor", "four_factor", "limit_2"])
def test_the_working_point_gives_the_wanted_force(name, write_fit, tmp_path):
    path = write_fit(get_model(name), THETA[name])
    arguments = ["amplitude-for", str(path), "--force=0.5N", "--h0=5um:6um:3", "--phi-r=1mm"]
    found = table_of([*arguments, "--phi=20deg"], tmp_path)
    assert len(found) == 3
    given = {c: found[c] for c in ("h0_m", "hv_m", "phi_r_m", "phi_deg")}
    fit = read_fit(path)
    force = get_model(name).evaluate(THETA[name], fit.with_asymptotic_forces(Factors.of(**given)))
    np.testing.assert_allclose(force, 0.5, rtol=1e-10)
    # An amplitude larger by its error gives a force larger by the model's.
    more = Factors.of(**given | {"hv_m": found["hv_m"] + found["hv_error_95_m"]})
    rise = get_model(name).evaluate(THETA[name], fit.with_asymptotic_forces(more)) - force
    np.testing.assert_allclose(rise, 2e-3 + 0.01 * 0.5, rtol=3e-2)


def test_an_amplitude_states_what_its_errors_are_relative_to(write_fit, capsys):
    """1.0 % of the amplitude stood above 2.1 % of the force, and nothing said which was which."""
    path = write_fit(get_model("four_factor"), THETA["four_factor"])
    assert cli.main(["amplitude-for", str(path), "--force=0.5N", "--h0=5um"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert re.fullmatch(
        r"prediction error \(95 %\) +± 0\.0\d+ µm, 0\.\d+ % of the amplitude", lines[1]
    )
    assert re.fullmatch(r"prediction error of the force \(95 %\) +1\.\d %", lines[3])


def test_a_parameter_without_a_unit_is_a_number_alone(write_fit):
    """It was followed by the unit 1, as one more number."""
    fit = Fit.read(write_fit(get_model("two_factor"), THETA["two_factor"]))
    name, value = next(iter(fit.theta.items()))
    (line,) = [line.split() for line in str(fit).splitlines() if line.startswith(f"{name} ")]
    assert line == [name, f"{value:.6g}"]


def test_one_unit_at_the_end_is_that_of_all_numbers():
    assert parse_quantities("0.5, 1, 2 um", option="--hv", unit="m") == [5e-7, 1e-6, 2e-6]
    assert parse_quantities("-2:2:3mm", option="--x", unit="m") == [-2e-3, 0, 2e-3]
    assert parse_quantities("0:45:4°", option="--phi", unit="deg") == [0, 15, 30, 45]
    for text in ("1,2", "1:2:3", "5um,6", "5:6um:3", "1:2um", "1:2:3:4um", "5:6:x um", "5:6:1um"):
        with pytest.raises(InputError, match="--h0"):
            parse_quantities(text, option="--h0", unit="m")


@pytest.mark.parametrize("text", ["5um..10um", "5-10um", "5 to 10 um", "5…10um"])
def test_a_range_in_another_form_is_told_how_it_is_written(text):
    with pytest.raises(InputError, match="a range is first:last:count, such as 5:10:6um"):
        parse_quantities(text, option="--h0", unit="m")


@pytest.mark.parametrize("text", ["1e-3", "-5", "5kg"])
def test_a_number_without_its_unit_is_no_range(text):
    with pytest.raises(InputError, match="must be a number with its unit"):
        parse_quantities(text, option="--h0", unit="m")


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ("7,5um", r"7\.5um, or 7um,5um\?"),
        ("5,5um", r"5\.5um, or 5um,5um\?"),
        ("0.5,1,2um", r"'0\.5,1,2um': 0\.5um,1um,2um\?"),
        ("0.5,0.6um", r"'0\.5,0\.6um': 0\.5um,0\.6um\?"),
        ("5um,0.005mm", "a value stands twice"),
        ("5:5:3um", "a value stands twice"),
    ],
)
def test_a_decimal_comma_and_equal_values_are_invalid(values, message, write_fit, refused):
    """`7,5um` was 7 and 5 µm, and `5,5um` with `2,2um` four equal rows."""
    path = write_fit(get_model("two_factor"), THETA["two_factor"])
    for command in (["simulate"], ["error-budget"], ["predict", path]):
        error = refused(*command, f"--h0={values}", "--hv=1um")
        assert re.search(message, error)
    assert re.search(message, refused("levitate", "--load=0.1N", f"--hv={values}"))


@pytest.mark.parametrize(
    ("damage", "message"),
    [
        ({"expression": "__import__('os').getcwd()"}, "no known function"),
        ({"theta": [1.0]}, "'theta' has 1 numbers"),
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
    source="test",
)
EXPORTED = [
    *((get_model(name), theta) for name, theta in THETA.items()),
    (EVERY_FUNCTION, (1e-3, 5e-6, 0.7, 0.2, 0.4)),
]


def in_python(fit, points: np.ndarray, folder: Path) -> list[list[float]]:
    names: dict = {}
    exec(source_code(fit, "python"), names)
    return [[names["force_n"](*point), names["in_range"](*point)] for point in points.tolist()]


def in_c(fit, points: np.ndarray, folder: Path) -> list[list[float]]:
    compiler = shutil.which("cc") or shutil.which("gcc")
    if compiler is None:
        pytest.skip("no C compiler (cc or gcc) here")
    (folder / "model.h").write_text(source_code(fit, "c"))
    at = [f"p[{index}]" for index in range(points.shape[1])]
    values, pointers = ", ".join(at), ", ".join(f"&{each}" for each in at)
    (folder / "main.c").write_text(
        '#include <stdio.h>\n#include "model.h"\n'
        f"int main(void) {{ double p[{len(at)}];\n"
        f'while (scanf("{"%lf" * len(at)}", {pointers}) == {len(at)})\n'
        f'printf("%.17g %d\\n", {fit.model}_force_n({values}), {fit.model}_in_range({values}));\n'
        "return 0; }\n"
    )
    strict = ["-std=c99", "-Wall", "-Wextra", "-Werror", "-Wno-unused-function", "-O1"]
    command = [compiler, *strict, "-o", f"{folder}/main", f"{folder}/main.c", "-lm"]
    subprocess.run(command, check=True, timeout=60)
    text = "\n".join(" ".join(map(repr, point)) for point in points.tolist())
    done = subprocess.run(
        [f"{folder}/main"], input=text, capture_output=True, text=True, timeout=60
    )
    return [[float(word) for word in line.split()] for line in done.stdout.splitlines()]


def in_matlab(fit, points: np.ndarray, folder: Path) -> list[list[float]]:
    """The formula and the range as MATLAB has them; nothing here runs the rest of the file."""
    text = source_code(fit, "matlab")
    assert len(re.findall(r"^(?:function|if|for)\b", text, re.M)) + text.count("\n    if") == len(
        re.findall(r"^ *end$", text, re.M)
    )
    assert not re.search(r"\[[^\]]*,\n", text)  # a line that ends within brackets ends a row
    if "own_tabulated" in text:
        pytest.skip("no MATLAB and no Octave here to read its table")
    body = re.sub(r"theta\((\d+)\)", lambda at: f"theta[{int(at[1]) - 1}]", text)
    names = {name: getattr(np, name) for name in ("sin", "cos", "tan", "sinh", "cosh", "tanh")}
    names |= {"exp": np.exp, "own_sqrt": np.sqrt, "own_log": np.log, "atan": np.arctan}
    names |= {"pow": np.power, "fabs": np.abs, "own_sinc": np.sinc, "theta": fit.theta}
    names |= {"hypot": np.hypot, "atan2": np.arctan2}
    rows = []
    for point in points:
        given = names | dict(zip(fit.force_model.factor_names, point, strict=True))
        part = {
            name: np.array(eval(re.search(rf"^{name} = \[?(.*?)\]?;", body, re.M)[1] + ",", given))
            for name in ("value", "point", "low", "high")
        }
        inside = np.all((part["low"] <= part["point"]) & (part["point"] <= part["high"]))
        rows.append([float(part["value"][0]), float(inside)])
    return rows


def in_javascript(fit, points: np.ndarray, folder: Path) -> list[list[float]]:
    node = shutil.which("node")
    if node is None:
        pytest.skip("no node here; tests/browser runs the same code in a browser")
    both = f"[{fit.model}.force_n(...p), {fit.model}.in_range(...p)]"
    call = f"console.log(JSON.stringify({json.dumps(points.tolist())}.map((p) => {both})));"
    script = f"{source_code(fit, 'javascript')}\n{call}"
    output = subprocess.run([node], input=script, capture_output=True, text=True, timeout=60)
    assert output.returncode == 0, output.stderr
    return json.loads(output.stdout)


@pytest.mark.parametrize(("model", "theta"), EXPORTED, ids=lambda each: "")
@pytest.mark.parametrize("run", [in_python, in_c, in_javascript, in_matlab])
def test_exported_code_is_the_model(run, model, theta, write_fit, tmp_path):
    fit, factors = read_fit(write_fit(model, theta)), Factors.of(**sample())
    points = np.column_stack([factors.column(name) for name in model.factor_names])
    found, inside = np.array(run(fit, points, tmp_path), dtype=float).T
    np.testing.assert_allclose(found, fit.evaluate(factors), rtol=1e-14, atol=1e-15)
    assert np.isfinite(found).all()
    np.testing.assert_array_equal(inside == 0, (factors.hv_m > 2e-6) | (factors.hv_m < 0.2e-6))


@pytest.mark.parametrize("run", [in_python, in_c, in_javascript, in_matlab])
def test_exported_code_and_the_library_agree_on_the_declared_space(run, write_fit, tmp_path):
    """Of a model in r, phi on a rectangular surface as well as of one in x, y on a disc."""
    polar = make_model("polar", {"expression": "t0*hv/h0 + t1*r*cos(angle)"}, source="test")
    cartesian = make_model("cartesian", {"expression": "t0*hv/h0 + t1*x*y"}, source="test")
    film = {"h0_m": (5e-6, 10e-6), "hv_m": (0.2e-6, 2e-6)}
    disc = film | {"phi_r_m": (0.0, 2e-3), "phi_deg": (0.0, 45.0)}
    plate = film | {"x_m": (-3e-3, 3e-3), "y_m": (0.0, 1e-3)}
    positions = [[0, 90], [1e-3, 20], [1e-3, 60], [1e-3, -20], [2e-3, 45], [3e-3, 180], [4e-3, 10]]
    for model, space in product((polar, cartesian), (disc, plate)):
        own = {**validation(), "ranges": space}
        fit = read_fit(write_fit(model, (1.0, 1.0), validation=own))
        r_m, phi_deg = np.transpose(positions)
        factors = Factors.of(h0_m=7e-6, hv_m=1e-6, phi_r_m=r_m, phi_deg=phi_deg)
        points = np.column_stack([factors.column(name) for name in model.factor_names])
        _, inside = np.array(run(fit, points, tmp_path), dtype=float).T
        assert 0 < inside.sum() < len(points)
        np.testing.assert_array_equal(
            inside == 1, [not each for each in fit.prediction_interval.range_notes(factors)]
        )


SYMMETRIES = [
    {"start_deg": 10.0, "width_deg": 45.0, "mirror": True},
    {"start_deg": 0.0, "width_deg": 90.0, "mirror": False},
    {"mirror_x": True, "mirror_y": False},
]


@pytest.mark.parametrize("run", [in_python, in_c, in_javascript])
@pytest.mark.parametrize("symmetry", SYMMETRIES, ids=str)
def test_exported_code_brings_positions_to_those_that_stand_for_them(
    run, symmetry, write_fit, tmp_path
):
    """This was left to the firmware: at x = −9 mm the code gave the force of another place."""
    polar = make_model("polar", {"expression": "t0*hv/h0*(1 + t2*phi) + t1*r"}, source="test")
    cartesian = make_model("cartesian", {"expression": "t0*hv/h0 + t1*(x + 2*y)"}, source="test")
    r_m, phi_deg = np.meshgrid([0.0, 1e-3, 2e-3], [-190.0, -100, -1, 9, 30, 56, 91, 181, 271, 300])
    factors = Factors.of(h0_m=7e-6, hv_m=1e-6, phi_r_m=r_m.ravel(), phi_deg=phi_deg.ravel())
    space = {name: (-1.0, 1.0) for name in ("h0_m", "hv_m", "x_m", "y_m")}
    for model, theta in ((polar, (1.0, 100.0, 0.01)), (cartesian, (1.0, 100.0))):
        own = {**validation(), "ranges": space}
        fit = read_fit(write_fit(model, theta, validation=own, directions=symmetry))
        points = np.column_stack([factors.column(name) for name in model.factor_names])
        found, _ = np.array(run(fit, points, tmp_path), dtype=float).T
        exact = fit.evaluate(fit.folded_factors(factors))
        np.testing.assert_allclose(found, exact, rtol=1e-12)


@pytest.mark.parametrize("language", NAN_OF_LANGUAGE)
def test_exported_code_has_a_sinc_where_its_formula_has_one(language, write_fit):
    for model, theta in ((get_model("two_factor"), THETA["two_factor"]), EXPORTED[-1]):
        text = source_code(read_fit(write_fit(model, theta)), language)
        assert ("sinc" in text.replace(model.expression, "")) == ("sinc" in model.expression)


def test_a_function_of_matlab_has_the_name_of_its_file(write_fit, tmp_path, refused):
    path = write_fit(get_model("two_factor"), THETA["two_factor"])
    export = ["export", str(path), "--language", "matlab", "--output"]
    assert cli.main([*export, str(tmp_path / "other.m")]) == 0
    text = (tmp_path / "other.m").read_text()
    assert "= other(h0_m, hv_m)" in text
    assert "Save this file as other.m" in text
    assert "my-force: cannot name a function" in refused(*export, tmp_path / "my-force.m")


def test_constants_with_units_are_in_a_fit_and_in_its_code(write_fit):
    """`cos(4*pi*x/0.012)` was invalid: the number had no unit, and none could be given."""
    entry = {"expression": "t0*(hv/h0)**2*cos(4*pi*x/wavelength)"}
    with pytest.raises(InputError, match=r"constants: \{name: 12 mm\}"):
        make_model(
            "waves", {"expression": entry["expression"].replace("wavelength", "0.012")}, source=""
        )
    model = make_model("waves", entry | {"constants": {"wavelength": "12 mm"}}, source="test")
    assert model.parameter_units == ("N",)
    fit, names = read_fit(write_fit(model, (3.0,))), {}
    exec(source_code(fit, "python"), names)
    force_n = 3.0 * 0.2**2 * math.cos(4 * math.pi * 1e-3 / 0.012)
    assert names["force_n"](5e-6, 1e-6, 1e-3, 0.0) == pytest.approx(force_n, rel=1e-12)
    with pytest.raises(InputError, match=r"constants.wavelength: '12 furlongs' is no number"):
        make_model("waves", entry | {"constants": {"wavelength": "12 furlongs"}}, source="test")


def test_outside_its_domain_generated_code_gives_no_number(write_fit):
    names: dict = {}
    fit = read_fit(write_fit(get_model("two_factor"), THETA["two_factor"]))
    exec(source_code(fit, "python"), names)
    assert math.isnan(names["force_n"](1e-6, 0.99e-6))
    assert math.isnan(names["force_n"](0.0, 1e-6))
    limit: dict = {}
    exec(source_code(read_fit(write_fit(get_model("limit_2"), THETA["limit_2"])), "python"), limit)
    assert math.isnan(limit["force_n"](5e-6, 1e-6, 5e-3, 0.0))


def test_a_table_is_no_fit(tmp_path):
    """A table of models ended with a position in JSON."""
    with pytest.raises(
        InputError, match=r"four_factor.csv: not a fit; give a file such as models/"
    ):
        read_fit(tmp_path / "four_factor.csv")


@pytest.mark.parametrize("part", ["format", "error_scale", "film", "directions", "ranges"])
def test_a_fit_that_lacks_a_part_is_refused(part, write_fit):
    """A file of another version was used without the error or the limit that it lacks."""
    path = write_fit(get_model("two_factor"), THETA["two_factor"])
    values = json.loads(path.read_text())
    del values[part]
    path.write_text(json.dumps(values))
    with pytest.raises(InputError, match=f"format 1, and it lacks {part}; fit again"):
        read_fit(path)
    path.write_text(json.dumps(values | {part: 7, "format": 2}))
    with pytest.raises(InputError, match="format 1, and its is 2; fit again"):
        read_fit(path)


@pytest.mark.parametrize("name", ['x"); system("true', "a b", "*/", "é", ""])
def test_a_fits_name_cannot_carry_code(name, write_fit):
    fit = read_fit(write_fit(get_model("two_factor"), THETA["two_factor"], model=name))
    for language in NAN_OF_LANGUAGE:
        with pytest.raises(InputError, match="cannot name a function"):
            source_code(fit, language)


def test_the_table_of_limits_states_its_error(limit_table):
    table = LimitTable.model_validate(json.loads(json.dumps(limit_table)))
    assert 0 < table.largest_relative_error < 1e-6
    outside = Factors.of(h0_m=[5e-6, 4e-6, 5e-6], hv_m=[4e-6, 1e-6, 1e-6], x_m=[0, 0, 5e-3])
    assert np.isnan(table.with_asymptotic_forces(outside).column("limit_n")).all()


@pytest.mark.parametrize(
    ("force_n", "error_n", "shown"),
    [
        (0.9620420431, 6.31e-7, ("0.96204204", "6.4e-07")),
        (123.4, 12.0, ("123", "12")),
        (123.4, 0.3, ("123.40", "0.30")),
        (12345.6, 1234.5, ("1.23e+04", "1.3e+03")),
        (5.966529e-05, 3.91e-11, ("5.9665290e-05", "4.0e-11")),
        (0.0, 0.02, ("0.000", "0.020")),
        (-3e-9, 5.63e-6, ("0.0e+00", "5.7e-06")),
        (0.9620420431, math.nan, ("0.962", "unknown")),
    ],
)
def test_a_force_has_the_digits_that_its_error_leaves(force_n, error_n, shown):
    assert value_and_error_texts(force_n, error_n) == shown


def test_errors_of_95_and_99_percent_are_rounded_alike(write_fit, capsys):
    """Both up to two digits, and the force ends where they do."""
    path = write_fit(get_model("four_factor"), THETA["four_factor"])
    assert cli.main(["predict", str(path), "--h0=5um,6um", "--hv=1um"]) == 0
    header, *rows = capsys.readouterr().out.splitlines()[:3]
    for row in rows:
        shown = dict(zip(header.split(), row.split()[1:], strict=False))
        force_n = float(shown["force_n"])
        errors_n = {"error_95_n": 2e-3 + 0.01 * force_n, "error_99_n": 4e-3 + 0.02 * force_n}
        for name, error_n in errors_n.items():
            assert len(shown[name].lstrip("0.")) == 2
            assert error_n - 1e-5 <= float(shown[name]) <= error_n + 1.1e-4
            assert len(shown["force_n"]) == len(shown[name]) == len("0.0000")
    assert cli.main(["predict", str(path), "--h0=5um", "--hv=1um"]) == 0
    printed = capsys.readouterr().out
    assert re.search(r"error \(95 %\) +± 0\.00[1-9]\d N", printed)
    assert re.search(r"error \(99 %\) +± 0\.00[1-9]\d N", printed)
