"""The basis in time in which the periodic state is preconditioned: it knows how the gap moves.

Where the film is compressed its gas flows more easily in proportion to the gap, and where the gas
has inertia its flow lags. Averaged over the finger, a change w of the mass obeys

    D Δw − σ A dw/dT = A r,      A = 1/h + lag L d/dT,      h = 1 + variation sin T + lagging cos T,

with the right-hand side r of the film's linear system, h the mean gap, D the mean of what diffuses
the mass over h and L the part of a force that inertia is given (``slow_part``). In the eigenvectors
of A d/dT, which are Fourier's for h = 1, this is one number for each mode of space and of time.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from squeezefilm.film.scene import distinct
from squeezefilm.reynolds.grid import Grid
from squeezefilm.reynolds.layout import Packed, packed
from squeezefilm.reynolds.spectral import period

# Steps in which variation and lag are told apart, which only decide the iterations' number, and the
# share of slow harmonics.
VARIATION_STEP = 0.05
MOST_VARIATION = round(1 / VARIATION_STEP) - 1
LAGS_PER_DECADE = 20
SLOW_STEP = 1 / 32
# What a film without inertia has for a lag.
LEAST_LAG = 1e-12
# Least speed of a pair: the first harmonic has 1, the null space rounding errors.
SLOWEST = 1e-3


def slow_part(instants: int, share: float) -> np.ndarray:
    """L, shape (nt, nt): of forces on so many instants, the harmonics in which the gas has inertia.

    That is about a ``share`` of those that the instants know; in the others the gas follows the
    pressure at once. Which they are, the next grid tells, where there are more.
    """
    return period(instants).harmonics_up_to(share * instants / 2)


@dataclass(frozen=True, eq=False)
class TimeModes:
    """Real modes over one period of nt instants, pair by pair: see ``Period``.

    With the decays g and speeds s of a pair, A d/dT maps its coefficients (c, d) to
    (g c + s d, g d − s c). The first pair has neither: it is the mean and the last cosine.

    Attributes:
        to_modes: coefficients of A r from the values of r on the instants, shape (nt, nt).
        from_modes: values from coefficients, shape (nt, nt); its 2-norm is 1, so that a change is
            no larger than its coefficients.
        decays, speeds: shape (nt / 2,).
        mean_gap: h on the instants, shape (nt,).
        settling: (1 + lag L h d/dT)⁻¹, how a flow follows what drives it, shape (nt, nt).
        settling_of_slow: the same after L.
    """

    to_modes: np.ndarray
    from_modes: np.ndarray
    decays: np.ndarray
    speeds: np.ndarray
    mean_gap: np.ndarray
    settling: np.ndarray
    settling_of_slow: np.ndarray

    @property
    def arrays(self) -> dict[str, np.ndarray]:
        """The arrays as kernels know them: transposed, the modes of a pair beside each other."""
        instants = len(self.mean_gap)
        return {
            "to_time_modes": self.to_modes[_beside(instants)].T,
            "time_modes": self.from_modes[:, _beside(instants)].T,
            "speeds": self.speeds,
            "decays": self.decays,
            "mean_resistance": 1 / self.mean_gap,
            "settling": self.settling.T,
            "settling_of_slow": self.settling_of_slow.T,
        }


def _beside(instants: int) -> np.ndarray:
    """The order in which each first mode of a pair is followed by its second, shape (nt,)."""
    return np.arange(instants).reshape(2, -1).T.ravel()


# Variation, lagging, lag and share of slow harmonics of a film, in the steps that are told apart.
Steps = tuple[float, float, float, float]


def steps_of(motion: np.ndarray, *, lag: np.ndarray, slow: np.ndarray) -> list[Steps]:
    """What tells the modes of films from each other.

    Args:
        motion: variation and lagging of the mean gaps, both together below 1, shape (2, films).
        lag: of the flow behind what drives it, in units of 1/ω; 0 without inertia.
        slow: share of the harmonics that lag (``slow_part``).
    """
    near = np.rint(motion / VARIATION_STEP)
    near *= MOST_VARIATION / np.maximum(np.hypot(*near), MOST_VARIATION)
    lags = np.rint(LAGS_PER_DECADE * np.log10(np.maximum(lag, LEAST_LAG)))
    return [*zip(*near.tolist(), lags.tolist(), np.rint(slow / SLOW_STEP).tolist(), strict=True)]


def modes_of(
    grids: Sequence[Grid], *, aspect: float, numbers: np.ndarray, motion: np.ndarray
) -> tuple[Packed, np.ndarray]:
    """The modes of films on each of some grids, each kind's once, and which kind each film has.

    Args:
        numbers: of the films' equation, a row for each.
        motion: factors of sin T and cos T of their mean gaps, (2, films).
    """
    instants, lag = [grid.nt for grid in grids], numbers["lag"]
    if not lag.any():  # all that tells them apart is how the gaps move
        near = np.rint(motion / VARIATION_STEP)
        first, which = distinct(1000 * near[0] + near[1])
        kinds = steps_of(motion[:, first], lag=lag[first], slow=np.ones(len(first)))
        return _packed_kinds(instants, [[steps] * len(grids) for steps in kinds]), which
    on_grids = []
    for grid in grids:  # only how many harmonics lag varies
        across = max(grid.x.full_points, grid.y.full_points / aspect)
        slow = np.minimum(numbers["slow"], numbers["waves_per_node"] * across / (grid.nt / 2))
        on_grids.append(steps_of(motion, lag=lag, slow=slow))
    known: dict[tuple[Steps, ...], int] = {}
    films = zip(*on_grids, strict=True)
    which = np.array([known.setdefault(steps, len(known)) for steps in films])
    return _packed_kinds(instants, list(known)), which


def _packed_kinds(instants: Sequence[int], kinds: Sequence[Sequence[Steps]]) -> Packed:
    return Packed.of_rows([_packed_modes(tuple(instants), tuple(steps)) for steps in kinds])


@lru_cache(maxsize=4096)
def _packed_modes(instants: tuple[int, ...], steps: tuple[Steps, ...]) -> Packed:
    """The arrays of one kind of films, on each of some grids."""
    on_grids = (time_modes(*each).arrays for each in zip(instants, steps, strict=True))
    return packed([{name: array[None] for name, array in each.items()} for each in on_grids])


@lru_cache(maxsize=4096)
def time_modes(instants: int, steps: Steps) -> TimeModes:
    """The modes of films whose numbers are within such steps."""
    variation, lagging = (VARIATION_STEP * part for part in steps[:2])
    lag = 10 ** (steps[2] / LAGS_PER_DECADE)
    lag = lag if lag > LEAST_LAG else 0.0
    share = SLOW_STEP * steps[3]
    rate = period(instants).derivative
    nodes = period(instants).nodes
    mean_gap = 1 + variation * np.sin(nodes) + lagging * np.cos(nodes)
    slow = slow_part(instants, share)
    resistance = np.diag(1 / mean_gap) + lag * slow @ rate
    pairs = _pairs(resistance @ rate, mean_gap)
    if pairs is None:
        return time_modes(instants, (0.0, 0.0, *steps[2:]))
    vectors, decays, speeds = pairs
    settling = np.linalg.inv(np.eye(instants) + lag * slow @ (mean_gap[:, None] * rate))
    return TimeModes(
        to_modes=np.linalg.solve(vectors, resistance),
        from_modes=vectors,
        decays=decays,
        speeds=speeds,
        mean_gap=mean_gap,
        settling=settling,
        settling_of_slow=settling @ slow,
    )


def _pairs(operator: np.ndarray, mean_gap: np.ndarray) -> tuple[np.ndarray, ...] | None:
    """Real vectors (nt, nt), decays and speeds (nt / 2,) of A d/dT; None if not all are pairs.

    Its null space is what d/dT maps to zero: the constant and the last cosine.
    """
    instants = len(operator)
    half = instants // 2
    values, complex_vectors = np.linalg.eig(operator)
    turning = np.argsort(values.imag)[half + 1 :]
    if not (values[turning].imag > SLOWEST).all():
        return None
    vectors = np.empty((instants, instants))
    vectors[:, 0] = 1.0
    vectors[:, half] = np.cos(half * period(instants).nodes)
    vectors[:, 1:half] = complex_vectors[:, turning].real
    vectors[:, half + 1 :] = complex_vectors[:, turning].imag
    # Both of a pair alike; undamped modes are orthogonal under the weight 1/h.
    size = np.sum(vectors**2 * mean_gap[:, None] ** -1, axis=0)
    size[1:half] = size[half + 1 :] = (size[1:half] + size[half + 1 :]) / 2
    vectors /= np.sqrt(size)
    vectors /= np.linalg.norm(vectors, 2)
    decays, speeds = np.zeros((2, half))
    decays[1:], speeds[1:] = values[turning].real, values[turning].imag
    return vectors, decays, speeds
