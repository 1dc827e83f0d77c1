"""Common parts of the other methods: equation, graded mesh, ways to the periodic state.

Each of them solves the isothermal Reynolds equation on the unit square X, Y in [0, 1],

    div(H^3 P grad P) = Lambda d(HP)/dX + sigma d(HP)/dT,     P = 1 on the edge,
    H = 1 + epsilon s(X, Y) sin T,

and returns the mean force of the periodic state, the integral of <P> - 1 over the square,
in units of p0 l0^2: force in newtons = force * p0 * l0**2.
"""

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.linalg import LinearOperator, gmres

from squeezefilm.errors import RunError
from squeezefilm.film.scene import Scene

FloatArray = NDArray[np.float64]
LinearMap = Callable[[FloatArray], FloatArray]

MAX_NEWTON_STEPS, MAX_KRYLOV_ITERATIONS = 40, 400


def film_symmetry_in_x_and_y(scene: Scene) -> tuple[bool, bool]:
    """Return whether a film is even about X = 1/2 and Y = 1/2, so that half the side suffices.

    It is probed at some points and phases.
    """
    nodes, phases = np.linspace(0.03, 0.46, 7), np.array([0.5, 2.0])
    x, y = np.meshgrid(nodes, 1.1 * nodes, indexing="ij")
    here = scene.gap(x, y, phases)
    even_x = np.allclose(scene.gap(1 - x, y, phases), here, rtol=0, atol=1e-13)
    even_y = np.allclose(scene.gap(x, 1 - y, phases), here, rtol=0, atol=1e-13)
    return even_x and scene.bearing_number == 0, even_y


def graded_cell_edges(*, cells: int, folded: bool) -> FloatArray:
    """Cell edges on [0, 1], or on [0, 1/2] if folded, closing up towards the edge as a cosine.

    cells: in each half of the side, so that a folded mesh is half of the whole one.
    The smooth map from a uniform mesh keeps a scheme's order, and the first cell shrinks as
    1/cells^2, which puts cells into the layer of width sqrt(2/sigma) without knowing sigma.
    """
    part = np.arange((cells if folded else 2 * cells) + 1) / cells
    return np.asarray((1 - np.cos(math.pi / 2 * part)) / 2)


def periods_to_settle(*, sigma: float, tolerance: float) -> int:
    """Periods from rest until the transient has decayed to `tolerance` of its start.

    The slowest mode is sin(pi X) sin(pi Y): it decays as exp(-2 pi^2 T / sigma).
    """
    return 1 + math.ceil(sigma * math.log(1 / tolerance) / (4 * math.pi**3))


def march_to_periodic_force(
    period: Callable[[FloatArray], tuple[FloatArray, float]],
    start: FloatArray,
    *,
    periods: int,
    tolerance: float = 0.0,
    anderson_depth: int = 0,
) -> float:
    """Repeat the period map until the state repeats itself; the mean force of the last period.

    period: maps the state at T = 0 to the state at T = 2 pi and the mean force in between.
    periods: how often the map is applied at most; tolerance: stop before that once no entry
    of the state changes by more than this over a period.
    anderson_depth: 0 marches in time; above 0, Anderson mixing with so many earlier periods
    (D. G. Anderson, J. ACM 12, 1965; in the form of Walker and Ni, SIAM J. Numer. Anal. 49,
    2011) finds the fixed point of the map instead.
    """
    state = start
    images: list[FloatArray] = []
    residuals: list[FloatArray] = []
    for _ in range(periods):
        image, force = period(state)
        residual = image - state
        if np.abs(residual).max() <= tolerance:
            break
        images = [*images, image][-anderson_depth - 1 :]
        residuals = [*residuals, residual][-anderson_depth - 1 :]
        state = image
        if len(images) > 1:
            weights = np.linalg.lstsq(np.diff(residuals, axis=0).T, residual, rcond=None)[0]
            state = image - np.diff(images, axis=0).T @ weights
    return force


def newton_krylov(
    shape: tuple[int, ...],
    linearised: Callable[[FloatArray], tuple[FloatArray, LinearMap, FloatArray | float]],
    *,
    positive: LinearMap,
    tolerance: float,
) -> FloatArray:
    """Newton's method with GMRES for a field, from zero until a preconditioned residual is small.

    Args:
        shape: of the field.
        linearised: gives at a state the preconditioned residual, a mass perturbation whose root
            mean square falls below the tolerance, its derivative to such a perturbation, and the
            change of the state for a unit of it.
        positive: what no step may make a tenth or less of what it was, linear in the state.

    Raises RunError when the method does not get there.
    """
    state = np.zeros(shape)
    for _ in range(MAX_NEWTON_STEPS):
        residual, derivative, per_mass = linearised(state)
        size = float(np.linalg.norm(residual) / math.sqrt(residual.size))
        if size < tolerance:
            return state
        if not math.isfinite(size):
            break
        flat = LinearOperator(
            (residual.size, residual.size),
            matvec=lambda w, apply=derivative: apply(w.reshape(shape)).ravel(),
            dtype=float,
        )
        w, _ = gmres(
            flat,
            -residual.ravel(),
            rtol=min(0.1, max(0.1 * size, 0.3 * tolerance / size)),
            restart=MAX_KRYLOV_ITERATIONS,
            maxiter=1,
        )
        change = per_mass * w.reshape(shape)
        while np.any(positive(state + change) <= 0.1 * positive(state)):
            change /= 2
        state = state + change
    raise RunError(f"no convergence in {MAX_NEWTON_STEPS} Newton steps (residual {size:.1e})")
