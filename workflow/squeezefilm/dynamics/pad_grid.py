"""Nodes under a pad: ∇², the mean over the pad, the film edge and the profile's slope there."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np

from squeezefilm.film.outline import DISC_COORDINATES, Outline
from squeezefilm.film.scene import Scene
from squeezefilm.film.symmetry import axisymmetric_mask
from squeezefilm.reynolds.asymptotics.edge_layer import quadrature_weights_with_ends
from squeezefilm.reynolds.asymptotics.films import Films
from squeezefilm.reynolds.spectral import cached_axis, cached_radial_axis, cached_time_axis

# Nodes around an outline for each one along a line through its middle.
NODES_AROUND_PER_NODE_ACROSS = 2
# Of the slowest mode's rate, and the steps in which it is found.
DECAY_RATE_PRECISION, MAX_DECAY_RATE_ITERATIONS = 1e-10, 100


class AmplitudeFunction(Protocol):
    """Profile at positions in [0, 1] across the pad."""

    def __call__(self, x: np.ndarray, y: np.ndarray) -> np.ndarray: ...


@dataclass(frozen=True)
class PadGrid:
    """Fields are flat over the nodes; lengths are in units of the pad's length along x.

    Attributes:
        points: nodes inside along a line through the pad's middle, or about as many.
        s: profile, s₁ + i s₂ of two quadrature components, shape (nodes,).
        inner_mask: whether a node is inside the film edge, (nodes,).
        laplacian: ∇² at the inner nodes of a field on all nodes, (inner, nodes).
        mean_weights: of the mean over the pad, (nodes,).
        edge_s, edge_slope: profile and its derivative along the inward normal on the edge, (edge,).
        edge_weights: of the integral along the edge over the pad's area, (edge,).
        edge_to_nodes_matrix: matrix from values on the edge to the nodes there, (nodes − inner,
            edge).
    """

    points: int
    s: np.ndarray
    inner_mask: np.ndarray
    laplacian: np.ndarray
    mean_weights: np.ndarray
    edge_s: np.ndarray
    edge_slope: np.ndarray
    edge_weights: np.ndarray
    edge_to_nodes_matrix: np.ndarray

    @property
    def inner_laplacian(self) -> np.ndarray:
        """∇² of fields that are zero on the edge, (inner, inner)."""
        return self.laplacian[:, self.inner_mask]

    def laplacian_of_edge_values(self, on_edge: np.ndarray) -> np.ndarray:
        """∇² at the inner nodes of values on the edge's nodes that are zero inside, (inner,)."""
        return np.asarray(self.laplacian[:, ~self.inner_mask] @ on_edge)

    @property
    def edge_mean_square_ratio(self) -> float:
        """Mean of |s|² along the edge over that of the pad."""
        around = self.edge_weights @ np.abs(self.edge_s) ** 2 / self.edge_weights.sum()
        return float(around / (self.mean_weights @ np.abs(self.s) ** 2))

    @cached_property
    def slowest_decay_rate(self) -> float:
        """The least eigenvalue of −∇² for fields that are zero on the edge, by inverse iteration.

        A film at rest forgets in 1/that of σ/ω.
        """
        inverse, rate = np.linalg.inv(-self.inner_laplacian), 0.0
        mode = np.ones(len(inverse))
        for _ in range(MAX_DECAY_RATE_ITERATIONS):
            previous, mode = rate, inverse @ mode
            rate = 1 / float(np.abs(mode).max())
            mode *= rate
            if abs(rate - previous) <= DECAY_RATE_PRECISION * rate:
                break
        return rate


def pad_grid(scene: Scene, points: int) -> PadGrid:
    """The nodes of a scene's pad that is no rectangle, ``points`` + 1 inside along its middle."""
    outline = scene.pad.smooth_outline
    assert outline
    if axisymmetric_mask(scene.pad_positions)[0]:
        return disc_grid(scene.amplitude, points)
    return outline_grid(outline, scene.amplitude, points)


def rectangle_grid(films: Films) -> PadGrid:
    """The nodes of one film (B = 1) under a rectangle; a corner has the mean of its two sides."""
    axes = (films.x_axis, films.y_axis)
    second_x, second_y = (axis.derivative_matrix @ axis.derivative_matrix for axis in axes)
    along_x = np.kron(second_x, np.eye(len(second_y)))
    along_y = np.kron(np.eye(len(second_x)), second_y) / films.aspect[0] ** 2
    inside = np.zeros(films.s.shape[1:], dtype=bool)
    inside[1:-1, 1:-1] = True
    inner = inside.ravel()
    indices = np.arange(inner.size).reshape(films.s.shape[1:])
    node_of_edge = films.edge_values(indices[None])[0]
    on_node = np.equal.outer(np.flatnonzero(~inner), node_of_edge)
    return PadGrid(
        points=films.x_axis.unknown_count,
        s=films.s[0].ravel(),
        inner_mask=inner,
        laplacian=(along_x + along_y)[inner],
        mean_weights=np.outer(
            quadrature_weights_with_ends(films.x_axis), quadrature_weights_with_ends(films.y_axis)
        ).ravel(),
        edge_s=films.edge_profile[0],
        edge_slope=films.edge_normal_slope[0],
        edge_weights=films.edge_integral(np.eye(len(node_of_edge))),
        edge_to_nodes_matrix=on_node / on_node.sum(axis=1, keepdims=True),
    )


def disc_grid(amplitude: AmplitudeFunction, points: int) -> PadGrid:
    """The nodes along the radius of a disc whose profile has no angle: twice as many, cheaply."""
    line = cached_radial_axis(points + 1)
    near, far = _matrix_halves(line.divergence_matrix @ line.derivative_matrix)
    slope_near, slope_far = _matrix_halves(line.derivative_matrix)
    slope = slope_near[-1] + slope_far[-1]
    across = line.all_nodes[line.unknown_count + 1 :]
    s = amplitude(*DISC_COORDINATES.side_fractions(across, np.zeros_like(across)))
    weights = line.quadrature_weights[::-1]
    inner = np.arange(len(across)) < line.unknown_count
    return PadGrid(
        points=points,
        s=s,
        inner_mask=inner,
        laplacian=(near + far)[inner],
        mean_weights=np.append(weights, 1 - weights.sum()),
        edge_s=s[-1:],
        edge_slope=-slope @ s[:, None],
        edge_weights=np.array([4.0]),
        edge_to_nodes_matrix=np.eye(1),
    )


def outline_grid(outline: Outline, amplitude: AmplitudeFunction, points: int) -> PadGrid:
    """The nodes μ > 0, ν of an outline's coordinates (film/outline.py): f(−μ, ν) = f(μ, −ν)."""
    line = cached_axis(points + 1, False)
    angle = cached_time_axis(NODES_AROUND_PER_NODE_ACROSS * (points + 1))
    unit = 2 * outline.edge_mu
    across, nu = np.meshgrid(line.all_nodes[len(line.all_nodes) // 2 :], angle.nodes, indexing="ij")
    stretch = outline.map_jacobian(unit * (across - 0.5), nu)
    s = amplitude(*outline.side_fractions(across.ravel(), nu.ravel())).reshape(across.shape)
    mirrored = -np.arange(angle.instant_count) % angle.instant_count
    near, far = _matrix_halves(line.derivative_matrix @ line.derivative_matrix)
    around, same = angle.derivative_matrix @ angle.derivative_matrix, np.eye(angle.instant_count)
    laplacian = (np.kron(near, same) + np.kron(far, same[mirrored])) / unit**2
    laplacian += np.kron(np.eye(len(near)), around)
    inside = np.ones(across.shape, dtype=bool)
    inside[-1] = False
    inner = inside.ravel()
    slope_near, slope_far = _matrix_halves(line.derivative_matrix)
    slope = (slope_near[-1] @ s + slope_far[-1] @ s[:, mirrored]) / unit
    length, step = np.sqrt(stretch[-1]), 2 * np.pi / angle.instant_count
    weights = (
        quadrature_weights_with_ends(line)[len(across) :, None]
        * unit
        * step
        * stretch
        / outline.area
    )
    return PadGrid(
        points=points,
        s=s.ravel(),
        inner_mask=inner,
        laplacian=(laplacian / stretch.ravel()[:, None])[inner],
        mean_weights=weights.ravel(),
        edge_s=s[-1],
        edge_slope=-slope / length,
        edge_weights=length * step / outline.area,
        edge_to_nodes_matrix=same,
    )


def _matrix_halves(matrix: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Parts of a matrix on all nodes for the second half: by its values and by the first's."""
    half = len(matrix) // 2
    return matrix[half:, half:], matrix[half:, half - 1 :: -1]
