"""How well data fix each parameter of a model.

The range of a parameter is where the sum of squares, minimised over all others, stays below

    S_min (1 + F(1, n - p; level) / (n - p)),

the profile-likelihood interval of nonlinear regression (Bates and Watts, Nonlinear Regression
Analysis and Its Applications, 1988, section 6.1). There, residuals are noise, and the interval
holds the true value so many times in a hundred. Simulations have no noise: residuals are the
model's lack of fit, the same each time, and no value is true. What the interval says here is how
far a parameter can go while the model describes these points about as well as the best fit does:
a measure of what the points fix, not of a scatter. It is conditional on the plan and the formula;
another plan may give an interval that does not overlap with it.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import brentq
from scipy.special import fdtri

from squeezefilm.errors import InputError
from squeezefilm.models.data import Array, Factors
from squeezefilm.models.fitting import local_fit, sum_of_squares
from squeezefilm.models.force_model import ExpressionModel

LEVEL = 0.95
RANGES_NOTE = (
    f"{LEVEL:.0%} profile-likelihood intervals, conditional on this plan and on the formula. They "
    "measure the lack of fit of a deterministic simulation, not noise: another plan may give "
    "intervals that do not overlap these. null is open."
)
"""Said wherever intervals are written."""
MOST_STEPS = 60
"""Doublings and halvings of the step away from the estimate before a range counts as open."""


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


def parameter_ranges(
    model: ExpressionModel,
    factors: Factors,
    force_n: ArrayLike,
    theta: ArrayLike,
) -> list[ParameterRange]:
    """The range of each parameter of a fit to n points, n above p (see the module).

    theta is the best fit next to it (``local_fit``). Raises InputError for too few points.
    """
    theta = np.asarray(theta, dtype=float)
    least = sum_of_squares(model, factors, force_n, theta)
    spare = len(factors) - len(theta)
    if spare < 1:
        raise InputError(
            f"profile: {len(factors)} points fix the {len(theta)} parameters of {model.name} "
            "exactly; a range needs more points than parameters"
        )
    allowed = least * (1 + float(fdtri(1, spare, LEVEL)) / spare)
    slopes = model.gradient(theta, factors)
    size = np.linalg.norm(slopes, axis=0)
    size = np.where(size > 0, size, 1.0)
    spread = np.linalg.norm(np.linalg.pinv(slopes / size), axis=1) / size * np.sqrt(least / spare)
    # Next to the fit the points may say nothing of a parameter, or describe it without a residual.
    usable = (spread > 1e-12 * np.abs(theta)) & (spread < 1e3 * np.abs(theta))
    spread = np.where(usable | (theta == 0) & (spread > 0), spread, 0.1 * np.abs(theta) + 1e-6)

    def end(place: int, step: float) -> tuple[float, Array]:
        """Where the profile reaches the allowed sum of squares, on one side, and theta there."""
        tried = {0.0: (theta, least - allowed)}

        def excess(way: float) -> float:
            if way not in tried:
                defined = [each for each in tried if tried[each][1] < np.inf]
                at = tried[min(defined, key=lambda each: abs(each - way))][0].copy()
                at[place] = theta[place] + way * step
                if np.isfinite(sum_of_squares(model, factors, force_n, at)):
                    at = local_fit(model, factors, force_n, at, fixed=place)
                tried[way] = at, sum_of_squares(model, factors, force_n, at) - allowed
            return tried[way][1]

        inside, way = 0.0, 1.0
        for _ in range(MOST_STEPS):
            above = excess(way)
            if above <= 0:
                inside, way = way, 2 * way
                continue
            if above == np.inf:  # beyond the edge of the region in which the model is defined
                way = (inside + way) / 2
                if way - inside >= 1e-9:
                    continue
            elif excess(inside) < 0:  # not so of a fit whose residual is rounding
                inside = float(brentq(excess, inside, way, xtol=1e-6))
            return float(theta[place] + inside * step), tried[inside][0]
        return float(np.copysign(np.inf, step)), tried[inside][0]

    ranges = []
    for place, step in enumerate(spread.tolist()):
        (lower, theta_lower), (upper, theta_upper) = end(place, -step), end(place, step)
        name, unit = model.parameter_names[place], model.parameter_units[place]
        ends = (lower, upper, tuple(theta_lower.tolist()), tuple(theta_upper.tolist()))
        ranges.append(ParameterRange(name, unit, float(theta[place]), *ends))
    return ranges
