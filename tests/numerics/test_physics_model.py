"""The physics limit as a force model: nothing fitted, better than the paper's fitted formula."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from reference_forces import FOUR_FACTOR_THETA, reference_table

from squeezefilm.config.loading import Config
from squeezefilm.models.cross_validation import error_sizes
from squeezefilm.models.data import COLUMNS, Factors
from squeezefilm.models.fitting import fit_model, local_fit
from squeezefilm.models.force_model import get_model
from squeezefilm.models.limit_table import MOST_NODES
from squeezefilm.reynolds import solve
from squeezefilm.studies.plans import box_of, random_plan
from squeezefilm.studies.study import scenes_in
from squeezefilm.studies.tasks import physics_limits as limits
from squeezefilm.studies.tasks.physics_limits import with_limits
from squeezefilm.tables import FACTOR_COLUMNS


def limits_of(table: pd.DataFrame, paper: Config) -> pd.DataFrame:
    return with_limits(table, scenes_in(table, paper))


def factors_of(table: pd.DataFrame) -> Factors:
    return Factors.of(**{name: table[name] for name in (*FACTOR_COLUMNS, *COLUMNS.values())})


def reference(name: str, paper: Config) -> tuple[Factors, np.ndarray]:
    table = reference_table(name)
    return factors_of(limits_of(table, paper)), table["force_n"].to_numpy()


@pytest.fixture(scope="module")
def control(paper):
    """A thousand random points of the four-factor space, by the periodic state."""
    ranges = box_of(paper).ranges
    table = limits_of(random_plan(points=1000, seed=11, **ranges), paper)
    scenes = scenes_in(table, paper)
    solutions = solve(scenes, tolerance=1e-5, method="periodic")
    return factors_of(table), np.array([each.force_n for each in solutions])


def test_the_limits_error_is_that_of_the_better_limit(paper, monkeypatch):
    """Whichever limit is computed last."""
    table = reference_table("four_factor").head(3)
    wanted = limits_of(table, paper)
    monkeypatch.setattr(limits, "EXPANSIONS", dict(reversed(limits.EXPANSIONS.items())))
    found = limits_of(table, paper)
    pd.testing.assert_frame_equal(found[list(wanted)], wanted)


def global_error(name: str, theta, points: tuple[Factors, np.ndarray]) -> float:
    factors, force = points
    model_n = get_model(name).evaluate(theta, factors)
    return error_sizes(model_n=model_n, simulation_n=force)["global_error"]


def test_on_the_screen_it_is_ten_times_better_than_the_fitted_formula(paper):
    screen = reference("screen", paper)
    assert global_error("limit", (), screen) < 0.0006
    paper = local_fit(get_model("two_factor"), *screen, (7.6, 1.9, -1.0))
    assert global_error("two_factor", paper, screen) == pytest.approx(0.0053, abs=1e-4)


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


def with_inertia(table: pd.DataFrame, paper: Config) -> tuple[Factors, np.ndarray, np.ndarray]:
    """A plan's factors with the limits, their errors and the forces by the periodic state."""
    scenes = scenes_in(table, paper)
    scenes = [replace(each, gas=replace(each.gas, inertia="included")) for each in scenes]
    known = with_limits(table, scenes)
    solutions = solve(scenes, tolerance=1e-5, method="periodic")
    force_n = np.array([each.force_n for each in solutions])
    return factors_of(known), known["limit_error_n"].to_numpy(), force_n


def test_with_inertia_too_it_needs_no_fitted_parameter(paper) -> None:
    """On the screen and on random points; inertia itself is 2 to 10 % of these forces."""
    random = random_plan(points=200, seed=11, **box_of(paper).ranges)
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


def test_inertia_to_be_decided_is_in_the_limits(paper) -> None:
    table = reference_table("screen").head(4)
    scenes = scenes_in(table, paper)
    known = {}
    for choice in ("none", "auto", "included"):
        theirs = [replace(each, gas=replace(each.gas, inertia=choice)) for each in scenes]
        known[choice] = with_limits(table, theirs)
    pd.testing.assert_frame_equal(known["auto"], known["included"])
    assert np.all(known["included"]["limit_n"] > 1.01 * known["none"]["limit_n"])


def test_table_of_limits_with_inertia_states_its_error(paper, monkeypatch) -> None:
    """It has more gaps: inertia grows like the square of the gap. Here for a centred finger."""
    ranges = box_of(paper).ranges | {"phi_r_m": (0.0, 0.0), "phi_deg": (0.0, 0.0)}
    monkeypatch.setattr(limits, "box_of", lambda config: SimpleNamespace(ranges=dict(ranges)))
    gas = paper["gas"] | {"inertia": "auto"}
    study = Config(path=paper.path, sections=paper.sections | {"gas": gas})
    assert limits.limit_table_of(study).largest_relative_error < 2e-5


def test_table_of_limits_has_points_enough_for_a_wavy_profile(paper, monkeypatch) -> None:
    """A disc of 20 mm radius, 700 rad/m: 7 × 6 positions left an error of 0.5 of the force."""
    ranges = box_of(paper).ranges | {"phi_r_m": (0.0, 0.0129)}
    monkeypatch.setattr(limits, "box_of", lambda config: SimpleNamespace(ranges=dict(ranges)))
    profile = {"kind": "bessel", "nodal_diameters": 0, "wave_number_rad_per_m": 700.0}
    profile |= {"edge_share": 0.0, "direction_deg": 0.0}
    disc = {"frequency_hz": 40e3, "surface_radius_m": 0.02, "profile": profile}
    study = Config(path=paper.path, sections=paper.sections | {"actuator": disc})
    table = limits.limit_table_of(study)
    assert table.largest_relative_error < 1e-5
    assert len(table.coefficients["limit_n"]) <= MOST_NODES


def test_models_of_the_limits_know_a_tilted_and_bulging_finger(paper, monkeypatch) -> None:
    """The force by the limit within its error, and the table's polynomials; not with inertia."""
    ranges = box_of(paper).ranges | {"phi_r_m": (0.0, 0.0), "phi_deg": (0.0, 0.0)}
    monkeypatch.setattr(limits, "box_of", lambda config: SimpleNamespace(ranges=dict(ranges)))
    gap = {"tilt_x_m": 1e-6, "tilt_y_m": 0.0, "bulge_m": 0.5e-6}
    sections = paper.sections | {"finger": paper["finger"] | {"gap": gap}}
    study = Config(path=paper.path, sections=sections)
    table = reference_table("screen").iloc[::7]
    scenes = scenes_in(table, study)
    still = [replace(each, gas=replace(each.gas, inertia="none")) for each in scenes]
    known = with_limits(table, still)
    forces = np.array([each.force_n for each in solve(still, tolerance=1e-5, method="periodic")])
    assert set(known["status"]) == {"ok"}
    assert np.all(np.abs(known["limit_n"] - forces) < known["limit_error_n"])
    assert np.abs(known["limit_n"] / forces - 1).max() < 0.01
    sections = sections | {"gas": paper["gas"] | {"inertia": "none"}}
    assert (
        limits.limit_table_of(Config(path=paper.path, sections=sections)).largest_relative_error
        < 1e-4
    )
    moving = [replace(each, gas=replace(each.gas, inertia="included")) for each in scenes]
    (reason,) = set(with_limits(table, moving)["status"])
    assert "gap that is even at rest" in reason
