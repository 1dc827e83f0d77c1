"""Momentum that a gas with inertia carries over the rim, and with it what the walls give it.

The momentum equation integrated over gap, pad and period says that both walls together give the gas
⟨∫h∇p⟩ and what leaves over the rim, ⟨∮ρ h β ū ū·n⟩, β = 6/5 for a parabola across the gap; and each
gives half, for the flow is even about the middle of the gap. On a strip with the velocity resolved
across the gap that was true of the shear at the wall to 2e-6, 1e-5 and 3e-4 of it at Re 0.45, 1.8
and 7.2, where what leaves is 1.7, 7 and 30 % of the shear (tests/numerics/test_outputs.py at the
git tag verification-2026-11).
"""

from __future__ import annotations

import numpy as np

from squeezefilm.film.scene import Scene
from squeezefilm.reynolds.flux_points import flux_points
from squeezefilm.reynolds.grid import Grid
from squeezefilm.reynolds.terms.rarefaction import flow_coefficients


def momentum_out(scene: Scene, grid: Grid, unknowns: np.ndarray) -> tuple[float, float]:
    """⟨∮ρ h β ū ū·n⟩ along the finger's x and y, in newtons.

    Args:
        unknowns: of a film with inertia on a grid: overpressure and the velocity's deficits along x
            and y (terms/inertia.py), shape (3, nx, ny, nt).
    """
    speed = scene.actuator.angular_frequency_rad_per_s * scene.finger.length_x_m
    sides_m = scene.finger.length_y_m, scene.finger.length_x_m
    found = []
    for which, (along, side_m) in enumerate(zip((grid.y, grid.x), sides_m, strict=True)):
        if (grid.x, grid.y)[which].folded:
            found.append(0.0)  # as much leaves on both sides, to both sides
            continue
        gap, velocity = at_ends(scene, grid, unknowns, which=which)
        # There the gas has ambient density.
        each = (_spread(scene, gap) * gap * velocity**2).mean(axis=-1) @ along.weights
        density = scene.gas.density_kg_per_m3
        found.append(float(each[1] - each[0]) * density * speed**2 * scene.h0_m * side_m)
    return found[0], found[1]


def at_ends(
    scene: Scene, grid: Grid, unknowns: np.ndarray, *, which: int
) -> tuple[np.ndarray, np.ndarray]:
    """Gap over h0 and mean velocity over ω l0 at both ends of an axis that is not folded.

    Along the axis ``which``, 0 or 1, at the nodes of the other one: each (2, nodes, nt).
    """
    axis, other = (grid.x, grid.y) if which == 0 else (grid.y, grid.x)
    length = 1.0 if which == 0 else scene.aspect
    pressure, deficit = (np.moveaxis(unknowns[k], which, 0) for k in (0, 1 + which))
    ends = np.array([0.0, 1.0])
    slope = np.tensordot(axis.derivative[[0, -1], 1:-1] / length, pressure, axes=1)
    missing = np.tensordot(flux_points(axis.points, folded=False).at(ends), deficit, axes=1)
    places = np.meshgrid(ends, other.nodes, indexing="ij")
    x, y = places if which == 0 else places[::-1]
    gap = scene.gap(x, y, grid.t.nodes)
    return gap, -gap * (gap + _slip(scene)) / scene.sigma * slope - missing


def _slip(scene: Scene) -> float:
    """6 Kn of first-order slip."""
    return sum(flow_coefficients(scene)[1:])


def _spread(scene: Scene, gap: np.ndarray) -> np.ndarray:
    """β, mean square of a velocity across the gap over the square of its mean: a parabola's.

    With slip it is ζ(1 − ζ) + Kn/H, ζ across the gap.
    """
    slip = _slip(scene) / 6 / gap
    return np.asarray((1 / 30 + slip / 3 + slip**2) / (1 / 6 + slip) ** 2)
