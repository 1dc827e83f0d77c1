"""Error against run time of the solver and of other methods, and the times at equal error.

A path is a list of settings made by a rule that is written down here, not by looking at errors: the
parts of a method's error (space, time, settling) shall fall at the same rate from rung to rung. A
rung that takes longer than a given time is the last of its path.

Films with inertia and thermal effects have one other method, collocation with dense matrices
(``all_effects``), whose own grid is their reference.
"""

import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from math import ceil, log, sqrt
from typing import Any

import numpy as np
import pandas as pd

from squeezefilm.errors import RunError
from squeezefilm.film.scene import Scene
from squeezefilm.parallel import print_step
from squeezefilm.reynolds import solve
from squeezefilm.reynolds.device import Device
from squeezefilm.reynolds.terms import terms_label, terms_of
from squeezefilm_workflow.verification import chebyshev_march, finite_elements, numpy_periodic
from squeezefilm_workflow.verification.all_effects import (
    Effects,
    force_on_grid,
    grid_sizes_of_scene,
)
from squeezefilm_workflow.verification.films import listed_films
from squeezefilm_workflow.verification.marching import periods_to_settle
from squeezefilm_workflow.verification.reference import ReferenceForce, reference_force

TIMED_FILMS = tuple(listed_films("timed"))
"""The last four have inertia and thermal effects."""
COMPARED_EFFECTS = Effects(slip="none")
SOLVER_NAME, BATCH_SOLVER_NAME = "solver", "solver, in a batch"
MethodSettings = dict[str, Any]
MethodFunctions = dict[str, tuple[Callable[..., float], Callable[[Scene, int], MethodSettings]]]
CLOCK_FUNCTIONS = time.perf_counter, time.process_time, time.thread_time


# A mean force in p0 l0^2, the error that the method claims for it (NaN: none), its status.
ForceErrorAndStatus = tuple[float, float, str]


def measure_call_times(
    call: Callable[[], Any], *, repeats: int, long_seconds: float = 0.2
) -> tuple[Any, np.ndarray]:
    """Return the result of a call, and medians of its wall, processor and main thread's time in s.

    It is warm: called once before, then so many times. A call that takes more than long_seconds is
    not repeated: its first run is what it takes, and what is done once (imports, compilation) does
    not show beside it.
    """
    times = []
    for _ in range(repeats + 1):
        before = [clock() for clock in CLOCK_FUNCTIONS]
        result = call()
        times.append(
            [clock() - start for clock, start in zip(CLOCK_FUNCTIONS, before, strict=True)]
        )
        if times[-1][0] > long_seconds:
            break
    return result, np.median(times[1:] or times, axis=0)


def work_precision_table(
    films: tuple[Scene, ...],
    *,
    repeats: int,
    batch: int,
    longest_seconds: float,
    rungs: int,
    device: Device,
) -> pd.DataFrame:
    """Rows: each film by each method, forces in units of p0 l0^2, seconds per film.

    Args:
        repeats, longest_seconds: timings per rung, and the CPU seconds beyond which a path ends.
        batch: films solved together.
        rungs: the most of any path.
    """
    rows = []
    tolerances = [{"tolerance": 10.0**-k} for k in range(1, 11)][:: max(1, 10 // rungs)]
    for scene in films:
        print_step(scene.point_id)
        reference = _independent_mean_force(scene)
        # Others within 1 % of its epsilon, which have nothing in common with it.
        alike = [replace(scene, hv_m=scene.hv_m * (1 - 0.01 * k / batch)) for k in range(batch)]
        # How a method answers, and its settings from rung to rung.
        paths: dict[str, tuple[Callable[..., ForceErrorAndStatus], list[MethodSettings]]] = {
            SOLVER_NAME: (partial(_solve_by_solver, [scene], device), tolerances),
            BATCH_SOLVER_NAME: (partial(_solve_by_solver, alike, device), tolerances),
        }
        others = OTHER_METHODS if scene.gas.inertia == "none" else OTHER_METHODS_WITH_EFFECTS
        for method, (solved, settings_of) in others.items():
            path = [settings_of(scene, level) for level in range(rungs)]
            paths[method] = partial(_solve_by_other_method, solved, scene), path
        for scenes in ([scene], alike):  # what is compiled once is in no method's time
            solve(scenes, tolerance=tolerances[0]["tolerance"], device=device)
        for method, (answer, path) in paths.items():
            for settings in path:
                call = partial(answer, **settings)
                (force, claimed, status), (_, cpu_s, _) = measure_call_times(call, repeats=repeats)
                row = {
                    "case": scene.point_id,
                    "terms": terms_label(terms_of(scene)),
                    "method": method,
                    "settings": " ".join(f"{key}={each:g}" for key, each in settings.items()),
                    "status": status,
                    "force": force,
                    "reference": reference.force,
                    "reference_uncertainty": reference.uncertainty / reference.force,
                    "relative_error": abs(force / reference.force - 1),
                    "estimated_error": claimed / reference.force,
                    "cpu_s": cpu_s / (batch if method == BATCH_SOLVER_NAME else 1),
                }
                rows.append(row)
                if cpu_s > longest_seconds:
                    break
    return with_speedup(pd.DataFrame(rows))


def with_speedup(table: pd.DataFrame) -> pd.DataFrame:
    """Table with the speedup of the solver over each row of another method.

    The solver is asked for a tolerance and chooses its method, its error estimate included in the
    time; of the tolerances whose true error is no larger, the cheapest counts. Errors within the
    reference's uncertainty count as that uncertainty. NaN where no tolerance is as good, and for
    the solver itself.
    """
    seen = table["relative_error"].clip(lower=table["reference_uncertainty"])
    others = table[~table["method"].isin((SOLVER_NAME, BATCH_SOLVER_NAME))]
    times = {}
    for column, method in (("speedup", SOLVER_NAME), ("speedup_in_batch", BATCH_SOLVER_NAME)):
        ours = table[(table["method"] == method) & (table["status"] == "ok")]
        cheapest = [
            ours.loc[(ours["case"] == case) & (seen[ours.index] <= error), "cpu_s"].min()
            for case, error in zip(others["case"], seen[others.index], strict=True)
        ]
        times[column] = others["cpu_s"] / cheapest
    return table.assign(**times)


def _solve_by_solver(
    scenes: list[Scene], device: Device, *, tolerance: float
) -> ForceErrorAndStatus:
    """Solve as a user does: to a tolerance, with an estimated error."""
    first, scale = solve(scenes, tolerance=tolerance, device=device)[0], scenes[0].force_scale_n
    return first.force_n / scale, first.force_error_n / scale, first.status


def _solve_by_other_method(
    solved: Callable[..., float], scene: Scene, **settings: Any
) -> ForceErrorAndStatus:
    try:
        return solved(scene, **settings), np.nan, "ok"
    except (RunError, ArithmeticError) as error:
        return np.nan, np.nan, str(error)


def _independent_mean_force(scene: Scene) -> ReferenceForce:
    """Return the mean force by a program that shares no discretisation with the solver."""
    if scene.gas.inertia == "none":
        return reference_force(scene)
    fine, coarse = (
        _dense_collocation_force(scene, points=points, instants=instants)
        for points, instants in grid_sizes_of_scene(scene)
    )
    return ReferenceForce(fine, abs(fine - coarse))


def _dense_collocation_force(scene: Scene, *, points: int, instants: int) -> float:
    force_n = force_on_grid(scene, COMPARED_EFFECTS, points=points, instants=instants)
    return force_n / scene.force_scale_n


def _dense_settings(scene: Scene, level: int) -> MethodSettings:
    """Spectral in space and time: four points across, twice two along a radius, two instants."""
    return {"points": 8 + 4 * level, "instants": 7 + 2 * level}


def _collocation_settings(scene: Scene, level: int) -> MethodSettings:
    """A layer of width 1/sqrt(sigma) takes Chebyshev points in proportion to sigma^(1/4), the
    harmonics of powers of 1/(1 + epsilon sin T) fall by a factor each."""
    tolerance = 10.0 ** -(level + 1)
    harmonics = log(tolerance) / log(scene.epsilon / (1 + sqrt(1 - scene.epsilon**2)))
    points = 4 * ceil((7 + 0.36 * (level + 1) * scene.sigma**0.25) / 4)
    instants = max(8, 4 * ceil(harmonics / 4))
    return {"nx": points, "ny": points, "nt": instants, "tolerance": 1e-3 * tolerance}


def _chebyshev_march_settings(scene: Scene, level: int) -> MethodSettings:
    """Spectral in space: two points and one decade of the integrator's tolerance a rung."""
    return {"points": 4 + 2 * level, "rtol": 10.0 ** -(level + 2)}


def _finite_element_settings(scene: Scene, level: int) -> MethodSettings:
    """Return a refinement level: fourth order in space, second in time, both errors a quarter."""
    return {"cells": round(3 * 2 ** (level / 2)), "steps": 8 * 2**level}


def _start_from_rest_settings(scene: Scene, level: int) -> MethodSettings:
    """Settings of a start from rest until the transient has decayed as far as the other errors."""
    periods = periods_to_settle(sigma=scene.sigma, tolerance=0.1 / 4**level)
    return _finite_element_settings(scene, level) | {"periods": periods}


def _anderson_settings(scene: Scene, level: int) -> MethodSettings:
    """The change over a period stands for an error that is larger by the number of e-folds."""
    tolerance = 1e-3 * scene.epsilon**2 / 4**level
    settings = {"periods": 60, "tolerance": tolerance, "anderson_depth": 10}
    return _finite_element_settings(scene, level) | settings


# Other methods: what gives the mean force in p0 l0^2, and the settings of a path's rungs.
OTHER_METHODS: MethodFunctions = {
    "same algorithm, NumPy, no symmetry": (
        numpy_periodic.periodic_mean_force,
        _collocation_settings,
    ),
    "Chebyshev, Radau, Anderson": (chebyshev_march.periodic_mean_force, _chebyshev_march_settings),
    "finite elements, Anderson": (finite_elements.periodic_mean_force, _anderson_settings),
    "finite elements from rest": (finite_elements.periodic_mean_force, _start_from_rest_settings),
}
OTHER_METHODS_WITH_EFFECTS: MethodFunctions = {
    "collocation, dense matrices": (_dense_collocation_force, _dense_settings)
}
