"""Finite elements in space, Crank-Nicolson in time: the textbook method, with scikit-fem.

Scheme: with u = (P^2 - 1)/2 the film equation reads, for every test function phi that
vanishes on the edge,

    sigma d/dT int H P phi = -int H^3 grad u . grad phi + Lambda int H P dphi/dX,

with P = sqrt(1 + 2 u),

so diffusion is linear in u and its matrix a cubic in epsilon sin T assembled once. Biquadratic
quadrilaterals (9 nodes) on a mesh graded towards the edge; Crank-Nicolson from rest, fully
implicit. Each step is solved by Newton's method with the factors of the same phase of an
earlier period, renewed when they no longer serve.

Order: 2 in time, 4 in space for the force on a smooth film (the layer of width
sqrt(2/sigma) must be resolved first). Cost: see `marching.periods_to_settle`; far less with
Anderson acceleration of the period map.
Source: Gustafsson and McBain, J. Open Source Softw. 5(52), 2020 (scikit-fem); Crank and
Nicolson, Proc. Camb. Phil. Soc. 43, 1947.
"""

import math
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.sparse.linalg import SuperLU, splu
from skfem import Basis, BilinearForm, ElementQuad2, ElementTriP2, Mesh, MeshQuad
from skfem.helpers import dot, grad

from squeezefilm.errors import RunError
from squeezefilm.film.scene import Scene
from squeezefilm_workflow.verification.marching import (
    FloatArray,
    film_symmetry_in_x_and_y,
    graded_cell_edges,
    march_to_periodic_force,
)

MAX_NEWTON_STEPS = 40
NEWTON_STEPS_PER_FACTORS = 4  # Newton steps with old factors before new ones are made
NEWTON_TOLERANCE = 1e-9  # on u, of order epsilon


@BilinearForm
def _diffusion_form(u, v, w):  # type: ignore[no-untyped-def]
    return w["s"] ** w["power"] * dot(grad(u), grad(v))


def periodic_mean_force(
    scene: Scene, *, cells: int = 8, steps: int = 32, mesh: Mesh | None = None, **marching: Any
) -> float:
    """Mean force in p0 l0^2 over the last period.

    cells: elements along each half side, folded or not; steps: time steps a period;
    mesh: triangles of another pad than the square, all of whose sides are its edge, in
    units of its side along x from a corner of what surrounds it; marching: as
    `march_to_periodic_force` takes it, the tolerance that of u.

    Raises RunError when a time step does not converge.
    """
    fold = film_symmetry_in_x_and_y(scene) if mesh is None else (False, False)
    if mesh is None:
        x, y = (graded_cell_edges(cells=cells, folded=folded) for folded in fold)
        basis = Basis(MeshQuad.init_tensor(x, y), ElementQuad2(), intorder=5)
        free = basis.complement_dofs(basis.get_dofs(lambda x: np.any((x == 0) | (x == 1), axis=0)))
    else:
        basis = Basis(mesh, ElementTriP2(), intorder=5)
        free = basis.complement_dofs(basis.get_dofs())
    film = _FilmOnElements(scene, basis, free, steps=steps)
    return march_to_periodic_force(
        film.march_one_period, np.zeros(len(free)), **marching
    ) * 2 ** sum(fold)


class _FilmOnElements:
    """The discretised film: matrices of all phases, and the factors kept between periods."""

    def __init__(self, scene: Scene, basis: Basis, free: NDArray[np.int64], *, steps: int) -> None:
        x, y = basis.global_coordinates()
        gap = scene.epsilon * scene.amplitude(x, y / scene.aspect)
        wave = np.sin(2 * math.pi * np.arange(steps + 1) / steps)
        half_step = math.pi / steps
        powers = [
            math.comb(3, j)
            * half_step
            * _diffusion_form.assemble(basis, s=gap, power=j)[free][:, free]
            for j in range(4)
        ]
        self.diffusion = [sum(a**j * matrix for j, matrix in enumerate(powers)) for a in wave]
        self.weights = basis.dx.ravel()
        self.gap_weights = [self.weights * (1 + a * gap.ravel()) for a in wave]
        shapes = [shape for shape, *_ in basis.basis]
        self.values = _quadrature_matrix(basis, [np.asarray(shape) for shape in shapes])[:, free]
        slopes = _quadrature_matrix(basis, [shape.grad[0] for shape in shapes])[:, free]
        slide = half_step * scene.bearing_number * slopes
        self.tested_old = sp.csr_matrix((scene.sigma * self.values + slide).T)
        self.tested_new = sp.csr_matrix((scene.sigma * self.values - slide).T)
        self.steps = steps
        self.factors: list[SuperLU | None] = [None] * (steps + 1)
        self.guess: FloatArray | None = None  # u at the phases of the last period

    def pressure_at_quadrature(self, u: FloatArray) -> FloatArray:
        """P at the quadrature points."""
        return np.asarray(np.sqrt(1 + 2 * (self.values @ u)))

    def march_one_period(self, start: FloatArray) -> tuple[FloatArray, float]:
        """u after one period from `start`, and the mean force in between."""
        u = start
        path = [u]
        force = 0.0
        for phase in range(1, self.steps + 1):
            old = self.diffusion[phase - 1] @ u - self.tested_old @ (
                self.gap_weights[phase - 1] * self.pressure_at_quadrature(u)
            )
            step = self.guess[phase] - self.guess[phase - 1] if self.guess is not None else 0
            u = self._implicit_time_step(phase, u + step, old)
            path.append(u)
            force += self.weights @ (self.pressure_at_quadrature(u) - 1)
        self.guess = np.array(path)
        return u, force / self.steps

    def _implicit_time_step(self, phase: int, u: FloatArray, old: FloatArray) -> FloatArray:
        """Solve one time step for u by Newton's method from the guess u."""
        gap_weights, diffusion = self.gap_weights[phase], self.diffusion[phase]
        for attempt in range(MAX_NEWTON_STEPS):
            pressure = self.pressure_at_quadrature(u)
            residual = self.tested_new @ (gap_weights * pressure) + diffusion @ u + old
            factors = self.factors[phase]
            if (
                factors is None
                or attempt % NEWTON_STEPS_PER_FACTORS == NEWTON_STEPS_PER_FACTORS - 1
            ):
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


def _quadrature_matrix(basis: Basis, shapes: list[FloatArray]) -> sp.csr_matrix:
    """Matrix from nodal values to quadrature points, element by element, of given shapes."""
    rows = np.arange(basis.dx.size)
    data = np.concatenate([np.broadcast_to(shape, basis.dx.shape).ravel() for shape in shapes])
    columns = np.repeat(basis.element_dofs, basis.dx.shape[1], axis=1).ravel()
    entries = (data, (np.tile(rows, len(shapes)), columns))
    return sp.csr_matrix(entries, shape=(rows.size, basis.N))
