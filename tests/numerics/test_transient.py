"""Marching in time against the periodic state, linear theory, and the schemes' own theory."""

from math import pi, sqrt
from typing import Any

import numpy as np
import pytest
from films import PISTON, film, mean_overpressure
from physics_facts import DAMPING_AT_20, SPRING_AT_20

from squeezefilm.io.errors import InputError
from squeezefilm.reynolds.device import Device, choose_device
from squeezefilm.reynolds.grid import Grid
from squeezefilm.reynolds.march import transient
from squeezefilm.reynolds.march.schemes import SCHEMES, choose, steps_for_stability
from squeezefilm.reynolds.march.settling import settle, transient_force
from squeezefilm.reynolds.march.transient import March, march
from squeezefilm.reynolds.problems import Problems, problems_of

DEVICE = choose_device()


def quarter_grid(points: int) -> Grid:
    return Grid(nx=points // 2, ny=points // 2, nt=4, fold_x=True, fold_y=True)


def problems_on(
    grid: Grid, *, epsilon: tuple[float, ...], tolerance: float = 1e-9, **numbers: Any
) -> Problems:
    """Scenes that differ in ε alone."""
    scenes = [film(epsilon=each, **numbers) for each in epsilon]
    return problems_of(scenes, grid, tolerance=tolerance)


def settled_mean(problems: Problems, grid: Grid, scheme: str, steps: int) -> float:
    settled = settle(
        problems=problems,
        grid=grid,
        steps_per_period=np.full(len(problems.epsilon), steps),
        scheme=scheme,
        device=DEVICE,
    )
    assert list(settled.status) == [0] * len(problems.epsilon)
    return float(settled.mean[0])


def marched(
    points: int,
    *,
    periods: int,
    steps: int | np.ndarray,
    scheme: str = "rk4",
    start: np.ndarray | None = None,
    device: Device = DEVICE,
    **numbers: Any,
) -> March:
    """Films on a quarter of a square grid, followed from rest or from a given state."""
    grid = quarter_grid(points)
    settings = {"periods": periods, "steps_per_period": steps, "scheme": scheme, "device": device}
    return march(problems=problems_on(grid, **numbers), grid=grid, overpressure=start, **settings)


# Schemes


@pytest.mark.parametrize("name", SCHEMES)
def test_growth_of_a_decaying_mode_is_what_the_scheme_promises(name):
    """1 at the end of the explicit scheme's real interval; 0 at infinity for the implicit ones."""
    scheme = SCHEMES[name]

    def growth(z: float) -> float:
        inverse = np.linalg.inv(np.eye(scheme.stages) - z * scheme.a)
        return float(1 + z * scheme.b @ inverse @ np.ones(scheme.stages))

    if scheme.implicit:
        assert growth(-1e6) == pytest.approx(0, abs=1e-5)
    else:
        assert growth(-scheme.real_limit) == pytest.approx(1, abs=1e-4)
        assert max(growth(-scheme.real_limit * share) for share in np.linspace(0.01, 0.99, 50)) < 1


@pytest.mark.parametrize(("name", "order"), [("rk4", 4), ("tr-bdf2", 2), ("esdirk4", 4)])
def test_settled_force_converges_with_the_scheme_s_order(name, order):
    """To the periodic state on the same grid."""
    grid = quarter_grid(8)
    problems = problems_on(grid, epsilon=(0.4,), sigma=583.0, tolerance=1e-12)
    scene = film(epsilon=0.4, sigma=583.0)
    exact = mean_overpressure(scene, points=8, instants=24, fold=True, tolerance=1e-13)
    coarse, fine = (abs(settled_mean(problems, grid, name, steps) - exact) for steps in (24, 48))
    assert np.log2(coarse / fine) == pytest.approx(order, abs=0.25)


@pytest.fixture
def unguarded(monkeypatch):
    """A march takes any number of explicit steps."""
    monkeypatch.setattr(transient, "steps_for_stability", lambda **_: np.ones(1))


@pytest.mark.usefixtures("unguarded")
def test_explicit_steps_are_stable_just_where_theory_says():
    """A disturbance of a film almost at rest grows or decays; the limit found by bisection."""
    grid = quarter_grid(16)
    film: dict[str, Any] = {"epsilon": (1e-3,), "sigma": 100.0}
    disturbance = 1e-6 * np.random.default_rng(1).standard_normal((1, grid.nx, grid.ny))

    def stable(steps: int) -> bool:
        run = marched(16, periods=10, steps=steps, start=disturbance, **film)
        return bool(run.status[0] == 0 and np.abs(run.overpressure).max() < 1e-3)

    problems = problems_on(grid, **film)
    theory = int(steps_for_stability(problems=problems, grid=grid, scheme="rk4")[0])
    unstable_below, stable_from = theory // 2, 2 * theory
    assert not stable(unstable_below)
    assert stable(stable_from)
    while stable_from - unstable_below > 1:
        middle = (unstable_below + stable_from) // 2
        if stable(middle):
            stable_from = middle
        else:
            unstable_below = middle
    assert stable_from == pytest.approx(theory, rel=0.05)


@pytest.mark.usefixtures("unguarded")
def test_unstable_steps_give_no_number():
    run = marched(16, periods=3, steps=200, epsilon=(0.3,), sigma=20.0)
    assert run.status[0] == 2
    assert np.isnan(run.mean_by_period[0, -1])


# Settled films


@pytest.mark.parametrize("sigma", [20.0, 583.0])
@pytest.mark.parametrize("epsilon", [0.3, 0.44])
def test_settled_force_is_that_of_the_periodic_state(epsilon, sigma):
    exact = mean_overpressure(film(epsilon=epsilon, sigma=sigma), points=32, instants=24, fold=True)
    for tolerance, points in ((1e-3, 16), (1e-6, 24)):
        (force,) = transient_force(
            problems_on=lambda grid: problems_on(grid, epsilon=(epsilon,), sigma=sigma),
            grid=quarter_grid(points),
            tolerance=tolerance,
            device=DEVICE,
        )
        assert force.status == "ok"
        assert abs(force.mean - exact) <= force.error <= tolerance * exact


def test_settling_takes_few_periods_where_plain_marching_takes_hundreds():
    grid = quarter_grid(16)
    settled = settle(
        problems=problems_on(grid, epsilon=(0.1, 0.44, 0.9), sigma=1e5, tolerance=1e-8),
        grid=grid,
        steps_per_period=np.full(3, 64),
        scheme="rk4",
        device=DEVICE,
    )
    assert list(settled.status) == [0, 0, 0]
    assert settled.periods.max() <= 10


def test_a_sliding_finger_settles_on_the_periodic_state():
    """Off the middle, where the direction counts."""
    scene = film(epsilon=0.4, sigma=100.0, x=0.2, bearing=10.0)
    exact = mean_overpressure(scene, points=24, instants=24)
    grid = Grid(nx=24, ny=12, nt=4, fold_x=False, fold_y=True)
    problems = problems_on(grid, epsilon=(0.4,), sigma=100.0, x=0.2, bearing=10.0)
    assert settled_mean(problems, grid, "esdirk4", 48) == pytest.approx(exact, rel=1e-6)
    still = problems_on(grid, epsilon=(0.4,), sigma=100.0, x=0.2)
    assert settled_mean(still, grid, "esdirk4", 48) != pytest.approx(exact, rel=1e-3)


def test_small_films_answer_linearly_with_blech_s_coefficients():
    """Force −ε (S sin T + D cos T) of a square piston at σ = 20, and its mean 5/4 ε² S."""
    spring, damping = SPRING_AT_20, DAMPING_AT_20
    epsilon = 1e-3
    run = marched(
        24, periods=5, steps=256, scheme="esdirk4", epsilon=(epsilon,), sigma=20.0, profile=PISTON
    )
    grid = quarter_grid(24)
    at_period_s_end = grid.x.weights @ run.overpressure[0] @ grid.y.weights
    swing = (run.highest_by_period - run.lowest_by_period)[0, -1] / 2
    assert at_period_s_end / epsilon == pytest.approx(-damping, rel=2e-3)
    assert swing / epsilon == pytest.approx(sqrt(spring**2 + damping**2), rel=2e-4)
    assert run.mean_by_period[0, -1] / epsilon**2 == pytest.approx(1.25 * spring, rel=1e-5)


# Start-up


@pytest.mark.parametrize("aspect", [1.0, 2.0])
def test_films_settle_with_the_time_constant_of_the_slowest_mode(aspect):
    run = marched(
        16,
        periods=45,
        steps=160,
        epsilon=(0.02,),
        sigma=583.0,
        profile=PISTON,
        aspect=aspect,
        tolerance=1e-6,
    )
    theory = 583.0 / (pi**2 * (1 + aspect**-2))
    before, after = np.diff(run.mean_by_period[0, -3:])
    assert 2 * pi / np.log(before / after) == pytest.approx(theory, rel=2e-3)


def test_a_march_goes_on_where_it_stopped():
    def run(periods: int, start: np.ndarray | None = None) -> March:
        return marched(16, periods=periods, steps=620, start=start, epsilon=(0.3,), sigma=200.0)

    whole, first = run(3), run(1)
    rest = run(2, first.overpressure)
    together = np.hstack([first.mean_by_period, rest.mean_by_period])
    assert together == pytest.approx(whole.mean_by_period, rel=1e-12)


# Promises


@pytest.mark.parametrize("scheme", SCHEMES)
def test_a_scene_does_not_depend_on_its_batch(scheme):
    epsilon, steps = np.array([0.1, 0.3, 0.5]), np.array([150, 180, 210])

    def means(which: list[int]) -> np.ndarray:
        films = {"epsilon": tuple(epsilon[which]), "sigma": 100.0}
        return marched(8, periods=2, steps=steps[which], scheme=scheme, **films).mean_by_period

    together = means([0, 1, 2])
    for scene in range(3):
        assert (means([scene])[0] == together[scene]).all()


def test_work_groups_of_many_items_give_the_same_forces():
    """The code path of a graphics processor; implicit steps take too long to compile for a test."""
    films = {"epsilon": (0.1, 0.3), "sigma": 583.0, "periods": 2, "steps": 260}
    alone, shared = (
        marched(16, device=choose_device(work_items=items), **films).mean_by_period
        for items in (1, 4)
    )
    assert shared == pytest.approx(alone, rel=1e-10)


def test_stiff_films_take_implicit_steps_and_others_explicit_ones():
    grid = quarter_grid(24)

    def scheme(sigma: float) -> str:
        problems = problems_on(grid, epsilon=(0.3,), sigma=sigma)
        return choose(problems=problems, grid=grid, tolerance=1e-6)[0].scheme

    assert scheme(20.0) == "esdirk4"
    assert scheme(2e4) == "rk4"


def test_what_cannot_be_marched_is_refused_with_a_reason():
    grid = quarter_grid(8)
    problems = problems_on(grid, epsilon=(0.3,), sigma=20.0)
    slipping = film(epsilon=0.3, sigma=20.0, rarefaction="slip")
    rarefied = problems_of([slipping], grid, tolerance=1e-9)
    odd = quarter_grid(12)
    for wrong, on, scheme, reason in (
        (problems, grid, "euler", "scheme 'euler': unknown"),
        (rarefied, grid, "esdirk4", "does not know slip"),
        (problems_on(odd, epsilon=(0.3,), sigma=20.0), odd, "esdirk4", "multiples of 4"),
        (problems, grid, "rk4", "8 steps per period with rk4 are too few at sigma = 20"),
    ):
        settings = {"periods": 1, "steps_per_period": 8, "scheme": scheme, "device": DEVICE}
        with pytest.raises(InputError, match=reason):
            march(problems=wrong, grid=on, **settings)
