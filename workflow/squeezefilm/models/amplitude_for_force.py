"""The amplitude at which a film gives a wanted force, by a model."""

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import brentq

from squeezefilm.errors import InputError
from squeezefilm.models.data import Array, Factors
from squeezefilm.models.fit_file import FittedModel

LOOKED_AT = 400
"""Places at which a model is looked at before the one for a wanted force is refined."""
STEP = 1e-4
"""Relative step of the amplitude in the slope of the force."""


def working_point(fit: FittedModel, point: Factors, *, force_n: float) -> dict[str, object]:
    """Amplitude, its errors and a note for one gap and position; NaN where there is none."""
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
        hv_m = amplitude_for_force(fit.evaluate, force_n=force_n, **where)
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
    evaluate: Callable[[Factors], Array], *, force_n: float, h0_m: float, **position: float
) -> float:
    """Smallest amplitude hv in metres that gives the wanted force at a gap and position.

    ``evaluate`` gives a model's forces in newtons, the position is as Factors.of takes it. A model
    may reach any force just before the edge of the region in which it is defined: beyond it the
    force counts as on the other side of the wanted one, so that a bracket may end there.
    Raises InputError where no amplitude between rest and contact (0 <= hv < h0) gives the
    force.
    """
    if not np.isfinite(force_n) or force_n == 0:
        raise InputError(f"force_n: {force_n} N is no force that an amplitude gives")

    def excess(share: ArrayLike) -> Array:
        at = Factors.of(h0_m=h0_m, hv_m=np.asarray(share) * h0_m, **position)
        return evaluate(at) - force_n

    def signed(share: float, beyond: float) -> float:
        return float(np.nan_to_num(excess(share)[0], nan=beyond))

    grid = np.append(np.linspace(0.0, 1.0, LOOKED_AT, endpoint=False), np.nextafter(1.0, 0.0))
    values = excess(grid)
    known = ~np.isnan(values)
    changes = (values[:-1] * values[1:] <= 0) | (known[:-1] != known[1:])
    for place in np.flatnonzero(changes):
        defined = place if known[place] else place + 1
        share = grid[defined]
        if values[defined]:
            ends = grid[place : place + 2]
            share = brentq(signed, *ends, args=(-values[defined],), xtol=1e-16, rtol=1e-15)
        # The sign may change at a pole or at the edge, too.
        if abs(excess(share)[0]) <= 1e-9 * (1 + abs(force_n)):
            return float(share) * h0_m
    rest = f"; at rest it gives {values[0] + force_n:.3g} N" if known[0] else ""
    raise InputError(
        f"force_n: the model gives {force_n:g} N at h0_m = {h0_m:g} m for no amplitude "
        f"below contact (hv_m < h0_m){rest}"
    )
