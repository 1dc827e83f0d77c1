"""Simulate, fit, judge, design, simulate …: the loop that ends when a model is good enough.

Points are of two kinds. *Verification points* are drawn at random from the space, simulated first
and never fitted: the errors there are a fair sample of the model's error over the space, whatever
that error is like. *Design points* are fitted: a few that fill the space, then in each round those
that are D-optimal for the parameters just found, given all before.

What is estimated, in units of the root mean square force over the space:

- the global error |y - eta|/|y|, from the verification points, with 95 % limits that hold if their
  errors are normally distributed;
- the worst error: the 95 % interval of prediction at the place where it is widest,
  t s sqrt(1 + f'(F'F)^-1 f), with s from the verification points; at least the largest error seen,
  there or at the design points of the last round, which lie at the edges of the space and are
  predicted before they are fitted. What is under the root besides one comes from the parameters
  and falls with more data, s is lack of fit and stays.

Simulations are deterministic, so s is no noise, and "95 %" is about where in the space one looks.

The loop ends in one of these ways:

- *reached*: the upper limit of the global error and the worst error are as small as wanted;
- *model*: no parameters are good enough. Of all parameters the least-squares ones leave the least
  root mean square residual on the points simulated so far, and the largest of any residuals is no
  less than their root mean square: if that exceeds the wanted worst error, this is proved. Or the
  wanted global error is below the lower limit of what the best fit to the verification points
  themselves leaves, with as many fewer degrees of freedom as it has parameters;
- *simulation*: the same, but what is left is no more than the simulations' own error;
- *budget*: one more round would take more simulations than allowed.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import isfinite, nan

import numpy as np
from scipy import stats

from squeezefilm.designs.exact_design import exchange
from squeezefilm.designs.refine_fits import Array, Fits, Indices, Pool
from squeezefilm.io.errors import InputError, naming
from squeezefilm.models.fitting import LEAST_SINGULAR_VALUE, best_told_apart, check_identifiable
from squeezefilm.models.force_model import ExpressionModel

Simulate = Callable[[Indices], tuple[Array, Array]]
"""From points of the pool to their forces and the errors of these, in newtons."""

LEVEL = 0.95
NUMERICAL = 3.0
"""A misfit below so many times the simulations' own error may come from them."""


@dataclass(frozen=True)
class Goal:
    """When to stop: the wanted errors, relative, and the most simulations in all."""

    global_error: float
    worst_error: float
    most_simulations: int
    batch: int


@dataclass(frozen=True, eq=False)
class Round:
    """One pass of the loop: the points fitted, the fit, and what is estimated of its errors.

    Errors are relative to the root mean square force over the space. global_lower and global_upper
    are the limits of global_error, lack_of_fit is s (NaN where the design does not settle the
    parameters), worst_at the point of the pool where the worst
    error is estimated, parameter_share the share of its square that comes from the parameters,
    floor the root mean square residual of the best fit to all points simulated so far.
    """

    number: int
    design: Indices
    simulations: int
    theta: Array
    global_error: float
    global_lower: float
    global_upper: float
    lack_of_fit: float
    worst_error: float
    worst_at: int
    parameter_share: float
    floor: float
    simulation_error: float


@dataclass(frozen=True, eq=False)
class Outcome:
    """How the loop ended: reached, model, simulation or budget, and in words why.

    hindsight is the best fit to all points, verification included; simulated lists them, in the
    order in which they were, with their forces and errors in newtons. scale_n is the root mean
    square force over the space.
    """

    verdict: str
    reason: str
    rounds: list[Round]
    hindsight: Array
    simulated: Indices
    force_n: Array
    force_error_n: Array
    scale_n: float


@dataclass(frozen=True)
class _Loop:
    fits: Fits
    goal: Goal
    simulate: Simulate
    separation: float

    def measure(self, points: Indices) -> None:
        self.fits.add(points, *self.simulate(points))


def refine_loop(
    model: ExpressionModel,
    pool: Pool,
    goal: Goal,
    simulate: Simulate,
    *,
    separation: float,
    bound: float,
    seed: int,
    report: Callable[[Round], object] = lambda done: None,
) -> Outcome:
    """Run the loop (see the module) until it ends.

    Args:
        simulate: called with points of the pool, each once.
        separation: least distance between two points simulated, in the pool's coordinates.
        bound, seed: of the global search with which the first fit begins.
        report: called with each round when it is done.

    Raises InputError where there are too few verification points, or simulations allowed.
    """
    fits = Fits(model, pool, bound=bound, seed=seed)
    loop = _Loop(fits, goal, simulate, separation)
    design = _first_points(loop)
    loop.measure(np.concatenate([pool.verification, design]))
    rounds: list[Round] = []
    while True:
        done, hindsight, verdict, reason = _one_round(loop, design, rounds)
        rounds.append(done)
        report(done)
        if not verdict:
            try:
                added = _added_points(loop, done.theta, design, goal.batch)
            except InputError as error:
                verdict, reason = "budget", f"no more points can be designed: {error}"
            else:
                design = np.concatenate([design, added])
                loop.measure(added)
                continue
        everything = np.concatenate([pool.verification, design])
        return Outcome(
            verdict=verdict,
            reason=reason,
            rounds=rounds,
            hindsight=hindsight,
            simulated=everything,
            force_n=fits.force_n[everything],
            force_error_n=fits.error_n[everything],
            scale_n=fits.scale(hindsight),
        )


def _first_points(loop: _Loop) -> Indices:
    """One point more than there are parameters, far from each other.

    Where these cannot tell the parameters apart, the points that do it best at some parameters.
    Refused where there is no room for them, or where no candidates tell the parameters apart.
    """
    model, pool = loop.fits.model, loop.fits.pool
    parameters, checks = len(model.parameter_names), len(pool.verification)
    first = parameters + 1 if parameters else 0
    if checks < 3:
        raise InputError("refine: errors cannot be estimated from fewer than 3 verification points")
    if checks + first > loop.goal.most_simulations:
        raise InputError(
            f"refine: the model {model.name} takes {first} simulations to begin with and "
            f"{checks} to verify, more than the {loop.goal.most_simulations} allowed"
        )
    spread = _spread_points(pool, first, loop.separation)
    if not first:
        return spread
    least, _, theta = best_told_apart(model, pool.factors.take(spread))
    if least < 0 or least > LEAST_SINGULAR_VALUE:
        return spread
    candidates = pool.factors.take(pool.candidates)
    with naming(f"refine: {len(candidates)} candidates"):
        check_identifiable(model, candidates)
    theta = best_told_apart(model, candidates)[2]
    return _added_points(loop, theta, np.empty(0, dtype=int), first)


def _one_round(
    loop: _Loop, design: Indices, rounds: Sequence[Round]
) -> tuple[Round, Array, str, str]:
    """The next round, the best fit to all points, and the verdict with its reason, if there is."""
    fits, number = loop.fits, len(rounds) + 1
    everything = np.concatenate([fits.pool.verification, design])
    start, surprise = None, np.empty(0)
    if rounds:
        start = rounds[-1].theta
        surprise = fits.residuals(start, design[-loop.goal.batch :])
    theta = fits.fitted(design, start)
    hindsight = fits.best_of(everything, [theta])
    done = _judged(fits, number, design, theta, hindsight, surprise)
    verdict, reason = _verdict(loop, done, hindsight)
    if verdict in ("model", "simulation") and len(theta):
        # The fit may sit in a local minimum: only a global search shows that nothing is better.
        hindsight = fits.best_of(everything, [hindsight, None])
        theta = fits.best_of(design, [theta, hindsight])
        done = _judged(fits, number, design, theta, hindsight, surprise)
        verdict, reason = _verdict(loop, done, hindsight)
    return done, hindsight, verdict, reason


def _spread_points(pool: Pool, count: int, separation: float) -> Indices:
    """Candidates far from each other and from the verification points, one after the other."""
    taken = pool.coordinates[pool.verification]
    places = pool.coordinates[pool.candidates]
    middle = places.mean(axis=0)
    chosen: list[int] = []
    for _ in range(count):
        nearest = np.linalg.norm(places[:, None] - taken[None], axis=-1).min(axis=1)
        far = (
            nearest
            if chosen
            else np.where(nearest >= separation, 1, 0) * np.linalg.norm(places - middle, axis=1)
        )
        best = int(np.argmax(far))
        chosen.append(int(pool.candidates[best]))
        taken = np.concatenate([taken, places[best : best + 1]])
    return np.array(chosen, dtype=int)


def _added_points(loop: _Loop, theta: Array, design: Indices, count: int) -> Indices:
    """The points that teach most about the parameters, besides those of the design."""
    pool, model = loop.fits.pool, loop.fits.model
    taken = np.concatenate([pool.verification, design])
    found = exchange(
        model.gradient(theta, pool.factors.take(pool.candidates)),
        count,
        existing=model.gradient(theta, pool.factors.take(design)) if len(design) else None,
        coordinates=pool.coordinates[pool.candidates],
        existing_coordinates=pool.coordinates[taken],
        separation=loop.separation,
        starts=3,
        seed=loop.fits.seed,
    )
    return np.asarray(pool.candidates[found.chosen])


def _judged(
    fits: Fits,
    number: int,
    design: Indices,
    theta: Array,
    hindsight: Array,
    surprise: Array,
) -> Round:
    """The round's estimates; surprise are errors at the newest points before they were fitted."""
    pool, checks, scale = fits.pool, fits.pool.verification, fits.scale(hindsight)
    misses = fits.residuals(theta, checks)
    misses = np.where(np.isfinite(misses), misses, np.inf)
    count = len(checks)
    relative = float(np.linalg.norm(misses) / np.linalg.norm(fits.force_n[checks]))
    spread = fits.variances(theta, design, checks)
    # Of a design that does not settle the parameters nothing is known but the errors seen.
    lack = float(np.sqrt(np.mean(misses**2 / (1 + spread)))) if np.isfinite(spread).all() else nan
    places = np.concatenate([pool.candidates, pool.typical])
    variance = fits.variances(theta, design, places)
    at = int(np.argmax(variance))
    open_ended = not (np.isfinite(variance[at]) and isfinite(lack))
    width = np.inf
    if not open_ended:
        width = float(stats.t.ppf((1 + LEVEL) / 2, count)) * lack * np.sqrt(1 + variance[at])
    seen = np.abs(np.concatenate([misses, surprise])).max()
    everything = np.concatenate([checks, design])
    left = fits.residuals(hindsight, everything)
    own = fits.error_n[everything]
    return Round(
        number=number,
        design=design,
        simulations=len(everything),
        theta=theta,
        global_error=relative,
        global_lower=relative * float(np.sqrt(count / stats.chi2.ppf(LEVEL, count))),
        global_upper=relative * float(np.sqrt(count / stats.chi2.ppf(1 - LEVEL, count))),
        lack_of_fit=lack / scale,
        worst_error=float(max(width, seen)) / scale,
        worst_at=int(places[at]),
        parameter_share=1.0 if open_ended else float(variance[at] / (1 + variance[at])),
        floor=float(np.sqrt(np.mean(left**2))) / scale,
        simulation_error=float(np.sqrt(np.mean(own**2))) / scale,
    )


def _verdict(loop: _Loop, last: Round, hindsight: Array) -> tuple[str, str]:
    """The loop's end and the reason for it; nothing while it should go on."""
    goal, parameters = loop.goal, len(loop.fits.model.parameter_names)
    tried = last.number > 1 or parameters == 0
    if tried and last.global_upper <= goal.global_error and last.worst_error <= goal.worst_error:
        return "reached", (
            f"global error {last.global_error:.2g}, below {last.global_upper:.2g} with 95 %; "
            f"worst error {last.worst_error:.2g}"
        )
    numerical = last.floor <= NUMERICAL * last.simulation_error
    what = "simulation" if numerical else "model"
    if last.simulations > parameters and last.floor > goal.worst_error:
        return what, (
            f"no parameters bring the largest residual on the {last.simulations} points simulated "
            f"below {last.floor:.2g} of the mean force; wanted are {goal.worst_error:.2g}"
        )
    least = _least_global(loop.fits, hindsight)
    if least > goal.global_error:
        return what, (
            f"even the best fit to the verification points leaves a global error above {least:.2g} "
            f"with 95 %; wanted are {goal.global_error:.2g}"
        )
    if parameters == 0:
        return what, "the model has no parameter that more simulations could improve"
    if last.simulations + goal.batch > goal.most_simulations:
        return "budget", (
            f"{last.simulations} of {goal.most_simulations} simulations are done; global error "
            f"{last.global_error:.2g} to {last.global_upper:.2g}, worst error "
            f"{last.worst_error:.2g}"
        )
    return "", ""


def _least_global(fits: Fits, start: Array) -> float:
    """Lower limit of the global error that the best parameters can have.

    From a fit to the verification points themselves: its residuals, with m - p degrees of freedom.
    """
    checks = fits.pool.verification
    spare = len(checks) - len(start)
    if spare < 1:
        return 0.0
    theta = fits.best_of(checks, [start])
    squares = float(np.sum(fits.residuals(theta, checks) ** 2))
    mean_square = squares / float(stats.chi2.ppf(LEVEL, spare))
    return float(np.sqrt(mean_square / np.mean(fits.force_n[checks] ** 2)))
