"""Inertia and thermal effects in the periodic state: limits, forces, strips, order, ``auto``."""

from __future__ import annotations

import time
from dataclasses import replace

import numpy as np
import pytest
from films import PISTON, SINC, at_reynolds, film, mean_overpressure
from numpy.linalg import solve as solve_linear
from random_scenes import moved_by_leaving_out, random_scenes
from stored_strip import strip_force

from squeezefilm.film.pad import Pad
from squeezefilm.film.profiles import Formula, Profile
from squeezefilm.film.scene import Actuator, Film, Gas, Scene
from squeezefilm.film.surfaces import Disc
from squeezefilm.film.validity import validity_text
from squeezefilm.quantities import model_error
from squeezefilm.quantities.model_error import (
    AUTO_TERM_TOLERANCE,
    error_budgets,
    resolve_auto_terms,
)
from squeezefilm.reynolds import solve
from squeezefilm.reynolds.periodic.like_films import films_on_grids_of
from squeezefilm.reynolds.spectral import cached_axis
from squeezefilm.reynolds.terms.inertia import LAG_PER_REYNOLDS
from squeezefilm.reynolds.terms.thermal import Thermal
from squeezefilm_workflow.verification.numpy_periodic import chebyshev_grid


def moving(reynolds: float, **numbers: object) -> Scene:
    """A scene with inertia, if nothing else is given, by its modified Reynolds number."""
    scene = film(**{"inertia": "included"} | numbers)  # type: ignore[arg-type]
    return at_reynolds(scene, reynolds)


def still(scene: Scene) -> Scene:
    return scene.with_gas(inertia="none")


def thermal_percent(scene: Scene, *, tolerance: float) -> float:
    """Change of the force by thermal effects."""
    with_it, without = forces([scene, scene.with_gas(thermal="none")], tolerance=tolerance)
    return 100 * float(with_it / without - 1)


def forces(scenes: list[Scene], *, tolerance: float, **options: object) -> np.ndarray:
    """In units of p0 times the area."""
    solved = solve(scenes, tolerance=tolerance, method="periodic", **options)  # type: ignore[arg-type]
    assert [each.status for each in solved] == ["ok"] * len(scenes)
    return np.array([a.force_n / b.force_scale_n for a, b in zip(solved, scenes, strict=True)])


def second_order(scene: Scene, *, points: int) -> float:
    """Mean overpressure over ε² as ε → 0: the equation of inertia.py expanded about rest.

    First order, with the mobility χ = 1/(1 + i Re/10) of a parabola, is Δp₁ − (iσ/χ) p₁ = (σ/χ) s;
    the mean of the second order is a Poisson equation. Dense, in Chebyshev points of its own.
    """
    sigma, reynolds = scene.sigma, scene.modified_reynolds
    line = chebyshev_grid(points)
    first, inner = line.derivative_matrix, (slice(1, -1), slice(1, -1))
    s = scene.amplitude(*np.meshgrid(line.x, line.x, indexing="ij"))
    one = np.eye(points)
    laplacian = np.kron(line.second_derivative_matrix[1:-1, 1:-1], one) + np.kron(
        one, line.second_derivative_matrix[1:-1, 1:-1]
    )

    def poisson(source: np.ndarray, decay: complex) -> np.ndarray:
        matrix = laplacian - decay * np.eye(points**2)
        return np.pad(solve_linear(matrix, source[inner].ravel()).reshape(points, points), 1)

    def gradient(values: np.ndarray) -> np.ndarray:
        return np.stack([first @ values, values @ first.T])

    def mean(a: np.ndarray, b: np.ndarray) -> np.ndarray:
        return np.real(a * np.conj(b)) / 2

    mobility = 1 / (1 + 0.1j * reynolds)
    pressure = poisson(sigma / mobility * s, 1j * sigma / mobility)
    slope = gradient(pressure)
    flow, gap = -mobility / sigma * slope, -1j * s
    shear = [gradient(each) for each in flow]
    carried = np.stack([mean(flow[0], each[0]) + mean(flow[1], each[1]) for each in shear])
    forced = (
        mean(pressure + 2 * gap, 1j * flow)
        + 9 / 7 * carried
        - mean(1j * (gap + pressure), flow) / 7
    )
    drive = sigma * mean(gap + pressure, flow) - 0.1 * sigma * reynolds * forced
    drive = drive - 2 * mean(gap, slope)
    source = first @ drive[0] + drive[1] @ first.T
    return float(line.weights @ poisson(source, 0.0) @ line.weights)


@pytest.mark.parametrize(
    ("reynolds", "sigma", "place", "profile"),
    [
        (0.45, 583.0, {}, SINC),
        (2.0, 583.0, {"x": 0.2, "y": 0.1}, SINC),
        (7.0, 150.0, {"x": 0.25}, SINC),
        (5.0, 40.0, {}, PISTON),
    ],
)
def test_small_motion_has_the_second_order_force(
    reynolds: float, sigma: float, place: dict[str, float], profile: Profile
) -> None:
    """Two small ε, extrapolated: the next order is ε⁴."""
    small, twice = (
        moving(reynolds, epsilon=epsilon, sigma=sigma, profile=profile, **place)
        for epsilon in (0.02, 0.04)
    )
    at_small, at_twice = forces([small, twice], tolerance=1e-5) / [0.02**2, 0.04**2]
    expected = second_order(small, points=28)
    assert (4 * at_small - at_twice) / 3 == pytest.approx(expected, rel=4e-5)


@pytest.mark.parametrize("thermal", ["none", "included"])
@pytest.mark.parametrize(
    ("epsilon", "sigma", "reynolds"),
    [(0.2, 583.0, 0.45), (0.2, 583.0, 1.81), (0.4, 2331.0, 0.45), (0.2, 146.0, 7.23)],
)
def test_the_middle_of_a_long_pad_is_the_strip(
    thermal: str, epsilon: float, sigma: float, reynolds: float
) -> None:
    """By the program that made the stored table of strips."""
    profile = Formula("sinc(109.8*x)", surface=Disc(1.0))
    numbers = {"epsilon": epsilon, "sigma": sigma}
    ends = [
        moving(reynolds, profile=profile, thermal=thermal, aspect=aspect, **numbers)
        for aspect in (4.0, 8.0)
    ]
    short, long = forces(ends, tolerance=1e-5)
    equation = "one_mode" if thermal == "none" else "one_mode_of_heat"
    expected = strip_force(equation, **numbers, reynolds=reynolds)
    assert (8 * long - 4 * short) / 4 == pytest.approx(
        expected, rel=3e-5 if thermal == "none" else 5e-5
    )


def test_forces_of_the_paper_s_pad(scene: Scene) -> None:
    """Forces by a program written apart from this solver."""
    included = scene.with_gas(inertia="included")
    wide = replace(included, h0_m=10e-6, hv_m=2e-6)
    solved = solve([included, wide], tolerance=1e-5)
    assert [each.force_n for each in solved] == pytest.approx([0.981542, 0.200885], rel=1e-5)
    assert all(each.force_error_n <= 1e-5 * each.force_n for each in solved)


@pytest.mark.parametrize("gas", [{}, {"rarefaction": "slip"}, {"polytropic_exponent": 1.4}])
def test_without_inertia_s_number_the_force_is_that_of_the_film_equation(
    gas: dict[str, object],
) -> None:
    heavy = moving(1e-7, epsilon=0.4, sigma=583.0, x=0.1, **gas)
    with_it, without = forces([heavy, still(heavy)], tolerance=1e-6)
    assert with_it == pytest.approx(without, rel=1e-6)


@pytest.mark.parametrize("gas", [{}, {"rarefaction": "slip", "knudsen": 0.05}])
def test_a_little_inertia_moves_the_force_by_the_effect_in_its_budget(
    gas: dict[str, object],
) -> None:
    """Also beside slip, which changes velocity and lag: its share of the effect is 5 % here."""
    heavy = moving(0.02, epsilon=0.4, sigma=583.0, **gas)
    with_it, without = forces([heavy, still(heavy)], tolerance=1e-7)
    (budget,) = error_budgets([still(heavy)])
    assert 100 * (with_it / without - 1) == pytest.approx(
        budget.effects["inertia"].percent, rel=8e-3
    )


def test_error_falls_fast_with_points_and_with_instants() -> None:
    """In time like a power of ε; in space like layer and profile, until the corners are left.

    There the velocity is not smooth: errors of 3e-7 fall algebraically.
    """
    scene = moving(2.0, epsilon=0.5, sigma=200.0)

    def errors(grids: list[tuple[int, int]]) -> list[float]:
        *some, best = (
            mean_overpressure(scene, points=points, instants=instants, fold=True)
            for points, instants in grids
        )
        return [abs(each / best - 1) for each in some]

    in_space = errors([(8, 24), (16, 24), (24, 24), (48, 24)])
    in_time = errors([(32, 8), (32, 12), (32, 16), (32, 24)])
    for found, fall, least in ((in_space, 10, 5e-7), (in_time, 100, 5e-9)):
        assert found[1] < found[0] / fall
        assert found[2] < found[1] / fall
        assert found[2] < least


@pytest.mark.parametrize("turned", [False, True])
def test_a_pad_turned_or_mirrored_bears_as_much(turned: bool) -> None:
    """Each direction has its own flux points, halves their own symmetry."""
    at = {"x": 0.1, "y": 0.25} if turned else {"x": -0.25, "y": 0.1}
    scenes = [
        moving(2.0, epsilon=0.4, sigma=200.0, **place) for place in ({"x": 0.25, "y": 0.1}, at)
    ]
    first, second = forces(scenes, tolerance=1e-5)
    assert second == pytest.approx(first, rel=1e-9)


@pytest.mark.parametrize(
    ("reynolds", "epsilon", "sigma", "x", "y", "tolerances"),
    [
        # Waves that steepen: without damping of their fast half there was no state.
        (6.0, 0.63, 99.0, 0.27, 0.03, (1e-3, 1e-4)),
        (9.98, 0.474, 164.0, 0.27, 0.03, (1e-3, 1e-4)),
        # Gas that goes out carries its velocity: taken as zero there, forces creep by 2e-3.
        (4.31, 0.654, 17.4, 0.21, 0.07, (1e-3, 1e-4)),
        # A thin layer, and steep waves over one: coarser grids agreed by chance.
        (0.5, 0.5, 1e5, 0.0, 0.0, (1e-4, 1e-5)),
        (2.183283, 0.764803, 2173.302, 0.159629, 0.048217, (1e-4, 5e-5)),
    ],
)
def test_hard_films_are_solved_within_their_estimate(
    reynolds: float, epsilon: float, sigma: float, x: float, y: float, tolerances: tuple[float, ...]
) -> None:
    scene = moving(reynolds, epsilon=epsilon, sigma=sigma, x=x, y=y)
    coarse, fine = (solve([scene], tolerance=each, method="periodic")[0] for each in tolerances)
    assert coarse.status == fine.status == "ok"
    assert abs(coarse.force_n - fine.force_n) < coarse.force_error_n
    assert coarse.force_error_n <= tolerances[0] * coarse.force_n


def test_whole_axes_bear_as_much_as_folded_ones() -> None:
    scene = moving(2.0, epsilon=0.3, sigma=200.0)
    halved, whole = (
        mean_overpressure(scene, points=16, instants=8, fold=fold) for fold in (True, False)
    )
    assert whole == pytest.approx(halved, rel=1e-9)


@pytest.mark.parametrize(
    "numbers",
    [
        {"sigma": 583.0, "inertia": "included"},
        {"sigma": 40.0, "inertia": "none", "x": 0.2, "y": 0.1},
        {"sigma": 583.0, "inertia": "included", "rarefaction": "slip", "knudsen": 0.03},
    ],
)
def test_a_little_heat_moves_the_force_by_the_first_order(numbers: dict[str, object]) -> None:
    """Beside slip too: its jump of temperature makes 30 % of the effect here."""
    scene = moving(0.01, thermal="included", epsilon=0.4, **numbers)
    (budget,) = error_budgets([scene.with_gas(thermal="none", inertia="none")])
    found = thermal_percent(scene, tolerance=1e-8)
    assert found == pytest.approx(budget.effects["thermal"].percent, rel=0.015)


def mean_warmth(rate: complex, jump: float) -> complex:
    """Mean over the gap of θ″ − rate θ = −1, whose ends are jump times its slope inwards."""
    line = cached_axis(24, False)
    square = (line.derivative_matrix @ line.derivative_matrix - rate * np.eye(26)).astype(complex)
    right = np.full(26, -1.0, dtype=complex)
    for end, inwards in ((0, 1), (-1, -1)):
        square[end] = np.eye(26)[end] - inwards * jump * line.derivative_matrix[end]
        right[end] = 0
    rim = (1 - line.quadrature_weights.sum()) / 2
    return complex([rim, *line.quadrature_weights, rim] @ np.linalg.solve(square, right))


@pytest.mark.parametrize("knudsen", [0.0, 0.0134, 0.05])
def test_the_jump_of_temperature_is_that_of_a_gas_that_conducts_across_the_gap(
    knudsen: float,
) -> None:
    """Warming to round-off, its lag to first order in the jump, what is missed no more than 6j²."""
    scene = film(epsilon=0.2, sigma=200.0, thermal="included", knudsen=knudsen or 1e-12)
    scene = scene.with_gas(rarefaction="slip")
    numbers = {name: float(value) for name, value in Thermal().equation_numbers(scene).items()}  # type: ignore[arg-type]
    jump = 2 * 1.4 / (2.4 * 0.71) * knudsen
    at_rest, slow = (mean_warmth(rate, jump) for rate in (0.0, 1e-4j))
    assert at_rest.real == pytest.approx((1 + numbers["jump_warms"]) / 12, rel=1e-9)
    lag = -slow.imag / (1e-4 * at_rest.real)
    missed = lag / (LAG_PER_REYNOLDS * (1 + numbers["jump_lags"])) - 1
    assert 3 * jump**2 - 1e-6 < missed < 6 * jump**2 + 1e-6


def test_grids_converge_to_the_force_with_heat() -> None:
    scene = moving(1.8, thermal="included", epsilon=0.4, sigma=583.0, inertia="included", x=0.1)
    coarse, fine, finest = (
        mean_overpressure(scene, points=points, instants=instants)
        for points, instants in ((20, 12), (28, 16), (36, 20))
    )
    assert abs(fine / finest - 1) < 2e-5
    assert abs(coarse - finest) > 5 * abs(fine - finest)


@pytest.mark.parametrize("gas", [{"prandtl": 1e-3}, {"heat_capacity_ratio": 1.0}])
def test_without_heat_s_numbers_the_force_is_the_isothermal_one(gas: dict[str, float]) -> None:
    scene = moving(1.0, thermal="included", epsilon=0.4, sigma=583.0).with_gas(**gas)
    # Friction and compression warm in proportion to Pr (γ − 1)/γ.
    assert abs(thermal_percent(scene, tolerance=1e-7)) < 1e-3


@pytest.mark.parametrize(
    ("term", "others", "most"), [("inertia", "none", 1e-2), ("thermal", "auto", 5e-3)]
)
def test_what_auto_leaves_out_moves_no_force_by_more_than_allowed(
    term: str, others: str, most: float, scene: Scene
) -> None:
    scenes = random_scenes(
        scene, count=30, seed=7, most_reynolds=2.0, inertia="auto", thermal=others
    )
    moved = moved_by_leaving_out(scenes, term=term, model_tolerance=most)
    assert 3 < len(moved) < 27
    assert 1e-3 < moved.max() < most


def test_near_contact_auto_decides_in_less_time_than_a_solve_takes() -> None:
    """A part of 20 × 10 mm, 0.16 µm off a piston of 2 µm: thin layers, and a gap that closes."""
    scene = moving(0.04, epsilon=0.93, sigma=23000.0, profile=PISTON, aspect=0.5)
    both = scene.with_gas(thermal="included")
    solve([both], tolerance=1e-3)  # compiles the kernels
    times_s = []
    for work in (
        lambda: resolve_auto_terms([scene.with_gas(inertia="auto", thermal="auto")]),
        lambda: solve([both], tolerance=1e-3),
    ):
        start = time.process_time()
        work()
        times_s.append(time.process_time() - start)
    assert times_s[0] < times_s[1]


@pytest.mark.parametrize(
    ("reynolds", "included", "grid_counts"), [(3.0, "included", {1}), (1e-3, "none", {1, 2})]
)
def test_auto_includes_terms_by_one_grid_and_excludes_them_by_two(
    monkeypatch, reynolds: float, included: str, grid_counts: set[int]
) -> None:
    solved_for = set()

    def films_on_grids(plan, scenes, rows, *, grid_count: int, **options):
        solved_for.update([grid_count] * len(rows))
        return films_on_grids_of(plan, scenes, rows, grid_count=grid_count, **options)

    monkeypatch.setattr(model_error, "films_on_grids_of", films_on_grids)
    auto = moving(reynolds, inertia="auto", thermal="auto", epsilon=0.3, sigma=30.0)
    (scene,) = resolve_auto_terms([auto])
    assert (scene.gas.inertia, scene.gas.thermal) == (included, included)
    assert solved_for == grid_counts


@pytest.mark.parametrize("speed_m_per_s", [0.0, 5.0])
def test_auto_excludes_all_terms_of_a_surface_at_rest(speed_m_per_s: float) -> None:
    """Such a scene begins many a curve over the amplitude."""
    pad = Pad(20e-3, 20e-3, shape="ellipse", speed_x_m_per_s=speed_m_per_s)
    actuator = Actuator(frequency_hz=20e3, surface_radius_m=15e-3, profile=PISTON)
    at_rest = Film(Gas(inertia="auto", thermal="auto"), actuator, pad).scene(10e-6, 0.0)
    (scene,) = resolve_auto_terms([at_rest])
    assert (scene.gas.inertia, scene.gas.thermal) == ("none", "none")


def test_auto_excludes_a_term_that_changes_the_force_by_little_less_than_the_tolerance() -> None:
    auto = moving(0.075, inertia="auto", thermal="auto", epsilon=0.53, sigma=11.0)
    (scene,) = resolve_auto_terms([auto])
    assert (scene.gas.inertia, scene.gas.thermal) == ("included", "none")
    without, both = solve([scene, scene.with_gas(thermal="included")], tolerance=1e-5)
    assert 0.9 < abs(without.force_n / both.force_n - 1) / AUTO_TERM_TOLERANCE < 1


def test_auto_keeps_a_term_whose_change_passes_through_zero_beyond_its_limit() -> None:
    """A disc of 20 mm at 20 kHz: at 36 and 47 µm outside the limit Re 10, at 46 µm within it."""
    film_of_disc = Film(
        Gas(inertia="auto", thermal="auto"),
        Actuator(frequency_hz=20e3, surface_radius_m=15e-3, profile=PISTON),
        Pad(20e-3, 20e-3, shape="ellipse"),
    )
    scenes = [film_of_disc.scene(gap_m, 5e-6) for gap_m in (36e-6, 46e-6, 47e-6)]
    decided = resolve_auto_terms(scenes)
    assert [scene.gas.thermal for scene in decided] == ["included"] * 3
    assert all("thermal effects included" in validity_text(scene) for scene in decided)
    without, both = solve([decided[1].with_gas(thermal="none"), decided[1]], tolerance=1e-5)
    assert abs(without.force_n / both.force_n - 1) < AUTO_TERM_TOLERANCE
