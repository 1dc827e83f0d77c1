"""Ranges of parameters: exact where the model is linear, open where nothing bounds them."""

import numpy as np
import pytest
from reference_forces import TWO_FACTOR, reference_forces
from scipy import stats

from squeezefilm.models.data import Factors
from squeezefilm.models.fitting import local_fit, parameter_ranges, sum_of_squares
from squeezefilm.models.force_model import make_model

LINE = make_model("line", {"expression": "t0 + t1*(hv/h0)"}, place="test")
EPSILON = np.linspace(0.05, 0.4, 12)
AT = Factors.of(h0_m=5e-6, hv_m=5e-6 * EPSILON)


def test_ranges_of_a_straight_line_are_the_intervals_of_student():
    force = 0.1 + 2 * EPSILON + 0.01 * np.sin(40 * EPSILON)
    theta = local_fit(LINE, AT, force, [0.0, 1.0])
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


def test_at_the_end_of_a_range_the_sum_of_squares_is_what_was_asked_for():
    at, forces = reference_forces("screen")
    theta = local_fit(TWO_FACTOR, at, forces, (7.6, 1.9, -1.0))
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
    step = make_model("step", {"expression": "t1*(1 - exp(-t0*hv/h0))"}, place="test")
    force = 0.5 + 1e-4 * np.sin(50 * EPSILON)
    theta = local_fit(step, AT, force, [60.0, 0.5])
    slope = parameter_ranges(step, AT, force, theta)[0]
    assert slope.upper == np.inf
    assert 10 < slope.lower < slope.estimate
