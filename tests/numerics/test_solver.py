"""What ``solve`` promises: the tolerance, an honest error, independence of grouping."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd
import pytest
from films import LENGTH_M, PISTON, PRESSURE_PA, SINC, film, with_pad
from physics_facts import ASIDE_N, CENTRED_N, slow_piston

from squeezefilm.film.profiles import Sinc
from squeezefilm.reynolds import Solution, solve
from squeezefilm.reynolds.device import choose_device
from squeezefilm.reynolds.dry_run import dry_run
from squeezefilm.reynolds.grid import Grid
from squeezefilm.reynolds.periodic import launch
from squeezefilm.reynolds.periodic.launch import solve_batch
from squeezefilm.reynolds.solver import METHODS
from squeezefilm.studies.study import scenes_of_table


@pytest.fixture(scope="module")
def paper_scenes(paper):
    """Random operating points over the paper's four factors."""
    random = np.random.default_rng(20140503)
    points = [
        {
            "h0_m": random.uniform(5e-6, 10e-6),
            "hv_m": random.uniform(0.2e-6, 2e-6),
            "phi_r_m": random.uniform(0, 2.9e-3) * (index % 4 > 0),
            "phi_deg": float(random.choice([0.0, 45.0, random.uniform(0, 45)])),
        }
        for index in range(300)
    ]
    return list(scenes_of_table(pd.DataFrame(points), paper))


@pytest.fixture(scope="module")
def exact_n(paper_scenes):
    """Their forces, far beyond the tolerances that are tried."""
    return np.array([each.force_n for each in solve(paper_scenes, tolerance=1e-9)])


@pytest.mark.parametrize(
    ("hv_m", "phi_r_m", "force_n"), [(2.2e-6, 0.0, CENTRED_N), (2e-6, 2.9e-3, ASIDE_N)]
)
def test_known_forces_of_the_paper_s_actuator(hv_m, phi_r_m, force_n, scene):
    (solution,) = solve([replace(scene, hv_m=hv_m, x_m=phi_r_m)], tolerance=1e-6)
    assert solution.force_n == pytest.approx(force_n, rel=1e-6)


@pytest.mark.parametrize("tolerance", [1e-2, 1e-6])
def test_errors_are_honest_on_random_scenes(paper_scenes, exact_n, tolerance):
    """True error ≤ estimate in 99 %, and the estimate is within the tolerance or useful."""
    solutions = solve(paper_scenes, tolerance=tolerance, method="periodic")
    assert {solution.status for solution in solutions} == {"ok"}
    force = np.array([solution.force_n for solution in solutions])
    estimate = np.array([solution.force_error_n for solution in solutions])
    error = np.abs(force - exact_n)
    assert np.mean(error <= estimate) >= 0.99
    assert np.all(estimate <= np.maximum(100 * error, tolerance * force * (1 + 1e-9)))
    assert np.all(error <= tolerance * force)


@pytest.mark.parametrize("tolerance", [1e-1, 1e-2, 1e-3, 1e-4])
def test_the_cheapest_method_that_is_taken_holds_the_tolerance(paper_scenes, exact_n, tolerance):
    solutions = solve(paper_scenes, tolerance=tolerance)
    force = np.array([solution.force_n for solution in solutions])
    estimate = np.array([solution.force_error_n for solution in solutions])
    assert {solution.status for solution in solutions} == {"ok"}
    assert np.all(np.abs(force - exact_n) <= tolerance * force)
    assert np.mean(np.abs(force - exact_n) <= estimate) >= 0.99


@pytest.mark.parametrize(
    ("tolerance", "sigma", "most", "inertia"),
    [
        (1e-2, 3e4, 0.5, "none"),
        (1e-4, 3e4, 0.3, "none"),
        (1e-6, 1e5, 0.1, "none"),
        (1e-3, 2e4, 0.3, "included"),
    ],
)
def test_the_composite_that_auto_takes_holds_the_tolerance(tolerance, sigma, most, inertia):
    random = np.random.default_rng(7)
    scenes = [
        film(epsilon=random.uniform(0.05, most), sigma=sigma, x=x, y=y, inertia=inertia)
        for x, y in random.uniform(0, 0.29, (4, 2))
    ]
    found = solve(scenes, tolerance=tolerance)
    exact = solve(scenes, tolerance=0.1 * tolerance, method="periodic")
    assert "composite" in {each.method for each in found}
    for each, its in zip(found, exact, strict=True):
        assert each.status == its.status == "ok"
        assert abs(each.force_n - its.force_n) <= each.force_error_n + its.force_error_n
        assert each.force_error_n <= tolerance * abs(each.force_n)


@dataclass(frozen=True)
class Spot:
    """A spot 20 mm off the disc's centre, which is exactly nothing under a pad at the centre."""

    is_complex = False

    def amplitude(self, *, x_m: np.ndarray, y_m: np.ndarray) -> np.ndarray:
        return np.exp(-((x_m - 0.02) ** 2 + y_m**2) / 5e-4**2)


@dataclass(frozen=True)
class Broken:
    """A profile that ends in an error which nobody foresees, or in no number."""

    fails: bool
    is_complex = False

    def amplitude(self, *, x_m: np.ndarray, y_m: np.ndarray) -> np.ndarray:
        if self.fails:
            raise np.linalg.LinAlgError("singular\nmatrix")
        return np.full(np.broadcast(x_m, y_m).shape, np.nan)


def alike(some: Sequence[Solution], others: Sequence[Solution]) -> bool:
    """The same but for rounding, which in the limits depends on how many are solved together."""
    forces = [[each.force_n for each in solutions] for solutions in (some, others)]
    ways = [[(each.method, each.status) for each in solutions] for solutions in (some, others)]
    return ways[0] == ways[1] and np.allclose(*forces, rtol=1e-12, atol=0, equal_nan=True)


@pytest.mark.parametrize("method", METHODS)
def test_a_film_at_rest_bears_nothing_and_does_not_touch_the_others(method):
    good = [film(epsilon=0.2, sigma=583.0, profile=PISTON, x=x) for x in (0.0, 0.2)]
    scenes = [good[0], film(epsilon=0.2, sigma=583.0, profile=Spot()), good[1]]
    first, still, last = solve(scenes, tolerance=1e-2, method=method)
    assert alike([first, last], solve(good, tolerance=1e-2, method=method))
    assert (still.status, still.force_n) == ("ok", 0)
    assert dry_run(scenes, tolerance=1e-2, method=method)[1]["status"] == still.status


@pytest.mark.parametrize("tolerance", [1e-2, 1e-6])
def test_an_unexpected_error_is_that_of_its_scene_alone(tolerance):
    good = [film(epsilon=0.2, sigma=583.0, x=x) for x in (0.0, 0.1, 0.2, 0.3)]
    raises, no_number = (
        film(epsilon=0.2, sigma=583.0, profile=Broken(fails)) for fails in (True, False)
    )
    scenes = [good[0], raises, good[1], good[2], no_number, good[3]]
    finished: list[int] = []
    solutions = solve(scenes, tolerance=tolerance, report=finished.append)
    assert alike([solutions[at] for at in (0, 2, 3, 5)], solve(good, tolerance=tolerance))
    assert solutions[1].status == "unexpected error: LinAlgError: singular matrix"
    assert solutions[4].status == "the profile has no finite value at some place under the pad"
    assert np.isnan([solutions[1].force_n, solutions[4].force_n]).all()
    assert sum(finished) == len(scenes)
    planned = [each["status"] for each in dry_run(scenes, tolerance=tolerance)]
    assert planned == [each.status for each in solutions]


def test_tiny_motion_of_a_thin_film_is_left_to_the_second_order():
    """Where the periodic force would drown in rounding, the expansion is exact enough."""
    (solution,) = solve([film(epsilon=1e-5, sigma=1e-3, profile=PISTON)], tolerance=1e-6)
    assert (solution.status, solution.method) == ("ok", "composite")
    expected = slow_piston(1e-5, 1e-3) * LENGTH_M**2 * PRESSURE_PA
    assert solution.force_n == pytest.approx(expected, rel=1e-5)


def test_result_does_not_depend_on_the_other_scenes(paper_scenes):
    """Nor on their surfaces and pads, which may differ."""
    scene = paper_scenes[0]
    other_wave = replace(scene, actuator=replace(scene.actuator, profile=Sinc(50.0)))
    small = with_pad(scene, length_x_m=0.008, length_y_m=0.008)
    scenes = [*paper_scenes[:12], other_wave, small]
    together = solve(scenes, tolerance=1e-6)
    backwards = solve(scenes[::-1], tolerance=1e-6)[::-1]
    alone = [solve([scene], tolerance=1e-6)[0] for scene in scenes]
    assert together == backwards == alone
    assert len({solution.force_n for solution in together}) == len(scenes)


FEW_FILMS = [
    film(profile=profile, epsilon=epsilon, sigma=sigma)
    for profile in (PISTON, SINC)
    for epsilon in (0.05, 0.4, 0.9)
    for sigma in (0.5, 20.0, 3e3)
]


FILMS_BY_TERMS = [
    FEW_FILMS,
    *(
        [
            film(profile=PISTON, epsilon=epsilon, sigma=sigma, inertia="included", thermal=thermal)
            for epsilon in (0.05, 0.2, 0.4)
            for sigma in (150.0, 400.0, 3e3)
        ]
        for thermal in ("none", "included")
    ),
]


@pytest.mark.parametrize("films", FILMS_BY_TERMS, ids=["none", "inertia", "both"])
@pytest.mark.parametrize("tolerance", [1e-1, 1e-2, 1e-3, 1e-5, 1e-7])
def test_no_more_is_left_of_an_iteration_than_it_says(tolerance, films):
    """Also where the residual behind the last step is not computed (periodic.cl)."""
    grid = Grid(nx=12, ny=12, nt=16, fold_x=True, fold_y=True)
    exact, found = (
        solve_batch(films, grid, tolerance=each, device=choose_device())
        for each in (1e-12, tolerance)
    )
    narrowest = 1 - np.array([each.epsilon for each in films])
    floor = 1e-14 * exact.result_rows["largest"]
    assert (
        np.abs(found.mean_pressure_ratio - exact.mean_pressure_ratio)
        <= found.result_rows["residual"] / narrowest + floor
    ).all()
    assert (np.abs(found.mean_pressure_ratio / exact.mean_pressure_ratio - 1) <= tolerance).all()


@pytest.mark.parametrize("films", FILMS_BY_TERMS, ids=["none", "inertia", "both"])
def test_single_precision_in_a_step_moves_no_force(monkeypatch, films):
    grid = Grid(nx=12, ny=12, nt=16, fold_x=True, fold_y=True)
    single = solve_batch(films, grid, tolerance=1e-10, device=choose_device())
    monkeypatch.setattr(launch, "uses_single_precision", lambda terms: False)
    double = solve_batch(films, grid, tolerance=1e-10, device=choose_device())
    assert single.mean_pressure_ratio == pytest.approx(double.mean_pressure_ratio, rel=2e-10)
    assert (single.mean_pressure_ratio != double.mean_pressure_ratio).any()  # it was another kernel
