"""Rarefaction: slip at the walls, or the flow of a gas at any Knudsen number.

First-order slip makes the mass flux Σ c_k H^(3−k) ρ^(1−k) ∇P; the mean free path's 1/ρ is in the
powers of ρ. The flow factor makes it W(D ρ H) H³ρ ∇P, a function of the inverse Knudsen number.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from squeezefilm.film.scene import OperatingPoints, Scene, Scenes
from squeezefilm.film.validity import LEAST_INVERSE_KNUDSEN
from squeezefilm.reynolds.terms.term import Numbers, Simplification, Term

# Poiseuille flow Q by D, from the linearised BGK equation (verification/rarefied_flow.py).
TABLE = Path(__file__).with_name("rarefied_flow.csv")
# Q − D/6 for D → ∞, and the number of powers of u that interpolate the table to 1e-6.
SLIP, POWERS = 1.016191418, 17
# Above this Q counts as that in the fit: slip is a small part of a dense gas' flow.
LARGE_FLOW = 3.0


@lru_cache(maxsize=1)
def flow_series() -> tuple[float, ...]:
    """Return p_k of Q = D/6 + ln(1 + 1/D)/√π + Σ p_k u^k, where u = (√D − 2)/(√D + 2).

    The logarithm is that of free molecules, D → 0, and the sum is SLIP for D → ∞.
    """
    inverse, flow = np.loadtxt(TABLE, delimiter=",", skiprows=1, unpack=True)
    powers = np.vander(_mapped(inverse), POWERS, increasing=True)
    falling, weights = powers[:, :-1] - powers[:, 1:], 1 / np.minimum(flow, LARGE_FLOW)
    rest = flow - _limits(inverse) - SLIP
    series, *_ = np.linalg.lstsq(falling * weights[:, None], rest * weights, rcond=None)
    return tuple((np.append(series, 0.0) - np.append(-SLIP, series)).tolist())


def _limits(inverse: Any) -> Any:
    return inverse / 6 + np.log1p(1 / inverse) / np.sqrt(np.pi)


def _mapped(inverse: Any) -> Any:
    return (np.sqrt(inverse) - 2) / (np.sqrt(inverse) + 2)


def flow_factor(inverse: Any) -> tuple[Any, Any, Any]:
    """Return the flow over that of a viscous gas, W = 6 Q/D, and two derivatives by ln D.

    Args:
        inverse: inverse Knudsen numbers D = √π ρ H / (2 Kn), positive; ρ over its ambient value.
    """
    u, series = _mapped(inverse), np.polynomial.Polynomial(flow_series())
    free, slope, by_log = np.sqrt(np.pi) * (1 + inverse), series.deriv()(u), (1 - u**2) / 4
    growth = inverse / 6 - 1 / free + slope * by_log
    bend = series.deriv(2)(u) * by_log - slope * u / 2
    bend = inverse / 6 + inverse / (free * (1 + inverse)) + bend * by_log
    factor = 6 / inverse * (_limits(inverse) + series(u))
    first = 6 / inverse * growth - factor
    return factor, first, 6 / inverse * bend - 2 * first - factor


def flow_over_viscous(numbers: np.ndarray, mass: np.ndarray) -> np.ndarray:
    """Return W of scenes with some numbers: 1, 1 + 6 Kn/(ρ H) with slip, or the flow factor.

    Args:
        mass: ρ H, of any shape with the scenes first.
    """
    columns = (-1, *(1,) * (mass.ndim - 1))
    if "inverse_knudsen" in (numbers.dtype.names or ()):
        return np.asarray(flow_factor(numbers["inverse_knudsen"].reshape(columns) * mass)[0])
    first, *slip = (each.reshape(columns) for each in numbers["flow"].T)
    return np.asarray(first + sum(slip) / mass)


@dataclass(frozen=True)
class Rarefaction(Term):
    """First-order slip adds 6 Kn H² ∇P (Burgdorfer 1959), times the gas' ``slip_coefficient``.

    ``label`` is the gas' ``rarefaction``, ``slip`` or, as FlowFactor, ``fukui-kaneko``.
    """

    NAME = "rarefaction"
    ABSENT = Simplification("rarefaction", "gas.rarefaction is none")

    @classmethod
    def of(cls, scene: Scene) -> Rarefaction | None:
        kinds = {"slip": Rarefaction, "fukui-kaneko": FlowFactor}
        kind = kinds.get(scene.gas.rarefaction)
        return kind(scene.gas.rarefaction) if kind else None

    def numbers(self, scene: OperatingPoints) -> Numbers:
        return {"flow": (1.0, 6 * scene.slip_knudsen)}

    @property
    def in_expansions(self) -> bool:
        return True


@dataclass(frozen=True)
class FlowFactor(Rarefaction):
    """The flow factor W of the linearised BGK equation, as Fukui and Kaneko's (1988)."""

    NAME = "flow_factor"
    OVER_PERIOD = "terms/rarefaction_over_period.cl"

    def numbers(self, scene: OperatingPoints) -> Numbers:
        return {
            "flow": (-0.5, 0.5),
            "inverse_knudsen": scene.inverse_knudsen,
            "inverse_exponent": 1 / scene.gas.polytropic_exponent,
            "flow_series": flow_series(),
        }

    @property
    def in_expansions(self) -> bool:
        return False

    def refused_states(self, scenes: Scenes, *, thinnest: np.ndarray) -> Mapping[int, str]:
        least = scenes.inverse_knudsen * thinnest
        return {
            row: f"gas too rarefied: D falls to {least[row]:.2g}, below {LEAST_INVERSE_KNUDSEN:g}"
            for row in np.flatnonzero(least < LEAST_INVERSE_KNUDSEN).tolist()
        }
