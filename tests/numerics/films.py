"""Scenes made from dimensionless numbers, for tests of the solver."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import pi
from typing import Any

import numpy as np

from squeezefilm.film.pad import Pad
from squeezefilm.film.profiles import Piston, Profile, Sinc
from squeezefilm.film.scene import Actuator, Gas, Scene
from squeezefilm.reynolds.asymptotics.composite import AsymptoticForces, expand_scenes
from squeezefilm.reynolds.asymptotics.films import Films, expansion_axis, films_of
from squeezefilm.reynolds.device import choose_device
from squeezefilm.reynolds.grid import Grid
from squeezefilm.reynolds.periodic.launch import PeriodicStates, solve_batch
from squeezefilm.reynolds.plan import solve_plan_of
from squeezefilm.reynolds.solver import solve
from squeezefilm.solution import Solution

SINC = Sinc(wave_number_per_m=109.8)
PISTON = Piston()
LENGTH_M = 0.01
PRESSURE_PA = 1e5
H0_M = 5e-6


def film(
    *,
    epsilon: float,
    sigma: float,
    profile: Profile = SINC,
    x: float = 0.0,
    y: float = 0.0,
    bearing: float = 0.0,
    aspect: float = 1.0,
    knudsen: float = 0.0134,
    **gas: Any,
) -> Scene:
    """A scene with the given ε, σ, Λ; the pad's centre at x, y in units of its side."""
    angular_frequency = 2 * pi * 4e4
    viscosity = sigma * PRESSURE_PA * H0_M**2 / (12 * angular_frequency * LENGTH_M**2)
    speed = bearing * PRESSURE_PA * H0_M**2 / (6 * viscosity * LENGTH_M)
    return Scene(
        point_id="film",
        h0_m=H0_M,
        hv_m=epsilon * H0_M,
        x_m=x * LENGTH_M,
        y_m=y * LENGTH_M,
        gas=Gas(
            viscosity_pa_s=viscosity,
            ambient_pressure_pa=PRESSURE_PA,
            density_kg_per_m3=1.2,
            mean_free_path_m=knudsen * H0_M,
            **{"inertia": "none", "thermal": "none"} | gas,
        ),
        actuator=Actuator(angular_frequency / (2 * pi), 1.0, profile=profile),
        pad=Pad(LENGTH_M, aspect * LENGTH_M, speed),
    )


def at_reynolds(scene: Scene, reynolds: float) -> Scene:
    """The scene with the density that gives it a modified Reynolds number."""
    density = scene.gas.density_kg_per_m3 * reynolds / scene.modified_reynolds
    return scene.with_gas(density_kg_per_m3=density)


def with_pad(scene: Scene, **changes: Any) -> Scene:
    """The scene with another shape, gap or speed of its pad."""
    return replace(scene, pad=replace(scene.pad, **changes))


def solved(
    scene: Scene, *, tolerance: float = 1e-6, method: str = "periodic", **how: Any
) -> Solution:
    """The solution of a scene that has one."""
    (solution,) = solve([scene], tolerance=tolerance, method=method, **how)
    assert solution.status == "ok"
    return solution


def mean(scene: Scene, *, tolerance: float = 1e-6, method: str = "periodic") -> float:
    """Mean overpressure over pad and period."""
    return solved(scene, tolerance=tolerance, method=method).force_n / scene.force_scale_n


def periodic_state(
    scene: Scene, *, points: int, instants: int, fold: bool = False, tolerance: float = 1e-10
) -> tuple[Grid, PeriodicStates]:
    """The scene solved on one given grid: ``points`` across the pad in both directions."""
    unknowns = points // 2 if fold else points
    grid = Grid(nx=unknowns, ny=unknowns, nt=instants, fold_x=fold, fold_y=fold)
    return grid, solve_batch([scene], grid, tolerance=tolerance, device=choose_device())


def mean_overpressure(
    scene: Scene, *, points: int, instants: int, fold: bool = False, tolerance: float = 1e-10
) -> float:
    """Force in units of p0 × area on one given grid."""
    _, states = periodic_state(
        scene, points=points, instants=instants, fold=fold, tolerance=tolerance
    )
    assert states.status_indices[0] == 0
    return float(states.mean_pressure_ratio[0])


def spring_and_damping(scene: Scene, *, points: int) -> tuple[float, float]:
    """Spring and damping numbers S, D of a film, from its force at a small amplitude."""
    grid, states = periodic_state(scene, points=points, instants=8)
    force = np.einsum(
        "xyt,x,y->t",
        states.gauge_pressure_ratio[0],
        grid.x.quadrature_weights,
        grid.y.quadrature_weights,
    )
    spring = -2 * np.mean(force * np.sin(grid.t.nodes)) / scene.epsilon
    damping = -2 * np.mean(force * np.cos(grid.t.nodes)) / scene.epsilon
    return float(spring), float(damping)


def limit(
    method: Callable[[Films], AsymptoticForces],
    *,
    epsilon: list[float] | np.ndarray,
    sigma: list[float] | np.ndarray,
    points: int = 31,
    slip: float = 0.0,
    **place: Any,
) -> AsymptoticForces:
    """A method applied to films under one pad."""
    nodes = expansion_axis(points).all_nodes
    scene = film(epsilon=0.1, sigma=1.0, **place)
    s = scene.amplitude(*np.meshgrid(nodes, nodes, indexing="ij"))
    profiles = np.repeat(s[None], len(epsilon), axis=0)
    numbers = np.array(epsilon), np.array(sigma)
    return method(films_of(*numbers, profiles, aspect=scene.aspect, slip=slip))


def expansion_of(
    expand: Callable[[Films], AsymptoticForces], scene: Scene, *, tolerance: float
) -> tuple[float, float]:
    """A scene's force by an expansion and its error, in newtons."""
    found = expand_scenes(expand, solve_plan_of(scene), [0], tolerance=tolerance)
    return found.mean_pressure_ratio[0] * scene.force_scale_n, found.pressure_ratio_error[
        0
    ] * scene.force_scale_n


@dataclass(frozen=True)
class AsTheGap:
    """A surface that moves most where the gap is wide, s = gap at rest / h0."""

    scene: Scene
    is_complex = False

    def amplitude(self, *, x_m: np.ndarray, y_m: np.ndarray) -> np.ndarray:
        pad = self.scene.pad
        rise_m = pad.gap.rise_m(x_m / pad.length_x_m + 0.5, y_m / pad.length_y_m + 0.5)
        return 1 + rise_m / self.scene.h0_m
