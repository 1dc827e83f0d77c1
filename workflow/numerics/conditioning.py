"""How accurate must a simulation be? Force errors, and what they do to the fit and the design."""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import pandas as pd

from squeezefilm.designs.box import Box, coordinates
from squeezefilm.designs.paper_design import Criterion, descend
from squeezefilm.io.errors import InputError
from squeezefilm.io.progress import say
from squeezefilm.models.fitting.fit import fit_model
from squeezefilm.models.fitting.local_fit import local_fit
from squeezefilm.models.force_model import TWO_FACTOR, Factors

FORCE_ERRORS = tuple(10.0**-k for k in range(2, 9))
SUCCESS = 1e-6  # relative, on the global error of the best fit


def conditioning(
    *,
    screen: Factors,
    screen_force_n: np.ndarray,
    design: Factors,
    design_force_n: np.ndarray,
    theta: np.ndarray,
    triplets: Sequence[np.ndarray],
    box: Box,
    scaling: str,
    bounds: Sequence[float],
    seeds: int,
) -> pd.DataFrame:
    """Rows in which `quantity` says what `value` is, `points` on which forces.

    theta: the fit on the screen; triplets: D-optimal designs of three points each, (3, 2), in
    metres, found for it; scaling: of the distances in their criterion; seeds: draws of force
    errors, and seeds of the fit.
    """
    rows: list[dict[str, Any]] = []
    for points, factors, force in (
        ("screen", screen, screen_force_n),
        ("design", design, design_force_n),
    ):
        best = local_fit(TWO_FACTOR, factors, force, theta)
        rows += list(_information(points, best, factors))
        for size in FORCE_ERRORS:
            say(f"{points}, force error {size:g}")
            rows += list(
                _moved(points, factors, force, best, size=size, draws=seeds, screen=screen)
            )
    for size in FORCE_ERRORS:
        moves = _design_moves(
            screen, screen_force_n, theta, triplets, box, scaling, size=size, draws=min(seeds, 20)
        )
        rows.append(
            {
                "quantity": "design_move",
                "points": "screen",
                "force_error": size,
                "draws": len(moves),
                "value": float(np.median(moves)) if len(moves) else np.nan,
            }
        )
    for bound in bounds:
        say(f"fits within ±{bound:g}")
        rows.append(_success_rate(screen, screen_force_n, bound=bound, seeds=seeds))
    return pd.DataFrame(rows)


def _information(points: str, theta: np.ndarray, factors: Factors) -> Iterator[dict[str, Any]]:
    """Determinant and condition number of F'F, as it is and with columns of unit length."""
    derivatives = TWO_FACTOR.gradient(theta, factors)
    scaled = derivatives / np.linalg.norm(derivatives, axis=0)
    information = derivatives.T @ derivatives
    values = {
        "determinant of F'F": float(np.linalg.det(information)),
        "condition number of F'F": float(np.linalg.cond(derivatives) ** 2),
        "condition number of F'F, unit columns": float(np.linalg.cond(scaled) ** 2),
    }
    for quantity, value in values.items():
        yield {"quantity": quantity, "points": points, "value": value}


def _moved(
    points: str,
    factors: Factors,
    force_n: np.ndarray,
    best: np.ndarray,
    *,
    size: float,
    draws: int,
    screen: Factors,
) -> Iterator[dict[str, Any]]:
    """Root mean square moves of the parameters, relative, and of the model's force over the
    screen, when forces carry independent relative errors of this size."""
    random = np.random.default_rng(1)
    noisy = [force_n * (1 + size * random.standard_normal(len(force_n))) for _ in range(draws)]
    fits = np.array([local_fit(TWO_FACTOR, factors, each, best) for each in noisy])
    move = np.sqrt(np.mean((fits / best - 1) ** 2, axis=0))
    yield {
        "quantity": "parameter_move",
        "points": points,
        "force_error": size,
        "draws": draws,
        "value": float(move.max()),
        **dict(zip(TWO_FACTOR.parameter_names, map(float, move), strict=True)),
    }
    model = TWO_FACTOR.evaluate(best, screen)
    change = np.linalg.norm(TWO_FACTOR.evaluate(fits, screen) - model, axis=1)
    yield {
        "quantity": "model_move",
        "points": points,
        "force_error": size,
        "draws": draws,
        "value": float(np.sqrt(np.mean(change**2)) / np.linalg.norm(model)),
    }


def _design_moves(
    screen: Factors,
    force_n: np.ndarray,
    theta: np.ndarray,
    triplets: Sequence[np.ndarray],
    box: Box,
    scaling: str,
    *,
    size: float,
    draws: int,
) -> np.ndarray:
    """Largest move of a point of the optimal triplets, in unit factors, per draw."""

    def refined(at: np.ndarray) -> list[np.ndarray]:
        criterion = Criterion(
            lambda points: TWO_FACTOR.gradient(at, TWO_FACTOR.factors(points)),
            box,
            distance=coordinates(scaling, box),
        )
        return [box.to_unit(descend(criterion, triplet).points) for triplet in triplets]

    start = refined(theta)
    random = np.random.default_rng(1)
    moves = []
    for _ in range(draws):
        noisy = force_n * (1 + size * random.standard_normal(len(force_n)))
        try:
            found = refined(local_fit(TWO_FACTOR, screen, noisy, theta))
        except InputError:  # a singular design: no optimum to compare with
            continue
        moves.append(
            max(float(np.abs(new - old).max()) for new, old in zip(found, start, strict=True))
        )
    return np.array(moves)


def _success_rate(
    factors: Factors, force_n: np.ndarray, *, bound: float, seeds: int
) -> dict[str, Any]:
    errors = np.array(
        [
            fit_model(TWO_FACTOR, factors, force_n, bound=bound, seed=seed).global_error
            for seed in range(1, seeds + 1)
        ]
    )
    return {
        "quantity": f"share of seeds that find the best fit, bounds ±{bound:g}",
        "points": "screen",
        "draws": seeds,
        "value": float(np.mean(errors <= errors.min() * (1 + SUCCESS))),
    }
