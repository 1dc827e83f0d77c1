"""Rarefaction: slip at the walls, or Fukui and Kaneko's flow factor, in powers of Kn.

The mass flux becomes Σ c_k H^(3−k) ρ^(1−k) ∇P; the mean free path's 1/ρ is in the powers of ρ.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from squeezefilm.film.scene import OperatingPoints, Scene, Scenes
from squeezefilm.film.validity import LEAST_INVERSE_KNUDSEN
from squeezefilm.reynolds.terms.term import Numbers, Simplification, Term

# Poiseuille flow of a rarefied gas over that of a viscous one, as a polynomial in 1/D with the
# inverse Knudsen number D = √π ρ H / (2 Kn), ρ over its ambient value: Fukui and Kaneko,
# J. Tribology 112 (1990), 78–83, the branch for D ≥ 5.
FUKUI_KANEKO = (1.0, 6 * 1.0162, 6 * 1.0653, -6 * 2.1354)


def flow_coefficients(scene: OperatingPoints) -> tuple[Any, ...]:
    """Coefficients c_k of the mass flux Σ c_k H^(3−k) ρ^(1−k) ∇P, the first being 1.

    Slip of first order adds 6 Kn H² (Burgdorfer 1959), times the gas' ``slip_coefficient``.
    """
    rarefaction = np.ravel(scene.gas.rarefaction)[0]  # scenes of like terms
    if rarefaction == "slip":
        return (1.0, 6 * scene.slip_knudsen)
    return fukui_kaneko(scene) if rarefaction == "fukui-kaneko" else (1.0,)


def fukui_kaneko(scene: OperatingPoints) -> tuple[Any, ...]:
    """The coefficients of Fukui and Kaneko's flow factor, whatever the scene's gas has."""
    inverse = scene.inverse_knudsen
    return tuple(c / inverse**k for k, c in enumerate(FUKUI_KANEKO))


@dataclass(frozen=True)
class Rarefaction(Term):
    """``label`` is the gas' ``rarefaction``, ``slip`` or ``fukui-kaneko``."""

    NAME = "rarefaction"
    ABSENT = Simplification("rarefaction", "gas.rarefaction is none", "no slip")

    @classmethod
    def of(cls, scene: Scene) -> Rarefaction | None:
        return cls(scene.gas.rarefaction) if scene.gas.rarefaction != "none" else None

    def numbers(self, scene: OperatingPoints) -> Numbers:
        return {"flow": flow_coefficients(scene)}

    @property
    def in_expansions(self) -> bool:
        return self.label == "slip"

    def refused_states(self, scenes: Scenes, *, thinnest: np.ndarray) -> Mapping[int, str]:
        if self.label != "fukui-kaneko":
            return {}
        least = scenes.inverse_knudsen * thinnest
        return {
            row: f"gas too rarefied: D falls to {least[row]:.2g}, below {LEAST_INVERSE_KNUDSEN:g}"
            for row in np.flatnonzero(least < LEAST_INVERSE_KNUDSEN).tolist()
        }
