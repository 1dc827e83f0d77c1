"""Resistance and inertance of flow around a film's edge, by finite elements across the gap.

Gas leaves a gap of height h between a wall that goes on and a pad with an upright side. It is
taken as incompressible and its oscillation as small:

    i Re u = −∇p + ∇²u,   ∇·u = 0,   Re = ρ ω h²/μ,

lengths by h, with u = 0 at the walls, or a velocity along them of the slip length times its slope.
Far inside, p falls along x by a constant slope. The pressure that its line has at the edge, over
the flow through the gap, is the impedance of what is outside: over 12 a resistance, the elongation
of the gap for slow flow, and Re times an inertance. The gas outside moves as far as waves of sound
or the pad's other sides let it; the pressure is ambient at the distance ``open_radius``.

Scheme: Taylor–Hood quadrilaterals (scikit-fem) on a mesh that is graded towards the edge.
"""

import argparse
from itertools import product

import numpy as np
import pandas as pd
from scipy.sparse import bmat
from scipy.sparse.linalg import splu
from skfem import (
    Basis,
    BilinearForm,
    ElementQuad1,
    ElementQuad2,
    ElementVector,
    FacetBasis,
    Functional,
    LinearForm,
    MeshQuad,
)
from skfem.helpers import ddot, div, dot, grad

from squeezefilm.cli.options import command, option
from squeezefilm.table_writer import write_table
from squeezefilm_workflow.verification.marching import FloatArray

# Length of the gap in the mesh, in gaps; beyond half of it the flow has no trace of the edge.
GAP_LENGTH = 4.0
# Size of the cells at the edge, in gaps, and how it grows away from it.
SMALLEST_CELL_SIZE, CELL_GROWTH = 1 / 24, 1.4
# Rows of the table: Re, slip lengths over the gap, and distances at which the pressure is ambient.
REYNOLDS_NUMBERS, SLIP_LENGTHS = (0.1, 0.5, 2.0, 5.0, 10.0), (0.0, 0.02, 0.1)
OPEN_RADII = (30.0, 100.0, 1000.0)


@command(option("--output", "TABLE.csv", "table to write", required=True))
def edge_flow(options: argparse.Namespace) -> None:
    """Resistance and inertance of flow around the edge, for small oscillations.

      squeezefilm-verification edge-flow --output TABLE.csv

    Two-dimensional flow out of a gap, with inertia and slip, by finite elements: the factors of the
    error budget's effect `edge_flow`, and their errors.
    """
    rows = [
        {
            "modified_reynolds": reynolds,
            "slip_length_over_gap": slip_length,
            "open_radius_over_gap": radius,
            "resistance": impedance.real,
            "inertance": impedance.imag / reynolds,
        }
        for reynolds, slip_length, radius in product(REYNOLDS_NUMBERS, SLIP_LENGTHS, OPEN_RADII)
        for impedance in [edge_impedance(reynolds, slip_length=slip_length, open_radius=radius)]
    ]
    write_table(pd.DataFrame(rows), options.output)


def edge_impedance(
    reynolds: float, *, slip_length: float = 0.0, open_radius: float = 300.0
) -> complex:
    """Return resistance + i Re inertance of the flow around an edge.

    Args:
        slip_length: over the gap.
        open_radius: distance at which the pressure is ambient, over the gap.
    """
    mesh = _gap_with_open_space(open_radius)
    velocity = Basis(mesh, ElementVector(ElementQuad2()))
    pressure = velocity.with_element(ElementQuad1())
    inlet = FacetBasis(mesh, velocity.elem, facets=mesh.boundaries["inlet"])
    walls = np.concatenate([mesh.boundaries["level"], mesh.boundaries["upright"]])
    momentum = BilinearForm(
        lambda u, v, w: ddot(grad(u), grad(v)) + 1j * reynolds * dot(u, v), dtype=complex
    ).assemble(velocity)
    fixed = [velocity.get_dofs(walls).all()]
    if slip_length:
        # No flow through walls, and shear there over the slip length.
        fixed = [
            velocity.get_dofs(mesh.boundaries[name]).all([f"u^{1 + axis}"])
            for name, axis in (("level", 1), ("upright", 0))
        ]
        along_walls = FacetBasis(mesh, velocity.elem, facets=walls)
        momentum += BilinearForm(lambda u, v, w: dot(u, v) / slip_length).assemble(along_walls)
    divergence = BilinearForm(lambda u, q, w: -div(u) * q).assemble(velocity, pressure)
    push = LinearForm(lambda v, w: -dot(w.n, v)).assemble(inlet)  # p = 1 there
    matrix = bmat([[momentum, divergence.T], [divergence, None]]).tocsc()
    right = np.concatenate([push, np.zeros(pressure.N)]).astype(complex)
    free = np.setdiff1d(np.arange(len(right)), np.concatenate(fixed))
    solution = np.zeros(len(right), dtype=complex)
    solution[free] = splu(matrix[free][:, free]).solve(right[free])
    flow, gauge = np.split(solution, [velocity.N])
    through = Functional(lambda w: -dot(w["u"], w.n)).assemble(inlet, u=inlet.interpolate(flow))
    inside = np.array([[-GAP_LENGTH / 2], [0.5]])
    slope = through / _flow_per_slope(reynolds, slip_length)
    return complex(((pressure.probes(inside) @ gauge)[0] - slope * GAP_LENGTH / 2) / (12 * through))


def _flow_per_slope(reynolds: float, slip_length: float) -> complex:
    """Return the flow through a gap of 1 for a slope −1 of the pressure."""
    if not reynolds:
        return 1 / 12 + slip_length / 2
    k = np.sqrt(1j * reynolds)
    # u = (1 − A cosh k(y − 1/2))/(i Re), A by the velocity at the wall.
    wall = np.cosh(k / 2) + slip_length * k * np.sinh(k / 2)
    return complex((1 - 2 * np.sinh(k / 2) / (k * wall)) / (1j * reynolds))


def _gap_with_open_space(radius: float) -> MeshQuad:
    """Return a mesh of the gap, x < 0 < y < 1, and of the space beyond its end, of a radius."""
    outward = _graded_nodes(radius)
    half = _graded_nodes(0.5)
    x = np.concatenate([-_graded_nodes(GAP_LENGTH)[:0:-1], outward])
    y = np.concatenate([half, 1 - half[-2::-1], 1 + outward[1:]])
    mesh = MeshQuad.init_tensor(x, y)
    centre = mesh.p[:, mesh.t].mean(axis=1)
    mesh = mesh.restrict(np.flatnonzero((centre[0] > 0) | (centre[1] < 1)))

    def level(points: FloatArray) -> np.ndarray:
        return (points[1] == 0) | ((points[1] == 1) & (points[0] < 0))

    return mesh.with_boundaries(
        {
            "inlet": lambda points: points[0] == -GAP_LENGTH,
            "level": level,
            "upright": lambda points: (points[0] == 0) & (points[1] > 1),
        }
    )


def _graded_nodes(length: float) -> FloatArray:
    """Return nodes from 0 to a length, their distances growing from the smallest."""
    ratio = length / SMALLEST_CELL_SIZE
    count = int(np.ceil(np.log1p(ratio * (CELL_GROWTH - 1)) / np.log(CELL_GROWTH)))
    nodes = (CELL_GROWTH ** np.arange(count + 1) - 1) / (CELL_GROWTH**count - 1)
    return np.asarray(length * nodes)
