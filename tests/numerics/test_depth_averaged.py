"""The estimated error of depth-averaged terms is that of resolved theory and films."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from stored_strip import strip_force

from squeezefilm.film.profiles import Piston
from squeezefilm.film.scene import Scene
from squeezefilm.quantities.model_error import DEPTH_AVERAGING_FILE, depth_averaging_change_percent
from squeezefilm.reynolds import solve
from squeezefilm_workflow.verification.second_order import (
    depth_averaged_force,
    depth_resolved_force,
    table_cases,
)


def film(scene: Scene, reynolds: float, sigma: float, epsilon: float = 0.1, **gas: str) -> Scene:
    """A square piston film of given numbers; with inertia, unless said."""
    its, rate = scene.gas, scene.actuator.angular_frequency_rad_per_s
    per_gap = its.viscosity_pa_s / scene.h0_m**2
    its = replace(
        its,
        density_kg_per_m3=reynolds * per_gap / rate,
        ambient_pressure_pa=12 * per_gap * rate * scene.pad.length_x_m**2 / sigma,
        **({"inertia": "included"} | gas),
    )
    actuator = replace(scene.actuator, profile=Piston())
    return replace(scene, gas=its, actuator=actuator, hv_m=epsilon * scene.h0_m)


HEATED = {"thermal": "included"}


def test_the_tables_nodes_come_back(scene):
    for row in pd.read_csv(DEPTH_AVERAGING_FILE).itertuples():
        change, off = depth_averaging_change_percent(
            film(scene, row.reynolds, row.sigma, **(HEATED if row.thermal else {}))
        )
        assert change == pytest.approx(100 * (row.resolved / row.averaged - 1), rel=1e-9, abs=1e-12)
        assert off >= 0.7 * abs(change)


@pytest.mark.parametrize("row", [0, 18, 33])
def test_a_row_of_the_table_is_found_again(row):
    """``squeezefilm-verification depth-averaged``; stored averages with heat are of ε 0.005."""
    thermal, reynolds, sigma = table_cases()[row]
    stored = pd.read_csv(DEPTH_AVERAGING_FILE).loc[row]
    assert tuple(stored[["thermal", "reynolds", "sigma"]]) == (thermal, reynolds, sigma)
    numbers = {"reynolds": reynolds, "sigma": sigma, "thermal": thermal}
    assert depth_resolved_force(**numbers) == pytest.approx(stored["resolved"], abs=6e-7)
    assert depth_averaged_force(**numbers) == pytest.approx(stored["averaged"], abs=2e-6)


def test_the_error_falls_to_zero_with_re_and_is_smooth_in_both(scene):
    assert depth_averaging_change_percent(film(scene, 1.0, 600.0, inertia="none")) == (0.0, 0.0)
    small = [depth_averaging_change_percent(film(scene, 10.0**-k, 600.0))[0] for k in (1, 2, 3)]
    assert small == pytest.approx([1e2 * small[1], small[1], 1e-2 * small[1]])
    over = np.array(
        [
            depth_averaging_change_percent(film(scene, re, 600.0))[0]
            for re in np.linspace(1, 20, 400)
        ]
    )
    assert np.abs(np.diff(over, 2)).max() < 1e-3
    # Beyond the largest σ of the table the error goes on by 1/√σ, to no more than a tenth more.
    at_table, beyond, far = (
        depth_averaging_change_percent(film(scene, 10.0, s))[0] for s in (2400, 1e4, 1e8)
    )
    assert 1 < beyond / at_table < far / at_table < 1.1


def test_beyond_what_was_resolved_nothing_is_claimed(scene):
    for reynolds, sigma, gas in ((20.1, 600.0, {}), (10.1, 600.0, HEATED), (2.1, 19.0, {})):
        assert np.isnan(depth_averaging_change_percent(film(scene, reynolds, sigma, **gas))).all()
    change, off = depth_averaging_change_percent(film(scene, 1.9, 19.0))
    assert change == 0 < off
    change, off = depth_averaging_change_percent(film(scene, 1.9, 600.0, inertia="none", **HEATED))
    assert change == 0 < off


@pytest.mark.parametrize(("sigma", "gas"), [(100.0, {}), (25.0, HEATED)])
def test_the_solver_has_the_tables_depth_averaged_forces(scene, sigma, gas):
    """So that the table is of these terms, and no others."""
    its = film(scene, 10.0, sigma, epsilon=0.005, **gas)
    (found,) = solve([its], tolerance=2e-5, method="periodic")
    table = pd.read_csv(DEPTH_AVERAGING_FILE).set_index(["thermal", "reynolds", "sigma"])
    mean = found.force_n / its.force_scale_n / its.epsilon**2
    assert mean == pytest.approx(table["averaged"][int(bool(gas)), 10.0, sigma], rel=3e-5)


@pytest.mark.parametrize(
    ("epsilon", "sigma", "reynolds", "thermal"),
    [
        (0.05, 2.0, 2.0, False),
        (0.4, 30.0, 8.0, False),
        (0.2, 300.0, 12.0, False),
        (0.4, 60.0, 3.0, True),
    ],
)
def test_strips_that_resolve_the_profiles_lie_within_the_estimate(
    scene, epsilon, sigma, reynolds, thermal
):
    """Another geometry, profile and amplitude than the table's."""
    numbers = {"epsilon": epsilon, "sigma": sigma, "reynolds": reynolds}
    equations = ("one_mode_of_heat", "resolved_heat") if thermal else ("one_mode", "resolved")
    averaged, resolved = (strip_force(equation, **numbers) for equation in equations)
    gas = HEATED if thermal else {}
    change, off = depth_averaging_change_percent(film(scene, reynolds, sigma, epsilon, **gas))
    assert abs(100 * (resolved / averaged - 1) - change) < off
