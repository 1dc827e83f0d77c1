"""Method of lines: conservative finite volumes in space, SciPy's integrators in time.

Scheme: cell-centred volumes on a mesh graded towards the rim, two-point fluxes of
(P^2 - 1)/2 with H^3 at the faces, and the mass H P of the cells as unknown, so that mass is
kept to round-off; `scipy.integrate.solve_ivp` with BDF (or Radau) and the exact sparse
Jacobian, marched from rest over N periods. What most users would write first.

Order: 2 in space; in time by the integrator's tolerance (BDF: variable order 1 to 5).
Cost: grows with N, about 19 periods for each factor e of the transient at sigma = 2331.
Source: Shampine and Reichelt, SIAM J. Sci. Comput. 18, 1997 (the integrator); LeVeque,
Finite Volume Methods for Hyperbolic Problems, 2002, chapter 4 (the conservative form).
"""

import math
import time
from typing import Any, Literal

import numpy as np
import scipy.sparse as sp
from scipy.integrate import solve_ivp

from numerics.films import Film
from numerics.peers.yardstick import (
    Amplitude,
    FloatArray,
    Fold,
    YardstickResult,
    graded_edges,
    periods_to_settle,
)
from squeezefilm.io.errors import RunError

SAMPLES = 64  # of the last period; their mean is spectrally accurate


def periodic_force(
    *,
    epsilon: float,
    sigma: float,
    amplitude: Amplitude,
    cells: int = 16,
    periods: int = 150,
    rtol: float = 1e-5,
    integrator: Literal["BDF", "Radau"] = "BDF",
    fold: Fold = (False, False),
    graded: bool = True,
) -> YardstickResult:
    """Mean force in p0 l0^2 over the last of `periods` periods from rest.

    cells: along each half side, folded or not; rtol: the integrator's
    relative tolerance (the absolute one is a tenth of it, on a mass of order 1);
    graded: False for cells of one size.

    Raises RunError when the integrator gives up.
    """
    start = time.process_time()
    x, y = (graded_edges(cells=cells, folded=folded, graded=graded) for folded in fold)
    x_mid, y_mid = (x[1:] + x[:-1]) / 2, (y[1:] + y[:-1]) / 2
    s = amplitude(*np.meshgrid(x_mid, y_mid, indexing="ij")).ravel()
    volume = np.outer(np.diff(x), np.diff(y)).ravel()

    # Differences across all faces that carry flux, those normal to X first.
    (x_jump, x_gap), (y_jump, y_gap) = (_jumps(x, fold[0]), _jumps(y, fold[1]))
    x_faces, y_faces = x[: len(x_gap)], y[: len(y_gap)]
    jump = sp.vstack(
        [sp.kron(x_jump, sp.eye(y_mid.size)), sp.kron(sp.eye(x_mid.size), y_jump)]
    ).tocsr()
    per_length = np.concatenate(
        [np.outer(1 / x_gap, np.diff(y)).ravel(), np.outer(np.diff(x), 1 / y_gap).ravel()]
    )
    s_face = np.concatenate(
        [
            amplitude(*np.meshgrid(x_faces, y_mid, indexing="ij")).ravel(),
            amplitude(*np.meshgrid(x_mid, y_faces, indexing="ij")).ravel(),
        ]
    )
    divergence = (sp.diags(-1 / (sigma * volume)) @ jump.T).tocsr()

    def conductance(t: float) -> FloatArray:
        return per_length * (1 + epsilon * s_face * math.sin(t)) ** 3

    def rate(t: float, mass: FloatArray) -> FloatArray:
        pressure = mass / (1 + epsilon * s * math.sin(t))
        return np.asarray(divergence @ (conductance(t) * (jump @ ((pressure**2 - 1) / 2))))

    def jacobian(t: float, mass: FloatArray) -> sp.csc_matrix:
        gap = 1 + epsilon * s * math.sin(t)
        flux = sp.diags(conductance(t)) @ jump @ sp.diags(mass / gap**2)
        return sp.csc_matrix(divergence @ flux)

    last = 2 * math.pi * (periods - 1 + np.arange(SAMPLES + 1) / SAMPLES)
    march = solve_ivp(
        rate,
        (0, last[-1]),
        np.ones(s.size),
        method=integrator,
        t_eval=last,
        jac=jacobian,
        rtol=rtol,
        atol=rtol / 10,
    )
    if not march.success:
        raise RunError(
            f"method of lines: {integrator} stopped at epsilon = {epsilon:g}, "
            f"sigma = {sigma:g}: {march.message}"
        )
    pressure = march.y / (1 + epsilon * np.outer(s, np.sin(last)))
    whole = 2 ** sum(fold)
    return YardstickResult(
        force=float(whole * volume @ (pressure[:, 1:] - 1).mean(axis=1)),
        cpu_seconds=time.process_time() - start,
        periods=periods,
        change=float(np.abs(march.y[:, -1] - march.y[:, 0]).max()),
        settings={"cells": cells, "rtol": rtol, "fold": fold},
    )


def _jumps(edges: FloatArray, folded: bool) -> tuple[sp.csr_matrix, FloatArray]:
    """Differences of cell values over the faces of one side, and the distances they span.

    The value beyond the rim is zero at the rim itself; no flux crosses the mirror of a folded
    side, whose face is left out.
    """
    cells = len(edges) - 1
    middle = (edges[1:] + edges[:-1]) / 2
    jump = sp.diags([1.0, -1.0], [0, -1], shape=(cells + 1, cells)).tocsr()
    gap = np.diff(np.concatenate([edges[:1], middle, edges[-1:]]))
    return (jump[:-1], gap[:-1]) if folded else (jump, gap)


def _rung(film: Film, level: int) -> dict[str, Any]:
    """Of second order in space: each rung divides that error and the tolerances by four."""
    return {
        "cells": 6 * 2**level,
        "rtol": 1e-3 * film.epsilon / 4**level,
        "periods": periods_to_settle(sigma=film.sigma, tolerance=0.1 / 4**level),
        "fold": film.fold,
    }


METHODS = {"volumes_from_rest": _rung}
