"""The rim: gas that streams in has come from rest, and its pressure has fallen for it.

P = 1 − C (σ Re/24) ū_n² where gas flows in (Bernoulli), P = 1 where it flows out. C is 1 for a
plug, 1.54 for a parabola, and more with losses: a bound of what can be known without the outside.
"""

from __future__ import annotations

from functools import reduce

import numpy as np

from squeezefilm.reynolds.effects.fields import Fields, along_x, along_y
from squeezefilm.reynolds.effects.sensitivity import Answers, total

# Of C: kinetic energy of a plug and of a parabola, over that of the mean velocity.
LEAST, MOST = 1.0, 1.54


def change(films: Fields, answers: Answers, *, reynolds: np.ndarray) -> np.ndarray:
    """Change of the mean pressure for C = 1, shape (scenes,): on the rim and by its flow.

    On the rim ρ is 1, and λ is 0: of the flow only that across it counts. Elsewhere nothing rises.
    """
    flow = reduce(np.add, films.flows)
    weights = films.weights.reshape(films.gap.shape[1:])
    to_x, to_y = films.along_x.of_even.T, films.along_y.of_even.T / films.problems.aspect
    fallen = np.zeros(len(reynolds))
    for end, inwards in ((slice(1), 1.0), (slice(-1, None), -1.0)):
        if inwards > 0 or not films.grid.x.folded:
            mean = weights[end] - along_x(to_x[end], answers.slope.x * flow)
            fallen += total(np.maximum(inwards * films.velocity.x[:, end], 0.0) ** 2, mean)
        if inwards > 0 or not films.grid.y.folded:
            mean = weights[:, end] - along_y(to_y[end], answers.slope.y * flow)
            fallen += total(np.maximum(inwards * films.velocity.y[:, :, end], 0.0) ** 2, mean)
    return -films.problems.sigma * reynolds / 24 * fallen
