"""The periodic state on the device: scenes of like terms on grids of their own (periodic.cl)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from squeezefilm.reynolds.device import Device, aligned, kernel
from squeezefilm.reynolds.needs import Needs
from squeezefilm.reynolds.spectral import Axis, Period, axis, period

SOURCES = ("linear_algebra.cl", "film_over_period.cl", "krylov.cl", "periodic.cl")
STATUS = ("ok", "Newton's method did not converge", "the pressure became infinite")
MOST_NEWTON = 40
LEAST_KRYLOV, MOST_KRYLOV = 20, 80
LARGEST_WORKSPACE_BYTES = 256 * 2**20


@dataclass(frozen=True)
class Grid:
    """Collocation points per direction, and which directions are folded by symmetry.

    ``nx`` and ``ny`` count unknowns: a folded axis has half as many as it has nodes.
    """

    nx: int
    ny: int
    nt: int
    fold_x: bool
    fold_y: bool

    @property
    def x(self) -> Axis:
        return axis(self.nx, self.fold_x)

    @property
    def y(self) -> Axis:
        return axis(self.ny, self.fold_y)

    @property
    def t(self) -> Period:
        return period(self.nt)

    @property
    def shape(self) -> tuple[int, int, int]:
        return self.nx, self.ny, self.nt

    @property
    def count(self) -> int:
        """Number of unknowns."""
        return self.nx * self.ny * self.nt

    def finer_than(self, other: Grid) -> bool:
        """In every direction: only then does the difference between two grids show every error."""
        return all(mine > its for mine, its in zip(self.shape, other.shape, strict=True))


@dataclass(frozen=True)
class Problems:
    """The scenes of a batch in dimensionless form; arrays of shape (scenes,).

    Attributes:
        epsilon, sigma, bearing: excursion ratio, squeeze number, bearing number.
        inverse_exponent: 1/n of the gas law ρ = P^(1/n), 1 for an isothermal film.
        flow: coefficients c_k of the flow's terms H^(3−k) ρ^(1−k) ∇P, shape (scenes, terms); 1 for
            the viscous flow alone.
        aspect: finger's length along y over that along x, one for the batch.
        amplitude: profile s on all nodes of the grid's axes, ends and mirror images included,
            shape (places, full nx + 2, full ny + 2).
        tolerance: relative error of the force that the iteration may leave, one for the batch.
        place: which profile each scene has; one of its own, in order, if left out.
    """

    epsilon: np.ndarray
    sigma: np.ndarray
    bearing: np.ndarray
    inverse_exponent: np.ndarray
    flow: np.ndarray
    aspect: float
    amplitude: np.ndarray
    tolerance: float
    place: np.ndarray | None = None

    @property
    def places(self) -> np.ndarray:
        """Row of ``amplitude`` that each scene has."""
        return np.arange(len(self.epsilon)) if self.place is None else self.place


@dataclass(frozen=True)
class Batch:
    """Scenes on one grid.

    guess: first guess of the overpressure, shape (scenes, nx, ny, nt); the film at rest if left
    out.
    """

    problems: Problems
    grid: Grid
    guess: np.ndarray | None = None

    @property
    def scenes(self) -> int:
        return len(self.problems.epsilon)

    @property
    def most_krylov(self) -> int:
        """Krylov iterations that a Newton step may take: as many as there is room for."""
        room = LARGEST_WORKSPACE_BYTES // (8 * self.grid.count) - 8
        return min(max(room, LEAST_KRYLOV), MOST_KRYLOV)

    @property
    def workspace_size(self) -> int:
        """Numbers that a work-group needs beside the state: fields, Krylov basis, Hessenberg."""
        fields = 3 * self.problems.flow.shape[1] + 4 + self.most_krylov
        return self.grid.count * fields + (self.most_krylov + 4) * (self.most_krylov + 1)


@dataclass(frozen=True)
class States:
    """What the device returns, one entry per scene.

    Attributes:
        overpressure: p = P − 1 on the grid, shape (scenes, nx, ny, nt).
        mean: mean of p over film and period, the force in units of p0 × area.
        residual: preconditioned residual, an estimate of the mass error left by the iteration.
        largest: largest |p|.
        lowest: smallest pressure P.
        thinnest: smallest product P H, by which the local Knudsen number grows.
        status: index into STATUS.
        newton_steps, krylov_iterations: work done.
    """

    overpressure: np.ndarray
    mean: np.ndarray
    residual: np.ndarray
    largest: np.ndarray
    lowest: np.ndarray
    thinnest: np.ndarray
    status: np.ndarray
    newton_steps: np.ndarray
    krylov_iterations: np.ndarray


def solve_batch(
    *, problems: Problems, grid: Grid, device: Device, guess: np.ndarray | None = None
) -> States:
    """The periodic states of one batch."""
    return launch([Batch(problems, grid, guess)], device=device).states()[0]


@dataclass(frozen=True)
class Launch:
    """Batches that the device is solving, and the arrays that it leaves its results in."""

    batches: Sequence[Batch]
    device: Device
    arrays: tuple[np.ndarray, ...]
    buffers: tuple[Any, ...]

    def states(self) -> list[States]:
        """Wait for the device; the states of each batch."""
        for values, buffer in zip(self.arrays, self.buffers, strict=True):
            self.device.fetch(values, buffer)
        state, results, counts, _ = self.arrays
        states = []
        first = start = 0
        for batch in self.batches:
            last, stop = first + batch.scenes, start + batch.scenes * batch.grid.count
            states.append(
                States(
                    overpressure=state[start:stop].reshape(-1, *batch.grid.shape),
                    mean=results[first:last, 0],
                    residual=results[first:last, 1],
                    largest=results[first:last, 2],
                    lowest=results[first:last, 3],
                    thinnest=results[first:last, 4],
                    status=counts[first:last, 0],
                    newton_steps=counts[first:last, 1],
                    krylov_iterations=counts[first:last, 2],
                )
            )
            first, start = last, stop
        return states


def launch(batches: Sequence[Batch], *, device: Device) -> Launch:
    """Let the device solve batches of like terms; each scene is solved on its own.

    The device takes scenes in the given order: put the dearest first.
    """
    import pyopencl as cl

    moving = any(np.any(batch.problems.bearing) for batch in batches)
    defines = _defines(batches, moving=moving)
    periodic_state = kernel(device, "periodic_state", sources=SOURCES, defines=defines)
    inputs = _inputs(batches, moving=moving)
    scenes = sum(batch.scenes for batch in batches)
    results = np.empty((scenes, 5))
    counts = np.empty((scenes, 3), dtype=np.int32)
    taken = np.zeros(1, dtype=np.int32)
    workspace_size = -(-max(batch.workspace_size for batch in batches) // 8) * 8
    groups = device.groups_for(scenes, workspace_bytes=8 * workspace_size)
    arrays = inputs.state, results, counts, taken
    buffers = tuple(device.shared(values) for values in arrays)
    periodic_state(
        device.queue,
        (groups * device.work_items,),
        (device.work_items,),
        np.int32(scenes),
        np.int32(MOST_NEWTON),
        *(device.sent(values) for values in inputs.read_only),
        *buffers,
        device.room(workspace_size * groups),
        np.uint64(workspace_size),
        cl.LocalMemory(8 * device.work_items),
    )
    device.queue.flush()
    return Launch(batches=batches, device=device, arrays=arrays, buffers=buffers)


@dataclass(frozen=True)
class _Inputs:
    """A launch's arrays, as periodic.cl describes them.

    read_only: layout, matrices, numbers, profile and schur.
    """

    read_only: tuple[np.ndarray, ...]
    state: np.ndarray


def _inputs(batches: Sequence[Batch], *, moving: bool) -> _Inputs:
    """The batches' arrays behind each other, and where each scene's parts lie in them."""
    layout: list[tuple[int, ...]] = []
    matrices, numbers, profile, schur = [], [], [], []
    at_matrices = at_profile = at_schur = at_state = 0
    state = aligned(sum(batch.scenes * batch.grid.count for batch in batches))
    for batch in batches:
        problems, grid = batch.problems, batch.grid
        matrices.append(grid_matrices(grid, aspect=problems.aspect, bearing=moving))
        numbers.append(_numbers(problems))
        fields = profile_fields(problems, grid, slope=moving)
        profile.append(fields.ravel())
        form_size = 0
        if moving:
            schur.append(_schur_forms(problems, grid).ravel())
            form_size = 3 * grid.nx**2
        end = at_state + batch.scenes * grid.count
        state[at_state:end] = 0.0 if batch.guess is None else batch.guess.ravel()
        for place in problems.places:
            at_place = at_profile + int(place) * fields[0].size
            offsets = at_matrices, at_place, at_schur, at_state
            layout.append((*grid.shape, batch.most_krylov, *offsets))
            at_schur += form_size
            at_state += grid.count
        at_matrices += matrices[-1].size
        at_profile += fields.size
    read_only = (
        np.array(layout, dtype=np.int64),
        np.concatenate(matrices),
        np.concatenate(numbers),
        np.concatenate(profile),
        np.concatenate(schur) if moving else np.zeros(1),
    )
    return _Inputs(read_only=read_only, state=state)


def _numbers(problems: Problems) -> np.ndarray:
    return np.column_stack(
        [
            problems.epsilon,
            problems.sigma,
            problems.bearing,
            # A mass error w moves the pressure by w/H.
            problems.tolerance * (1 - problems.epsilon),
            problems.inverse_exponent,
            problems.flow,
        ]
    )


def _defines(batches: Sequence[Batch], *, moving: bool) -> tuple[str, ...]:
    """The terms that the batches need; the others are not compiled."""
    defines = [f"FLOW_TERMS={batches[0].problems.flow.shape[1]}", "PROFILE_FIELDS=3"]
    if moving:
        defines[1:] = ["PROFILE_FIELDS=4", "BEARING"]
    if any(np.any(batch.problems.inverse_exponent != 1) for batch in batches):
        defines.append("POLYTROPIC")
    return tuple(defines)


def _schur_forms(problems: Problems, grid: Grid) -> np.ndarray:
    """Real Schur form of d²/dX² − (Λ/D) d/dX per scene: vectors, inverse, triangle (3, nx, nx).

    An orthogonal basis stays well conditioned where the eigenvectors of a convection-dominated
    operator do not. D, the mean diffusivity, is that of the film at ambient pressure. The vectors
    are scaled so that coefficients measure like nodal values.
    """
    from scipy.linalg import schur

    forms = np.empty((len(problems.epsilon), 3, grid.nx, grid.nx))
    scale = np.sqrt(grid.nx)
    for form, bearing, flow in zip(forms, problems.bearing, problems.flow, strict=True):
        operator = grid.x.second_derivative - bearing / flow.sum() * grid.x.first_derivative
        triangle, vectors = schur(operator, output="real")
        form[:] = vectors * scale, vectors.T / scale, triangle
    return forms


def warm(device: Device, needs: Needs) -> None:
    """Build and load the kernels that a scene needs, so that the first batch need not wait."""
    grid = Grid(nx=4, ny=4, nt=8, fold_x=False, fold_y=False)
    problems = Problems(
        epsilon=np.zeros(1),
        sigma=np.ones(1),
        bearing=np.full(1, float(needs.bearing)),
        inverse_exponent=np.full(1, 0.8 if needs.polytropic else 1.0),
        flow=np.ones((1, needs.flow_terms)),
        aspect=1.0,
        amplitude=np.ones((1, 6, 6)),
        tolerance=1.0,
    )
    solve_batch(problems=problems, grid=grid, device=device)


@lru_cache(maxsize=256)
def grid_matrices(grid: Grid, *, aspect: float, bearing: bool) -> np.ndarray:
    """The batch's matrices in one array, in the order in which make_grid reads them."""
    values_x, vectors_x, inverse_x = grid.x.modes
    values_y, vectors_y, inverse_y = grid.y.modes
    parts = [
        grid.x.second_derivative,
        vectors_x,
        inverse_x,
        grid.y.second_derivative / aspect**2,
        vectors_y,
        inverse_y,
        grid.t.fourier,
        grid.t.fourier.T,
        grid.t.derivative.T,
        np.add.outer(values_x, values_y / aspect**2),
        values_y / aspect**2,
        np.outer(grid.x.weights, grid.y.weights),
        np.tile(np.arange(grid.nt // 2), 2),
        np.sin(grid.t.nodes),
        np.cos(grid.t.nodes),
    ]
    if bearing:
        parts.append(grid.x.first_derivative)
    return np.concatenate([np.ascontiguousarray(part).ravel() for part in parts])


def profile_fields(problems: Problems, grid: Grid, *, slope: bool) -> np.ndarray:
    """s, |∇s|², Δs and, if asked for, ∂s/∂X where the unknowns lie; (places, 3 or 4, nx, ny).

    Derivatives are those of the interpolating polynomial, lengths in units of the finger's x side.
    """
    s = problems.amplitude
    along_x = grid.x.derivative @ s
    along_y = s @ grid.y.derivative.T / problems.aspect
    laplacian = grid.x.derivative @ along_x + along_y @ grid.y.derivative.T / problems.aspect
    fields = [s, along_x**2 + along_y**2, laplacian, *([along_x] if slope else [])]
    inner = (slice(None), slice(1, grid.nx + 1), slice(1, grid.ny + 1))
    return np.ascontiguousarray(np.stack([values[inner] for values in fields], axis=1))
