"""The amplitude, or the gap, at which a film gives a wanted force, by a model."""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import brentq

from squeezefilm.io.errors import InputError
from squeezefilm.models.data import Array, Factors
from squeezefilm.models.fit_file import FittedModel
from squeezefilm.models.force_model import ExpressionModel

LOOKED_AT = 400
"""Places at which a model is looked at before the one for a wanted force is refined."""
STEP = 1e-4
"""Relative step of the amplitude in the slope of the force."""

Complete = Callable[[Factors], Factors]
"""Adds the columns of a model's results of physics to factors."""


def working_point(fit: FittedModel, point: Factors, *, force_n: float) -> dict[str, object]:
    """Amplitude, its errors and a note for one gap and position; NaN where there is none."""
    model = fit.force_model
    point = fit.represented(point)
    where = {name: float(point.column(name)[0]) for name in ("h0_m", *point.position)}
    row: dict[str, object] = {
        "force_n": force_n,
        **dict.fromkeys(("hv_m", "hv_error_95_m", "error_95_percent"), np.nan),
        **fit.profile_uncertainty_percent,
        "validity": "",
    }
    fit.complete(point)  # an error names what is missing, if anything
    try:
        hv_m = amplitude_for_force(
            model, fit.theta, force_n=force_n, complete=fit.complete, **where
        )
    except InputError as error:
        return row | {"note": str(error).removeprefix("force_n: ")}
    near = Factors.of(**where | {"hv_m": hv_m * np.array([1 - STEP, 1.0, 1 + STEP])})
    below, _, above = fit.evaluate(near)
    slope = (above - below) / (2 * STEP * hv_m) if hv_m else np.nan
    (error_n,), _, (note,) = fit.validation(near.take([1]), [force_n])
    return row | {
        "hv_m": hv_m,
        "hv_error_95_m": error_n / abs(slope) if slope else np.nan,
        "error_95_percent": 100 * error_n / abs(force_n),
        "validity": fit.validity(near.take([1]))[0],
        "note": note,
    }


def amplitude_for_force(
    model: ExpressionModel,
    theta: ArrayLike,
    *,
    force_n: float,
    h0_m: float,
    complete: Complete | None = None,
    **position: float,
) -> float:
    """Smallest amplitude hv in metres that gives the wanted force at a gap and position.

    The position as Factors.of takes it. A model of results of physics needs ``complete``.
    Raises InputError where no amplitude between rest and contact (0 <= hv < h0) gives the
    force.
    """
    forces = _forces(model, theta, force_n=force_n, complete=complete)

    def excess(share: ArrayLike) -> Array:
        return forces(h0_m=h0_m, hv_m=np.asarray(share) * h0_m, **position) - force_n

    if (share := _first_zero(excess, force_n)) is not None:
        return share * h0_m
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
    complete: Complete | None = None,
    **position: float,
) -> float:
    """Widest gap h0 in metres at which an amplitude gives the wanted force at a position.

    gaps_m: the least and the largest gap that are looked at, such as those of the fitted points;
    the rest as amplitude_for_force has it. A part that comes down from above floats there.
    Raises InputError where no such gap above contact (h0 > hv) gives the force.
    """
    forces = _forces(model, theta, force_n=force_n, complete=complete)
    least, most = max(gaps_m[0], float(np.nextafter(hv_m, 1.0))), gaps_m[1]
    if least >= most:
        raise InputError(f"hv_m: surface and finger touch at every gap up to {most:g} m")

    def excess(share: ArrayLike) -> Array:
        gap = most + np.asarray(share) * (least - most)
        return forces(h0_m=gap, hv_m=hv_m, **position) - force_n

    if (share := _first_zero(excess, force_n)) is not None:
        return most + share * (least - most)
    narrow, wide = excess([1.0, 0.0]) + force_n
    raise InputError(
        f"force_n: the model gives {force_n:g} N at hv_m = {hv_m:g} m for no gap from {least:g} m "
        f"({narrow:.3g} N) to {most:g} m ({wide:.3g} N)"
    )


def _forces(
    model: ExpressionModel, theta: ArrayLike, *, force_n: float, complete: Complete | None
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


def _first_zero(excess: Callable[[ArrayLike], Array], force_n: float) -> float | None:
    """The first share in [0, 1) at which the excess over a force is zero, if there is one.

    A model may reach any force just before the edge of the region in which it is defined: beyond
    it the excess counts as of the other sign, so that a bracket may end there.
    """
    grid = np.append(np.linspace(0.0, 1.0, LOOKED_AT, endpoint=False), np.nextafter(1.0, 0.0))
    values = excess(grid)
    known = ~np.isnan(values)
    changes = (values[:-1] * values[1:] <= 0) | (known[:-1] != known[1:])
    for place in np.flatnonzero(changes):
        defined = values[place] if known[place] else values[place + 1]

        def signed(share: float, beyond: float = -float(defined)) -> float:
            value = float(excess(share)[0])
            return beyond if np.isnan(value) else value

        share = grid[place if known[place] else place + 1]
        if defined:
            share = brentq(signed, grid[place], grid[place + 1], xtol=1e-16, rtol=1e-15)
        # The sign may change at a pole or at the edge, too.
        if abs(excess(share)[0]) <= 1e-9 * (1 + abs(force_n)):
            return float(share)
    return None
