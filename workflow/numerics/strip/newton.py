"""Newton's method with GMRES for equations whose derivative is taken by a complex step."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.linalg import LinearOperator, gmres

from numerics.peers.yardstick import FloatArray
from squeezefilm.io.errors import RunError

Vector = NDArray[Any]
Residual = Callable[[Vector], Vector]
"""An analytic function of its argument, real or complex, shape (n,) in and out."""
Precondition = Callable[[FloatArray], FloatArray]
COMPLEX_STEP = 1e-30
KRYLOV_ITERATIONS = 300
NEWTON_STEPS = 40
HALVINGS = 8


@dataclass(frozen=True)
class Root:
    """Where a residual vanishes, and what that took."""

    state: FloatArray
    residual: float
    newton_steps: int
    krylov_iterations: int


def derivative(residual: Residual, state: FloatArray, direction: FloatArray) -> FloatArray:
    """Along a direction, exact to rounding (Squire and Trapp, SIAM Review 40, 1998)."""
    return np.asarray(np.imag(residual(state + 1j * COMPLEX_STEP * direction)) / COMPLEX_STEP)


def solve_linear(
    residual: Residual,
    state: FloatArray,
    right: FloatArray,
    precondition: Precondition,
    *,
    tolerance: float,
) -> tuple[FloatArray, int]:
    """The direction along which the residual's derivative is `right`, and the iterations taken.

    Raises RunError when GMRES does not reach the relative tolerance.
    """
    count = 0

    def product(direction: FloatArray) -> FloatArray:
        nonlocal count
        count += 1
        return precondition(derivative(residual, state, direction))

    size = len(state)
    found, failed = gmres(
        LinearOperator((size, size), matvec=product, dtype=float),
        precondition(right),
        rtol=tolerance,
        restart=KRYLOV_ITERATIONS,
        maxiter=1,
    )
    if failed:
        raise RunError(f"{KRYLOV_ITERATIONS} Krylov iterations were not enough")
    return found, count


def newton(
    residual: Residual,
    start: FloatArray,
    preconditioner: Callable[[FloatArray], Precondition],
    *,
    tolerance: float,
) -> Root:
    """The state at which the residual vanishes.

    preconditioner: gives an approximate inverse of the derivative at a state.
    tolerance: on the root mean square of the preconditioned residual, about the state's error.

    Raises RunError when that is not reached.
    """
    state, iterations = start, 0
    value = residual(state)
    for step in range(NEWTON_STEPS + 1):
        precondition = preconditioner(state)
        size = _rms(precondition(value))
        if not np.isfinite(size):
            break
        if size < tolerance:
            return Root(state, size, step, iterations)
        wanted = float(np.clip(size, 0.3 * tolerance / size, 0.1))
        change, count = solve_linear(residual, state, -value, precondition, tolerance=wanted)
        iterations += count
        for _ in range(HALVINGS):
            value = residual(state + change)
            if _rms(precondition(value)) < size:
                break
            change = change / 2
        else:
            raise RunError(f"Newton's method stops at a residual of {size:.1e}")
        state = state + change
    raise RunError(f"no convergence in {NEWTON_STEPS} Newton steps (residual {size:.1e})")


def _rms(values: FloatArray) -> float:
    return float(np.linalg.norm(values) / np.sqrt(values.size))
