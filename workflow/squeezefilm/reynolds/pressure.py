"""The pressure under a finger over a period, at wanted places: what a force is the mean of."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from squeezefilm.film.finger import Finger
from squeezefilm.film.scene import Scene
from squeezefilm.io.errors import RunError
from squeezefilm.reynolds.device import Device
from squeezefilm.reynolds.error_estimate import ITERATION_SHARE
from squeezefilm.reynolds.grid import Grid
from squeezefilm.reynolds.needs import needs_of
from squeezefilm.reynolds.periodic.launch import solve_batch
from squeezefilm.reynolds.periodic.resolution import finer_grid, grid_for
from squeezefilm.reynolds.periodic.sizes import iteration_flops
from squeezefilm.reynolds.periodic.states import STATUS
from squeezefilm.reynolds.plan import plans_of
from squeezefilm.reynolds.self_test import check_device
from squeezefilm.reynolds.spectral import period
from squeezefilm.reynolds.terms import states_refused

# Operations of iterations beyond which no finer grid is tried: some ten to twenty seconds.
MOST_WORK = 1e11
NO_STATE = "no periodic state was found in which the pressure holds the tolerance at every place"


@dataclass(frozen=True)
class Pressure:
    """Overpressure P − 1 in units of the ambient pressure.

    Attributes:
        values: at each instant and place, shape (instants, ny, nx); NaN outside the pad.
        change: largest change of a value by the last refinement, in the same unit.
    """

    values: np.ndarray
    change: float


def pressure(
    scene: Scene,
    *,
    x: np.ndarray,
    y: np.ndarray,
    instants: int,
    tolerance: float,
    device: Device,
) -> Pressure:
    """The periodic film's overpressure at places x (nx,) and y (ny,) in [0, 1] across the finger.

    ``instants`` are equidistant from phase 0 on. Grids are refined until no value changes by more
    than ``tolerance`` of the largest. Inertia must be decided (effects/automatic.py).
    Raises RunError saying why there is no such pressure.
    """
    needs = needs_of(scene)
    if plans := plans_of(needs, tolerance=tolerance, method="periodic"):
        raise RunError(plans[0].refused)
    if not device.processor:
        check_device(device)
    grid: Grid | None = grid_for(needs, tolerance=tolerance)[0]
    before: np.ndarray | None = None
    ending = NO_STATE
    work, most = 0.0, min((term.MOST_WORK for term in needs.terms), default=MOST_WORK)
    while grid is not None and work <= most:
        states = solve_batch([scene], grid, tolerance=ITERATION_SHARE * tolerance, device=device)
        work += float(states.krylov_iterations[0]) * iteration_flops(grid, needs.terms)
        if states.status[0] != 0:
            before, ending = None, STATUS[states.status[0]]
        else:
            if refused := states_refused(needs.scenes, needs.terms, thinnest=states.thinnest):
                raise RunError(refused[0])
            found = _at(
                states.overpressure[0], grid, finger=scene.finger, x=x, y=y, instants=instants
            )
            if before is not None:
                change = float(np.nanmax(np.abs(found - before)))
                if change <= tolerance * np.nanmax(np.abs(found)):
                    return Pressure(found, change)
            before, ending = found, NO_STATE
        grid = finer_grid(grid)
    raise RunError(ending)


def _at(
    unknowns: np.ndarray,
    grid: Grid,
    *,
    finger: Finger,
    x: np.ndarray,
    y: np.ndarray,
    instants: int,
) -> np.ndarray:
    """A state on a grid, shape (nx, ny, nt), at other places and instants: (instants, y, x)."""
    in_time = period(grid.nt).interpolation_to(period(instants))
    if grid.outline is None:
        along_x, along_y = grid.x.at(x), grid.y.at(y)
        return np.einsum("ti,yb,xa,abi->tyx", in_time, along_y, along_x, unknowns, optimize=True)
    across, along = np.meshgrid(x, y)
    inside = finger.within(across, along)
    u, v = grid.outline.coordinates(across[inside], along[inside])
    found = np.einsum("xa,abi->xbi", grid.x.at(u), unknowns)
    found = np.einsum("xb,xbi->xi", grid.y.at(v), found)
    values = np.full((instants, *across.shape), np.nan)
    values[:, inside] = in_time @ found.T
    return values
