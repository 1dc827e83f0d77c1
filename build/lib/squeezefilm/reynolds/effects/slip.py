"""Rarefaction at first order: the flow that the walls' slip adds to the viscous one (T8)."""

from __future__ import annotations

import numpy as np

from squeezefilm.reynolds.effects.fields import Fields


def source(films: Fields, *, coefficients: np.ndarray) -> np.ndarray:
    """Source of mass on all nodes, −∇·Σ c_k H^(3−k) ρ^(1−k) ∇P over k ≥ 1.

    Args:
        coefficients: c_k, shape (scenes, terms), the viscous flow's 1 first.
    """
    added = coefficients.copy()
    added[:, 0] = 0.0
    slope = films.gradient(films.pressure - 1)
    return -films.divergence(slope.times(films.flux_factor(added)))
