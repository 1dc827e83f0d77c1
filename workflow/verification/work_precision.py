"""Error against run time of the solver and of three other methods, and the times at equal error.

A path is a list of settings made by a rule that is written down here, not by looking at errors: the
parts of a method's error (space, time, settling) shall fall at the same rate from rung to rung. A
rung that takes longer than a given time is the last of its path.
"""

import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from math import ceil, log, sqrt
from statistics import median
from typing import Any

import numpy as np
import pandas as pd

from squeezefilm.errors import RunError
from squeezefilm.parallel import say
from squeezefilm.reynolds import solve
from squeezefilm.reynolds.device import Device
from verification import chebyshev_march, finite_elements, numpy_periodic
from verification.films import Film
from verification.marching import periods_to_settle
from verification.reference import reference_force

FILMS = (
    Film("ε = 0.1, σ = 20", 0.1, 20.0),
    Film("ε = 0.44, σ = 583", 0.44, 583.0),
    Film("off centre, ε = 0.4, σ = 2331", 0.4, 2331.0, x=0.29),
    Film("ε = 0.9, σ = 583", 0.9, 583.0),
)
SOLVER, BATCH = "solver", "solver, in a batch"
Settings = dict[str, Any]


# A mean force in p0 l0^2, the error that the method claims for it (NaN: none), its status.
Answer = tuple[float, float, str]
# The settings of a method from rung to rung, and the call that solves a film with them.
Path = Iterator[tuple[Settings, Callable[[], Answer]]]


def measure(
    call: Callable[[], Any], *, repeats: int, long_seconds: float = 0.2
) -> tuple[Any, float]:
    """What a call returns, and the median of its processor time in seconds.

    It is warm: called once before, then so many times. A call that takes more than long_seconds is
    not repeated: its first run is what it takes, and what is done once (imports, compilation) does
    not show beside it.
    """
    times = []
    for _ in range(repeats + 1):
        wall, cpu = time.perf_counter(), time.process_time()
        result = call()
        times.append(time.process_time() - cpu)
        if time.perf_counter() - wall > long_seconds:
            break
    return result, median(times[1:] or times)


def work_precision(
    films: tuple[Film, ...],
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
    for film in films:
        say(film.name)
        reference = reference_force(
            epsilon=film.epsilon, sigma=film.sigma, gap=film.scene.gap, fold=film.fold
        )
        paths: dict[str, Path] = {
            SOLVER: _by_tolerance(film, batch=1, device=device, rungs=rungs),
            BATCH: _by_tolerance(film, batch=batch, device=device, rungs=rungs),
            **{method: _other(film, method, rungs=rungs) for method in METHODS},
        }
        for method, path in paths.items():
            for settings, run in path:
                (force, claimed, status), cpu_seconds = measure(run, repeats=repeats)
                row = {
                    "film": film.name,
                    "method": method,
                    "settings": " ".join(f"{key}={each:g}" for key, each in settings.items()),
                    "status": status,
                    "force": force,
                    "reference": reference.force,
                    "reference_uncertainty": reference.uncertainty / reference.force,
                    "relative_error": abs(force / reference.force - 1),
                    "estimated_error": claimed / reference.force,
                    "cpu_seconds": cpu_seconds / (batch if method == BATCH else 1),
                }
                rows.append(row)
                if cpu_seconds > longest_seconds:
                    break
    return with_times_less(pd.DataFrame(rows))


def with_times_less(table: pd.DataFrame) -> pd.DataFrame:
    """With how many times less processor time the solver takes than another method's each row.

    The solver is asked for a tolerance and chooses its method, its error estimate included in the
    time; of the tolerances whose true error is no larger, the cheapest counts. Errors within the
    reference's uncertainty count as that uncertainty. NaN where no tolerance is as good, and for
    the solver itself.
    """
    seen = table["relative_error"].clip(lower=table["reference_uncertainty"])
    others = table[~table["method"].isin((SOLVER, BATCH))]
    times = {}
    for column, method in (("times_less", SOLVER), ("times_less_in_a_batch", BATCH)):
        ours = table[(table["method"] == method) & (table["status"] == "ok")]
        cheapest = [
            ours.loc[(ours["film"] == film) & (seen[ours.index] <= error), "cpu_seconds"].min()
            for film, error in zip(others["film"], seen[others.index], strict=True)
        ]
        times[column] = others["cpu_seconds"] / cheapest
    return table.assign(**times)


def _by_tolerance(film: Film, *, batch: int, rungs: int, device: Device) -> Path:
    """What a user does: a tolerance is asked for, and the error estimated.

    In a batch beside others within 1 % of its epsilon, which have nothing in common with it.
    """
    films = [replace(film, epsilon=film.epsilon * (1 - 0.01 * k / batch)) for k in range(batch)]
    scenes, scale = [each.scene for each in films], film.scene.force_scale_n

    def answer(tolerance: float) -> Answer:
        first = solve(scenes, tolerance=tolerance, device=device)[0]
        return first.force_n / scale, first.force_error_n / scale, first.status

    for tolerance in [10.0**-k for k in range(1, 11)][:: max(1, 10 // rungs)]:
        yield {"tolerance": tolerance}, partial(answer, tolerance)


def _other(film: Film, method: str, *, rungs: int) -> Path:
    solved, path = METHODS[method]
    numbers: Settings = {"sigma": film.sigma}
    if solved is numpy_periodic.periodic_state:
        numbers["gap"] = film.scene.gap
    else:
        numbers |= {"epsilon": film.epsilon, "amplitude": film.amplitude, "fold": film.fold}

    def answer(settings: Settings) -> Answer:
        try:
            return solved(**numbers, **settings).force, np.nan, "ok"
        except RunError as error:
            return np.nan, np.nan, str(error)

    for level in range(rungs):
        settings = path(film, level)
        yield settings, partial(answer, settings)


def _grid(film: Film, level: int) -> Settings:
    """A layer of width 1/sqrt(sigma) takes Chebyshev points in proportion to sigma^(1/4), the
    harmonics of powers of 1/(1 + epsilon sin T) fall by a factor each."""
    tolerance = 10.0 ** -(level + 1)
    harmonics = log(tolerance) / log(film.epsilon / (1 + sqrt(1 - film.epsilon**2)))
    points = 4 * ceil((7 + 0.36 * (level + 1) * film.sigma**0.25) / 4)
    instants = max(8, 4 * ceil(harmonics / 4))
    return {"nx": points, "ny": points, "nt": instants, "tolerance": 1e-3 * tolerance}


def _chebyshev(film: Film, level: int) -> Settings:
    """Spectral in space: two points and one decade of the integrator's tolerance a rung."""
    return {"points": 4 + 2 * level, "rtol": 10.0 ** -(level + 2)}


def _elements(film: Film, level: int) -> Settings:
    """Of fourth order in space and second in time: each rung divides both errors by four."""
    return {"cells": round(3 * 2 ** (level / 2)), "steps": 8 * 2**level}


def _from_rest(film: Film, level: int) -> Settings:
    """From rest until the transient has decayed as far as the other errors."""
    periods = periods_to_settle(sigma=film.sigma, tolerance=0.1 / 4**level)
    return _elements(film, level) | {"periods": periods}


def _accelerated(film: Film, level: int) -> Settings:
    """The change over a period stands for an error that is larger by the number of e-folds."""
    tolerance = 1e-3 * film.epsilon**2 / 4**level
    settings = {"periods": 60, "tolerance": tolerance, "anderson_depth": 10}
    return _elements(film, level) | settings


# Other methods: what gives the mean force in p0 l0^2, and the settings of a path's rungs.
METHODS: dict[str, tuple[Callable[..., Any], Callable[[Film, int], Settings]]] = {
    "same algorithm, NumPy, no symmetry": (numpy_periodic.periodic_state, _grid),
    "Chebyshev, Radau, Anderson": (chebyshev_march.periodic_force, _chebyshev),
    "finite elements, Anderson": (finite_elements.periodic_force, _accelerated),
    "finite elements from rest": (finite_elements.periodic_force, _from_rest),
}
