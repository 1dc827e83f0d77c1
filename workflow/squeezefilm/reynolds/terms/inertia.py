"""Inertia of the gas: its velocity lags behind the slope of the pressure that drives it.

The momentum equation, weighted with the parabola that the velocity has over the gap, is one
equation for the mean velocity ū (lengths by the finger's length along x, time by 1/ω):

    ū + (Re ρ H²/10) { ∂ū/∂T + (9/7) (ū·∇)ū − (1/7) ū ∂ ln(ρH)/∂T } = V,    V = −(H²/σ) ∇P

with Re = ρ₀ ω h₀²/μ; beside it ∂(ρH)/∂T + ∇·(ρ H ū) = 0. Ruyer-Quil and Manneville (Eur. Phys. J. B
15, 2000) have the same numbers for a liquid film. Solved for beside the pressure is the deficit
b = V − ū, whose divergence joins the Reynolds equation: + σ ∇·(ρ H b).

With first-order slip V has the factor 1 + 6 Kn/(ρH), and the parabola with slip makes the factor
Re ρ H²/10 larger by 1 + 4 Kn/(ρH), to first order in Kn.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from squeezefilm.film.scene import Scene
from squeezefilm.reynolds.flux_points import FluxPoints, flux_points
from squeezefilm.reynolds.terms.term import Arrays, LeftOut, Numbers, Term

if TYPE_CHECKING:
    from squeezefilm.reynolds.grid import Grid

# Re of a velocity's lag at the gap h0: the parabola's 1/10.
LAG_PER_REYNOLDS = 0.1


@dataclass(frozen=True)
class Inertia(Term):
    label: str = "inertia"

    NAME = "inertia"
    ABSENT = LeftOut("inertia", "gas.inertia is none")
    OVER_PERIOD = "terms/inertia_over_period.cl"
    HOOKS = ("residual", "response", "step", "carry")
    UNKNOWN_FIELDS = 2
    OWN_FIELDS = 27
    CARRYING = ("carry_flux_x", "carry_flux_y")

    @classmethod
    def of(cls, scene: Scene) -> Inertia | None:
        return cls() if scene.gas.inertia == "included" else None

    def numbers(self, scene: Scene) -> Numbers:
        reynolds = scene.modified_reynolds
        return {"reynolds": reynolds, "lag": LAG_PER_REYNOLDS * reynolds}

    def matrices(self, grid: Grid, *, aspect: float) -> Arrays:
        return {
            f"flux_{name}_{axis}": matrix
            for axis, points, length in zip("xy", _points(grid), (1.0, aspect), strict=True)
            for name, matrix in {
                "values": points.from_nodes,
                "nodes": points.to_nodes,
                "slope": points.slope / length,
                "along": points.along / length,
                "divergence": points.divergence / length,
                "across": points.across / length,
            }.items()
        }

    def profile_fields(self, s: np.ndarray, grid: Grid) -> Arrays:
        along_x, along_y = _points(grid)
        inner_x, inner_y = slice(1, grid.nx + 1), slice(1, grid.ny + 1)
        return {
            "flux_amplitude_x": along_x.from_all_nodes @ s[:, :, inner_y],
            "flux_amplitude_y": s[:, inner_x] @ along_y.from_all_nodes.T,
        }

    def refused_on_grid(self, scene: Scene) -> str:
        if scene.gas.rarefaction == "fukui-kaneko":
            return "inertia is derived for viscous flow and first-order slip, not for fukui-kaneko"
        if scene.bearing_number != 0:
            return "inertia is not derived for a sliding finger"
        return ""

    def carrying(self, coarse: Grid, fine: Grid) -> Arrays:
        pairs = zip("xy", _points(coarse), _points(fine), strict=True)
        return {f"carry_flux_{axis}": its.carried_to(finer) for axis, its, finer in pairs}


def _points(grid: Grid) -> tuple[FluxPoints, FluxPoints]:
    return flux_points(grid.nx, grid.fold_x), flux_points(grid.ny, grid.fold_y)
