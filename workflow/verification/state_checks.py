"""Does a computed pressure solve the film equation? Checks that do not ask its solver.

The pressure is carried to a finer grid, where the equation in its conservative form,

    div((H^3 P + 6 Kn H^2) grad P) - Lambda d(HP)/dX - sigma d(HP)/dT = 0,

is evaluated with plain derivatives; what is left is a defect of discretisation, iteration and
code alike. Nothing here is shared with the solver under test but the equation.
"""

import math
from dataclasses import dataclass

import numpy as np

from verification.films import Film
from verification.marching import FloatArray, Fold
from verification.numpy_periodic import ChebyshevGrid, chebyshev_grid, real_eigenvectors


@dataclass(frozen=True)
class StateChecks:
    """What a pressure field is worth.

    Attributes:
        force: its mean force in units of p0 times the area.
        defect: change of the force in one correction by the mean-coefficient operator, relative
            to the force. Blind to what changes the pressure and not its mean, as by symmetry.
        state_defect: root mean square of that correction relative to the mass perturbation H p.
    """

    force: float
    defect: float
    state_defect: float


def unfold(overpressure: FloatArray, fold: Fold) -> FloatArray:
    """The field on the whole finger from that on its mirror half or quarter, (nx, ny, nt)."""
    whole = np.concatenate([overpressure, overpressure[::-1]]) if fold[0] else overpressure
    return np.concatenate([whole, whole[:, ::-1]], axis=1) if fold[1] else whole


def check_state(film: Film, overpressure: FloatArray) -> StateChecks:
    """Judge p = P - 1 at the inner Chebyshev points of the whole finger and equal times of a
    period from T = 0, shape (nx, ny, nt)."""
    nx, ny, nt = overpressure.shape
    grid_x, grid_y = (chebyshev_grid(_finer(n)) for n in (nx, ny))
    times = _finer(nt)
    p = np.pad(overpressure, ((1, 1), (1, 1), (0, 0)))
    p = np.tensordot(_carry(chebyshev_grid(nx), grid_x), p, 1)
    p = np.matmul(_carry(chebyshev_grid(ny), grid_y), p)
    p = _resample(p, times)

    phase = 2 * math.pi * np.arange(times) / times
    places = np.meshgrid(grid_x.x, grid_y.x, indexing="ij")
    gap = film.scene.gap(*places, phase)
    squeeze = gap - film.scene.rest_gap(*places)[:, :, None]
    first_x, first_y = grid_x.first, grid_y.first / film.aspect
    conductance = gap**3 * (1 + p) + 6 * film.knudsen * gap**2
    flux_x = conductance * np.tensordot(first_x, p, 1)
    flux_y = conductance * np.matmul(first_y, p)
    # H P less what is there at rest, small where the film is: no digits are lost in its rate.
    mass = squeeze + gap * p
    residual = np.tensordot(first_x, flux_x, 1) + np.matmul(first_y, flux_y)
    residual -= film.sigma * _rate(mass)
    if film.bearing:
        residual -= film.bearing * np.tensordot(first_x, gap - 1 + gap * p, 1)

    weights = grid_x.weights[:, None] * grid_y.weights
    force = float(np.sum(weights * p.mean(axis=-1)))
    correction = _correction(
        residual[1:-1, 1:-1],
        diffusivity=float(np.mean(conductance / gap)),
        sigma=film.sigma,
        grids=(grid_x, grid_y),
        aspect=film.aspect,
    )
    change = correction / gap[1:-1, 1:-1]
    defect = float(np.sum(weights[1:-1, 1:-1] * change.mean(axis=-1)))
    inner = weights[1:-1, 1:-1, None]
    size = float(np.sum(inner * (gap * p)[1:-1, 1:-1] ** 2))
    return StateChecks(
        force=force,
        defect=abs(defect / force),
        state_defect=math.sqrt(float(np.sum(inner * correction**2)) / size),
    )


def _finer(points: int) -> int:
    """A quarter more, and even."""
    return 2 * math.ceil(0.625 * points)


def _carry(coarse: ChebyshevGrid, fine: ChebyshevGrid) -> FloatArray:
    """Interpolation between Chebyshev grids, all points: the barycentric formula."""
    sign = (-1.0) ** np.arange(len(coarse.x))
    sign[[0, -1]] /= 2
    gap = fine.x[:, None] - coarse.x
    same = np.abs(gap) < 1e-14
    matrix = sign / np.where(same, 1.0, gap)
    hit = same.any(axis=1)
    matrix[hit] = same[hit]
    return np.asarray(matrix / matrix.sum(axis=1, keepdims=True))


def _resample(field: FloatArray, times: int) -> FloatArray:
    """Trigonometric interpolation along the last axis to more equidistant times."""
    before = field.shape[-1]
    modes = np.fft.rfft(field)
    modes[..., -1] /= 2  # the sawtooth mode of an even number of times stands for two
    padded = np.zeros((*field.shape[:-1], times // 2 + 1), dtype=complex)
    padded[..., : modes.shape[-1]] = modes
    return np.fft.irfft(padded, n=times) * (times / before)


def _rate(field: FloatArray) -> FloatArray:
    times = field.shape[-1]
    i_k = 1j * np.arange(times // 2 + 1)
    return np.fft.irfft(i_k * np.fft.rfft(field), n=times)


def _correction(
    residual: FloatArray,
    *,
    diffusivity: float,
    sigma: float,
    grids: tuple[ChebyshevGrid, ChebyshevGrid],
    aspect: float,
) -> FloatArray:
    """Solve (D lap - sigma d/dT) w = -residual at the inner points."""
    (x_values, x_modes), (y_values, y_modes) = (
        real_eigenvectors(grid.second[1:-1, 1:-1]) for grid in grids
    )
    laplacian = x_values[:, None] + y_values / aspect**2
    times = residual.shape[-1]
    symbol = diffusivity * laplacian[:, :, None] - 1j * sigma * np.arange(times // 2 + 1)
    modes = np.matmul(np.linalg.inv(y_modes), np.tensordot(np.linalg.inv(x_modes), residual, 1))
    w = np.fft.irfft(np.fft.rfft(-modes) / symbol, n=times)
    return np.asarray(np.matmul(y_modes, np.tensordot(x_modes, w, 1)))
