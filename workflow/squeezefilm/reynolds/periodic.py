"""The periodic state on the device: one batch of scenes on one grid (see periodic.cl)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from squeezefilm.reynolds.device import Device, kernel
from squeezefilm.reynolds.needs import Needs
from squeezefilm.reynolds.spectral import Axis, Period, axis, period

SOURCES = ("linear_algebra.cl", "film_over_period.cl", "krylov.cl", "periodic.cl")
STATUS = ("ok", "Newton's method did not converge", "the pressure became infinite")
MOST_NEWTON = 40
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
            shape (scenes, full nx + 2, full ny + 2).
        tolerance: relative error of the force that the iteration may leave, one for the batch.
    """

    epsilon: np.ndarray
    sigma: np.ndarray
    bearing: np.ndarray
    inverse_exponent: np.ndarray
    flow: np.ndarray
    aspect: float
    amplitude: np.ndarray
    tolerance: float


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
    """Solve a batch of scenes on one grid; each scene is solved on its own.

    Args:
        guess: first guess of the overpressure, shape (scenes, nx, ny, nt); the film at rest if
            left out.
    """
    import pyopencl as cl

    scenes = len(problems.epsilon)
    terms = problems.flow.shape[1]
    moving = bool(np.any(problems.bearing))
    periodic_state = kernel(device, "periodic_state", sources=SOURCES, defines=_defines(problems))
    count = grid.nx * grid.ny * grid.nt
    most_krylov = int(np.clip(LARGEST_WORKSPACE_BYTES // (8 * count) - 8, 20, 80))
    workspace_size = count * (3 * terms + 4 + most_krylov) + (most_krylov + 4) * (most_krylov + 1)
    workspace_size = -(-workspace_size // 8) * 8
    groups = device.groups_for(scenes, workspace_bytes=8 * workspace_size)

    numbers = np.column_stack(
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
    state = np.zeros((scenes, *grid.shape)) if guess is None else np.ascontiguousarray(guess)
    results = np.empty((scenes, 5))
    counts = np.empty((scenes, 3), dtype=np.int32)

    flags = cl.mem_flags
    context, queue = device.context, device.queue

    def sent(values: np.ndarray) -> cl.Buffer:
        return cl.Buffer(context, flags.READ_ONLY | flags.COPY_HOST_PTR, hostbuf=values)

    state_buffer = cl.Buffer(context, flags.READ_WRITE | flags.COPY_HOST_PTR, hostbuf=state)
    results_buffer = cl.Buffer(context, flags.WRITE_ONLY, results.nbytes)
    counts_buffer = cl.Buffer(context, flags.WRITE_ONLY, counts.nbytes)
    workspace = cl.Buffer(context, flags.READ_WRITE, 8 * workspace_size * groups)
    taken = np.zeros(1, dtype=np.int32)
    periodic_state(
        queue,
        (groups * device.work_items,),
        (device.work_items,),
        np.int32(scenes),
        *(np.int32(n) for n in grid.shape),
        np.int32(MOST_NEWTON),
        np.int32(most_krylov),
        sent(grid_matrices(grid, aspect=problems.aspect, bearing=moving)),
        sent(numbers),
        sent(profile_fields(problems, grid, slope=moving)),
        sent(_schur_forms(problems, grid) if moving else np.zeros(1)),
        state_buffer,
        results_buffer,
        counts_buffer,
        workspace,
        np.uint64(workspace_size),
        cl.Buffer(context, flags.READ_WRITE | flags.COPY_HOST_PTR, hostbuf=taken),
        cl.LocalMemory(8 * device.work_items),
    )
    cl.enqueue_copy(queue, state, state_buffer)
    cl.enqueue_copy(queue, results, results_buffer)
    cl.enqueue_copy(queue, counts, counts_buffer)
    return States(
        overpressure=state,
        mean=results[:, 0],
        residual=results[:, 1],
        largest=results[:, 2],
        lowest=results[:, 3],
        thinnest=results[:, 4],
        status=counts[:, 0],
        newton_steps=counts[:, 1],
        krylov_iterations=counts[:, 2],
    )


def _defines(problems: Problems) -> tuple[str, ...]:
    """The terms that the batch needs; the others are not compiled."""
    defines = [f"FLOW_TERMS={problems.flow.shape[1]}", "PROFILE_FIELDS=3"]
    if np.any(problems.bearing):
        defines[1:] = ["PROFILE_FIELDS=4", "BEARING"]
    if np.any(problems.inverse_exponent != 1):
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
        values_x,
        values_y / aspect**2,
        grid.x.weights,
        grid.y.weights,
        np.sin(grid.t.nodes),
        np.cos(grid.t.nodes),
    ]
    if bearing:
        parts.append(grid.x.first_derivative)
    return np.concatenate([np.ascontiguousarray(part).ravel() for part in parts])


def profile_fields(problems: Problems, grid: Grid, *, slope: bool) -> np.ndarray:
    """s, |∇s|², Δs and, if asked for, ∂s/∂X where the unknowns lie; (scenes, 3 or 4, nx, ny).

    Derivatives are those of the interpolating polynomial, lengths in units of the finger's x side.
    """
    s = problems.amplitude
    along_x = grid.x.derivative @ s
    along_y = s @ grid.y.derivative.T / problems.aspect
    laplacian = grid.x.derivative @ along_x + along_y @ grid.y.derivative.T / problems.aspect
    fields = [s, along_x**2 + along_y**2, laplacian, *([along_x] if slope else [])]
    inner = (slice(None), slice(1, grid.nx + 1), slice(1, grid.ny + 1))
    return np.ascontiguousarray(np.stack([values[inner] for values in fields], axis=1))
