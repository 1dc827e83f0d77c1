"""How much the mean force answers to a source of mass, wherever and whenever it is: one adjoint.

With J the Jacobian of the film equation for a mass perturbation w = δ(Hρ), an effect of source S
(J w = S) changes the mean pressure by ⟨w/(Hρ')⟩ = ⟨λ S⟩, where λ solves J* λ = 1/(Hρ') once for
all effects. J* is adjoint to J in the quadrature of the grid, and so is its preconditioner, the
inverse of D Δ − σ ∂/∂T.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache, partial

import numpy as np

from squeezefilm.reynolds.effects.fields import Fields, Vector, along_t, along_x, along_y
from squeezefilm.reynolds.outlines.around import Around
from squeezefilm.reynolds.spectral import Axis

Operator = Callable[[np.ndarray], np.ndarray]
MOST_ITERATIONS = 200


def sensitivity(
    films: Fields, *, tolerance: float | np.ndarray, kind: type[np.floating] = np.float64
) -> np.ndarray:
    """λ at the unknowns, shape (scenes, nx, ny, nt): the mean pressure's answer is ``answer``.

    Args:
        tolerance: preconditioned residual over its size at the start, one or one for each scene.
        kind: of numbers that λ is found in.
    """
    precondition = _preconditioner(films, adjoint=True, kind=kind)
    adjoint = _adjoint_jacobian(films, kind=kind)
    right = (1 / (films.gap * films.density_slope)[films.inner]).astype(kind)
    return gmres(
        lambda values: precondition(adjoint(values)), precondition(right), tolerance=tolerance
    )


def answer(films: Fields, sensitive: np.ndarray, source: np.ndarray) -> np.ndarray:
    """Change of the mean pressure by a source on all nodes or at the unknowns, shape (scenes,)."""
    if source.shape != sensitive.shape:
        source = source[films.inner]
    return films.mean(films.with_rim(sensitive * source))


class Answers:
    """What sources do to the mean pressure, by λ.

    None is formed: slopes of λ, by the adjoint of the grid's own divergence, times its flux.
    """

    def __init__(self, films: Fields, sensitive: np.ndarray) -> None:
        """Args: sensitive: λ at the unknowns."""
        weighted = films.with_rim(sensitive) * films.weights.reshape(films.gap.shape[1:])
        x, y = films.along_x.of_odd, films.along_y.of_odd / films.problems.aspect
        self._slope = Vector(along_x(x.T, weighted), along_y(y.T, weighted))
        self._rate = films.t_derivative(weighted)

    def along(self, flux: Vector) -> np.ndarray:
        """The slopes of λ times a flux, on all nodes: of a source ∇·(factor · flux) the answer is
        ``total`` of that and the factor.
        """
        return self._slope.dot(flux)

    def to_stored(self, stored: np.ndarray) -> np.ndarray:
        """Change of the mean pressure by a source −∂stored/∂T, shape (scenes,)."""
        return total(self._rate, stored)


def total(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Sum of the product of two fields over all nodes, shape (scenes,)."""
    scenes = len(first)
    product = np.einsum("si,si->s", first.reshape(scenes, -1), second.reshape(scenes, -1))
    return np.asarray(product)


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


def _adjoint_jacobian(films: Fields, *, kind: type[np.floating]) -> Operator:
    """J* of J w = ∇·Σ c_k H^(3−k) ∇(ρ^(1−k) w/(Hρ')) − σ ∂w/∂T − Λ ∂w/∂X."""
    inner, grid = films.inner, films.grid
    x, y = films.along_x, films.along_y
    cast = partial(np.asarray, dtype=kind)
    aspect = films.problems.aspect
    rows_x, rows_y = slice(1, grid.nx + 1), slice(1, grid.ny + 1)
    # Adjoints of gradient and divergence, each between unknowns and all nodes.
    to_x = cast(_adjoint(x.of_odd[rows_x], x.weights[rows_x], x.weights))
    to_y = cast(_adjoint(y.of_odd[rows_y], y.weights[rows_y], y.weights) / aspect)
    from_x = cast(_adjoint(x.of_even[:, rows_x], x.weights, x.weights[rows_x]))
    from_y = cast(_adjoint(y.of_even[:, rows_y], y.weights, y.weights[rows_y]) / aspect)
    slide = cast(_adjoint(x.of_even[rows_x, rows_x], x.weights[rows_x], x.weights[rows_x]))
    rate = cast(grid.t.derivative)
    flow = films.problems.numbers["flow"]
    sigma, speed = cast(films.sigma), cast(films.numbers("bearing", absent=0.0))
    factors = [cast(films.number(c) * films.gap ** (3 - k)) for k, c in enumerate(flow.T)]
    factors_x, factors_y = (
        [factor[:, :, rows_y] for factor in factors],
        [factor[:, rows_x] for factor in factors],
    )
    responses = [
        cast((films.density ** (1 - k) / (films.gap * films.density_slope))[inner])
        for k in range(flow.shape[1])
    ]

    def apply(values: np.ndarray) -> np.ndarray:
        slope_x, slope_y = along_x(to_x, values), along_y(to_y, values)
        result = sigma * along_t(rate, values)
        for factor_x, factor_y, response in zip(factors_x, factors_y, responses, strict=True):
            result += response * (
                along_x(from_x, factor_x * slope_x) + along_y(from_y, factor_y * slope_y)
            )
        if np.any(speed):
            result -= speed * along_x(slide, values)
        return result

    return apply


def _preconditioner(
    films: Fields, *, adjoint: bool, kind: type[np.floating] = np.float64
) -> Operator:
    """Inverse of D Δ − σ ∂/∂T by diagonalisation, or its adjoint; D is the mean diffusivity."""
    grid, aspect = films.grid, films.problems.aspect
    diffusivity = films.flux_factor(films.problems.numbers["flow"]) / (
        films.gap * films.density_slope
    )
    strength = diffusivity[films.inner].mean(axis=(1, 2, 3), keepdims=True)
    values_x, to_x, from_x = _modes(grid.x, adjoint=adjoint, kind=kind)
    values_y, to_y, from_y = _modes(grid.y, adjoint=adjoint, kind=kind)
    to_t, from_t = (each.astype(kind) for each in _harmonics(grid.nt))
    symbol = strength * np.add.outer(values_x, values_y / aspect**2)[..., None]
    rate = films.sigma * np.arange(grid.nt // 2 + 1)
    rate[..., -1] = 0  # as the sawtooth has no derivative on the nodes
    inverse = 1 / (symbol + (1j if adjoint else -1j) * rate)
    inverse = inverse.astype(np.result_type(kind, np.complex64))

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


def _modes(
    axis: Axis | Around, *, adjoint: bool, kind: type[np.floating]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Eigenvalues, analysis and synthesis of the second derivative, or of its adjoint."""
    values, vectors, inverse = axis.modes
    if adjoint:
        ones = np.ones_like(values)
        vectors, inverse = (
            _adjoint(inverse, ones, axis.weights),
            _adjoint(vectors, axis.weights, ones),
        )
    return values, inverse.astype(kind), vectors.astype(kind)


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
            new = new - share[:, None] * known
            column[k] = share
        left = np.linalg.norm(new, axis=1)
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
    found = sum(share[:, None] * basis[k] for k, share in shares.items())
    return np.where(steps[:, None] > 0, found, np.nan)


def _finite(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Values with zeros for a scene that has some which are not finite, and each scene's size.

    The size of such a scene is NaN, so that nothing is ever good enough for it.
    """
    size = np.linalg.norm(values, axis=1)
    return np.where(np.isfinite(size)[:, None], values, 0.0), size
