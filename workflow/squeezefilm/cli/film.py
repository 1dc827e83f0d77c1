"""Commands that solve the film equation: forces, modelling errors, pressure fields."""

from __future__ import annotations

import argparse
import sys

from squeezefilm.api.film import POINTS_PER_SIDE_RANGE, TIME_POINTS_RANGE, Film
from squeezefilm.api.forces import (
    budget_table,
    forces_table,
    missing_quantity_reason,
    preview_table,
    simulate_table,
)
from squeezefilm.cli.options import (
    CONFIG_OPTION,
    FILM_OPTIONS,
    HELP_OF_FACTOR,
    OUTPUT_OPTION,
    SCENES_ARGUMENT,
    SOLVER_OPTIONS,
    check_json_option,
    command,
    factor_options,
    film_of_options,
    flag_option,
    option,
    points_unless_scenes_table,
    result_text,
    study_name_column,
    table_output_option,
    write_or_print_rows,
)
from squeezefilm.errors import InputError, RunError, prefix_errors
from squeezefilm.files import atomic_file
from squeezefilm.film.validity import OK
from squeezefilm.lazy import pd
from squeezefilm.quantities.model_error import budget_row
from squeezefilm.solution import MODELLING_ERROR_COLUMNS, OUTPUT_COLUMNS
from squeezefilm.table_writer import write_table
from squeezefilm.tables import read_scenes


@command(
    SCENES_ARGUMENT,
    table_output_option("--output", "FORCES.csv", "table of forces to write"),
    *SOLVER_OPTIONS,
    flag_option("--dry-run", "show how scenes would be solved"),
    flag_option("--derivatives", "derivatives of the force too, by each quantity of a scene"),
    flag_option(
        "--budget",
        "the modelling error too, as columns of several points, its parts in --json; of a table of "
        "scenes: squeezefilm error-budget",
    ),
    option("--outputs", "NAME,…", f"further quantities, of {', '.join(OUTPUT_COLUMNS)}, or all"),
    factor_options(),
)
def simulate(options: argparse.Namespace) -> None:
    """Mean squeeze-film forces by solving the Reynolds equation, each with an error estimate.

      squeezefilm simulate SCENES.csv --config CONFIG.yaml --output FORCES.csv
      squeezefilm simulate --h0 5um --hv 2.2um --x -2mm
      squeezefilm simulate --h0 5um --hv 0.5:2.5:9um --output CURVE.csv

    The first takes a table of scenes, CSV or Parquet, such as

      h0 [µm], hv [µm], x [mm]
      5, 2.2, 0
      5, 2.2, -2
      6, 2.2, 0

    Its columns are a gap, an amplitude and, where they are known, a position (x, y or phi_r, phi)
    and point_id; results of other commands beside them are ignored.

    The others take quantities: a number with its unit, several with commas, or evenly spaced ones
    as first:last:count: 0.5:2.5:9um are 9 values from 0.5 to 2.5 µm. Between commas each
    number has its unit; every combination is a point. One point is shown with its force, errors and
    numbers; several make a table.

    `force_error_n` is the numerical error; with a scan `measurement_noise_n` is what its noise adds
    (95 %), and each quantity beside the force has a column `…_measurement_noise_…`. With
    `--budget`, `modelling_error_lower_percent` and `…_upper_percent` bound the effects that the
    film equation neglects.

    `validity` is `ok`, or the limits of validity of the film equation that a scene exceeds, with
    what that means. One point outside them is shown too, with exit status 1; rows of a table end
    with 0.

    Tolerance means |error| <= tolerance * |force| + round-off floor, the floor being 1e-14 of the
    largest gauge pressure times the pad's area. The exit status is 1 when a scene has no force; all
    rows are written nevertheless, each with its status. A table of scenes has no column of a scan's
    noise; `squeezefilm profile` estimates what the noise of a measured profile adds.

    `--derivatives` adds those of the force by h0, hv, the pad's position (x, y) and each property
    of the gas, with their errors, by films beside each scene; `derivatives_status` states why
    there are none. `--outputs thrust,power` adds these quantities instead of the study's `outputs`,
    each with its error, from the periodic state; `outputs_status` states which are missing and
    why. `harmonics` has film stiffness and damping, `static_stiffness` is −dF/dh0.

    `--dry-run` computes no force, but decides terms that are `auto`: it shows each scene's numbers,
    method, domain, terms, absent terms and why, first grid and expected cost, or with --output
    writes them, a row for each scene.
    """
    outputs = None if options.outputs is None else [*filter(None, options.outputs.split(","))]
    film = film_of_options(options, outputs)
    points, path = points_unless_scenes_table(options), options.scenes
    if options.dry_run:
        with prefix_errors(path):
            scenes = film.scenes(read_scenes(path) if path else points)
        table, rows = preview_table(scenes, film)
        check_json_option(options, len(table))
        if options.output is not None:
            write_table(table, options.output)
        print(*(result_text(row, options) for row in rows), sep="\n\n")
    elif path is None:
        _simulate_given_points(points, options, film)
    else:
        _simulate_scenes_table(options, film)


def _simulate_given_points(
    points: dict[str, tuple[float, ...]], options: argparse.Namespace, film: Film
) -> None:
    """One force with all that is known of it, or a table of several."""
    scenes = film.scenes(points)
    alone = len(scenes) == 1 and not options.output
    budget = alone or options.budget
    forces = film.solved(scenes, derivatives=options.derivatives, budget=budget)
    if alone:
        row = forces[0].row
        if options.json and not options.budget:
            parts = {name for name in budget_row(forces[0].budget) if name.endswith("_percent")}
            row = {
                name: row[name]
                for name in row
                if name in MODELLING_ERROR_COLUMNS or name not in parts
            }
        print(result_text(row, options))
    else:
        table = forces_table(pd.DataFrame(points), forces, whole=bool(options.output))
        write_or_print_rows(table.assign(**study_name_column(options)), options)
        for warning in film.scan.warnings if film.scan else ():
            print(warning, file=sys.stderr)
    failures = [
        f"row {row}: {reason}" if len(forces) > 1 else reason
        for row, force in enumerate(forces, start=1)
        if (reason := missing_quantity_reason(force.solution))
    ]
    if alone and forces[0].validity != OK:
        failures.append(f"outside the limits of validity: {forces[0].validity}")
    if failures:
        raise RunError("; ".join(failures))


def _simulate_scenes_table(options: argparse.Namespace, film: Film) -> None:
    if options.output is None:
        raise InputError("a table of scenes needs --output FORCES.csv")
    check_json_option(options, count=1)
    if options.budget:
        raise InputError(
            "--budget is of points; `squeezefilm error-budget` is of a table of scenes"
        )
    failures, incomplete = simulate_table(
        options.scenes, film, output=options.output, derivatives=options.derivatives
    )
    if film.scan is not None:
        alone = "errors are numerical: what the scan's noise adds, `squeezefilm profile` says"
        print(alone, *film.scan.warnings, sep="\n", file=sys.stderr)
    if missing := failures + incomplete:
        what = "no force or no derivatives" if options.derivatives else "no force"
        what += ", or not all outputs," * bool(film.solver().outputs)
        raise RunError(f"{what} for " + "; ".join(missing))


@command(SCENES_ARGUMENT, OUTPUT_OPTION, *FILM_OPTIONS, factor_options())
def error_budget(options: argparse.Namespace) -> None:
    """Estimate the modelling error of forces: inertia, thermal effects, slip, edge loss, sliding.

      squeezefilm error-budget SCENES.csv --config CONFIG.yaml --output BUDGET.csv
      squeezefilm error-budget --h0 5um --hv 2.2um --x -2mm

    A row for each scene. `inertia_percent`, `thermal_percent`, `slip_percent`, `edge_loss_percent`
    (for its coefficient C = 1; `edge_loss_upper_percent` for 1.54) and `bearing_percent` are
    changes of the mean force: the difference of two solved forces, with and without the effect.

    `modelling_error_lower_percent` and `…_upper_percent` bound all effects that the force neglects
    together, with C from 1 to 1.54; `included_effects` names the others. `higher_orders_percent` is
    by how much they differ from the sum of each alone. `unknown_effects` names those that could not
    be solved for; `status` says why there are none.
    `depth_averaged_percent` is the estimated error of inertia and thermal effects as averages over
    the gap; `validity` is `ok`, or the limits of validity that a scene exceeds.
    """
    points, film = points_unless_scenes_table(options), film_of_options(options)
    scenes = pd.DataFrame(points) if points else read_scenes(options.scenes)
    table = budget_table(scenes, film)
    if not options.output and len(table) > 1:
        table = table.loc[:, (table != 0).any()]  # without effects that these films do not have
    write_or_print_rows(table, options)


@command(
    CONFIG_OPTION,
    option("--output", "FIELD", ".csv or .nc, to write", required=True),
    option(
        "--points-per-side",
        None,
        "points along x and along y, {} to {}".format(*POINTS_PER_SIDE_RANGE),
        type=int,
        default=41,
    ),
    option(
        "--time-points",
        help="time points per period, even, {} to {}".format(*TIME_POINTS_RANGE),
        type=int,
        default=32,
    ),
    factor_options(many=False),
)
def pressure(options: argparse.Namespace) -> None:
    """The pressure under a pad over one period, as a file.

      squeezefilm pressure --h0 5um --hv 2.2um --output field.csv
      squeezefilm pressure --h0 5um --hv 2.2um --x 1mm --output field.nc --config CONFIG.yaml

    A CSV table has a row for each time and point: phase_deg, time_s, x_m, y_m (from the pad's
    centre, along its own axes), gauge_pressure_pa, gap_m. A name that ends in .nc makes a NetCDF
    file, with units and what was solved among its attributes. Both need xarray: the extra `fields`.
    """
    if not options.output.endswith((".csv", ".nc")):
        raise InputError(f"--output {options.output}: name a file that ends in .csv or .nc")
    given = {name: getattr(options, name) for name in HELP_OF_FACTOR}
    if not (given["h0"] and given["hv"]):
        raise InputError("give --h0 and --hv")
    film = film_of_options(options)
    field = film.pressure(
        **given, points_per_side=options.points_per_side, time_points=options.time_points
    )
    if options.output.endswith(".nc"):
        with atomic_file(options.output) as path:
            field.to_netcdf(path, engine="scipy")
        return
    names = {"phase": "phase_deg", "time": "time_s", "x": "x_m", "y": "y_m"}
    names |= {"gauge_pressure": "gauge_pressure_pa", "gap": "gap_m"}
    table = field.to_dataframe().reset_index().dropna()
    write_table(table.rename(columns=names)[list(names.values())], options.output)
