"""Pads with an outline from a file, and the coordinates of outlines."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from films import PISTON, film
from scipy.special import ive, ivp
from skfem import MeshTri2

from squeezefilm.film.finger import GapShape
from squeezefilm.film.outline import ellipse, read_contour
from squeezefilm.film.profiles import StandingWave
from squeezefilm.film.scene import Scene
from squeezefilm.quantities.outputs import _from_states
from squeezefilm.quantities.pressure import pressure
from squeezefilm.reynolds.device import choose_device
from squeezefilm.reynolds.solver import solve
from verification import finite_elements

WAVE = StandingWave(wavelength_m=0.02, direction_deg=20.0, crest_m=0.001)
TURN = 2 * np.pi * np.arange(120) / 120


def shaped(scene: Scene, **changes: object) -> Scene:
    return replace(scene, finger=replace(scene.finger, **changes))  # type: ignore[arg-type]


def written(folder: Path, z_mm: np.ndarray) -> Path:
    path = folder / "patch.csv"
    rows = "".join(f"{z.real:.9f},{z.imag:.9f}\n" for z in z_mm)
    path.write_text(f"x_mm,y_mm\n{rows}", encoding="utf-8")
    return path


def ellipse_mm(scene: Scene, turned_deg: float = 0.0) -> np.ndarray:
    half_x, half_y = 500 * scene.finger.length_x_m, 500 * scene.finger.length_y_m
    turn = np.exp(1j * np.radians(turned_deg))
    return turn * (half_x * np.cos(TURN) + 1j * half_y * np.sin(TURN)) + 2 - 3j


def curved(scene: Scene, folder: Path, z_mm: np.ndarray, sides_m: tuple[float, float]) -> Scene:
    contour = read_contour(written(folder, z_mm), sides_m=sides_m)
    return shaped(
        scene, shape="curve", length_x_m=sides_m[0], length_y_m=sides_m[1], contour=contour
    )


def force(scene: Scene, tolerance: float = 1e-5) -> float:
    (solution,) = solve([scene], tolerance=tolerance)
    assert solution.status == "ok"
    assert solution.method == "periodic"
    return solution.force_n


@pytest.mark.parametrize("aspect", [0.2, 0.96, 1.0, 1.04, 3.0])
def test_an_ellipse_s_coordinates_end_on_its_rim(aspect):
    outline = ellipse(aspect)
    x, y = outline.positions(np.array(1.0), np.linspace(0, 6, 50))
    assert (2 * x - 1) ** 2 + (2 * y - 1) ** 2 == pytest.approx(1, abs=1e-11)
    assert outline.area == pytest.approx(np.pi / 4 * aspect, rel=1e-12)
    u, v = outline.coordinates(*outline.positions(np.linspace(0.5, 1, 50), np.linspace(0, 6, 50)))
    again = outline.positions(u, v)
    assert again == pytest.approx(
        np.array(outline.positions(np.linspace(0.5, 1, 50), np.linspace(0, 6, 50))), abs=1e-6
    )


@pytest.mark.parametrize(
    "numbers",
    [
        {"epsilon": 0.44, "sigma": 583.0, "aspect": 0.8},
        {"epsilon": 0.4, "sigma": 30.0, "aspect": 1.3, "x": 0.2, "y": 0.1},
    ],
)
def test_an_ellipse_may_be_given_as_a_curve(numbers, tmp_path):
    scene = shaped(film(**numbers), shape="ellipse", gap=GapShape(tilt_x_m=1e-6))
    sides_m = scene.finger.length_x_m, scene.finger.length_y_m
    given = curved(scene, tmp_path, ellipse_mm(scene), sides_m)
    assert force(given) == pytest.approx(force(scene), rel=5e-5)


def test_a_curve_lies_as_its_file_says(tmp_path):
    """A turned ellipse, off the centre of a wave, turned by its finger or in its file."""
    plain = film(epsilon=0.4, sigma=300.0, aspect=0.6, profile=WAVE, x=0.2, y=0.1)
    scene = shaped(plain, shape="ellipse", rotation_deg=30.0)
    rim = np.array(scene.finger.outline())
    half = 0.5 * np.hypot(
        scene.finger.length_x_m * np.array([np.sqrt(0.75), 0.5]),
        scene.finger.length_y_m * np.array([0.5, np.sqrt(0.75)]),
    )
    assert np.abs(rim).max(axis=0) == pytest.approx(half, rel=1e-3)
    given = curved(plain, tmp_path, ellipse_mm(scene, 30.0), tuple(2 * half))
    assert force(given, 1e-4) == pytest.approx(force(scene, 1e-4), rel=2e-4)
    other = shaped(scene, rotation_deg=-30.0)
    assert force(other, 1e-4) != pytest.approx(force(scene, 1e-4), rel=1e-2)


def patch(turn: np.ndarray) -> np.ndarray:
    """x + iy of a fingertip's contact that has no symmetry."""
    wide = 5 * np.cos(turn) + 0.3 * np.sin(2 * turn)
    return np.asarray(wide + 1j * (4 * np.sin(turn) + 0.4 * np.cos(2 * turn)))


def stiffness(z: np.ndarray, slope: np.ndarray, sigma: float) -> float:
    """Spring coefficient of a pad that vibrates as a whole, for the length along x, by Trefftz.

    ∇²p − iσp = iσ with p = 0 on the rim: p + 1 = Σ a_n I_n(κr) exp(inφ), κ² = iσ, by least squares
    on the rim; its mean by the flux over the rim.
    """
    kappa, n = np.sqrt(1j * sigma), np.arange(-24, 25)
    r, angle = np.abs(z)[:, None], np.angle(z)[:, None]
    largest = ive(np.abs(n), kappa * r.max()) * np.exp(np.abs((kappa * r.max()).real))
    wave = np.exp(1j * n * angle) / largest
    values = ive(np.abs(n), kappa * r) * np.exp((kappa * r).real) * wave
    along_r = kappa * ivp(np.abs(n), kappa * r) * wave
    around = 1j * n / r * values
    a, *_ = np.linalg.lstsq(values, np.ones(len(z), dtype=complex), rcond=None)
    assert np.abs(values @ a - 1).max() < 1e-7
    outward = -1j * slope * np.exp(-1j * angle[:, 0])  # normal · |dz|, along r and around
    flux = ((along_r @ a) * outward.real + (around @ a) * outward.imag).mean() * 2 * np.pi
    area = 0.5 * (z.conj() * slope).imag.mean() * 2 * np.pi
    return float(1 - (flux / (1j * sigma * area)).real)


@pytest.mark.parametrize("sigma", [10.0, 200.0])
def test_a_patch_of_no_symmetry_has_its_linear_limit(sigma, tmp_path):
    """Where all of the gap moves alike F = 5/4 ε² S, whatever the outline."""
    epsilon = 1e-3
    dense = patch(np.linspace(0, 2 * np.pi, 200_001))
    sides_m = 1e-3 * np.ptp(dense.real), 1e-3 * np.ptp(dense.imag)
    scene = film(epsilon=epsilon, sigma=sigma, profile=PISTON)
    given = curved(scene, tmp_path, patch(TURN), sides_m)
    turn = 2 * np.pi * np.arange(400) / 400
    z, ahead, behind = (patch(turn + step) for step in (0.0, 1e-5, -1e-5))
    unit = 1e3 * sides_m[0]
    expected = stiffness(z / unit, (ahead - behind) / 2e-5 / unit, given.sigma)
    mean = force(given) / given.force_scale_n
    assert mean == pytest.approx(1.25 * epsilon**2 * expected, rel=5e-5)


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

    def amplitude(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        return scene.amplitude(0.5 + x, 0.5 + y * sides_m[0] / sides_m[1])

    mesh = triangles((patch(TURN) - middle) / unit, refined=3)
    coarse, fine = (
        finite_elements.periodic_force(
            epsilon=scene.epsilon,
            sigma=scene.sigma,
            amplitude=amplitude,
            mesh=mesh,
            steps=steps,
            tolerance=1e-6,
            anderson_depth=10,
        ).force
        for steps in (24, 48)
    )
    scale_n = scene.gas.ambient_pressure_pa * sides_m[0] ** 2
    assert coarse * scale_n != pytest.approx(force(scene), rel=1e-3)  # of second order in time
    assert (4 * fine - coarse) / 3 * scale_n == pytest.approx(force(scene), rel=1e-4)


# Answers and their errors by Galerkin's method in the modes of the ellipse (commit cde05ac).
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
    scene = shaped(film(epsilon=0.44, sigma=100.0, aspect=0.8, x=0.2, y=0.1), shape="ellipse")
    forces = solve([scene], tolerance=1e-4, method="periodic", keep_states=True)
    (grid,) = _from_states([scene], forces, tolerance=1e-4, device=None)
    assert not grid.refused
    for name, (expected, error) in MODES.items():
        allowed = grid.error[name] + error
        assert grid.value[name] == pytest.approx(expected, abs=allowed, rel=0)


def test_the_pressure_under_a_curve_is_that_under_its_ellipse(tmp_path):
    scene = shaped(film(epsilon=0.44, sigma=100.0, aspect=0.8, x=0.2), shape="ellipse")
    sides_m = scene.finger.length_x_m, scene.finger.length_y_m
    given = curved(scene, tmp_path, ellipse_mm(scene), sides_m)
    wanted = {"x": np.linspace(0, 1, 9), "y": np.linspace(0, 1, 8), "instants": 8}
    one, other = (
        pressure(each, **wanted, tolerance=1e-4, device=choose_device()).values
        for each in (scene, given)
    )
    inside = np.isfinite(one) & np.isfinite(other)
    assert np.abs(one - other)[inside].max() <= 5e-4 * np.abs(one[inside]).max()
    assert inside[0].sum() > 30


def test_a_curve_does_not_slide(tmp_path):
    scene = film(epsilon=0.4, sigma=300.0, bearing=5.0)
    sides_m = scene.finger.length_x_m, scene.finger.length_y_m
    (solution,) = solve([curved(scene, tmp_path, ellipse_mm(scene), sides_m)], tolerance=1e-3)
    assert solution.status == "not supported: a sliding pad that is not a rectangle"
