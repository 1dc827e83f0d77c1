"""The loop ends where it should, and its estimates are those of the points it has seen."""

from collections.abc import Callable
from itertools import pairwise

import numpy as np
import pytest

from squeezefilm.config.study import Refine
from squeezefilm.designs.sequential import Outcome, PointPool, SequentialDesign
from squeezefilm.errors import InputError
from squeezefilm.models.data import Factors
from squeezefilm.models.force_model import ExpressionModel, make_model

GRID = 9
CHECKS = 8
GOAL = {"global_error": 1e-3, "worst_error": 4e-3, "simulations": 20, "batch": 2}
GOAL |= {"separation": 0.1, "seed": 1}


def model(expression: str) -> ExpressionModel:
    return make_model("tried", {"expression": expression}, source="test")


QUADRATIC = "t0*(hv/h0)**2 + t1*(hv/h0)**4"


def pool(*, checks: int = CHECKS) -> PointPool:
    """Gaps of 5 to 10 µm and amplitudes of 0.2 to 2 µm: a grid, checks and a sample."""
    gap, amplitude = np.meshgrid(np.linspace(0, 1, GRID), np.linspace(0, 1, GRID))
    drawn = np.random.default_rng(5).uniform(size=(checks + 200, 2))
    unit = np.concatenate([np.column_stack([gap.ravel(), amplitude.ravel()]), drawn])
    factors = Factors.of(h0_m=5e-6 + 5e-6 * unit[:, 0], hv_m=0.2e-6 + 1.8e-6 * unit[:, 1])
    ends = np.cumsum([0, GRID**2, checks, 200])
    parts = [np.arange(start, stop) for start, stop in pairwise(ends)]
    return PointPool(factors, unit, *parts)


def run(
    tried: ExpressionModel,
    truth: Callable[[np.ndarray], np.ndarray],
    *,
    goal: dict = GOAL,
    error_n: float = 1e-9,
    points: PointPool | None = None,
) -> tuple[Outcome, list[int]]:
    points, asked = points or pool(), []

    def simulate(which: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        asked.extend(int(each) for each in which)
        force = truth(points.factors.take(which).epsilon)
        return force, np.full(len(which), error_n)

    loop = SequentialDesign(tried, points, Refine(**goal), simulate, bound=100)
    return loop.run(), asked


def wavy(share: float) -> Callable[[np.ndarray], np.ndarray]:
    """What the quadratic can say, and a wave that it cannot."""
    return lambda e: 5 * e**2 + 3 * e**4 + share * np.sin(20 * e)


def test_a_model_that_holds_reaches_the_wanted_error():
    found, asked = run(model(QUADRATIC), wavy(0))
    assert found.verdict == "estimates meet targets"
    np.testing.assert_allclose(found.rounds[-1].theta, [5, 3], rtol=1e-6)
    assert len(asked) == len(set(asked)) == found.rounds[-1].simulations <= 20


def test_a_small_misfit_is_estimated_without_the_points_it_is_compared_on():
    points = pool()

    def truth(e: np.ndarray) -> np.ndarray:
        return np.asarray(5 * e**2 + 3 * e**4 + 1e-3 * e * np.sin(20 * e))

    found, _ = run(model(QUADRATIC), truth, points=points)
    last, everywhere = found.rounds[-1], np.arange(len(points.coordinates))
    unseen = np.setdiff1d(everywhere, found.simulated_indices)
    force = truth(points.factors.take(unseen).epsilon)
    misses = model(QUADRATIC).evaluate(last.theta, points.factors.take(unseen)) - force
    assert found.verdict == "estimates meet targets"
    assert last.global_lower < np.linalg.norm(misses) / np.linalg.norm(force) < last.global_upper
    assert 0.5 < last.worst_error * found.rms_force_n / np.abs(misses).max() < 3


@pytest.mark.parametrize("seed", range(6))
def test_the_first_points_determine_the_parameters(seed):
    """Of points that filled a space of four factors most had the smallest amplitudes."""
    wave = make_model(
        "wave",
        {
            "expression": "(t0 + t1*cos(x/w))*(hv/h0)**2 + (t2 + t3*cos(x/w))*(hv/h0)**4",
            "constants": {"w": "2 mm"},
        },
        source="test",
    )
    grid = np.stack(np.meshgrid(*[np.linspace(0, 1, 4)] * 4, indexing="ij"), axis=-1)
    drawn = np.random.default_rng(seed).uniform(size=(CHECKS + 200, 4))
    unit = np.concatenate([grid.reshape(-1, 4), drawn])
    scaled = [5e-6, 0.2e-6, 0.0, 0.0] + unit * [5e-6, 1.8e-6, 0.02, 0.01]
    factors = Factors.of(**dict(zip(("h0_m", "hv_m", "x_m", "y_m"), scaled.T, strict=True)))
    parts = np.split(np.arange(len(unit)), np.cumsum([256, CHECKS]))
    force_n = wave.evaluate(np.array([3.0, 1.0, 2.0, 0.5]), factors)
    force_n = force_n * (1 + 0.01 * np.cos(20 * factors.epsilon + 300 * factors.x_m))
    loop = SequentialDesign(
        wave,
        PointPool(factors, unit, *parts),
        Refine(**GOAL),
        lambda points: (force_n[points], np.full(len(points), 1e-9)),
        bound=100,
    )
    theta, sample = loop.run().rounds[0].theta, parts[-1]
    misses = wave.evaluate(theta, factors)[sample] - force_n[sample]
    assert np.linalg.norm(misses) < 0.02 * np.linalg.norm(force_n[sample])


@pytest.mark.parametrize(
    ("expression", "checks", "goal", "reason"),
    [
        ("sqrt(1 + t0*(hv/h0)**2)/sqrt(1 - t1*(hv/h0)**2) + t2 + t3*hv", 3, {}, "3 points do not"),
        (QUADRATIC, 40, {"separation": 0.5, "simulations": 50}, "of 81 candidates are 0.5 or more"),
        (QUADRATIC, 8, {"simulations": 10}, "3 simulations to begin with and 8 to verify"),
    ],
)
def test_what_cannot_begin_is_told_before_anything_is_simulated(expression, checks, goal, reason):
    def simulate(e: np.ndarray) -> np.ndarray:
        raise AssertionError("simulated")

    with pytest.raises(InputError, match=reason):
        run(model(expression), simulate, goal=GOAL | goal, points=pool(checks=checks))


def test_a_model_that_lacks_a_term_is_found_out():
    found, asked = run(model("t0*(hv/h0)**2"), lambda e: 5 * e**2 + 30 * e**4)
    assert found.verdict == "limited by the model"
    assert len(asked) <= 12
    assert found.rounds[-1].floor > GOAL["worst_error"]
    # It is proved: no other parameter leaves a smaller largest residual than the floor.
    factors = pool().factors.take(found.simulated_indices)
    square = factors.epsilon**2
    left = found.force_n - square * (square @ found.force_n) / (square @ square)
    floor = found.rounds[-1].floor * found.rms_force_n
    assert floor == pytest.approx(np.sqrt(np.mean(left**2)), rel=1e-6)
    largest = [np.abs(t * square - found.force_n).max() for t in np.linspace(4, 12, 400)]
    assert min(largest) >= floor


def test_rough_simulations_are_not_taken_for_a_bad_model():
    noise = np.random.default_rng(1).normal(scale=3e-3, size=2000)

    def truth(e: np.ndarray) -> np.ndarray:
        return np.asarray(5 * e**2 + noise[(e * 1e7).astype(int) % 2000])

    assert (
        run(model("t0*(hv/h0)**2"), truth, error_n=3e-3)[0].verdict == "limited by the simulations"
    )
    assert run(model("t0*(hv/h0)**2"), truth, error_n=1e-6)[0].verdict == "limited by the model"


def test_points_keep_their_distance():
    goal = GOAL | {"global_error": 1e-2, "worst_error": 1e-6, "simulations": 30, "batch": 3}
    found, _ = run(model(QUADRATIC), wavy(1e-7), goal=goal)
    assert len(found.rounds) > 3
    places = pool().coordinates[found.simulated_indices]
    gaps = np.linalg.norm(places[CHECKS:, None] - places[None], axis=-1)
    assert gaps[gaps > 0].min() >= 0.1 - 1e-9
    assert np.count_nonzero(gaps == 0) == len(places) - CHECKS


@pytest.mark.parametrize(
    ("allowed", "batch", "made", "reason"),
    [
        (16, 3, 14, "14 of 16 simulations are done, and another batch has 3"),
        (1000, 20, 45, "no more points can be designed"),
    ],
)
def test_the_loop_ends_where_its_simulations_or_its_space_does(allowed, batch, made, reason):
    goal = GOAL | {"worst_error": 1e-6, "simulations": allowed, "batch": batch}
    found, asked = run(model(QUADRATIC), wavy(1e-7), goal=goal)
    assert found.verdict == "out of simulations"
    assert reason in found.reason
    assert made - 4 <= len(asked) <= allowed
