"""A film whose equation was not derived, or has no solution, gets its reason and no force."""

from dataclasses import replace

import numpy as np
import pytest
from films import film

from squeezefilm.film.pad import GapShape
from squeezefilm.film.profiles import Quadrature, StandingWave
from squeezefilm.reynolds import solve
from squeezefilm.reynolds.solver import previews

INERTIA, HEAT, SLIDING = {"inertia": "included"}, {"heat": "included"}, {"bearing": 0.1}
FACTOR, SLIP = {"rarefaction": "fukui-kaneko"}, {"rarefaction": "slip"}
ELLIPSE, TILTED = {"shape": "ellipse"}, {"gap": GapShape(tilt_x_m=1e-6)}
WAVE = StandingWave(wavelength_m=0.02, direction_deg=0.0, crest_m=0.001)
TWO_PHASES = {"profile": Quadrature(WAVE, replace(WAVE, direction_deg=60.0), shares=(0.7, 0.7))}
COMPOSITE = "the composite expansion is "


@pytest.mark.parametrize(
    ("numbers", "pad", "method", "reason"),
    [
        (INERTIA | FACTOR, {}, "auto", "with fukui-kaneko"),
        (INERTIA | SLIDING, {}, "auto", "not supported: inertia with a sliding pad"),
        (INERTIA, ELLIPSE, "auto", "not supported: gas.inertia under a pad"),
        (INERTIA, ELLIPSE, "composite", "derived for rectangular pads"),
        (INERTIA | TWO_PHASES, {}, "composite", COMPOSITE + "derived for one quadrature component"),
        (HEAT | {"polytropic_exponent": 1.4}, {}, "auto", "another gas.polytropic_exponent"),
        (HEAT | FACTOR, {}, "auto", "with fukui-kaneko"),
        (HEAT | SLIDING, {}, "auto", "not supported: heat with a sliding pad"),
        (HEAT, ELLIPSE, "auto", "not supported: gas.heat under a pad"),
        (HEAT, {}, "composite", COMPOSITE + "not derived with heat"),
        (SLIDING, ELLIPSE, "auto", "not supported: a sliding pad that is not a rectangle"),
        (SLIDING, {}, "composite", COMPOSITE + "not derived with bearing"),
        (SLIP, TILTED, "composite", COMPOSITE + "derived for a gap that is uniform at rest"),
    ],
)
def test_what_was_not_derived_is_refused_and_planned_so(numbers, pad, method, reason):
    scene = film(**{"epsilon": 0.3, "sigma": 200.0} | numbers)
    scene = replace(scene, pad=replace(scene.pad, **pad))
    (solution,) = solve([scene], tolerance=1e-3, method=method)
    assert reason in solution.status
    assert np.isnan(solution.force_n)
    assert previews([scene], tolerance=1e-3, method=method)[0].status == solution.status


def test_a_gas_too_rarefied_for_the_flow_factor_is_refused():
    scene = film(epsilon=0.9, sigma=500.0, rarefaction="fukui-kaneko", knudsen=0.17)
    (solution,) = solve([scene], tolerance=1e-3)
    assert "rarefied" in solution.status
    assert np.isnan(solution.force_n)
