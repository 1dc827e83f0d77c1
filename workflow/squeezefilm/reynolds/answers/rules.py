"""Points and weights of the mean over a pad."""

from __future__ import annotations

import numpy as np


def pad_rule(shape: str, points: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Gauss' rule over a pad in [0, 1] × [0, 1]: x, y and weights of sum 1, each shape (Q,).

    For an ellipse along the radius, with equidistant angles.

    Args:
        points: along a side, or a radius; around there are twice as many.
    """
    nodes, shares = np.polynomial.legendre.leggauss(points)
    nodes, shares = (1 + nodes) / 2, shares / 2
    if shape == "ellipse":
        angles = np.pi * np.arange(2 * points) / points
        radii, angle = np.meshgrid(nodes / 2, angles, indexing="ij")
        weights = np.multiply.outer(2 * nodes * shares, np.full(2 * points, 0.5 / points))
        x, y = 0.5 + radii * np.cos(angle), 0.5 + radii * np.sin(angle)
    else:
        x, y = np.meshgrid(nodes, nodes, indexing="ij")
        weights = np.multiply.outer(shares, shares)
    return x.ravel(), y.ravel(), weights.ravel()
