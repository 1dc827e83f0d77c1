"""How much the mean force answers to a source of mass, wherever and whenever it is: one adjoint.

With J the Jacobian of the film equation for a mass perturbation w = δ(Hρ), an effect of source S
(J w = S) changes the mean pressure by ⟨w/(Hρ')⟩ = ⟨λ S⟩, where λ solves J* λ = 1/(Hρ') once for
all effects. J* is adjoint to J in the quadrature of the grid, and so is its preconditioner, the
inverse of D Δ − σ ∂/∂T.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

import numpy as np

from squeezefilm.reynolds.conformal_axis import Around
from squeezefilm.reynolds.effects.fields import Fields, Vector, along_t, along_x, along_y
from squeezefilm.reynolds.spectral import Axis

Operator = Callable[[np.ndarray], np.ndarray]
MOST_ITERATIONS = 200


def sensitivity(films: Fields, *, tolerance: float | np.ndarray) -> np.ndarray:
    """λ at the unknowns, shape (scenes, nx, ny, nt): the mean pressure's answer is ``answer``.

    Args:
        tolerance: preconditioned residual over its size at the start, one or one for each scene.
    """
    precondition, adjoint = _preconditioner(films, adjoint=True), _adjoint_jacobian(films)
    right = 1 / (films.gap * films.density_slope)[films.inner]
    return gmres(
        lambda values: precondition(adjoint(values)), precondition(right), tolerance=tolerance
    )


def answer(films: Fields, sensitive: np.ndarray, source: np.ndarray) -> np.ndarray:
    """Change of the mean pressure by a source on all nodes or at the unknowns, shape (scenes,)."""
    if source.shape != sensitive.shape:
        source = source[films.inner]
    return films.mean(films.with_rim(sensitive * source))


class Answers:
    """What sources do to the mean pressure, by λ; none is formed.

    Attributes:
        slope: of λ, by the adjoint of the grid's own divergence: the ``total`` of that times a flux
            is the answer to a source that is its divergence.
        rate: the answer to a source −∂stored/∂T is the ``total`` of that and what is stored.
        along: ``slope`` times ∇P.
    """

    def __init__(self, films: Fields, sensitive: np.ndarray) -> None:
        """Args: sensitive: λ at the unknowns."""
        weighted = films.with_rim(sensitive) * films.weights.reshape(films.gap.shape[1:])
        x, y = films.along_x.of_odd, films.along_y.of_odd / films.problems.aspect
        self.slope = Vector(along_x(x.T, weighted), along_y(y.T, weighted))
        self.rate = films.t_derivative(weighted)
        self.along = self.slope.dot(films.slope)


def total(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Sum of the product of two fields over all nodes, shape (scenes,)."""
    scenes = len(first)
    return np.asarray(first.reshape(scenes, 1, -1) @ second.reshape(scenes, -1, 1))[:, 0, 0]


def flow_of(films: Fields, rise: np.ndarray) -> np.ndarray:
    """∇·Σ c_k H^(3−k) ∇(ρ^(1−k) δP): the flow that a change of pressure makes, on all nodes."""
    flux = Vector(np.zeros_like(rise), np.zeros_like(rise))
    for k, factor in enumerate(films.flows):
        flux = flux.plus(films.gradient(films.density ** (1 - k) * rise).times(factor))
    return films.divergence(flux)


def curvature_of_flow(films: Fields, rise: np.ndarray) -> np.ndarray:
    """Second order of an isothermal film's flow in a change of pressure, on all nodes.

    ½ ∇·Σ c_k (1 − k) H^(3−k) ∇(ρ^(−k) δP²), as ρ = P.
    """
    flux = Vector(np.zeros_like(rise), np.zeros_like(rise))
    for k, factor in enumerate(films.flows):
        slope = films.gradient(films.density ** (-k) * rise**2)
        flux = flux.plus(slope.times((1 - k) / 2 * factor))
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
    grid, aspect = films.grid, films.problems.aspect
    x, y = films.along_x, films.along_y
    rows_x, rows_y = slice(1, grid.nx + 1), slice(1, grid.ny + 1)
    # Adjoints of gradient and divergence, each between unknowns and all nodes.
    to_x = _adjoint(x.of_odd[rows_x], x.weights[rows_x], x.weights)
    to_y = _adjoint(y.of_odd[rows_y], y.weights[rows_y], y.weights) / aspect
    from_x = _adjoint(x.of_even[:, rows_x], x.weights, x.weights[rows_x])
    from_y = _adjoint(y.of_even[:, rows_y], y.weights, y.weights[rows_y]) / aspect
    slide = _adjoint(x.of_even[rows_x, rows_x], x.weights[rows_x], x.weights[rows_x])
    speed = films.numbers("bearing", absent=0.0)
    terms = [
        (
            factor[:, :, rows_y],
            factor[:, rows_x],
            (films.density ** (1 - k) / (films.gap * films.density_slope))[films.inner],
        )
        for k, factor in enumerate(films.flows)
    ]

    def apply(values: np.ndarray) -> np.ndarray:
        slope_x, slope_y = along_x(to_x, values), along_y(to_y, values)
        result = films.sigma * films.t_derivative(values)
        for factor_x, factor_y, response in terms:
            result += response * (
                along_x(from_x, factor_x * slope_x) + along_y(from_y, factor_y * slope_y)
            )
        if np.any(speed):
            result -= speed * along_x(slide, values)
        return result

    return apply


def _preconditioner(films: Fields, *, adjoint: bool) -> Operator:
    """Inverse of D Δ − σ ∂/∂T by diagonalisation, or its adjoint; D is the mean diffusivity."""
    grid, aspect, kind = films.grid, films.problems.aspect, films.kind
    diffusivity = films.ease * films.density / films.density_slope
    strength = diffusivity[films.inner].mean(axis=(1, 2, 3), keepdims=True)
    values_x, to_x, from_x = (each.astype(kind) for each in _modes(grid.x, adjoint=adjoint))
    values_y, to_y, from_y = (each.astype(kind) for each in _modes(grid.y, adjoint=adjoint))
    to_t, from_t = (each.astype(kind) for each in _harmonics(grid.nt))
    symbol = strength * np.add.outer(values_x, values_y / aspect**2)[..., None]
    rate = films.sigma * np.arange(grid.nt // 2 + 1, dtype=kind)
    rate[..., -1] = 0  # as the sawtooth has no derivative on the nodes
    inverse = 1 / (symbol + (1j if adjoint else -1j) * rate)

    def apply(values: np.ndarray) -> np.ndarray:
        modal = along_y(to_y, along_x(to_x, along_t(to_t, values)))
        solved = (modal.view(inverse.dtype) * inverse).view(kind)
        return along_t(from_t, along_x(from_x, along_y(from_y, solved)))

    return apply


@lru_cache(maxsize=64)
def _harmonics(instants: int) -> tuple[np.ndarray, np.ndarray]:
    """The real FFT over a period and back as matrices, complex numbers as pairs: few instants ask
    for no more, and what acts along the other axes need not know of complex numbers.
    """
    to_t = np.fft.rfft(np.eye(instants)).view(float).T
    units = np.eye(instants + 2).view(complex)
    return to_t, np.fft.irfft(units, n=instants).T


@lru_cache(maxsize=64)
def _modes(axis: Axis | Around, *, adjoint: bool) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Eigenvalues, analysis and synthesis of the second derivative, or of its adjoint."""
    values, vectors, inverse = axis.modes
    if adjoint:
        ones = np.ones_like(values)
        vectors, inverse = (
            _adjoint(inverse, ones, axis.weights),
            _adjoint(vectors, axis.weights, ones),
        )
    return values, inverse, vectors


def _adjoint(matrix: np.ndarray, rows: np.ndarray, columns: np.ndarray) -> np.ndarray:
    """Adjoint of a matrix between spaces with such quadrature weights."""
    return np.asarray(matrix.T * rows / columns[:, None])


def gmres(apply: Operator, right: np.ndarray, *, tolerance: float | np.ndarray) -> np.ndarray:
    """Solve ``apply(x) = right`` for each scene, first axis, by GMRES without restart.

    A scene's answer does not depend on the others': it is that of the first iteration which is
    good enough for it, and NaN where none of MOST_ITERATIONS is.
    """
    scenes, shape = len(right), right.shape
    right, size = _finite(right.reshape(scenes, -1))
    basis = [_unit(right, size)]
    # The Hessenberg matrix, made triangular by a rotation for each iteration, and the goal with it.
    columns: list[np.ndarray] = []
    goal = [np.nan_to_num(size)]
    rotations: list[tuple[np.ndarray, np.ndarray]] = []
    steps = np.zeros(scenes, dtype=int)
    for step in range(1, MOST_ITERATIONS + 1):
        new, _ = _finite(apply(basis[-1].reshape(shape)).reshape(scenes, -1))
        column = np.zeros((step + 1, scenes))
        for k, known in enumerate(basis):  # modified Gram–Schmidt (Paige et al. 2006)
            share = total(known, new)
            new -= share[:, None] * known
            column[k] = share
        left = np.sqrt(total(new, new))
        column[step] = left
        for k, (cosine, sine) in enumerate(rotations):
            upper, lower = column[k].copy(), column[k + 1].copy()
            column[k], column[k + 1] = cosine * upper + sine * lower, cosine * lower - sine * upper
        length = np.hypot(column[-2], left)
        turn = np.where(length > 0, length, 1.0)
        cosine, sine = column[-2] / turn, left / turn
        rotations.append((cosine, sine))
        column[-2] = length
        columns.append(column[:-1])
        goal.append(-sine * goal[-1])
        goal[-2] = cosine * goal[-2]
        done = (steps == 0) & (np.abs(goal[-1]) <= tolerance * size)
        steps[done] = step
        if steps.all():
            break
        basis.append(_unit(new, left))
    return _combined(basis, columns, goal, steps).reshape(shape)


def _unit(values: np.ndarray, size: np.ndarray) -> np.ndarray:
    """Each scene's values over their size, in numbers of their own kind."""
    return values / np.where(size > 0, size, 1.0)[:, None].astype(values.dtype)


def _combined(
    basis: list[np.ndarray], columns: list[np.ndarray], goal: list[np.ndarray], steps: np.ndarray
) -> np.ndarray:
    """The sums of Krylov's vectors after so many steps of each scene; NaN after none."""
    shares: dict[int, np.ndarray] = {}
    for k in range(len(columns) - 1, -1, -1):
        left = goal[k] - sum(columns[later][k] * share for later, share in shares.items())
        pivot = columns[k][k]
        wanted = (steps > k) & (pivot != 0)
        shares[k] = np.where(wanted, left / np.where(wanted, pivot, 1.0), 0.0)
    kind = basis[0].dtype
    found = sum(share[:, None].astype(kind) * basis[k] for k, share in shares.items())
    return np.where(steps[:, None] > 0, found, np.nan)


def _finite(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Values with zeros for a scene that has some which are not finite, and each scene's size.

    The size of such a scene is NaN, so that nothing is ever good enough for it.
    """
    size = np.sqrt(total(values, values))
    if np.isfinite(size).all():
        return values, size
    return np.where(np.isfinite(size)[:, None], values, 0.0), size
