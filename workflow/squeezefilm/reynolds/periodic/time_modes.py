"""The basis in time in which the periodic state is preconditioned: it knows how the gap moves.

Where the film is compressed its gas flows more easily in proportion to the gap, where the gas has
inertia its flow lags, and where compression warms the gas it holds less of it. Averaged over the
pad, a change w of the mass obeys

    D Δw − σ A d/dT (1 − B) w = A r,      A = 1/h + lag L d/dT,
    h = 1 + variation sin T + lagging cos T,      B = warming/(1 + 1/(warming_lag d/dT)),

with the right-hand side r of the film's linear system, h the mean gap, D the mean of what diffuses
the mass over h and L the part of a force that inertia is given (``_time_modes``). In the
eigenvectors of A d/dT (1 − B), which are Fourier's for h = 1, this is one number for each mode of
space and of time.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from math import hypot, inf

import numpy as np

from squeezefilm.film.scene import distinct_row_indices
from squeezefilm.reynolds.grid import Grid
from squeezefilm.reynolds.layout import PackedArrays, pack_arrays
from squeezefilm.reynolds.spectral import cached_time_axis

# Steps in which variation and lag are told apart, which only decide the iterations' number, and the
# share of slow harmonics.
GAP_VARIATION_STEP = 0.05
MAX_GAP_VARIATION_INDEX = round(1 / GAP_VARIATION_STEP) - 1
LAG_STEPS_PER_DECADE = 20
SLOW_HARMONICS_FRACTION_STEP = 1 / 32
WARMING_STEP = 1 / 64
# What a film without inertia, or that stays at ambient temperature, has for a lag.
MIN_PHASE_LAG = 1e-12
# Least speed of a pair: the first harmonic has 1, the null space rounding errors.
MIN_PAIR_ANGULAR_FREQUENCY = 1e-3


def time_modes_of_films(
    grids: Sequence[Grid], *, aspect: float, numbers: np.ndarray, motion: np.ndarray
) -> tuple[PackedArrays, np.ndarray]:
    """The modes of films on each of some grids, each kind's once, and which kind each film has.

    Args:
        numbers: of the films' equation, a row for each.
        motion: factors of sin T and cos T of their mean gaps, both together below 1, (2, films).
    """
    steps = [*np.rint(motion / GAP_VARIATION_STEP)]
    if numbers["lag"].any() or numbers["warming"].any():
        lags, warming_lags = (
            np.rint(LAG_STEPS_PER_DECADE * np.log10(np.maximum(numbers[name], MIN_PHASE_LAG)))
            for name in ("lag", "warming_lag")
        )
        warming = np.rint(numbers["warming"] / WARMING_STEP)
        across = [max(grid.nodes_per_length(aspect)) for grid in grids]
        waves = np.multiply.outer(across, numbers["waves_per_node"])
        half = np.array([[grid.nt / 2] for grid in grids])
        slows = np.rint(np.minimum(numbers["slow"], waves / half) / SLOW_HARMONICS_FRACTION_STEP)
        slows = np.maximum(slows, 1.0)
        steps += [lags, warming, warming_lags, *slows]
    first, which = distinct_row_indices(*steps)
    instants = tuple([grid.nt for grid in grids])
    kinds = np.array(steps)[:, first].T.tolist()
    return PackedArrays.join_rows([_packed_modes(instants, *kind) for kind in kinds]), which


@lru_cache(maxsize=4096)
def _packed_modes(
    instants: tuple[int, ...],
    variation: float,
    lagging: float,
    lag: float = -inf,
    warming: float = 0.0,
    warming_lag: float = -inf,
    *slows: float,
) -> PackedArrays:
    """The arrays of one kind of films, on each of some grids."""
    stages = []
    shrunk = MAX_GAP_VARIATION_INDEX / max(hypot(variation, lagging), MAX_GAP_VARIATION_INDEX)
    for nt, slow in zip(
        instants, slows or [1 / SLOW_HARMONICS_FRACTION_STEP] * len(instants), strict=True
    ):
        numbers = lag, warming, warming_lag, slow
        arrays = _time_modes(nt, shrunk * variation, shrunk * lagging, *numbers)
        stages.append({name: array[None] for name, array in arrays.items()})
    return pack_arrays(stages)


@lru_cache(maxsize=4096)
def _time_modes(
    instants: int,
    variation: float,
    lagging: float,
    lag: float,
    warming: float,
    warming_lag: float,
    slow: float,
) -> dict[str, np.ndarray]:
    """Real modes over one period, as kernels know them, of films whose numbers are within steps.

    They come in pairs, beside each other. With the decays g and speeds s of a pair, A d/dT (1 − B)
    maps its coefficients (c, d) to (g c + s d, g d − s c). The first pair has neither: it is the
    mean and the last cosine.

    ``to_time_modes`` gives coefficients of A r from the values of r on the instants, ``time_modes``
    values from coefficients; its 2-norm is 1, so that a change is no larger than its coefficients.
    ``mass_rate`` is d/dT (1 − B). ``settling`` is (1 + lag L h d/dT)⁻¹, how a flow follows what
    drives it, ``settling_of_slow`` the same after L. Matrices are transposed.

    L leaves of a force, about, a share ``slow`` of the harmonics that the instants know, those in
    which the gas has inertia; in the others it follows the pressure at once. Which they are, the
    next grid tells, where there are more.
    """
    rate, nodes = cached_time_axis(instants).derivative_matrix, cached_time_axis(instants).nodes
    mean_gap = (
        1
        + GAP_VARIATION_STEP * variation * np.sin(nodes)
        + GAP_VARIATION_STEP * lagging * np.cos(nodes)
    )
    inert = cached_time_axis(instants).low_pass_matrix(
        SLOW_HARMONICS_FRACTION_STEP * slow * instants / 2
    )
    lag_of_rate = 10 ** (lag / LAG_STEPS_PER_DECADE) * inert
    resistance = np.diag(1 / mean_gap) + lag_of_rate @ rate
    warm_rate = 10 ** (warming_lag / LAG_STEPS_PER_DECADE) * rate
    warms = np.linalg.solve(np.eye(instants) + warm_rate, WARMING_STEP * warming * warm_rate)
    mass_rate = rate - rate @ warms
    pairs = _real_mode_pairs(resistance @ mass_rate, mean_gap)
    if pairs is None:
        return _time_modes(instants, 0.0, 0.0, lag, warming, warming_lag, slow)
    vectors, decays, speeds = pairs
    settling = np.linalg.inv(np.eye(instants) + lag_of_rate @ (mean_gap[:, None] * rate))
    beside = np.arange(instants).reshape(2, -1).T.ravel()
    return {
        "to_time_modes": np.linalg.solve(vectors, resistance)[beside].T,
        "time_modes": vectors[:, beside].T,
        "speeds": speeds,
        "decays": decays,
        "mean_resistance": 1 / mean_gap,
        "mass_rate": mass_rate.T,
        "settling": settling.T,
        "settling_of_slow": (settling @ inert).T,
    }


def _real_mode_pairs(operator: np.ndarray, mean_gap: np.ndarray) -> tuple[np.ndarray, ...] | None:
    """Real vectors (nt, nt), decays and speeds (nt / 2,) of A d/dT (1 − B), None if not in pairs.

    Its null space is what d/dT maps to zero: the constant and the last cosine.
    """
    instants = len(operator)
    half = instants // 2
    values, complex_vectors = np.linalg.eig(operator)
    turning = np.argsort(values.imag)[half + 1 :]
    if not (values[turning].imag > MIN_PAIR_ANGULAR_FREQUENCY).all():
        return None
    vectors = np.empty((instants, instants))
    vectors[:, 0] = 1.0
    vectors[:, half] = np.cos(half * cached_time_axis(instants).nodes)
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
