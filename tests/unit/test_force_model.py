"""The empirical models: values, limits, gradients, inverse."""

from functools import partial

import numpy as np
import pandas as pd
import pytest
import yaml
from reference_forces import FOUR_FACTOR, FOUR_FACTOR_THETA, SCREEN_THETA, TWO_FACTOR

from squeezefilm.cli.main import main
from squeezefilm.config.loading import load_config
from squeezefilm.errors import InputError
from squeezefilm.files import read_json, write_json
from squeezefilm.models.data import Factors, factors_of_table
from squeezefilm.models.fit_file import amplitude_for_force
from squeezefilm.models.force_model import check_columns_known, get_model, make_model
from squeezefilm.studies.tasks.fits import asymptotic_forces_of_table
from squeezefilm.studies.tasks.physics_limits import with_limit_forces

THETA = {TWO_FACTOR: np.array(SCREEN_THETA), FOUR_FACTOR: np.array(FOUR_FACTOR_THETA)}
MODELS = pytest.mark.parametrize("model", [TWO_FACTOR, FOUR_FACTOR], ids=lambda m: m.name)


def test_the_piston_formula_is_a_case_of_the_model():
    # Paper eq. (6): 3/2, 1 and -1 in place of the parameters.
    factors = Factors.of(h0_m=5e-6, hv_m=2e-6)
    piston = np.sqrt(1 + 1.5 * 0.16) / np.sqrt(1 - 0.16) - 1
    assert TWO_FACTOR.evaluate([1.5, 1.0, -1.0], factors) == pytest.approx([piston], rel=1e-14)


def test_the_formula_of_the_docs_is_valid(repository):
    page = (repository / "docs/reference/formulas.md").read_text(encoding="utf-8")
    settings = yaml.safe_load(page.partition("\n\n")[2].partition("\n\n")[0])["models"]["mine"]
    assert make_model("mine", settings, source="docs").parameter_units == ("1/m", "1", "1", "1")


def test_position_enters_in_degrees_over_45_and_in_metres():
    factors = Factors.of(h0_m=5e-6, hv_m=2e-6, phi_r_m=2e-3, phi_deg=30)
    t0, t1, t2, t3, t4 = THETA[FOUR_FACTOR]
    q = 1 + t3 * 30 / 45 + t4 * 0.002
    by_hand = np.sqrt(1 + t0 * 0.16) / np.sqrt(1 - t1 * q * 0.16) + t2
    assert FOUR_FACTOR.evaluate(THETA[FOUR_FACTOR], factors) == pytest.approx([by_hand], rel=1e-14)


def test_a_point_without_a_derivative_is_refused_by_name():
    model = make_model(
        "kink", {"expression": "t0*(hv/h0)**2*abs(t1*x - y)"}, source="C: models.kink"
    )
    factors = Factors.of(h0_m=5e-6, hv_m=2e-6, x_m=[0.0, 2e-3, 1e-3], y_m=[0.0, 3e-3, 1e-3])
    assert np.isfinite(model.gradient([2.0, 3.0], factors)).all()
    with pytest.raises(InputError, match=r"C: models\.kink.*abs\(t1\*x - y\).* to t1 .*x_m 0\.001"):
        model.gradient([2.0, 1.0], factors)


@MODELS
@pytest.mark.parametrize("force_n", [0.01, 0.5, 1.0, 3.0])
def test_amplitude_for_force_inverts_the_model(model, force_n):
    where = {"h0_m": 5e-6, "phi_r_m": 1e-3, "phi_deg": 15.0}
    hv_m = amplitude_for_force(partial(model.evaluate, THETA[model]), force_n=force_n, **where)
    back = model.evaluate(THETA[model], Factors.of(hv_m=hv_m, **where))
    assert back == pytest.approx([force_n], rel=1e-12)


@pytest.mark.parametrize("force_n", [-0.5, -5.0, -1.0013 + 0.5, float("nan")])
def test_a_force_that_no_amplitude_gives_is_refused(force_n):
    evaluate = partial(TWO_FACTOR.evaluate, THETA[TWO_FACTOR])
    with pytest.raises(InputError, match=r"force_n: .* (must be finite|to .* N at h0 = 5 µm)"):
        amplitude_for_force(evaluate, force_n=force_n, h0_m=5e-6)


def test_a_model_that_cannot_be_used_has_the_status_of_the_asymptotic_force(edited, tmp_path):
    """It was "see its status", which stood in another file of the results."""
    config, model = load_config(edited("paper", pad={"shape": "ellipse"})), get_model("limit_2")
    at_centre = {"phi_r_m": [0.0], "phi_deg": [0.0]}
    points = pd.DataFrame({"point_id": ["1"], "h0_m": [5e-6], "hv_m": [1e-6], **at_centre})
    points = points.assign(force_n=0.2, status="ok")
    limits = tmp_path / "limits.csv"
    asymptotic_forces_of_table(points, config).to_csv(limits, index=False)
    for factors in (
        factors_of_table(with_limit_forces(model, points, config)),
        factors_of_table(points, limits=limits),
    ):
        with pytest.raises(InputError, match="row 1: the composite expansion is derived for rect"):
            check_columns_known(model, factors)


def test_a_candidate_that_cannot_be_fitted_has_that_status_too(edited, script, tmp_path):
    """The page of models had "does not hold there" for every pad that is no rectangle."""
    study, forces = edited(pad={"shape": "ellipse"}), tmp_path / "forces.csv"
    points = ["--h0=5um,6um", "--hv=1um"]
    assert main(["simulate", *points, f"--config={study}", f"--output={forces}"]) == 0
    write_json({}, tmp_path / "table.json")
    given = {"forces": forces, "sample": forces, "limit_table": tmp_path / "table.json", "scan": []}
    written = {"fits": [tmp_path / "fit.json"], "limits": [tmp_path / "a.csv", tmp_path / "b.csv"]}
    params = {"models": ["limit_2"], "seeds": 1}
    script("fit", study, input=given, output=written, params=params)
    reason = read_json(tmp_path / "fit.json")["not_supported"]
    assert "row 1: the composite expansion is derived for rectangular pads" in reason
