"""Tables of the edge layer, computed: what ``asymptotics/edge_layer.py`` interpolates.

Its docstring has the equations. Without inertia the layer's mass is solved for by Newton's method
with GMRES, with inertia a stream function of ξ and T by dense matrices. Collocation is Chebyshev's
on 0 ≤ ξ ≤ HALF_LINE_LENGTH, crowded at the edge: ξ = HALF_LINE_LENGTH (exp(k z) − 1)/(exp(k) − 1).
"""

import argparse
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from math import log, sqrt
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.polynomial import chebyshev
from scipy.linalg import lu_factor, lu_solve
from scipy.sparse.linalg import LinearOperator, gmres

from squeezefilm.cli.options import command, option
from squeezefilm.errors import RunError
from squeezefilm.files import write_text
from squeezefilm.parallel import print_step
from squeezefilm.reynolds.asymptotics import edge_layer
from squeezefilm.reynolds.asymptotics.edge_layer import (
    EXCURSION_COUNT,
    EXCURSION_COUNT_WITH_INERTIA,
    MAX_TABLE_EXCURSION,
    MAX_TABLE_REYNOLDS,
    REYNOLDS_NUMBER_COUNT,
    max_excursion_with_inertia,
    quadrature_weights_with_ends,
)
from squeezefilm.reynolds.spectral import cached_axis, cached_time_axis

LAYER_COLUMNS = ("a", "d_over_a_squared", "g_over_a", "q_over_a")
INERTIA_LAYER_COLUMNS = (
    *("reynolds", "a", "rise_over_a_squared"),
    *("d_over_a_squared", "g_over_a", "h_over_a_squared"),
)
HALF_LINE_LENGTH = 60.0
# k of the nodes; with inertia waves reach farther, and it is smaller.
NODE_STRETCH, STRETCH_LOSS_PER_REYNOLDS = 6.0, 0.2
NODE_COUNT, NODE_COUNT_WITH_INERTIA = 112, 88
# Instants with inertia, from small excursions to the largest.
INSTANT_COUNT_RANGE = 12, 48
MAX_NEWTON_STEPS = 40
# Share of the shortest waves in time from which on a state is not resolved.
MAX_SHORT_WAVE_FRACTION = 5e-3


@command(option("--output", "FOLDER", "for the two tables", required=True, type=Path))
def edge_layers(options: argparse.Namespace) -> None:
    """Compute both tables of the edge layer again, in half an hour of one core.

    squeezefilm-verification edge-layers --output workflow/squeezefilm/reynolds/asymptotics
    """
    rows: list[tuple[float, ...]] = []
    for a in table_excursions():
        print_step(f"a {a:.4g}")
        rows.append((a, *layer_coefficients(a)))
    write_text(_csv_text(LAYER_COLUMNS, rows), options.output / edge_layer.LAYER_TABLE_PATH.name)
    rows = []
    for reynolds in table_reynolds_numbers():
        print_step(f"Re {reynolds:.4g}")
        rows += layer_rows_with_inertia(reynolds, table_excursions_with_inertia(reynolds))
    write_text(
        _csv_text(INERTIA_LAYER_COLUMNS, rows),
        options.output / edge_layer.LAYER_TABLE_WITH_INERTIA_PATH.name,
    )


def _csv_text(columns: tuple[str, ...], rows: list[tuple[float, ...]]) -> str:
    return "".join(",".join(map(str, line)) + "\n" for line in [columns, *rows])


def table_excursions() -> list[float]:
    """Excursion ratios of the table's rows, rising from 0 to MAX_TABLE_EXCURSION."""
    return _excursions_of_log_narrowing(
        edge_layer.log_narrowing_factor(MAX_TABLE_EXCURSION)
        * cached_axis(EXCURSION_COUNT - 2, False).all_nodes
    )


def table_reynolds_numbers() -> list[float]:
    """Reynolds numbers of the table with inertia."""
    return (MAX_TABLE_REYNOLDS * (chebyshev.chebpts1(REYNOLDS_NUMBER_COUNT) + 1) / 2).tolist()


def table_excursions_with_inertia(reynolds: float) -> list[float]:
    """Excursion ratios of the table with inertia at one of its Reynolds numbers."""
    fractions = (chebyshev.chebpts1(EXCURSION_COUNT_WITH_INERTIA) + 1) / 2
    return _excursions_of_log_narrowing(
        edge_layer.log_narrowing_factor(max_excursion_with_inertia(reynolds)) * fractions
    )


def _excursions_of_log_narrowing(coordinates: np.ndarray) -> list[float]:
    return np.sqrt(-np.expm1(-coordinates)).tolist()


class HalfLine(NamedTuple):
    """Nodes ξ from the edge inwards, d/dξ on them, and weights of the integral over ξ."""

    xi: np.ndarray
    derivative_matrix: np.ndarray
    weights: np.ndarray


def half_line_of_nodes(nodes: int, stretch: float) -> HalfLine:
    """Collocation on the layer, ends included."""
    line = cached_axis(nodes, False)
    z, unit = line.all_nodes, HALF_LINE_LENGTH / np.expm1(stretch)
    slope = unit * stretch * np.exp(stretch * z)
    return HalfLine(
        xi=unit * np.expm1(stretch * z),
        derivative_matrix=line.derivative_matrix / slope[:, None],
        weights=quadrature_weights_with_ends(line) * slope,
    )


def layer_coefficients(a: float) -> tuple[float, float, float]:
    """d/a², g/a and q/a at one excursion ratio 0 ≤ a < 1, without inertia.

    At a = 0 the linear layer gives −5√2/8, 3/√2 and −3/√2.

    Raises RunError where Newton's method does not converge.
    """
    if a == 0:
        return -5 * sqrt(2) / 8, 3 / sqrt(2), -3 / sqrt(2)
    # Powers of 1/H have harmonics that fall like ρ^k.
    ratio = a / (1 + sqrt(1 - a**2))
    time = cached_time_axis(4 * max(6, round(1.2 * log(1e-14) / log(ratio) / 4)))
    gap, core = 1 + a * np.sin(time.nodes), sqrt(1 + 1.5 * a**2)
    line = half_line_of_nodes(NODE_COUNT, NODE_STRETCH)
    second = (line.derivative_matrix @ line.derivative_matrix)[1:-1]
    inner, shape = second[:, 1:-1], (NODE_COUNT, time.instant_count)
    mass = np.full((NODE_COUNT + 2, time.instant_count), core)
    mass[0] = gap
    # In the time ∫H dT the layer is ∂²(M²/2) = ∂M: with M replaced by its value inside, the
    # linear operator is diagonal in the eigenvectors of both directions.
    root = 1 / np.sqrt(gap)
    rates, vectors = np.linalg.eigh(1j * root[:, None] * time.derivative_matrix * root)
    across, shapes = np.linalg.eig(inner)
    back, divisor = np.linalg.inv(shapes), core * across[:, None] + 1j * rates

    def precondition(field: np.ndarray) -> np.ndarray:
        modes = back @ ((field * root) @ vectors.conj()) / divisor
        return np.asarray(((shapes @ modes @ vectors.T).real * root).ravel())

    def linear_operator(diffusivity: np.ndarray) -> Callable[[np.ndarray], np.ndarray]:
        def apply_operator(change: np.ndarray) -> np.ndarray:
            change = change.reshape(shape)
            return precondition(inner @ (diffusivity * change) - change @ time.derivative_matrix.T)

        return apply_operator

    for _ in range(MAX_NEWTON_STEPS):
        residual = second @ (gap * mass**2 / 2) - mass[1:-1] @ time.derivative_matrix.T
        target = -precondition(residual)
        if np.abs(target).max() < 1e-12:
            break
        size = target.size
        operator = LinearOperator(
            (size, size), matvec=linear_operator(gap * mass[1:-1]), dtype=float
        )
        change, _ = gmres(operator, target, rtol=1e-5, restart=150, maxiter=3)
        change = change.reshape(shape)
        step_fraction = 1.0
        while np.min(mass[1:-1] + step_fraction * change) <= 0.1 * np.min(mass[1:-1]):
            step_fraction /= 2
        mass[1:-1] += step_fraction * change
    else:
        raise RunError(f"the edge layer at a = {a:g} did not converge")
    d = line.weights @ np.mean((mass - core) / gap, axis=1)
    square = line.weights @ (mass**2 - core**2) * 3 / time.instant_count
    g, q = square @ np.sin(time.nodes), square @ np.cos(time.nodes)
    return float(d / a**2), float(g / a), float(q / a)


def layer_rows_with_inertia(reynolds: float, rising: list[float]) -> list[tuple[float, ...]]:
    """Rows of INERTIA_LAYER_COLUMNS at one Reynolds number and rising excursion ratios 0 < a < 1.

    Raises RunError where no state is found, as where a shock forms, or it is not resolved.
    """
    rows: list[tuple[float, ...]] = []
    last: tuple[InertiaLayer, np.ndarray] | None = None
    for a in rising:
        excursion_fraction = (a / float(max_excursion_with_inertia(reynolds))) ** 2
        instants = 2 * round(
            (
                INSTANT_COUNT_RANGE[0]
                + (INSTANT_COUNT_RANGE[1] - INSTANT_COUNT_RANGE[0]) * excursion_fraction
            )
            / 2
        )
        state = InertiaLayer(a, reynolds, instants)
        stream, factors = state.solve(last)
        last = state, stream
        rise, d, g, h = state.edge_functions(stream, factors)
        rows.append((reynolds, a, rise / a**2, d / a**2, g / a, h / a**2))
    return rows


@dataclass(frozen=True)
class InertiaLayer:
    """The layer with inertia at one excursion ratio; fields are (nodes, instants), edge first.

    The unknown, ``stream``, is X less the linear part of a layer without inertia.
    """

    excursion_ratio: float
    reynolds: float
    instant_count: int

    @cached_property
    def half_line(self) -> HalfLine:
        return half_line_of_nodes(
            NODE_COUNT_WITH_INERTIA, NODE_STRETCH - STRETCH_LOSS_PER_REYNOLDS * self.reynolds
        )

    @cached_property
    def second_derivative_matrix(self) -> np.ndarray:
        return self.half_line.derivative_matrix @ self.half_line.derivative_matrix

    @property
    def time_derivative(self) -> np.ndarray:
        """d/dT."""
        return cached_time_axis(self.instant_count).derivative_matrix

    @cached_property
    def gap(self) -> np.ndarray:
        return 1 + self.excursion_ratio * np.sin(cached_time_axis(self.instant_count).nodes)

    def layer_mass(self, stream: np.ndarray) -> np.ndarray:
        return np.asarray(
            sqrt(1 + 1.5 * self.excursion_ratio**2) + self.half_line.derivative_matrix @ stream
        )

    def solve(self, nearby: "tuple[InertiaLayer, np.ndarray] | None" = None) -> tuple:
        """Return the stream and the factors of the last step's matrix, from a nearby stream."""
        stream = np.zeros((NODE_COUNT_WITH_INERTIA + 2, self.instant_count))
        if nearby is not None:
            other, known = nearby
            carried = cached_time_axis(other.instant_count).matrix_at(
                cached_time_axis(self.instant_count).nodes
            )
            stream = known @ carried.T * (self.excursion_ratio / other.excursion_ratio)
        for _ in range(MAX_NEWTON_STEPS):
            factors = lu_factor(self._jacobian(stream), overwrite_a=True, check_finite=False)
            change = self._solve_linear_equation(factors, -self._residual(stream))
            least, step_fraction = self.layer_mass(stream).min(), 1.0
            while self.layer_mass(stream + step_fraction * change).min() <= 0.1 * least:
                step_fraction /= 2
            stream = stream + step_fraction * change
            if np.abs(self.half_line.derivative_matrix @ change).max() < 1e-9:
                break
        else:
            raise RunError(f"no edge layer at a = {self.excursion_ratio:g}, Re = {self.reynolds:g}")
        half = self.instant_count // 2
        waves = np.abs(
            cached_time_axis(self.instant_count).fourier_matrix @ self.layer_mass(stream).T
        )
        if waves[half - 1 : half + 1].max() > MAX_SHORT_WAVE_FRACTION:
            raise RunError(
                f"a = {self.excursion_ratio:g}, Re = {self.reynolds:g}: the layer is not resolved"
            )
        return stream, factors

    def edge_functions(
        self, stream: np.ndarray, factors: tuple
    ) -> tuple[float, float, float, float]:
        """ψ² − 1, d, g and h of a state."""
        mass, xi = self.layer_mass(stream), self.half_line.xi[:, None]
        psi = float(mass[-1].mean())
        d = float(self.half_line.weights @ np.mean((mass - psi) / self.gap, axis=1))
        flux = -stream @ self.time_derivative.T
        sine = np.sin(cached_time_axis(self.instant_count).nodes)
        # Far inside the core's own flux goes on: −ψ (A ∂ψ/∂n − ψ B ∂a/∂n).
        rates = np.diag(1 / self.gap) + self.reynolds / 10 * psi * self.time_derivative
        mobility = np.linalg.solve(rates, np.ones(self.instant_count))
        by_slope = self._apply_linear_equation(
            stream, 0.0, 0.0, psi**2 * (mobility - 1) / self.excursion_ratio
        )
        by_slope = by_slope - xi * sine * flux / self.gap - mass**2 * sine
        by_core = self._apply_linear_equation(stream, xi, 1.0, -psi * mobility)
        changes = []
        for forcing in (by_slope, by_core):
            forcing[0] = 0.0  # P = 1 on the edge
            answer = self.half_line.derivative_matrix @ self._solve_linear_equation(
                factors, -forcing[:-1]
            )
            changes.append(float(answer[-1].mean()))
        return psi**2 - 1, d, 2 * psi * changes[0], changes[1]

    def _residual(self, stream: np.ndarray) -> np.ndarray:
        """On all nodes but the last, where X = 0; on the edge w − H."""
        mass = self.layer_mass(stream)
        flux = -stream @ self.time_derivative.T
        rate = self.time_derivative
        slope = self.second_derivative_matrix @ stream
        inertia = (
            mass * (flux @ rate.T)
            - 17 / 7 * flux * (mass @ rate.T)
            - 9 / 7 * flux**2 / mass * slope
        )
        residual = flux + self.gap * (self.reynolds / 10 * inertia + mass * slope)
        residual[0] = mass[0] - self.gap
        return np.asarray(residual[:-1])

    def _linear_coefficients(self, stream: np.ndarray) -> tuple[np.ndarray, ...]:
        """Coefficients of w, ∂w/∂ξ, ∂w/∂T, q and ∂q/∂T in the linear equation."""
        mass = self.layer_mass(stream)
        flux = -stream @ self.time_derivative.T
        rate = self.time_derivative
        slope, weight = self.second_derivative_matrix @ stream, self.reynolds / 10 * self.gap
        return (
            weight * (flux @ rate.T + 9 / 7 * (flux / mass) ** 2 * slope) + self.gap * slope,
            -9 / 7 * weight * flux**2 / mass + self.gap * mass,
            -17 / 7 * weight * flux,
            1 - weight * (17 / 7 * (mass @ rate.T) + 18 / 7 * flux * slope / mass),
            weight * mass,
        )

    def _apply_linear_equation(
        self,
        stream: np.ndarray,
        mass: np.ndarray | float,
        slope: np.ndarray | float,
        flux: np.ndarray,
    ) -> np.ndarray:
        """The linear equation applied to a steady mass and its slope, and an even flux q(T)."""
        of_mass, of_slope, _, of_flux, of_rate = self._linear_coefficients(stream)
        changes = of_flux * flux + of_rate * (flux @ self.time_derivative.T)
        return np.asarray(of_mass * mass + of_slope * slope + changes)

    def _jacobian(self, stream: np.ndarray) -> np.ndarray:
        """Jacobian for X on all nodes but the last; the rows of the edge come first."""
        rate, count = self.time_derivative, NODE_COUNT_WITH_INERTIA + 1
        first = self.half_line.derivative_matrix[:-1, :-1]
        second = self.second_derivative_matrix[:-1, :-1]
        of_mass, of_slope, of_mass_rate, of_flux, of_flux_rate = (
            coefficient[:-1] for coefficient in self._linear_coefficients(stream)
        )
        matrix = of_mass_rate[:, :, None, None] * first[:, None, :, None] * rate[None, :, None, :]
        at, now = np.arange(count), np.arange(self.instant_count)
        same_time = of_mass[:, :, None] * first[:, None] + of_slope[:, :, None] * second[:, None]
        matrix[:, now, :, now] += same_time.swapaxes(0, 1)
        by_flux = of_flux[:, :, None] * rate + of_flux_rate[:, :, None] * (rate @ rate)
        matrix[at, :, at, :] -= by_flux
        matrix[0] = 0.0
        matrix[0, now, :, now] = first[0]
        return np.asarray(matrix.reshape(count * self.instant_count, count * self.instant_count))

    def _solve_linear_equation(self, factors: tuple, right: np.ndarray) -> np.ndarray:
        """The linear equation's X for a right-hand side on all nodes but the last."""
        inner = lu_solve(factors, right.ravel(), check_finite=False).reshape(right.shape)
        return np.concatenate([inner, np.zeros((1, right.shape[1]))])
