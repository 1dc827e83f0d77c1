"""The genetic search is pymoo's, without an object for every candidate."""

import numpy as np
import pytest
from pymoo.algorithms.soo.nonconvex.ga import GA
from pymoo.core.problem import Problem
from pymoo.core.termination import NoTermination

from squeezefilm.models.search import genetic_search

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
