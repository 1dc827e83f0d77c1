"""Rarefaction: slip at the walls, or the flow of a gas at any Knudsen number.

The mass flux becomes H³ρ ∇P + c H² F ∇P. First-order slip has c = 6 Kn and F = 1. The flow factor
has c = 6/D and F = Q − x/6, the part of the Poiseuille flow Q by which a viscous gas would not
flow, a function of the local inverse Knudsen number x = D ρ H.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from squeezefilm.film.scene import OperatingPoints, Scene
from squeezefilm.reynolds.terms.term import AbsentTerm, NamedNumbers, Term

# Poiseuille flow Q by x, from the linearised BGK equation (verification/rarefied_flow.py).
FLOW_TABLE_PATH = Path(__file__).with_name("rarefied_flow.csv")
# F for x → ∞, and the number of powers of u that interpolate the table to 1e-6.
SLIP_FLOW_LIMIT, FLOW_SERIES_TERM_COUNT = 1.016191418, 16
# Above this Q counts as that in the fit: slip is a small part of a dense gas' flow.
MAX_FIT_FLOW_FACTOR = 3.0


@lru_cache(maxsize=1)
def slip_flow_series_coefficients() -> tuple[float, ...]:
    """Return s_k of F = ln(1 + 1/x)/√π + Σ s_k u^k, where u = (√x − 2)/(√x + 2).

    The logarithm is that of free molecules, x → 0, and the sum is SLIP_FLOW_LIMIT for x → ∞.
    """
    inverse, flow = np.loadtxt(FLOW_TABLE_PATH, delimiter=",", skiprows=1, unpack=True)
    powers = np.vander(_chebyshev_argument(inverse), FLOW_SERIES_TERM_COUNT, increasing=True)
    falling, weights = powers[:, :-1] - powers[:, 1:], 1 / np.minimum(flow, MAX_FIT_FLOW_FACTOR)
    rest = flow - inverse / 6 - np.log1p(1 / inverse) / np.sqrt(np.pi) - SLIP_FLOW_LIMIT
    series, *_ = np.linalg.lstsq(falling * weights[:, None], rest * weights, rcond=None)
    return tuple((np.append(series, 0.0) - np.append(-SLIP_FLOW_LIMIT, series)).tolist())


def _chebyshev_argument(inverse: Any) -> Any:
    return (np.sqrt(inverse) - 2) / (np.sqrt(inverse) + 2)


def slip_flow(inverse: Any) -> Any:
    """Return F at some inverse Knudsen numbers x > 0."""
    series = np.polynomial.Polynomial(slip_flow_series_coefficients())
    return np.log1p(1 / inverse) / np.sqrt(np.pi) + series(_chebyshev_argument(inverse))


def slip_flow_derivatives(inverse: Any) -> tuple[Any, Any]:
    """Return the first two derivatives of F by ln x at some inverse Knudsen numbers x > 0."""
    u, series = (
        _chebyshev_argument(inverse),
        np.polynomial.Polynomial(slip_flow_series_coefficients()),
    )
    slope, by_log, free = series.deriv()(u), (1 - u**2) / 4, 1 / (1 + inverse) / np.sqrt(np.pi)
    bend = (series.deriv(2)(u) * by_log - slope * u / 2) * by_log
    return slope * by_log - free, bend + free * inverse / (1 + inverse)


def slip_coefficient_and_argument(
    numbers: np.ndarray, mass: np.ndarray
) -> tuple[np.ndarray, np.ndarray | None]:
    """Return c of scenes that slip, and x where F is not 1.

    Args:
        numbers: of the scenes' equation, (n,).
        mass: ρ H, of any shape with the scenes first.
    """
    columns = (-1, *(1,) * (mass.ndim - 1))
    coefficient, inverse = numbers["flow"][:, 1].reshape(columns), None
    if "inverse_knudsen" in (numbers.dtype.names or ()):
        inverse = numbers["inverse_knudsen"].reshape(columns) * mass
    return coefficient, inverse


def flow_to_viscous_ratio(numbers: np.ndarray, mass: np.ndarray) -> np.ndarray:
    """Return the flow over that of a viscous gas, W = 1 + c F/(ρ H); arguments as of slip_of."""
    if numbers["flow"].shape[1] == 1:
        return np.ones_like(mass)
    coefficient, inverse = slip_coefficient_and_argument(numbers, mass)
    flow = 1.0 if inverse is None else slip_flow(inverse)
    return np.asarray(1 + coefficient * flow / mass)


class Rarefaction(Term):
    """First-order slip (Burgdorfer 1959), with the gas' ``slip_coefficient``."""

    label = "slip"
    NAME = "rarefaction"
    EQUATION_NUMBER_WIDTHS: ClassVar[Mapping[str, int]] = {"flow": 2}
    ABSENT_TERM = AbsentTerm("rarefaction", "gas.rarefaction is none", "no slip")
    SUPPORTS_EXPANSIONS = True

    @classmethod
    def of(cls, scene: Scene) -> Rarefaction | None:
        kinds = {kind.label: kind for kind in (Rarefaction, FlowFactor)}
        kind = kinds.get(scene.gas.rarefaction)
        return kind() if kind else None

    def equation_numbers(self, scene: OperatingPoints) -> NamedNumbers:
        return {"flow": (1.0, 6 * scene.slip_knudsen)}


class FlowFactor(Rarefaction):
    """Flow by the linearised Boltzmann equation, as of Fukui and Kaneko, J. Tribology 110, 1988."""

    label = "fukui-kaneko"
    NAME = "flow_factor"
    EQUATION_NUMBER_WIDTHS: ClassVar[Mapping[str, int]] = {
        "flow": 2,
        "inverse_knudsen": 0,
        "slip_series": FLOW_SERIES_TERM_COUNT,
    }
    KERNEL_FILE = "terms/rarefaction_over_period.cl"
    SUPPORTS_EXPANSIONS = False

    def equation_numbers(self, scene: OperatingPoints) -> NamedNumbers:
        return {
            "flow": (1.0, 6 / scene.inverse_knudsen),
            "inverse_knudsen": scene.inverse_knudsen,
            "slip_series": slip_flow_series_coefficients(),
        }
