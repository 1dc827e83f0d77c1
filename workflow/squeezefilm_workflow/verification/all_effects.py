"""A film with all effects solved for together: inertia, thermal effects, slip, flow at the edge.

It shares with the solver the equations (squeezefilm/reynolds/terms: inertia, thermal), the law at
the edge (squeezefilm/quantities/edge_effects.py) and nothing else: pressure, velocities and warming
at collocation points in space, at all instants together.
Derivatives are dense matrices, so that a disc's radius, a rectangle and an ellipse are sets of
points (``points_of_scene``). At the edge

    P = 1 + σ (h0/l) [R u/H + L ∂(H u)/∂T] − C (σ Re/24) u²,

with the mean velocity u outward, the last term only where it is inward, and the resistance R and
the inertance L of flow around the edge; gas that comes in has no velocity along the edge.
Newton's steps are solved by GMRES, whose matrix is differentiated by complex steps, after one
system in space for each harmonic.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from math import pi, sqrt
from typing import Literal, Self

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.linalg import lu_factor, lu_solve
from scipy.sparse.linalg import LinearOperator, gmres

from squeezefilm.film.scene import Scene
from squeezefilm.quantities.edge_effects import EDGE_RESISTANCE, edge_inertance
from squeezefilm.reynolds.terms.rarefaction import FLOW_TABLE_PATH
from squeezefilm_workflow.verification.marching import FloatArray, film_symmetry_in_x_and_y
from squeezefilm_workflow.verification.numpy_periodic import chebyshev_grid

COMPLEX_STEP, MAX_NEWTON_STEPS, CONVERGED_PRESSURE_CHANGE = 1e-30, 40, 1e-9
MAX_KRYLOV_ITERATIONS, KRYLOV_TOLERANCE = 300, 1e-3
# Most that a Newton step changes of a pressure, in p0.
MAX_PRESSURE_STEP = 0.4
# Twice the points along a disc's radius; points across another film that is even about no axis,
# one or two; instants in a period (odd).
DIAMETER_POINT_COUNT, POINT_COUNTS, INSTANT_COUNT = 64, (24, 28, 36), 21
# Share of the points on the coarser grid, that of the error estimate.
COARSER_GRID_RATIO = 0.8
# Velocity at the edge, over ε/√σ, within which gas neither comes in nor goes out.
FLOW_REVERSAL_VELOCITY = 0.1


@dataclass(frozen=True)
class Points:
    """Collocation points of a pad, lengths by its length along x.

    Attributes:
        x, y: position across the pad in [0, 1], (points,).
        weights: of a mean over the pad, (points,).
        gradient_matrices, divergence_matrices: a matrix for each component of a vector.
        velocity_slope_matrices: of each component of a velocity the derivatives along all axes.
        outward_normals: outward at the edge, 0 inside, (components, points).
        corner_mask: where two sides meet.
    """

    x: FloatArray
    y: FloatArray
    weights: FloatArray
    gradient_matrices: tuple[FloatArray, ...]
    divergence_matrices: tuple[FloatArray, ...]
    velocity_slope_matrices: tuple[tuple[FloatArray, ...], ...]
    outward_normals: FloatArray
    corner_mask: np.ndarray

    @property
    def edge_mask(self) -> np.ndarray:
        return np.any(self.outward_normals != 0, axis=0)


def points_of_scene(scene: Scene, count: int) -> Points:
    """Return points for a pad, of an even film those of one half; along the radius of a disc.

    Args:
        count: even, points across the pad, or twice those along a radius.
    """
    if is_axisymmetric(scene):
        return _disc_radius_points(count)
    of_shape = {"rectangle": _rectangle_points, "ellipse": _ellipse_points}[scene.pad.shape]
    return _points_folded_by_symmetry(
        of_shape(scene.aspect, count), *film_symmetry_in_x_and_y(scene)
    )


def is_axisymmetric(scene: Scene) -> bool:
    """Return whether a pad is a disc above a gap that depends on the radius alone."""
    if scene.pad.shape != "ellipse" or scene.aspect != 1 or scene.bearing_number:
        return False
    angle, phase = 0.3 + np.arange(7.0), np.array([0.5, 2.0])
    radius = np.array([[0.15], [0.3], [0.5]])
    gap = scene.gap(0.5 + radius * np.cos(angle), 0.5 + radius * np.sin(angle), phase)
    return bool(np.ptp(gap, axis=1).max() < 1e-12)


def _chebyshev_line_rule(count: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Points from −1/2 to 1/2, the matrix of the derivative, and weights."""
    grid = chebyshev_grid(count - 2)
    return grid.x - 0.5, grid.derivative_matrix, grid.weights


def _disc_radius_points(count: int) -> Points:
    x, first, _ = _chebyshev_line_rule(count)
    half = count // 2
    same, other = first[half:, half:], first[half:, half - 1 :: -1]
    r, even, odd = x[half:], same + other, same - other
    on_edge = (np.arange(half) == half - 1).astype(float)
    # r is no polynomial over a whole diameter: its mean is taken at points along a radius.
    along, _, weights = _chebyshev_line_rule(2 * count)
    finer = (along + 0.5) / 2
    over_disc = (4 * finer * weights) @ _interpolation_matrix(x, finer)
    return Points(
        r + 0.5,
        np.full(half, 0.5),
        over_disc[half:] + over_disc[half - 1 :: -1],
        (even,),
        (odd + np.diag(1 / r),),
        ((odd,),),
        on_edge[None],
        np.zeros(half, dtype=bool),
    )


def _interpolation_matrix(nodes: FloatArray, points: FloatArray) -> FloatArray:
    """Matrix from values at Chebyshev points to values elsewhere."""
    degree = np.arange(len(nodes))

    def chebyshev_polynomials(x: FloatArray) -> FloatArray:
        return np.cos(degree * np.arccos(np.clip(2 * x[:, None], -1, 1)))

    return np.asarray(
        np.linalg.solve(chebyshev_polynomials(nodes).T, chebyshev_polynomials(points).T).T
    )


def _rectangle_points(aspect: float, count: int) -> Points:
    x, first, weights = _chebyshev_line_rule(count)
    one = np.eye(count)
    along: tuple[FloatArray, ...] = (
        np.asarray(np.kron(first, one)),
        np.asarray(np.kron(one, first) / aspect),
    )
    on_x, on_y = (coordinate.ravel() for coordinate in np.meshgrid(x, x, indexing="ij"))
    normal = np.stack(
        [np.sign(coordinate) * (abs(coordinate) == 0.5) for coordinate in (on_x, on_y)]
    )
    corner = np.all(normal != 0, axis=0)
    area = np.outer(weights, weights).ravel()
    return Points(on_x + 0.5, on_y + 0.5, area, along, along, (along, along), normal, corner)


def _ellipse_points(aspect: float, count: int) -> Points:
    """Points on half of as many radii as instants of a turn, through the centre."""
    x, first, _ = _chebyshev_line_rule(count)
    half, turns = count // 2, 4 * (count // 4)
    r = np.repeat(x[half:], turns)
    angle = np.tile(2 * pi * (np.arange(turns) + 0.5) / turns, half)
    opposite = np.roll(np.eye(turns), turns // 2, axis=1)
    outwards = np.kron(first[half:, half:], np.eye(turns))
    outwards += np.kron(first[half:, half - 1 :: -1], opposite)
    around = np.kron(np.eye(half), _time_derivative_matrix(turns).T) / r[:, None]
    cosine, sine = np.cos(angle)[:, None], np.sin(angle)[:, None]
    along = (
        np.asarray(cosine * outwards - sine * around),
        np.asarray((sine * outwards + cosine * around) / aspect),
    )
    radial = _disc_radius_points(count).weights
    normal = np.stack([np.cos(angle), np.sin(angle) / aspect]) * (r == 0.5)
    normal /= np.maximum(np.hypot(*normal), 1e-300)
    on_x, on_y = 0.5 + r * np.cos(angle), 0.5 + r * np.sin(angle)
    weights = np.repeat(radial, turns) / turns
    corner = np.zeros(len(r), dtype=bool)
    return Points(on_x, on_y, weights, along, along, (along, along), normal, corner)


def _points_folded_by_symmetry(points: Points, even_x: bool, even_y: bool) -> Points:
    """Return the points of one half along each axis about which a film is even."""
    from_centre, even = np.stack([points.x, points.y]) - 0.5, np.array([[even_x], [even_y]])
    kept = np.flatnonzero(np.all(~even | (from_centre > 0), axis=0))
    mirrored = np.where(even, abs(from_centre), from_centre)
    distance = np.abs(mirrored[:, :, None] - from_centre[:, None, kept]).sum(axis=0)
    values = (distance < 1e-9).astype(float)  # of an even field
    # A component of a vector is odd along its own axis.
    odd = np.where(even & (from_centre < 0), -1.0, 1.0)[:, :, None] * values
    axes = points.gradient_matrices
    return Points(
        *(points.x[kept], points.y[kept], points.weights @ values),
        tuple(along[kept] @ values for along in axes),
        tuple(along[kept] @ of for along, of in zip(axes, odd, strict=True)),
        tuple(tuple(along[kept] @ of for along in axes) for of in odd),
        *(points.outward_normals[:, kept], points.corner_mask[kept]),
    )


def _time_derivative_matrix(instants: int) -> FloatArray:
    """Return the matrix by which values over a turn are multiplied for their derivative."""
    waves = np.fft.rfft(np.eye(instants))
    order = 1j * np.arange(waves.shape[1])
    if instants % 2 == 0:
        order[-1] = 0
    return np.asarray(np.fft.irfft(order * waves, n=instants))


@cache
def _rarefied_excess_flow() -> CubicSpline:
    """Return what rarefaction adds to the flow Q, D/6 of a viscous gas, by ln D."""
    inverse, flow = np.loadtxt(FLOW_TABLE_PATH, delimiter=",", skiprows=1, unpack=True)
    return CubicSpline(np.log(inverse), flow - inverse / 6)


def _matrix_times_field(matrix: FloatArray, field: np.ndarray) -> np.ndarray:
    """Return a real matrix times a real or complex field."""
    if not np.iscomplexobj(field):
        return matrix @ field
    parts = np.ascontiguousarray(field).view(float)
    return np.asarray((matrix @ parts).view(complex))


@dataclass(frozen=True)
class Effects:
    """The effects that a film is solved with.

    Attributes:
        slip: none, that of first order by the gas' own coefficient, or by the flow factor, a
            table of the linearised Boltzmann equation (rarefied_flow.py).
        edge_loss_coefficient: C of the loss at the edge where gas comes in; 0 without.
        edge_flow: with flow around the edge.
    """

    inertia: bool = True
    thermal: bool = True
    slip: Literal["none", "first-order", "flow-factor"] = "flow-factor"
    edge_loss_coefficient: float = 0.0
    edge_flow: bool = False

    @classmethod
    def of_scene(cls, scene: Scene) -> Self:
        """The effects that the solver's equation has for a scene without a flow factor."""
        gas = scene.gas
        return cls(
            inertia=gas.inertia == "included",
            thermal=gas.thermal == "included",
            slip="first-order" if gas.rarefaction == "slip" else "none",
        )


@dataclass(frozen=True)
class FilmOnPoints:
    """A scene on one grid, states of shape (1 + components + 1, points, instants).

    A state is P − 1, the mean velocities over l0 ω, and the warming by compression.
    """

    scene: Scene
    effects: Effects
    points: Points
    instant_count: int

    @cached_property
    def gap(self) -> FloatArray:
        phase = 2 * pi * np.arange(self.instant_count) / self.instant_count
        return self.scene.gap(self.points.x, self.points.y, phase)

    @cached_property
    def time_derivative_matrix(self) -> FloatArray:
        return _time_derivative_matrix(self.instant_count)

    @cached_property
    def equation_numbers(self) -> dict[str, float]:
        scene, gas, effects = self.scene, self.scene.gas, self.effects
        reynolds, ratio = scene.modified_reynolds, gas.heat_capacity_ratio
        conduction = gas.prandtl * reynolds * effects.thermal
        return {
            "lag": reynolds / 10 * effects.inertia,
            "slip": float(self.slip_length(np.ones(1))[0]),
            "heating": (1 - 1 / ratio) * conduction,
            "thermal_lag": conduction / 10,
            "jump": 2
            * ratio
            / ((ratio + 1) * gas.prandtl)
            * scene.knudsen
            * (effects.slip != "none"),
            **self._edge_flow_numbers(),
            "loss": effects.edge_loss_coefficient * reynolds * scene.sigma / 24,
            "reversing": FLOW_REVERSAL_VELOCITY
            * max(scene.epsilon, 1e-9)
            / sqrt(max(scene.sigma, 16.0)),
        }

    def _edge_flow_numbers(self) -> dict[str, float]:
        scene = self.scene
        per_velocity = scene.sigma * scene.h0_m / scene.pad.length_x_m * self.effects.edge_flow
        inertance = scene.modified_reynolds * float(edge_inertance(scene))
        return {"resistance": per_velocity * EDGE_RESISTANCE, "inertance": per_velocity * inertance}

    def slip_length(self, mass: np.ndarray) -> np.ndarray:
        """Return the slip length times the density over h0, for P H."""
        knudsen, slip = self.scene.knudsen, self.effects.slip
        if slip != "flow-factor":
            length = self.scene.gas.slip_coefficient * knudsen if slip == "first-order" else 0.0
            return np.full(mass.shape, length)
        inverse = self.scene.inverse_knudsen
        flow, logarithm = _rarefied_excess_flow(), np.log(inverse * mass.real)
        length = flow(logarithm)
        if np.iscomplexobj(mass):  # a complex step
            length = length + 1j * flow(logarithm, 1) * mass.imag / mass.real
        return np.asarray(length / inverse)

    def time_derivative(self, field: np.ndarray) -> np.ndarray:
        if np.iscomplexobj(field):
            return np.asarray(
                field.real @ self.time_derivative_matrix
                + 1j * (field.imag @ self.time_derivative_matrix)
            )
        return np.asarray(field @ self.time_derivative_matrix)

    def residual(self, state: np.ndarray) -> np.ndarray:
        """Return the residuals of mass, momentum and energy, of the shape of the state."""
        at, n, gap, sigma = self.points, self.equation_numbers, self.gap, self.scene.sigma
        excess, velocity, warm = state[0], state[1:-1], state[-1]
        pressure, excess_rate = 1 + excess, self.time_derivative(excess)
        filling = self.time_derivative(gap) / gap + excess_rate / pressure
        slip = self.slip_length(pressure * gap)
        mobility = gap * (gap + 6 * slip / pressure) / sigma
        lag = n["lag"] * gap * (pressure * gap + 4 * n["slip"])
        rates = np.stack([self.time_derivative(u) for u in velocity])
        momentum = velocity.copy()
        for i, u in enumerate(velocity):
            carried = sum(
                v * _matrix_times_field(slope, u)
                for v, slope in zip(velocity, at.velocity_slope_matrices[i], strict=True)
            )
            momentum[i] += lag * (rates[i] + 9 / 7 * carried - u * filling / 7)
            momentum[i] += mobility * _matrix_times_field(at.gradient_matrices[i], excess)
        energy = warm + n["thermal_lag"] * gap * (
            pressure * gap + 4 * n["jump"]
        ) * self.time_derivative(warm)
        energy -= n["heating"] / 12 * gap * (gap + 6 * n["jump"] / pressure) * excess_rate
        cool = n["heating"] * sigma / 20 * np.sum(velocity**2, axis=0)
        hot, exponent = warm - cool, self.scene.gas.viscosity_exponent
        slower = 6 / 5 * warm - 9 / 14 * cool + exponent * (3 / 5 * warm - 3 / 7 * cool)
        mass = self.time_derivative(pressure * gap * (1 - hot))
        for i, u in enumerate(velocity):
            beside = lag * (9 / 7 * hot * rates[i] + u * self.time_derivative(hot) / 7) - u * slower
            sliding = self.scene.bearing_number / sigma if i == 0 else 0.0
            flow = pressure * gap * (u + beside + sliding)
            mass = mass + _matrix_times_field(at.divergence_matrices[i], flow)
        self._set_edge_conditions(excess, velocity, mass, momentum)
        return np.concatenate([mass[None], momentum, energy[None]])

    def _set_edge_conditions(
        self, excess: np.ndarray, velocity: np.ndarray, mass: np.ndarray, momentum: np.ndarray
    ) -> None:
        """Put the conditions at the edge into the residuals of mass and momentum."""
        edge_rows, corner = self.points.edge_mask, self.points.corner_mask
        normal = self.points.outward_normals[:, edge_rows, None]
        out = np.sum(normal * velocity[:, edge_rows], axis=0)
        inflow = np.where(out.real < 0, out, 0.0)
        inflow[corner[edge_rows]] = 0.0
        mass[edge_rows] = excess[edge_rows] + self.equation_numbers["loss"] * inflow**2
        gap = self.gap[edge_rows]
        around = self.equation_numbers["resistance"] * out / gap
        around += self.equation_numbers["inertance"] * self.time_derivative(gap * out)
        mass[edge_rows] -= np.where(corner[edge_rows, None], 0.0, around)
        if len(velocity) > 1:
            outflow_ratio = out / self.equation_numbers["reversing"]
            leaves = (1 + outflow_ratio / np.sqrt(1 + outflow_ratio**2)) / 2
            across = np.sum(normal * momentum[:, edge_rows], axis=0) * normal
            along = momentum[:, edge_rows] - across
            still = velocity[:, edge_rows] - out * normal
            momentum[:, edge_rows] = across + leaves * along + (1 - leaves) * still
            momentum[:, corner] = velocity[:, corner]

    def solve_periodic_state(self, state: FloatArray | None = None) -> FloatArray:
        """Return the periodic state, from another one as a guess.

        Raises:
            ArithmeticError: if Newton's method does not converge.
        """
        if state is None:
            shape = 2 + len(self.points.gradient_matrices), len(self.points.x), self.instant_count
            state = np.zeros(shape)
        precondition = self._preconditioner(state)
        for _ in range(MAX_NEWTON_STEPS):
            residual = precondition(self.residual(state))

            def derivative(change: FloatArray, at: FloatArray = state) -> FloatArray:
                stepped = at + 1j * COMPLEX_STEP * change.reshape(at.shape)
                return np.asarray(precondition(self.residual(stepped).imag / COMPLEX_STEP).ravel())

            matrix = LinearOperator((state.size, state.size), matvec=derivative, dtype=float)
            change, _ = gmres(
                matrix,
                -residual.ravel(),
                rtol=KRYLOV_TOLERANCE,
                restart=MAX_KRYLOV_ITERATIONS,
                maxiter=1,
            )
            change = change.reshape(state.shape)
            size = np.abs(change[0]).max()
            state = state + change * min(1.0, MAX_PRESSURE_STEP / size)
            if size < CONVERGED_PRESSURE_CHANGE:
                return state
            if not np.isfinite(size):
                break
        raise ArithmeticError("Newton's method did not converge")

    def mean_gauge_pressure(self, state: FloatArray) -> float:
        """Return the mean gauge pressure over pad and period, in p0."""
        return float(self.points.weights @ state[0].mean(axis=-1))

    def _preconditioner(self, state: FloatArray) -> Callable[[FloatArray], FloatArray]:
        """Return the inverse of the equations with coefficients averaged over the period."""
        at, n, gap, sigma = self.points, self.equation_numbers, self.gap, self.scene.sigma
        pressure, edge_rows = 1 + state[0], at.edge_mask
        mobility = gap * (gap + 6 * n["slip"] / pressure) / sigma
        flow = np.mean(pressure * mobility, axis=-1)
        lag = np.mean(n["lag"] * gap * (pressure * gap + 4 * n["slip"]), axis=-1)
        order = 1j * np.arange(self.instant_count // 2 + 1)
        inert = 1 + np.outer(lag, order)
        still = 1 + n["thermal_lag"] * order
        moved = sum(
            div @ (flow[:, None] * grad)
            for div, grad in zip(at.divergence_matrices, at.gradient_matrices, strict=True)
        )
        systems = []
        for k, harmonic in enumerate(order):
            stored = harmonic * (1 - n["heating"] / 12 * harmonic / still[k])
            system = stored * np.eye(len(edge_rows)) - moved / (1 + at.weights @ lag * harmonic)
            system[edge_rows] = np.eye(len(edge_rows))[edge_rows]
            systems.append(lu_factor(system))

        def multiply_harmonics(field: FloatArray, factor: np.ndarray) -> FloatArray:
            return np.asarray(np.fft.irfft(factor * np.fft.rfft(field), n=self.instant_count))

        def apply_preconditioner(residual: FloatArray) -> FloatArray:
            velocity = [multiply_harmonics(component, 1 / inert) for component in residual[1:-1]]
            mass = residual[0] + self.time_derivative(multiply_harmonics(residual[-1], 1 / still))
            for u, div in zip(velocity, at.divergence_matrices, strict=True):
                mass = mass - div @ (pressure * gap * u)
            mass[edge_rows] = residual[0][edge_rows] * gap[edge_rows]
            waves = np.fft.rfft(mass)
            columns = [lu_solve(lu, waves[:, k]) for k, lu in enumerate(systems)]
            rise = np.fft.irfft(np.stack(columns, axis=-1), n=self.instant_count) / gap
            for i, grad in enumerate(at.gradient_matrices):
                velocity[i] = velocity[i] - multiply_harmonics(mobility * (grad @ rise), 1 / inert)
            heat = residual[-1] + n["heating"] / 12 * gap**2 * self.time_derivative(rise)
            return np.stack([rise, *velocity, multiply_harmonics(heat, 1 / still)])

        return apply_preconditioner


def grid_sizes_of_scene(scene: Scene) -> list[tuple[int, int]]:
    """Return points and instants of the grid for a scene and of a coarser one."""
    points = (
        DIAMETER_POINT_COUNT
        if is_axisymmetric(scene)
        else POINT_COUNTS[sum(film_symmetry_in_x_and_y(scene))]
    )
    return [
        (points, INSTANT_COUNT),
        (4 * round(COARSER_GRID_RATIO * points / 4), INSTANT_COUNT - 4),
    ]


def force_on_grid(scene: Scene, effects: Effects, *, points: int, instants: int) -> float:
    """Return the mean force in newtons on one grid (``forces_on_grid``)."""
    return forces_on_grid(scene, [effects], points=points, instants=instants)[0]


def forces_on_grid(
    scene: Scene, effects: Sequence[Effects], *, points: int, instants: int
) -> list[float]:
    """Return the mean force in newtons with several sets of effects on one grid.

    Args:
        points: even, across the pad, or twice those along the radius of a disc.
        instants: in a period, an odd number.
    """
    grid, state, forces_n = points_of_scene(scene, points), None, []
    for effects_of_film in effects:
        film = FilmOnPoints(scene, effects_of_film, grid, instants)
        state = film.solve_periodic_state(state)
        forces_n.append(film.mean_gauge_pressure(state) * scene.force_scale_n)
    return forces_n
