"""Candidates for the force model: fitting any formula, and judging it at points left out."""

import csv
import json
import re

import numpy as np
import pandas as pd
import pytest
from reference_forces import reference_forces

from squeezefilm.cli import main as cli
from squeezefilm.io.errors import InputError
from squeezefilm.models.cross_validation import fold_numbers, left_out_predictions
from squeezefilm.models.fitted import read_fit
from squeezefilm.models.fitting.fit import fit_model
from squeezefilm.models.fitting.identifiability import check_identifiable
from squeezefilm.models.fitting.local_fit import local_fit
from squeezefilm.models.fitting.profile_likelihood import parameter_ranges
from squeezefilm.models.fitting.search import nelder_mead
from squeezefilm.models.force_model import TWO_FACTOR, Factors, get_model, library, make_model
from squeezefilm.models.library import check_models, model_named
from squeezefilm.studies.config import load_config


def own(expression: str):
    return make_model("own", {"expression": expression}, place="models.own")


@pytest.mark.parametrize(
    ("expression", "message"),
    [
        ("t0*t1*(hv/h0)**2", "t0, t1 cannot be told apart"),
        ("t0*(hv/h0)**2 + t1*x", "t1 has no effect"),
        ("sqrt(1 + t0*(hv/h0)**2)/sqrt(1 - t1*(hv/h0)**2) + t2 + t3", "t2, t3 cannot be told"),
        ("t0*exp(t1 + t2*hv)", "t0, t1 cannot be told apart"),
        ("t0*log(-1 - t1**2)", "undefined at 400 random"),
    ],
)
def test_parameters_that_the_points_cannot_tell_apart_are_refused(expression, message):
    factors, _ = reference_forces("screen")
    with pytest.raises(InputError, match=f"models.own.expression: .*{message}"):
        check_identifiable(own(expression), factors)


def test_the_papers_position_terms_need_points_off_the_centre():
    model = get_model("four_factor")
    check_identifiable(model, reference_forces("four_factor")[0])
    with pytest.raises(InputError, match="theta3, theta4"):
        check_identifiable(model, reference_forces("screen")[0])


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


def test_a_model_without_parameters_is_only_judged():
    factors, force = reference_forces("screen")
    known = Factors.of(h0_m=factors.h0_m, hv_m=factors.hv_m, limit_n=force * 1.01)
    fit = fit_model(get_model("limit"), known, force)
    assert fit.theta == ()
    assert fit.global_error == pytest.approx(0.01)


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
    best = nelder_mead(lambda t: sums(model, force, t * truth), np.ones(2)).x * truth
    theta = local_fit(model, CENTRED, force, truth)
    np.testing.assert_allclose(theta, best, rtol=1e-6)
    for each in parameter_ranges(model, CENTRED, force, theta):
        assert each.lower < each.estimate < each.upper
    predicted = left_out_predictions(model, CENTRED, force, theta=theta, folds=5, seed=1)
    assert np.linalg.norm(predicted - force) < 0.04 * np.linalg.norm(force)


def sums(model, force, thetas) -> np.ndarray:
    return np.sum((model.evaluate(thetas, CENTRED) - force) ** 2, axis=-1)


@pytest.mark.parametrize("expression", ["t0*(hv/h0)**2*abs(t1 + r)", "t0*(hv/h0)**2*sqrt(t1 - r)"])
def test_a_fit_without_a_derivative_is_refused_with_its_point(expression):
    model = own(expression)
    force = np.ones(len(CENTRED))
    start = [3.0, 0.0 if "abs" in expression else 4e-3]
    with pytest.raises(InputError, match=r"no finite derivative .* t1 at h0_m .*phi_r_m 0"):
        local_fit(model, CENTRED, force, start)


def test_a_refit_arrives_where_the_search_does():
    factors, force = reference_forces("screen")
    theta = local_fit(TWO_FACTOR, factors, force, (7.0, 1.8, -0.99))
    assert theta == pytest.approx((7.6240, 1.9166, -1.0013), abs=1e-3)


def test_folds_are_even_and_depend_on_the_seed_alone():
    numbers = fold_numbers(points=13, folds=4, seed=3)
    assert sorted(np.bincount(numbers)) == [3, 3, 3, 4]
    np.testing.assert_array_equal(numbers, fold_numbers(points=13, folds=4, seed=3))
    with pytest.raises(InputError, match="folds: 5 for 4 points"):
        fold_numbers(points=4, folds=5, seed=1)


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


def test_left_out_points_are_predicted_worse_than_fitted_ones():
    factors, force = reference_forces("screen")
    fit = fit_model(TWO_FACTOR, factors, force, bound=100.0)
    left_out = left_out_predictions(TWO_FACTOR, factors, force, theta=fit.theta, folds=5, seed=1)
    error = np.linalg.norm(left_out - force) / np.linalg.norm(force)
    assert 1.2 * fit.global_error < error < 3 * fit.global_error


def test_every_model_of_the_library_says_what_it_is():
    for model in library().values():
        assert model.about
        assert model.parsed.names


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


def test_the_models_to_refine_are_checked_before_anything_runs():
    named = {
        "comparison": {"two_factor": [], "four_factor": []},
        "refine": {"two_factor": [], "four_factor": ["none_such"]},
    }
    with pytest.raises(InputError, match=r"study.yaml: refine.four_factor: model 'none_such'"):
        check_models({}, named, place="study.yaml")


@pytest.fixture
def tables(study, tmp_path):
    """Forces of the screen, and made-up limits 1 % above them."""
    forces = study.root / "simulations" / "screen" / "forces.csv"
    with forces.open() as file:
        rows = list(csv.DictReader(file))
    limits = tmp_path / "limits.csv"
    names = ["point_id", "h0_m", "hv_m", "phi_r_m", "phi_deg"]
    added = ["limit_n", "fast_limit_n", "sigma", "limit_error_n", "status"]
    with limits.open("w", newline="") as file:
        table = csv.writer(file)
        table.writerow([*names, *added])
        for row in rows:
            force = float(row["force_n"])
            limit = [1.01 * force, 1.02 * force, 5.8e-8 / float(row["h0_m"]) ** 2, 1e-3, "ok"]
            table.writerow([*(row[name] for name in names), *limit])
    return forces, limits


def fitted(study, tables, tmp_path, name: str, *more: str) -> dict:
    forces, limits = tables
    path = tmp_path / f"{name}.json"
    arguments = ["fit", str(forces), "--limits", str(limits), "--model", name, "--seeds", "1"]
    assert cli.main([*arguments, f"--config={study.config}", f"--output={path}", *more]) == 0
    return json.loads(path.read_text())


def test_a_fits_file_says_all_that_its_users_need(study, tables, tmp_path):
    fit = fitted(study, tables, tmp_path, "limit_1")
    assert fit["expression"] == "limit + t0*(hv/h0)**2/sigma**1.5"
    assert (fit["parameters"], fit["parameter_units"]) == (["t0"], ["N"])
    assert fit["ranges"]["h0_m"] == [5e-6, 10e-6]
    assert fit["cross_validation"]["folds"] == 5
    assert fit["cross_validation"]["global_error"] >= fit["residual"]["global_error"]
    assert len(fit["source"]["forces_sha256"]) == 64


def test_a_fit_to_forces_of_a_scan_knows_what_the_scan_leaves_open(
    study, repository, tmp_path, capsys
):
    forces, summary = study.root / "simulations/screen/forces.csv", tmp_path / "summary.json"
    summary.write_text(json.dumps({"largest_force_error_share": 0.016}))
    words = ["fit", str(forces), "--model=polynomial_3", f"--output={tmp_path}/fit.json"]
    scanned = [*words, f"--config={repository}/config/vibrometer.yaml"]
    assert cli.main(scanned) == 2
    assert "its profile is measured; give --scan SUMMARY.json" in capsys.readouterr().err
    assert cli.main([*scanned, f"--scan={summary}"]) == 0
    fit = read_fit(tmp_path / "fit.json")
    assert fit.scan_error == 0.016
    assert cli.main(["predict", fit.place, "--h0=6um", "--hv=1.5um"]) == 0
    assert "1.6" in capsys.readouterr().out
    assert cli.main([*words, f"--config={study.config}", f"--scan={summary}"]) == 2
    assert "is not measured" in capsys.readouterr().err


def test_the_seeds_of_a_fit_are_those_of_its_factors(study, tmp_path):
    """However many parameters it has: both have two."""
    own_models = {"gap": "t0*(hv/h0)**(2 + t1)", "place": "t0*sinc(t1*r)*(hv/h0)**2"}
    config = tmp_path / "study.yaml"
    text = study.config.read_text(encoding="utf-8").replace("bounds: [1e6, 100]", "bounds: [100]")
    text = text.replace("{two_factor: 20, four_factor: 2}", "{two_factor: 1, four_factor: 2}")
    more = "".join(f"\n  {name}: {{expression: {e}}}" for name, e in own_models.items())
    config.write_text(text.replace("\nmodels: {}", f"\nmodels:{more}"), encoding="utf-8")
    counts = {}
    for name in own_models:
        runs = tmp_path / f"{name}.csv"
        forces = study.root / "simulations" / "four_factor" / "forces.csv"
        arguments = ["fit", str(forces), f"--model={name}", f"--config={config}"]
        assert cli.main([*arguments, f"--output={tmp_path}/fit.json", f"--runs={runs}"]) == 0
        counts[name] = int(pd.read_csv(runs)["method"].str.startswith("genetic").sum())
    assert counts == {"gap": 1, "place": 2}


def test_models_are_compared_at_points_they_were_not_fitted_to(study, tables, tmp_path, capsys):
    """Those of the control points that were fitted, here of the least amplitude, judge nothing."""
    names = ("polynomial_3", "limit", "polynomial_5")
    config = tmp_path / "study.yaml"
    text = study.config.read_text(encoding="utf-8")
    config.write_text(
        re.sub("two_factor: .two_factor, .*", f"two_factor: [{', '.join(names)}]", text)
    )
    for name in names:
        fitted(study, tables, tmp_path, name, "--keep-going")
    paths = [str(tmp_path / f"{name}.json") for name in names]
    forces, limits = (tmp_path / name for name in ("control.csv", "control_limits.csv"))
    for source, target in zip(tables, (forces, limits), strict=True):
        table = pd.read_csv(source, dtype={"point_id": str})
        table.loc[table["hv_m"] > table["hv_m"].min(), "hv_m"] *= 0.999
        table.to_csv(target, index=False)
    output = [f"--{kind}={tmp_path / kind}.csv" for kind in ("output", "errors", "report")]
    arguments = [
        "compare",
        "two_factor",
        *paths,
        f"--config={config}",
        f"--forces={forces}",
        f"--limits={limits}",
        *output,
    ]
    assert cli.main([*arguments[:3], *arguments[5:]]) == 2
    assert "no fit of limit, polynomial_5 is given" in capsys.readouterr().err
    assert cli.main(arguments) == 0
    rows = pd.read_csv(tmp_path / "output.csv").set_index("model")
    assert rows.loc["limit", "control_error"] == pytest.approx(0.01)
    assert rows.loc["limit", "control_points"] == 54
    assert "t3, t4 cannot be told apart" in rows.loc["polynomial_5", "note"]
    assert len(pd.read_csv(tmp_path / "errors.csv")) == 2 * 54
    text = capsys.readouterr().out
    assert text.index("| polynomial_3 |") < text.index("| limit |") < text.index("Not judged")
    picture = tmp_path / "errors.png"
    plot = ["plot", "model_errors", str(tmp_path / "errors.csv"), "--output", str(picture)]
    assert cli.main(plot) == 0
    assert picture.stat().st_size > 10_000


def test_models_are_not_ranked_on_points_far_from_those_they_were_fitted_to(
    study, tables, tmp_path, capsys
):
    """Fitted at gaps of 5 to 10 µm, judged at 15 to 30 µm: no ranking."""
    config = tmp_path / "study.yaml"
    text = study.config.read_text(encoding="utf-8")
    config.write_text(re.sub("two_factor: .two_factor, .*", "two_factor: [polynomial_3]", text))
    fitted(study, tables, tmp_path, "polynomial_3")
    elsewhere = pd.read_csv(tables[0], dtype={"point_id": str})
    elsewhere["h0_m"] *= 3
    elsewhere.to_csv(tmp_path / "elsewhere.csv", index=False)
    outputs = [f"--{name}={tmp_path}/{name}.csv" for name in ("output", "errors", "report")]
    arguments = ["compare", "two_factor", f"{tmp_path}/polynomial_3.json", f"--config={config}"]
    assert cli.main([*arguments, f"--forces={tmp_path}/elsewhere.csv", *outputs]) == 2
    message = "polynomial_3: 60 of 60 control points lie outside the points it was fitted to"
    assert message in capsys.readouterr().err


@pytest.mark.parametrize(
    ("damage", "message"),
    [
        (lambda text: text.replace("5e-06", "5.1e-06", 1), "not the scenes"),
        (lambda text: text.replace("sigma", "stigma"), "'sigma' is missing"),
        (lambda text: "\n".join(text.splitlines()[:-1]), "not the scenes"),
    ],
)
def test_limits_of_other_scenes_are_refused(study, tables, tmp_path, capsys, damage, message):
    forces, limits = tables
    limits.write_text(damage(limits.read_text()))
    arguments = ["fit", str(forces), f"--limits={limits}", "--model=limit"]
    assert cli.main([*arguments, f"--config={study.config}", f"--output={tmp_path}/f.json"]) == 2
    assert message in capsys.readouterr().err


def test_a_model_of_the_limit_needs_the_limits(study, tables, tmp_path, capsys):
    arguments = ["fit", str(tables[0]), "--model=limit", f"--config={study.config}"]
    assert cli.main([*arguments, f"--output={tmp_path}/f.json"]) == 2
    assert "limit_n: the points lack this column" in capsys.readouterr().err


PIECES = (
    *(
        "t0",
        "t1",
        "h0",
        "hv",
        "x",
        "phi",
        "angle",
        "limit",
        "sigma",
        "slope",
        "none_such",
        "0",
        "1",
    ),
    *("2.5", "1e999", "(hv/h0)**2", "sqrt(", ")", "(", "+", "-", "*", "/", "**", ",", " ", "\n"),
    *("exp(", "sinc(", "__class__", ".", "'", "[", "lambda", "é", "9**9**9", "#", "\x00", "∞"),
)
VALUES = (None, True, 5, -1e300, "", "1", "N", "N/m", "furlong", [], ["t0"], {}, {"t0": "N"}, [[]])


def damaged(rng: np.random.Generator) -> dict:
    """A section `models` that nobody would write, or nearly nobody."""
    text = "".join(rng.choice(PIECES, rng.integers(1, 9)))
    entry: dict = {"expression": text if rng.random() < 0.6 else "t0*(hv/h0)**2 + slope*hv"}
    if rng.random() < 0.6:
        entry["parameters"] = ["slope"] if rng.random() < 0.5 else {"slope": "N/m"}
    if rng.random() < 0.3:
        key = str(rng.choice(["expression", "parameters", "about", "colour"]))
        entry[key] = VALUES[rng.integers(len(VALUES))]
    return {str(rng.choice(["mine", "limit", "Mine", "a b", "x"])): entry}


def test_studies_with_damaged_models_run_or_are_refused_with_their_place(repository, tmp_path):
    rng = np.random.default_rng(3)
    text = (repository / "config" / "paper.yaml").read_text(encoding="utf-8")
    before, after = re.split(r"models: \{\}.*", text)
    path = tmp_path / "study.yaml"
    factors, force = reference_forces("four_factor")
    known = {name: force for name in ("limit_n", "fast_limit_n", "sigma")}
    at = Factors.of(h0_m=factors.h0_m, hv_m=factors.hv_m, x_m=factors.x_m, y_m=factors.y_m, **known)
    outcomes = []
    for _ in range(40):
        path.write_text(f"{before}models: {json.dumps(damaged(rng))}{after}", encoding="utf-8")
        try:
            config = load_config(path)
            check_models(config["models"], config, place=path)
            for name in config["models"]:
                model = model_named(name, config["models"], place=path)
                check_identifiable(model, at)
                fit_model(model, at, force, bound=10.0) if model.is_linear else None
            outcomes.append("ran")
        except InputError as error:
            outcomes.append(str(error))
    refusals = [each for each in outcomes if each != "ran"]
    assert 20 < len(refusals) < 40
    assert all("models" in each or "at these points" in each for each in refusals)
