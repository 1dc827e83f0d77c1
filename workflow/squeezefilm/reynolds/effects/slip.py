"""Rarefaction at first order: the flow that the walls' slip adds to the viscous one."""

from __future__ import annotations

import numpy as np

from squeezefilm.reynolds.effects.fields import Fields
from squeezefilm.reynolds.effects.sensitivity import Answers, total


def changes(films: Fields, answers: Answers, *, terms: int) -> np.ndarray:
    """Change of the mean pressure by a flow H^(3−k) ρ^(1−k) ∇P for each k ≥ 1.

    Its source of mass is −∇· of that, for each unit of the flow's coefficient c_k.

    Returns:
        Changes of shape (scenes, terms).
    """
    power, found = films.gap**2, []
    for _ in range(terms):
        found.append(-total(answers.along, power))
        power = power / films.mass
    return np.stack(found, axis=1)
