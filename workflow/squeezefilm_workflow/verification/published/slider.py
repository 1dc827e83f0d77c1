"""An infinitely wide, inclined slider on a gas: exact, and as its pressure was published.

Between a pad at rest and a surface that moves, (H³ P P′ − Λ H P)′ = 0 and P = 1 at both ends
(Harrison 1913): an equation of first order in which one constant, the flow, is to be determined.
"""

import numpy as np
from scipy.integrate import solve_bvp

from squeezefilm.errors import RunError
from squeezefilm.film.scene import Scene

SLIDER_NODE_COUNT = 200_001
"""Among which the largest pressure is taken."""


PressureLoadAndCentre = tuple[float, float, float]
"""Largest pressure over p0, load over p0 and area, centre of pressure over the length.

The centre is counted from the end where the surface enters.
"""


def slider_quantities_of_cells(x: np.ndarray, pressure: np.ndarray) -> PressureLoadAndCentre:
    """Largest pressure, load and centre of pressures over p0 in equal cells along the length."""
    load = np.mean(pressure - 1)
    return float(pressure.max()), float(load), float(np.mean(x * (pressure - 1)) / load)


def exact_slider_quantities(scene: Scene) -> PressureLoadAndCentre:
    """Largest pressure, load and centre of a scene's gap at rest along x, its speed and gas.

    Raises RunError where the boundary-value problem is not solved.
    """

    def pressure_equations(x: np.ndarray, y: np.ndarray, flow: np.ndarray) -> np.ndarray:
        gap, pressure = 1 + scene.pad.gap.rise_m(x, np.full_like(x, 0.5)) / scene.h0_m, y[0]
        slope = (scene.bearing_number * gap * pressure - flow) / (gap**3 * pressure)
        return np.stack([slope, pressure - 1, x * (pressure - 1)])

    def boundary_conditions(left: np.ndarray, right: np.ndarray, _: np.ndarray) -> np.ndarray:
        return np.append(left - [1, 0, 0], right[0] - 1)

    x = np.linspace(0, 1, 401)
    start = np.stack([1 + x * (1 - x), x / 6, x / 12])
    solution = solve_bvp(
        pressure_equations,
        boundary_conditions,
        x,
        start,
        p=[scene.bearing_number],
        tol=1e-9,
        max_nodes=10**5,
    )
    if not solution.success:
        raise RunError(f"exact slider: {solution.message}")
    pressure, load, moment = solution.sol(np.linspace(0, 1, SLIDER_NODE_COUNT))
    return float(pressure.max()), float(load[-1]), float(moment[-1] / load[-1])
