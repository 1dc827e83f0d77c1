"""The edge's boundary layer with the gas' inertia: functions of excursion ratio and Re.

What the core of the film sees of the layer is ψ² on the rim, the layer's own overpressure d, and
the changes g and h of the rim's ψ² with the slopes of the profile and of the core. They were
computed once, by ``write_table``, and are stored as (ψ² − 1)/a², d/a², g/a and h/a² at Chebyshev
points: in Re up to MOST_REYNOLDS and, for each Re, in −ln(1 − a²) up to a = ``largest(Re)``.
Somewhere beyond, waves steepen to a shock in the layer, and no periodic state was found that a
finer grid would not change.

Within √(1/σ) of the finger's rim, with ξ = n√σ, n the distance from the rim, and ū = v/√σ the mean
velocity over the gap, mass w = HP and flux q = wv obey

    ∂w/∂T + ∂q/∂ξ = 0,    H = 1 + a sin T at the rim point, a = ε s,
    q + (Re/10) H {w ∂q/∂T − (17/7) q ∂w/∂T − (9/7)(q²/w) ∂w/∂ξ} + H w ∂w/∂ξ − w² ∂H/∂ξ = 0,

which is w times the one-mode momentum equation (terms/inertia.py)

    ū + (Re P H²/10) {∂ū/∂T + (9/7)(ū·∇)ū − (1/7) ū ∂ ln(PH)/∂T} = −(H²/σ) ∇P.

P = 1 at ξ = 0; inside w goes to a constant ψ and the flux to rest. With w = ∂X/∂ξ and q = −∂X/∂T
mass is conserved by itself and no mean flux is left: one equation for X, by collocation in ξ and T,
Newton's method and dense matrices.

At the next order in 1/√σ the profile's slope ∂a/∂n and the core's ∂ψ/∂n reach into the layer, which
answers linearly: far inside, ψ is changed by a multiple of either.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from math import sqrt
from pathlib import Path

import numpy as np
from numpy.polynomial import chebyshev

from squeezefilm.reynolds.asymptotics.edge_layer import all_weights
from squeezefilm.reynolds.spectral import Period, axis, period

TABLE = Path(__file__).with_name("edge_layer_with_inertia.csv")
COLUMNS = (
    *("reynolds", "a", "rise_over_a_squared"),
    *("d_over_a_squared", "g_over_a", "h_over_a_squared"),
)
MOST_REYNOLDS = 10.0
REYNOLDS_ROWS, ROWS = 14, 18
# Nodes across the layer and, from small excursions to the largest, over the period.
NODES, INSTANTS = 88, (12, 48)
# Share of the shortest waves in time from which on a state is not to be relied on.
MOST_UNRESOLVED = 5e-3
# The layer on [0, DEPTH]: ξ = DEPTH (exp(k z) − 1)/(exp(k) − 1), z on a Chebyshev axis; with
# inertia waves reach farther, and k is smaller.
DEPTH = 60.0
STRETCH, STRETCH_PER_REYNOLDS = 6.0, 0.2
MOST_NEWTON = 12
CONVERGED = 1e-9


@dataclass(frozen=True)
class RimValues:
    """The layer's functions at points of the rim, each of one shape; NaN beyond the table.

    rise: ψ² − 1; d: ∫₀^∞ ⟨P − ψ/H⟩ dξ; g, h: ψ² is changed by (g ∂a/∂n + h ∂ψ²/∂n)/√σ, n inward.
    """

    rise: np.ndarray
    d: np.ndarray
    g: np.ndarray
    h: np.ndarray


def largest(reynolds: np.ndarray | float) -> np.ndarray:
    """The largest excursion ratio of the table: 0.9 without inertia, 0.4 at Re = 10."""
    return 0.9 / (1 + np.asarray(reynolds, dtype=float) / 8)


def rim_values(a: np.ndarray, reynolds: np.ndarray) -> RimValues:
    """The functions at excursion ratios ``a``, shape (B, …), of films with ``reynolds``, (B,)."""
    reynolds = np.asarray(reynolds, dtype=float)
    films = a.reshape(len(reynolds), -1)
    most = largest(reynolds)[:, None]
    inside = (np.abs(films) <= most) & (reynolds[:, None] <= MOST_REYNOLDS)
    place = 2 * _stretched(np.minimum(np.abs(films), most)) / _stretched(most) - 1
    powers = chebyshev.chebvander(place, ROWS - 1)
    of_film = chebyshev.chebvander(
        2 * np.minimum(reynolds, MOST_REYNOLDS) / MOST_REYNOLDS - 1, REYNOLDS_ROWS - 1
    )
    series = np.einsum("br,kra->bka", of_film, _series())
    values = np.einsum("bka,bma->kbm", series, powers)
    ratio = np.where(inside, films, np.nan)
    scaled = values * np.stack([ratio**2, ratio**2, ratio, ratio**2])
    return RimValues(*scaled.reshape(4, *a.shape))


def table_nodes() -> np.ndarray:
    """Reynolds numbers and excursion ratios of the table's rows, shape (REYNOLDS_ROWS, ROWS, 2)."""
    reynolds = (chebyshev.chebpts1(REYNOLDS_ROWS) + 1) / 2 * MOST_REYNOLDS
    share = (chebyshev.chebpts1(ROWS) + 1) / 2
    a = np.sqrt(-np.expm1(-np.outer(_stretched(largest(reynolds)), share)))
    return np.stack([np.broadcast_to(reynolds[:, None], a.shape), a], axis=2)


def compute(reynolds: float, excursions: np.ndarray) -> np.ndarray:
    """Rows of the table at one Reynolds number and rising a > 0, shape (len(excursions), 6).

    Raises:
        ArithmeticError: where no state is found or it is not resolved.
    """
    rows = []
    last: LayerState | None = None
    for a in map(float, excursions):
        share = (a / float(largest(reynolds))) ** 2
        instants = 2 * round((INSTANTS[0] + (INSTANTS[1] - INSTANTS[0]) * share) / 2)
        layer = Layer(a, reynolds, LayerGrid(NODES, reynolds, period(instants)))
        last = layer.solve(last)
        if last.unresolved > MOST_UNRESOLVED:
            raise ArithmeticError(f"the layer at a = {a:g}, Re = {reynolds:g} is not resolved")
        seen = layer.seen(last)
        rise = (seen.mass_square - 1) / a**2
        rows.append((reynolds, a, rise, seen.d / a**2, seen.g / a, seen.h / a**2))
    return np.array(rows)


def read_table() -> np.ndarray:
    """The rows, Reynolds number by Reynolds number, shape (REYNOLDS_ROWS, ROWS, 6)."""
    rows = np.loadtxt(TABLE, delimiter=",", skiprows=1)
    return rows.reshape(REYNOLDS_ROWS, ROWS, len(COLUMNS))


def write_table() -> None:
    """Compute every row anew; about half an hour of one core."""
    rows = [compute(float(of_one[0, 0]), of_one[:, 1]) for of_one in table_nodes()]
    lines = [
        ",".join(COLUMNS),
        *(",".join(map(repr, row.tolist())) for row in np.concatenate(rows)),
    ]
    TABLE.write_text("\n".join(lines) + "\n", encoding="utf-8")


def _stretched(a: np.ndarray | float) -> np.ndarray:
    return -np.log1p(-np.square(a))


@lru_cache(maxsize=1)
def _series() -> np.ndarray:
    """Chebyshev coefficients of the four functions in Re and a, (4, REYNOLDS_ROWS, ROWS)."""
    values = np.moveaxis(read_table()[:, :, 2:], 2, 0)
    of_reynolds, of_a = (
        np.linalg.inv(chebyshev.chebvander(chebyshev.chebpts1(count), count - 1))
        for count in (REYNOLDS_ROWS, ROWS)
    )
    series: np.ndarray = of_reynolds @ values @ of_a.T
    return series


@dataclass(frozen=True)
class LayerGrid:
    """Collocation on the half line, rim first: all fields have shape (points + 2, instants)."""

    points: int
    reynolds: float
    time: Period

    @property
    def stretch(self) -> float:
        return STRETCH - STRETCH_PER_REYNOLDS * self.reynolds

    @cached_property
    def xi(self) -> np.ndarray:
        """Distances from the rim, shape (points + 2,)."""
        nodes = axis(self.points, False).all_nodes
        return DEPTH * np.expm1(self.stretch * nodes) / np.expm1(self.stretch)

    @cached_property
    def _slope(self) -> np.ndarray:
        nodes = axis(self.points, False).all_nodes
        return DEPTH * self.stretch * np.exp(self.stretch * nodes) / np.expm1(self.stretch)

    @cached_property
    def first(self) -> np.ndarray:
        """d/dξ on all nodes."""
        return axis(self.points, False).derivative / self._slope[:, None]

    @cached_property
    def second(self) -> np.ndarray:
        """d²/dξ² on all nodes."""
        return self.first @ self.first

    @cached_property
    def weights(self) -> np.ndarray:
        """Of the integral over ξ."""
        return all_weights(axis(self.points, False)) * self._slope


@dataclass(frozen=True)
class Seen:
    """What the core sees of a layer.

    mass_square: ψ² inside; d = ∫₀^∞ ⟨P − ψ/H⟩ dξ; g, h: the rim's ψ² is changed by
    (g ∂a/∂n + h ∂ψ²/∂n)/√σ, n inward.
    """

    mass_square: float
    d: float
    g: float
    h: float


@dataclass(frozen=True)
class LayerState:
    """A periodic state: ``stream`` is X less the linear part of a layer without inertia.

    ``factors`` are those of the Jacobian at the last Newton step.
    """

    layer: Layer
    stream: np.ndarray
    factors: tuple[np.ndarray, np.ndarray]

    @cached_property
    def mass(self) -> np.ndarray:
        return self.layer.mass(self.stream)

    @property
    def unresolved(self) -> float:
        """Share of the shortest waves in time."""
        time = self.layer.grid.time
        half = time.points // 2
        return float(np.abs(time.fourier @ self.mass.T)[half - 1 : half + 1].max())


@dataclass(frozen=True)
class Layer:
    """The layer at one excursion ratio 0 < a < 1 and Reynolds number Re, on a grid."""

    a: float
    reynolds: float
    grid: LayerGrid

    @cached_property
    def gap(self) -> np.ndarray:
        return 1 + self.a * np.sin(self.grid.time.nodes)

    @property
    def still(self) -> float:
        """ψ without inertia, about which X is expanded."""
        return sqrt(1 + 1.5 * self.a**2)

    def mass(self, stream: np.ndarray) -> np.ndarray:
        return self.still + self.grid.first @ stream

    def solve(self, nearby: LayerState | None = None) -> LayerState:
        """The periodic state, from one at another excursion ratio if that is given.

        Raises:
            ArithmeticError: where Newton's method does not converge, as where a shock forms.
        """
        from scipy.linalg import lu_factor

        grid = self.grid
        stream = np.zeros((grid.points + 2, grid.time.points))
        if nearby is not None:
            carried = nearby.layer.grid.time.interpolation_to(grid.time)
            stream = nearby.stream @ carried.T * (self.a / nearby.layer.a)
        for _ in range(MOST_NEWTON):
            factors = lu_factor(self._jacobian(stream), overwrite_a=True, check_finite=False)
            change = self._solved(factors, -self._residual(stream))
            least, share = self.mass(stream).min(), 1.0
            while self.mass(stream + share * change).min() <= 0.1 * least:
                share /= 2
            stream = stream + share * change
            if np.abs(grid.first @ change).max() < CONVERGED:
                return LayerState(self, stream, factors)
        raise ArithmeticError(f"no layer at a = {self.a:g}, Re = {self.reynolds:g} was found")

    def seen(self, state: LayerState) -> Seen:
        """What the core sees of it."""
        grid, mass = self.grid, state.mass
        psi = float(mass[-1].mean())
        d = float(grid.weights @ np.mean((mass - psi) / self.gap, axis=1))
        flux, sine = self._flux(state.stream), np.sin(grid.time.nodes)
        # Far inside the core's own flux goes on: −ψ (A ∂ψ/∂n − ψ B ∂a/∂n), A and B as in
        # core.py.
        rates = np.diag(1 / self.gap) + self.reynolds / 10 * psi * grid.time.derivative
        mobility = np.linalg.solve(rates, np.ones(grid.time.points))
        by_slope = self._linear(state, 0.0, 0.0, psi**2 * (mobility - 1) / self.a)
        by_slope = by_slope - grid.xi[:, None] * sine * flux / self.gap - mass**2 * sine
        by_core = self._linear(state, grid.xi[:, None], 1.0, -psi * mobility)
        changes = []
        for forcing in (by_slope, by_core):
            forcing[0] = 0.0  # P = 1 on the rim
            answer = grid.first @ self._solved(state.factors, -forcing[:-1])
            changes.append(float(answer[-1].mean()))
        return Seen(mass_square=psi**2, d=d, g=2 * psi * changes[0], h=changes[1])

    def _flux(self, stream: np.ndarray) -> np.ndarray:
        return -stream @ self.grid.time.derivative.T

    def _residual(self, stream: np.ndarray) -> np.ndarray:
        """On all nodes but the last, where X = 0; on the rim w − H."""
        mass, flux = self.mass(stream), self._flux(stream)
        rate, slope = self.grid.time.derivative, self.grid.second @ stream
        inertia = (
            mass * (flux @ rate.T)
            - 17 / 7 * flux * (mass @ rate.T)
            - 9 / 7 * flux**2 / mass * slope
        )
        residual = flux + self.gap * (self.reynolds / 10 * inertia + mass * slope)
        residual[0] = mass[0] - self.gap
        return residual[:-1]

    def _coefficients(self, stream: np.ndarray) -> tuple[np.ndarray, ...]:
        """Of the linear equation: those of w, ∂w/∂ξ, ∂w/∂T, q and ∂q/∂T."""
        mass, flux = self.mass(stream), self._flux(stream)
        rate, slope = self.grid.time.derivative, self.grid.second @ stream
        weight = self.reynolds / 10 * self.gap
        return (
            weight * (flux @ rate.T + 9 / 7 * (flux / mass) ** 2 * slope) + self.gap * slope,
            -9 / 7 * weight * flux**2 / mass + self.gap * mass,
            -17 / 7 * weight * flux,
            1 - weight * (17 / 7 * (mass @ rate.T) + 18 / 7 * flux * slope / mass),
            weight * mass,
        )

    def _linear(
        self,
        state: LayerState,
        mass: np.ndarray | float,
        slope: np.ndarray | float,
        flux: np.ndarray,
    ) -> np.ndarray:
        """The linear equation applied to a steady mass and its slope, and an even flux q(T)."""
        of_mass, of_slope, _, of_flux, of_rate = self._coefficients(state.stream)
        rate = self.grid.time.derivative
        result: np.ndarray = (
            of_mass * mass + of_slope * slope + of_flux * flux + of_rate * (flux @ rate.T)
        )
        return result

    def _jacobian(self, stream: np.ndarray) -> np.ndarray:
        """For X on all nodes but the last, rim's rows first."""
        grid, rate = self.grid, self.grid.time.derivative
        count, instants = grid.points + 1, grid.time.points
        first, second = grid.first[:-1, :-1], grid.second[:-1, :-1]
        of_mass, of_slope, of_mass_rate, of_flux, of_flux_rate = (
            each[:-1] for each in self._coefficients(stream)
        )
        matrix: np.ndarray = (
            of_mass_rate[:, :, None, None] * first[:, None, :, None] * rate[None, :, None, :]
        )
        at, now = np.arange(count), np.arange(instants)
        same_time = of_mass[:, :, None] * first[:, None] + of_slope[:, :, None] * second[:, None]
        matrix[:, now, :, now] += same_time.swapaxes(0, 1)
        matrix[at, :, at, :] -= of_flux[:, :, None] * rate + of_flux_rate[:, :, None] * (
            rate @ rate
        )
        matrix[0] = 0.0
        matrix[0, now, :, now] = first[0]
        return matrix.reshape(count * instants, count * instants)

    def _solved(self, factors: tuple[np.ndarray, np.ndarray], right: np.ndarray) -> np.ndarray:
        """The linear equation's X for a right-hand side on all nodes but the last."""
        from scipy.linalg import lu_solve

        inner = lu_solve(factors, right.ravel(), check_finite=False).reshape(right.shape)
        return np.concatenate([inner, np.zeros((1, right.shape[1]))])


if __name__ == "__main__":
    write_table()
