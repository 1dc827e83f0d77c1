"""Finite elements in space, Crank-Nicolson in time: the textbook method, with scikit-fem.

Scheme: with u = (P^2 - 1)/2 the film equation reads, for every test function phi that
vanishes on the rim,

    sigma d/dT int H P phi = -int H^3 grad u . grad phi + Lambda int H P dphi/dX,

with P = sqrt(1 + 2 u),

so diffusion is linear in u and its matrix a cubic in epsilon sin T assembled once. Biquadratic
quadrilaterals (9 nodes) on a mesh graded towards the rim; Crank-Nicolson from rest, fully
implicit. Each step is solved by Newton's method with the factors of the same phase of an
earlier period, renewed when they no longer serve.

Order: 2 in time, 4 in space for the force on a smooth film (the layer of width
sqrt(2/sigma) must be resolved first). Cost: see `yardstick.periods_to_settle`; far less with
Anderson acceleration of the period map.
Source: Gustafsson and McBain, J. Open Source Softw. 5(52), 2020 (scikit-fem); Crank and
Nicolson, Proc. Camb. Phil. Soc. 43, 1947.
"""

import math
import time
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.sparse.linalg import SuperLU, splu
from skfem import Basis, BilinearForm, ElementQuad2, ElementTriP2, Mesh, MeshQuad
from skfem.helpers import dot, grad

from numerics.films import Film
from numerics.peers.yardstick import (
    Amplitude,
    FloatArray,
    Fold,
    YardstickResult,
    graded_edges,
    march_to_periodic,
    periods_to_settle,
)
from squeezefilm.io.errors import RunError

NEWTON_STEPS = 40
PATIENCE = 4  # Newton steps with old factors before new ones are made
NEWTON_TOLERANCE = 1e-9  # on u, of order epsilon


@BilinearForm
def _diffusion(u, v, w):  # type: ignore[no-untyped-def]
    return w["s"] ** w["power"] * dot(grad(u), grad(v))


def periodic_force(
    *,
    epsilon: float,
    sigma: float,
    amplitude: Amplitude,
    bearing: float = 0.0,
    cells: int = 8,
    steps: int = 32,
    periods: int = 150,
    tolerance: float = 0.0,
    anderson_depth: int = 0,
    fold: Fold = (False, False),
    graded: bool = True,
    start_phase: float = 0.0,
    mesh: Mesh | None = None,
) -> YardstickResult:
    """Mean force in p0 l0^2 over the last period.

    bearing: the bearing number Lambda of a surface sliding in X (then do not fold X);
    cells: elements along each half side, folded or not; steps: time steps a period;
    periods: marched at most; tolerance: stop before that once u repeats itself so
    closely; anderson_depth: above 0, accelerate the period map (then give a tolerance);
    graded: False for elements of one size; start_phase: T in radians at which the march starts
    with ambient pressure; mesh: triangles of another pad than the unit square, all of whose edge
    is its rim (then fold nothing).

    The result's `change` tells whether the tolerance was reached within the periods.
    Raises RunError when a time step does not converge.
    """
    start = time.process_time()
    film = _Film(
        epsilon=epsilon,
        sigma=sigma,
        amplitude=amplitude,
        bearing=bearing,
        cells=cells,
        steps=steps,
        fold=fold,
        graded=graded,
        start_phase=start_phase,
        mesh=mesh,
    )
    force, marched, change = march_to_periodic(
        film.period,
        np.zeros(film.unknowns),
        periods=periods,
        tolerance=tolerance,
        anderson_depth=anderson_depth,
    )
    return YardstickResult(
        force=force * 2 ** sum(fold),
        cpu_seconds=time.process_time() - start,
        periods=marched,
        change=change,
        settings={
            "cells": cells,
            "steps": steps,
            "anderson_depth": anderson_depth,
            "fold": fold,
        },
    )


def forces_by_period(
    *,
    epsilon: float,
    sigma: float,
    amplitude: Amplitude,
    cells: int,
    steps: int,
    periods: int,
    fold: Fold = (False, False),
    start_phase: float = 0.0,
) -> FloatArray:
    """Mean force in p0 l0^2 of every period from rest, shape (periods,).

    Arguments and errors as for `periodic_force`.
    """
    film = _Film(
        epsilon=epsilon,
        sigma=sigma,
        amplitude=amplitude,
        bearing=0.0,
        cells=cells,
        steps=steps,
        fold=fold,
        graded=True,
        start_phase=start_phase,
    )
    u = np.zeros(film.unknowns)
    forces = []
    for _ in range(periods):
        u, force = film.period(u)
        forces.append(force * 2 ** sum(fold))
    return np.array(forces)


class _Film:
    """The discretised film: matrices of all phases, and the factors kept between periods."""

    def __init__(
        self,
        *,
        epsilon: float,
        sigma: float,
        amplitude: Amplitude,
        bearing: float,
        cells: int,
        steps: int,
        fold: Fold,
        graded: bool,
        start_phase: float,
        mesh: Mesh | None = None,
    ) -> None:
        if mesh is None:
            x, y = (graded_edges(cells=cells, folded=folded, graded=graded) for folded in fold)
            basis = Basis(MeshQuad.init_tensor(x, y), ElementQuad2(), intorder=5)
            free = basis.complement_dofs(basis.get_dofs(_on_rim))
        else:
            basis = Basis(mesh, ElementTriP2(), intorder=5)
            free = basis.complement_dofs(basis.get_dofs())
        s = amplitude(*basis.global_coordinates())
        wave = epsilon * np.sin(start_phase + 2 * math.pi * np.arange(steps + 1) / steps)
        half_step = math.pi / steps
        powers = [
            math.comb(3, j) * half_step * _diffusion.assemble(basis, s=s, power=j)[free][:, free]
            for j in range(4)
        ]
        self.diffusion = [sum(a**j * matrix for j, matrix in enumerate(powers)) for a in wave]
        self.weights = basis.dx.ravel()
        self.gap_weights = [self.weights * (1 + a * s.ravel()) for a in wave]
        self.values = _at_quadrature(basis, [np.asarray(shape[0]) for shape in basis.basis])[
            :, free
        ]
        slopes = _at_quadrature(basis, [shape[0].grad[0] for shape in basis.basis])[:, free]
        self.tested_old = sp.csr_matrix((sigma * self.values + half_step * bearing * slopes).T)
        self.tested_new = sp.csr_matrix((sigma * self.values - half_step * bearing * slopes).T)
        self.steps = steps
        self.unknowns = len(free)
        self.factors: list[SuperLU | None] = [None] * (steps + 1)
        self.guess: FloatArray | None = None  # u at the phases of the last period

    def pressure(self, u: FloatArray) -> FloatArray:
        """P at the quadrature points."""
        return np.asarray(np.sqrt(1 + 2 * (self.values @ u)))

    def period(self, start: FloatArray) -> tuple[FloatArray, float]:
        """u after one period from `start`, and the mean force in between."""
        u = start
        path = [u]
        force = 0.0
        for phase in range(1, self.steps + 1):
            old = self.diffusion[phase - 1] @ u - self.tested_old @ (
                self.gap_weights[phase - 1] * self.pressure(u)
            )
            step = self.guess[phase] - self.guess[phase - 1] if self.guess is not None else 0
            u = self._implicit(phase, u + step, old)
            path.append(u)
            force += self.weights @ (self.pressure(u) - 1)
        self.guess = np.array(path)
        return u, force / self.steps

    def _implicit(self, phase: int, u: FloatArray, old: FloatArray) -> FloatArray:
        """Solve one time step for u by Newton's method from the guess u."""
        gap_weights, diffusion = self.gap_weights[phase], self.diffusion[phase]
        for attempt in range(NEWTON_STEPS):
            pressure = self.pressure(u)
            residual = self.tested_new @ (gap_weights * pressure) + diffusion @ u + old
            factors = self.factors[phase]
            if factors is None or attempt % PATIENCE == PATIENCE - 1:
                stored = self.tested_new @ sp.diags(gap_weights / pressure) @ self.values
                factors = self.factors[phase] = splu(sp.csc_matrix(stored + diffusion))
            change = factors.solve(residual)
            at_points = self.values @ change
            while np.any(2 * at_points > 0.9 * pressure**2):  # keep P^2 positive
                change, at_points = change / 2, at_points / 2
            u = u - change
            if np.abs(change).max() < NEWTON_TOLERANCE:
                return u
        raise RunError(f"finite elements: time step {phase} of {self.steps} did not converge")


def _on_rim(x: FloatArray) -> NDArray[np.bool_]:
    """Which points lie on the rim of the unit square; a mirror of a folded one does not."""
    return np.asarray(np.any((x == 0) | (x == 1), axis=0))


def _at_quadrature(basis: Basis, shapes: list[FloatArray]) -> sp.csr_matrix:
    """Matrix from nodal values to quadrature points, element by element, of given shapes."""
    rows = np.arange(basis.dx.size)
    data = np.concatenate([np.broadcast_to(shape, basis.dx.shape).ravel() for shape in shapes])
    columns = np.repeat(basis.element_dofs, basis.dx.shape[1], axis=1).ravel()
    entries = (data, (np.tile(rows, len(shapes)), columns))
    return sp.csr_matrix(entries, shape=(rows.size, basis.N))


def _elements(film: Film, level: int) -> dict[str, Any]:
    """Of fourth order in space and second in time: each rung divides both errors by four."""
    return {"cells": round(3 * 2 ** (level / 2)), "steps": 8 * 2**level, "fold": film.fold}


def marched_rung(film: Film, level: int) -> dict[str, Any]:
    """From rest until the transient has decayed as far as the other errors."""
    periods = periods_to_settle(sigma=film.sigma, tolerance=0.1 / 4**level)
    return _elements(film, level) | {"periods": periods}


def _anderson_rung(film: Film, level: int) -> dict[str, Any]:
    """The change over a period stands for an error that is larger by the number of e-folds."""
    tolerance = 1e-3 * film.epsilon**2 / 4**level
    settings = {"periods": 60, "tolerance": tolerance, "anderson_depth": 10}
    return _elements(film, level) | settings


METHODS = {"elements_anderson": _anderson_rung, "elements_from_rest": marched_rung}
