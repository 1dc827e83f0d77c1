"""The searches are pymoo's and SciPy's, without an object or a call for every candidate."""

import numpy as np
import pytest
from pymoo.algorithms.soo.nonconvex.ga import GA
from pymoo.core.problem import Problem
from pymoo.core.termination import NoTermination
from scipy.optimize import minimize, rosen

from squeezefilm.models.search import genetic_search, nelder_mead

LOWER, UPPER = np.array([-5.0, -5.0, 0.0]), np.array([5.0, 4.0, 3.0])


def bumpy(x: np.ndarray) -> np.ndarray:
    return np.sum(x**2 - 3 * np.cos(4 * x), axis=1)


def stepped(x: np.ndarray) -> np.ndarray:
    """Equal values abound, and most are the worst: as where a model is undefined."""
    return np.minimum(np.floor(np.sum(x**2, axis=1)), 6.0)


@pytest.mark.parametrize("objective", [bumpy, stepped])
@pytest.mark.parametrize("seed", [1, 2**32 - 1])
def test_it_is_pymoos_genetic_algorithm(objective, seed):
    class Search(Problem):
        def _evaluate(self, x, out, *args, **kwargs) -> None:
            out["F"] = objective(x)[:, None]

    drawn = np.random.default_rng(seed).uniform(LOWER, UPPER, (900, 3))
    best = drawn[np.argsort(objective(drawn), kind="stable")[:30]]
    theirs = GA(pop_size=30, sampling=best, eliminate_duplicates=False)
    problem = Search(n_var=3, n_obj=1, xl=LOWER, xu=UPPER)
    theirs.setup(problem, termination=NoTermination(), seed=seed, verbose=False)
    for _ in range(25):
        theirs.next()
    ours = genetic_search(
        objective, lower=LOWER, upper=UPPER, seed=seed, population=30, first=900, generations=25
    )
    assert np.array_equal(ours.x, theirs.opt[0].X)
    assert ours.value == theirs.opt[0].F[0]


def receding(x: np.ndarray) -> np.ndarray:
    """The least value is at infinity, along a bent valley."""
    return 1 + 1 / (1 + x[:, 0] ** 2) + (x[:, 1] - np.log(1 + x[:, 0] ** 2)) ** 2 + x[:, 2] ** 2


@pytest.mark.parametrize("objective", [bumpy, stepped, lambda x: rosen(x.T), receding])
def test_simplexes_side_by_side_are_those_of_scipy(objective):
    """Number by number, with their restarts, whichever ends first."""
    starts = np.random.default_rng(3).uniform(LOWER, UPPER, (4, 3))
    starts[0, 1] = 0.0
    for start, found in zip(starts, nelder_mead(objective, starts), strict=True):
        x, value, evaluations = start, objective(start[None])[0], 1
        for _ in range(50):
            theirs = minimize(
                lambda x: objective(x[None])[0],
                x,
                method="Nelder-Mead",
                options={"xatol": 1e-8, "fatol": 1e-12 * value, "maxiter": 200 * len(x)},
            )
            evaluations += theirs.nfev
            fell = value - theirs.fun
            if fell > 0:
                x, value = theirs.x, theirs.fun
            if fell <= (1e-12 if theirs.success else 1e-7) * value + 1e-26:
                break
        assert np.array_equal(found.x, x)
        assert found.value == value
        assert found.evaluations == evaluations
