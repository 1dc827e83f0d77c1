"""The OpenCL solver on one given grid, without its own choice of resolution."""

from collections.abc import Sequence

from numerics.films import Film
from squeezefilm.reynolds.device import Device
from squeezefilm.reynolds.grid import Grid
from squeezefilm.reynolds.periodic.launch import solve_batch
from squeezefilm.reynolds.periodic.states import States
from squeezefilm.reynolds.problems import Problems, problems_of


def solve_on_grid(films: Sequence[Film], *, grid: Grid, tolerance: float, device: Device) -> States:
    """The periodic states of films that differ in epsilon and sigma alone.

    tolerance: relative error of the force that Newton's method may leave.
    """
    return solve_batch(
        problems=problems_on_grid(films, grid=grid, tolerance=tolerance), grid=grid, device=device
    )


def problems_on_grid(films: Sequence[Film], *, grid: Grid, tolerance: float) -> Problems:
    """The films as the kernels take them; they differ in epsilon and sigma alone."""
    return problems_of([film.scene for film in films], grid, tolerance=tolerance)
