"""Runge–Kutta schemes for the film in time, and how many steps each needs.

Explicit schemes serve where stability asks for no more steps than accuracy does, implicit ones
where the film is stiff.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import pi, sqrt

import numpy as np

from squeezefilm.reynolds.grid import Grid
from squeezefilm.reynolds.problems import Problems

LEAST_STEPS = 8
# Cost of solving for a stage in units of evaluating one, measured on 16 × 16 nodes.
SOLVE_COST = 20


@dataclass(frozen=True, eq=False)
class Scheme:
    """A Runge–Kutta method with a lower triangular table.

    Attributes:
        name: its key in SCHEMES.
        order: of convergence of the period means in the step.
        error_constant: of the settled force's relative error, see ``steps_for_accuracy``.
        a, b: Butcher's table, shapes (stages, stages) and (stages,).
        real_limit: how far its region of stability reaches along the negative real axis.
    """

    name: str
    order: int
    error_constant: float
    a: np.ndarray
    b: np.ndarray
    real_limit: float = np.inf

    @property
    def c(self) -> np.ndarray:
        """Times of the stages in steps, shape (stages,)."""
        return self.a.sum(axis=1)

    @property
    def stages(self) -> int:
        return len(self.b)

    @property
    def implicit(self) -> bool:
        return bool(np.any(np.diag(self.a)))

    @property
    def step_cost(self) -> int:
        solved = int(np.count_nonzero(np.diag(self.a)))
        return SOLVE_COST * solved if solved else self.stages

    @cached_property
    def table(self) -> np.ndarray:
        return np.concatenate([self.a.ravel(), self.b, self.c])


def _scheme(
    name: str,
    rows: list[list[float]],
    *,
    order: int,
    error_constant: float,
    real_limit: float = np.inf,
) -> Scheme:
    """Scheme from its rows, the last of them the weights b; stiffly accurate ones repeat theirs."""
    stages = len(rows[-1])
    a = np.zeros((stages, stages))
    for i, row in enumerate(rows[:stages]):
        a[i, : len(row)] = row
    return Scheme(
        name=name,
        order=order,
        error_constant=error_constant,
        a=a,
        b=np.array(rows[-1]),
        real_limit=real_limit,
    )


# Classical method: 1 + z + z²/2 + z³/6 + z⁴/24 = 1 at z = −2.78529.
RK4 = _scheme(
    "rk4",
    [[], [1 / 2], [0, 1 / 2], [0, 0, 1], [1 / 6, 1 / 3, 1 / 3, 1 / 6]],
    order=4,
    error_constant=600.0,
    real_limit=2.78529,
)
# Trapezoidal rule and backward differences with one matrix for both stages, L-stable (Bank et al.
# 1985; Hosea and Shampine 1996).
TR_BDF2 = _scheme(
    "tr-bdf2",
    [[], [1 - 1 / sqrt(2)] * 2, [sqrt(2) / 4, sqrt(2) / 4, 1 - 1 / sqrt(2)]],
    order=2,
    error_constant=30.0,
)
# Implicit part of ARK4(3)6L[2]SA, L-stable, stage order two (Kennedy and Carpenter 2003).
ESDIRK4 = _scheme(
    "esdirk4",
    [
        [],
        [1 / 4, 1 / 4],
        [8611 / 62500, -1743 / 31250, 1 / 4],
        [5012029 / 34652500, -654441 / 2922500, 174375 / 388108, 1 / 4],
        [
            15267082809 / 155376265600,
            -71443401 / 120774400,
            730878875 / 902184768,
            2285395 / 8070912,
            1 / 4,
        ],
        [82889 / 524892, 0, 15625 / 83664, 69875 / 102672, -2260 / 8211, 1 / 4],
    ],
    order=4,
    error_constant=25.0,
)
SCHEMES = {scheme.name: scheme for scheme in (RK4, TR_BDF2, ESDIRK4)}


def steps_for_stability(*, problems: Problems, grid: Grid, scheme: str) -> np.ndarray:
    """Least number of steps per period with which a scheme is stable, shape (scenes,).

    The largest eigenvalue of the collocated Laplacian, times the largest H²P ≤ (1 + ε |s|)², over
    σ must lie within the scheme's limit on the real axis; 1 for implicit schemes. Terms add the
    largest of their own, as the limit holds in about all directions to the left.
    """
    limit = SCHEMES[scheme].real_limit
    steepest = -grid.x.modes[0].min() - grid.y.modes[0].min() / problems.aspect**2
    highest = np.abs(problems.parts).max(axis=(1, 2, 3))[problems.places]
    rate = steepest * (1 + problems.epsilon * highest) ** 2
    for term in problems.terms:
        rate = rate + term.explicit_rate(problems.numbers, grid)
    return np.maximum(1.0, np.ceil(2 * pi * rate / problems.sigma / limit))


def steps_for_accuracy(
    *, epsilon: np.ndarray, sigma: np.ndarray, scheme: str, tolerance: float
) -> np.ndarray:
    """Guess of the steps per period that leave a share ``tolerance`` of the force, (scenes,).

    A power law whose constant was fitted to settled films of sinc profile (σ = 1 … 1e5), and for
    large amplitudes as many steps as the harmonics of 1/(1 + ε sin T) need.
    """
    method = SCHEMES[scheme]
    constant = method.error_constant / sigma * (1 + 30 / sigma) ** (method.order / 4)
    law = (constant / tolerance) ** (1 / method.order)
    ratio = epsilon / (1 + np.sqrt(1 - epsilon**2))
    harmonics = np.log(tolerance / 3) / np.log(np.maximum(ratio, 1e-300))
    return np.ceil(np.maximum(np.maximum(law, harmonics), LEAST_STEPS))


@dataclass(frozen=True)
class Choice:
    """How a scene is marched: the scheme, the steps that accuracy asks for, and why."""

    scheme: str
    accurate_steps: int
    left_out: str


def choose(*, problems: Problems, grid: Grid, tolerance: float) -> list[Choice]:
    """For each scene the scheme that is cheapest a priori.

    A step costs one unit per evaluated stage and SOLVE_COST per solved one; explicit schemes take
    as many steps as stability asks for, implicit ones as many as accuracy.
    """
    names = list(SCHEMES)
    accurate = [
        steps_for_accuracy(
            epsilon=problems.epsilon, sigma=problems.sigma, scheme=name, tolerance=tolerance
        )
        for name in names
    ]
    stable = [steps_for_stability(problems=problems, grid=grid, scheme=name) for name in names]
    costs = [
        np.maximum(a, s) * SCHEMES[name].step_cost
        for name, a, s in zip(names, accurate, stable, strict=True)
    ]
    explicit_steps = steps_for_stability(problems=problems, grid=grid, scheme=RK4.name)
    choices = []
    for scene, best in enumerate(np.argmin(costs, axis=0)):
        most = int(explicit_steps[scene])
        if SCHEMES[names[best]].implicit:
            left_out = f"explicit steps, stable only from {most} a period on"
        else:
            left_out = f"implicit steps, as explicit ones are stable from {most} a period on"
        choices.append(Choice(names[best], int(accurate[best][scene]), left_out))
    return choices
