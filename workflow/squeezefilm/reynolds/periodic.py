"""The periodic state on the device: scenes of like terms on grids of their own (periodic.cl)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from squeezefilm.reynolds.device import Device, aligned, kernel
from squeezefilm.reynolds.grid import Grid, carrying_matrices, grid_matrices
from squeezefilm.reynolds.needs import Needs

SOURCES = ("linear_algebra.cl", "film_over_period.cl", "krylov.cl", "periodic.cl")
# Numbers that the device says of a scene beside its state: those of States but the first.
NUMBERS = 8
# Numbers of a row of the layout, as periodic.cl lists them, and what stands for no offset.
LAYOUT = 9
NOTHING = -1
STATUS = ("ok", "Newton's method did not converge", "the pressure became infinite")
MOST_NEWTON = 40
LEAST_KRYLOV, MOST_KRYLOV = 20, 80
LARGEST_WORKSPACE_BYTES = 256 * 2**20


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
    """Scenes on one grid after the other: the state on each is the first guess on the next.

    Attributes:
        grids: each no coarser than the one before.
        problems: the scenes as they are on each of the grids.
        guess: first guess of the overpressure on the first grid, shape (scenes, nx, ny, nt); the
            film at rest if left out.
    """

    grids: Sequence[Grid]
    problems: Sequence[Problems]
    guess: np.ndarray | None = None

    @property
    def scenes(self) -> int:
        return len(self.problems[0].epsilon)

    @property
    def count(self) -> int:
        """Number of unknowns, of all scenes on all grids."""
        return self.scenes * sum(grid.count for grid in self.grids)

    @property
    def workspace_size(self) -> int:
        """Numbers that a work-group needs beside the states: fields, Krylov basis, Hessenberg."""
        flow_terms = self.problems[0].flow.shape[1]
        sizes = []
        for grid in self.grids:
            most = most_krylov(grid)
            sizes.append(grid.count * (3 * flow_terms + 4 + most) + (most + 4) * (most + 1))
        return max(sizes)


def most_krylov(grid: Grid) -> int:
    """Krylov iterations that a Newton step may take: as many as there is room for."""
    room = LARGEST_WORKSPACE_BYTES // (8 * grid.count) - 8
    return min(max(room, LEAST_KRYLOV), MOST_KRYLOV)


@dataclass(frozen=True)
class States:
    """What the device returns, one entry per scene.

    Attributes:
        overpressure: p = P − 1 on the grid, shape (scenes, nx, ny, nt).
        mean: mean of p over film and period, the force in units of p0 × area.
        residual: preconditioned residual, an estimate of the mass error left by the iteration.
        largest: largest |p|.
        lowest: smallest pressure P.
        thinnest: smallest product ρ H, by which the local Knudsen number grows.
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

    @property
    def mean_in_time(self) -> np.ndarray:
        """Overpressure averaged over the period, shape (scenes, nx, ny)."""
        instants = self.overpressure.shape[-1]
        return np.asarray(self.overpressure @ np.full(instants, 1 / instants))


def solve_batch(
    *, problems: Problems, grid: Grid, device: Device, guess: np.ndarray | None = None
) -> States:
    """The periodic states of scenes on one grid."""
    return launch([Batch([grid], [problems], guess)], device=device).states()[0][0]


@dataclass(frozen=True)
class Launch:
    """Batches that the device is solving, and the array that it leaves its results in.

    done: the kernel's event.
    """

    batches: Sequence[Batch]
    device: Device
    results: np.ndarray
    buffer: Any
    done: Any

    def states(self) -> list[list[States]]:
        """Wait for the device; the states of each batch on each of its grids."""
        self.device.fetch(self.results, self.buffer, after=self.done)
        rows = sum(batch.scenes * len(batch.grids) for batch in self.batches)
        at_state = rows * NUMBERS
        numbers = self.results[:at_state].reshape(rows, NUMBERS)
        states: list[list[States]] = []
        first = 0
        for batch in self.batches:
            stages = len(batch.grids)
            last = first + batch.scenes * stages
            states.append([])
            for stage, grid in enumerate(batch.grids):
                end = at_state + batch.scenes * grid.count
                said = numbers[first + stage : last : stages].T
                states[-1].append(
                    States(
                        self.results[at_state:end].reshape(-1, *grid.shape),
                        *said[:5],
                        *said[5:].astype(int),
                    )
                )
                at_state = end
            first = last
        return states


def launch(batches: Sequence[Batch], *, device: Device) -> Launch:
    """Let the device solve batches of like terms; each scene is solved on its own.

    All of a scene's grids come in one launch, for the way to the device and back costs as much as
    a small solve.

    The device takes scenes in the given order: put the dearest first.
    """
    import pyopencl as cl

    moving = any(np.any(batch.problems[0].bearing) for batch in batches)
    defines = _defines(batches, moving=moving)
    periodic_state = kernel(device, "periodic_state", sources=SOURCES, defines=defines)
    inputs = _inputs(batches, moving=moving)
    scenes = sum(batch.scenes for batch in batches)
    workspace_size = -(-max(batch.workspace_size for batch in batches) // 8) * 8
    groups = device.groups_for(scenes, workspace_bytes=8 * workspace_size)
    buffer = device.shared(inputs.results)
    done = periodic_state(
        device.queue,
        (groups * device.work_items,),
        (device.work_items,),
        scenes,
        MOST_NEWTON,
        *(device.sent(values) for values in inputs.read_only),
        buffer,
        device.sent(np.zeros(1, dtype=np.int32)),
        device.room(workspace_size * groups),
        workspace_size,
        cl.LocalMemory(8 * device.work_items),
    )
    device.queue.flush()
    return Launch(batches, device, results=inputs.results, buffer=buffer, done=done)


@dataclass(frozen=True)
class _Inputs:
    """A launch's arrays, as periodic.cl describes them.

    read_only: begins, layout, matrices, numbers, profile and schur.
    results: room for what the device says of the scenes, and their first guesses.
    """

    read_only: tuple[np.ndarray, ...]
    results: np.ndarray


class _Joined:
    """Arrays that are put behind each other, and where the next one will begin."""

    def __init__(self) -> None:
        self.parts: list[np.ndarray] = [np.zeros(0)]
        self.end = 0

    def add(self, values: np.ndarray) -> int:
        """Where the values begin."""
        begin = self.end
        self.parts.append(values.ravel())
        self.end += values.size
        return begin

    @property
    def values(self) -> np.ndarray:
        return np.concatenate(self.parts) if self.end else np.zeros(1)


def _inputs(batches: Sequence[Batch], *, moving: bool) -> _Inputs:
    """The batches' arrays behind each other, and where each scene's parts lie in them."""
    stages = np.concatenate([np.full(batch.scenes, len(batch.grids)) for batch in batches])
    begins = np.concatenate([[0], np.cumsum(stages)])
    at_state = NUMBERS * int(begins[-1])
    results = aligned(at_state + sum(batch.count for batch in batches))
    matrices, profile, schur = _Joined(), _Joined(), _Joined()
    layouts, numbers = [], []
    for batch in batches:
        layout = np.empty((batch.scenes, len(batch.grids), LAYOUT), dtype=np.int64)
        coarser = None
        for stage, (grid, problems) in enumerate(zip(batch.grids, batch.problems, strict=True)):
            scene = np.arange(batch.scenes)
            fields = profile_fields(problems, grid, slope=moving)
            parts = (
                *grid.shape,
                most_krylov(grid),
                matrices.add(grid_matrices(grid, aspect=problems.aspect, bearing=moving)),
                matrices.add(carrying_matrices(coarser, grid)) if coarser else NOTHING,
                profile.add(fields) + problems.places * fields[0].size,
                (schur.add(_schur_forms(problems, grid)) + 3 * grid.nx**2 * scene) if moving else 0,
                at_state + grid.count * scene,
            )
            for column, value in enumerate(parts):
                layout[:, stage, column] = value
            end = at_state + batch.scenes * grid.count
            if coarser is None:
                results[at_state:end] = 0.0 if batch.guess is None else batch.guess.ravel()
            at_state, coarser = end, grid
        layouts.append(layout.reshape(-1, LAYOUT))
        numbers.append(np.stack([_numbers(each) for each in batch.problems], axis=1).ravel())
    read_only = (
        begins.astype(np.int32),
        np.concatenate(layouts),
        matrices.values,
        np.concatenate(numbers),
        profile.values,
        schur.values,
    )
    return _Inputs(read_only=read_only, results=results)


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
    defines = [f"FLOW_TERMS={batches[0].problems[0].flow.shape[1]}", "PROFILE_FIELDS=3"]
    if moving:
        defines[1:] = ["PROFILE_FIELDS=4", "BEARING"]
    if any(np.any(batch.problems[0].inverse_exponent != 1) for batch in batches):
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
