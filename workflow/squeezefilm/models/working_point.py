"""The amplitude that gives a wanted force, by a model."""

from collections.abc import Callable, Iterable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from squeezefilm.io.errors import InputError
from squeezefilm.models.fitted import FittedModel
from squeezefilm.models.force_model import Array, ExpressionModel, Factors

AMPLITUDES = 400
"""Amplitudes at which a model is looked at before the one for a wanted force is refined."""
STEP = 1e-4
"""Relative step of the amplitude in the slope of the force."""


def working_point(
    fit: FittedModel, point: Factors, *, force_n: float, error_n: float
) -> dict[str, object]:
    """Amplitude, its error and a note for one gap and position; NaN where there is none.

    error_n is the model's error in force, in newtons, to expect.
    """
    model = fit.force_model
    point = fit.represented(point)
    where = {name: float(point.column(name)[0]) for name in ("h0_m", *point.position)}
    unknown = dict.fromkeys(("hv_m", "hv_error_m", "within_percent"), np.nan)
    row: dict[str, object] = {"force_n": force_n, **unknown, **fit.scan_percent, "note": ""}
    if model.column_names:
        fit.complete(point)  # says what is missing, if anything
    try:
        hv_m = amplitude_for_force(
            model,
            fit.theta,
            force_n=force_n,
            complete=fit.complete if model.column_names else None,
            **where,
        )
    except InputError as error:
        return row | {"note": str(error).removeprefix("force_n: ")}
    near = Factors.of(**where | {"hv_m": hv_m * np.array([1 - STEP, 1.0, 1 + STEP])})
    below, _, above = model.evaluate(fit.theta, fit.complete(near))
    slope = (above - below) / (2 * STEP * hv_m) if hv_m else np.nan
    verdict = fit.judge(near.take([1]), [force_n])
    error_n = error_n + fit.scan_error * abs(force_n)
    error_m = error_n / abs(slope) if slope and verdict.trusted[0] else np.nan
    within = verdict.within_percent([force_n])[0]
    known = {"hv_m": hv_m, "hv_error_m": error_m, "within_percent": within}
    return row | known | {"note": verdict.reasons[0]}


def amplitude_for_force(
    model: ExpressionModel,
    theta: ArrayLike,
    *,
    force_n: float,
    h0_m: float,
    complete: Callable[[Factors], Factors] | None = None,
    **position: float,
) -> float:
    """Smallest amplitude hv in metres that gives the wanted force at a gap and position.

    The position as Factors.of takes it. A model of results of physics needs ``complete``, which
    adds their columns to factors.
    Raises InputError where no amplitude between rest and contact (0 <= hv < h0) gives the
    force.
    """
    if not np.isfinite(force_n):
        raise InputError(f"force_n: {force_n} is not a finite number")
    if force_n == 0:
        raise InputError("force_n: a force of 0 N wants no amplitude")
    if model.column_names and complete is None:
        raise InputError(
            f"the model {model.name} needs {', '.join(model.column_names)} at each amplitude"
        )

    def excess(epsilon: ArrayLike) -> Array:
        hv_m = np.asarray(epsilon) * h0_m
        at = Factors.of(h0_m=h0_m, hv_m=hv_m, **position)
        at = complete(at) if complete else at
        return model.evaluate(theta, at) - force_n

    for low, high in _brackets(excess):
        found = _root(excess, low, high)
        # The sign may change at a pole, too.
        if abs(excess(found)[0]) <= 1e-9 * (1 + abs(force_n)):
            return found * h0_m
    at_rest = excess(0.0)[0] + force_n
    rest = "" if np.isnan(at_rest) else f"; at rest it gives {at_rest:.3g} N"
    raise InputError(
        f"force_n: the model gives {force_n:g} N at h0_m = {h0_m:g} m for no amplitude "
        f"below contact (hv_m < h0_m){rest}"
    )


def _brackets(excess: Any) -> Iterable[tuple[float, float]]:
    """Pairs of excursion ratios in [0, 1) between which a function changes sign, from below.

    The edge of the region where the function is defined is found by bisection: a model may reach
    any force just before its pole.
    """
    grid = np.append(np.linspace(0.0, 1.0, AMPLITUDES, endpoint=False), np.nextafter(1.0, 0.0))
    values = excess(grid)
    for index in range(len(grid) - 1):
        low, high = grid[index], grid[index + 1]
        at_low, at_high = values[index], values[index + 1]
        if np.isnan(at_low) and np.isnan(at_high):
            continue
        if np.isnan(at_low) or np.isnan(at_high):
            low, high = _defined_part(excess, low, high)
            at_low, at_high = excess(low)[0], excess(high)[0]
        if at_low * at_high <= 0:
            yield low, high


def _root(excess: Any, low: float, high: float) -> float:
    """Where a function changes sign in an interval, by bisection down to round-off."""
    rises = excess(low)[0] <= 0
    while low < (middle := (low + high) / 2) < high:
        if (excess(middle)[0] <= 0) == rises:
            low = middle
        else:
            high = middle
    return min(low, high, key=lambda each: abs(excess(each)[0]))


def _defined_part(excess: Any, low: float, high: float) -> tuple[float, float]:
    """The part of an interval in which a function is defined, which it is at one end."""
    inside, outside = (high, low) if np.isnan(excess(low)[0]) else (low, high)
    start = inside
    for _ in range(100):
        middle = (inside + outside) / 2
        if np.isnan(excess(middle)[0]):
            outside = middle
        else:
            inside = middle
    return min(start, inside), max(start, inside)
