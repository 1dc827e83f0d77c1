"""Inertia of the gas: its velocity lags behind the slope of the pressure that drives it.

The momentum equation, weighted with the parabola that the velocity has over the gap, is one
equation for the mean velocity ū (lengths by the pad's length along x, time by 1/ω):

    ū + (Re ρ H²/10) { ∂ū/∂T + (9/7) (ū·∇)ū − (1/7) ū ∂ ln(ρH)/∂T } = V,    V = −(H²/σ) ∇P

with Re = ρ₀ ω h₀²/μ; beside it ∂(ρH)/∂T + ∇·(ρ H ū) = 0. Ruyer-Quil and Manneville (Eur. Phys. J. B
15, 2000) have the same numbers for a liquid film. Solved for beside the pressure is the deficit
b = V − ū, whose divergence joins the Reynolds equation: + σ ∇·(ρ H b).

At the edge gas comes in with no velocity along it, and carries out the one that it has.

With first-order slip V has the factor 1 + 6 Kn/(ρH), and the parabola with slip makes the factor
Re ρ H²/10 larger by 1 + 4 Kn/(ρH), to first order in Kn.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from math import pi
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from squeezefilm.film.scene import OperatingPoints, Scene
from squeezefilm.reynolds.spectral import AngleAxis, Axis, FluxPoints, flux_points
from squeezefilm.reynolds.terms.term import AbsentTerm, NamedArrays, NamedNumbers, Term

if TYPE_CHECKING:
    from squeezefilm.reynolds.grid import Grid

# Re of a velocity's lag at the gap h0: the parabola's 1/10.
LAG_PER_REYNOLDS = 0.1
# Where waves steepen this share of a grid's harmonics has inertia, elsewhere practically all: of
# the products of the others a grid sees little.
MIN_LAGGING_HARMONICS_FRACTION, MAX_LAGGING_HARMONICS_FRACTION, STEEP_WAVES_STEEPNESS = (
    0.5,
    2.0,
    0.45,
)
# And no more than so many whose waves have nodes enough, for each node and wave of the first
# harmonic, fewer where the gas runs against them at a share of their own speed; or that are damped
# within a part of a wave. With more the linear system is all but singular, for Newton's steps go
# along waves that the grid does not resolve: 17 of 200 random scenes had no
# state on their first grids.
NODES_PER_WAVE, COUNTERFLOW_WAVE_FACTOR, DAMPED_WAVES_PER_NODE_FACTOR = 3.0, 0.8, 0.1
# Share of a velocity at the edge, about, within which gas is neither coming in nor going out: with
# a fifth or five times as much a force (Re 4.3, ε 0.65, σ 17) changed by 1e-6.
REVERSING_VELOCITY_FRACTION = 0.1
# By so much a first grid takes layers to be thinner than σ says, where they are thinner than in a
# film of this σ, or waves steeper than STIFF_WAVE_STEEPNESS: without it two grids agreed by chance
# at σ 1e5, ε 0.5, Re 0.5, on a force that was off by four times its estimate, and a quarter of the
# paper's scenes needed a third grid.
THIN_LAYER_SIGMA_FACTOR, THIN_LAYER_SIGMA, STIFF_WAVE_STEEPNESS = 2.5, 1e4, 0.05
# And as thin as by (WAVE_LAYER_FACTOR ε Re)⁴, at most so many times, where waves are shorter than
# half of the pad and do not steepen much (nine pistons, ε Re 0.8 to 2.5): without it they took up
# to five grids, each of which has more instants too.
WAVE_LAYER_FACTOR, MAX_LAYER_SIGMA_FACTOR, SHORT_WAVE_NUMBER = 1.2, 50.0, 4 * pi
# A velocity at the edge is about ε s/√σ in a film with layers there, and no more than without.
MIN_ROOT_SIGMA = 4.0
# Stands for zero in a denominator.
TINY_DENOMINATOR = 1e-14
# Of matrices at and from the flux points of an axis, those of a curved axis last.
FLUX_MATRIX_NAMES = (
    *("values", "nodes", "slope", "along", "divergence", "across", "edge", "to_end", "amplitude"),
    *("over_area", "bend"),
)


class VelocityTerm(Term):
    """A term of the gas' velocities, along each axis on its flux points and the other's nodes."""

    def matrices(self, grid: Grid, *, aspect: float) -> NamedArrays:
        return flux_point_matrices(grid, aspect=aspect)

    def profile_fields(self, parts: np.ndarray, grid: Grid) -> NamedArrays:
        along_x, along_y = _flux_points_of_grid(grid)
        return {
            "flux_amplitude_x": along_x.matrix_from_all_nodes @ parts[..., grid.y.inner_slice],
            "flux_amplitude_y": parts[:, :, grid.x.inner_slice] @ along_y.matrix_from_all_nodes.T,
        }

    def unsupported_on_grid_reason(self, scene: Scene) -> str:
        if scene.gas.rarefaction == "fukui-kaneko":
            which = "fukui-kaneko, only with viscous flow or first-order slip"
            return f"not supported: {self.label} with {which}"
        return ""


class Inertia(VelocityTerm):
    label = "inertia"
    NAME = "inertia"
    EQUATION_NUMBER_WIDTHS: ClassVar[Mapping[str, int]] = {"reynolds": 0, "reversing": 0}
    ABSENT_TERM = AbsentTerm("inertia", "gas.inertia does not include it", "no inertia")
    KERNEL_FILE = "terms/inertia_over_period.cl"
    KERNEL_HOOKS = ("residual", "response", "step", "carry")
    VELOCITY_FIELD_COUNT = 1
    SUPPORTS_SINGLE_PRECISION = True
    WORK_FIELD_COUNT = 21
    LINEAR_FIELD_COUNT = 44
    SPACE_MATRIX_PRODUCT_COUNT = 7
    TIME_MATRIX_PRODUCT_COUNT = 10
    SUPPORTS_EXPANSIONS = True
    INTERPOLATION_MATRIX_NAMES = ("carry_flux_x", "carry_flux_y")
    OPERATOR_NAMES = tuple(f"flux_{name}_{axis}" for axis in "xy" for name in FLUX_MATRIX_NAMES)

    @classmethod
    def of(cls, scene: Scene) -> Inertia | None:
        return cls() if scene.gas.inertia == "included" else None

    def equation_numbers(self, scene: OperatingPoints) -> NamedNumbers:
        reynolds = scene.modified_reynolds
        lag = LAG_PER_REYNOLDS * reynolds
        steep = np.maximum(wave_mach_estimate(scene), TINY_DENOMINATOR)
        slow = MIN_LAGGING_HARMONICS_FRACTION * np.maximum(1.0, STEEP_WAVES_STEEPNESS / steep) ** 3
        thinness = np.maximum(scene.sigma**0.5, MIN_ROOT_SIGMA)
        # Waves travel at 1/√(lag σ), in units of the pad's length times ω.
        waves = (lag * scene.sigma) ** 0.5 * (
            1 + COUNTERFLOW_WAVE_FACTOR * wave_mach_estimate(scene)
        )
        return {
            "reynolds": reynolds,
            "lag": lag,
            "reversing": REVERSING_VELOCITY_FRACTION
            * np.maximum(scene.epsilon, TINY_DENOMINATOR)
            / thinness,
            "slow": np.minimum(slow, MAX_LAGGING_HARMONICS_FRACTION),
            "waves_per_node": np.maximum(
                NODES_PER_WAVE / waves, DAMPED_WAVES_PER_NODE_FACTOR / lag
            ),
        }

    def layer_sigma_factor(self, scene: OperatingPoints, *, sigma: Any) -> Any:
        layered = (sigma > THIN_LAYER_SIGMA) | (wave_mach_estimate(scene) > STIFF_WAVE_STEEPNESS)
        least = np.where(layered, THIN_LAYER_SIGMA_FACTOR, 1.0)
        reynolds = scene.modified_reynolds
        short = LAG_PER_REYNOLDS * reynolds * sigma > SHORT_WAVE_NUMBER**2
        wavy = short & (wave_mach_estimate(scene) < STEEP_WAVES_STEEPNESS)
        waves = np.where(wavy, (WAVE_LAYER_FACTOR * scene.epsilon * reynolds) ** 4, 0.0)
        return np.clip(waves, least, MAX_LAYER_SIGMA_FACTOR)

    def interpolation_matrices(self, coarse: Grid, fine: Grid) -> NamedArrays:
        pairs = zip("xy", _flux_points_of_grid(coarse), _flux_points_of_grid(fine), strict=True)
        return {
            f"carry_flux_{axis}": its.matrix_to_finer_points(finer) for axis, its, finer in pairs
        }


def wave_mach_estimate(scene: OperatingPoints) -> Any:
    """Steepness of waves: a velocity in a thick film over the speed of sound, roughly."""
    return scene.epsilon * (scene.modified_reynolds / 5) ** 0.5


@lru_cache(maxsize=256)
def flux_point_matrices(grid: Grid, *, aspect: float) -> NamedArrays:
    """The matrices of velocities along each axis (spectral.py), by their names in the kernels."""
    lengths = grid.axis_lengths(aspect)
    matrices = [
        _flux_matrices_of_axis(axis, length)
        for axis, length in zip((grid.x, grid.y), lengths, strict=True)
    ]
    if grid.outline:
        matrices = [
            {**matrices_of_axis, **bent}
            for matrices_of_axis, bent in zip(matrices, _coordinate_curvatures(grid), strict=True)
        ]
    return {
        f"flux_{name}_{axis}": matrix
        for axis, of_axis in zip("xy", matrices, strict=True)
        for name, matrix in of_axis.items()
    }


@lru_cache(maxsize=64)
def _flux_matrices_of_axis(axis: Axis | AngleAxis, length: float) -> NamedArrays:
    return flux_points(axis).matrices(length)


def _flux_points_of_grid(grid: Grid) -> list[Any]:
    """FluxPoints of x and y; of an outline AroundPoints of y."""
    return [flux_points(axis) for axis in (grid.x, grid.y)]


def _coordinate_curvatures(grid: Grid) -> list[NamedArrays]:
    """Return 1/J and the bend of the velocity at the flux points of μ and of ν.

    With W = (dz/dζ)* ū, whose parts lie along μ and ν, (dz/dζ)* (ū·∇)ū is

        ((W·∇)W − |W|² (z″/z′)*)/J.
    """
    points = (FluxPoints(grid.x).all_points[: grid.nx], -1.0), (grid.x.nodes, -1j)
    return [
        {
            "over_area": 1 / np.asarray(grid.area_ratio_at(at)),
            "bend": np.real(part * grid.conformal_map_log_slope(at)),
        }
        for at, part in points
    ]
