"""The amplitude, or the gap, at which a film gives a wanted force, by a model."""

from collections.abc import Callable, Iterable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from squeezefilm.io.errors import InputError
from squeezefilm.models.fitted import FittedModel
from squeezefilm.models.force_model import Array, ExpressionModel, Factors

LOOKED_AT = 400
"""Places at which a model is looked at before the one for a wanted force is refined."""
STEP = 1e-4
"""Relative step of the amplitude in the slope of the force."""


def working_point(fit: FittedModel, point: Factors, *, force_n: float) -> dict[str, object]:
    """Amplitude, its errors and a note for one gap and position; NaN where there is none."""
    model = fit.force_model
    point = fit.represented(point)
    where = {name: float(point.column(name)[0]) for name in ("h0_m", *point.position)}
    unknown = dict.fromkeys(("hv_m", "hv_error_95_m", "error_95_percent"), np.nan)
    row: dict[str, object] = {
        "force_n": force_n,
        **unknown,
        **fit.profile_uncertainty_percent,
        "validity": "",
        "note": "",
    }
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
    (error_n,), _, (note,) = fit.validation(near.take([1]), [force_n])
    known = {
        "hv_m": hv_m,
        "hv_error_95_m": error_n / abs(slope) if slope else np.nan,
        "error_95_percent": 100 * error_n / abs(force_n),
        "validity": fit.validity(near.take([1]))[0],
    }
    return row | known | {"note": note}


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
    at_share = _forces(model, theta, force_n=force_n, complete=complete)

    def excess(share: ArrayLike) -> Array:
        return at_share(h0_m=h0_m, hv_m=np.asarray(share) * h0_m, **position) - force_n

    if (found := _first(excess, force_n)) is not None:
        return found * h0_m
    at_rest = excess(0.0)[0] + force_n
    rest = "" if np.isnan(at_rest) else f"; at rest it gives {at_rest:.3g} N"
    raise InputError(
        f"force_n: the model gives {force_n:g} N at h0_m = {h0_m:g} m for no amplitude "
        f"below contact (hv_m < h0_m){rest}"
    )


def gap_for_force(
    model: ExpressionModel,
    theta: ArrayLike,
    *,
    force_n: float,
    hv_m: float,
    gaps_m: tuple[float, float],
    complete: Callable[[Factors], Factors] | None = None,
    **position: float,
) -> float:
    """Widest gap h0 in metres at which an amplitude gives the wanted force at a position.

    gaps_m: the least and the largest gap that are looked at, such as those of the fitted points;
    the rest as amplitude_for_force has it. A part that comes down from above floats there.
    Raises InputError where no such gap above contact (h0 > hv) gives the force.
    """
    at_share = _forces(model, theta, force_n=force_n, complete=complete)
    least, most = max(gaps_m[0], float(np.nextafter(hv_m, 1.0))), gaps_m[1]
    if least >= most:
        raise InputError(f"hv_m: surface and finger touch at every gap up to {most:g} m")

    def gap(share: ArrayLike) -> Array:
        return np.asarray(most + np.asarray(share) * (least - most))

    def excess(share: ArrayLike) -> Array:
        return at_share(h0_m=gap(share), hv_m=hv_m, **position) - force_n

    if (found := _first(excess, force_n)) is not None:
        return float(gap(found))
    narrow, wide = (float(excess(share)[0]) + force_n for share in (1.0, 0.0))
    raise InputError(
        f"force_n: the model gives {force_n:g} N at hv_m = {hv_m:g} m for no gap from {least:g} m "
        f"({narrow:.3g} N) to {most:g} m ({wide:.3g} N)"
    )


def _forces(
    model: ExpressionModel,
    theta: ArrayLike,
    *,
    force_n: float,
    complete: Callable[[Factors], Factors] | None,
) -> Callable[..., Array]:
    """The model as a function of factors, for a force that can be wanted."""
    if not np.isfinite(force_n):
        raise InputError(f"force_n: {force_n} is not a finite number")
    if force_n == 0:
        raise InputError("force_n: a force of 0 N wants no amplitude")
    if model.column_names and complete is None:
        raise InputError(
            f"the model {model.name} needs {', '.join(model.column_names)} at each amplitude"
        )

    def forces(**factors: Any) -> Array:
        at = Factors.of(**factors)
        return model.evaluate(theta, complete(at) if complete else at)

    return forces


def _first(excess: Any, force_n: float) -> float | None:
    """The first share in [0, 1) at which the excess over a force is zero, if there is one."""
    for low, high in _brackets(excess):
        found = _root(excess, low, high)
        # The sign may change at a pole, too.
        if abs(excess(found)[0]) <= 1e-9 * (1 + abs(force_n)):
            return found
    return None


def _brackets(excess: Any) -> Iterable[tuple[float, float]]:
    """Pairs of shares in [0, 1) between which a function changes sign, from below.

    The edge of the region where the function is defined is found by bisection: a model may reach
    any force just before its pole.
    """
    grid = np.append(np.linspace(0.0, 1.0, LOOKED_AT, endpoint=False), np.nextafter(1.0, 0.0))
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
