"""Least-squares fits of the empirical models, in the paper's two steps (eq. 4).

A genetic algorithm over wide bounds finds a rough solution without a starting point; the
Nelder-Mead simplex then goes from there to the local minimum.

Both steps work on u = asinh(theta) instead of theta. Parameters are of order ten and the bounds
reach a million: drawn evenly over such bounds, hardly any candidate would lie near the parameters
looked for, and searches end in false minima. asinh is linear near zero and logarithmic beyond, so
every order of magnitude gets its share of the candidates.
"""

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from functools import partial
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import Bounds, differential_evolution

from squeezefilm.io.errors import InputError
from squeezefilm.io.parallel import parallel_map
from squeezefilm.models.fitting.local_fit import local_fit
from squeezefilm.models.fitting.search import Array, Objective, genetic_search, nelder_mead
from squeezefilm.models.force_model import ExpressionModel, Factors

UNDEFINED = 1e30
"""Objective value where a root of the model is undefined: far above any sum of squares here."""
MOST_SEARCHES = 32


@dataclass(frozen=True)
class Fit:
    """A fitted model and how it was found.

    sum_of_squares is in N^2; global_error is |y - eta|/|y|, dimensionless. bound is the largest
    magnitude of a parameter in the global search, searches how many of them were made, search_theta
    where the best of them stopped; evaluations counts the objective's, in both steps.
    """

    model: str
    theta: tuple[float, ...]
    sum_of_squares: float
    global_error: float
    points: int
    method: str
    bound: float
    seed: int
    searches: int
    evaluations: int
    search_theta: tuple[float, ...]

    def to_dict(self) -> dict[str, Any]:
        """Plain numbers, strings and lists, ready for JSON."""
        plain = asdict(self)
        return plain | {name: list(plain[name]) for name in ("theta", "search_theta")}


def fit_model(
    model: ExpressionModel,
    factors: Factors,
    force_n: ArrayLike,
    *,
    bound: float = 1e6,
    seed: int = 1,
) -> Fit:
    """Genetic algorithm within +-bound, stopped early, then Nelder-Mead (paper, section III).

    Several independent genetic searches are made and the best of them refined. A model that is
    linear in its parameters, or has none, needs no search.
    factors and force_n hold n experiments, force_n in newtons. Equal input and seed give an equal
    result. Raises InputError for fewer points than parameters, for lengths that differ and for
    forces that are not finite or all zero.
    """
    force = _checked_force(model, factors, force_n, bound)
    done = partial(_fit, model, factors, force, bound=bound, seed=seed)
    if model.is_linear:
        return _linear_fit(model, factors, force, done)
    objective = _objective(model, factors, force)
    parameters = len(model.parameter_names)
    limit = np.full(parameters, np.arcsinh(bound))
    # The good region's share of the box falls with every parameter: twice the searches for each.
    count = min(2 ** (parameters - 1), MOST_SEARCHES)
    seeds = np.random.SeedSequence(seed).generate_state(count)
    searches = [
        genetic_search(objective, lower=-limit, upper=limit, seed=int(each)) for each in seeds
    ]
    # A false minimum can look better while the search is rough: the best four go on for a while.
    leading = sorted(searches, key=lambda found: found.value)[:4]
    nearer = [nelder_mead(objective, found.x, restarts=2) for found in leading]
    first = min(range(len(nearer)), key=lambda index: nearer[index].value)
    best = nelder_mead(objective, nearer[first].x)
    return done(
        theta=np.sinh(best.x),
        method="genetic algorithm, then Nelder-Mead",
        searches=len(searches),
        evaluations=sum(found.evaluations for found in [*searches, *nearer, best]),
        search_theta=np.sinh(leading[first].x),
    )


def fit_by_differential_evolution(
    model: ExpressionModel,
    factors: Factors,
    force_n: ArrayLike,
    *,
    bound: float = 100.0,
    seed: int = 1,
) -> Fit:
    """The same least squares by SciPy's differential evolution, as a check of fit_model.

    Another global search, refined by the same simplex. One search is made; with five parameters
    and bounds of a million, about every second one ends in a false minimum, hence the default
    bound. Raises InputError as fit_model does.
    """
    force = _checked_force(model, factors, force_n, bound)
    done = partial(_fit, model, factors, force, bound=bound, seed=seed)
    if model.is_linear:
        return _linear_fit(model, factors, force, done)
    objective = _objective(model, factors, force)
    limit = np.full(len(model.parameter_names), np.arcsinh(bound))
    population = 60 * len(model.parameter_names)

    def of_columns(x: Any, /) -> Any:
        return objective(x.T)

    rough = differential_evolution(
        of_columns,
        Bounds(-limit, limit),
        rng=seed,
        vectorized=True,
        updating="deferred",
        polish=False,
        popsize=60,
        tol=0.01,
        maxiter=400,
    )
    best = nelder_mead(objective, rough.x)
    return done(
        theta=np.sinh(best.x),
        method="differential evolution, then Nelder-Mead",
        searches=1,
        evaluations=population * (int(rough.nit) + 1) + best.evaluations,
        search_theta=np.sinh(rough.x),
    )


def fits_from_seeds(
    model: ExpressionModel,
    factors: Factors,
    force_n: ArrayLike,
    settings: Mapping[str, Any],
    *,
    processes: int = 1,
) -> list[Fit]:
    """Every seed with every bound, and a differential evolution with every bound as a check.

    settings is the section ``fit`` of a study. A model that is linear is fitted once.
    """
    bounds, first_seed = settings["bounds"], settings["first_seed"]
    if model.is_linear:
        return [fit_model(model, factors, force_n, bound=bounds[0], seed=first_seed)]
    count = settings["seeds"]["two_factor" if model.is_centred else "four_factor"]
    searches = [
        *((fit_model, seed) for seed in range(first_seed, first_seed + count)),
        (fit_by_differential_evolution, first_seed),
    ]

    def one(way: tuple[float, tuple[Callable[..., Fit], int]]) -> Fit:
        bound, (search, seed) = way
        return search(model, factors, force_n, bound=bound, seed=seed)

    return parallel_map(one, list(product(bounds, searches)), processes=processes)


def _linear_fit(
    model: ExpressionModel, factors: Factors, force: Array, done: Callable[..., Fit]
) -> Fit:
    theta = local_fit(model, factors, force, np.zeros(len(model.parameter_names)))
    method = "linear least squares" if len(theta) else "no parameters"
    return done(theta=theta, method=method, searches=0, evaluations=1, search_theta=theta)


def _checked_force(
    model: ExpressionModel, factors: Factors, force_n: ArrayLike, bound: float
) -> Array:
    force = np.atleast_1d(np.asarray(force_n, dtype=float))
    needed = len(model.parameter_names)
    if force.shape != (len(factors),):
        raise InputError(f"force_n: {force.size} forces for {len(factors)} points; give one each")
    if len(force) < needed:
        raise InputError(
            f"fit: {len(force)} points for the {needed} parameters of the {model.name} model; "
            f"give at least {needed}"
        )
    if not np.all(np.isfinite(force)):
        raise InputError("force_n: a force is not a finite number; leave failed points out")
    if not np.any(force):
        raise InputError("force_n: every force is zero; nothing can be fitted to that")
    if not (np.isfinite(bound) and bound > 0):
        raise InputError(f"bound: {bound} is not allowed; give a positive finite number")
    return force


def _objective(model: ExpressionModel, factors: Factors, force_n: Array) -> Objective:
    """Sum of squares (paper eq. 4) over |y|^2, of a population of u = asinh(theta).

    Takes shape (m, p), gives shape (m,).
    """
    scale = float(np.sum(force_n**2))

    def sum_of_squares(u: Array) -> Array:
        with np.errstate(over="ignore", invalid="ignore"):
            residual = model.evaluate(np.sinh(u), factors) - force_n
            squares = np.sum(residual**2, axis=-1) / scale
        return np.fmin(squares, UNDEFINED)  # which takes the number where squares are none

    return sum_of_squares


def _fit(
    model: ExpressionModel, factors: Factors, force_n: Array, *, theta: Array, **how: Any
) -> Fit:
    squares = float(np.sum((model.evaluate(theta, factors) - force_n) ** 2))
    if not np.isfinite(squares):
        raise InputError(
            f"fit: the {model.name} model is undefined at every candidate tried; "
            "no parameters describe these points"
        )
    return Fit(
        model=model.name,
        theta=tuple(float(value) for value in theta),
        sum_of_squares=squares,
        global_error=float(np.sqrt(squares) / np.linalg.norm(force_n)),
        points=len(force_n),
        **(how | {"search_theta": tuple(float(value) for value in how["search_theta"])}),
    )
