"""The OpenCL solver on one given grid, without its own choice of resolution."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from numerics.films import Film
from squeezefilm.reynolds.device import Device
from squeezefilm.reynolds.grid import Grid
from squeezefilm.reynolds.periodic import Problems, States, solve_batch


def solve_on_grid(films: Sequence[Film], *, grid: Grid, tolerance: float, device: Device) -> States:
    """The periodic states of films that differ in epsilon and sigma alone.

    tolerance: relative error of the force that Newton's method may leave.
    """
    return solve_batch(
        problems=problems_on_grid(films, grid=grid, tolerance=tolerance), grid=grid, device=device
    )


def problems_on_grid(films: Sequence[Film], *, grid: Grid, tolerance: float) -> Problems:
    """The films as the kernels take them; they differ in epsilon and sigma alone."""
    first = films[0]
    x, y = np.meshgrid(grid.x.all_nodes, grid.y.all_nodes, indexing="ij")
    return Problems(
        epsilon=np.array([film.epsilon for film in films]),
        sigma=np.array([film.sigma for film in films]),
        bearing=np.array([film.bearing for film in films]),
        inverse_exponent=np.ones(len(films)),
        flow=np.array([film.scene.flow_coefficients for film in films]),
        aspect=first.aspect,
        amplitude=np.repeat(first.amplitude(x, y)[None], len(films), axis=0),
        tolerance=tolerance,
    )
