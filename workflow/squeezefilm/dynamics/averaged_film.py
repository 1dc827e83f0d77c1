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
from dataclasses import replace
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
from scipy.integrate import odeint

from squeezefilm.film.scene import Scene
from squeezefilm.reynolds.asymptotics import edge_layer
from squeezefilm.reynolds.asymptotics.composite import edge_layer_expansion
from squeezefilm.reynolds.asymptotics.edge_layer import all_weights
from squeezefilm.reynolds.asymptotics.films import Films, expansion_axis, films_of
from squeezefilm.reynolds.terms import terms_of
from squeezefilm.reynolds.terms.inertia import Inertia

# Step of a difference quotient of the layer's functions, relative to ε.
LAYER_DIFFERENCE_STEP = 1e-5
# Unknowns along each side of the grids that are tried, and what the next must gain.
GRID_POINTS = (11, 15, 21, 31)
ERROR_RATIO = 0.9


def _slope(value: Callable[[float], Any]) -> Any:
    """Central difference quotient of ``value`` at 1."""
    return (value(1 + LAYER_DIFFERENCE_STEP) - value(1 - LAYER_DIFFERENCE_STEP)) / (
        2 * LAYER_DIFFERENCE_STEP
    )


class AveragedFilm:
    """One film on one grid (B = 1 of ``films``), with or without the edge's boundary layer."""

    def __init__(self, films: Films, layer: bool = True) -> None:
        self.films, self.layer = films, layer
        numbers = films.epsilon, films.sigma, films.slip
        self.epsilon, self.sigma, self.slip = (float(number[0]) for number in numbers)

    @cached_property
    def laplacian(self) -> np.ndarray:
        """∇² on the inner nodes of a field on all nodes, shape (inner, all), both flattened."""
        films = self.films
        second_x, second_y = (line.derivative @ line.derivative for line in (films.x, films.y))
        along_x = np.kron(second_x, np.eye(len(second_y)))
        along_y = np.kron(np.eye(len(second_x)), second_y) / films.aspect[0] ** 2
        return (along_x + along_y)[self.inner]

    @cached_property
    def inner(self) -> np.ndarray:
        """Return the nodes that are not on the film edge, shape (all,)."""
        inside = np.zeros(self.films.s.shape[1:], dtype=bool)
        inside[1:-1, 1:-1] = True
        return inside.ravel()

    def edge_w(self, epsilon: float) -> np.ndarray:
        """w on the edge's nodes, in the order of all nodes; corners are means of both sides."""
        films = self.films
        a = epsilon * np.abs(films.edge_profile)
        values = (1 + 1.5 * a**2) / 2 + self.slip * (1 + a**2 / 2)
        if self.layer:
            _, in_phase, ahead = edge_layer.ratios(a)
            turned = films.edge_profile.conj() * films.slope
            u = epsilon**2 * (in_phase * turned.real + ahead * turned.imag)
            values = values + u / np.sqrt(films.layer_number) / 2
        return self._edge_values_on_nodes(values)[~self.inner]

    def field(self, inside: np.ndarray, on_edge: np.ndarray) -> np.ndarray:
        """A field on all nodes, (nx + 2, ny + 2), from its parts."""
        field = np.empty(self.inner.size, dtype=inside.dtype)
        field[self.inner], field[~self.inner] = inside, on_edge
        return field.reshape(self.films.s.shape[1:])

    def density(self, w: np.ndarray) -> np.ndarray:
        """ψ of w."""
        return np.sqrt(self.slip**2 + 2 * w) - self.slip

    def mean(self, psi: np.ndarray, epsilon: float) -> float:
        """Mean gauge pressure over pad and period at an amplitude, in units of p0."""
        films = self.films
        within = films.mean((psi / self._mean_gap_factor(epsilon) - 1)[None])
        return float(within[0]) + self._layer(epsilon)

    def settled(self, epsilon: float) -> np.ndarray:
        """Steady w at a constant amplitude: ∇²w = 0, shape (nx + 2, ny + 2)."""
        on_edge = self.edge_w(epsilon)
        inside = np.linalg.solve(
            self.laplacian[:, self.inner], -self.laplacian[:, ~self.inner] @ on_edge
        )
        return self.field(inside, on_edge)

    def response(self, modulation: np.ndarray) -> np.ndarray:
        """Change of ln F per small change of ln ε, complex, at modulations in units of ω, (n,)."""
        psi, on_edge, at_once = self._amplitude_derivatives
        return self._mean_pressure_gain(modulation, psi, on_edge, at_once) / self.mean(
            psi, self.epsilon
        )

    @cached_property
    def _amplitude_derivatives(self) -> tuple[np.ndarray, np.ndarray, float]:
        """Return ψ, ∂w/∂ln ε on the film edge, and the instantaneous ∂⟨p⟩/∂ln ε."""
        epsilon, psi = self.epsilon, self.density(self.settled(self.epsilon))
        on_edge = _slope(lambda ratio: self.edge_w(epsilon * ratio))
        return psi, on_edge, _slope(lambda ratio: self.mean(psi, epsilon * ratio))

    def stiffness(self, modulation: np.ndarray) -> np.ndarray:
        """Stiffness −∂⟨p⟩/∂ln h0 at constant hv, in units of p0.

        At motions exp(iΩT) of the pad, Ω in units of ω, (n,): the imaginary part of the result
        damps. Ω may be complex, as of a motion that dies away. A film (1 + δ) h0 thick is one of
        ε/(1 + δ), σ/(1 + δ)² and Kn/(1 + δ), in whose units ψ is less by 1 + δ and w by its square.
        """
        psi = self.density(self.settled(self.epsilon))
        at_once = _slope(
            lambda ratio: self.with_thicker_gap(ratio).mean(psi / ratio, self.epsilon / ratio)
        )
        return -self._mean_pressure_gain(modulation, psi, self._edge_of_thicker_film(), at_once)

    def free_motion(self, *, slow: float, scale: float) -> np.ndarray:
        """All exponents λ of free motion exp(λT) of a mass on the film, in units of ω, complex.

        The roots of λ² + slow + scale (K(−iλ) − K(0)) = 0, K that of ``stiffness``, as eigenvalues:
        with δ the change of ln h0 and z what δw is more than it would be in slow motion,

            σ ∂z/∂T = (ψ + 6 Kn) ∇²z − σ w₀ ∂δ/∂T,   ∂²δ/∂T² = scale ⟨z⟩ − slow δ,

        w₀ the δw of slow motion for δ = 1, ⟨z⟩ its change of the mean pressure.

        Args:
            slow: stiffness of slow motion over mass and ω².
            scale: unit of K, p0 times the area over h0, over mass and ω².
        """
        films = self.films
        psi = self.density(self.settled(self.epsilon))
        mobility = (psi + self.slip).ravel()[self.inner]
        inside, on_edge = self.laplacian[:, self.inner], self._edge_of_thicker_film()
        at_rest = np.linalg.solve(inside, -self.laplacian[:, ~self.inner] @ on_edge)
        of_mean = np.outer(all_weights(films.x), all_weights(films.y)) / self._mean_gap_factor(
            self.epsilon
        )
        count = len(mobility)
        matrix = np.zeros((count + 2, count + 2))
        matrix[:count, :count] = mobility[:, None] * inside / self.sigma
        matrix[:count, -1] = -at_rest
        matrix[-2, -1] = 1
        matrix[-1, :count] = scale * of_mean.ravel()[self.inner] / mobility
        matrix[-1, -2] = -slow
        return np.linalg.eigvals(matrix)

    def _edge_of_thicker_film(self) -> np.ndarray:
        """∂w/∂ln h0 on the film edge."""
        return np.asarray(
            _slope(
                lambda ratio: ratio**2 * self.with_thicker_gap(ratio).edge_w(self.epsilon / ratio)
            )
        )

    def with_thicker_gap(self, ratio: float) -> AveragedFilm:
        """Return the film with the same amplitude and h0 multiplied by ``ratio``."""
        films, slip = self.films, self.films.slip / ratio
        numbers = {"epsilon": films.epsilon / ratio, "sigma": films.sigma / ratio**2, "slip": slip}
        return AveragedFilm(replace(films, **numbers), self.layer)

    def _mean_pressure_gain(
        self, modulation: np.ndarray, psi: np.ndarray, on_edge: np.ndarray, at_once: float
    ) -> np.ndarray:
        """Complex gain of the mean gauge pressure by a small modulation of the film, (n,).

        δψ exp(iΩT): iΩσ δψ = ∇²((ψ + 6 Kn) δψ), with δw known on the edge.
        """
        inside = self.laplacian[:, self.inner]
        driven = -self.laplacian[:, ~self.inner] @ on_edge
        mobility = psi + self.slip
        weight = 1 / (mobility * self._mean_gap_factor(self.epsilon))
        changes = []
        for omega in np.atleast_1d(modulation):
            by_flow = np.zeros(1)
            if np.isfinite(omega):  # else the gas does not move
                shift = np.diag(1j * omega * self.sigma / mobility.ravel()[self.inner])
                change = self.field(np.linalg.solve(inside - shift, driven), on_edge)
                by_flow = self.films.mean((change * weight)[None])
            changes.append(at_once + complex(by_flow[0]))
        return np.array(changes)

    def after_step(self, psi: np.ndarray, epsilon: float, times: np.ndarray) -> np.ndarray:
        """Mean gauge pressure at times T after the amplitude has jumped to ε from a state ψ.

        Args:
            psi: the state, shape (nx + 2, ny + 2).
            times: rising, from 0, shape (n,).
        """
        settled = self.density(self.settled(epsilon))
        inside = self.laplacian[:, self.inner] / self.sigma
        final = settled.ravel()[self.inner]
        mobility = final + self.slip

        # In the distance y = ψ − settled, whose small end is then as exact as its beginning.
        def rate(_: float, y: np.ndarray) -> np.ndarray:
            return np.asarray(inside @ (y * (mobility + y / 2)))

        def jacobian(_: float, y: np.ndarray) -> np.ndarray:
            return np.asarray(inside * (mobility + y))

        start = psi.ravel()[self.inner] - final
        tolerances = {"rtol": 1e-6, "atol": 1e-8 * np.abs(start).max()}
        solution, about = odeint(
            rate, start, times, Dfun=jacobian, tfirst=True, full_output=True, **tolerances
        )
        if "successful" not in about["message"]:
            raise ArithmeticError(f"the averaged film: {about['message']}")
        fields = np.repeat(settled[None], len(times), axis=0).reshape(len(times), -1)
        fields[:, self.inner] += solution
        densities = fields.reshape(-1, *settled.shape) / self._mean_gap_factor(epsilon) - 1
        return np.asarray(self.films.mean(densities) + self._layer(epsilon))

    def _mean_gap_factor(self, epsilon: float) -> np.ndarray:
        return np.asarray(np.sqrt(1 - epsilon**2 * self.films.profile_squared[0]))

    def _layer(self, epsilon: float) -> float:
        if not self.layer:
            return 0.0
        films = self.films
        d = films.edge_integral(edge_layer.integrals(epsilon * np.abs(films.edge_profile))[0])
        return float((d / np.sqrt(films.layer_number))[0])

    def _edge_values_on_nodes(self, values: np.ndarray) -> np.ndarray:
        """Put edge values, (1, 2 (nx + ny + 4)), on all nodes, flattened; inner nodes are 0."""
        node_indices = np.arange(self.inner.size).reshape(self.films.s.shape[1:])
        order = np.concatenate(
            [node_indices[0], node_indices[-1], node_indices[:, 0], node_indices[:, -1]]
        )
        total, count = (
            np.bincount(order, weights=side_values, minlength=node_indices.size)
            for side_values in (values[0], None)
        )
        return np.asarray(total / np.maximum(count, 1))


def refused(scene: Scene) -> str:
    """Return the reason why a scene's response is not supported, or an empty text."""
    if scene.pad.shape != "rectangle":
        return "the response was derived for rectangular pads"
    if not scene.pad.gap.flat:
        return "the response was derived for a gap that is uniform at rest, not tilted or crowned"
    if scene.epsilon == 0:
        return "the surface is at rest"
    terms = terms_of(scene)
    unknown = [term.label for term in terms if not term.IN_EXPANSIONS or isinstance(term, Inertia)]
    return f"the response is not derived with {', '.join(unknown)}" if unknown else ""


def averaged_film_of(scene: Scene) -> tuple[AveragedFilm, float]:
    """Return the averaged film on the finest grid that pays, and its relative error.

    A finer grid is taken as long as it makes the error smaller by a tenth.
    """
    best = film_on(scene)
    for points in GRID_POINTS[1:]:
        finer = film_on(scene, points)
        if not finer[1] < ERROR_RATIO * best[1]:
            break
        best = finer
    return best


@lru_cache(maxsize=len(GRID_POINTS))
def film_on(scene: Scene, points: int = GRID_POINTS[0]) -> tuple[AveragedFilm, float]:
    """The averaged film on one grid, and its relative error at rest.

    The error is that of the settled force, by the edge layer's expansion: it may be infinite.
    """
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
        return AveragedFilm(films), float(np.abs(limit.error / limit.mean)[0])
