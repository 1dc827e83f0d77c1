"""The rim: gas that streams in has come from rest, and its pressure has fallen for it (T12).

P = 1 − C (σ Re/24) ū_n² where gas flows in (Bernoulli), P = 1 where it flows out. C is 1 for a
plug, 1.54 for a parabola, and more with losses: a bound of what can be known without the outside.
"""

from __future__ import annotations

import numpy as np

from squeezefilm.reynolds.effects.fields import Fields
from squeezefilm.reynolds.effects.sensitivity import Answers, total

# Of C: kinetic energy of a plug and of a parabola, over that of the mean velocity.
LEAST, MOST = 1.0, 1.54


def change(films: Fields, answers: Answers, *, reynolds: np.ndarray) -> np.ndarray:
    """Change of the mean pressure for C = 1, shape (scenes,): on the rim and by its flow."""
    rise = pressure_rise(films, reynolds=reynolds)
    # On the rim, and elsewhere nothing rises, ρ is 1.
    flow = films.problems.numbers["flow"]
    factor = sum(
        films.number(coefficient) * films.gap ** (3 - k) for k, coefficient in enumerate(flow.T)
    )
    return films.mean(rise) - total(answers.along(films.gradient(rise)), np.asarray(factor))


def pressure_rise(films: Fields, *, reynolds: np.ndarray) -> np.ndarray:
    """Change of the rim's pressure for C = 1, zero inside and at the corners, on all nodes."""
    rise = np.zeros_like(films.pressure)
    strength = films.sigma * films.number(reynolds) / 24
    velocity, grid = films.velocity, films.grid
    along_x, along_y = slice(1, grid.nx + 1), slice(1, grid.ny + 1)

    def enter(rim: tuple[slice, ...], inwards: np.ndarray) -> None:
        rise[rim] = -strength * np.maximum(inwards[rim], 0.0) ** 2

    enter(np.s_[:, :1, along_y], velocity.x)
    enter(np.s_[:, along_x, :1], velocity.y)
    if not grid.x.folded:
        enter(np.s_[:, -1:, along_y], -velocity.x)
    if not grid.y.folded:
        enter(np.s_[:, along_x, -1:], -velocity.y)
    return rise
