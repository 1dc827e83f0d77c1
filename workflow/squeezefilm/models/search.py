"""The searches that fits and designs share: a genetic algorithm, and the simplex after it."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from squeezefilm.errors import needing

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

    objective takes a population of shape (m, d), m even, and returns m values, all finite. The best
    of `first` candidates drawn evenly over the box are the first population: in a wide box the good
    region is so small that a population alone would rarely hit it.

    It is pymoo's GA (Deb's: tournaments of two, simulated binary crossover, polynomial mutation,
    and the best of parents and children survive), number by number, without an object for every
    candidate, which would take most of the time.
    """
    drawn = np.random.default_rng(seed).uniform(lower, upper, (first, len(lower)))
    # In parts that stay in the processor's cache: three times as fast as all at once.
    values = np.concatenate([objective(part) for part in np.array_split(drawn, -(-first // 500))])
    best = np.argsort(values, kind="stable")[:population]
    x, values = drawn[best], values[best]
    random = np.random.default_rng(seed)
    for _ in range(generations - 1):
        children = _children(x, values, lower, upper, random)
        x, values = np.concatenate([x, children]), np.append(values, objective(children))
        best = np.argsort(values, kind="stable")[:population]
        x, values = x[best], values[best]
    return Found(x=x[0], value=float(values[0]), evaluations=first + population * (generations - 1))


def _children(
    x: Array, values: Array, lower: Array, upper: Array, random: np.random.Generator
) -> Array:
    """As many children as there are parents, shape (m, d), by pymoo's operators as it sets them."""
    # Imported here: loading them takes longer than most commands that never search.
    with needing("fits", what="a search for parameters"):
        from pymoo.operators.crossover.sbx import cross_sbx
        from pymoo.operators.mutation.pm import mut_pm

    count, pairs = len(x), len(x) // 2
    rivals = np.concatenate([random.permutation(count) for _ in range(2)]).reshape(-1, 2)
    first, second = values[rivals].T
    winners = np.where(first < second, *rivals.T)
    for tie in np.flatnonzero(first == second):
        winners[tie] = random.choice(rivals[tie])
    parents = np.swapaxes(x[winners.reshape(pairs, 2)], 0, 1)
    crossed = random.random(pairs) < 0.9
    random.random(pairs)  # pymoo's draw for an exchange that always happens
    chances = {
        "eta": np.full((pairs, 1), 15.0),
        "prob_var": 0.5,
        "prob_bin": np.full((pairs, 1), 0.5),
    }
    offspring = cross_sbx(parents, lower, upper, **chances, random_state=random)
    children = np.where(crossed[:, None], offspring, parents).reshape(x.shape)
    each = np.full(count, min(0.5, 1 / x.shape[1]))
    mutants = mut_pm(
        children, lower, upper, np.full(count, 20.0), each, at_least_once=False, random_state=random
    )
    return np.where(random.random(count)[:, None] <= 0.9, mutants, children)


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
