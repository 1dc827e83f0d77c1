"""Least squares on a surface's smooth modes, the degree by cross-validation."""

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np

from squeezefilm.errors import InputError
from squeezefilm.film.surfaces import Surface

LARGEST_DEGREE = 24
POINTS_PER_MODE = 3
LARGEST_CONDITION = 1e8
# Degrees above the best by cross-validation, so that the misfit is small beside the noise.
DEGREES_MORE = 2
# An axisymmetric profile is doubted where angles leave less than this share of what it leaves, and
# the points that this is looked at with.
LESS_WITH_ANGLES, MOST_LOOKED_AT = 0.5, 2000


@dataclass(frozen=True)
class Fit:
    """Least squares on the modes up to one degree.

    ``held_out`` is the error at each point of the fit to the others, ``scores`` has its rms by
    degree, and ``root`` (modes, modes) is the factor by which the points' noise enters the
    coefficients: their covariance is noise² root rootᵀ.
    """

    degree: int
    orders: tuple[tuple[int, int], ...]
    coefficients: np.ndarray
    held_out: np.ndarray
    root: np.ndarray
    scores: dict[int, float]


def best_fit(
    path: Path,
    surface: Surface,
    x: np.ndarray,
    y: np.ndarray,
    measured: np.ndarray,
    axisymmetric: bool,
) -> Fit:
    """Least squares, DEGREES_MORE above the degree of least leave-one-out error.

    The error at a left-out point is e/(1 − h), h its leverage, without fitting again (Allen's
    PRESS).

    Args:
        path: of the scan, for messages.
        x, y: the points, scaled.

    Raises InputError where the points determine no profile.
    """
    degrees, orthogonal, triangle = _decomposed(surface, x.tobytes(), y.tobytes(), axisymmetric)
    along = orthogonal.T @ measured
    # More modes are never better determined: where the most are, one condition number will do.
    sure = np.linalg.cond(triangle) <= LARGEST_CONDITION
    scores: dict[int, float] = {}
    errors: dict[int, np.ndarray] = {}
    for degree in degrees:
        count = len(surface.orders_up_to(degree, axisymmetric=axisymmetric))
        leverage = np.sum(orthogonal[:, :count] ** 2, axis=1)
        determined = sure or np.linalg.cond(triangle[:count, :count]) <= LARGEST_CONDITION
        if not determined or leverage.max() > 1 - 1e-6:
            break
        residual = measured - orthogonal[:, :count] @ along[:count]
        errors[degree] = residual / (1 - leverage)
        scores[degree] = float(np.sqrt(np.mean(np.abs(errors[degree]) ** 2)))
    if not scores:
        raise InputError(f"{path}: the points do not determine a profile")
    best = min(scores, key=lambda degree: scores[degree])
    degree = max(each for each in scores if each <= best + DEGREES_MORE)
    orders = surface.orders_up_to(degree, axisymmetric=axisymmetric)
    root = np.linalg.inv(triangle[: len(orders), : len(orders)])
    return Fit(degree, orders, root @ along[: len(orders)], errors[degree], root, scores)


@lru_cache(maxsize=2)
def _decomposed(
    surface: Surface, x: bytes, y: bytes, axisymmetric: bool
) -> tuple[tuple[int, ...], np.ndarray, np.ndarray]:
    """Degrees that so many points allow, and the QR decomposition of their modes there.

    The modes of a degree come before those of the next: one decomposition serves all. It is kept,
    as the same points are fitted again.
    """
    places = {"x": np.frombuffer(x), "y": np.frombuffer(y)}
    degrees = tuple(
        degree
        for degree in range(0, LARGEST_DEGREE + 1, 2 if axisymmetric else 1)
        if POINTS_PER_MODE * len(surface.orders_up_to(degree, axisymmetric=axisymmetric))
        <= len(places["x"])
    )
    orders = surface.orders_up_to(degrees[-1], axisymmetric=axisymmetric)
    return degrees, *np.linalg.qr(surface.modes_at(orders, **places))


def wants_angles(
    path: Path, surface: Surface, x: np.ndarray, y: np.ndarray, measured: np.ndarray, fit: Fit
) -> str:
    """What is to be said where a profile with angles leaves far less; empty where none does."""
    some = slice(None, None, -(-len(x) // MOST_LOOKED_AT))
    try:
        free = best_fit(path, surface, x[some], y[some], measured[some], False)
    except InputError:  # too few points for angles
        return ""
    share = min(free.scores.values()) / min(fit.scores.values())
    if share > LESS_WITH_ANGLES:
        return ""
    return (
        f"the scan is not axisymmetric: a profile with angles leaves {share:.2g} of what this one "
        "does, and no noise or error here holds; say actuator.profile.axisymmetric: false"
    )
