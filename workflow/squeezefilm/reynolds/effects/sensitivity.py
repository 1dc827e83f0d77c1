"""How much the mean force answers to a source of mass, wherever and whenever it is: one adjoint.

With J the Jacobian of the film equation for a mass perturbation w = δ(Hρ), an effect of source S
(J w = S) changes the mean pressure by ⟨w/(Hρ')⟩ = ⟨λ S⟩, where λ solves J* λ = 1/(Hρ') once for
all effects. J* is adjoint to J in the quadrature of the grid, and so is its preconditioner, the
inverse of D Δ − σ ∂/∂T.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from squeezefilm.reynolds.effects.fields import Fields, Vector, along_x, along_y
from squeezefilm.reynolds.spectral import Axis

Operator = Callable[[np.ndarray], np.ndarray]
MOST_ITERATIONS = 200


def sensitivity(films: Fields, *, tolerance: float | np.ndarray) -> np.ndarray:
    """λ at the unknowns, shape (scenes, nx, ny, nt): the mean pressure's answer is ``answer``.

    Args:
        tolerance: preconditioned residual over its size at the start, one or one for each scene.
    """
    precondition = _preconditioner(films, adjoint=True)
    adjoint = _adjoint_jacobian(films)
    right = 1 / (films.gap * films.density_slope)[films.inner]
    return gmres(
        lambda values: precondition(adjoint(values)), precondition(right), tolerance=tolerance
    )


def answer(films: Fields, sensitive: np.ndarray, source: np.ndarray) -> np.ndarray:
    """Change of the mean pressure by a source on all nodes or at the unknowns, shape (scenes,)."""
    if source.shape != sensitive.shape:
        source = source[films.inner]
    return films.mean(films.with_rim(sensitive * source))


def flow_of(films: Fields, rise: np.ndarray) -> np.ndarray:
    """∇·Σ c_k H^(3−k) ∇(ρ^(1−k) δP): the flow that a change of pressure makes, on all nodes."""
    flow = films.problems.numbers["flow"]
    flux = Vector(np.zeros_like(rise), np.zeros_like(rise))
    for k in range(flow.shape[1]):
        slope = films.gradient(films.density ** (1 - k) * rise)
        flux = flux.plus(slope.times(films.number(flow[:, k]) * films.gap ** (3 - k)))
    return films.divergence(flux)


def curvature_of_flow(films: Fields, rise: np.ndarray) -> np.ndarray:
    """Second order of an isothermal film's flow in a change of pressure, on all nodes.

    ½ ∇·Σ c_k (1 − k) H^(3−k) ∇(ρ^(−k) δP²), as ρ = P.
    """
    flow = films.problems.numbers["flow"]
    flux = Vector(np.zeros_like(rise), np.zeros_like(rise))
    for k in range(flow.shape[1]):
        slope = films.gradient(films.density ** (-k) * rise**2)
        flux = flux.plus(slope.times((1 - k) / 2 * films.number(flow[:, k]) * films.gap ** (3 - k)))
    return films.divergence(flux)


def response(films: Fields, source: np.ndarray, *, tolerance: float) -> np.ndarray:
    """w of J w = ``source``, all at the unknowns, shape (scenes, nx, ny, nt)."""
    precondition, jacobian = _preconditioner(films, adjoint=False), _jacobian(films)
    return gmres(
        lambda values: precondition(jacobian(values)), precondition(source), tolerance=tolerance
    )


def _jacobian(films: Fields) -> Operator:
    """J w = ∇·Σ c_k H^(3−k) ∇(ρ^(1−k) w/(Hρ')) − σ ∂w/∂T − Λ ∂w/∂X."""
    speed = films.numbers("bearing", absent=0.0)

    def apply(values: np.ndarray) -> np.ndarray:
        mass = films.with_rim(values)
        flow = flow_of(films, mass / (films.gap * films.density_slope))
        moved = films.sigma * films.t_derivative(mass)
        if np.any(speed):
            moved = moved + speed * films.x_derivative(mass)
        return np.asarray((flow - moved)[films.inner])

    return apply


def _adjoint_jacobian(films: Fields) -> Operator:
    """J* of J w = ∇·Σ c_k H^(3−k) ∇(ρ^(1−k) w/(Hρ')) − σ ∂w/∂T − Λ ∂w/∂X."""
    inner, grid = films.inner, films.grid
    x, y = films.along_x, films.along_y
    aspect = films.problems.aspect
    rows_x, rows_y = slice(1, grid.nx + 1), slice(1, grid.ny + 1)
    # Adjoints of gradient and divergence, each between unknowns and all nodes.
    to_x = _adjoint(x.of_odd[rows_x], x.weights[rows_x], x.weights)
    to_y = _adjoint(y.of_odd[rows_y], y.weights[rows_y], y.weights) / aspect
    from_x = _adjoint(x.of_even[:, rows_x], x.weights, x.weights[rows_x])
    from_y = _adjoint(y.of_even[:, rows_y], y.weights, y.weights[rows_y]) / aspect
    slide = _adjoint(x.of_even[rows_x, rows_x], x.weights[rows_x], x.weights[rows_x])
    flow = films.problems.numbers["flow"]
    speed = films.numbers("bearing", absent=0.0)
    factors = [films.number(flow[:, k]) * films.gap ** (3 - k) for k in range(flow.shape[1])]
    factors_x, factors_y = (
        [factor[:, :, rows_y] for factor in factors],
        [factor[:, rows_x] for factor in factors],
    )
    responses = [
        (films.density ** (1 - k) / (films.gap * films.density_slope))[inner]
        for k in range(flow.shape[1])
    ]

    def apply(values: np.ndarray) -> np.ndarray:
        slope_x, slope_y = along_x(to_x, values), along_y(to_y, values)
        result = films.sigma * films.t_derivative(values)
        for factor_x, factor_y, response in zip(factors_x, factors_y, responses, strict=True):
            result += response * (
                along_x(from_x, factor_x * slope_x) + along_y(from_y, factor_y * slope_y)
            )
        if np.any(speed):
            result -= speed * along_x(slide, values)
        return result

    return apply


def _preconditioner(films: Fields, *, adjoint: bool) -> Operator:
    """Inverse of D Δ − σ ∂/∂T by diagonalisation, or its adjoint; D is the mean diffusivity."""
    grid, aspect = films.grid, films.problems.aspect
    diffusivity = films.flux_factor(films.problems.numbers["flow"]) / (
        films.gap * films.density_slope
    )
    strength = diffusivity[films.inner].mean(axis=(1, 2, 3), keepdims=True)
    values_x, to_x, from_x = _modes(grid.x, adjoint=adjoint)
    values_y, to_y, from_y = _modes(grid.y, adjoint=adjoint)
    symbol = strength * np.add.outer(values_x, values_y / aspect**2)[..., None]
    rate = films.sigma * np.arange(grid.nt // 2 + 1)
    rate[..., -1] = 0  # as the sawtooth has no derivative on the nodes
    inverse = 1 / (symbol + (1j if adjoint else -1j) * rate)

    def apply(values: np.ndarray) -> np.ndarray:
        modal = along_y(to_y, along_x(to_x, np.fft.rfft(values))) * inverse
        return np.fft.irfft(along_x(from_x, along_y(from_y, modal)), n=grid.nt)

    return apply


def _modes(axis: Axis, *, adjoint: bool) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Eigenvalues, analysis and synthesis of the second derivative, or of its adjoint."""
    values, vectors, inverse = axis.modes
    if not adjoint:
        return values, inverse, vectors
    ones = np.ones_like(values)
    return values, _adjoint(vectors, axis.weights, ones), _adjoint(inverse, ones, axis.weights)


def _adjoint(matrix: np.ndarray, rows: np.ndarray, columns: np.ndarray) -> np.ndarray:
    """Adjoint of a matrix between spaces with such quadrature weights."""
    return np.asarray(matrix.T * rows / columns[:, None])


def gmres(apply: Operator, right: np.ndarray, *, tolerance: float | np.ndarray) -> np.ndarray:
    """Solve ``apply(x) = right`` for each scene, first axis, by GMRES without restart.

    A scene's answer does not depend on the others': it is that of the first iteration which is
    good enough for it, and NaN where none of MOST_ITERATIONS is.
    """
    scenes, shape = len(right), right.shape
    unsolved = np.ones(scenes, dtype=bool)
    right, size = _finite(right.reshape(scenes, -1))
    basis = np.empty((scenes, MOST_ITERATIONS + 1, right.shape[1]))
    basis[:, 0] = right / np.where(size > 0, size, 1.0)[:, None]
    hessenberg = np.zeros((scenes, MOST_ITERATIONS + 1, MOST_ITERATIONS))
    goal = np.zeros((scenes, MOST_ITERATIONS + 1, 1))
    goal[:, 0, 0] = np.nan_to_num(size)
    shares = np.full((scenes, MOST_ITERATIONS), np.nan)
    for step in range(MOST_ITERATIONS):
        known = basis[:, : step + 1]
        new, _ = _finite(apply(basis[:, step].reshape(shape)).reshape(scenes, -1))
        for _ in range(2):  # twice is enough (Giraud et al. 2005)
            share = known @ new[..., None]
            hessenberg[:, : step + 1, step] += share[..., 0]
            new = new - (share.mT @ known)[:, 0]
        left = np.linalg.norm(new, axis=1)
        hessenberg[:, step + 1, step] = left
        square, wanted = hessenberg[:, : step + 2, : step + 1], goal[:, : step + 2]
        found = np.linalg.pinv(square) @ wanted
        missed = np.linalg.norm(square @ found - wanted, axis=(1, 2))
        done = unsolved & (missed <= tolerance * size)
        shares[done] = 0.0
        shares[done, : step + 1] = found[done, :, 0]
        unsolved &= ~done
        if not unsolved.any():
            break
        basis[:, step + 1] = new / np.where(left > 0, left, 1.0)[:, None]
    found = shares[:, None, : step + 1] @ basis[:, : step + 1]
    return np.asarray(found).reshape(shape)


def _finite(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Values with zeros for a scene that has some which are not finite, and each scene's size.

    The size of such a scene is NaN, so that nothing is ever good enough for it.
    """
    size = np.linalg.norm(values, axis=1)
    return np.where(np.isfinite(size)[:, None], values, 0.0), size
