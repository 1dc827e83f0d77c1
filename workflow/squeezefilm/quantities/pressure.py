"""The pressure under a pad over a period, at wanted places: what a force is the mean of."""

import numpy as np

from squeezefilm.errors import RunError
from squeezefilm.film.pad import Pad
from squeezefilm.film.scene import Scene
from squeezefilm.reynolds.device import Device
from squeezefilm.reynolds.periodic.launch import PeriodicStates
from squeezefilm.reynolds.solver import solve
from squeezefilm.reynolds.spectral import cached_time_axis

# The pressure at a place is known to about half the digits of its mean: the force is solved for to
# a power of the tolerance, then to a tenth of that, until no value changes by more than it.
FORCE_TOLERANCE_POWER, MIN_FORCE_TOLERANCE, MAX_TIGHTER_SOLVES = 1.75, 1e-10, 3
NO_STATE_MESSAGE = (
    "no periodic state was found in which the pressure meets the tolerance at every point"
)


def gauge_pressure_and_change(
    scene: Scene,
    *,
    x: np.ndarray,
    y: np.ndarray,
    time_points: int,
    tolerance: float,
    device: Device,
) -> tuple[np.ndarray, float]:
    """The periodic film's gauge pressure at points x (nx,) and y (ny,) in [0, 1] across the pad.

    In units of the ambient pressure, (time_points, ny, nx), NaN outside the pad; and the largest
    change of a value by the last refinement. Time points are equidistant from phase 0 on. No value
    changes by more than ``tolerance`` of the largest from the last grid but one to the last.
    Inertia must be decided (model_error.py).
    Raises RunError saying why there is no such pressure.
    """
    for repeated in range(1 + MAX_TIGHTER_SOLVES):
        (solution,) = solve(
            [scene],
            tolerance=max(tolerance**FORCE_TOLERANCE_POWER, MIN_FORCE_TOLERANCE) * 0.1**repeated,
            method="periodic",
            device=device,
            keep_states=True,
        )
        if not solution.states:
            raise RunError(
                f"{NO_STATE_MESSAGE}: {solution.status}" if repeated else solution.status
            )
        before, values = (
            _interpolated_state(state, pad=scene.pad, x=x, y=y, time_points=time_points)
            for state in solution.states
        )
        change = float(np.nanmax(np.abs(values - before)))
        if change <= tolerance * np.nanmax(np.abs(values)):
            return values, change
    raise RunError(NO_STATE_MESSAGE)


def _interpolated_state(
    state: PeriodicStates, *, pad: Pad, x: np.ndarray, y: np.ndarray, time_points: int
) -> np.ndarray:
    """Interpolate a state at given positions and time points, (time_points, y, x)."""
    grid, field = state.grid, state.unknowns[0]
    in_time = cached_time_axis(grid.nt).matrix_at(cached_time_axis(time_points).nodes)
    if grid.pad_coordinates is None:
        along_x, along_y = grid.x.matrix_at(x), grid.y.matrix_at(y)
        return np.einsum("ti,yb,xa,abi->tyx", in_time, along_y, along_x, field, optimize=True)
    across, along = np.meshgrid(x, y)
    inside = pad.contains_positions(across, along)
    u, v = grid.pad_coordinates.coordinates(across[inside], along[inside])
    values_on_lines = np.einsum("xa,abi->xbi", grid.x.matrix_at(u), field)
    values_on_lines = np.einsum("xb,xbi->xi", grid.y.matrix_at(v), values_on_lines)
    values = np.full((time_points, *across.shape), np.nan)
    values[:, inside] = in_time @ values_on_lines.T
    return values
