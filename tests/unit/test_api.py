"""The door of the library: ``import squeezefilm as sf``."""

import ast
import importlib
import json
import re
import subprocess
import sys

import numpy as np
import pandas as pd
import pytest

import squeezefilm as sf
from squeezefilm.cli.main import main
from squeezefilm.reynolds import solve

DISC = {"frequency": 43270, "surface_radius": 0.01, "profile": {"kind": "piston"}}
PAD = {"length_x": 0.01, "length_y": 0.008}


@pytest.fixture(scope="module")
def study(repository):
    return sf.load(repository / "config" / "quick.yaml")


@pytest.fixture(scope="module")
def fit(study):
    return study.fit("limit_1")


def test_every_name_is_there_and_is_told_to_type_checkers_alike(repository):
    text = (repository / "workflow/squeezefilm/__init__.pyi").read_text(encoding="utf-8")
    imports = [node for node in ast.parse(text).body if isinstance(node, ast.ImportFrom)]
    found = {name.name: node.module for node in imports for name in node.names}
    assert sorted(found) == sf.__all__
    for name, place in found.items():
        assert getattr(sf, name) is getattr(importlib.import_module(place), name)
        assert getattr(sf, name).__doc__
    with pytest.raises(AttributeError, match="no attribute 'lod'"):
        _ = sf.lod


LIGHT = {
    "import squeezefilm": {"numpy", "pandas", "pyopencl"},
    "import squeezefilm; squeezefilm.load('config/paper.yaml')": {"pandas", "pyopencl", "scipy"},
    "from squeezefilm.cli.main import main; main('simulate --h0 5um --hv 2um'.split())": {
        *("multiprocessing", "pandas", "scipy", "squeezefilm.film.measured.smooth"),
        *("squeezefilm.film.measured.table", "squeezefilm.config.study"),
        *("squeezefilm.config.keys", "squeezefilm.config.messages", "squeezefilm.provenance"),
        *("squeezefilm.reynolds.self_test", "subprocess", "difflib"),
    },
    "from squeezefilm.cli.main import main\ntry: main(['--help'])\nexcept SystemExit: pass": {
        *("ast", "ctypes", "dataclasses", "hashlib", "numpy", "tempfile"),
    },
    "from squeezefilm.cli.main import main; main('levitate --mass 10g --hv 1um'.split())": {
        *("multiprocessing", "pandas", "scipy")
    },
}


@pytest.mark.parametrize("code", LIGHT)
def test_it_loads_nothing_heavy_that_is_not_needed(code):
    words = [sys.executable, "-c", f"{code}\nimport sys; print(sorted(sys.modules))"]
    done = subprocess.run(words, capture_output=True, text=True, check=True)
    loaded = set(ast.literal_eval(done.stdout.splitlines()[-1]))
    assert "squeezefilm" in loaded
    assert not LIGHT[code] & loaded


def test_a_force_has_its_error_and_what_its_equation_leaves_out(study):
    force = study.force(h0="5 um", hv="2.2 um")
    assert float(force) == pytest.approx(0.962042, abs=force.error_n + 5e-7)
    assert 0 < force.error_n < 1e-4 * float(force)  # the study's tolerance
    least, most = force.modelling_error_percent
    assert -0.1 < least < 0 < 0.5 < most < 0.6  # README: -0.07 to +0.60 %
    assert force.scene.epsilon == pytest.approx(0.44)
    assert force.status == "ok"
    lines = str(force).splitlines()
    assert [line.split("  ")[1] for line in lines[3:5]] == ["inertia", "slip"]
    assert "operating point         h0 = 5 µm, hv = 2.2 µm, x = 0 m, y = 0 m" in lines


def test_the_command_line_says_what_the_library_says(study, capsys, refused):
    words = ["--config", str(study.config.path), "--h0=5um", "--hv=1.5um"]
    assert main(["simulate", *words, "--x", "-1mm", "--y", "0.5mm"]) == 0
    told = capsys.readouterr().out
    force = study.force("5 um", 1.5e-6, x=-1e-3, y="0.5 mm")
    assert told.strip() == str(force)
    assert main(["simulate", *words, "--x", "-1mm", "--y", "0.5mm", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["force_n"] == float(force)
    least, most = told["modelling_error_lower_percent"], told["modelling_error_upper_percent"]
    assert (least, most) == force.modelling_error_percent
    assert not {"inertia_percent", "slip_error_percent"} & told.keys()  # parts not asked for
    assert main(["simulate", *words, "--x", "-1mm", "--y", "0.5mm", "--json", "--budget"]) == 0
    assert {"inertia_percent", *told} < json.loads(capsys.readouterr().out).keys()
    assert "--json prints one" in refused("simulate", *words, "--x=-1mm,1mm", "--json")


def test_a_range_makes_a_curve_by_either_door(study, tmp_path):
    path = tmp_path / "curve.csv"
    words = ["--config", str(study.config.path), "--h0", "5um", "--hv", "0.5:2:3um"]
    assert main(["simulate", *words, "--x", "-1mm,1mm", "--output", str(path)]) == 0
    written = pd.read_csv(path)
    curve = study.curve("5 um", [0.5e-6, 1.25e-6, 2e-6], x="-1, 1 mm")
    pd.testing.assert_frame_equal(curve, written[list(curve)], check_dtype=False)
    assert written["study"].unique().tolist() == [study.config.path.stem]
    assert list(written["hv_m"]) == [5e-7, 5e-7, 1.25e-6, 1.25e-6, 2e-6, 2e-6]
    pairs = written["force_n"].to_numpy().reshape(3, 2)
    # The paper's film is symmetric: left and right are alike.
    np.testing.assert_allclose(pairs[:, 0], pairs[:, 1], rtol=2e-6)
    single = study.force("5 um", "2 um", x="1 mm")
    assert pairs[2, 1] == pytest.approx(float(single), rel=1e-12)


def test_polar_and_cartesian_places_are_one(study):
    polar = study.scene("5 um", "1 um", phi_r="2 mm", phi="30 deg")
    assert polar.x_m == pytest.approx(2e-3 * 3**0.5 / 2)
    assert polar.y_m == pytest.approx(1e-3)
    assert study.scene("5 um", "1 um", x=polar.x_m, y=polar.y_m) == polar


def test_a_film_needs_no_file():
    film = sf.Film.of(actuator=DISC, pad=PAD)
    force = film.force(h0=5e-6, hv=1e-6, tolerance=1e-4)
    assert force.scene.gas.inertia == "included"  # air, whose inertia counts here
    (again,) = solve([force.scene], tolerance=1e-4)
    assert float(force) == again.force_n
    slow = sf.Film.of(actuator=DISC | {"frequency": 20}, pad=PAD)
    assert slow.force(h0=5e-6, hv=1e-6).scene.gas.inertia == "none"


@pytest.mark.parametrize("inertia", ["none", "included"])
def test_the_mean_of_the_pressure_is_the_force(inertia):
    film = sf.Film.of(actuator=DISC, pad=PAD, gas={"inertia": inertia})
    field = film.pressure("5 um", "2 um", points_per_side=401, time_points=16, tolerance=1e-3)
    assert field.gauge_pressure.dims == ("phase", "y", "x")
    assert field.gauge_pressure.attrs["units"] == "Pa"
    mean_n = float(field.gauge_pressure.mean("phase").integrate(["x", "y"]))
    # The rim's layer is a hundredth of the pad: the trapezoidal rule misses little on 401 places.
    assert mean_n == pytest.approx(float(film.force("5 um", "2 um")), rel=3e-3)
    assert float(field.gap.min()) == pytest.approx(3e-6)
    assert float(field.gap.max()) == pytest.approx(7e-6)
    assert field.attrs["change_pa"] <= 1e-3 * float(abs(field.gauge_pressure).max())


@pytest.mark.parametrize("suffix", ["csv", "nc"])
def test_a_pressure_field_is_a_file(suffix, study, tmp_path):
    import xarray

    path = tmp_path / f"field.{suffix}"
    words = ["--config", str(study.config.path), "--h0=5um", "--hv=1um", "--x", "-1mm"]
    more = ["--points-per-side", "5", "--time-points", "8", "--output", str(path)]
    assert main(["pressure", *words, *more]) == 0
    field = study.pressure("5 um", "1 um", x="-1 mm", points_per_side=5, time_points=8)
    if suffix == "nc":
        with xarray.open_dataset(path, engine="scipy") as found:
            xarray.testing.assert_allclose(found, field)
            assert found.attrs["pad_x_m"] == pytest.approx(-1e-3)
        return
    table = pd.read_csv(path)
    assert len(table) == 5 * 5 * 8
    row = table[(table["phase_deg"] == 90) & (table["x_m"] == 0) & (table["y_m"] == 0)]
    found = float(field.gauge_pressure.sel(phase=90, x=0, y=0))
    assert float(row["gauge_pressure_pa"].iloc[0]) == pytest.approx(found)


def test_a_fit_predicts_what_is_simulated(study, fit):
    predicted = fit.predict("6 um", "1.5 um", x="1 mm", y="-0.5 mm").iloc[0]
    force = float(study.force("6 um", "1.5 um", x="1 mm", y="-0.5 mm"))
    assert abs(predicted["force_n"] / force - 1) <= predicted["error_95_percent"] / 100 < 0.01
    assert "not validated" not in predicted["note"]  # few points may cover a region badly
    outside = fit.predict("6 um", "4 um").iloc[0]
    assert np.isnan(outside["error_95_n"])
    assert "hv = 4 µm outside" in outside["note"]


def test_a_model_is_fitted_to_positions_on_a_rectangle(edited, repository):
    scan = {"kind": "measured", "file": str(repository / "config/plate.csv")}
    gas = {"inertia": "none", "thermal": "none"}
    plate = sf.load(edited("plate", actuator={"profile": scan}, gas=gas))
    points = plate.plan(centred=False)
    assert {"x_m", "y_m"} <= set(points.columns)
    fit = plate.fit("along_x")
    at = {"h0": "10 um", "hv": "2 um", "x": "5 mm", "y": "0 mm"}
    (predicted,) = fit.predict(**at).to_dict("records")
    off_n = abs(predicted["force_n"] - float(plate.force(**at)))
    assert off_n < predicted["error_99_n"] < 0.3 * predicted["force_n"]


def test_tables_of_a_fit_show_their_numbers(fit):
    """hv_m was 0.000002 in both, and columns of an amplitude were elided."""
    predicted, amplitude = fit.predict("6 um", "1.5 um"), fit.amplitude_for("0.5 N", "5 um")
    assert "1.5e-06" in str(predicted.T)
    assert f"{amplitude['hv_m'].iloc[0]:.6g}" in str(amplitude)
    assert all(name in str(amplitude) for name in amplitude)


def test_gap_and_response_are_those_of_the_command_line(study, repository, tmp_path):
    """They were on the command line only."""
    config, points = f"--config={repository}/config/quick.yaml", ["--hv=2um", "--x=1mm"]
    assert main(["levitate", "--mass=60g", *points, config, f"--output={tmp_path}/gap.csv"]) == 0
    assert main(["response", "--h0=5um", *points, config, f"--output={tmp_path}/own.csv"]) == 0
    for name, table in (
        ("gap", study.levitate("2 um", mass="60 g", x="1 mm")),
        ("own", study.response("5 um", "2 um", x="1 mm")),
    ):
        told = pd.read_csv(tmp_path / f"{name}.csv")[list(table)]
        assert (table["status"] == "ok").all()
        numbers = table.select_dtypes("number")
        np.testing.assert_allclose(numbers, told[list(numbers)], rtol=1e-9)
    gains = study.gains("5 um", "2 um", frequencies="10, 1000 Hz")
    assert gains["gain"].iloc[0] > gains["gain"].iloc[1] > 0
    with pytest.raises(sf.InputError, match="give load or mass"):
        study.levitate("2 um")


def test_a_working_point_gives_the_force_that_was_wanted(study, fit):
    row = fit.amplitude_for("0.5 N", "5 um").iloc[0]
    force = float(study.force("5 um", float(row["hv_m"])))
    assert abs(force / 0.5 - 1) <= row["error_95_percent"] / 100 < 0.01
    assert len(fit.amplitude_for(0.2)) == 6


def test_a_saved_fit_is_the_one_that_the_command_line_reads(fit, tmp_path, capsys):
    path = tmp_path / "fit.json"
    fit.save(path)
    assert sf.Fit.read(path).predict(6e-6, 1e-6).equals(fit.predict(6e-6, 1e-6))
    assert main(["predict", str(path), "--h0=6um", "--hv=1um", "--output", f"{path}.csv"]) == 0
    table = pd.read_csv(f"{path}.csv")
    assert table["force_n"].iloc[0] == fit.predict(6e-6, 1e-6)["force_n"].iloc[0]
    assert fit.name in fit.code("c")
    assert "limit_1: limit + t0" in str(fit)
    (line,) = [each for each in str(fit).splitlines() if each.startswith("prediction error (95 %)")]
    parts = re.search(r"± \((\S+) N \+ (\S+) % of the force\)", line)
    constant_n, percent = map(float, parts.groups())
    assert fit.predict(6e-6, 1e-6)["error_95_n"].iloc[0] == pytest.approx(
        constant_n + percent / 100 * fit.predict(6e-6, 1e-6)["force_n"].iloc[0], rel=0.1
    )


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"h0": "5", "hv": 1e-6}, "h0 '5' must be a number with its unit: m, mm, um, µm, nm"),
        ({"h0": 5e-6, "hv": "1, 2 um"}, "one scene is asked for, not 2"),
        ({"h0": 5e-6, "hv": 5e-6}, "surface and pad touch"),
    ],
)
def test_what_means_nothing_is_refused_with_a_reason(given, message, study):
    with pytest.raises(sf.InputError, match=message):
        study.force(**given)


def test_a_film_without_a_force_says_why():
    film = sf.Film.of(actuator=DISC, pad=PAD, gas={"inertia": "none", "thermal": "none"})
    with pytest.raises(sf.RunError, match=r"; validity: .*hv/h0 = 0.99 is above 0.95"):
        film.force(5e-5, 4.95e-5)
    table = film.curve(5e-5, [4.95e-5])
    assert np.isnan(table["force_n"].iloc[0])
    assert table["status"].iloc[0] != "ok"


AT = {"h0_m": [5e-6], "hv_m": [1e-6]}
MISNAMED = {
    "x": "column 'x' needs a unit, one of x_m",
    "x_furlong": "column 'x_furlong' needs a unit, one of x_m",
    "phi_deg": "column 'phi_r_m' is missing",
}


@pytest.mark.parametrize("name", MISNAMED)
def test_a_misnamed_position_is_not_taken_for_the_centre(study, fit, name):
    points = pd.DataFrame({**AT, name: [2.0]})
    for use in (study.scenes, study.forces, fit.predict_at):
        with pytest.raises(sf.InputError) as refusal:
            use(points)
        assert MISNAMED[name] in str(refusal.value)


def test_both_forms_of_position_are_refused_and_so_is_an_unknown_column(study, fit):
    both = pd.DataFrame({**AT, "x_m": [1e-3], "phi_r_m": [1e-3]})
    for use in (study.scenes, fit.predict_at):
        with pytest.raises(sf.InputError, match="unknown column 'x_m'; a position is"):
            use(both)
    for use in (study.forces, fit.predict_at):
        with pytest.raises(sf.InputError, match=r"unknown column 'xx_mm' \(did you mean 'x_mm'"):
            use(pd.DataFrame({**AT, "xx_mm": [1.0]}))
    with pytest.raises(sf.InputError, match="column 'hv_m' is missing; it has h0_m"):
        fit.predict_at(pd.DataFrame({"h0_m": [5e-6]}))


@pytest.mark.parametrize("name", ["x_mm", "X_mm"])
def test_a_column_in_another_unit_is_read_as_in_a_file(study, fit, name):
    named = pd.DataFrame({"h0_um": [5.0], "hv_m": [1e-6], name: [2], "y_m": [0.0]})
    (scene,) = study.scenes(named)
    assert (scene.h0_m, scene.x_m) == (5e-6, 2e-3)
    predicted = fit.predict_at(named)
    assert predicted[["h0_m", "x_m"]].to_numpy().tolist() == [[5e-6, 2e-3]]
    assert list(named) == ["h0_um", "hv_m", name, "y_m"]


def test_derivatives_are_asked_for_as_outputs_are(study):
    """That to the gap is the quotient of two forces, and a column of every table."""
    force = study.force("5 um", "1 um", derivatives=True)
    curve = study.curve("4.99, 5, 5.01 um", "1 um", derivatives=True)
    slope = force.solution.derivatives.value["h0_m"]
    assert curve["dforce_dh0_n_per_m"][1] == slope
    quotient = np.diff(curve["force_n"][[0, 2]]) / np.diff(curve["h0_m"][[0, 2]])
    assert slope == pytest.approx(float(quotient[0]), rel=0.01)
    with pytest.raises(TypeError, match="'derivative' is no argument and none of the factors h0"):
        study.curve("5 um", "1 um", derivative=True)
