"""Pads of other outlines and places: turned rectangles, discs and ellipses."""

from dataclasses import replace
from math import log, pi, sqrt

import numpy as np
import pytest
from films import PISTON, film
from physics_facts import fast_piston
from scipy.special import ellipe, iv

from squeezefilm.columns import cartesian
from squeezefilm.errors import InputError
from squeezefilm.film.finger import GapShape
from squeezefilm.film.profiles import StandingWave
from squeezefilm.film.scene import Scene
from squeezefilm.film.surfaces import Disc
from squeezefilm.film.validity import check_scene
from squeezefilm.reynolds import Solution
from squeezefilm.reynolds.asymptotics import edge_layer
from squeezefilm.reynolds.plan import previews
from squeezefilm.reynolds.solver import solve

TILTED = GapShape(tilt_x_m=1e-6, tilt_y_m=-0.5e-6, bulge_m=-0.2e-6)
WAVE = StandingWave(wavelength_m=0.02, direction_deg=0.0, crest_m=0.001)


def pad(scene: Scene, **changes: object) -> Scene:
    return replace(scene, finger=replace(scene.finger, **changes))  # type: ignore[arg-type]


def ellipse(**numbers: object) -> Scene:
    return pad(film(**numbers), shape="ellipse")  # type: ignore[arg-type]


def solved(scene: Scene, *, tolerance: float = 1e-6, method: str = "auto") -> Solution:
    (solution,) = solve([scene], tolerance=tolerance, method=method)
    assert solution.status == "ok"
    return solution


def mean(scene: Scene, *, tolerance: float = 1e-6) -> float:
    """Mean overpressure over pad and period."""
    return solved(scene, tolerance=tolerance).force_n / scene.force_scale_n


def disc_stiffness(sigma: float) -> float:
    """Spring coefficient of a disc that vibrates as a whole, of diameter l0, by Bessel functions.

    ∇²p − iσp = iσ with p = 0 at r = 1/2: p = I0(√(iσ) r)/I0(√(iσ)/2) − 1.
    """
    z = np.sqrt(1j * sigma) / 2
    return float((1 - 2 * iv(1, z) / (z * iv(0, z))).real)


@pytest.mark.parametrize("sigma", [2.0, 22.0, 583.0, 5e3])
def test_a_disc_has_its_linear_limit(sigma):
    """Where all of the gap moves alike ⟨H³P²⟩ is constant, whatever the outline: F = 5/4 ε² S."""
    epsilon = 1e-3
    expected = 1.25 * epsilon**2 * disc_stiffness(sigma)
    assert mean(ellipse(epsilon=epsilon, sigma=sigma, profile=PISTON)) == pytest.approx(
        expected, rel=8 * epsilon**2 + 1e-6
    )


@pytest.mark.parametrize("aspect", [1.0, 0.5])
def test_an_ellipse_has_its_fast_limit(aspect):
    """The closed form over the area, and a layer that takes d(ε)/√σ of each length of the rim."""
    epsilon, sigma = 0.4, 5e3
    rim = 2 * max(1, aspect) * ellipe(1 - min(aspect, 1 / aspect) ** 2)
    layer = float(edge_layer.integrals(np.array(epsilon))[0]) * rim / (pi / 4 * aspect)
    scene = ellipse(epsilon=epsilon, sigma=sigma, aspect=aspect, profile=PISTON)
    assert mean(scene) == pytest.approx(
        fast_piston(epsilon) + layer / sqrt(sigma), rel=4 / (aspect**2 * sigma)
    )


def test_an_ellipse_holds_its_tolerance():
    """The error that is stated covers what a much finer solution shows, over kinds of films."""
    films = [
        ellipse(epsilon=0.44, sigma=583.0),
        ellipse(epsilon=0.9, sigma=100.0),
        ellipse(epsilon=0.3, sigma=40.0, x=0.2, y=0.1, aspect=1.5),
        ellipse(epsilon=0.4, sigma=200.0, profile=WAVE),
        ellipse(epsilon=0.4, sigma=583.0, rarefaction="fukui-kaneko", polytropic_exponent=1.4),
    ]
    for scene in films:
        rough, fine = solved(scene, tolerance=1e-3), solved(scene, tolerance=1e-5)
        assert abs(rough.force_n - fine.force_n) <= rough.force_error_n
        assert rough.force_error_n <= 1e-3 * abs(rough.force_n)


def test_an_ellipse_s_error_estimate_has_a_margin():
    """A mass error moves the pressure of a heated film by n/H, and ε is too small to hide that."""
    scene = ellipse(
        epsilon=0.1164, sigma=158.95, aspect=1.12167, profile=PISTON, polytropic_exponent=1.4
    )
    rough = solved(scene, tolerance=1e-2, method="periodic")
    fine = solved(scene, tolerance=1e-4)
    assert abs(rough.force_n - fine.force_n) <= 0.75 * rough.force_error_n


@pytest.mark.parametrize(
    ("numbers", "aspect", "gap", "expected"),
    [
        ({"epsilon": 0.4, "sigma": 300.0}, 0.3, GapShape(), 0.10276098),
        ({"epsilon": 0.4, "sigma": 300.0, "x": 0.2}, 0.7, GapShape(), 0.09859680),
        ({"epsilon": 0.4, "sigma": 300.0, "y": 0.2}, 1.4, GapShape(), 0.06767106),
        (
            {"epsilon": 0.4, "sigma": 300.0, "x": 0.2, "y": 0.1, "rarefaction": "slip"},
            1.01,
            TILTED,
            0.08854731,
        ),
        (
            {"epsilon": 0.3, "sigma": 3e3, "polytropic_exponent": 1.4, "profile": PISTON},
            0.96,
            GapShape(),
            0.1588474,
        ),
    ],
)
def test_an_ellipse_has_the_forces_of_galerkin_s_method_in_its_modes(
    numbers, aspect, gap, expected
):
    """Mean overpressures good to 5e-7, by a method that shared the equation alone (cde05ac).

    With each symmetry, and none.
    """
    scene = pad(ellipse(aspect=aspect, **numbers), gap=gap)
    assert mean(scene, tolerance=1e-6) == pytest.approx(expected, rel=2e-6)


@pytest.mark.parametrize("outline", ["rectangle", "ellipse"])
def test_turning_finger_place_and_profile_changes_nothing(outline):
    """Off the centre and off the axes, so that turning the wrong way would show."""
    scene = pad(film(epsilon=0.4, sigma=300.0, aspect=0.6, profile=WAVE), shape=outline)
    scene = replace(scene, **cartesian(0.002, 20.0))
    wave = replace(WAVE, direction_deg=50.0)
    turned = replace(
        scene, **cartesian(0.002, 70.0), actuator=replace(scene.actuator, profile=wave)
    )
    all_turned = pad(turned, rotation_deg=50.0)
    first = mean(scene, tolerance=1e-4)
    assert mean(all_turned, tolerance=1e-4) == pytest.approx(first, rel=1e-9)
    assert mean(pad(turned, rotation_deg=-50.0), tolerance=1e-4) != pytest.approx(first, rel=1e-2)


@pytest.mark.parametrize("outline", ["rectangle", "ellipse"])
def test_a_quarter_turn_exchanges_the_sides(outline):
    wide = pad(film(epsilon=0.4, sigma=300.0, aspect=2.0, x=0.1, y=0.2), shape=outline)
    # σ is in units of the side along x, which is the other one now.
    finger = replace(wide.finger, length_x_m=0.02, length_y_m=0.01, rotation_deg=90.0)
    high = replace(wide, finger=finger)
    forces = [solved(scene, tolerance=1e-4).force_n for scene in (wide, high)]
    assert forces[0] == pytest.approx(forces[1], rel=2e-4)


def test_what_is_even_about_the_middle_is_solved_on_a_quarter_of_a_disc():
    folded, off = ellipse(epsilon=0.4, sigma=300.0), ellipse(epsilon=0.4, sigma=300.0, x=1e-9)
    assert "mirror half in x; mirror half in y" in solved(folded).left_out
    assert "mirror half in x" not in solved(off, tolerance=1e-4).left_out
    assert mean(off, tolerance=1e-4) == pytest.approx(mean(folded, tolerance=1e-4), rel=2e-4)


def test_a_preview_is_how_an_ellipse_or_a_tilted_pad_is_solved():
    disc = ellipse(epsilon=0.4, sigma=583.0)
    tilted = pad(film(epsilon=0.4, sigma=583.0), gap=GapShape(tilt_x_m=2e-6))
    # At 1e-5 the disc's first grid is not always its last.
    for scene, domain, tolerance in ((disc, "quarter", 1e-4), (tilted, "half", 1e-5)):
        (way,) = previews([scene], tolerance=tolerance)
        solution = solved(scene, tolerance=tolerance)
        assert (way.method, way.domain) == (solution.method, domain)
        assert (way.nx, way.ny, way.nt) == (solution.nx, solution.ny, solution.nt)
        assert 0.5 < solution.work / 1e6 / way.expected_mflop < 2


def test_the_composite_expansion_of_an_ellipse_is_not_derived():
    (solution,) = solve([ellipse(epsilon=0.4, sigma=583.0)], tolerance=1e-3, method="composite")
    assert np.isnan(solution.force_n)
    assert "rectangular" in solution.status


def test_a_tilted_pad_carries_as_a_slider_bearing():
    """Without vibration and at a small bearing number: Reynolds' plane slider (1886).

    W/L = Λ/H2² [ln(1 + K) − 2K/(2 + K)]/K² with H from H1 = H2 (1 + K) down to H2, twice as wide
    less once as wide to be rid of the ends.
    """
    h0, tilt = 5e-6, 4e-6
    wedge = [
        pad(film(epsilon=0.0, sigma=1.0, bearing=1e-4, aspect=a), gap=GapShape(tilt_x_m=-tilt))
        for a in (4.0, 8.0)
    ]
    narrow, wide = (mean(scene, tolerance=1e-4) * scene.aspect for scene in wedge)
    low = 1 - tilt / h0 / 2
    k = tilt / h0 / low
    expected = 1e-4 / low**2 * (log(1 + k) - 2 * k / (2 + k)) / k**2
    assert (wide - narrow) / 4 == pytest.approx(expected, rel=1e-3)


@pytest.mark.parametrize("bearing", [0.1, 31.0])
@pytest.mark.parametrize("method", ["auto", "periodic"])
def test_an_ellipse_that_slides_is_not_supported(bearing, method):
    scene = ellipse(epsilon=0.4, sigma=583.0, bearing=bearing)
    (solution,) = solve([scene], tolerance=1e-3, method=method)
    (preview,) = previews([scene], tolerance=1e-3, method=method)
    assert solution.status == "not supported: a sliding pad that is not a rectangle"
    assert preview.status == solution.status
    assert np.isnan(solution.force_n)


def test_a_tilt_breaks_the_symmetry_along_it_alone():
    scene = pad(film(epsilon=0.4, sigma=300.0), gap=GapShape(tilt_x_m=1e-6))
    solution = solved(scene, tolerance=1e-4)
    assert "mirror half in y" in solution.left_out
    assert "mirror half in x" not in solution.left_out
    other = pad(scene, gap=GapShape(tilt_x_m=-1e-6))
    assert solved(other, tolerance=1e-4).force_n == pytest.approx(solution.force_n, rel=1e-9)


def test_a_pad_that_touches_is_refused():
    touching = pad(film(epsilon=0.3, sigma=583.0), gap=GapShape(tilt_x_m=9e-6))
    with pytest.raises(InputError, match="touches the surface"):
        check_scene(replace(touching, actuator=replace(touching.actuator, surface=Disc(1.0))))
