"""Candidates for the force model: fitting any formula, and judging it at points left out."""

import json
import shutil

import numpy as np
import pandas as pd
import pytest
from reference_forces import reference_forces

from reporting.figures import FIGURES, save
from reporting.models import compare, comparison_values
from reporting.pages import render
from reporting.results import Results
from squeezefilm.cli import main as cli
from squeezefilm.errors import InputError
from squeezefilm.models.cross_validation import fold_numbers, left_out_predictions
from squeezefilm.models.data import Factors, factors_of
from squeezefilm.models.fit_file import read_fit
from squeezefilm.models.fitting import check_identifiable, fit_model, local_fit
from squeezefilm.models.force_model import TWO_FACTOR, check_models, get_model, make_model
from squeezefilm.models.parameter_intervals import parameter_ranges
from squeezefilm.models.search import nelder_mead
from squeezefilm.tables import SCENE_COLUMNS, read_ok_forces


def own(expression: str):
    return make_model("own", {"expression": expression}, place="models.own")


@pytest.mark.parametrize(
    ("expression", "message"),
    [
        ("t0*t1*(hv/h0)**2", "t0, t1 cannot be told apart"),
        ("sqrt(1 + t0*(hv/h0)**2)/sqrt(1 - t1*(hv/h0)**2) + t2 + t3", "t2, t3 cannot be told"),
        ("t0*log(-1 - t1**2)", "undefined at 400 random"),
    ],
)
def test_parameters_that_the_points_cannot_tell_apart_are_refused(expression, message):
    factors, _ = reference_forces("screen")
    with pytest.raises(InputError, match=f"models.own.expression: .*{message}"):
        check_identifiable(own(expression), factors)


def test_a_linear_model_is_solved_at_once():
    factors, force = reference_forces("screen")
    model = get_model("polynomial_3")
    fit = fit_model(model, factors, force)
    assert fit.method == "linear least squares"
    # At the minimum the residual is at right angles to every column.
    residual = model.evaluate(fit.theta, factors) - force
    columns = model.gradient(fit.theta, factors)
    slopes = columns.T @ residual / np.linalg.norm(columns, axis=0) / np.linalg.norm(force)
    assert np.abs(slopes).max() < 1e-10
    assert not TWO_FACTOR.is_linear


CENTRED = Factors.of(
    h0_m=np.tile([5e-6, 6e-6, 7e-6, 8e-6], 5),
    hv_m=2e-6,
    phi_r_m=np.repeat([0.0, 1e-3, 2e-3, 3e-3, 4e-3], 4),
    phi_deg=0.0,
)
"""Points of which some are centred, where r = 0."""


@pytest.mark.parametrize("shape", ["sinc(t1*r)", "sqrt(1 - abs(t1*r))", "(1 - (t1*r)**0.5)"])
def test_centred_points_count_in_every_fit_near_a_known_one(shape):
    """A derivative that is 0/0 there was taken for zero, and theta came out elsewhere."""
    model = own(f"t0*{shape}*(hv/h0)**2")
    truth = np.array([3.0, 59.5])
    scatter = 0.02 * np.random.default_rng(1).standard_normal(len(CENTRED))
    force = model.evaluate(truth, CENTRED) * (1 + scatter)
    best = nelder_mead(lambda t: sums(model, force, t * truth), np.ones((1, 2)))[0].x * truth
    theta = local_fit(model, CENTRED, force, truth)
    np.testing.assert_allclose(theta, best, rtol=1e-6)
    for each in parameter_ranges(model, CENTRED, force, theta):
        assert each.lower < each.estimate < each.upper
    predicted = left_out_predictions(model, CENTRED, force, theta=theta, folds=5, seed=1)
    assert np.linalg.norm(predicted - force) < 0.04 * np.linalg.norm(force)


def sums(model, force, thetas) -> np.ndarray:
    return np.sum((model.evaluate(thetas, CENTRED) - force) ** 2, axis=-1)


def test_a_point_left_out_does_not_know_its_own_force():
    factors, force = reference_forces("screen")
    model = get_model("polynomial_3")
    changed = force.copy()
    changed[7] += 1.0
    kept, moved = (
        left_out_predictions(model, factors, y, theta=np.zeros(3), folds=5, seed=1)
        for y in (force, changed)
    )
    fold = fold_numbers(points=60, folds=5, seed=1)
    np.testing.assert_array_equal(kept[fold == fold[7]], moved[fold == fold[7]])
    assert np.all(kept[fold != fold[7]] != moved[fold != fold[7]])


@pytest.mark.parametrize(
    ("models", "candidates", "message"),
    [
        ({"mine": {"expression": "h0 + phi"}}, [], "models.mine.expression: 'h0 . phi' adds"),
        ({"limit": {"expression": "limit"}}, [], "models.limit: the library has a model"),
        ({}, ["none_such"], "comparison.two_factor: model 'none_such' is unknown"),
    ],
)
def test_a_studys_models_are_checked_before_anything_runs(models, candidates, message):
    named = {
        "comparison": {"two_factor": candidates, "four_factor": []},
        "refine": {"two_factor": [], "four_factor": []},
    }
    with pytest.raises(InputError, match=f"study.yaml: {message}"):
        check_models(models, named, place="study.yaml")


@pytest.fixture
def tables(study, tmp_path):
    """Forces of the screen, and made-up limits 1 % above them."""
    forces, limits = study.root / "simulations/screen/forces.csv", tmp_path / "limits.csv"
    table = pd.read_csv(forces, dtype={"point_id": str})
    limit_n = 1.01 * table["force_n"]
    known = table[list(SCENE_COLUMNS)].assign(limit_n=limit_n, fast_limit_n=1.01 * limit_n)
    known["sigma"] = 5.8e-8 / table["h0_m"] ** 2
    known.assign(limit_error_n=1e-3, status="ok").to_csv(limits, index=False)
    return forces, limits


def fitted(script, study, tables, tmp_path, name: str) -> dict:
    forces, limits = map(str, tables)
    path, limit_table = tmp_path / f"{name}.json", tmp_path / "limit_table.json"
    limit_table.write_text(json.dumps({"refused": "made up"}))
    given = {"forces": forces, "limits": limits, "limit_table": str(limit_table)}
    given |= {"sample": forces, "sample_limits": limits, "scan": []}
    script("fit_candidate", study.config, input=given, output=path, model=name)
    return json.loads(path.read_text())


def test_a_fits_file_says_all_that_its_users_need(script, study, tables, tmp_path):
    fit = fitted(script, study, tables, tmp_path, "limit_1")
    assert fit["expression"] == "limit + t0*(hv/h0)**2/sigma**1.5"
    assert (fit["parameters"], fit["parameter_units"]) == (["t0"], ["N"])
    assert fit["ranges"]["h0_m"] == [5e-6, 10e-6]
    assert fit["cross_validation"]["folds"] == 5
    assert fit["cross_validation"]["global_error"] >= fit["residual"]["global_error"]
    assert len(fit["source"]["forces_sha256"]) == 64


def test_a_fit_to_forces_of_a_scan_knows_what_the_scan_leaves_open(script, study, tmp_path, capsys):
    forces, summary = str(study.root / "simulations/screen/forces.csv"), tmp_path / "summary.json"
    summary.write_text(json.dumps({"largest_force_error_share": 0.016}))
    given = {"forces": forces, "sample": forces, "scan": str(summary)}
    output = {"fit": tmp_path / "fit.json", "runs": tmp_path / "runs.csv"}
    script("fit", study.config, input=given, output=output, params={"model": "polynomial_3"})
    fit = read_fit(tmp_path / "fit.json")
    assert fit.profile_uncertainty == 0.016
    assert cli.main(["predict", fit.place, "--h0=6um", "--hv=1.5um"]) == 0
    assert "1.6" in capsys.readouterr().out


def test_the_seeds_of_a_fit_are_those_of_its_factors(study, edited, tmp_path):
    """However many parameters it has: both have two."""
    own_models = {"gap": "t0*(hv/h0)**(2 + t1)", "place": "t0*sinc(t1*r)*(hv/h0)**2"}
    config = edited(
        "paper",
        fit={"bounds": [100], "seeds": {"two_factor": 1, "four_factor": 2}},
        models={name: {"expression": each} for name, each in own_models.items()},
    )
    counts = {}
    for name in own_models:
        runs = tmp_path / f"{name}.csv"
        forces = study.root / "simulations" / "four_factor" / "forces.csv"
        arguments = ["fit", str(forces), f"--model={name}", f"--config={config}"]
        assert cli.main([*arguments, f"--output={tmp_path}/fit.json", f"--runs={runs}"]) == 0
        counts[name] = int(pd.read_csv(runs)["method"].str.startswith("genetic").sum())
    assert counts == {"gap": 1, "place": 2}


def test_models_are_ranked_on_half_of_the_validation_sample(
    script, study, tables, edited, tmp_path
):
    """A point without a force is excluded from the errors, and counted."""
    names = ("polynomial_3", "limit", "polynomial_5")
    config = edited("paper", comparison={"two_factor": list(names)})
    (tmp_path / "models/two_factor").mkdir(parents=True)
    for name in names:
        fitted(script, study, tables, tmp_path / "models/two_factor", name)
    plan = tmp_path / "simulations/validation_two_factor"
    plan.mkdir(parents=True)
    table = pd.read_csv(tables[0], dtype={"point_id": str})
    table.loc[4, ["force_n", "status"]] = np.nan, "not converged"
    table.to_csv(plan / "forces.csv", index=False)
    shutil.copy(tables[1], plan / "limits.csv")
    results = Results.of(tmp_path, config)
    table, errors = compare(results, "two_factor")
    rows = table.set_index("model")
    assert rows.loc["limit", "validation_error"] == pytest.approx(0.01)
    assert rows.loc["limit", "validation_points"] == 29
    assert rows.loc["limit", "validation_failed"] == 1
    assert "t3, t4 cannot be told apart" in rows.loc["polynomial_5", "note"]
    assert len(errors) == 2 * 29
    text = render("models.md", **comparison_values(results, "two_factor", table))
    assert text.index("| polynomial_3 |") < text.index("| limit |") < text.index("Not validated")
    table.to_csv(tmp_path / "models/two_factor.csv")
    errors.to_csv(tmp_path / "models/two_factor_errors.csv")
    save(FIGURES["models/two_factor_errors"], results, [tmp_path / "errors.png"])
    assert (tmp_path / "errors.png").stat().st_size > 10_000
    (tmp_path / "models/two_factor/limit.json").unlink()
    with pytest.raises(InputError, match=r"limit\.json"):
        compare(results, "two_factor")


@pytest.mark.parametrize(
    ("damage", "message"),
    [
        (lambda text: text.replace("5e-06", "5.1e-06", 1), "not the scenes"),
        (lambda text: text.replace("sigma", "stigma"), "'sigma' is missing"),
    ],
)
def test_limits_of_other_scenes_are_refused(tables, damage, message):
    forces, limits = tables
    limits.write_text(damage(limits.read_text()))
    with pytest.raises(InputError, match=message):
        factors_of(read_ok_forces(forces), limits=limits)
