"""Savings by each simplification, and its effect on accuracy: each is removed in turn.

Scenes of the study's space are solved as they need, and again with one simplification disabled:
the mirror halves, a term that is zero, more modes than wanted, time where a limit would do. Of a
term so little is re-enabled that it changes nothing but has to be computed. Last, the same
algorithm in NumPy.
"""

from collections import ChainMap
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from itertools import product
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from squeezefilm.film.scene import Scene, Scenes
from squeezefilm.reynolds import solve
from squeezefilm.reynolds.device import Device
from squeezefilm.reynolds.grid import Grid
from squeezefilm.reynolds.periodic.launch import solve_batch
from squeezefilm.reynolds.periodic.refinement import solve_periodic
from squeezefilm.reynolds.plan import solve_plan_of
from squeezefilm.reynolds.terms import TERM_CLASSES
from squeezefilm.solution import Solutions
from squeezefilm_workflow.verification.numpy_periodic import periodic_mean_force
from squeezefilm_workflow.verification.work_precision import measure_call_times

# A grid that is fine enough for every scene of the paper's space, and the one it is checked with.
COMMON_GRIDS = (
    Grid(nx=28, ny=28, nt=16, fold_x=False, fold_y=False),
    Grid(nx=32, ny=32, nt=20, fold_x=False, fold_y=False),
)
NOTHING_DISABLED_LABEL = "nothing"
# What puts a term back, by its name: numbers of the scene's pad, gap or gas.
TERM_ENABLING_TINY_VALUE = 1e-14
TERM_ENABLING_CHANGES: dict[str, dict[str, Any]] = {
    "any_gap": {"crown_m": TERM_ENABLING_TINY_VALUE * 1e-6},
    "bearing": {"speed_x_m_per_s": TERM_ENABLING_TINY_VALUE},
    "rarefaction": {
        "rarefaction": "fukui-kaneko",
        "mean_free_path_m": TERM_ENABLING_TINY_VALUE * 1e-6,
    },
    "polytropic": {"polytropic_exponent": 1 + TERM_ENABLING_TINY_VALUE},
    "inertia": {"inertia": "included", "density_kg_per_m3": TERM_ENABLING_TINY_VALUE},
    "thermal": {"thermal": "included", "prandtl": TERM_ENABLING_TINY_VALUE},
}
REFERENCE_TOLERANCE = 1e-9
# Share of a tolerance that Newton's iteration may leave on one grid for all.
ITERATION_ERROR_FRACTION = 0.2


def ablation_table(
    scenes: Sequence[Scene], *, tolerances: Sequence[float], repeats: int, device: Device
) -> pd.DataFrame:
    """Table with a row for each tolerance and each simplification that is disabled.

    Columns: what is re-enabled, seconds of all scenes in one call, processor time over that of the
    scenes as they need, worst relative error, share of scenes within their error estimate; NumPy
    has none, nor the points that tight tolerances ask for.
    """
    periodic = partial(solve, method="periodic", device=device)
    one_grid = partial(_solve_on_common_grids, device=device)
    with_all = _scenes_with_changes(scenes, dict(ChainMap(*TERM_ENABLING_CHANGES.values())))
    ways: dict[str, tuple[Callable[..., StatedForces | Solutions], Sequence[Scene]]] = {
        NOTHING_DISABLED_LABEL: (partial(solve, device=device), scenes),
        "time (always periodic)": (periodic, scenes),
        "symmetry": (partial(_solve_on_whole_pads, device=device), scenes),
        **{
            kind.ABSENT_TERM.name: (
                periodic,
                _scenes_with_changes(scenes, TERM_ENABLING_CHANGES[kind.NAME]),
            )
            for kind in TERM_CLASSES
            if kind.ABSENT_TERM
        },
        "finest modes for all": (one_grid, scenes),
        "everything": (one_grid, with_all),
        "everything, in NumPy": (_solve_in_numpy, scenes),
    }
    exact = periodic(scenes, tolerance=REFERENCE_TOLERANCE).force_n
    rows = []
    for tolerance, (re_enabled, (way, changed)) in product(tolerances, ways.items()):
        call = partial(way, changed, tolerance=tolerance)
        forces, (_, cpu_s, _) = measure_call_times(call, repeats=repeats, long_seconds=np.inf)
        error, stated = np.abs(forces.force_n - exact), forces.force_error_n
        row = {
            "re_enabled": re_enabled,
            "tolerance": tolerance,
            "cpu_s": cpu_s,
            "worst_error": np.max(error / np.abs(exact)),
            "coverage": np.mean(error <= stated) if np.isfinite(stated).all() else np.nan,
        }
        rows.append(row)
    table = pd.DataFrame(rows)
    needed = table[table["re_enabled"] == NOTHING_DISABLED_LABEL].set_index("tolerance")["cpu_s"]
    ratio = table["cpu_s"] / table["tolerance"].map(needed)
    return table.assign(cpu_ratio=ratio, scenes=len(scenes))


def _scenes_with_changes(scenes: Sequence[Scene], changes: dict[str, Any]) -> list[Scene]:
    """Return the scenes with changed numbers of pad, gap or gas."""

    def with_changed_attributes(whole: Any) -> Any:
        return replace(whole, **{name: changes[name] for name in changes if hasattr(whole, name)})

    pads = [
        replace(with_changed_attributes(each.pad), gap=with_changed_attributes(each.pad.gap))
        for each in scenes
    ]
    pairs = zip(scenes, pads, strict=True)
    return [replace(scene, pad=pad, gas=with_changed_attributes(scene.gas)) for scene, pad in pairs]


class StatedForces(NamedTuple):
    """Forces of scenes and their stated errors."""

    force_n: np.ndarray
    force_error_n: np.ndarray


def _solve_on_whole_pads(scenes: Sequence[Scene], *, tolerance: float, device: Device) -> Solutions:
    whole = np.zeros(len(scenes), dtype=bool)
    plan = replace(solve_plan_of(scenes), fold_x=whole, fold_y=whole)
    solutions = Solutions.unsolved_of_method("periodic", len(plan.scenes))
    solve_periodic(plan, solutions, tolerance=tolerance, device=device)
    return solutions


def _solve_on_common_grids(
    scenes: Sequence[Scene], *, tolerance: float, device: Device
) -> StatedForces:
    """Every scene on the same two grids over the whole pad, each solved from rest."""
    coarse, fine = (
        solve_batch(
            scenes,
            grid,
            tolerance=ITERATION_ERROR_FRACTION * tolerance,
            device=device,
            many=True,
        )
        for grid in COMMON_GRIDS
    )
    scale = Scenes.of(scenes).force_scale_n
    stated = 2 * np.abs(fine.mean_pressure_ratio - coarse.mean_pressure_ratio)
    return StatedForces(
        scale * fine.mean_pressure_ratio, scale * (stated + fine.result_rows["residual"])
    )


def _solve_in_numpy(scenes: Sequence[Scene], *, tolerance: float) -> StatedForces:
    """Forces of the uniform-gap equation on 24 × 24 × 16 points of the whole pad."""
    means = np.array([periodic_mean_force(each, tolerance=1e-4 * tolerance) for each in scenes])
    return StatedForces(Scenes.of(scenes).force_scale_n * means, np.full(len(scenes), np.nan))
