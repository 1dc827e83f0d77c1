"""A film whose equation was not derived, or has no solution, gets its reason and no force."""

from dataclasses import replace

import numpy as np
import pytest
from films import film, with_pad

from squeezefilm.film.pad import GapShape
from squeezefilm.film.profiles import QuadratureProfile, StandingWave
from squeezefilm.reynolds import solve
from squeezefilm.reynolds.dry_run import dry_run

INERTIA, THERMAL, SLIDING = {"inertia": "included"}, {"thermal": "included"}, {"bearing": 0.1}
FACTOR, SLIP = {"rarefaction": "fukui-kaneko"}, {"rarefaction": "slip"}
ELLIPSE, TILTED = {"shape": "ellipse"}, {"gap": GapShape(tilt_x_m=1e-6)}
WAVE = StandingWave(wavelength_m=0.02, direction_deg=0.0, crest_m=0.001)
TWO_PHASES = {
    "profile": QuadratureProfile(
        WAVE, replace(WAVE, direction_deg=60.0), component_factors=(0.7, 0.7)
    )
}
COMPOSITE = "the composite expansion is "


@pytest.mark.parametrize(
    ("numbers", "pad", "method", "reason"),
    [
        (INERTIA | FACTOR, {}, "auto", "with fukui-kaneko"),
        (INERTIA, ELLIPSE, "composite", "derived for rectangular pads"),
        (INERTIA | TWO_PHASES, {}, "composite", COMPOSITE + "derived for one quadrature component"),
        (THERMAL | {"polytropic_exponent": 1.4}, {}, "auto", "another gas.polytropic_exponent"),
        (THERMAL | FACTOR, {}, "auto", "with fukui-kaneko"),
        (THERMAL, {}, "composite", COMPOSITE + "not derived with thermal effects"),
        (SLIDING, {}, "composite", COMPOSITE + "not derived with Couette term"),
        (SLIP, TILTED, "composite", COMPOSITE + "derived for a gap that is uniform at rest"),
    ],
)
def test_what_was_not_derived_is_refused_and_planned_so(numbers, pad, method, reason):
    scene = film(**{"epsilon": 0.3, "sigma": 200.0} | numbers)
    scene = with_pad(scene, **pad)
    (solution,) = solve([scene], tolerance=1e-3, method=method)
    assert reason in solution.status
    assert np.isnan(solution.force_n)
    assert dry_run([scene], tolerance=1e-3, method=method)[0]["status"] == solution.status
