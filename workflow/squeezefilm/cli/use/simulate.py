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
`--dry-run` solves nothing: it shows each scene's numbers, method, domain, terms, what it does not
need and why, first grid and expected cost, or with --output writes them, a row for each scene.
"""

import argparse
import sys
from typing import Any

import pandas as pd

from squeezefilm.api.film import Film
from squeezefilm.api.forces import force_of, forces_of, forces_table
from squeezefilm.api.preview import preview_table, preview_text
from squeezefilm.api.simulation import missing_of, scenes_of_table, simulate_table
from squeezefilm.cli.options import add_options, add_point_options, film_at, points_in, write_points
from squeezefilm.errors import InputError, RunError
from squeezefilm.film.validity import OK
from squeezefilm.solution import OUTPUTS
from squeezefilm.studies.solver_settings import SolverSettings, device_of, solver_settings
from squeezefilm.tables import read_scenes, write_table


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("scenes", nargs="?", metavar="SCENES.csv", help="table of scenes")
    parser.add_argument("--output", metavar="FORCES.csv", help="table of forces to write")
    add_options(parser, "config", "tolerance", "method", "device")
    parser.add_argument(
        "--dry-run", action="store_true", help="show how scenes would be solved, and solve nothing"
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
    film = film_at(options.config)
    settings = solver_settings(
        film.config, tolerance=options.tolerance, method=options.method, outputs=options.outputs
    )
    points = points_in(options)
    if (options.scenes is None) == points.columns.empty:
        raise InputError("give a table of scenes, or points by --h0 and --hv")
    if options.scenes is None and not {"h0_m", "hv_m"} <= set(points):
        raise InputError("give both --h0 and --hv")
    if options.dry_run:
        _preview(points, options, film, settings)
    elif options.scenes is None:
        _simulate_points(points, options, film, settings)
    else:
        _simulate_table(options, film, settings)


def _preview(
    points: pd.DataFrame, options: argparse.Namespace, film: Film, settings: SolverSettings
) -> None:
    """How scenes would be solved, in words or as a table."""
    if options.scenes is None:
        scenes = film.scenes(points)
    else:
        rows = read_scenes(options.scenes)
        scenes = scenes_of_table(rows, config=film.config, path=options.scenes)
    device = device_of(film.config, option=options.device)
    table = preview_table(scenes, settings=settings, device=device)
    if options.output is not None:
        write_table(table, options.output)
    print(preview_text(table, tolerance=settings.tolerance))


def _simulate_points(
    points: pd.DataFrame, options: argparse.Namespace, film: Film, settings: SolverSettings
) -> None:
    """One force with all that is known of it, or a table of several."""
    scenes, smoothed = film.scenes(points), film.scan
    device = device_of(film.config, option=options.device)
    how: dict[str, Any] = {"settings": settings, "device": device, "smoothed": smoothed}
    alone = len(scenes) == 1 and not options.output
    if alone:
        forces = [force_of(scenes[0], derivatives=options.derivatives, **how)]
        print(forces[0])
    else:
        forces = forces_of(scenes, derivatives=options.derivatives, budget=options.budget, **how)
        write_points(forces_table(points, forces), options.output)
        for warning in smoothed.warnings if smoothed else ():
            print(warning, file=sys.stderr)
    failures = [
        f"row {row}: {reason}" if len(forces) > 1 else reason
        for row, force in enumerate(forces, start=1)
        if (reason := missing_of(force.solution))
    ]
    if alone and forces[0].validity != OK:
        failures.append(f"outside the limits of validity: {forces[0].validity}")
    if failures:
        raise RunError("; ".join(failures))


def _simulate_table(options: argparse.Namespace, film: Film, settings: SolverSettings) -> None:
    if options.output is None:
        raise InputError("a table of scenes needs --output")
    if options.budget:
        raise InputError("--budget is of points; `squeezefilm budget` is of a table of scenes")
    failures, incomplete = simulate_table(
        options.scenes,
        film.config,
        settings=settings,
        output=options.output,
        device=options.device,
        derivatives=options.derivatives,
    )
    if film.scan is not None:
        alone = (
            "force_error_n is the solver's error alone: what the scan's noise adds, "
            "`squeezefilm profile` says"
        )
        print(alone, *film.scan.warnings, sep="\n", file=sys.stderr)
    if missing := failures + incomplete:
        what = "no force or no derivatives" if options.derivatives else "no force"
        what += ", or not all outputs," * bool(settings.outputs)
        raise RunError(f"{what} for " + "; ".join(missing))
