"""The searches that fits and designs share: a genetic algorithm, and the simplex after it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

Array = NDArray[np.float64]
Objective = Callable[[Array], Array]
"""Values (m,) of a population (m, d)."""


@dataclass(frozen=True)
class Found:
    """What a search came to: the best candidate, its value and the evaluations made."""

    x: Array
    value: float
    evaluations: int


def genetic_search(
    objective: Objective,
    *,
    lower: Array,
    upper: Array,
    seed: int,
    population: int = 40,
    first: int = 10_000,
    generations: int = 20,
) -> Found:
    """A rough minimum of objective over a box by a genetic algorithm.

    objective takes a population of shape (m, d) and returns m values, all finite. The best of
    `first` candidates drawn evenly over the box are the first population: in a wide box the good
    region is so small that a population alone would rarely hit it.
    """
    # Imported here: loading it takes longer than most commands that never search.
    from pymoo.algorithms.soo.nonconvex.ga import GA
    from pymoo.core.problem import Problem
    from pymoo.core.termination import NoTermination

    class Search(Problem):
        def _evaluate(self, x: Array, out: dict[str, Array], *args: Any, **kwargs: Any) -> None:
            out["F"] = objective(x)[:, None]

    drawn = np.random.default_rng(seed).uniform(lower, upper, (first, len(lower)))
    best = np.argsort(objective(drawn), kind="stable")[:population]
    algorithm = GA(pop_size=population, sampling=drawn[best], eliminate_duplicates=False)
    algorithm.setup(
        Search(n_var=len(lower), n_obj=1, xl=lower, xu=upper),
        termination=NoTermination(),
        seed=seed,
        verbose=False,
    )
    for _ in range(generations):
        algorithm.next()
    return Found(
        x=np.asarray(algorithm.opt[0].X, dtype=float),
        value=float(algorithm.opt[0].F[0]),
        evaluations=first + int(algorithm.evaluator.n_eval),
    )


def nelder_mead(objective: Objective, start: Array, *, restarts: int = 50) -> Found:
    """Local minimum by the Nelder-Mead simplex.

    objective is that of genetic_search. A simplex can collapse before it arrives, so it is started
    anew at its own optimum until the objective no longer falls.
    """

    def single(x: Array) -> float:
        return float(objective(x[None])[0])

    x, value, evaluations = start, single(start), 1
    for _ in range(restarts):
        step = minimize(
            single,
            x,
            method="Nelder-Mead",
            options={"xatol": 1e-8, "fatol": 1e-12 * value, "maxiter": 400 * len(x)},
        )
        evaluations += int(step.nfev)
        fell = value - step.fun
        if fell > 0:
            x, value = step.x, float(step.fun)
        if fell <= 1e-12 * value + 1e-26:
            break
    return Found(x=x, value=value, evaluations=evaluations)
