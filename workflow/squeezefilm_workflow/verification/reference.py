"""A reference of the mean force that shares neither equation nor discretisation with any method.

Scheme: Legendre spectral elements in space, in the weak form of

    div(H^3 grad u) = sigma d(HP)/dT,     u = (P^2 - 1)/2,     P = sqrt(1 + 2 u),

with Gauss-Lobatto nodes, two elements per half side, the outer one narrow for the layer at the
edge; an odd number of instants with trigonometric interpolation in time; Newton's method with
GMRES on the weak form. Where the solver under test collocates strong derivatives of other
variables on Chebyshev points, here an integral identity is met in another basis. Only the steps
of Newton's method are those of ``numpy_periodic``: the residual shows their error.

Uncertainty: the change from a coarser computation, in space and time at once, and round-off.
Source: Karniadakis and Sherwin, Spectral/hp Element Methods, 2005, chapters 2 and 4.
"""

import math
from typing import NamedTuple

import numpy as np
from scipy.interpolate import BarycentricInterpolator
from scipy.linalg import block_diag, eigh
from scipy.special import eval_legendre, roots_jacobi

from squeezefilm.film.scene import Scene
from squeezefilm_workflow.verification.marching import (
    FloatArray,
    LinearMap,
    film_symmetry_in_x_and_y,
    newton_krylov,
)

FORCE_ROUND_OFF = 1e-13  # of the force, in units of p0 l0^2
NEWTON_TOLERANCE = 1e-12  # of Newton's method, on a mass perturbation


class ReferenceForce(NamedTuple):
    """A mean force in units of p0 l0^2 and how far it may be from the truth."""

    force: float
    uncertainty: float


def reference_force(scene: Scene, *, degree: int = 18) -> ReferenceForce:
    """The mean force of a square film without any term but that of the gap's shape.

    Args:
        degree: of the elements; the coarser computation has 4 less and four fifths of the instants.

    Raises RunError when Newton's method does not converge.
    """
    closure = scene.closure()
    ratio = closure / (1 + math.sqrt(1 - closure**2))
    instants = 20 + math.ceil(1.3 * math.log(1e-12) / math.log(ratio))
    fewer = instants * 4 // 5
    coarse = _mean_force(scene, degree=degree - 4, instants=fewer + 1 - fewer % 2)
    fine = _mean_force(scene, degree=degree, instants=instants + 1 - instants % 2)
    return ReferenceForce(force=fine, uncertainty=abs(fine - coarse) + FORCE_ROUND_OFF)


class _SpectralElementSide:
    """Spectral elements along one side: global nodes that carry unknowns, and element nodes."""

    def __init__(self, *, degree: int, folded: bool) -> None:
        half = np.array([0.0, 0.09, 0.5])
        edges = half if folded else np.concatenate([half, 1 - half[-2::-1]])
        nodes, weights, derivative = gauss_lobatto_rule(degree)
        widths = np.diff(edges)
        # Of each element's nodes the global ones, the last of an element the first of the next.
        node_indices = (degree * np.arange(len(widths))[:, None] + np.arange(degree + 1)).ravel()
        gather, x = np.eye(node_indices[-1] + 1)[node_indices], np.zeros(node_indices[-1] + 1)
        slope = block_diag(*(derivative * 2 / width for width in widths)) @ gather
        self.element_weights = np.outer(widths, weights).ravel() / 2
        x[node_indices] = (edges[:-1, None] + np.outer(widths, nodes + 1) / 2).ravel()
        free = slice(1, None if folded else -1)
        self.x, self.gather, self.slope = x[free], gather[:, free], slope[:, free]
        self.mass = self.gather.T @ self.element_weights
        self.element_x = x[node_indices]
        stiffness = self.slope.T @ (self.element_weights[:, None] * self.slope)
        self.values, self.modes = eigh(stiffness, np.diag(self.mass))


def gauss_lobatto_rule(degree: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Gauss-Lobatto-Legendre nodes on [-1, 1], weights, and the derivative matrix."""
    # The inner nodes are the zeros of the derivative of Legendre's polynomial.
    nodes = np.concatenate([[-1.0], roots_jacobi(degree - 1, 1, 1)[0], [1.0]])
    weights = 2 / (degree * (degree + 1) * eval_legendre(degree, nodes) ** 2)
    interpolation = BarycentricInterpolator(nodes, np.eye(degree + 1), rng=0)
    return nodes, weights, interpolation.derivative(nodes)


def _mean_force(scene: Scene, *, degree: int, instants: int) -> float:
    sigma, fold = scene.sigma, film_symmetry_in_x_and_y(scene)
    x, y = (_SpectralElementSide(degree=degree, folded=folded) for folded in fold)
    phase = 2 * math.pi * np.arange(instants) / instants

    def gap_at(x_nodes: FloatArray, y_nodes: FloatArray) -> FloatArray:
        return scene.gap(*np.meshgrid(x_nodes, y_nodes, indexing="ij"), phase)

    height = gap_at(x.x, y.x)
    conductance_x = np.outer(x.element_weights, y.mass)[..., None] * gap_at(x.element_x, y.x) ** 3
    conductance_y = np.outer(x.mass, y.element_weights)[..., None] * gap_at(x.x, y.element_x) ** 3
    area = np.outer(x.mass, y.mass)[..., None]
    laplacian = np.add.outer(x.values, y.values)[..., None]
    i_k = 1j * np.arange(instants // 2 + 1)

    def time_derivative(mass: FloatArray) -> FloatArray:
        return np.fft.irfft(i_k * np.fft.rfft(mass), n=instants)

    def diffusion_term(u: FloatArray) -> FloatArray:
        along_x = np.tensordot(x.slope.T, conductance_x * np.tensordot(x.slope, u, 1), 1)
        along_y = np.matmul(y.slope.T, conductance_y * np.matmul(y.slope, u))
        return np.asarray(along_x + along_y)

    squeeze = time_derivative(height)

    def linearised_equation(u: FloatArray) -> tuple[FloatArray, LinearMap, FloatArray]:
        pressure = np.sqrt(1 + 2 * u)
        symbol = np.mean(height**2 * pressure) * laplacian + sigma * i_k
        to_u = pressure / height

        def precondition(r: FloatArray) -> FloatArray:
            modes = np.matmul(y.modes.T, np.tensordot(x.modes.T, r, 1))
            modes = np.fft.irfft(np.fft.rfft(modes) / symbol, n=instants)
            return np.asarray(np.matmul(y.modes, np.tensordot(x.modes, modes, 1)))

        # H P = H + H p, and the rate of H is known.
        stored = sigma * area * (time_derivative(height * 2 * u / (1 + pressure)) + squeeze)
        return (
            precondition(diffusion_term(u) + stored),
            lambda w: precondition(diffusion_term(to_u * w) + sigma * area * time_derivative(w)),
            to_u,
        )

    u = newton_krylov(
        height.shape, linearised_equation, positive=lambda u: 1 + 2 * u, tolerance=NEWTON_TOLERANCE
    )
    gauge_pressure_ratio = 2 * u / (1 + np.sqrt(1 + 2 * u))
    return float(2 ** sum(fold) * np.sum(area[:, :, 0] * gauge_pressure_ratio.mean(axis=-1)))
