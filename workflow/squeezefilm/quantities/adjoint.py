"""Periodic states as fields on the host, and how the mean force answers to any source of mass.

With J the Jacobian of the film equation for a mass perturbation w = δ(Hρ), an effect of source S
(J w = S) changes the mean pressure by ⟨w/(Hρ')⟩ = ⟨λ S⟩, where λ solves J* λ = 1/(Hρ') once for
all effects. J* is adjoint to J in the quadrature of the grid, and so is its preconditioner, the
inverse of D Δ − σ ∂/∂T.
"""

from collections import defaultdict
from collections.abc import Callable, Iterator, Sequence
from functools import cached_property, lru_cache
from typing import Any

import numpy as np

from squeezefilm.film.scene import Scene
from squeezefilm.reynolds.device import Device
from squeezefilm.reynolds.error_estimate import UNKNOWN_FALL, least_fall_of, left_after, margin_of
from squeezefilm.reynolds.grid import Grid
from squeezefilm.reynolds.needs import needs_of
from squeezefilm.reynolds.periodic.resolution import least_fall, profile_fall
from squeezefilm.reynolds.problems import Problems, problems_of
from squeezefilm.reynolds.solver import solve
from squeezefilm.reynolds.spectral import Around, Axis, even_and_odd
from squeezefilm.reynolds.terms import terms_of
from squeezefilm.reynolds.terms.rarefaction import (
    flow_over_viscous,
    slip_flow,
    slip_growth,
    slip_of,
)
from squeezefilm.solution import Solution

Operator = Callable[[np.ndarray], np.ndarray]
# Of a product: a field, or what multiplies by a matrix along an axis, and the matrix.
Factor = np.ndarray | tuple[Callable[[np.ndarray, np.ndarray], np.ndarray], np.ndarray]
MOST_ITERATIONS = 200


class AxisWithRim:
    """One axis with its rim nodes, if it ends there: derivatives and the mean over it.

    A folded axis holds one rim node and the first half of the others, on which a function even
    about the middle has an odd derivative and an odd one an even.

    Attributes:
        of_even, of_odd: first derivative of such functions, shape (m, m), m nodes with the rim;
            the same on an axis that is not folded.
        weights: of the integral of an even function, shape (m,), rim included.
    """

    def __init__(self, axis: Axis | Around) -> None:
        if isinstance(axis, Around):
            self.of_even, self.of_odd = axis.slope(odd=False), axis.slope(odd=True)
            self.weights = axis.weights
            return
        rim = 1 - axis.weights.sum()  # a constant's integral is that constant
        if axis.folded:
            self.of_even, self.of_odd = even_and_odd(axis.derivative)
            self.weights = np.append(rim, axis.weights)
        else:
            self.of_even = self.of_odd = axis.derivative
            self.weights = np.concatenate([[rim / 2], axis.weights, [rim / 2]])


with_rim = lru_cache(maxsize=64)(AxisWithRim)


class Fields:
    """Films of like terms on one grid, each with its gap H, pressure P and density ρ.

    Lengths in units of the pad's x side, time of 1/ω, pressure and density of ambient ones. Under
    an outline vectors are along its coordinates, times |dz/dζ|, and sources of mass times J, both
    over the typical (terms/outline.py).

    Every field has the shape (scenes, x, y, t), rim nodes included, a vector field (2, scenes, x,
    y, t). Numbers of scenes come as columns, to go with fields: ``number``.
    """

    def __init__(self, problems: Problems, grid: Grid, overpressure: np.ndarray) -> None:
        """Args: overpressure: P − 1 at the unknowns, shape (scenes, nx, ny, nt)."""
        self.problems, self.grid = problems, grid
        self.lengths = grid.lengths(problems.aspect)
        self.along_x, self.along_y = with_rim(grid.x), with_rim(grid.y)
        self.inner = (slice(None), grid.x.inner, grid.y.inner)
        across = grid.x.all_nodes[: len(self.along_x.weights)]
        self.area, self.turn, self.bend = (
            np.asarray(of(across))[..., None] for of in (grid.area, grid.turn, grid.bend)
        )
        seen = (..., slice(len(self.along_x.weights)), slice(len(self.along_y.weights)), None)
        parts = problems.parts[problems.places].swapaxes(0, 1)[seen]
        rest = 1 + self.numbers("per_rise", absent=0.0) * sum(parts[2:])
        moving = self.number(problems.numbers["epsilon"]) * parts[:2]
        sine, cosine = np.sin(grid.t.nodes), np.cos(grid.t.nodes)
        self.gap = rest + sum(map(np.multiply, moving, (sine, cosine)))
        self.gap_rate = sum(map(np.multiply, moving, (cosine, -sine)))
        self.overpressure = self.on_all_nodes(overpressure)

    def number(self, values: np.ndarray) -> np.ndarray:
        """One number of each scene, to go with fields."""
        return np.asarray(values, dtype=float)[:, None, None, None]

    def numbers(self, name: str, *, absent: float) -> np.ndarray:
        """A number that a term gives the scenes, or what it is without the term."""
        table = self.problems.numbers
        known = name in (table.dtype.names or ())
        return self.number(table[name] if known else np.full(len(table), absent))

    def on_all_nodes(self, values: np.ndarray) -> np.ndarray:
        """Values at the unknowns with zeros on the rim."""
        found = np.zeros(self.gap.shape)
        found[self.inner] = values
        return found

    @cached_property
    def sigma(self) -> np.ndarray:
        return self.number(self.problems.numbers["sigma"])

    @cached_property
    def density(self) -> np.ndarray:
        exponent, pressure = self.numbers("inverse_exponent", absent=1.0), 1 + self.overpressure
        return pressure if np.all(exponent == 1) else np.asarray(pressure**exponent)

    @cached_property
    def density_slope(self) -> np.ndarray:
        """dρ/dP."""
        exponent = self.numbers("inverse_exponent", absent=1.0)
        return np.asarray(exponent * self.density / (1 + self.overpressure))

    @cached_property
    def mass(self) -> np.ndarray:
        """Hρ, the mass of gas per area."""
        return np.asarray(self.gap * self.density)

    @cached_property
    def pressure_rate(self) -> np.ndarray:
        """∂P/∂T."""
        return self.t_derivative(self.overpressure)

    @cached_property
    def slope(self) -> np.ndarray:
        """∇P."""
        return self.gradient(self.overpressure)

    @cached_property
    def velocity(self) -> np.ndarray:
        """Mean velocity over the gap by pressure alone, ū = −(1/σ) ``mobility`` ∇P."""
        return self.slope * (self.mobility * (-1 / self.sigma))

    @cached_property
    def mobility(self) -> np.ndarray:
        """H² W, by which a slope of pressure drives gas: W is the flow over a viscous gas'."""
        return np.asarray(flow_over_viscous(self.problems.numbers, self.mass) * self.gap**2)

    @cached_property
    def flow_terms(self) -> list[tuple[np.ndarray, np.ndarray, np.ndarray | float]]:
        """c_k H^(3−k), dg_k/dP and d²g_k/dP² of each term of the flux Σ c_k H^(3−k) ∇g_k.

        They are the terms of film_over_period.cl, the second derivative that of an isothermal gas.
        """
        square = self.gap**2
        cube = self.gap * square
        if self.problems.numbers["flow"].shape[1] == 1:
            return [(cube, self.density, 1.0)]
        slip, inverse = slip_of(self.problems.numbers, self.mass)
        if inverse is None:
            return [(cube, self.density, 1.0), (slip * square, np.ones_like(square), 0.0)]
        over_gap, flow, (growth, bend) = slip / self.gap, slip_flow(inverse), slip_growth(inverse)
        return [
            (cube, self.density + over_gap * growth, 1 + over_gap / self.density * bend),
            (slip * square, flow - growth, (growth - bend) / self.density),
        ]

    def x_derivative(self, values: np.ndarray, *, odd: bool = False) -> np.ndarray:
        """∂/∂X of a field that is even in x, or odd, wherever the axis is folded."""
        matrix = self.along_x.of_odd if odd else self.along_x.of_even
        return along_x(matrix / self.lengths[0], values)

    def y_derivative(self, values: np.ndarray, *, odd: bool = False) -> np.ndarray:
        matrix = self.along_y.of_odd if odd else self.along_y.of_even
        return along_y(matrix / self.lengths[1], values)

    def slide(self, values: np.ndarray) -> np.ndarray:
        """∂/∂X along the pad's own x axis."""
        if self.grid.outline is None:
            return self.x_derivative(values)
        return self.turn.real * self.x_derivative(values) - self.turn.imag * self.y_derivative(
            values
        )

    def t_derivative(self, values: np.ndarray) -> np.ndarray:
        return along_t(self.grid.t.derivative, values)

    def gradient(self, values: np.ndarray) -> np.ndarray:
        return np.stack([self.x_derivative(values), self.y_derivative(values)])

    def divergence(self, flux: np.ndarray) -> np.ndarray:
        return self.x_derivative(flux[0], odd=True) + self.y_derivative(flux[1], odd=True)

    def carried(self, v: np.ndarray) -> np.ndarray:
        """(v·∇)v of a velocity (terms/inertia.py)."""
        along = self.x_derivative(v[0], odd=True), self.x_derivative(v[1])
        across = self.y_derivative(v[0]), self.y_derivative(v[1], odd=True)
        bends = -self.bend.real, self.bend.imag
        square = dot(v, v) if self.grid.outline else 0.0
        parts = zip(along, across, bends, strict=True)
        return np.stack([v[0] * x + v[1] * y + bend * square for x, y, bend in parts]) / self.area

    def mean(self, values: np.ndarray) -> np.ndarray:
        """Mean over film and period, shape (scenes,)."""
        return np.einsum("si,i->s", values.reshape(len(values), -1), self.weights)

    @cached_property
    def weights(self) -> np.ndarray:
        """Return the weights of the mean over film and period, (nodes · times,) in sequence."""
        return np.ravel(self.plain_weights * (self.area * self.grid.mean_area))

    @cached_property
    def plain_weights(self) -> np.ndarray:
        """Weights of the mean over the coordinates, (x, y, t)."""
        area = np.outer(self.along_x.weights, self.along_y.weights)
        return np.repeat(area[..., None] / self.grid.nt, self.grid.nt, axis=2)


def dot(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Product of two vector fields."""
    return np.asarray(one[0] * other[0] + one[1] * other[1])


def along_x(matrix: np.ndarray, values: np.ndarray) -> np.ndarray:
    """A matrix (m, n) along the first axis of fields (scenes, n, y, t)."""
    scenes, nodes = values.shape[:2]
    product = matrix @ values.reshape(scenes, nodes, -1)
    return np.asarray(product.reshape(scenes, len(matrix), *values.shape[2:]))


def along_y(matrix: np.ndarray, values: np.ndarray) -> np.ndarray:
    """A matrix (m, n) along the second axis of fields (scenes, x, n, t)."""
    return np.asarray(matrix @ values)


def along_t(matrix: np.ndarray, values: np.ndarray) -> np.ndarray:
    """A matrix (m, n) along the last axis of fields (scenes, x, y, n)."""
    product = values.reshape(len(values), -1, values.shape[-1]) @ matrix.T
    return np.asarray(product.reshape(*values.shape[:-1], len(matrix)))


def total(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Sum of the product of two fields over all nodes, shape (scenes,)."""
    scenes = len(first)
    return np.asarray(first.reshape(scenes, 1, -1) @ second.reshape(scenes, -1, 1))[:, 0, 0]


UNSOLVED = Solution(status="", method="periodic")


def with_states(
    scenes: Sequence[Scene],
    solutions: Sequence[Solution] | None = None,
    *,
    tolerance: float,
    device: Device | None,
) -> list[Solution]:
    """Solutions with their states; those without are solved for, by the periodic method."""
    found = list(solutions or [UNSOLVED] * len(scenes))
    missing = [k for k, solution in enumerate(found) if not solution.states]
    more = solve(
        [scenes[k] for k in missing],
        tolerance=tolerance,
        method="periodic",
        device=device,
        keep_states=True,
    )
    for k, solution in zip(missing, more, strict=True):
        found[k] = solution
    return found


# Scenes with their solutions and states, by the scenes' places.
Solved = dict[int, tuple[Scene, Solution]]


def alike(solved: Solved, *, numbers: int) -> Iterator[Solved]:
    """Scenes whose states are on the same grids, of like terms and pads.

    Args:
        numbers: of the finer states of a group; more would fall out of the caches.
    """
    groups: dict[tuple[Any, ...], list[int]] = defaultdict(list)
    for k, (scene, solution) in solved.items():
        grids = tuple(state.grid for state in solution.states)
        groups[grids, terms_of(scene), scene.aspect].append(k)
    for (grids, *_), group in groups.items():
        step = max(1, numbers // grids[-1].count)
        for first in range(0, len(group), step):
            yield {k: solved[k] for k in group[first : first + step]}


def fields_of(scenes: Sequence[Scene], solutions: Sequence[Solution], *, grid: int = -1) -> Fields:
    """The films of ``alike`` scenes, by default on the finer grid."""
    states = [solution.states[grid] for solution in solutions]
    problems = problems_of(scenes, states[0].grid)
    return Fields(problems, states[0].grid, np.stack([each.unknowns[0] for each in states]))


def remainder(scene: Scene, solution: Solution, *, tolerance: float) -> tuple[float, float]:
    """Return the error after a quantity's change between the grids, as for the force.

    Returns:
        The error in units of that change, and what the iteration left of the pressure, in p0.
    """
    needs, (coarse, fine) = needs_of(scene), (state.grid.across for state in solution.states)
    fall = max(
        UNKNOWN_FALL,
        profile_fall(needs, coarse, fine, tolerance=tolerance).item(),
        least_fall_of(needs.terms),
        least_fall(needs.scenes, coarse[0]).item(),
    )
    # A mass error w moves the pressure by about n w/H.
    left = scene.gas.polytropic_exponent * solution.residual / scene.narrowest
    return margin_of(needs.terms) * float(left_after(fall)), left


def sensitivity(films: Fields, *, tolerance: float | np.ndarray) -> np.ndarray:
    """λ at the unknowns, shape (scenes, nx, ny, nt): what S does is the mean of λ S.

    The mean is that over the coordinates, and S times J under an outline.

    Args:
        tolerance: preconditioned residual over its size at the start, one or one for each scene.
    """
    precondition, jacobian = _preconditioner(films, adjoint=True), _jacobian(films, adjoint=True)
    # The transpose is adjoint in plain sums; by the quadrature's weights in its integrals.
    inner = films.inner[1:]
    weights, area = films.plain_weights[inner], films.weights.reshape(films.gap.shape[1:])[inner]
    right = precondition(area / (films.gap * films.density_slope)[films.inner]) / weights
    return gmres(
        lambda values: precondition(jacobian(weights * values)) / weights,
        right,
        tolerance=tolerance,
    )


def response(films: Fields, source: np.ndarray, *, tolerance: float) -> np.ndarray:
    """w of J w = ``source``, all at the unknowns, shape (scenes, nx, ny, nt)."""
    precondition, jacobian = _preconditioner(films), _jacobian(films)
    return gmres(
        lambda values: precondition(jacobian(values)), precondition(source), tolerance=tolerance
    )


def _jacobian(films: Fields, *, adjoint: bool = False) -> Operator:
    """J w = ∇·Σ c_k H^(3−k) ∇(dg_k/dP w/(Hρ')) − σ ∂w/∂T − Λ ∂w/∂X, or its transpose.

    A sum of products whose factors are fields and matrices along an axis; transposed, a product's
    factors are transposed and stand in the opposite order.
    """
    x, y, (_, rows_x, rows_y) = films.along_x, films.along_y, films.inner
    length_x, length_y = films.lengths
    outline = films.grid.outline is not None
    stored = films.sigma * (films.area[rows_x] if outline else 1.0)
    products: list[list[Factor]] = [[-stored, (along_t, films.grid.t.derivative)]]
    speed = films.numbers("bearing", absent=0.0)
    if np.any(speed):
        turn = films.turn[rows_x]
        share = speed * turn.real if outline else speed
        products.append([-share, (along_x, x.of_even[rows_x, rows_x] / length_x)])
        if outline:
            products.append([speed * turn.imag, (along_y, y.of_even[rows_y, rows_y] / length_y)])
    # Between unknowns and all nodes: gradient and divergence along each axis.
    for factor, rise, _ in films.flow_terms:
        change = (rise / (films.gap * films.density_slope))[films.inner]
        for along, axis, rows, length, part in (
            (along_x, x, rows_x, length_x, factor[:, :, rows_y]),
            (along_y, y, rows_y, length_y, factor[:, rows_x]),
        ):
            slope, out = axis.of_even[:, rows] / length, axis.of_odd[rows] / length
            products.append([(along, out), part, (along, slope), change])
    if adjoint:
        products = [[_transposed(each) for each in reversed(product)] for product in products]

    def apply(values: np.ndarray) -> np.ndarray:
        result = np.zeros_like(values)
        for product in products:
            part = values
            for factor in reversed(product):
                part = factor[0](factor[1], part) if isinstance(factor, tuple) else factor * part
            result += part
        return result

    return apply


def _transposed(factor: Factor) -> Factor:
    return (factor[0], factor[1].T) if isinstance(factor, tuple) else factor


def _preconditioner(films: Fields, *, adjoint: bool = False) -> Operator:
    """Inverse of D Δ − σ ∂/∂T by diagonalisation, or its transpose; D is the mean diffusivity."""
    grid = films.grid
    diffusivity = films.mobility * films.density / films.density_slope
    strength = diffusivity[films.inner].mean(axis=(1, 2, 3), keepdims=True)
    (values_x, from_x, to_x), (values_y, from_y, to_y) = grid.x.modes, grid.y.modes
    if adjoint:
        from_x, to_x, from_y, to_y = to_x.T, from_x.T, to_y.T, from_y.T
    length_x, length_y = films.lengths
    symbol = strength * np.add.outer(values_x / length_x**2, values_y / length_y**2)[..., None]
    rate = films.sigma * np.arange(grid.nt // 2 + 1)
    rate[..., -1] = 0  # as the sawtooth has no derivative on the nodes
    inverse = 1 / (symbol + (1j if adjoint else -1j) * rate)

    def apply(values: np.ndarray) -> np.ndarray:
        modal = inverse * np.fft.rfft(along_y(to_y, along_x(to_x, values)))
        return along_x(from_x, along_y(from_y, np.fft.irfft(modal, n=grid.nt)))

    return apply


def gmres(apply: Operator, right: np.ndarray, *, tolerance: float | np.ndarray) -> np.ndarray:
    """Solve ``apply(x) = right`` for each scene, first axis, by GMRES without restart.

    A scene's answer does not depend on the others': it is that of the first iteration which is
    good enough for it, and NaN where none of MOST_ITERATIONS is.
    """
    scenes, shape = len(right), right.shape
    right = right.reshape(scenes, -1)
    size = np.sqrt(total(right, right))
    allowed = np.broadcast_to(tolerance * size, scenes)
    found = np.where(size[:, None] == 0, 0.0, np.full_like(right, np.nan))
    waiting = np.isfinite(size) & (size > 0)
    basis = [_unit(right, size, waiting)]
    hessenberg = np.zeros((scenes, 1, 0))
    for step in range(1, MOST_ITERATIONS + 1):
        if not waiting.any():
            break
        new = apply(basis[-1].reshape(shape)).reshape(scenes, -1)
        hessenberg = np.pad(hessenberg, ((0, 0), (0, 1), (0, 1)))
        for k, known in enumerate(basis):  # modified Gram–Schmidt (Paige et al. 2006)
            hessenberg[:, k, -1] = part = total(known, new)
            new -= part[:, None] * known
        hessenberg[:, step, -1] = left = np.sqrt(total(new, new))
        waiting &= np.isfinite(left)
        q, r = np.linalg.qr(hessenberg, mode="complete")
        goal = size[:, None] * q[:, 0]
        done = np.flatnonzero(waiting & (np.abs(goal[:, step]) <= allowed))
        if done.size:
            shares = np.linalg.solve(r[done, :step], goal[done, :step, None])[..., 0]
            found[done] = sum(shares[:, k, None] * basis[k][done] for k in range(step))
            waiting[done] = False
        basis.append(_unit(new, left, waiting))
    return found.reshape(shape)


def _unit(values: np.ndarray, size: np.ndarray, waiting: np.ndarray) -> np.ndarray:
    """Values over their sizes; zeros for scenes that wait no more, or are not finite."""
    scale = np.where(waiting & (size > 0), 1 / np.where(size > 0, size, 1.0), 0.0)
    return np.where(waiting[:, None], values * scale[:, None], 0.0)
