"""Candidates for the force model: fitting any formula, and judging it at points left out."""

import numpy as np
import pytest
from reference_forces import TWO_FACTOR, reference_forces

from squeezefilm.errors import InputError
from squeezefilm.models.data import Factors
from squeezefilm.models.fitting import (
    check_identifiable,
    fit_model,
    local_fit_theta,
    parameter_ranges,
)
from squeezefilm.models.force_model import get_model, make_model
from squeezefilm.models.prediction_interval import fold_indices_of_points, held_out_predictions
from squeezefilm.models.search import nelder_mead


def own(expression: str):
    return make_model("own", {"expression": expression}, source="models.own")


@pytest.mark.parametrize(
    ("expression", "message"),
    [
        ("t0*t1*(hv/h0)**2", "t0, t1 cannot be told apart"),
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
    theta = local_fit_theta(model, CENTRED, force, truth)
    np.testing.assert_allclose(theta, best, rtol=1e-6)
    for each in parameter_ranges(model, CENTRED, force, theta):
        assert each.lower < each.estimate < each.upper
    folds = fold_indices_of_points(CENTRED, folds=5, seed=1)
    predicted = held_out_predictions(model, CENTRED, force, theta=theta, folds=folds)
    assert np.linalg.norm(predicted - force) < 0.04 * np.linalg.norm(force)


def sums(model, force, thetas) -> np.ndarray:
    return np.sum((model.evaluate(thetas, CENTRED) - force) ** 2, axis=-1)


def test_a_point_left_out_does_not_know_its_own_force():
    factors, force = reference_forces("screen")
    model = get_model("polynomial_3")
    changed = force.copy()
    changed[7] += 1.0
    fold = fold_indices_of_points(factors, folds=5, seed=1)
    kept, moved = (
        held_out_predictions(model, factors, y, theta=np.zeros(3), folds=fold)
        for y in (force, changed)
    )
    np.testing.assert_array_equal(kept[fold == fold[7]], moved[fold == fold[7]])
    assert np.all(kept[fold != fold[7]] != moved[fold != fold[7]])
