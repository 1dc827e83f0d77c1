"""Least-squares fits of the empirical models, in the paper's two steps (eq. 4).

A genetic algorithm over wide bounds finds a rough solution without a starting point; the
Nelder-Mead simplex then goes from there to the local minimum.

Both steps work on u = asinh(theta) instead of theta. Parameters are of order ten and the bounds
reach a million: drawn evenly over such bounds, hardly any candidate would lie near the parameters
looked for, and searches end in false minima. asinh is linear near zero and logarithmic beyond, so
every order of magnitude gets its share of the candidates.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import differential_evolution, minimize

from squeezefilm.errors import InputError
from squeezefilm.force_model import Factors, ForceModel

Array = NDArray[np.float64]

UNDEFINED = 1e30
"""Objective value where a root of the model is undefined: far above any sum of squares here."""


@dataclass(frozen=True)
class Fit:
    """A fitted model and how it was found.

    sum_of_squares is in N^2; global_error is |y - eta|/|y|, dimensionless. bound is the largest
    magnitude of a parameter in the global search. search_theta is where the global search stopped
    and generations how long it took; evaluations counts both steps.
    """

    model: str
    theta: tuple[float, ...]
    sum_of_squares: float
    global_error: float
    points: int
    method: str
    bound: float
    seed: int
    generations: int
    evaluations: int
    search_theta: tuple[float, ...]

    def to_dict(self) -> dict[str, Any]:
        """Plain numbers, strings and lists, ready for JSON."""
        plain = asdict(self)
        return plain | {name: list(plain[name]) for name in ("theta", "search_theta")}

    @classmethod
    def from_dict(cls, plain: dict[str, Any]) -> Fit:
        """The fit written by to_dict; raises InputError for a missing or an unknown entry."""
        names = {field.name for field in fields(cls)}
        wrong = names.symmetric_difference(plain)
        if wrong:
            raise InputError(
                f"fit: entries {', '.join(sorted(wrong))} are missing or unknown; "
                f"a fit has {', '.join(sorted(names))}"
            )
        tuples = {name: tuple(plain[name]) for name in ("theta", "search_theta")}
        return cls(**(plain | tuples))


@dataclass(frozen=True)
class Found:
    """What a genetic search came to: the best candidate, its value and the work done."""

    x: Array
    value: float
    generations: int
    evaluations: int


def fit_model(
    model: ForceModel,
    factors: Factors,
    force_n: ArrayLike,
    *,
    bound: float = 1e6,
    seed: int = 1,
) -> Fit:
    """Genetic algorithm within +-bound, stopped early, then Nelder-Mead (paper, section III).

    factors and force_n hold n experiments, force_n in newtons. Equal input and seed give an equal
    result. Raises InputError for fewer points than parameters, for lengths that differ and for
    forces that are not finite or all zero.
    """
    force = _checked_force(model, factors, force_n, bound)
    objective = _objective(model, factors, force)
    limit = np.full(len(model.parameter_names), np.arcsinh(bound))
    rough = genetic_search(
        objective, lower=-limit, upper=limit, seed=seed, population=100, generations=40, fall=0.05
    )
    u, evaluations = nelder_mead(lambda x: float(objective(x[None])[0]), rough.x)
    return _fit(
        model,
        factors,
        force,
        theta=np.sinh(u),
        method="genetic algorithm, then Nelder-Mead",
        bound=bound,
        seed=seed,
        generations=rough.generations,
        evaluations=rough.evaluations + evaluations,
        search_theta=np.sinh(rough.x),
    )


def fit_by_differential_evolution(
    model: ForceModel,
    factors: Factors,
    force_n: ArrayLike,
    *,
    bound: float = 1e6,
    seed: int = 1,
) -> Fit:
    """The same least squares by SciPy's differential evolution, as a check of fit_model.

    Another global search, polished by the same simplex. Raises InputError as fit_model does.
    """
    force = _checked_force(model, factors, force_n, bound)
    objective = _objective(model, factors, force)
    limit = float(np.arcsinh(bound))
    rough = differential_evolution(
        lambda x: objective(x.T),
        [(-limit, limit)] * len(model.parameter_names),
        rng=seed,
        vectorized=True,
        updating="deferred",
        polish=False,
        popsize=20,
        tol=1e-3,
        maxiter=400,
    )
    u, evaluations = nelder_mead(lambda x: float(objective(x[None])[0]), rough.x)
    return _fit(
        model,
        factors,
        force,
        theta=np.sinh(u),
        method="differential evolution, then Nelder-Mead",
        bound=bound,
        seed=seed,
        generations=int(rough.nit),
        evaluations=int(rough.nfev) + evaluations,
        search_theta=np.sinh(rough.x),
    )


def genetic_search(
    objective: Callable[[Array], Array],
    *,
    lower: Array,
    upper: Array,
    seed: int,
    population: int,
    generations: int,
    fall: float = 0.0,
    patience: int = 5,
) -> Found:
    """Minimum of objective over a box by a genetic algorithm.

    objective takes a population of shape (m, d) and returns m values, all finite. The search ends
    after the given number of generations, or as soon as the best value fell by less than the
    share fall within the last `patience` generations.
    """
    # Imported here: loading it takes longer than most commands that never search.
    from pymoo.algorithms.soo.nonconvex.ga import GA
    from pymoo.core.problem import Problem
    from pymoo.core.termination import NoTermination

    class Search(Problem):
        def _evaluate(self, x: Array, out: dict[str, Array], *args: Any, **kwargs: Any) -> None:
            out["F"] = objective(x)[:, None]

    algorithm = GA(pop_size=population, eliminate_duplicates=False)
    algorithm.setup(
        Search(n_var=len(lower), n_obj=1, xl=lower, xu=upper),
        termination=NoTermination(),
        seed=seed,
        verbose=False,
    )
    best: list[float] = []
    while len(best) < generations:
        algorithm.next()
        best.append(float(algorithm.opt[0].F[0]))
        if len(best) > patience and best[-1] > (1 - fall) * best[-1 - patience]:
            break
    return Found(
        x=np.asarray(algorithm.opt[0].X, dtype=float),
        value=best[-1],
        generations=len(best),
        evaluations=int(algorithm.evaluator.n_eval),
    )


def nelder_mead(
    objective: Callable[[Array], float], start: Array, *, restarts: int = 50
) -> tuple[Array, int]:
    """Local minimum by the Nelder-Mead simplex; returns it and the number of evaluations.

    A simplex can collapse before it arrives, so it is started anew at its own optimum until the
    objective no longer falls.
    """
    x, value, evaluations = start, objective(start), 1
    for _ in range(restarts):
        step = minimize(
            objective,
            x,
            method="Nelder-Mead",
            options={"xatol": 1e-9, "fatol": 0.0, "maxiter": 400 * len(x), "adaptive": True},
        )
        evaluations += int(step.nfev)
        fell = value - step.fun
        x, value = (step.x, step.fun) if fell > 0 else (x, value)
        if fell <= 1e-12 * value:
            break
    return x, evaluations


def _checked_force(
    model: ForceModel, factors: Factors, force_n: ArrayLike, bound: float
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


def _objective(
    model: ForceModel, factors: Factors, force_n: Array
) -> Callable[[Array], Array]:
    """Sum of squares (paper eq. 4) of a population of u = asinh(theta), shape (m, p) -> (m,)."""

    def sum_of_squares(u: Array) -> Array:
        residual = model.evaluate(np.sinh(u), factors) - force_n
        squares = np.sum(residual**2, axis=-1)
        return np.where(np.isfinite(squares), np.minimum(squares, UNDEFINED), UNDEFINED)

    return sum_of_squares


def _fit(
    model: ForceModel, factors: Factors, force_n: Array, *, theta: Array, **how: Any
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
