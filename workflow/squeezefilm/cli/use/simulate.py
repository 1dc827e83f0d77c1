"""Mean squeeze-film forces by solving the Reynolds equation, each with an error estimate.

  squeezefilm simulate SCENES.csv --config CONFIG.yaml --output FORCES.csv
  squeezefilm simulate --h0 5um --hv 2.2um --x -2mm
  squeezefilm simulate --h0 5um --hv 0.5:2.5:9um --output CURVE.csv

The first takes a table of scenes. The others take quantities: a number with its unit, several with
commas, or evenly spaced ones as first:last:count; every combination is a point. One point is shown
with all that is known of its force; several make a table, in which `force_error_n` has the part of
a scan too and, with `--budget`, `left_out_…_percent` is what the film equation leaves out, least
and most.

`validity` is `ok`, or the limits of validity of the film equation that a scene exceeds, with what
that means. One point outside them is shown too, with exit status 1; rows of a table end with 0.

Tolerance means |error| <= tolerance * |force| + round-off floor, the floor being 1e-14 of the
largest overpressure times the finger's area. The exit status is 1 when a scene has no force; all
rows are written nevertheless, each with its status. Of a table of scenes `force_error_n` is the
solver's error alone; what the noise of a measured profile adds, `squeezefilm profile` says.
`--derivatives` adds those of the force to h0, hv, the finger's place (x, y) and each number of the
gas, the others kept, with their errors, by one adjoint problem per scene; `derivatives_status` says
why there are none. `--outputs thrust,power` adds answers beside the force, of harmonics, power,
centre, moments, thrust, extremes and static_stiffness, or `all`, instead of the study's `outputs`:
each with its error, by the periodic state; `outputs_status` says what is not known and why.
"""

import argparse
import sys
import time
from collections.abc import Sequence
from contextlib import nullcontext
from functools import partial

import pandas as pd

from squeezefilm.api.forces import WITH_STATES, force_of, forces_of, forces_table, solved
from squeezefilm.api.points import scene_points_of
from squeezefilm.cli import which_study
from squeezefilm.cli.points import add_point_options, points_in, write_points
from squeezefilm.film.measured.smooth import SmoothedScan
from squeezefilm.film.scene import Scene
from squeezefilm.film.validity import OK
from squeezefilm.io.errors import InputError, RunError, naming
from squeezefilm.io.positions import as_in
from squeezefilm.io.progress import progress_bar
from squeezefilm.io.solution import OUTPUTS
from squeezefilm.io.tables import (
    FORCE_COLUMNS,
    all_rows,
    read_scenes,
    scene_points,
    table_writer,
)
from squeezefilm.quantities.model_error import excluded_terms
from squeezefilm.reynolds import Solution, node_cache
from squeezefilm.reynolds.periodic.launch import warm
from squeezefilm.studies.config import Config
from squeezefilm.studies.solver_settings import (
    SolverSettings,
    add_solver_arguments,
    device_of,
    solver_settings,
)
from squeezefilm.studies.study import scene_of, smoothed_scan_of

# Scenes whose results are held before they are written.
PIECE = 4096


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("scenes", nargs="?", metavar="SCENES.csv", help="table of scenes")
    parser.add_argument("--config", metavar="CONFIG.yaml", help=which_study.HELP)
    parser.add_argument("--output", metavar="FORCES.csv", help="table of forces to write")
    parser.add_argument("--timings", metavar="TIMINGS.csv", help="table of run times to write")
    add_solver_arguments(parser)
    parser.add_argument(
        "--device", help="instead of SQUEEZEFILM_DEVICE and the config's solver.device"
    )
    parser.add_argument("--chunk", metavar="I/N", help="only the I-th of N parts of the table")
    parser.add_argument(
        "--keep-going", action="store_true", help="exit with 0 although a scene has no force"
    )
    parser.add_argument(
        "--derivatives", action="store_true", help="of the force too, to each number of a scene"
    )
    parser.add_argument(
        "--budget",
        action="store_true",
        help="what the film equation leaves out, as columns of several points; one has it anyway",
    )
    parser.add_argument(
        "--outputs",
        type=lambda text: [name for name in text.split(",") if name],
        metavar="NAME,…",
        help=f"answers beside the force, of {', '.join(OUTPUTS)}, or all",
    )
    add_point_options(parser)


def run(options: argparse.Namespace) -> None:
    config = which_study.film_at(options.config)
    settings = solver_settings(
        config, tolerance=options.tolerance, method=options.method, outputs=options.outputs
    )
    points = points_in(options)
    if len(points.columns):
        _simulate_points(points, options, config, settings)
    else:
        _simulate_table(options, config, settings)


def _simulate_points(
    points: pd.DataFrame, options: argparse.Namespace, config: Config, settings: SolverSettings
) -> None:
    """One force with all that is known of it, or a table of several."""
    if options.scenes is not None:
        raise InputError("give either a table of scenes or --h0 and --hv, not both")
    if options.timings or options.chunk:
        raise InputError("--timings and --chunk are of a table of scenes")
    if not {"h0_m", "hv_m"} <= set(points):
        raise InputError("give both --h0 and --hv")
    scenes = [scene_of(point, config) for point in scene_points_of(points)]
    device = device_of(config, option=options.device)
    smoothed = smoothed_scan_of(config)
    if len(scenes) == 1 and not options.output:
        force = force_of(
            scenes[0],
            settings=settings,
            device=device,
            smoothed=smoothed,
            derivatives=options.derivatives,
        )
        print(force)
        forces = [force]
    else:
        forces = forces_of(
            scenes,
            settings=settings,
            device=device,
            smoothed=smoothed,
            derivatives=options.derivatives,
            budget=options.budget,
        )
        write_points(forces_table(points, forces), options.output)
        _print_warnings(smoothed)
    failures = [
        f"row {row}: {reason}" if len(forces) > 1 else reason
        for row, force in enumerate(forces, start=1)
        if (reason := _missing(force.solution))
    ]
    if len(forces) == 1 and not options.output and forces[0].validity != OK:
        failures.append(f"outside the limits of validity: {forces[0].validity}")
    if failures and not options.keep_going:
        raise RunError("; ".join(failures))


def _simulate_table(options: argparse.Namespace, config: Config, settings: SolverSettings) -> None:
    if options.scenes is None or options.output is None:
        raise InputError("give a table of scenes and --output, or points by --h0 and --hv")
    if options.budget:
        raise InputError("--budget is of points; `squeezefilm budget` is of a table of scenes")
    rows = all_rows if options.chunk is None else partial(chunk_rows, options.chunk)
    table = read_scenes(options.scenes, rows=rows)
    size = WITH_STATES if options.derivatives or settings.outputs else PIECE
    pieces = [table.iloc[first : first + size] for first in range(0, len(table), size)]
    for piece in pieces:
        _scenes(piece, config, path=options.scenes)  # refused before anything is solved
    with node_cache.one_build_at_a_time():
        device = device_of(config, option=options.device)
        warm(device, _scenes(pieces[0], config, path=options.scenes)[0])
    failures: list[str] = []
    good = 0
    seconds = 0.0
    timings = table_writer(options.timings) if options.timings else nullcontext(lambda rows: None)
    with (
        progress_bar(len(table), unit="scene", name=str(options.scenes)) as bar,
        table_writer(options.output) as write,
        timings as write_timings,
    ):
        for piece in pieces:
            scenes = _scenes(piece, config, path=options.scenes)
            start = time.perf_counter()
            solutions = solved(
                settings.resolved(scenes, device),
                settings=settings,
                device=device,
                derivatives=options.derivatives,
                report=bar.update,
            )
            wall = time.perf_counter() - start
            seconds += wall
            write(_forces(piece, solutions))
            shares = [wall * share for share in _work_shares(solutions)]
            write_timings(piece[["point_id"]].assign(solve_seconds=shares))
            good += sum(solution.status == "ok" for solution in solutions)
            failures += [
                f"point {scene.point_id}: {reason}"
                for scene, solution in zip(scenes, solutions, strict=True)
                if (reason := _missing(solution))
            ]
    for note in excluded_terms(
        _scenes(table.iloc[:1], config, path=options.scenes)[0], method=settings.method
    ):
        print(note, file=sys.stderr)
    smoothed = smoothed_scan_of(config)
    if smoothed is not None:
        print(
            "force_error_n is the solver's error alone: what the scan's noise adds, "
            "`squeezefilm profile` says",
            file=sys.stderr,
        )
    _print_warnings(smoothed)
    print(f"{good} of {len(table)} scenes solved in {seconds:.3f} s", file=sys.stderr)
    if failures and options.keep_going:
        print("\n".join(failures), file=sys.stderr)
    elif failures:
        what = "no force or no derivatives" if options.derivatives else "no force"
        what += ", or not all outputs," * bool(settings.outputs)
        raise RunError(f"{what} for " + "; ".join(failures))


def _print_warnings(smoothed: SmoothedScan | None) -> None:
    for warning in smoothed.warnings if smoothed else ():
        print(warning, file=sys.stderr)


def _missing(solution: Solution) -> str:
    """Why there is no force, or not what was asked for beside it; empty if all is there."""
    asked = (solution, solution.derivatives, solution.outputs)
    return next((each.status for each in asked if each and each.status != "ok"), "")


def _scenes(rows: pd.DataFrame, config: Config, *, path: str) -> list[Scene]:
    with naming(path):
        return [scene_of(point, config) for point in scene_points(rows)]


def _forces(rows: pd.DataFrame, solutions: Sequence[Solution]) -> pd.DataFrame:
    """The rows of a plan with what was solved for them."""
    columns = {
        name: [getattr(solution, name) for solution in solutions]
        for name in as_in(FORCE_COLUMNS, rows)
        if name not in rows.columns
    }
    more = pd.DataFrame([each.asked_columns for each in solutions], index=rows.index)
    table = rows.assign(**columns)[as_in(FORCE_COLUMNS, rows)]
    return table.assign(**{name: more[name] for name in map(str, more)})


def _work_shares(solutions: Sequence[Solution]) -> list[float]:
    """Each scene's share of the run time, by its floating-point operations; sums to 1."""
    total = sum(solution.work for solution in solutions)
    if total == 0:
        return [1 / len(solutions)] * len(solutions)
    return [solution.work / total for solution in solutions]


def chunk_rows(text: str, count: int) -> slice:
    """The rows of part I of N for ``I/N``: contiguous parts that differ by at most one row.

    Raises InputError when the text is not I/N with 1 ≤ I ≤ N ≤ count.
    """
    try:
        part, parts = (int(word) for word in text.split("/"))
    except ValueError:
        raise InputError(f"--chunk {text!r} must be two whole numbers like 2/4") from None
    if not 1 <= part <= parts <= count:
        raise InputError(f"--chunk {text!r}: 1 <= I <= N <= {count} (the rows of the table)")
    return slice(count * (part - 1) // parts, count * part // parts)
