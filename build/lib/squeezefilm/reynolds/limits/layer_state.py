"""The rim's boundary layer with the gas' inertia: its periodic state and what the core sees of it.

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
from functools import cached_property
from math import sqrt

import numpy as np
from scipy.linalg import lu_factor, lu_solve

from squeezefilm.reynolds.limits.boundary_layer import all_weights
from squeezefilm.reynolds.spectral import Period, axis

# The layer on [0, DEPTH]: ξ = DEPTH (exp(k z) − 1)/(exp(k) − 1), z on a Chebyshev axis; with
# inertia waves reach farther, and k is smaller.
DEPTH = 60.0
STRETCH, STRETCH_PER_REYNOLDS = 6.0, 0.2
MOST_NEWTON = 12
CONVERGED = 1e-9


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
        # inertial_core.py.
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
        inner = lu_solve(factors, right.ravel(), check_finite=False).reshape(right.shape)
        return np.concatenate([inner, np.zeros((1, right.shape[1]))])
