"""Ranges of parameters: exact where the model is linear, open where nothing bounds them."""

import json

import numpy as np
import pandas as pd
import pytest
import yaml
from reference_forces import TWO_FACTOR, reference_forces
from scipy import stats

from squeezefilm.cli.main import main
from squeezefilm.models.data import Factors
from squeezefilm.models.fitting import local_fit_theta, parameter_ranges, sum_of_squares
from squeezefilm.models.force_model import make_model
from squeezefilm.tables import FORCE_COLUMNS

LINE = make_model("line", {"expression": "t0 + t1*(hv/h0)"}, source="test")
EPSILON = np.linspace(0.05, 0.4, 12)
AT = Factors.of(h0_m=5e-6, hv_m=5e-6 * EPSILON)


def test_ranges_of_a_straight_line_are_the_intervals_of_student():
    force = 0.1 + 2 * EPSILON + 0.01 * np.sin(40 * EPSILON)
    theta = local_fit_theta(LINE, AT, force, [0.0, 1.0])
    ranges = parameter_ranges(LINE, AT, force, theta)
    known = stats.linregress(EPSILON, force)
    t = stats.t.ppf(0.975, len(force) - 2)
    for found, value, error in (
        (ranges[0], known.intercept, known.intercept_stderr),
        (ranges[1], known.slope, known.stderr),
    ):
        assert found.estimate == pytest.approx(value)
        assert found.lower == pytest.approx(value - t * error)
        assert found.upper == pytest.approx(value + t * error)


def test_the_file_of_a_fit_has_the_ranges_of_its_parameters(tmp_path, repository):
    force = 0.1 + 2 * EPSILON + 0.01 * np.sin(40 * EPSILON)
    films = {"h0_m": 5e-6, "hv_m": 5e-6 * EPSILON, "phi_r_m": 0.0, "phi_deg": 0.0}
    forces = pd.DataFrame(films | {"point_id": range(12), "force_n": force, "status": "ok"})
    forces.reindex(columns=FORCE_COLUMNS, fill_value=0.0).to_csv(tmp_path / "f.csv", index=False)
    study = yaml.safe_load((repository / "config/quick.yaml").read_text(encoding="utf-8"))
    study["models"] = {"line": {"expression": "t0 + t1*(hv/h0)"}}
    (tmp_path / "study.yaml").write_text(yaml.safe_dump(study), encoding="utf-8")
    files = [str(tmp_path / name) for name in ("f.csv", "study.yaml", "fit.json")]
    assert (
        main(["fit", files[0], "--model", "line", "--config", files[1], "--output", files[2]]) == 0
    )
    written = json.loads((tmp_path / "fit.json").read_text(encoding="utf-8"))
    known = stats.linregress(EPSILON, force)
    t = stats.t.ppf(0.975, len(force) - 2)
    ranges = {each["name"]: (each["lower"], each["upper"]) for each in written["parameter_ranges"]}
    half = t * known.intercept_stderr, t * known.stderr
    for name, value, width in zip(("t0", "t1"), (known.intercept, known.slope), half, strict=True):
        assert ranges[name] == pytest.approx((value - width, value + width))


def test_at_the_end_of_a_range_the_sum_of_squares_is_what_was_asked_for():
    at, forces = reference_forces("screen")
    theta = local_fit_theta(TWO_FACTOR, at, forces, (7.6, 1.9, -1.0))
    least = sum_of_squares(TWO_FACTOR, at, forces, theta)
    spare = len(forces) - 3
    wanted = least * (1 + stats.f.ppf(0.95, 1, spare) / spare)
    for found in parameter_ranges(TWO_FACTOR, at, forces, theta):
        assert found.lower < found.estimate < found.upper
        for end in (found.theta_lower, found.theta_upper):
            reached = sum_of_squares(TWO_FACTOR, at, forces, end)
            assert reached == pytest.approx(wanted, rel=1e-4)


def test_a_parameter_that_the_points_do_not_bound_has_an_open_range():
    """exp(-t0 eps) is nothing for every large t0."""
    step = make_model("step", {"expression": "t1*(1 - exp(-t0*hv/h0))"}, source="test")
    force = 0.5 + 1e-4 * np.sin(50 * EPSILON)
    theta = local_fit_theta(step, AT, force, [60.0, 0.5])
    slope = parameter_ranges(step, AT, force, theta)[0]
    assert slope.upper == np.inf
    assert 10 < slope.lower < slope.estimate
