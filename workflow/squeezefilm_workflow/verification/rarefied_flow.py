"""Flow of a rarefied gas between parallel walls, by the linearised BGK equation.

A gradient of pressure drives a gas between diffusely reflecting walls (accommodation 1). With
lengths over the mean free path, so that the gap is the inverse Knudsen number D, the velocity's
profile follows from an integral equation (Cercignani and Daneri, J. Appl. Phys. 34, 1963, 3509),

    ψ(y) = 1 + (1/√π) ∫ T(|y − y'|) ψ(y') dy',    Q_P = (∫ψ dy − D) / D²,    |y| ≤ D/2,

with T(x) = ∫ exp(−t² − x/t) dt/t over t > 0. It is collocated in Gauss–Legendre points of a
variable that crowds at the walls, where ψ has a logarithmic slope; the integral, whose kernel has a
logarithm at y' = y, is taken on either side by the tanh-sinh rule.

``python -m squeezefilm_workflow.verification.rarefied_flow`` prints the table that the flow factor
interpolates (squeezefilm/reynolds/terms/rarefied_flow.csv).
"""

import numpy as np
from scipy.interpolate import BarycentricInterpolator

# Inverse Knudsen numbers of the table, ten for each decade.
TABULATED_INVERSE_KNUDSEN = 10.0 ** (np.arange(-20, 31) / 10)
# Of t in T(x), by the trapezoidal rule in ln t.
LOG_T_NODES, LOG_T_STEP = np.linspace(-45, 2.2, 900, retstep=True)


def poiseuille_flow(inverse_knudsen: float, *, points: int = 60, half_rule: int = 50) -> float:
    """Return Q_P, the flow relative to a scale of free molecules, at an inverse Knudsen number.

    A viscous gas has D/6. Sixty points give ten digits up to D = 100 and eight at D = 1000.

    Args:
        points: collocation points across the gap.
        half_rule: nodes of the tanh-sinh rule on either side of its middle.
    """
    half = inverse_knudsen / 2
    at, weights = np.polynomial.legendre.leggauss(points)
    spread, step = np.linspace(-3.2, 3.2, 2 * half_rule + 1, retstep=True)
    quadrature_nodes = (1 + np.tanh(np.pi / 2 * np.sinh(spread))) / 2
    node_weights = step * np.pi / 4 * np.cosh(spread) / np.cosh(np.pi / 2 * np.sinh(spread)) ** 2
    interpolation = BarycentricInterpolator(at, np.eye(points), rng=0)
    equation = np.eye(points)
    for row, point in enumerate(at.tolist()):
        for length in (-1 - point, 1 - point):
            nodes = point + length * quadrature_nodes
            kernel = _abramowitz_function(
                half
                * np.abs(
                    _wall_clustered_position(nodes) - _wall_clustered_position(np.array(point))
                )
            )
            kernel *= (
                half * _wall_clustering_slope(nodes) * abs(length) * node_weights / np.sqrt(np.pi)
            )
            equation[row] -= kernel @ interpolation(nodes)
    profile = np.linalg.solve(equation, np.ones(points))
    return float(
        (half * weights * _wall_clustering_slope(at) @ profile - 2 * half) / (2 * half) ** 2
    )


def _abramowitz_function(x: np.ndarray) -> np.ndarray:
    """T(x) of each x, shape (n,)."""
    t = np.exp(LOG_T_NODES)
    return np.exp(-(t**2) - np.maximum(x, 1e-18)[:, None] / t).sum(axis=1) * LOG_T_STEP


def _wall_clustered_position(q: np.ndarray) -> np.ndarray:
    """Place across the gap, −1 … 1, of a variable in which places crowd at both walls."""
    return (35 * q - 35 * q**3 + 21 * q**5 - 5 * q**7) / 16


def _wall_clustering_slope(q: np.ndarray) -> np.ndarray:
    """Slope of ``_wall_clustered_position``."""
    return 35 / 16 * (1 - q**2) ** 3


if __name__ == "__main__":
    print("inverse_knudsen,poiseuille_flow")
    for inverse_knudsen in TABULATED_INVERSE_KNUDSEN:
        print(f"{inverse_knudsen:.10g},{poiseuille_flow(inverse_knudsen):.9g}")
