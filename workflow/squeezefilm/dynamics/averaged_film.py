"""The slow film: the mean force while the amplitude changes over many periods.

At σ → ∞ the gas under the pad keeps its mass over a period, HP = ψ(X, Y, T), and gives it away
through the edge over many. Averaged over a period the film equation is a diffusion equation,

    σ ∂ψ/∂T = ∇²w,   w = ψ²/2 + 6 Kn ψ,
    w on the edge = (1 + 3 a²/2 + u)/2 + 6 Kn (1 + a²/2),   a = ε(T) |s|,
    u = ε² (Re(s* ∂s/∂n) g(a)/a + Im(s* ∂s/∂n) q(a)/a)/√σ,
    mean gauge pressure = ∫ ψ/√(1 − ε² |s|²) − 1 + ∮ d(a)/√σ,

s the profile, s₁ + i s₂ of two quadrature components, n the inward normal, d, g and q the integrals
of the edge's boundary layer (asymptotics/edge_layer.py), which follows the amplitude at once. The
settled ψ is that of ``asymptotics.composite``. Slopes of ψ at the edge do not move its value there:
⟨H³P²⟩ is linear across the layer.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from math import inf
from typing import Any

import numpy as np

from squeezefilm.dynamics.pad_grid import PadGrid, pad_grid, rectangle_grid
from squeezefilm.film.scene import Scene
from squeezefilm.reynolds.asymptotics import edge_layer
from squeezefilm.reynolds.asymptotics.composite import edge_layer_expansion
from squeezefilm.reynolds.asymptotics.films import expansion_axis, films_of
from squeezefilm.reynolds.solver import solve
from squeezefilm.reynolds.terms import terms_of
from squeezefilm.reynolds.terms.inertia import Inertia
from squeezefilm.reynolds.terms.outline import SmoothOutline
from squeezefilm.solution import Solution

# Step of a difference quotient of the layer's functions, relative to ε.
LAYER_DIFFERENCE_STEP = 1e-5
# Unknowns along each side of the grids that are tried, and what the next must gain.
GRID_POINT_COUNTS = (11, 15, 21, 31)
MAX_REFINED_ERROR_RATIO = 0.9
# Of the periodic states' forces that those of settled films are compared with.
PERIODIC_FORCE_TOLERANCE = 1e-4


def _difference_quotient(value: Callable[[float], Any]) -> Any:
    """Central difference quotient of ``value`` at 1."""
    return (value(1 + LAYER_DIFFERENCE_STEP) - value(1 - LAYER_DIFFERENCE_STEP)) / (
        2 * LAYER_DIFFERENCE_STEP
    )


@dataclass(frozen=True)
class PeriodAveragedFilm:
    """One film on one grid, with or without the edge's boundary layer.

    Attributes:
        epsilon, sigma: excursion ratio and squeeze number.
        slip: first-order slip, 6 Kn.
    """

    grid: PadGrid
    epsilon: float
    sigma: float
    slip: float = 0.0
    has_edge_layer: bool = True

    @property
    def layer_squeeze_number(self) -> float:
        """Squeeze number that sets the layer's thickness: slip makes gas flow more freely."""
        return self.sigma / (1 + self.slip)

    @property
    def layer_thickness(self) -> float:
        """Thickness of the edge's layer over the pad's size, about."""
        return float(np.sqrt(self.grid.slowest_decay_rate / self.sigma))

    def edge_flow_potential(self, epsilon: float) -> np.ndarray:
        """w on the edge's nodes, in the order of all nodes."""
        grid = self.grid
        a = epsilon * np.abs(grid.edge_s)
        values = (1 + 1.5 * a**2) / 2 + self.slip * (1 + a**2 / 2)
        if self.has_edge_layer:
            _, in_phase, ahead = edge_layer.scaled_layer_integrals(a)
            turned = grid.edge_s.conj() * grid.edge_slope
            u = epsilon**2 * (in_phase * turned.real + ahead * turned.imag)
            values = values + u / np.sqrt(self.layer_squeeze_number) / 2
        return np.asarray(grid.edge_to_nodes_matrix @ values)

    def field_on_all_nodes(self, inside: np.ndarray, on_edge: np.ndarray) -> np.ndarray:
        """A field on all nodes from its parts."""
        field = np.empty(self.grid.inner_mask.size, dtype=inside.dtype)
        field[self.grid.inner_mask], field[~self.grid.inner_mask] = inside, on_edge
        return field

    def density(self, w: np.ndarray) -> np.ndarray:
        """ψ of w."""
        return np.sqrt(self.slip**2 + 2 * w) - self.slip

    def mean_gauge_pressure(self, psi: np.ndarray, epsilon: float) -> float:
        """Mean gauge pressure over pad and period at an amplitude, in units of p0."""
        within = self.grid.mean_weights @ (psi / self._harmonic_mean_gap(epsilon) - 1)
        return float(within) + self._edge_layer_correction(epsilon)

    def steady_flow_potential(self, epsilon: float) -> np.ndarray:
        """Steady w at a constant amplitude: ∇²w = 0, shape (nodes,)."""
        on_edge = self.edge_flow_potential(epsilon)
        inside = np.linalg.solve(
            self.grid.inner_laplacian, -self.grid.laplacian_of_edge_values(on_edge)
        )
        return self.field_on_all_nodes(inside, on_edge)

    def force_gain(self, modulation: np.ndarray) -> np.ndarray:
        """Change of ln F per small change of ln ε, complex, at modulations in units of ω, (n,)."""
        psi, on_edge, at_once = self._amplitude_derivatives
        gain = self._mean_pressure_gain(modulation, psi, on_edge, at_once)
        return gain / self.mean_gauge_pressure(psi, self.epsilon)

    @cached_property
    def _amplitude_derivatives(self) -> tuple[np.ndarray, np.ndarray, float]:
        """Return ψ, ∂w/∂ln ε on the film edge, and the instantaneous ∂⟨p⟩/∂ln ε."""
        epsilon, psi = self.epsilon, self.density(self.steady_flow_potential(self.epsilon))
        on_edge = _difference_quotient(lambda ratio: self.edge_flow_potential(epsilon * ratio))
        return (
            psi,
            on_edge,
            _difference_quotient(lambda ratio: self.mean_gauge_pressure(psi, epsilon * ratio)),
        )

    def stiffness(self, modulation: np.ndarray, lag: float = 0.0) -> np.ndarray:
        """Stiffness −∂⟨p⟩/∂ln h0 at constant hv, in units of p0.

        At motions exp(iΩT) of the pad, Ω in units of ω, (n,): the imaginary part of the result
        damps. Ω may be complex, as of a motion that dies away. A film (1 + δ) h0 thick is one of
        ε/(1 + δ), σ/(1 + δ)² and Kn/(1 + δ), in whose units ψ is less by 1 + δ and w by its square.

        Args:
            lag: Re/10 of gas with inertia, whose velocity lags behind the slope of the pressure.
        """
        return -self._mean_pressure_gain(modulation, *self._gap_derivatives, lag)

    @cached_property
    def _gap_derivatives(self) -> tuple[np.ndarray, np.ndarray, float]:
        """Return ψ, ∂w/∂ln h0 on the film edge, and the instantaneous ∂⟨p⟩/∂ln h0."""
        epsilon, psi = self.epsilon, self.density(self.steady_flow_potential(self.epsilon))
        on_edge = _difference_quotient(
            lambda ratio: (
                ratio**2 * self.with_thicker_gap(ratio).edge_flow_potential(epsilon / ratio)
            )
        )
        at_once = _difference_quotient(
            lambda ratio: self.with_thicker_gap(ratio).mean_gauge_pressure(
                psi / ratio, epsilon / ratio
            )
        )
        return psi, on_edge, at_once

    def free_motion_exponents(self, *, slow: float, scale: float) -> np.ndarray:
        """All exponents λ of free motion exp(λT) of a mass on the film, in units of ω, complex.

        The roots of λ² + slow + scale (K(−iλ) − K(0)) = 0, K that of ``stiffness``, as eigenvalues:
        with δ the change of ln h0 and z what δw is more than it would be in slow motion,

            σ ∂z/∂T = (ψ + 6 Kn) ∇²z − σ w₀ ∂δ/∂T,   ∂²δ/∂T² = scale ⟨z⟩ − slow δ,

        w₀ the δw of slow motion for δ = 1, ⟨z⟩ its change of the mean pressure.

        Args:
            slow: stiffness of slow motion over mass and ω².
            scale: unit of K, p0 times the area over h0, over mass and ω².
        """
        grid = self.grid
        psi, on_edge, _ = self._gap_derivatives
        mobility = (psi + self.slip)[grid.inner_mask]
        at_rest = np.linalg.solve(grid.inner_laplacian, -grid.laplacian_of_edge_values(on_edge))
        of_mean = grid.mean_weights / self._harmonic_mean_gap(self.epsilon)
        count = len(mobility)
        matrix = np.zeros((count + 2, count + 2))
        matrix[:count, :count] = mobility[:, None] * grid.inner_laplacian / self.sigma
        matrix[:count, -1] = -at_rest
        matrix[-2, -1] = 1
        matrix[-1, :count] = scale * of_mean[grid.inner_mask] / mobility
        matrix[-1, -2] = -slow
        return np.linalg.eigvals(matrix)

    def with_thicker_gap(self, ratio: float) -> PeriodAveragedFilm:
        """Return the film with the same amplitude and h0 multiplied by ``ratio``."""
        return replace(
            self, epsilon=self.epsilon / ratio, sigma=self.sigma / ratio**2, slip=self.slip / ratio
        )

    def _mean_pressure_gain(
        self,
        modulation: np.ndarray,
        psi: np.ndarray,
        on_edge: np.ndarray,
        at_once: float,
        lag: float = 0.0,
    ) -> np.ndarray:
        """Complex gain of the mean gauge pressure by a small modulation of the film, (n,).

        δψ exp(iΩT): iΩσ δψ = ∇·(∇((ψ + 6 Kn) δψ)/(1 + iΩ lag)), with δw known on the edge.
        """
        grid, driven = self.grid, -self.grid.laplacian_of_edge_values(on_edge)
        mobility = psi + self.slip
        weight = 1 / (mobility * self._harmonic_mean_gap(self.epsilon))
        changes = []
        for omega in np.atleast_1d(modulation):
            by_flow = 0.0
            if np.isfinite(omega):  # else the gas does not move
                rate = 1j * omega * (1 + 1j * omega * lag)
                shift = np.diag(rate * self.sigma / mobility[grid.inner_mask])
                change = self.field_on_all_nodes(
                    np.linalg.solve(grid.inner_laplacian - shift, driven), on_edge
                )
                by_flow = grid.mean_weights @ (change * weight)
            changes.append(at_once + complex(by_flow))
        return np.array(changes)

    def pressure_after_amplitude_jump(
        self, psi: np.ndarray, epsilon: float, times: np.ndarray
    ) -> np.ndarray:
        """Mean gauge pressure at times T after the amplitude has jumped to ε from a state ψ.

        Args:
            psi: the state, shape (nodes,).
            times: rising, from 0, shape (n,).
        """
        from scipy.integrate import odeint  # slow to import, and only needed here

        settled = self.density(self.steady_flow_potential(epsilon))
        inner, inside = self.grid.inner_mask, self.grid.inner_laplacian / self.sigma
        final = settled[inner]
        mobility = final + self.slip

        # In the distance y = ψ − settled, whose small end is then as exact as its beginning.
        def psi_rate(_: float, y: np.ndarray) -> np.ndarray:
            return np.asarray(inside @ (y * (mobility + y / 2)))

        def jacobian(_: float, y: np.ndarray) -> np.ndarray:
            return np.asarray(inside * (mobility + y))

        start = psi[inner] - final
        tolerances = {"rtol": 1e-6, "atol": 1e-8 * np.abs(start).max()}
        solution, about = odeint(
            psi_rate, start, times, Dfun=jacobian, tfirst=True, full_output=True, **tolerances
        )
        if "successful" not in about["message"]:
            raise ArithmeticError(f"the averaged film: {about['message']}")
        fields = np.repeat(settled[None], len(times), axis=0)
        fields[:, inner] += solution
        densities = fields / self._harmonic_mean_gap(epsilon) - 1
        return np.asarray(densities @ self.grid.mean_weights + self._edge_layer_correction(epsilon))

    def _harmonic_mean_gap(self, epsilon: float) -> np.ndarray:
        return np.asarray(np.sqrt(1 - epsilon**2 * np.abs(self.grid.s) ** 2))

    def _edge_layer_correction(self, epsilon: float) -> float:
        if not self.has_edge_layer:
            return 0.0
        d, _ = edge_layer.layer_integrals(epsilon * np.abs(self.grid.edge_s))
        return float(self.grid.edge_weights @ d / np.sqrt(self.layer_squeeze_number))


def unsupported_reason(scene: Scene) -> str:
    """Return the reason why a scene's response is not supported, or an empty text."""
    if not scene.pad.gap.flat:
        return "the response was derived for a gap that is uniform at rest, not tilted or crowned"
    if scene.epsilon == 0:
        return "the surface is at rest"
    terms = terms_of(scene)
    unknown = [
        term.label
        for term in terms
        if isinstance(term, Inertia)
        or not (term.SUPPORTS_EXPANSIONS or isinstance(term, SmoothOutline))
    ]
    return f"the response is not derived with {', '.join(unknown)}" if unknown else ""


def best_averaged_film(scene: Scene) -> tuple[PeriodAveragedFilm, float]:
    """Return the averaged film on the finest grid that pays, and its relative error.

    A finer grid is taken as long as it makes the error smaller by a tenth.
    """
    best = averaged_film_on_grid(scene)
    for points in GRID_POINT_COUNTS[1:]:
        finer = averaged_film_on_grid(scene, points)
        if not finer[1] < MAX_REFINED_ERROR_RATIO * best[1]:
            break
        best = finer
    return best


@lru_cache(maxsize=len(GRID_POINT_COUNTS))
def averaged_film_on_grid(
    scene: Scene, points: int = GRID_POINT_COUNTS[0]
) -> tuple[PeriodAveragedFilm, float]:
    """The averaged film on one grid, and its relative error at rest.

    The error is that of the settled force: of a rectangle by the edge layer's expansion, of other
    pads the difference to the periodic state's. It may be infinite.
    """
    numbers = scene.epsilon, scene.sigma, 6 * scene.slip_knudsen
    if scene.pad.smooth_outline:
        film = PeriodAveragedFilm(pad_grid(scene, points), *numbers)
        return film, _error_against_periodic(film, scene)
    nodes = expansion_axis(points).all_nodes
    films = films_of(
        np.array([scene.epsilon]),
        np.array([scene.sigma]),
        scene.amplitude(*np.meshgrid(nodes, nodes, indexing="ij"))[None],
        aspect=scene.aspect,
        slip=6 * scene.slip_knudsen,
    )
    limit = edge_layer_expansion(films)
    with np.errstate(divide="ignore", invalid="ignore"):
        error = float(np.abs(limit.pressure_ratio_error / limit.mean_pressure_ratio)[0])
    return PeriodAveragedFilm(rectangle_grid(films), *numbers), error


def _error_against_periodic(film: PeriodAveragedFilm, scene: Scene) -> float:
    """Relative error of the settled force and of its growth with the amplitude.

    Where the force is in error by e(ε), the gain is so by ε ∂e/∂ε: of e = e₀ + e₁ ε² that is
    8/3 of its change from half the amplitude.
    """
    errors = []
    for periodic, epsilon in zip(
        _periodic_solutions(scene), (film.epsilon, film.epsilon / 2), strict=True
    ):
        if not np.isfinite(periodic.force_n):
            return inf
        force_n = (
            film.mean_gauge_pressure(film.density(film.steady_flow_potential(epsilon)), epsilon)
            * scene.force_scale_n
        )
        errors.append(force_n / periodic.force_n - 1)
    return abs(errors[0]) + 8 / 3 * abs(errors[0] - errors[1]) + PERIODIC_FORCE_TOLERANCE


@lru_cache(maxsize=16)
def _periodic_solutions(scene: Scene) -> list[Solution]:
    """Forces of the periodic states at a scene's amplitude and at half of that."""
    viscous = scene.viscous()
    scenes = [replace(viscous, hv_m=share * scene.hv_m) for share in (1.0, 0.5)]
    return list(solve(scenes, tolerance=PERIODIC_FORCE_TOLERANCE))
