"""Discs and ellipses with inertia, thermal effects, sliding: own programs and exact theory."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from films import PISTON, at_reynolds, film, mean, solved, with_pad
from resolved_disc import resolved_second_order
from test_outlines import WAVE, curved, ellipse_mm

from squeezefilm.film.pad import GapShape
from squeezefilm.film.scene import Scene
from squeezefilm.quantities.model_error import (
    depth_averaging_change_percent,
    error_budgets,
    resolve_auto_terms,
)
from squeezefilm.quantities.outputs import with_outputs
from squeezefilm.reynolds.device import choose_device
from squeezefilm.reynolds.grid import Grid
from squeezefilm.reynolds.periodic.launch import solve_batch
from squeezefilm.reynolds.solver import solve
from squeezefilm_workflow.verification.all_effects import Effects, force_on_grid
from squeezefilm_workflow.verification.published.linear_film import (
    depth_averaged_factors,
    disc_response,
)

BOTH = {"inertia": "included", "thermal": "included"}


def ellipse(reynolds: float, **numbers: object) -> Scene:
    """Under a disc, or an ellipse of the aspect, with inertia unless said."""
    scene = film(**{"inertia": "included", "profile": PISTON} | numbers)  # type: ignore[arg-type]
    return with_pad(at_reynolds(scene, reynolds), shape="ellipse")


def alone(scene: Scene, *, edge_coefficient: float = 0.0) -> float:
    """The same in the radius alone."""
    terms = {name: getattr(scene.gas, name) == "included" for name in BOTH}
    effects = Effects(**terms, slip="none", edge_loss_coefficient=edge_coefficient)
    return force_on_grid(scene, effects, points=64, instants=17) / scene.force_scale_n


@pytest.mark.parametrize(
    ("reynolds", "sigma", "gas"),
    [
        (1.0, 300.0, {}),
        (2.0, 40.0, {}),
        (2.0, 300.0, {}),
        (2.0, 40.0, BOTH),
        (1.0, 300.0, {"inertia": "none", "thermal": "included"}),
    ],
)
def test_a_disc_has_the_force_of_its_radius_alone(reynolds, sigma, gas):
    scene = ellipse(reynolds, epsilon=0.4, sigma=sigma, **gas)
    found, expected = solved(scene, tolerance=1e-5), alone(scene)
    off = found.force_n / scene.force_scale_n - expected
    assert abs(off) <= found.force_error_n / scene.force_scale_n <= 1e-5 * expected


def test_errors_fall_through_the_foci():
    """Where z′ is zero, inside the disc; by a factor of five for eight nodes across."""
    scene = ellipse(2.0, epsilon=0.4, sigma=300.0)
    expected, length_m = alone(scene), scene.pad.length_x_m
    # So little longer that it has an angle.
    scene = with_pad(scene, length_y_m=(1 + 1e-12) * length_m)
    pad = scene.pad.smooth_outline
    errors = [
        abs(
            solve_batch([scene], grid, tolerance=1e-9, device=choose_device()).mean_pressure_ratio[
                0
            ]
            - expected
        )
        for grid in (Grid(n, n // 2, 16, True, True, pad) for n in (8, 12, 16, 20))
    ]
    assert all(fine < coarse / 5 for coarse, fine in pairwise(errors))
    assert errors[-1] < 2e-5 * expected


@pytest.mark.parametrize(("reynolds", "sigma"), [(0.1, 20.0), (2.0, 100.0), (40.0, 20.0)])
def test_a_small_motion_has_the_linear_theory_s_force(reynolds, sigma):
    """The first harmonic by Bessel functions, S + iD with Re's factor of the parabola."""
    scene = ellipse(reynolds, epsilon=1e-3, sigma=sigma)
    (found,) = with_outputs(
        [scene],
        [solved(scene, tolerance=1e-4, keep_states=True)],
        outputs=("harmonics",),
        tolerance=1e-4,
    )
    factors = depth_averaged_factors(reynolds, prandtl=0.0, heat_capacity_ratio=1.4)
    force = complex(found.outputs.value["force_in_phase"], found.outputs.value["force_quadrature"])
    ours = -force / (scene.force_scale_n * scene.epsilon)
    assert ours == pytest.approx(disc_response(sigma, factors), rel=2e-5)


@pytest.mark.parametrize(("sigma", "reynolds"), [(20.0, 4.0), (100.0, 10.0), (600.0, 20.0)])
def test_a_disc_that_resolves_the_profile_lies_within_the_estimate(sigma, reynolds):
    """Second-order theory; without inertia it is 5/4 of the spring."""
    spring = disc_response(sigma).real
    assert resolved_second_order(sigma, 1e-5) == pytest.approx(1.25 * spring, rel=1e-5)
    scene = ellipse(reynolds, epsilon=1e-3, sigma=sigma)
    resolved = resolved_second_order(sigma, scene.modified_reynolds)
    change, off = depth_averaging_change_percent(scene)
    missed = 100 * (resolved / (alone(scene) / scene.epsilon**2) - 1)
    assert abs(missed) > 0.05
    assert abs(missed - change) < off


@pytest.mark.parametrize("gas", [{}, {"rarefaction": "slip"}, BOTH])
def test_an_ellipse_of_nearly_equal_axes_may_be_turned(gas):
    """Its long axis lies along y in two ways, and no film is even; what is turned has its own ν."""
    at = {"x": 0.1, "y": 0.05, "aspect": 1.03, "profile": WAVE}
    scene = ellipse(1.0, epsilon=0.4, sigma=300.0, **at, **gas)
    pad = scene.pad
    sides = {"length_x_m": pad.length_y_m, "length_y_m": pad.length_x_m}
    turned = replace(scene, pad=replace(pad, rotation_deg=90.0, **sides))
    assert solved(turned, tolerance=1e-5).force_n == pytest.approx(
        solved(scene, tolerance=1e-5).force_n, rel=1e-5
    )


def test_estimates_hold_with_inertia_heat_and_sliding():
    tilted = GapShape(tilt_x_m=1e-6, tilt_y_m=-0.5e-6, crown_m=-0.2e-6)
    off = {"x": 0.1, "y": 0.05}
    waves = ellipse(4.0, epsilon=0.3, sigma=500.0, aspect=0.8, **off)
    scenes = [
        ellipse(2.0, epsilon=0.5, sigma=2000.0, aspect=0.5, profile=WAVE, **off),
        ellipse(1.0, epsilon=0.6, sigma=30.0, aspect=1.4, x=0.1, thermal="included"),
        with_pad(waves, gap=tilted),
        ellipse(1.0, epsilon=0.6, sigma=100.0, inertia="none", bearing=100.0, aspect=0.7, **off),
    ]
    rough, fine = (solve(scenes, tolerance=tolerance) for tolerance in (1e-3, 1e-4))
    for one, other in zip(rough, fine, strict=True):
        assert other.status == "ok"
        assert abs(one.force_n - other.force_n) <= one.force_error_n <= 1e-3 * one.force_n


@pytest.mark.parametrize(
    ("numbers", "expected"),
    [
        ({"bearing": 2.0, "aspect": 0.6, "x": 0.1, "y": 0.05}, 0.08914504),
        ({"bearing": 20.0, "aspect": 1.0}, 0.05826850),
        ({"bearing": 20.0, "aspect": 1.5, "y": 0.1}, 0.04407188),
    ],
)
def test_a_sliding_ellipse_has_the_force_of_finite_elements(numbers, expected):
    """Good to about 1e-4, as of the patch in test_outlines.py; along −x it is as well mirrored."""
    scene = film(epsilon=0.4, sigma=100.0, **numbers)
    scene = with_pad(scene, shape="ellipse")
    assert mean(scene, tolerance=1e-5) == pytest.approx(expected, rel=1e-4)
    still, back = (
        with_pad(scene, speed_x_m_per_s=share * scene.pad.speed_x_m_per_s) for share in (0.0, -1.0)
    )
    assert mean(still, tolerance=1e-5) != pytest.approx(expected, rel=2e-3)
    other, own = mean(replace(back, x_m=-scene.x_m), tolerance=1e-5), mean(scene, tolerance=1e-5)
    assert other == pytest.approx(own, rel=1e-5)


def test_the_budget_of_an_ellipse_is_its_own():
    """Effects on an ellipse off the centre, and the loss at a disc's rim, at first order."""
    at = {"x": 0.1, "y": 0.05, "aspect": 0.5, "bearing": 2.0, "profile": WAVE}
    heavy = ellipse(0.02, epsilon=0.4, sigma=300.0, **at | {"bearing": 0.0})
    plain = heavy.with_gas(inertia="none")
    disc = ellipse(0.05, epsilon=0.4, sigma=300.0, inertia="none")
    slides = ellipse(0.02, epsilon=0.4, sigma=300.0, inertia="none", **at)
    own, of_disc, sliding = error_budgets([plain, disc, slides])
    for name in ("inertia", "thermal"):
        with_it = plain.with_gas(**{name: "included"})
        percent = 100 * (mean(with_it, tolerance=1e-8) / mean(plain, tolerance=1e-8) - 1)
        assert own.effects[name].percent == pytest.approx(percent, rel=0.02)
    percent = 100 * (alone(disc, edge_coefficient=1.0) / alone(disc) - 1)
    assert of_disc.effects["edge_loss"].percent == pytest.approx(percent, rel=0.02)
    percent = 100 * (1 - mean(plain, tolerance=1e-6) / mean(slides, tolerance=1e-6))
    assert sliding.effects["bearing"].percent == pytest.approx(percent, rel=1e-3)
    round_slides = replace(disc, pad=replace(disc.pad, speed_x_m_per_s=slides.pad.speed_x_m_per_s))
    (of_sliding_disc,) = error_budgets([round_slides])
    percent = 100 * (1 - mean(disc, tolerance=1e-6) / mean(round_slides, tolerance=1e-6))
    bearing = of_sliding_disc.effects["bearing"]
    assert abs(bearing.percent - percent) <= bearing.error_percent
    assert np.isfinite(own.modelling_error_percent).all()
    (chosen,) = resolve_auto_terms([ellipse(1.0, epsilon=0.4, sigma=300.0, inertia="auto")])
    assert chosen.gas.inertia == "included"


def test_momentum_that_leaves_over_an_outline_turns_with_it(tmp_path):
    scene = ellipse(1.0, epsilon=0.4, sigma=300.0, aspect=0.6, profile=WAVE, x=0.05)
    scene = with_pad(scene, rotation_deg=30.0)
    half = np.hypot(np.array([0.75, 0.25]) ** 0.5, 0.6 * np.array([0.25, 0.75]) ** 0.5)
    sides_m = tuple(scene.pad.length_x_m * half)
    flat = with_pad(scene, rotation_deg=0.0)
    scenes = [scene, curved(flat, tmp_path, ellipse_mm(scene, 30.0), sides_m)]
    scenes += [each.with_gas(inertia="none") for each in scenes]
    forces = [solved(each, tolerance=1e-3, keep_states=True) for each in scenes]
    found = with_outputs(scenes, forces, outputs=("thrust",), tolerance=1e-3)
    one, other, without, _ = (
        1e6 * np.array([each.outputs.value[f"thrust_{axis}"] for axis in "xy"]) for each in found
    )
    assert other == pytest.approx(one, abs=1e-3 * np.abs(one).max())
    assert one[0] != pytest.approx(without[0], rel=0.05)
