"""Nodes under pads of every shape: ∇², the mean and the slope at the edge belong together."""

from functools import partial

import numpy as np
import pytest

from squeezefilm.dynamics.pad_grid import disc_grid, outline_grid, rectangle_grid
from squeezefilm.film.outline import Outline, ellipse_outline
from squeezefilm.reynolds.asymptotics.films import expansion_axis, films_of

# An oval with a bulge to one side; its own middle is not where x and y begin.
OVAL = Outline(np.array([0, 0.4, 0.02 + 0.01j]), 0.7, 1.0)
CURVATURE = 4.0


def profile(x, y, aspect=1.0):
    """x² + y² and a harmonic part, from the middle: ∇² is CURVATURE everywhere."""
    x, y = x - 0.5, (y - 0.5) * aspect
    return 1 + x**2 + y**2 + x**3 - 3 * x * y**2


def bowl(x, y):
    return 1 + (x - 0.5) ** 2 + (y - 0.5) ** 2


def rectangle(aspect):
    nodes = expansion_axis(11).all_nodes
    s = profile(*np.meshgrid(nodes, nodes, indexing="ij"), aspect)
    return rectangle_grid(films_of(np.array([0.1]), np.array([1.0]), s[None], aspect=aspect))


GRIDS = {
    "rectangle": partial(rectangle, 0.6),
    "disc": partial(disc_grid, bowl, 11),
    "disc off centre": partial(outline_grid, ellipse_outline(1.0), profile, 21),
    "ellipse": partial(outline_grid, ellipse_outline(0.5), partial(profile, aspect=0.5), 21),
    "oval": partial(outline_grid, OVAL, profile, 21),
}


@pytest.mark.parametrize("pad", GRIDS)
def test_what_flows_through_the_edge_is_what_the_pad_gives(pad):
    """Gauss: the outward slope's integral along the edge, over the area, is the mean of ∇²."""
    grid = GRIDS[pad]()
    assert grid.laplacian @ grid.s == pytest.approx(
        np.full(grid.inner_mask.sum(), CURVATURE), rel=1e-6
    )
    assert grid.mean_weights.sum() == pytest.approx(1, abs=1e-9)
    assert -grid.edge_weights @ grid.edge_slope == pytest.approx(CURVATURE, rel=1e-8)
    assert grid.edge_to_nodes_matrix @ grid.edge_s == pytest.approx(
        grid.s[~grid.inner_mask], rel=1e-12
    )
