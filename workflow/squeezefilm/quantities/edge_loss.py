"""Edge loss: gas that flows in has come from rest, and its pressure at the edge is below ambient.

    P = 1 − C (σ Re/24) ū_n²  where gas flows in (Bernoulli),  P = 1 where it flows out,

with the mean velocity ū over the gap, lengths by the pad's length along x, time by 1/ω. C is the
kinetic energy of a plug or of a parabola, over that of the mean velocity, and more with losses: it
is not known better than to the two. A wall that slides drags gas to the edge, with a pressure from
ρ U²/2 below to as much above the ambient one, which no film equation tells. The edge's pressure and
the film's state are solved for in turn, each with the other's last one, until the force settles.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np

from squeezefilm.film.scene import Scene
from squeezefilm.quantities.fields import Fields
from squeezefilm.quantities.states import EDGE_PRESSURE, changes_with_errors, weights_with_edge
from squeezefilm.reynolds.device import Device
from squeezefilm.reynolds.grid import Grid
from squeezefilm.reynolds.periodic.launch import solve_batch
from squeezefilm.reynolds.spectral import Axis, FluxPoints
from squeezefilm.reynolds.terms.rarefaction import (
    flow_over_viscous,
    slip_flow,
    slip_growth,
    slip_of,
)
from squeezefilm.solution import Solution

# Coefficients C of a plug and of a parabola.
COEFFICIENTS = (1.0, 1.54)
# Relative error of the force that an iteration of the state may leave.
STATE_TOLERANCE = 1e-5
# Change of the effect, over it, at which the iteration ends; steps that it may take.
CONVERGED_CHANGE, MOST_STEPS = 3e-3, 30
# Pressures on the edge over the ambient one in whose effects higher orders do not count. At the
# first no state may be found of a film of large amplitude, at the second rounding counts more.
SMALL_FRACTIONS = (1e-3, 1e-4)
# Both ends of an axis.
ENDS = np.array([0.0, 1.0])


def mean_changes(
    scenes: Sequence[Scene], solutions: Sequence[Solution], *, device: Device
) -> np.ndarray:
    """Return the relative changes of the forces by the edge loss, and their errors.

    Args:
        solutions: of the scenes, with their states on two grids.

    Returns:
        Changes and errors for each of COEFFICIENTS, shape (2, coefficients, scenes); NaN where a
        solution has no states, or the iteration does not settle.
    """
    on_grid = partial(_changes_on_grid, device=device)
    changes = changes_with_errors(
        scenes, solutions, on_grid, changes=len(COEFFICIENTS), tolerance=STATE_TOLERANCE
    )
    changes[1] += CONVERGED_CHANGE * np.abs(changes[0])
    return changes


def ram_changes(
    scenes: Sequence[Scene], solutions: Sequence[Solution], *, device: Device
) -> np.ndarray:
    """Return what the pressure ρ U²/2 where a sliding wall drags gas in changes of the forces.

    Gas that comes in with the wall's speed and stops has it: the largest that there may be. The
    change goes with the pressure, and is solved for a small one.

    Args and returns: as of ``mean_changes``, of one change, (2, 1, scenes).
    """

    def on_grid(
        scenes: Sequence[Scene], unknowns: Sequence[np.ndarray], grid: Grid, *, fraction: float
    ) -> np.ndarray:
        film, own = EdgeFilms(scenes, grid), np.stack(unknowns)
        without, with_pressure = (
            film.solve(own, edge, device)[1]
            for edge in (film.ambient(), film.pressure_of_dragged_gas(fraction))
        )
        return np.array([with_pressure / without - 1])

    changes = np.full((2, 1, len(scenes)), np.nan)
    for fraction in SMALL_FRACTIONS:
        if np.isnan(changes).any():
            of_grid = partial(on_grid, fraction=fraction)
            tried = changes_with_errors(
                scenes, solutions, of_grid, changes=1, tolerance=STATE_TOLERANCE
            )
            changes = np.where(np.isnan(changes), tried / fraction, changes)
    # ρ U²/2 over the ambient pressure.
    ram = [each.modified_reynolds * each.bearing_number**2 / (6 * each.sigma) for each in scenes]
    return changes * np.array(ram)


def _changes_on_grid(
    scenes: Sequence[Scene], unknowns: Sequence[np.ndarray], grid: Grid, *, device: Device
) -> np.ndarray:
    """Changes of the mean pressure over it on one grid, (coefficients, scenes)."""
    copies = 1 + len(COEFFICIENTS)
    coefficients = np.repeat([0.0, *COEFFICIENTS], len(scenes))
    film = EdgeFilms(scenes[np.tile(np.arange(len(scenes)), copies)], grid)
    state, edge = np.concatenate([np.stack(unknowns)] * copies), film.ambient()
    change = np.zeros(len(coefficients))
    step, moved = np.ones(len(coefficients)), np.full(len(coefficients), np.inf)
    for _ in range(MOST_STEPS):
        new = film.pressure_of_inflow(state, edge, coefficients)
        moves = [pressure - known for pressure, known in zip(new, edge, strict=True)]
        before, moved = moved, np.max([_largest(move) for move in moves], axis=0)
        # High harmonics of a large loss overshoot.
        step = np.where(moved > before, step / 4, step)
        columns = step[:, None, None, None]
        tried = [known + columns * move for known, move in zip(edge, moves, strict=True)]
        new_state, mean = film.solve(state, tried, device)
        without_loss = np.tile(mean[: len(scenes)], copies)
        failed = np.isnan(mean)
        last, change = change, np.where(failed, change, mean / without_loss - 1)
        settled = ~failed & (np.abs(change - last) <= step * CONVERGED_CHANGE / 2 * np.abs(change))
        # Where Newton's method does not follow, a shorter step is tried.
        keep = failed[:, None, None, None]
        edge = [np.where(keep, known, new) for known, new in zip(edge, tried, strict=True)]
        state = np.where(keep[..., None], state, new_state)
        step = np.where(failed, step / 2, np.minimum(1.5 * step, 1.0))
        if settled.all():
            break
    changes = np.where(settled, change, np.nan)
    return np.asarray(changes.reshape(copies, -1)[1:])


class EdgeFilms:
    """Films of like terms on one grid, and what a pressure on their edge adds to the equation.

    A pressure on the edge is g = P − 1 at the ends of each axis that has some, of shape (scenes,
    ends, nodes of the other axis, times); a folded axis has one end. An outline's angle has none.
    """

    def __init__(self, scenes: Sequence[Scene], grid: Grid) -> None:
        fields = Fields(scenes, grid, np.zeros((len(scenes), *grid.shape)))
        self.scenes, self.grid, self.numbers = scenes, grid, fields.equation
        self.lengths = fields.lengths
        self.exponent = scenes[0].gas.polytropic_exponent
        reynolds = np.array([scene.modified_reynolds for scene in scenes])
        self.bernoulli = (self.numbers["sigma"] * reynolds / 24)[:, None, None, None]
        self.axes = [axis for axis in (grid.x, grid.y) if isinstance(axis, Axis)]
        gap = fields.gap
        # Over h0, on the nodes that are solved for, and at each axis' ends.
        self.gap = gap[:, grid.x.inner, grid.y.inner]
        self.gap_at_ends = [gap[:, _end_nodes(grid.x)][:, :, grid.y.inner]]
        if len(self.axes) == 2:
            ends_of_y = gap[:, grid.x.inner][:, :, _end_nodes(self.axes[1])]
            self.gap_at_ends.append(ends_of_y.swapaxes(1, 2))

    def ambient(self) -> list[np.ndarray]:
        """The ambient pressure on the edge."""
        return [np.zeros_like(gap) for gap in self.gap_at_ends]

    def solve(
        self, guess: np.ndarray, edge: list[np.ndarray], device: Device
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return unknowns of states with a pressure on the edge, and means, NaN without one."""
        states = solve_batch(
            self.scenes,
            self.grid,
            tolerance=STATE_TOLERANCE,
            device=device,
            guess=guess,
            edge=self.arrays(edge),
        )
        mean = states.mean + self.mean_of_edge(edge)
        return states.unknowns, np.where(states.status == 0, mean, np.nan)

    def pressure_of_inflow(
        self, unknowns: np.ndarray, edge: list[np.ndarray], coefficients: np.ndarray
    ) -> list[np.ndarray]:
        """Return the pressure on the edge by the velocity of a state that has some pressure there.

        Args:
            unknowns: gauge pressure and deficits of the velocity, (scenes, fields, nx, ny, times).
            coefficients: C of each scene.
        """
        scale = coefficients[:, None, None, None] * self.bernoulli
        pressures = []
        for k, (axis, gap, at_ends) in enumerate(
            zip(self.axes, self.gap_at_ends, edge, strict=True)
        ):
            ends = _end_nodes(axis)
            slope = axis.derivative[ends] / self.lengths[k]
            field = np.moveaxis(unknowns[:, 0], 1 + k, 1)
            inner = axis.fold(slope[:, 1:-1], rows=len(ends))
            gradient = np.einsum("en,snqt->seqt", inner, field)
            gradient += np.einsum("ef,sfqt->seqt", _end_columns(slope, axis), at_ends)
            mass = gap * (1 + at_ends) ** (1 / self.exponent)
            mobility = gap**2 * flow_over_viscous(self.numbers, mass)
            velocity = -mobility / self.numbers["sigma"][:, None, None, None] * gradient
            if unknowns.shape[1] > 1:
                deficit = np.moveaxis(unknowns[:, 1 + k], 1 + k, 1)
                at = FluxPoints(axis).at(axis.all_nodes[ends])
                deficit_at = axis.fold(at, odd=True, rows=len(ends))
                velocity -= np.einsum("en,snqt->seqt", deficit_at, deficit)
            pressures.append(-scale * self._square_of_inflow(velocity))
        return pressures

    def pressure_of_dragged_gas(self, fraction: float) -> list[np.ndarray]:
        """Return a small pressure on the edge where a sliding wall drags gas in.

        It goes with the square of the wall's speed into the film and is a fraction where that is U.
        """
        pressure = self.ambient()
        turn = np.asarray(self.grid.turn(ENDS)).real[..., None]
        direction = np.sign(self.numbers["bearing"])[:, None, None, None]
        velocity = direction * turn[: pressure[0].shape[1]] + pressure[0]
        pressure[0] += fraction * self._square_of_inflow(velocity)
        return pressure

    def _square_of_inflow(self, velocity: np.ndarray) -> np.ndarray:
        """Square of the velocity at the ends of an axis where it leads into the film, else 0."""
        ends = velocity.shape[1]
        inflow = np.maximum(np.array([1.0, -1.0])[:ends, None, None] * velocity, 0.0)
        return np.asarray(inflow**2 / np.asarray(self.grid.area(ENDS))[..., None][:ends])

    def arrays(self, edge: list[np.ndarray]) -> dict[str, np.ndarray]:
        """Return what a pressure on the edge adds, by the kernels' names of arrays."""
        array_of_name = {name: np.zeros_like(self.gap) for name in ("edge_flow", *EDGE_PRESSURE)}
        flows = self._flow_at_ends(edge)
        for k, (axis, name) in enumerate(zip(self.axes, "xy", strict=False)):
            length = self.lengths[k]
            second = (axis.divergence @ axis.derivative)[axis.inner] / length**2
            points = FluxPoints(axis)
            values = points.from_all_nodes
            slope = values @ axis.derivative / length

            def spread(matrix: np.ndarray, at_ends: np.ndarray, k: int = k) -> np.ndarray:
                field = np.einsum("nf,sfqt->snqt", matrix, at_ends)
                return np.moveaxis(field, 1, 1 + k)

            array_of_name[f"edge_values_{name}"] = spread(_end_columns(values, axis), edge[k])
            array_of_name[f"edge_slope_{name}"] = spread(_end_columns(slope, axis), edge[k])
            for term, at_ends in enumerate(flows[k]):
                power = self.gap ** (0.5 * (3 - term))
                array_of_name["edge_flow"] += power * spread(_end_columns(second, axis), at_ends)
        return array_of_name

    def _flow_at_ends(self, edge: list[np.ndarray]) -> list[list[np.ndarray]]:
        """v of each flow term on the edge, c_k H^((3−k)/2) (g_k(P) − g_k(1)), for each axis."""
        flows = []
        for gap, rise in zip(self.gap_at_ends, edge, strict=True):
            power = 1 + 1 / self.exponent
            viscous = ((1 + rise) ** power - 1) / power
            of_axis = [gap**1.5 * viscous]
            if self.numbers["flow"].shape[1] > 1:
                slip, inverse = slip_of(self.numbers, gap)
                if inverse is None:
                    of_axis.append(slip * gap * rise)
                else:  # to first order in the pressure, as flow_from splits the flow
                    growth = slip_growth(inverse)[0]
                    of_axis[0] = of_axis[0] + gap**1.5 * slip / gap * growth * rise
                    of_axis.append(slip * gap * (slip_flow(inverse) - growth) * rise)
            flows.append(of_axis)
        return flows

    def mean_of_edge(self, edge: list[np.ndarray]) -> np.ndarray:
        """Return the part of the mean pressure that the edge's nodes have, (scenes,)."""
        along_x, along_y = (weights_with_edge(axis) for axis in (self.grid.x, self.grid.y))
        inner_x, inner_y = along_x[self.grid.x.inner], along_y[self.grid.y.inner]
        ends = along_x[_end_nodes(self.grid.x)]
        area = np.ones((len(ends), len(inner_y)))
        if self.grid.outline:
            area = np.asarray(self.grid.area(np.array([0.0, 1.0])))[: len(ends)]
            area = area * self.grid.mean_area
        mean = np.einsum("seqt,e,q,eq->s", edge[0], ends, inner_y, area)
        if len(self.axes) == 2:
            mean += np.einsum("seqt,e,q->s", edge[1], along_y[_end_nodes(self.axes[1])], inner_x)
        return np.asarray(mean / self.grid.nt)


def _largest(values: np.ndarray) -> np.ndarray:
    """Largest size of each scene's values, (scenes,)."""
    return np.asarray(np.abs(values).reshape(len(values), -1).max(axis=1))


def _end_nodes(axis: Axis) -> list[int]:
    """The nodes of an axis at its ends; one of a folded axis, whose ends are alike."""
    return [0] if axis.folded else [0, -1]


def _end_columns(matrix: np.ndarray, axis: Axis) -> np.ndarray:
    """Return the columns of a matrix on all nodes that multiply the values at the ends."""
    ends = matrix[:, [0, -1]]
    return ends.sum(axis=1, keepdims=True) if axis.folded else ends
