"""The asymptotic expansion as a model: nothing fitted, better than the paper's fitted formula."""

from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from changed_sections import changed
from reference_forces import FOUR_FACTOR_THETA, reference_table

from squeezefilm.config.study import Study
from squeezefilm.models.data import Factors, factors_of_table
from squeezefilm.models.fitting import fit_model
from squeezefilm.models.force_model import get_model
from squeezefilm.models.prediction_interval import error_statistics
from squeezefilm.reynolds import solve
from squeezefilm.studies.plans import random_plan
from squeezefilm.studies.space import space_of_study
from squeezefilm.studies.study import scenes_of_table
from squeezefilm.studies.tasks import physics_limits as limits
from squeezefilm.studies.tasks.physics_limits import with_asymptotic_forces


def limits_of(table: pd.DataFrame, paper: Study) -> pd.DataFrame:
    return with_asymptotic_forces(table, scenes_of_table(table, paper))


def reference(name: str, paper: Study) -> tuple[Factors, np.ndarray]:
    table = reference_table(name)
    return factors_of_table(limits_of(table, paper)), table["force_n"].to_numpy()


@pytest.fixture(scope="module")
def control(paper):
    """A thousand random points of the four-factor space, by the periodic state."""
    ranges = space_of_study(paper).limits
    table = limits_of(random_plan(points=1000, seed=11, **ranges), paper)
    scenes = scenes_of_table(table, paper)
    solutions = solve(scenes, tolerance=1e-5, method="periodic")
    return factors_of_table(table), np.array([each.force_n for each in solutions])


def global_error(name: str, theta, points: tuple[Factors, np.ndarray]) -> float:
    factors, force = points
    model_n = get_model(name).evaluate(theta, factors)
    return error_statistics(model_n=model_n, simulation_n=force)["global_error"]


def test_on_a_thousand_points_it_is_ten_times_better_than_the_fitted_formula(control):
    physics = global_error("limit", (), control)
    paper = global_error("four_factor", FOUR_FACTOR_THETA, control)
    assert physics < 0.0011
    assert 0.012 < paper < 0.020
    assert paper > 10 * physics


def test_each_corrective_parameter_makes_it_better(paper, control):
    plan = reference("four_factor", paper)
    errors = [
        global_error(name, fit_model(get_model(name), *plan).theta, control)
        for name in ("fast_limit", "limit", "limit_1", "limit_2")
    ]
    assert errors[1] < errors[0] / 10
    assert errors[2] < errors[1] / 5
    assert errors[3] < errors[2] / 2


def with_inertia(table: pd.DataFrame, paper: Study) -> tuple[Factors, np.ndarray, np.ndarray]:
    """A plan's factors with the limits, their errors and the forces by the periodic state."""
    scenes = scenes_of_table(table, paper)
    scenes = [each.with_gas(inertia="included") for each in scenes]
    known = with_asymptotic_forces(table, scenes)
    solutions = solve(scenes, tolerance=1e-5, method="periodic")
    force_n = np.array([each.force_n for each in solutions])
    return factors_of_table(known), known["limit_error_n"].to_numpy(), force_n


def test_with_inertia_too_it_needs_no_fitted_parameter(paper) -> None:
    """On the screen and on random points; inertia itself is 2 to 10 % of these forces."""
    random = random_plan(points=200, seed=11, **space_of_study(paper).limits)
    plan, _, plan_n = with_inertia(reference_table("four_factor"), paper)
    for table in (reference_table("screen"), random):
        factors, error_n, force_n = with_inertia(table, paper)
        limit_n = factors.column("limit_n")
        assert global_error("limit", (), (factors, force_n)) < 1.5e-4
        assert np.abs(limit_n / force_n - 1).max() < 3e-4
        assert np.all(np.abs(limit_n - force_n) < error_n)
        assert global_error("fast_limit", (), (factors, force_n)) < 0.012
        for name in ("limit_1", "limit_2"):
            theta = fit_model(get_model(name), plan, plan_n).theta
            assert global_error(name, theta, (factors, force_n)) < 1.5e-4


BESSEL = {
    "kind": "bessel",
    "nodal_diameters": 0,
    "wave_number_rad_per_m": 700.0,
    "edge_share": 0.0,
    "direction_deg": 0.0,
}
SMALL_DISC = {"frequency_hz": 40e3, "surface_radius_m": 0.02, "profile": BESSEL}
TILTED = {"tilt_x_m": 1e-6, "tilt_y_m": 0.0, "crown_m": 0.5e-6}
CENTRED = {"phi_r_m": (0.0, 0.0), "phi_deg": (0.0, 0.0)}


@pytest.mark.parametrize(
    ("sections", "ranges", "error"),
    [
        ({"gas": {"inertia": "auto"}}, CENTRED, 2e-5),
        ({"pad": {"gap": TILTED}, "gas": {"inertia": "none"}}, CENTRED, 1e-4),
        # At one gap: the wave bends the force over the position.
        ({"actuator": SMALL_DISC}, {"h0_m": (5e-6, 5e-6), "phi_r_m": (0.0, 0.0129)}, 1e-5),
    ],
    ids=["inertia", "tilted and bulging", "wavy profile"],
)
def test_a_table_of_limits_has_gaps_and_positions_enough(
    paper, monkeypatch, sections, ranges, error
) -> None:
    """Inertia grows like the square of the gap; 7 × 6 positions left half of a wavy force."""
    box = space_of_study(paper).limits | ranges
    monkeypatch.setattr(limits, "space_of_study", lambda config: SimpleNamespace(limits=dict(box)))
    table = limits.limit_table_of_study(changed(paper, **sections))
    assert table.largest_relative_error < error
    assert len(table.coefficients["limit_n"]) <= limits.MAX_TABLE_NODES
