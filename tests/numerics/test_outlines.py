"""Pads of other outlines and places: turned rectangles, ellipses, curves from a file."""

from dataclasses import replace
from functools import partial
from math import log, pi, sqrt
from pathlib import Path

import films
import numpy as np
import pytest
from films import PISTON, film, with_pad
from physics_facts import fast_piston
from scipy.special import ellipe, iv
from skfem import MeshTri2

from squeezefilm.api.film import Film as FilmOfUser
from squeezefilm.film.outline import read_contour
from squeezefilm.film.pad import GapShape
from squeezefilm.film.positions import cartesian_from_polar
from squeezefilm.film.profiles import StandingWave
from squeezefilm.film.scene import Scene, Scenes
from squeezefilm.quantities.outputs import _outputs_from_states
from squeezefilm.quantities.pressure import gauge_pressure_and_change
from squeezefilm.reynolds.asymptotics import edge_layer
from squeezefilm.reynolds.device import choose_device
from squeezefilm.reynolds.solver import solve
from squeezefilm_workflow.verification import finite_elements

TILTED = GapShape(tilt_x_m=1e-6, tilt_y_m=-0.5e-6, crown_m=-0.2e-6)
WAVE = StandingWave(wavelength_m=0.02, direction_deg=0.0, crest_m=0.001)
TURN = 2 * np.pi * np.arange(120) / 120
solved, mean = partial(films.solved, method="auto"), partial(films.mean, method="auto")


def ellipse(**numbers: object) -> Scene:
    return with_pad(film(**numbers), shape="ellipse")  # type: ignore[arg-type]


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
    layer = float(edge_layer.layer_integrals(np.array(epsilon))[0]) * rim / (pi / 4 * aspect)
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
    """Mean overpressures good to 5e-7, by a method that shares the equation alone.

    With each symmetry, and none.
    """
    scene = with_pad(ellipse(aspect=aspect, **numbers), gap=gap)
    assert mean(scene, tolerance=1e-6) == pytest.approx(expected, rel=2e-6)


@pytest.mark.parametrize("outline", ["rectangle", "ellipse"])
def test_turning_pad_place_and_profile_changes_nothing(outline):
    """Off the centre and off the axes, so that turning the wrong way would show."""
    scene = with_pad(film(epsilon=0.4, sigma=300.0, aspect=0.6, profile=WAVE), shape=outline)
    scene = replace(scene, **cartesian_from_polar(0.002, 20.0))
    wave = replace(WAVE, direction_deg=50.0)
    turned = replace(
        scene, **cartesian_from_polar(0.002, 70.0), actuator=replace(scene.actuator, profile=wave)
    )
    all_turned = with_pad(turned, rotation_deg=50.0)
    first = mean(scene, tolerance=1e-4)
    assert mean(all_turned, tolerance=1e-4) == pytest.approx(first, rel=1e-9)
    assert mean(with_pad(turned, rotation_deg=-50.0), tolerance=1e-4) != pytest.approx(
        first, rel=1e-2
    )


def test_a_tilted_pad_carries_as_a_slider_bearing():
    """Without vibration and at a small bearing number: Reynolds' plane slider (1886).

    W/L = Λ/H2² [ln(1 + K) − 2K/(2 + K)]/K² with H from H1 = H2 (1 + K) down to H2, twice as wide
    less once as wide to be rid of the ends.
    """
    h0, tilt = 5e-6, 4e-6
    wedge = [
        with_pad(film(epsilon=0.0, sigma=1.0, bearing=1e-4, aspect=a), gap=GapShape(tilt_x_m=-tilt))
        for a in (4.0, 8.0)
    ]
    narrow, wide = (mean(scene, tolerance=1e-4) * scene.aspect for scene in wedge)
    low = 1 - tilt / h0 / 2
    k = tilt / h0 / low
    expected = 1e-4 / low**2 * (log(1 + k) - 2 * k / (2 + k)) / k**2
    assert (wide - narrow) / 4 == pytest.approx(expected, rel=1e-3)


def written(folder: Path, z_mm: np.ndarray) -> Path:
    path = folder / "patch.csv"
    rows = "".join(f"{z.real:.9f},{z.imag:.9f}\n" for z in z_mm)
    path.write_text(f"x_mm,y_mm\n{rows}", encoding="utf-8")
    return path


def ellipse_mm(scene: Scene, turned_deg: float = 0.0) -> np.ndarray:
    half_x, half_y = 500 * scene.pad.length_x_m, 500 * scene.pad.length_y_m
    turn = np.exp(1j * np.radians(turned_deg))
    return turn * (half_x * np.cos(TURN) + 1j * half_y * np.sin(TURN)) + 2 - 3j


def curved(scene: Scene, folder: Path, z_mm: np.ndarray, sides_m: tuple[float, float]) -> Scene:
    contour = read_contour(written(folder, z_mm), sides_m=sides_m)
    return with_pad(
        scene, shape="curve", length_x_m=sides_m[0], length_y_m=sides_m[1], contour=contour
    )


def test_a_curve_lies_as_its_file_says(tmp_path):
    """A turned ellipse, off the centre of a wave, turned by its pad or in its file."""
    plain = film(
        epsilon=0.4,
        sigma=300.0,
        aspect=0.6,
        profile=replace(WAVE, direction_deg=20.0),
        x=0.2,
        y=0.1,
    )
    scene = with_pad(plain, shape="ellipse", rotation_deg=30.0)
    rim = np.array(scene.pad.edge_points_m())
    half = 0.5 * np.hypot(
        scene.pad.length_x_m * np.array([np.sqrt(0.75), 0.5]),
        scene.pad.length_y_m * np.array([0.5, np.sqrt(0.75)]),
    )
    assert np.abs(rim).max(axis=0) == pytest.approx(half, rel=1e-3)
    given = curved(plain, tmp_path, ellipse_mm(scene, 30.0), tuple(2 * half))
    assert solved(given, tolerance=1e-4).force_n == pytest.approx(
        solved(scene, tolerance=1e-4).force_n, rel=2e-4
    )
    other = with_pad(scene, rotation_deg=-30.0)
    assert solved(other, tolerance=1e-4).force_n != pytest.approx(
        solved(scene, tolerance=1e-4).force_n, rel=1e-2
    )


def patch(turn: np.ndarray) -> np.ndarray:
    """x + iy of a fingertip's contact that has no symmetry."""
    wide = 5 * np.cos(turn) + 0.3 * np.sin(2 * turn)
    return np.asarray(wide + 1j * (4 * np.sin(turn) + 0.4 * np.cos(2 * turn)))


def triangles(rim: np.ndarray, refined: int) -> MeshTri2:
    """A disc's curved triangles, carried inside a closed curve by its harmonic continuation."""
    mesh = MeshTri2.init_circle(refined)
    along = np.fft.fft(rim) / len(rim)
    n = np.fft.fftfreq(len(rim), 1 / len(rim))
    r, angle = np.hypot(*mesh.p), np.arctan2(mesh.p[1], mesh.p[0])
    z = (r[:, None] ** np.abs(n) * np.exp(1j * np.outer(angle, n))) @ along
    return replace(mesh, doflocs=np.array([z.real, z.imag]))


@pytest.mark.parametrize(("epsilon", "sigma"), [(0.3, 10.0), (0.6, 100.0)])
def test_a_patch_of_no_symmetry_has_the_force_of_finite_elements(epsilon, sigma, tmp_path):
    """Marched until it repeats itself, in x and y: nothing is shared but the equation."""
    dense = patch(np.linspace(0, 2 * np.pi, 200_001))
    sides_m = 1e-3 * np.ptp(dense.real), 1e-3 * np.ptp(dense.imag)
    scene = curved(film(epsilon=epsilon, sigma=sigma, x=0.2), tmp_path, patch(TURN), sides_m)
    unit = 1e3 * sides_m[0]
    middle = (dense.real.max() + dense.real.min() + 1j * (dense.imag.max() + dense.imag.min())) / 2

    mesh = triangles((patch(TURN) - middle) / unit + 0.5 + 0.5j * scene.aspect, refined=3)
    coarse, fine = (
        finite_elements.periodic_mean_force(
            scene, mesh=mesh, steps=steps, periods=150, tolerance=1e-6, anderson_depth=10
        )
        for steps in (24, 48)
    )
    scale_n = scene.gas.ambient_pressure_pa * sides_m[0] ** 2
    force_n = solved(scene, tolerance=1e-5).force_n
    assert coarse * scale_n != pytest.approx(force_n, rel=1e-3)  # of second order in time
    assert (4 * fine - coarse) / 3 * scale_n == pytest.approx(force_n, rel=1e-4)


# Answers and their errors by Galerkin's method in the modes of the ellipse.
MODES = {
    "power": (0.1210377, 4.7e-4),
    "thrust_x": (4.865736e-05, 1.1e-7),
    "thrust_y": (2.803626e-05, 9e-8),
    "moment_x": (-1.2331327e-4, 3.2e-6),
    "centre_y": (-1.996089e-4, 5.6e-6),
    "film_stiffness": (810644.4, 1017.0),
}


def test_the_answers_under_an_ellipse_are_those_of_its_modes():
    """By two methods that share no more than the equation."""
    scene = with_pad(film(epsilon=0.44, sigma=100.0, aspect=0.8, x=0.2, y=0.1), shape="ellipse")
    forces = solve([scene], tolerance=1e-4, method="periodic", keep_states=True)
    ((values, missing),) = _outputs_from_states(
        Scenes.of([scene]), forces, tolerance=1e-4, device=None
    )
    assert not missing
    for name, (expected, error) in MODES.items():
        value, estimated = values[name]
        assert value == pytest.approx(expected, abs=estimated + error, rel=0)


def test_the_pressure_under_a_curve_is_that_under_its_ellipse(tmp_path):
    scene = with_pad(film(epsilon=0.44, sigma=100.0, aspect=0.8, x=0.2), shape="ellipse")
    sides_m = scene.pad.length_x_m, scene.pad.length_y_m
    given = curved(scene, tmp_path, ellipse_mm(scene), sides_m)
    wanted = {"x": np.linspace(0, 1, 9), "y": np.linspace(0, 1, 8), "time_points": 8}
    one, other = (
        gauge_pressure_and_change(each, **wanted, tolerance=1e-4, device=choose_device())[0]
        for each in (scene, given)
    )
    inside = np.isfinite(one) & np.isfinite(other)
    assert np.abs(one - other)[inside].max() <= 5e-4 * np.abs(one[inside]).max()
    assert inside[0].sum() > 30


def test_nearly_equal_modes_around_a_slender_ellipse_need_no_inverse():
    """At 1e-8 its angle has modes whose matrix is singular to rounding."""
    film = FilmOfUser.of(
        actuator={
            "frequency": "20 kHz",
            "surface_radius": "30 mm",
            "profile": {"kind": "sinc", "wave_number": 90.0},
        },
        pad={"shape": "ellipse", "length_x": "3 mm", "length_y": "8 mm"},
        gas={"rarefaction": "slip", "inertia": "none", "thermal": "none"},
    )
    scene = film.scene("8 um", "4 um", x="1 mm")
    (close,), (rough,) = (solve([scene], tolerance=tolerance) for tolerance in (1e-8, 1e-5))
    assert close.status == "ok"
    assert abs(close.force_n - rough.force_n) <= rough.force_error_n + close.force_error_n
