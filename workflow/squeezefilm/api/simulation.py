"""From a table of scenes to their forces: on one device, whole or in parts."""

import sys
import time
from collections.abc import Sequence
from contextlib import nullcontext
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from squeezefilm.api.forces import solved_with
from squeezefilm.config.loading import Config
from squeezefilm.errors import InputError, RunError, naming
from squeezefilm.film.scene import Scene, Scenes
from squeezefilm.parallel import progress_bar
from squeezefilm.quantities.model_error import excluded_terms
from squeezefilm.reynolds import Solution, node_cache
from squeezefilm.reynolds.device import Device, describe
from squeezefilm.reynolds.periodic.launch import warm
from squeezefilm.solution import Solutions, as_in
from squeezefilm.studies.solver_settings import SolverSettings, device_of
from squeezefilm.studies.study import film_in, scenes_in
from squeezefilm.tables import (
    SCENE_COLUMNS,
    TIMING_COLUMNS,
    read_forces,
    read_scenes,
    read_timings,
    table_writer,
)

PIECE = 4096
"""Scenes whose results are held before they are written."""
NAMED = 100
"""Points without a force, at most, in a message."""


def device_ready(config: Config, *, option: str | None, scene: Scene) -> Device:
    """The device of a study with its kernels compiled for scenes like one; on a node once."""
    with node_cache.one_build_at_a_time():
        device = device_of(config, option=option)
        warm(device, scene)
    return device


def compile_kernels(config: Config) -> dict[str, Any]:
    """Compile the kernels of a study, so that jobs find them in the caches; name its device."""
    # Which terms a film needs does not depend on its gap, so no gap need be one of the study's.
    scene = film_in(config).scene(h0_m=5e-6, hv_m=0.0)
    facts = describe(device_ready(config, option=None, scene=scene))
    del facts["global_memory_bytes"]  # PoCL's is what is free at the moment
    return facts


def chunk_rows(chunk: int, chunks: int, count: int) -> slice:
    """The rows of one of several chunks: contiguous parts that differ by at most one row."""
    return slice(count * (chunk - 1) // chunks, count * chunk // chunks)


def simulate_table(
    scenes: Path | str,
    config: Config,
    *,
    settings: SolverSettings,
    output: Path | str,
    timings: Path | str | None = None,
    chunk: tuple[int, int] = (1, 1),
    device: str | None = None,
    derivatives: bool = False,
) -> tuple[list[str], list[str]]:
    """Solve the scenes of a table and write a row for each, whatever became of it.

    Args:
        timings: where to write each scene's share of the run time.
        chunk: which of how many parts of the table.
        device: instead of the study's.
        derivatives: of the force too.

    Returns:
        the points without a force, each with its reason, and those that have a force but not all
        that was asked for beside it.

    Raises InputError, before anything is solved, for a scene that cannot be.
    """
    table = read_scenes(scenes, rows=partial(chunk_rows, *chunk))
    planned = scenes_of_table(table, config=config, path=scenes)
    chosen = device_ready(config, option=device, scene=planned[0])
    failures: list[str] = []
    incomplete: list[str] = []
    seconds = 0.0
    times = table_writer(timings) if timings else nullcontext(lambda rows: None)
    with (
        progress_bar(len(table), unit="scene", name=str(scenes)) as bar,
        table_writer(output) as write,
        times as write_times,
    ):
        for first in range(0, len(table), PIECE):
            rows, batch = table.iloc[first : first + PIECE], planned[first : first + PIECE]
            start = time.perf_counter()
            solutions = solved_with(
                settings.resolved(batch, chosen),
                settings=settings,
                device=chosen,
                derivatives=derivatives,
                report=bar.update,
            )
            wall = time.perf_counter() - start
            write(_forces(rows, solutions))
            # By floating-point operations, of which closed forms need none worth counting.
            work = np.array([solution.work for solution in solutions])
            shares = work / work.sum() if work.any() else np.full(len(work), 1 / len(work))
            write_times(rows[["point_id"]].assign(solve_seconds=wall * shares))
            seconds += wall
            for point_id, solution in zip(rows["point_id"], solutions, strict=True):
                if reason := missing_of(solution):
                    missing = incomplete if solution.status == "ok" else failures
                    missing.append(f"point {point_id}: {reason}")
    for note in excluded_terms(planned[0], method=settings.method):
        print(note, file=sys.stderr)
    solved = len(table) - len(failures)
    print(f"{solved} of {len(table)} scenes solved in {seconds:.3f} s", file=sys.stderr)
    return failures, incomplete


def missing_of(solution: Solution) -> str:
    """Why there is no force, or not what was asked for beside it; empty if all is there."""
    asked = (solution, solution.derivatives, solution.outputs)
    return next((each.status for each in asked if each and each.status != "ok"), "")


def scenes_of_table(rows: pd.DataFrame, *, config: Config, path: Path | str) -> Scenes:
    """The scenes of a table's rows; the table's path stands before what is wrong with one."""
    with naming(path):
        return scenes_in(rows, config)


def _forces(rows: pd.DataFrame, solutions: Sequence[Solution]) -> pd.DataFrame:
    """The rows of a plan with what was solved for them."""
    found = Solutions.of(solutions).to_frame(rows.index)
    asked = pd.DataFrame([each.asked_columns for each in solutions], index=rows.index)
    return pd.concat([rows[as_in(SCENE_COLUMNS, rows)], found, asked], axis=1)


def merge_forces(
    scenes: Path | str, parts: Sequence[Path | str], *, output: Path | str, keep_failed: bool
) -> None:
    """Put the forces of a plan's parts together, one part held at a time.

    Raises InputError where the parts are not the rows of the plan in its order, RunError naming the
    points without a force unless these may stay; then nothing is written.
    """
    plan_rows = read_scenes(scenes)
    columns = as_in(SCENE_COLUMNS, plan_rows)
    failures: list[str] = []
    first = 0
    with table_writer(output) as write:
        for part in parts:
            rows = read_forces(part, whole=True)
            planned = plan_rows.iloc[first : first + len(rows)].reset_index(drop=True)
            if not planned.equals(rows.reindex(columns=columns)):
                raise InputError(
                    f"{part}: its points are not those of {scenes} from row {first + 1} on; "
                    "simulate it again"
                )
            failed = rows[rows["status"] != "ok"]
            failures += [
                f"point {row.point_id}: {row.status} ({part})" for row in failed.itertuples()
            ]
            first += len(rows)
            write(rows)
        if first < len(plan_rows):
            raise InputError(f"{scenes}: point {plan_rows['point_id'].iloc[first]} is in no part")
        if failures and not keep_failed:
            raise RunError(no_force(failures, scenes))


def no_force(failures: Sequence[str], scenes: Path | str) -> str:
    """The message for points without a force."""
    more = f" and {len(failures) - NAMED} more" if len(failures) > NAMED else ""
    return f"{scenes}: no force for {'; '.join(failures[:NAMED])}{more}"


def merge_timings(parts: Sequence[Path | str], *, output: Path | str) -> None:
    """Put the run times of a plan's parts together."""
    with table_writer(output) as write:
        for part in parts:
            write(read_timings(part)[list(TIMING_COLUMNS)])
