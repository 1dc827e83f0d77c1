"""Sliding: the bearing term −Λ d(Hρ)/dX of a pad that moves along its own x axis."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from squeezefilm.film.scene import OperatingPoints, Scene
from squeezefilm.reynolds.terms.inertia import flux_point_matrices
from squeezefilm.reynolds.terms.rarefaction import flow_to_viscous_ratio
from squeezefilm.reynolds.terms.term import AbsentTerm, NamedArrays, NamedNumbers, Term

if TYPE_CHECKING:
    from squeezefilm.reynolds.grid import Grid


class Bearing(Term):
    label = "Couette term"
    NAME = "bearing"
    ABSENT_TERM = AbsentTerm("Couette term", "the pad is at rest")
    SYMMETRY_BROKEN_AXES = "x"
    KERNEL_FILE = "terms/bearing_over_period.cl"
    KERNEL_HOOKS = ("residual", "response")

    @classmethod
    def of(cls, scene: Scene) -> Bearing | None:
        return cls() if scene.bearing_number != 0 else None

    def equation_numbers(self, scene: OperatingPoints) -> NamedNumbers:
        return {"bearing": scene.bearing_number}

    def matrices(self, grid: Grid, *, aspect: float) -> NamedArrays:
        if grid.outline is None:
            return {"derivative_x": grid.x.derivative_matrix[1:-1, 1:-1]}
        along, turn = (
            flux_point_matrices(grid, aspect=aspect),
            np.asarray(grid.conformal_map_slope(grid.x.nodes)),
        )
        return {
            "derivative_x": along["flux_across_x"],
            "derivative_y": along["flux_across_y"],
            "turn_x": turn.real,
            "turn_y": -turn.imag,
        }

    def scene_operators(self, numbers: np.ndarray, grid: Grid, *, aspect: float) -> NamedArrays:
        """Real Schur form of d²/dX² − (Λ/D) d/dX, each (scenes, nx, nx).

        An orthogonal basis stays well conditioned where the eigenvectors of a convection-dominated
        operator do not. D, the mean diffusivity, is that of the film at ambient pressure. The
        vectors are scaled so that coefficients measure like nodal values.
        """
        if grid.outline:  # modes in space are those of its area (outline.py)
            return {}
        from scipy.linalg import schur

        scale, first = np.sqrt(grid.nx), grid.x.derivative_matrix[1:-1, 1:-1]
        vectors, inverse, triangle = np.empty((3, len(numbers), grid.nx, grid.nx))
        ambient = flow_to_viscous_ratio(numbers, np.ones(len(numbers)))
        for k, (speed, flow) in enumerate(zip(numbers["bearing"], ambient, strict=True)):
            operator = grid.x.second_derivative - speed / flow * first
            triangle[k], basis = schur(operator, output="real")
            vectors[k], inverse[k] = basis * scale, basis.T / scale
        return {"modes_x": vectors, "to_modes_x": inverse, "triangle": triangle}
