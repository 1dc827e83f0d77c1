"""The searches that fits and designs share: a genetic algorithm, and the simplex after it."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
SIMPLEX_TOLERANCE, MAX_STEPS_PER_DIMENSION = 1e-8, 200
"""Distance of a simplex's corners at its end; most of its steps per dimension, as SciPy has it."""
MIN_RESTART_DECREASE, MIN_UNFINISHED_DECREASE = 1e-12, 1e-7
"""Shares by which a simplex has to fall to be started anew: one that ended, and one whose steps ran
out, as in a valley that leads to infinity."""
SIMPLEX_STEP_FACTORS = np.array([1.0, 2.0, 0.5, -0.5])[:, None, None]
"""From the centre away from the worst corner: reflection, expansion, contractions on both sides."""
CROSSOVER_DISTRIBUTION_INDEX, MUTATION_DISTRIBUTION_INDEX, CROSSOVER_PROBABILITY = 15.0, 20.0, 0.9
"""Distribution indices η; the share of pairs that are crossed, and of candidates that mutate."""
EQUAL_PARENT_DISTANCE = 1e-14
"""Values of parents that are closer are not crossed."""
ObjectiveFunction = Callable[[Array], Array]
"""Values (m,) of a population (m, d)."""


@dataclass(frozen=True)
class SearchResult:
    """Result of a search: the best candidate, its value and the evaluations made."""

    x: Array
    value: float
    evaluations: int


def genetic_search(
    objective: ObjectiveFunction,
    *,
    lower: Array,
    upper: Array,
    seed: int,
    population: int = 40,
    first: int = 10_000,
    generations: int = 20,
) -> SearchResult:
    """A rough minimum of objective over a box by a genetic algorithm.

    objective takes a population of shape (m, d), m even, and returns m values, all finite. The best
    of `first` candidates drawn evenly over the box are the first population: in a wide box the good
    region is so small that a population alone would rarely hit it.

    It is pymoo's GA (Deb's: tournaments of two, simulated binary crossover, polynomial mutation,
    and the best of parents and children survive), number by number, without an object for every
    candidate, which would take most of the time; a test compares both.
    """
    drawn = np.random.default_rng(seed).uniform(lower, upper, (first, len(lower)))
    values = objective(drawn)
    best = np.argsort(values, kind="stable")[:population]
    x, values = drawn[best], values[best]
    random = np.random.default_rng(seed)
    for _ in range(generations - 1):
        children = _children(x, values, lower, upper, random)
        x, values = np.concatenate([x, children]), np.append(values, objective(children))
        best = np.argsort(values, kind="stable")[:population]
        x, values = x[best], values[best]
    return SearchResult(
        x=x[0], value=float(values[0]), evaluations=first + population * (generations - 1)
    )


def _children(
    x: Array, values: Array, lower: Array, upper: Array, random: np.random.Generator
) -> Array:
    """Children, as many as parents, shape (m, d)."""
    count, pairs = len(x), len(x) // 2
    rivals = np.concatenate([random.permutation(count) for _ in range(2)]).reshape(-1, 2)
    first, second = values[rivals].T
    winners = np.where(first < second, *rivals.T)
    for tie in np.flatnonzero(first == second):
        winners[tie] = random.choice(rivals[tie])
    parents = np.swapaxes(x[winners.reshape(pairs, 2)], 0, 1)
    crossed = random.random(pairs) < CROSSOVER_PROBABILITY
    random.random(pairs)  # pymoo's draw for an exchange that always happens
    offspring = crossover(parents, lower, upper, random)
    children = np.where(crossed[:, None], offspring, parents).reshape(x.shape)
    mutants = mutation(children, lower, upper, random)
    return np.where(random.random(count)[:, None] <= CROSSOVER_PROBABILITY, mutants, children)


def crossover(parents: Array, lower: Array, upper: Array, random: np.random.Generator) -> Array:
    """Simulated binary crossover within limits, of pairs of shape (2, m, d), half of all values.

    A pair's children lie about its parents, spread β times as far apart, with a density of
    ~ β^η up to 1 and β^−(η+2) above, cut at the limits (Deb and Agrawal, Complex Systems 9, 1995).
    """
    apart = np.abs(parents[0] - parents[1]) > EQUAL_PARENT_DISTANCE
    chosen = (random.random(apart.shape) < 0.5) & apart & (lower < upper)
    least, most = (np.broadcast_to(bound, apart.shape)[chosen] for bound in (lower, upper))
    near, far = np.sort(parents[:, chosen], axis=0)
    part, width = random.random(len(near)), far - near
    power = np.full(len(near), CROSSOVER_DISTRIBUTION_INDEX + 1.0)

    def spread_factor(distance: Array) -> Array:
        whole = 2.0 - (1.0 + 2.0 * distance / width) ** -power
        contracts = part <= 1.0 / whole
        return np.where(contracts, part * whole, 1.0 / (2.0 - part * whole)) ** (1.0 / power)

    low = 0.5 * ((near + far) - spread_factor(near - least) * width)
    high = 0.5 * ((near + far) + spread_factor(most - far) * width)
    exchanged = random.random(len(near)) < 0.5
    children = parents.copy()
    children[:, chosen] = np.where(exchanged, (high, low), (low, high))
    return np.clip(children, lower, upper)


def mutation(x: Array, lower: Array, upper: Array, random: np.random.Generator) -> Array:
    """Polynomial mutation within limits, one value of each candidate on average, shape (m, d).

    A value moves by δ times the limits' distance, −1 < δ < 1, with a density of ~ (1 − |δ|)^η, cut
    at the limits (Deb and Goyal, Computer Science and Informatics 26(4), 1996).
    """
    chosen = (random.random(x.shape) < min(0.5, 1 / x.shape[1])) & (lower < upper)
    least, most = (np.broadcast_to(bound, x.shape)[chosen] for bound in (lower, upper))
    value, width = x[chosen], most - least
    part = random.random(len(value))
    power = np.full(len(value), MUTATION_DISTRIBUTION_INDEX + 1.0)
    down = 2.0 * part + (1.0 - 2.0 * part) * (1.0 - (value - least) / width) ** power
    up = 2.0 * (1.0 - part) + 2.0 * (part - 0.5) * (1.0 - (most - value) / width) ** power
    step = np.where(part <= 0.5, down ** (1.0 / power) - 1.0, 1.0 - up ** (1.0 / power))
    mutants = x.copy()
    mutants[chosen] = np.clip(value + step * width, least, most)
    return mutants


def nelder_mead(
    objective: ObjectiveFunction, starts: Array, *, restarts: int = 50
) -> list[SearchResult]:
    """Local minima next to starts, shape (k, d), by Nelder-Mead simplexes side by side.

    objective is that of genetic_search. A simplex can collapse before it arrives, so it is started
    again at its own optimum until the objective no longer falls.
    """
    x, value = np.array(starts, dtype=float), objective(starts)
    evaluations = np.ones(len(x), dtype=int)
    falling = np.arange(len(x))
    for _ in range(restarts):
        if not len(falling):
            break
        before = value[falling]
        lower, lower_value, count, ended = _run_simplexes(
            objective, x[falling], MIN_RESTART_DECREASE * before
        )
        evaluations[falling] += count
        fell = before - lower_value
        x[falling] = np.where((fell > 0)[:, None], lower, x[falling])
        value[falling] = np.where(fell > 0, lower_value, value[falling])
        least = (
            np.where(ended, MIN_RESTART_DECREASE, MIN_UNFINISHED_DECREASE) * value[falling] + 1e-26
        )
        falling = falling[fell > least]
    return [
        SearchResult(*minimum)
        for minimum in zip(x, value.tolist(), evaluations.tolist(), strict=True)
    ]


def _run_simplexes(
    objective: ObjectiveFunction, starts: Array, tolerance: Array
) -> tuple[Array, Array, NDArray[np.int64], NDArray[np.bool_]]:
    """Ends of simplexes, shape (k, d), the values there, the evaluations that each needed and
    whether it ended before its steps did, shape (k,).

    Each is number by number that of scipy.optimize.minimize with its usual coefficients: it ends
    where its corners are as close as SIMPLEX_TOLERANCE and their values as the tolerance, shape
    (k,). All points that a step may need are evaluated in one call, for it is the calls that take
    long.
    """
    count, size = starts.shape
    corners = np.repeat(starts[:, None], size + 1, axis=1)
    axes = np.arange(size)
    corners[:, axes + 1, axes] = np.where(starts == 0, 0.00025, 1.05 * starts)
    values = objective(corners.reshape(-1, size)).reshape(count, size + 1)
    evaluations, simplex_rows = np.full(count, size + 1), np.arange(count)[:, None]
    for iteration in range(MAX_STEPS_PER_DIMENSION * size):
        order = np.argsort(values, axis=1)
        corners, values = corners[simplex_rows, order], values[simplex_rows, order]
        apart = np.abs(corners[:, 1:] - corners[:, :1]).max(axis=(1, 2)) > SIMPLEX_TOLERANCE
        apart |= np.abs(values[:, 1:] - values[:, :1]).max(axis=1) > tolerance
        now = np.flatnonzero(apart)
        if not len(now) or iteration == MAX_STEPS_PER_DIMENSION * size - 1:
            break
        best, second, worst = values[now][:, [0, -2, -1]].T
        centre, last = corners[now, :-1].sum(axis=1) / size, corners[now, -1]
        tried = (1 + SIMPLEX_STEP_FACTORS) * centre - SIMPLEX_STEP_FACTORS * last
        tried_value = objective(tried.reshape(-1, size)).reshape(len(SIMPLEX_STEP_FACTORS), -1)
        reflected = tried_value[0]
        # A second step unless the reflection is kept: outwards, or to either side of the centre.
        step = np.where(reflected < best, 1, np.where(reflected < worst, 2, 3))
        step[(reflected >= best) & (reflected < second)] = 0
        evaluations[now] += 1 + (step > 0)
        # An expansion has to be better than the reflection, a contraction at least as good.
        value = tried_value[step, simplex_rows[: len(now), 0]]
        step[(step == 1) & (value >= reflected)] = 0
        shrinks = np.where(step == 2, value > reflected, (step == 3) & (value >= worst))
        kept, step = np.flatnonzero(~shrinks), step[~shrinks]
        corners[now[kept], -1], values[now[kept], -1] = tried[step, kept], tried_value[step, kept]
        if len(shrunk := now[shrinks]):
            corners[shrunk, 1:] = corners[shrunk, :1] + 0.5 * (
                corners[shrunk, 1:] - corners[shrunk, :1]
            )
            values[shrunk, 1:] = objective(corners[shrunk, 1:].reshape(-1, size)).reshape(-1, size)
            evaluations[shrunk] += size
    return corners[:, 0], values[:, 0], evaluations, ~apart
