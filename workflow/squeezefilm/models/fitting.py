"""Least-squares fits of the empirical models, in the paper's two steps (eq. 4).

A genetic algorithm over wide bounds finds a rough solution without a starting point; the
Nelder-Mead simplex then goes from there to the local minimum.

Both steps work on u = asinh(theta) instead of theta. Parameters are of order ten and the bounds
reach a million: drawn evenly over such bounds, hardly any candidate would lie near the parameters
looked for, and searches end in false minima. asinh is linear near zero and logarithmic beyond, so
every order of magnitude gets its share of the candidates.

How well data fix a parameter: its range is where the sum of squares, minimised over all others,
stays below

    S_min (1 + F(1, n - p; level) / (n - p)),

the profile-likelihood interval of nonlinear regression (Bates and Watts, Nonlinear Regression
Analysis and Its Applications, 1988, section 6.1). There, residuals are noise, and the interval
holds the true value so many times in a hundred. Simulations have no noise: residuals are the
model's lack of fit, the same each time, and no value is true.

What the interval says here is how far a parameter can go while the model describes these points
about as well as the best fit does: a measure of what the points fix, not of a scatter. It is
conditional on the plan and the formula; another plan may give an interval that does not overlap
with it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations
from typing import Any

import numpy as np
import scipy
from numpy.typing import ArrayLike, NDArray

from squeezefilm.errors import InputError
from squeezefilm.formulas import ValueFunction
from squeezefilm.models.data import Factors
from squeezefilm.models.force_model import ExpressionModel
from squeezefilm.models.search import (
    Array,
    ObjectiveFunction,
    SearchResult,
    genetic_search,
    nelder_mead,
)
from squeezefilm.parallel import parallel_map
from squeezefilm.units import parse_compound_unit

UNDEFINED_OBJECTIVE_VALUE = 1e30
"""Objective value where a root of the model is undefined: far above any sum of squares here."""
MAX_GENETIC_SEARCHES = 32
DEPENDENT_COLUMN_TOLERANCE = 1e-10
"""Share of a column's length that others do not replace, below which it counts as none."""
FORCES_PER_CHUNK = 12_000
"""Forces evaluated at once: in 100 kB, which memory is kept for; five times as fast as 260 kB."""
IDENTIFIABILITY_DRAW_COUNT, IDENTIFIABILITY_SEED = 400, 1
ASINH_THETA_BOUNDS = (2.0, 16.0)
"""Parameters are drawn as sinh of a uniform number within these: up to 4 and up to 4 million."""
CONFIDENCE_LEVEL = 0.95
PARAMETER_RANGES_NOTE = (
    f"{CONFIDENCE_LEVEL:.0%} profile-likelihood intervals, conditional on this plan and on the "
    "formula. They measure the lack of fit of a deterministic simulation, not noise: another plan "
    "may give intervals that do not overlap these. null is open."
)
"""Said wherever intervals are written."""
MAX_RANGE_SEARCH_STEPS, OPEN_RANGE_STEP_MULTIPLE = 60, 2.0**30
"""Doublings and halvings of the step away from the estimate, and its multiple, before a range
counts as open."""
MIN_SINGULAR_VALUE = 1e-9
NULL_DIRECTION_FRACTION = 0.1
COMBINATION_OPERATORS = {"/": np.divide, "*": np.multiply, " + ": np.add, " - ": np.subtract}
MAX_COMBINATION_WIDTH_RATIO = 0.5
"""Relative change of a combination that the points determine while its parameters are unbounded."""
WIDER_BOUND_FACTOR, MUCH_WORSE_SQUARES_RATIO = 1e4, 1.01
"""Factor of the widest bound in a check of it; ratio of sums of squares that a check finds."""
RANDOM_START_COUNT, RANDOM_START_RANGE, BEST_START_COUNT = 64, 4.0, 8
"""Random parameters of a check, within this or the bound; best of them that least squares start at.
The search alone ends in a false minimum of NIST's Thurber; with four starts one of six seeds does.
"""


@dataclass(frozen=True)
class Fit:
    """A fitted model and how it was found.

    sum_of_squares is in N^2; global_error is |y - eta|/|y|, dimensionless. bound is the largest
    magnitude of a parameter in the global search, searches how many of them were made, evaluations
    counts the objective's, in both steps.
    """

    model: str
    theta: tuple[float, ...]
    sum_of_squares: float
    global_error: float
    points: int
    method: str
    bound: float
    seed: int
    searches: int = 0
    evaluations: int = 0

    @classmethod
    def of(
        cls, model: ExpressionModel, factors: Factors, force_n: Array, theta: Array, **about: Any
    ) -> Fit:
        """A fit by its parameters, shape (p,); ``about`` says how they were found, if searched."""
        squares = sum_of_squares(model, factors, force_n, theta)
        if not np.isfinite(squares):
            raise InputError(
                f"fit: the {model.name} model is undefined at every candidate tried; "
                "no parameters describe these points"
            )
        error = float(np.sqrt(squares) / np.linalg.norm(force_n))
        return cls(model.name, tuple(theta.tolist()), squares, error, len(force_n), **about)


SearchFunction = Callable[[ObjectiveFunction, Array, int], list[SearchResult]]
"""From an objective, bounds of ±u and a seed to rough minima."""


def run_genetic_searches(
    objective: ObjectiveFunction, limit: Array, seed: int
) -> list[SearchResult]:
    """Several genetic searches, stopped early."""
    # The good region's share of the box falls with every parameter: twice the searches for each.
    count = min(2 ** (len(limit) - 1), MAX_GENETIC_SEARCHES)
    seeds = np.random.SeedSequence(seed).generate_state(count)
    return [genetic_search(objective, lower=-limit, upper=limit, seed=int(seed)) for seed in seeds]


def run_differential_evolution(
    objective: ObjectiveFunction, limit: Array, seed: int
) -> list[SearchResult]:
    """One search by SciPy's differential evolution, as a check of the genetic ones.

    With five parameters and bounds of a million, about every second one ends in a false minimum.
    """
    rough = scipy.optimize.differential_evolution(
        lambda columns: objective(columns.T),
        scipy.optimize.Bounds(-limit, limit),
        rng=seed,
        vectorized=True,
        updating="deferred",
        polish=False,
        popsize=60,
        tol=0.01,
        maxiter=400,
    )
    evaluations = 60 * len(limit) * (int(rough.nit) + 1)
    return [SearchResult(x=rough.x, value=float(rough.fun), evaluations=evaluations)]


NAME_OF_SEARCH: dict[SearchFunction, str] = {
    run_genetic_searches: "genetic algorithm",
    run_differential_evolution: "differential evolution",
}


def fit_model(
    model: ExpressionModel,
    factors: Factors,
    force_n: ArrayLike,
    *,
    bound: float = 1e6,
    seed: int = 1,
) -> Fit:
    """A global search within +-bound, then Nelder-Mead (paper, section III); see
    ``fits_of_searches``."""
    return fits_of_searches([(bound, run_genetic_searches, seed)], model, factors, force_n)[0]


def fits_of_searches(
    ways: Sequence[tuple[float, SearchFunction, int]],
    model: ExpressionModel,
    factors: Factors,
    force_n: ArrayLike,
    *,
    processes: int = 1,
) -> list[Fit]:
    """A fit for each bound, search and seed; all their simplexes go side by side.

    A model that is linear in its parameters, or has none, needs no search and is fitted once.
    factors and force_n hold n experiments, force_n in newtons. Equal input and seed give an equal
    result. Raises InputError for fewer points than parameters, and for forces that are not finite
    or all zero.
    """
    force, count = np.asarray(force_n, dtype=float), len(model.parameter_names)
    if len(force) < count:
        raise InputError(
            f"fit: {len(force)} points for the {count} parameters of the {model.name} model; "
            f"give at least {count}"
        )
    if not (np.all(np.isfinite(force)) and np.any(force)):
        raise InputError("force_n: forces must be finite numbers, and not all zero")
    if model.is_linear:
        theta = local_fit_theta(model, factors, force, np.zeros(count))
        method = "linear least squares" if count else "no parameters"
        about = {"bound": ways[0][0], "seed": ways[0][2], "evaluations": 1}
        return [Fit.of(model, factors, force, theta, method=method, **about)]
    projection = _VariableProjection(model, factors, force)
    objective, size = projection.objective, int(projection.nonlinear_parameter_mask.sum())

    def run_search(way: tuple[float, SearchFunction, int]) -> list[SearchResult]:
        bound, search, seed = way
        return search(objective, np.full(size, np.arcsinh(bound)), seed)

    searches = parallel_map(run_search, ways, processes=processes)
    # A false minimum can look better while the search is rough: the best four go on for a while.
    rough = [sorted(found, key=lambda search_result: search_result.value)[:4] for found in searches]
    starts = np.array([search_result.x for found in rough for search_result in found])
    nearer = iter(nelder_mead(objective, starts, restarts=2))
    tried = [[next(nearer) for _ in found] for found in rough]
    leading = [min(found, key=lambda search_result: search_result.value) for found in tried]
    ends = nelder_mead(objective, np.array([near.x for near in leading]))
    runs = [
        Fit.of(
            model,
            factors,
            force,
            projection.theta(end.x),
            method=f"{NAME_OF_SEARCH[search]}, then Nelder-Mead",
            bound=bound,
            seed=seed,
            searches=len(found),
            evaluations=sum(search_result.evaluations for search_result in [*found, *near, end]),
        )
        for (bound, search, seed), found, near, end in zip(ways, searches, tried, ends, strict=True)
    ]
    return [_best_of_run_and_random_starts(run, projection) for run in runs]


def _best_of_run_and_random_starts(run: Fit, projection: _VariableProjection) -> Fit:
    """The run, or the least squares next to random parameters if they are much better."""
    within = np.arcsinh(min(RANDOM_START_RANGE, run.bound))
    size = RANDOM_START_COUNT, int(projection.nonlinear_parameter_mask.sum())
    drawn = np.random.default_rng(run.seed).uniform(-within, within, size)
    model, factors, force_n = projection.model, projection.factors, projection.force_n
    best, theta = run.sum_of_squares / MUCH_WORSE_SQUARES_RATIO, None
    for start_row in np.argsort(projection.objective(drawn))[:BEST_START_COUNT]:
        try:
            end = local_fit_theta(model, factors, force_n, projection.theta(drawn[start_row]))
        except (InputError, ValueError):  # the model is undefined there, or has no derivative
            continue
        squares = sum_of_squares(model, factors, force_n, end)
        if squares < best:
            best, theta = squares, end
    if theta is None:
        return run
    about = {name: getattr(run, name) for name in ("bound", "seed", "searches", "evaluations")}
    method = "random starts, then least squares"
    return Fit.of(model, factors, force_n, theta, method=method, **about)


@dataclass(frozen=True)
class _VariableProjection:
    """A model at n points with its linear parameters eliminated (variable projection).

    The parameters in which the force is linear have their best values at any others: the search
    is in the others alone, and the unit of force does not matter (G. Golub and V. Pereyra, The
    differentiation of pseudo-inverses and nonlinear least squares problems whose variables
    separate, SIAM J. Numer. Anal. 10 (1973) 413-432).
    """

    model: ExpressionModel
    factors: Factors
    force_n: Array

    @cached_property
    def nonlinear_parameter_mask(self) -> NDArray[np.bool_]:
        """Mask of the parameters that are not linear, shape (p,)."""
        linear = self.model.linear_parameter_names
        return np.array([name not in linear for name in self.model.parameter_names])

    @cached_property
    def _parameter_scales(self) -> Array:
        """Units of the parameters that are searched for, by the forces' root mean square."""
        units = np.array(self.model.parameter_units)[self.nonlinear_parameter_mask]
        known = [parse_compound_unit(str(unit)) for unit in units]
        powers = [float(unit.dimension.get("N", 0)) if unit else 0.0 for unit in known]
        size_n = np.linalg.norm(self.force_n) / np.sqrt(len(self.force_n))
        return np.asarray(size_n ** np.array(powers))

    @cached_property
    def _value_function(self) -> ValueFunction:
        return self.model.parsed_expression.partial_value_function(
            self.model.formula_values(self.factors)
        )

    def _residual_and_linear_columns(self, u: Array) -> tuple[Array, Array]:
        """Force less its part without linear parameters (m, n); columns of these (m, k, n)."""
        names, linear = self.model.parameter_names, self.model.linear_parameter_names
        searched = [name for name in names if name not in linear]
        theta = dict(
            zip(searched, (self._parameter_scales * np.sinh(u)).T[..., None, None], strict=True)
        )
        units = np.eye(len(linear) + 1)[1:, :, None]
        shape = len(u), len(linear) + 1, len(self.force_n)
        values = np.broadcast_to(
            self._value_function(theta | dict(zip(linear, units, strict=True))), shape
        )
        return self.force_n - values[:, 0], values[:, 1:] - values[:, :1]

    def objective(self, u: Array) -> Array:
        """Sum of squares (paper eq. 4) over |y|^2, of a population of u = asinh(theta).

        Takes shape (m, q), q parameters being searched for, gives shape (m,).
        """
        rows = max(
            FORCES_PER_CHUNK // (len(self.force_n) * (len(self.model.linear_parameter_names) + 1)),
            1,
        )
        starts = range(0, len(u), rows)
        with np.errstate(all="ignore"):
            return np.concatenate(
                [self._sums_of_squares(u[start : start + rows]) for start in starts]
            )

    def _sums_of_squares(self, u: Array) -> Array:
        residual, columns = self._residual_and_linear_columns(u)
        length = np.linalg.norm(columns, axis=-1)
        # Gram and Schmidt's, modified: no unit of force.
        for k in range(columns.shape[1]):
            left = np.linalg.norm(columns[:, k], axis=-1)
            replaced_by_others = left < DEPENDENT_COLUMN_TOLERANCE * length[:, k]
            left[replaced_by_others] = np.inf
            unit = columns[:, k] / left[:, None]
            residual = residual - np.sum(unit * residual, axis=-1)[:, None] * unit
            rest = columns[:, k + 1 :]
            projections = np.sum(unit[:, None] * rest, axis=-1)
            columns[:, k + 1 :] = rest - projections[..., None] * unit[:, None]
        squares = np.sum(residual**2, axis=-1) / np.sum(self.force_n**2)
        return np.fmin(squares, UNDEFINED_OBJECTIVE_VALUE)  # the number where squares are none

    def theta(self, u: Array) -> Array:
        """All parameters, shape (p,), from those that were searched for, shape (q,)."""
        theta = np.zeros(len(self.nonlinear_parameter_mask))
        theta[self.nonlinear_parameter_mask] = self._parameter_scales * np.sinh(u)
        with np.errstate(all="ignore"):
            (wanted,), (columns,) = self._residual_and_linear_columns(u[None])
        theta[~self.nonlinear_parameter_mask] = _linear_solution(columns.T, wanted)
        return theta


def best_fit_of_bounds(
    runs: Sequence[Fit], model: ExpressionModel, factors: Factors, force_n: Array
) -> tuple[Fit, list[str]]:
    """The best of a model's runs, or of wider bounds if it is much better, and what to note."""
    best = min(runs, key=lambda run: run.sum_of_squares)
    widest = max(run.bound for run in runs)
    if model.is_linear:
        return best, []
    wider = fit_model(model, factors, force_n, bound=WIDER_BOUND_FACTOR * widest, seed=best.seed)
    rounding = 1e-20 * float(np.sum(force_n**2))
    if best.sum_of_squares > MUCH_WORSE_SQUARES_RATIO * wider.sum_of_squares + rounding:
        return wider, [
            f"fit.bounds up to {widest:g} are too narrow: the sum of squares there is "
            f"{best.sum_of_squares:.4g} N², with {wider.bound:g} it is "
            f"{wider.sum_of_squares:.4g} N², and this fit is shown"
        ]
    searched = [name for name in model.parameter_names if name not in model.linear_parameter_names]
    theta = dict(zip(model.parameter_names, best.theta, strict=True))
    beyond = [name for name in searched if abs(theta[name]) >= widest]
    if not beyond:
        return best, []
    return best, [
        f"{', '.join(beyond)} at or beyond fit.bounds ({widest:g}); wider ones fit no better"
    ]


def _linear_solution(columns: Array, wanted: Array) -> Array:
    """Least-squares coefficients of columns (n, k), whatever their sizes."""
    size = np.linalg.norm(columns, axis=0)
    size = np.where(size > 0, size, 1.0)
    return np.asarray(np.linalg.lstsq(columns / size, wanted, rcond=None)[0] / size)


def local_fit_theta(
    model: ExpressionModel,
    factors: Factors,
    force_n: ArrayLike,
    start: ArrayLike,
    *,
    fixed: int | None = None,
) -> Array:
    """Parameters of the least sum of squares next to a start, shape (p,).

    A parameter may be held fixed, by its place. force_n has shape (n,). Where the model is linear
    the start does not matter. Steps to where the model is undefined are taken back.
    Raises InputError where the model is undefined at the start, or has no derivative on the way.
    """
    theta = np.array(start, dtype=float)
    free = np.arange(len(theta)) != (-1 if fixed is None else fixed)

    def all_parameters(part: Array) -> Array:
        full = theta.copy()
        full[free] = part
        return full

    def residuals(part: Array) -> Array:
        return model.evaluate(all_parameters(part), factors) - np.asarray(force_n, dtype=float)

    def residual_jacobian(part: Array) -> Array:
        return model.gradient(all_parameters(part), factors)[:, free]

    begun = residuals(theta[free])
    if np.isnan(begun).any():
        where = model.point_text(theta, factors, int(np.argmax(np.isnan(begun))))
        raise InputError(f"fit: the {model.name} model is undefined {where}")
    if not free.any():
        return theta
    if model.is_linear:  # exact in one step, whatever the parameters' sizes
        return all_parameters(
            theta[free] + _linear_solution(residual_jacobian(theta[free]), -begun)
        )
    tolerances = dict.fromkeys(("xtol", "ftol", "gtol"), 1e-15)
    with np.errstate(all="ignore"):  # steps may lead far away, and are taken back
        optimum = scipy.optimize.least_squares(
            residuals, theta[free], jac=residual_jacobian, x_scale="jac", **tolerances
        )
    return all_parameters(optimum.x)


def sum_of_squares(
    model: ExpressionModel, factors: Factors, force_n: ArrayLike, theta: ArrayLike
) -> float:
    """Sum of squared residuals in N^2; infinite where the model is undefined at a point."""
    misses = model.evaluate(theta, factors) - np.asarray(force_n, dtype=float)
    total = float(np.sum(misses**2))
    return total if np.isfinite(total) else np.inf


def check_identifiable(model: ExpressionModel, factors: Factors) -> None:
    """Check that the gradient has full rank at some theta, so that a fit can have one answer.

    The rank is taken numerically, with columns scaled to one, at many random theta at which the
    model is defined: what fails at all of them is a property of the model and the points.
    Raises InputError naming the parameters that the points cannot tell apart, or a model that is
    undefined wherever it was tried.
    """
    count, random = len(model.parameter_names), np.random.default_rng(IDENTIFIABILITY_SEED)
    best, direction = -1.0, np.zeros(count)
    for draw in range(IDENTIFIABILITY_DRAW_COUNT if count else 0):
        spread = ASINH_THETA_BOUNDS[draw % len(ASINH_THETA_BOUNDS)]
        theta = np.sinh(random.uniform(-spread, spread, count))
        try:
            gradient = model.gradient(theta, factors)
        except InputError:  # a number within the formula that exceeds the largest there is
            continue
        gradient = gradient[np.isfinite(gradient).all(axis=1)]
        with np.errstate(over="ignore", invalid="ignore"):
            length = np.linalg.norm(gradient, axis=0)
        if len(gradient) < count or not np.all(np.isfinite(length)):
            continue
        scaled = gradient / np.where(length > 0, length, 1.0)
        _, values, directions = np.linalg.svd(scaled, full_matrices=False)
        if values[-1] > MIN_SINGULAR_VALUE:
            return
        if values[-1] > best:
            best, direction = float(values[-1]), directions[-1]
    if best >= 0:
        large = np.abs(direction) > NULL_DIRECTION_FRACTION * np.abs(direction).max()
        names = np.array(model.parameter_names)[large]
        what = "has no effect on the force" if len(names) == 1 else "cannot be told apart"
        raise InputError(
            f"{model.source_location}: {', '.join(names)} {what} at these points; leave a "
            "parameter out, or vary the factors that it belongs to"
        )
    if count:
        raise InputError(
            f"{model.source_location}: the formula is undefined at {IDENTIFIABILITY_DRAW_COUNT} "
            "random parameter sets; no fit can start from there"
        )


@dataclass(frozen=True)
class ParameterRange:
    """A parameter's estimate and range, infinite where the data do not bound it.

    theta_lower and theta_upper are the whole parameter vectors at the ends of the range, those of
    the last step that was tried where it is open.
    """

    name: str
    unit: str
    estimate: float
    lower: float
    upper: float
    theta_lower: tuple[float, ...]
    theta_upper: tuple[float, ...]

    def to_dict(self) -> dict[str, Any]:
        """Estimate and range, ready for JSON; an open end is null."""
        plain = {"name": self.name, "unit": self.unit, "estimate": self.estimate}
        ends = {"lower": self.lower, "upper": self.upper}
        return plain | {name: end if np.isfinite(end) else None for name, end in ends.items()}


def _starts_with_fixed_value(theta: Array, index: int, value: float) -> list[Array]:
    """Starts (p,) with a new value of a parameter: the others kept, or one in proportion to it.

    Points may determine the quotient or the product of two parameters and neither of them.
    """
    kept = theta.copy()
    kept[index] = value
    starts, ratio = [kept], value / theta[index] if theta[index] else 0.0
    for other in range(len(theta) if ratio > 0 else 0):
        for factor in (ratio, 1 / ratio):
            if other != index:
                starts.append(kept * np.where(np.arange(len(theta)) == other, factor, 1.0))
    return starts


def open_range_notes(ranges: Sequence[ParameterRange]) -> list[str]:
    """Statements about the parameters whose ranges are open, for a fit's reader.

    A quotient, product, sum or difference of two of them that hardly changes along their ranges
    is determined by the points all the same.
    """
    names = [parameter.name for parameter in ranges]
    unbounded = [
        parameter
        for parameter in ranges
        if not np.isfinite([parameter.lower, parameter.upper]).all()
    ]
    statements, paired = [], set[str]()
    for one, other in combinations(unbounded, 2):
        ends = (
            parameter for pair in (one, other) for parameter in (pair.theta_lower, pair.theta_upper)
        )
        estimate = [parameter.estimate for parameter in ranges]
        a, b = np.array([estimate, *ends])[:, [names.index(one.name), names.index(other.name)]].T
        for operator, combine in COMBINATION_OPERATORS.items():
            with np.errstate(all="ignore"):
                values = combine(a, b)
            if np.ptp(values) < MAX_COMBINATION_WIDTH_RATIO * abs(values[0]):
                what = f"{one.name}{operator}{other.name}"
                statements.append(f"only {what} is determined by these points")
                paired |= {one.name, other.name}
                break
    alone = [parameter.name for parameter in unbounded if parameter.name not in paired]
    return statements + [f"{name} is not determined by these points" for name in alone]


def parameter_ranges(
    model: ExpressionModel, factors: Factors, force_n: ArrayLike, theta: ArrayLike
) -> list[ParameterRange]:
    """The range of each parameter of a fit to n points, n above p (see the module).

    theta is the best fit next to it (``local_fit_theta``). Raises InputError for too few points.
    """
    theta = np.asarray(theta, dtype=float)
    least = sum_of_squares(model, factors, force_n, theta)
    spare = len(factors) - len(theta)
    if spare < 1:
        raise InputError(
            f"profile: {len(factors)} points fix the {len(theta)} parameters of {model.name} "
            "exactly; a range needs more points than parameters"
        )
    allowed = least * (1 + float(scipy.special.fdtri(1, spare, CONFIDENCE_LEVEL)) / spare)
    slopes = model.gradient(theta, factors)
    size = np.linalg.norm(slopes, axis=0)
    size = np.where(size > 0, size, 1.0)
    spread = np.linalg.norm(np.linalg.pinv(slopes / size), axis=1) / size * np.sqrt(least / spare)
    # Next to the fit the points may say nothing of a parameter, or describe it without a residual.
    usable = (spread > 1e-12 * np.abs(theta)) & (spread < 1e3 * np.abs(theta))
    spread = np.where(usable | (theta == 0) & (spread > 0), spread, 0.1 * np.abs(theta) + 1e-6)

    def range_end(index: int, step: float) -> tuple[float, Array]:
        """End of the range on one side, at the allowed sum of squares, and theta there."""
        tried = {0.0: (theta, least - allowed)}

        def excess_sum_of_squares(way: float) -> float:
            if way not in tried:
                defined = [tried_way for tried_way in tried if tried[tried_way][1] < np.inf]
                near = tried[min(defined, key=lambda tried_way: abs(tried_way - way))][0]
                starts = _starts_with_fixed_value(near, index, float(theta[index] + way * step))
                at = min(starts, key=lambda at: sum_of_squares(model, factors, force_n, at))
                if np.isfinite(sum_of_squares(model, factors, force_n, at)):
                    at = local_fit_theta(model, factors, force_n, at, fixed=index)
                tried[way] = at, sum_of_squares(model, factors, force_n, at) - allowed
            return tried[way][1]

        inside, way = 0.0, 1.0
        for _ in range(MAX_RANGE_SEARCH_STEPS):
            above = excess_sum_of_squares(way)
            if above <= 0 and way > OPEN_RANGE_STEP_MULTIPLE:
                break
            if above <= 0:
                inside, way = way, 2 * way
                continue
            if above == np.inf:  # beyond the edge of the region in which the model is defined
                way = (inside + way) / 2
                if way - inside >= 1e-9:
                    continue
            elif excess_sum_of_squares(inside) < 0:  # not so of a fit whose residual is rounding
                inside = float(scipy.optimize.brentq(excess_sum_of_squares, inside, way, xtol=1e-6))
            return float(theta[index] + inside * step), tried[inside][0]
        return float(np.copysign(np.inf, step)), tried[inside][0]

    ranges = []
    for index, step in enumerate(spread.tolist()):
        (lower, theta_lower), (upper, theta_upper) = range_end(index, -step), range_end(index, step)
        name, unit = model.parameter_names[index], model.parameter_units[index]
        ends = (lower, upper, tuple(theta_lower.tolist()), tuple(theta_upper.tolist()))
        ranges.append(ParameterRange(name, unit, float(theta[index]), *ends))
    return ranges
