"""What leaving things out saves, and that it costs no accuracy: each put back in turn.

Scenes of the study's space are solved as they need, and again with one thing put back: the mirror
halves, a term that is zero, more modes than wanted, time where a limit would do. Of a term so
little is put back that it changes nothing but has to be computed. Last, the same algorithm in
NumPy.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from itertools import product
from typing import Any

import numpy as np
import pandas as pd

from squeezefilm.film.scene import Scene
from squeezefilm.reynolds import Solution, solve
from squeezefilm.reynolds.device import Device
from squeezefilm.reynolds.error_estimate import ITERATION_SHARE
from squeezefilm.reynolds.grid import Grid
from squeezefilm.reynolds.needs import needs_of
from squeezefilm.reynolds.periodic.launch import solve_batch
from squeezefilm.reynolds.periodic.refinement import solve_periodic
from squeezefilm.reynolds.terms import TERMS
from verification.numpy_periodic import periodic_state
from verification.timing import measure

# A grid that is fine enough for every scene of the paper's space, and the one it is checked with.
ONE_FOR_ALL = (
    Grid(nx=28, ny=28, nt=16, fold_x=False, fold_y=False),
    Grid(nx=32, ny=32, nt=20, fold_x=False, fold_y=False),
)
AS_NEEDED = "nothing"
# What puts a term back, by its name: numbers of the scene's finger, gap or gas.
NEGLIGIBLE = 1e-14
PUT_BACK: dict[str, dict[str, Any]] = {
    "any_gap": {"bulge_m": NEGLIGIBLE * 1e-6},
    "bearing": {"speed_x_m_per_s": NEGLIGIBLE},
    "rarefaction": {"rarefaction": "fukui-kaneko", "mean_free_path_m": NEGLIGIBLE * 1e-6},
    "polytropic": {"polytropic_exponent": 1 + NEGLIGIBLE},
    "inertia": {"inertia": "included", "density_kg_per_m3": NEGLIGIBLE},
    "heat": {"heat": "included", "prandtl": NEGLIGIBLE},
}
REFERENCE_TOLERANCE = 1e-9

Forces = tuple[Sequence[float], Sequence[float]]
"""Mean forces in newtons, and the errors stated for them."""


def ablation(
    scenes: Sequence[Scene], *, tolerances: Sequence[float], repeats: int, device: Device
) -> pd.DataFrame:
    """For each tolerance a row for the scenes as they need, and one for each thing put back.

    Columns: what is put back, seconds of all scenes in one call, processor time over that of the
    scenes as they need, worst relative error, share of scenes within their error estimate; NumPy
    has none, nor the points that tight tolerances ask for.
    """
    own = partial(_solved, device=device)
    periodic = partial(own, method="periodic")
    one_grid = partial(_on_one_grid, device=device)
    exact = np.array(periodic(scenes, tolerance=REFERENCE_TOLERANCE)[0])
    with_all = scenes
    for changes in PUT_BACK.values():
        with_all = _with(with_all, changes)
    ways: dict[str, tuple[Callable[..., Forces], Sequence[Scene]]] = {
        AS_NEEDED: (own, scenes),
        "time (always periodic)": (periodic, scenes),
        "mirror halves": (partial(_on_whole_pads, device=device), scenes),
        **{
            kind.ABSENT.what: (periodic, _with(scenes, PUT_BACK[kind.NAME]))
            for kind in TERMS
            if kind.ABSENT
        },
        "finest modes for all": (one_grid, scenes),
        "everything": (one_grid, with_all),
        "everything, in NumPy": (_in_numpy, scenes),
    }
    rows = []
    for tolerance, (put_back, (way, changed)) in product(tolerances, ways.items()):
        call = partial(way, changed, tolerance=tolerance)
        timed = measure(call, repeats=repeats, long_seconds=math.inf)
        force, stated = map(np.array, timed.result)
        error = np.abs(force - exact)
        row = {
            "put_back": put_back,
            "tolerance": tolerance,
            "cpu_seconds": timed.cpu_seconds,
            "wall_seconds": timed.wall_seconds,
            "worst_error": np.max(error / np.abs(exact)),
            "covered": np.mean(error <= stated) if np.isfinite(stated).all() else math.nan,
        }
        rows.append(row)
    table = pd.DataFrame(rows)
    needed = table[table["put_back"] == AS_NEEDED].set_index("tolerance")["cpu_seconds"]
    ratio = table["cpu_seconds"] / table["tolerance"].map(needed)
    return table.assign(cpu_ratio=ratio, scenes=len(scenes))


def _with(scenes: Sequence[Scene], changes: dict[str, Any]) -> list[Scene]:
    """Scenes with other numbers."""

    def changed(whole: Any) -> Any:
        return replace(whole, **{name: changes[name] for name in changes if hasattr(whole, name)})

    fingers = [replace(changed(each.finger), gap=changed(each.finger.gap)) for each in scenes]
    pairs = zip(scenes, fingers, strict=True)
    return [replace(scene, finger=finger, gas=changed(scene.gas)) for scene, finger in pairs]


def _forces(solutions: Sequence[Solution]) -> Forces:
    return [each.force_n for each in solutions], [each.force_error_n for each in solutions]


def _solved(
    scenes: Sequence[Scene], *, tolerance: float, device: Device, method: str = "auto"
) -> Forces:
    return _forces(solve(scenes, tolerance=tolerance, method=method, device=device))


def _on_whole_pads(scenes: Sequence[Scene], *, tolerance: float, device: Device) -> Forces:
    whole = np.zeros(len(scenes), dtype=bool)
    needs = replace(needs_of(scenes), fold_x=whole, fold_y=whole)
    return _forces(solve_periodic(needs, tolerance=tolerance, device=device))


def _on_one_grid(scenes: Sequence[Scene], *, tolerance: float, device: Device) -> Forces:
    """Every scene on the same two grids over the whole finger, each solved from rest."""
    coarse, fine = (
        solve_batch(scenes, grid, tolerance=ITERATION_SHARE * tolerance, device=device)
        for grid in ONE_FOR_ALL
    )
    scale = np.array([scene.force_scale_n for scene in scenes])
    stated = 2 * np.abs(fine.mean - coarse.mean) + fine.said["residual"]
    return list(scale * fine.mean), list(scale * stated)


def _in_numpy(scenes: Sequence[Scene], *, tolerance: float) -> Forces:
    """Of the plain equation, on 24 × 24 × 16 points of the whole finger."""
    forces = []
    for scene in scenes:
        numbers: dict[str, Any] = {"epsilon": scene.epsilon, "sigma": scene.sigma}
        state = periodic_state(**numbers, amplitude=scene.amplitude, tolerance=1e-4 * tolerance)
        forces.append(scene.force_scale_n * state.force)
    return forces, [math.nan] * len(forces)
