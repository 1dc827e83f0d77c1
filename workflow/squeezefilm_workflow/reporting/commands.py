"""Commands for a finished study: figures, the recommended model, the check."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from importlib.metadata import entry_points
from pathlib import Path
from typing import TYPE_CHECKING

from squeezefilm.cli.options import (
    OUTPUT_OPTION,
    command,
    option,
    table_output_option,
    write_or_print_rows,
)
from squeezefilm.errors import InputError, RunError, append_remedy, prefix_errors
from squeezefilm.film.positions import CARTESIAN_COLUMNS
from squeezefilm.lazy import pd
from squeezefilm.table_writer import write_table
from squeezefilm.tables import FACTOR_COLUMNS, read_columns
from squeezefilm_workflow.reporting.results import Results

if TYPE_CHECKING:
    from matplotlib.figure import Figure

RESULTS_ARGUMENT = option("results", "RESULTS", "the study's results", type=Path)
STUDY_OPTION = option("--config", "CONFIG.yaml", "the study, if not RESULTS' own")
FIGURE_FILES_OPTION = option("--output", "FILE", required=True, nargs="+", type=Path)
RECOMMENDATION_COLUMNS_SHOWN = (
    *("space", "model", "validation_error_percent", "simulations", "worst_error_percent"),
    *(*FACTOR_COLUMNS, *CARTESIAN_COLUMNS),
    *("force_n", "hv_error_95_m", "note"),
)
PICTURE_SUFFIXES = (".png", ".svg", ".pdf")

# matplotlib is imported where something is drawn or pictures are compared.


@command(
    option("figure", "FIGURE", "such as fig05 or models/two_factor_errors, or TABLE.csv"),
    option("results", "RESULTS", "the study's results, or PROFILE.csv", type=Path, nargs="?"),
    STUDY_OPTION,
    FIGURE_FILES_OPTION,
)
def plot(options: argparse.Namespace) -> None:
    """Draw a figure of a finished study, or its table, or a table that a command wrote.

      squeezefilm plot fig08 results/paper --output fig08.pdf
      squeezefilm simulate --h0 5um --hv 0.5:2.5:9um --output curve.csv
      squeezefilm plot curve.csv --output curve.png
      squeezefilm plot profile PROFILE.csv --output profile.png

    Drawn are forces by `simulate` or `predict`, gaps by `levitate`, amplitudes by `amplitude-for`,
    and the tables of `response`: over the factor with most values, or as a map over x and y. The
    format follows the name: .png, .svg or .pdf; .csv is the table that a numbered figure of the
    paper draws. The same results give the same file, byte for byte.
    """
    tables = (".csv", ".parquet")
    if options.figure.endswith(tables):
        from squeezefilm_workflow.reporting.figures.curve import curve_figure

        return _save_figure_of_table(
            options.figure,
            columns=("h0_m", "hv_m"),
            optional=FACTOR_COLUMNS,
            draw=curve_figure,
            output=options.output,
        )
    if options.figure == "profile" and options.results and options.results.suffix in tables:
        from squeezefilm_workflow.reporting.figures.maps import (
            REQUIRED_PROFILE_COLUMNS,
            draw_profile_table,
        )

        return _save_figure_of_table(
            options.results,
            columns=REQUIRED_PROFILE_COLUMNS,
            draw=draw_profile_table,
            output=options.output,
        )
    check_formats(options.output, (*PICTURE_SUFFIXES, ".csv"))
    if options.results is None:
        raise InputError(f"{options.figure}: give the folder of the study's results too")
    from squeezefilm_workflow.reporting.figures import FIGURES, draw_and_save

    figures = dict(FIGURES)
    for point in entry_points(group="squeezefilm.figures"):
        figures |= point.load()
    place = options.figure if "/" in options.figure else f"figures/{options.figure}"
    if place not in figures:
        known = ", ".join(sorted(name.removeprefix("figures/") for name in figures))
        raise InputError(f"there is no figure {options.figure!r}; the figures are {known}")
    draw_and_save(
        figures[place], Results.of_folder(options.results, options.config), options.output
    )


def _save_figure_of_table(
    path: Path | str,
    *,
    columns: Sequence[str],
    optional: Sequence[str] = (),
    draw: Callable[[pd.DataFrame], Figure],
    output: Sequence[Path],
) -> None:
    from squeezefilm_workflow.reporting.figures import style

    check_formats(output, PICTURE_SUFFIXES)
    table = read_columns(path, columns=columns, optional=optional)
    with style.figure_style(), prefix_errors(path):
        style.save_figure(draw(table), output)


@command(option("field", "FIELD.nc", "by `squeezefilm pressure`"), FIGURE_FILES_OPTION)
def plot_pressure(options: argparse.Namespace) -> None:
    """Pictures of a pressure field over the period, and an animation of it.

      squeezefilm pressure --h0 5um --hv 2.2um --x 1mm --output field.nc
      squeezefilm plot-pressure field.nc --output sheet.png film.gif

    A name that ends in .gif makes the animation, one in .png, .svg or .pdf a sheet: the
    gauge pressure at eight phases and in the mean, and its mean over the pad beside the gap there.
    The same field gives the same files. Both need xarray: the extra `fields`.
    """
    check_formats(options.output, (*PICTURE_SUFFIXES, ".gif"))
    from squeezefilm_workflow.reporting.pressure_pictures import draw_pressure_field

    draw_pressure_field(options.field, options.output)


def check_formats(files: Sequence[Path], formats: Sequence[str]) -> None:
    """Raise InputError for a file whose name ends in no format that can be drawn."""
    for path in files:
        if path.suffix not in formats:
            raise InputError(f"{path}: a picture's name ends in {', '.join(formats)}")


@command(RESULTS_ARGUMENT, STUDY_OPTION, OUTPUT_OPTION)
def recommend(options: argparse.Namespace) -> None:
    """Recommend a model, pad centred and anywhere, with amplitudes for the target force.

      squeezefilm recommend results/plate --output TABLE.csv

    Recommended is the model with the fewest parameters of those whose global error,
    `validation_error_percent`, is within 5 % of the least on the half of the validation sample that
    ranks; its page, models/*.html, has its largest error there. `worst_error_percent` is the
    largest at any of the `simulations`, fitted or not: those of the validation samples and of the
    plan `four_factor`, which has the positions.

    The amplitude gives the study's target force at its gap (section `extrapolation`), its errors
    are those of `squeezefilm amplitude-for`. The study's candidates must be compared (`snakemake
    models`). The screen shows those of the plan's positions with the least and the largest
    amplitude; between them it may be larger. --output has all positions, and the two errors as
    fractions, `validation_error` and `worst_error`. The fit's file is for `squeezefilm
    amplitude-for`. The exit status is 1 where no amplitude gives the target force.
    """
    from squeezefilm_workflow.reporting.models import (
        missing_amplitude_text,
        recommendation_table,
        rows_of_extreme_amplitudes,
    )

    results = Results.of_folder(options.results, options.config)
    with append_remedy("run `snakemake models --configfile CONFIG.yaml`"):
        table = recommendation_table(results)
    if table["model"].isna().all():
        raise RunError(f"{options.results}: no model can be judged; models/*.html say why")
    reason = missing_amplitude_text(table)
    if options.output is None:
        # On the screen the least and the largest amplitude of each space, and no wide columns.
        for name in ("validation_error", "worst_error"):
            table[f"{name}_percent"] = 100 * table[name]
        table = rows_of_extreme_amplitudes(table)
        table = table[[name for name in RECOMMENDATION_COLUMNS_SHOWN if name in table]]
    write_or_print_rows(table, options)
    for best in table.drop_duplicates("space").to_dict("records"):
        print(f"fit of {best['space']}: {results.candidate_fit_file(best['space'], best['model'])}")
    if reason:
        raise RunError(f"{options.results}: {reason}")


@command(
    RESULTS_ARGUMENT,
    STUDY_OPTION,
    option("--reference", "FOLDER", "made by `squeezefilm reference`", required=True, type=Path),
    table_output_option("--output", "CHECK.csv", "the table, a row each quantity"),
)
def check(options: argparse.Namespace) -> int:
    """Compare the results of a finished study with a small reference.

      squeezefilm check results/paper --reference tests/reference/paper

    Compared are all columns of the tables of simulations, modelling errors, response, levitation,
    validation, figures and the paper, but for grids and iterations; claims, fits, designs,
    pictures and the verdicts on stiff films: each as closely as the study's tolerance allows. Of
    long tables, 100 rows and least, mean and largest value of a column are. Shown are each
    part's worst quantity and every quantity that failed; all of them are in the table.
    The exit status is 1 when anything failed.
    """
    from squeezefilm_workflow.reporting.check import FAILED, check_table, terminal_text

    table = check_table(Results.of_folder(options.results, options.config), options.reference)
    if options.output:
        write_table(table, options.output)
    print(terminal_text(table, options.results))
    return int((table["verdict"] == FAILED).any())


@command(
    RESULTS_ARGUMENT,
    STUDY_OPTION,
    option("--output", "FOLDER", "to write", required=True, type=Path),
)
def reference(options: argparse.Namespace) -> None:
    """Make the small reference that `squeezefilm check` compares a study with, from its results.

      squeezefilm reference results/paper --output tests/reference/paper

    An old reference in the folder is replaced: `git diff` shows what changed, cell by cell.
    """
    from squeezefilm_workflow.reporting.check import study_quantities, write_reference

    quantities = study_quantities(
        Results.of_folder(options.results, options.config), options.output
    )
    write_reference(quantities, options.results, options.output)
    print(f"{options.output}: written")
