"""A profile is measured before it is solved: fine features are seen or refused, never missed."""

import re

import numpy as np
import pytest
from films import LENGTH_M, PISTON, film, with_pad

from squeezefilm.film.profiles import Formula, StandingWave
from squeezefilm.film.surfaces import Disc
from squeezefilm.reynolds import solve

SPOT = "exp(-(r/2e-5)**2)"
ASIDE = "exp(-((x-0.0011)**2+(y+0.0017)**2)/2e-5**2)"


def formula(expression: str) -> Formula:
    return Formula(expression, surface=Disc(0.02))


def wave(share: float) -> StandingWave:
    """A standing wave of some share of the pad, its crest in the middle."""
    return StandingWave(wavelength_m=share * LENGTH_M, direction_deg=0.0, crest_m=0.0)


@pytest.mark.parametrize("tolerance", [1e-2, 1e-4])
@pytest.mark.parametrize("expression", [SPOT, ASIDE, f"1-0.5*{SPOT}", f"1-0.5*{ASIDE}"])
def test_a_spot_that_no_grid_sees_is_refused_with_its_size(expression, tolerance):
    """At half its height a spot exp(−(r/a)²) is 2 √(ln 2) a = 33 µm wide."""
    (solution,) = solve(
        [film(epsilon=0.9, sigma=2331.0, profile=formula(expression))], tolerance=tolerance
    )
    assert np.isnan(solution.force_n)
    width = re.search("a feature about ([0-9.]+) µm wide", solution.status)
    assert width is not None
    assert float(width[1]) == pytest.approx(33, rel=0.1)
    assert "320 points across 10 mm" in solution.status


@pytest.mark.parametrize("method", ["periodic", "composite"])
@pytest.mark.parametrize("shape", ["rectangle", "ellipse"])
def test_no_method_solves_what_it_does_not_see(method, shape):
    scene = film(epsilon=0.4, sigma=583.0, profile=formula(SPOT))
    scene = with_pad(scene, shape=shape)
    (solution,) = solve([scene], tolerance=1e-2, method=method)
    assert "the profile has a feature" in solution.status


def test_a_spot_is_looked_for_under_the_pad_alone():
    elsewhere = "1-0.5*exp(-((x-0.011)**2+y**2)/2e-5**2)"
    flat, spotted = (
        solve([film(epsilon=0.4, sigma=583.0, profile=each)], tolerance=1e-4)[0]
        for each in (PISTON, formula(elsewhere))
    )
    assert spotted.status == "ok"
    assert spotted.force_n == pytest.approx(flat.force_n, rel=2e-4)


def off_centre(width_m: float) -> Formula:
    """A spot away from the middle, where Chebyshev's nodes are far apart."""
    return formula(f"0.3+exp(-((x-0.0011)**2+(y+0.0007)**2)/{width_m}**2)")


@pytest.mark.parametrize(
    ("profile", "sigma", "tolerances"),
    [
        (off_centre(3e-4), 100.0, (1e-2, 1e-4)),
        (off_centre(1.2e-3), 100.0, (1e-2, 1e-4)),
        (wave(1 / 8), 2331.0, (1e-4, 1e-6)),
        (wave(1 / 10), 2331.0, (1e-4, 1e-6)),
    ],
)
def test_what_a_grid_sees_is_solved(profile, sigma, tolerances):
    scene = film(epsilon=0.4, sigma=sigma, profile=profile)
    rough, fine = (solve([scene], tolerance=each)[0] for each in tolerances)
    assert rough.status == fine.status == "ok"
    assert abs(rough.force_n - fine.force_n) <= rough.force_error_n + fine.force_error_n


def test_a_refusal_gives_its_error_in_the_tolerance_s_terms():
    (solution,) = solve(
        [film(epsilon=0.4, sigma=2331.0, profile=wave(1 / 30))], tolerance=1e-6, method="periodic"
    )
    assert "not converged: tolerance not reached on the finest grid" in solution.status
    assert "of the force, 1e-06 allowed" in solution.status
    assert "inf" not in solution.status


@pytest.mark.parametrize(
    ("centre_m", "shape"), [(0.0112, "rectangle"), (0.0165, "rectangle"), (0.0112, "ellipse")]
)
def test_a_profile_next_to_nothing_bears_nothing_within_its_error(centre_m, shape):
    """1e-17 and 1e-58 at the pad's edge: the force, of its square, is far below rounding."""
    spot = formula(f"exp(-((x-{centre_m})/1e-3)**2)")
    scene = film(epsilon=0.4, sigma=100.0, profile=spot)
    scene = with_pad(scene, shape=shape)
    (solution,) = solve([scene], tolerance=1e-2, method="periodic")
    assert solution.status == "ok"
    assert abs(solution.force_n) <= solution.force_error_n < 1e-25
