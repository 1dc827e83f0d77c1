"""The film equation under any pad in its modes (galerkin.py): the balance and its response."""

from __future__ import annotations

import numpy as np

from squeezefilm.film.scene import Scene
from squeezefilm.reynolds.modes.pad_modes import PadModes
from squeezefilm.reynolds.terms import numbers_of, terms_of


class FilmInModes:
    """The equation's terms but for the rate, at the quadrature points: fields are (Q, instants)."""

    def __init__(self, scene: Scene, modes: PadModes, instants: np.ndarray) -> None:
        self.scene, self.modes = scene, modes
        self.gap = scene.gap(modes.x, modes.y, instants)
        ahead = scene.gap(modes.x, modes.y, instants + np.pi / 2)  # the motion's rate, and rest
        squeeze = scene.sigma * (ahead - scene.rest_gap(modes.x, modes.y)[:, None])
        self.own = terms_of(scene)
        self.coefficients = np.atleast_1d(numbers_of(scene, self.own)["flow"])
        self.drive = -modes.project(squeeze)
        for term in self.own:
            self.drive += term.in_modes(scene, modes, self.gap)
        self.exponent = scene.gas.polytropic_exponent

    def set_state(self, mass: np.ndarray) -> None:
        """Take a state, given by its mass excess in the modes, shape (modes, instants)."""
        self.mass = mass
        excess = self.modes.values(mass)
        self.density = 1 + excess / self.gap
        n = self.exponent
        self.pressure = excess / self.gap
        slope = 1 / self.gap  # dP/dm
        if n != 1:
            self.pressure = np.expm1(n * np.log1p(self.pressure))
            slope = n * self.density ** (n - 1) / self.gap
        self.terms = []
        self.diffusivity = 0.0
        for k, coefficient in enumerate(self.coefficients):
            power = coefficient * self.gap ** (3 - k)
            response = self.density ** (1 - k) * slope
            self.terms.append((power, response, self._potential(k)))
            share = (power * response).mean(axis=1)
            self.diffusivity += float(self.modes.weights @ share)

    def _potential(self, k: int) -> np.ndarray:
        """g_k(P) − g_k(1), exact for a small overpressure."""
        p = self.pressure
        power = (1 - k) / self.exponent + 1
        if power == 2:
            return p * (1 + p / 2)
        return np.log1p(p) if power == 0 else np.expm1(power * np.log1p(p)) / power

    def _flow(self, power: np.ndarray, potential: np.ndarray) -> np.ndarray:
        """−⟨∇φ_i, power ∇Π potential⟩, shape (modes, instants)."""
        along_x, along_y = self.modes.slopes(self.modes.project(potential))
        return -self.modes.project_on_slopes(power * along_x, power * along_y)

    def balance(self) -> np.ndarray:
        """All terms of the equation but −σ dm/dT, at the state."""
        total = self.drive.copy()
        for power, _, potential in self.terms:
            total += self._flow(power, potential)
        return total + self._by_terms(self.mass)

    def respond(self, change: np.ndarray) -> np.ndarray:
        """What a small change of the mass changes in the balance."""
        values = self.modes.values(change)
        total = self._by_terms(change)
        for power, response, _ in self.terms:
            total += self._flow(power, response * values)
        return total

    def _by_terms(self, mass: np.ndarray) -> np.ndarray:
        """What the scene's terms add because of a mass in the modes."""
        total = np.zeros_like(mass)
        if self.own:
            values = self.modes.values(mass)
            for term in self.own:
                total += term.in_modes(self.scene, self.modes, values)
        return total

    def safe_share(self, change: np.ndarray) -> float:
        """Largest share of a step that takes at most 9/10 of the density anywhere."""
        steepest = float((-self.modes.values(change) / self.gap / self.density).max())
        return 0.9 / steepest if steepest > 0.9 else 1.0

    @property
    def mean_overpressure(self) -> float:
        return float(self.modes.weights @ self.pressure.mean(axis=1))
