"""Sequential design: simulate, fit, estimate errors, add points, until a model is good enough.

Points are of two kinds. *Verification points* are drawn at random from the space, simulated first
and never fitted: the errors there are a fair sample of the model's error over the space, whatever
that error is like. *Design points* are fitted: in each round those that are D-optimal for the
parameters just found, given all before; in the first for those of the verification points. Points
that fill the space would not do there: as few as there are parameters may hardly determine these.

What is estimated, in units of the root mean square force over the space:

- the global error |y - eta|/|y|, from the verification points, with 95 % limits that hold if their
  errors are normally distributed;
- the worst error: that of 95 % of the space, with 95 % confidence, where it is largest,
  z s sqrt(1 + f'(F'F)^-1 f), with the upper limit s from the verification points; at least the
  largest error seen, there or at the design points of the last round, which lie at the edges of the
  space and are predicted before they are fitted. What is under the root besides one comes from the
  parameters and falls with more data, s is lack of fit and stays.

Simulations are deterministic, so s is no noise, and "95 %" is about where in the space one looks.

The loop ends in one of these ways:

- *estimates meet targets*: the upper limit of the global error and the estimated worst error do;
- *limited by the model*: no parameters are good enough. Of all parameters the least-squares ones
  leave the least root mean square residual on the points simulated so far, and the largest of any
  residuals is no less than their root mean square: if that exceeds the target worst error, this is
  proved. Or the target global error is below the lower limit of what the best fit to the
  verification points themselves leaves, with as many fewer degrees of freedom as it has parameters;
- *limited by the simulations*: the same, but what is left is no more than the simulations' error;
- *out of simulations*: those left are no batch, or no more points can be designed.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from math import isfinite, nan

import numpy as np
from scipy import stats
from scipy.spatial.distance import cdist

from squeezefilm.config.study import Refine
from squeezefilm.designs.optimal import Array, Indices, exact_design_by_exchange, sensitivity
from squeezefilm.errors import InputError, prefix_errors
from squeezefilm.formatting import percent_text
from squeezefilm.models.data import Factors
from squeezefilm.models.fitting import (
    CONFIDENCE_LEVEL,
    check_identifiable,
    fit_model,
    local_fit_theta,
    sum_of_squares,
)
from squeezefilm.models.force_model import ExpressionModel
from squeezefilm.units import error_text

PointSimulator = Callable[[Indices], tuple[Array, Array]]
"""From points of the pool to their forces and the errors of these, in newtons."""

MAX_RESIDUAL_ERROR_RATIO = 3.0
"""A misfit below so many times the simulations' own error may come from them."""


@dataclass(frozen=True, eq=False)
class PointPool:
    """All points the loop knows of: their factors, shape (n,), and coordinates, shape (n, c).

    candidates may be simulated and fitted, verification are simulated and not fitted,
    fair_sample_indices are a fair sample of the space of which nothing is simulated; each is a set
    of indices. Distances are taken between coordinates, scaled so that the space is about one wide.
    """

    factors: Factors
    coordinates: Array
    candidates: Indices
    verification: Indices
    fair_sample_indices: Indices


@dataclass(frozen=True, eq=False)
class RefinementRound:
    """One pass of the loop: the points fitted, the fit, and what is estimated of its errors.

    Errors are relative to the root mean square force over the space. global_lower and global_upper
    are the limits of global_error, lack_of_fit is s (NaN where the design does not settle the
    parameters), worst_error_index the point of the pool where the worst error is estimated,
    parameter_fraction the share of its square that comes from the parameters, floor the root mean
    square residual of the best fit to all points simulated so far.
    """

    number: int
    simulations: int
    design: Indices
    theta: Array
    global_error: float
    global_lower: float
    global_upper: float
    lack_of_fit: float
    worst_error: float
    worst_error_index: int
    parameter_fraction: float
    floor: float
    simulation_error: float


@dataclass(frozen=True, eq=False)
class Outcome:
    """End of the loop, in the words above, and the reason.

    theta_of_all_points is the best fit to all points, verification included; simulated_indices
    lists them in the order in which they were simulated, force_n are their forces. rms_force_n is
    the root mean square force over the space.
    """

    verdict: str
    reason: str
    rounds: list[RefinementRound]
    theta_of_all_points: Array
    simulated_indices: Indices
    force_n: Array
    rms_force_n: float


@dataclass
class SequentialDesign:
    """The loop: forces of the pool's points, NaN where none is known, and fits to some.

    settings is the section ``refine`` of a study; its separation, the least distance between two
    points simulated, is in the pool's coordinates. simulate is called with points of the pool, each
    once; bound is that of the global search with which the first fit begins.
    """

    model: ExpressionModel
    pool: PointPool
    settings: Refine
    simulate: PointSimulator
    bound: float
    force_n: Array = field(init=False)
    error_n: Array = field(init=False)

    def __post_init__(self) -> None:
        self.force_n, self.error_n = np.full((2, len(self.pool.factors)), np.nan)

    @property
    def parameters(self) -> int:
        return len(self.model.parameter_names)

    @property
    def first_design_size(self) -> int:
        """One point more than there are parameters, none without."""
        return self.parameters + 1 if self.parameters else 0

    def simulate_points(self, points: Indices) -> None:
        """Simulate points of the pool."""
        if len(points):
            self.force_n[points], self.error_n[points] = self.simulate(points)

    def fitted_theta(self, points: Indices, *starts: Array | None) -> Array:
        """The least-squares parameters of some points from several starts, None a global search."""
        factors, force = self.pool.factors.take(points), self.force_n[points]
        best, least = np.empty(0), np.inf
        for start in starts if self.parameters else ():
            if start is None or sum_of_squares(self.model, factors, force, start) == np.inf:
                seed = self.settings.seed
                global_fit = fit_model(self.model, factors, force, bound=self.bound, seed=seed)
                start = np.array(global_fit.theta)
            theta = local_fit_theta(self.model, factors, force, start)
            squares = sum_of_squares(self.model, factors, force, theta)
            if not len(best) or squares < least:
                best, least = theta, squares
        return best

    def residuals(self, theta: Array, points: Indices) -> Array:
        return self.model.evaluate(theta, self.pool.factors.take(points)) - self.force_n[points]

    def prediction_variances(self, theta: Array, design: Indices, points: Indices) -> Array:
        """f'(F'F)^-1 f at points, F being that of the design; infinite where it is singular."""
        if not len(theta):
            return np.zeros(len(points))
        f = self.model.gradient(theta, self.pool.factors.take(design))
        at = self.model.gradient(theta, self.pool.factors.take(points))
        known = np.isfinite(f).all() and np.isfinite(at).all(axis=1)
        return np.where(known, sensitivity(f, at) * len(theta) / len(design), np.inf)

    def scale(self, theta: Array) -> float:
        """Root mean square force over the space, by the model."""
        force = self.model.evaluate(theta, self.pool.factors.take(self.pool.fair_sample_indices))
        known = force[np.isfinite(force)]
        return float(np.sqrt(np.mean(known**2))) if len(known) else nan

    def check_settings(self) -> None:
        """Check before anything is simulated that the loop can begin.

        Raises InputError where too few simulations or verification points are allowed, where these
        leave no room for others, or where no candidates tell the parameters apart.
        """
        pool, checks, first = self.pool, len(self.pool.verification), self.first_design_size
        if checks + first > self.settings.simulations:
            raise InputError(
                f"refine: the model {self.model.name} takes {first} simulations to begin with and "
                f"{checks} to verify, more than the {self.settings.simulations} allowed"
            )
        if checks < self.parameters and not self.model.is_linear:
            raise InputError(
                f"refine.verification: {checks} points do not determine the {self.parameters} "
                f"parameters of {self.model.name}; give {self.parameters} or more"
            )
        with prefix_errors(f"refine: {len(pool.candidates)} candidates"):
            check_identifiable(self.model, pool.factors.take(pool.candidates))
        verification = pool.coordinates[pool.verification]
        distance = cdist(pool.coordinates[pool.candidates], verification).min(axis=1)
        if (room := np.count_nonzero(distance >= self.settings.separation)) < first:
            raise InputError(
                f"refine.separation: {room} of {len(pool.candidates)} candidates are "
                f"{self.settings.separation:g} or more from the {checks} verification points, and "
                f"{first} are needed; give a smaller separation, fewer of these or more candidates"
            )

    def preliminary_theta(self) -> Array:
        """The parameters that the first points are designed for: those of the verification points.

        Of a linear model any do: its derivatives are the same for all.
        """
        if self.model.is_linear:
            return np.zeros(self.parameters)
        return self.fitted_theta(self.pool.verification, None)

    def most_informative_indices(self, theta: Array, design: Indices, *, count: int) -> Indices:
        """The most informative points about the parameters, besides those of the design."""
        pool, model = self.pool, self.model
        if not count:
            return np.empty(0, dtype=int)
        chosen = exact_design_by_exchange(
            model.gradient(theta, pool.factors.take(pool.candidates)),
            count,
            existing=model.gradient(theta, pool.factors.take(design)),
            coordinates=pool.coordinates[pool.candidates],
            existing_coordinates=pool.coordinates[np.concatenate([pool.verification, design])],
            separation=self.settings.separation,
            starts=3,
            seed=self.settings.seed,
        )
        return np.asarray(pool.candidates[chosen])

    def estimated_round(
        self, number: int, design: Indices, theta: Array, hindsight: Array, surprise: Array
    ) -> RefinementRound:
        """The round's estimates; surprise are errors at the newest points before their fit."""
        checks, scale = self.pool.verification, self.scale(hindsight)
        misses, count = self.residuals(theta, checks), len(checks)
        misses[~np.isfinite(misses)] = np.inf
        relative = float(np.linalg.norm(misses) / np.linalg.norm(self.force_n[checks]))
        lower, upper = np.sqrt(
            count / stats.chi2.ppf([CONFIDENCE_LEVEL, 1 - CONFIDENCE_LEVEL], count)
        )
        spread = self.prediction_variances(theta, design, checks)
        # Of a design that does not settle the parameters nothing is known but the errors seen.
        settled = np.isfinite(spread).all()
        lack = float(np.sqrt(np.mean(misses**2 / (1 + spread)))) if settled else nan
        pool_points = np.concatenate([self.pool.candidates, self.pool.fair_sample_indices])
        variance = self.prediction_variances(theta, design, pool_points)
        at = int(np.argmax(variance))
        known = isfinite(variance[at]) and isfinite(lack)
        times = float(stats.norm.ppf((1 + CONFIDENCE_LEVEL) / 2) * upper)
        width = times * lack * np.sqrt(1 + variance[at]) if known else np.inf
        seen = np.abs(np.concatenate([misses, surprise])).max()
        simulated = np.concatenate([checks, design])
        left, own = self.residuals(hindsight, simulated), self.error_n[simulated]
        return RefinementRound(
            number=number,
            design=design,
            simulations=len(simulated),
            theta=theta,
            global_error=relative,
            global_lower=relative * float(lower),
            global_upper=relative * float(upper),
            lack_of_fit=lack / scale,
            worst_error=float(max(width, seen)) / scale,
            worst_error_index=int(pool_points[at]),
            parameter_fraction=float(variance[at] / (1 + variance[at])) if known else 1.0,
            floor=float(np.sqrt(np.mean(left**2))) / scale,
            simulation_error=float(np.sqrt(np.mean(own**2))) / scale,
        )

    def verdict(self, last: RefinementRound, hindsight: Array) -> tuple[str, str]:
        """The loop's end and the reason for it; nothing while it should go on."""
        settings, parameters = self.settings, self.parameters
        errors = (
            f"global error {_percent_text(last.global_error)}, at most "
            f"{error_text(100 * last.global_upper)} % (95 % limit); estimated worst error "
            f"{_percent_text(last.worst_error)}"
        )
        below = (
            last.global_upper <= settings.global_error and last.worst_error <= settings.worst_error
        )
        if below and (last.number > 1 or parameters == 0):
            return "estimates meet targets", errors
        numerical = last.floor <= MAX_RESIDUAL_ERROR_RATIO * last.simulation_error
        what = f"limited by the {'simulations' if numerical else 'model'}"
        if last.simulations > parameters and last.floor > settings.worst_error:
            return what, (
                f"no parameters bring the largest residual on the {last.simulations} points "
                f"simulated below {_percent_text(last.floor)} of the mean force; the target is "
                f"{_percent_text(settings.worst_error)}"
            )
        least = self.least_reachable_global_error(hindsight)
        if least > settings.global_error:
            return what, (
                "even the best fit to the verification points leaves a global error above "
                f"{_percent_text(least)} with 95 %; the target is "
                f"{_percent_text(settings.global_error)}"
            )
        if parameters == 0:
            return what, "the model has no parameter that more simulations could improve"
        if last.simulations + settings.batch > settings.simulations:
            return "out of simulations", (
                f"{last.simulations} of {settings.simulations} simulations are done, and another "
                f"batch has {settings.batch}; {errors}"
            )
        return "", ""

    def least_reachable_global_error(self, start: Array) -> float:
        """Lower limit of the global error that the best parameters can have.

        From a fit to the verification points themselves: its residuals, with m - p degrees of
        freedom.
        """
        checks = self.pool.verification
        spare = len(checks) - len(start)
        if spare < 1:
            return 0.0
        squares = float(np.sum(self.residuals(self.fitted_theta(checks, start), checks) ** 2))
        mean_square = squares / float(stats.chi2.ppf(CONFIDENCE_LEVEL, spare))
        return float(np.sqrt(mean_square / np.mean(self.force_n[checks] ** 2)))

    def run(self, report: Callable[[RefinementRound], object] = lambda done: None) -> Outcome:
        """Run the loop until it ends; ``report`` is called with each round when it is done.

        Raises InputError as ``check_settings`` does.
        """
        self.check_settings()
        self.simulate_points(self.pool.verification)
        start, surprise, rounds = self.preliminary_theta(), np.empty(0), list[RefinementRound]()
        design = np.empty(0, dtype=int)
        with prefix_errors("refine"):
            design = self.most_informative_indices(start, design, count=self.first_design_size)
        self.simulate_points(design)
        while True:
            simulated = np.concatenate([self.pool.verification, design])
            theta = self.fitted_theta(design, start)
            hindsight = self.fitted_theta(simulated, theta)
            done = self.estimated_round(len(rounds) + 1, design, theta, hindsight, surprise)
            verdict, reason = self.verdict(done, hindsight)
            if verdict.startswith("limited") and len(theta):
                # The fit may sit in a local minimum: only a global search shows that none is lower.
                hindsight = self.fitted_theta(simulated, hindsight, None)
                theta = self.fitted_theta(design, theta, hindsight)
                done = self.estimated_round(len(rounds) + 1, design, theta, hindsight, surprise)
                verdict, reason = self.verdict(done, hindsight)
            rounds.append(done)
            report(done)
            if not verdict:
                try:
                    added = self.most_informative_indices(theta, design, count=self.settings.batch)
                except InputError as error:
                    verdict, reason = (
                        "out of simulations",
                        f"no more points can be designed: {error}",
                    )
            if verdict:
                force_n, rms_force_n = self.force_n[simulated], self.scale(hindsight)
                return Outcome(verdict, reason, rounds, hindsight, simulated, force_n, rms_force_n)
            self.simulate_points(added)
            design = np.concatenate([design, added])
            start, surprise = theta, self.residuals(theta, added)


def _percent_text(fraction: float) -> str:
    return percent_text(100 * fraction, sign="")
