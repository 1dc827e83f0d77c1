"""Declaration of commands, their common options, and tables on the screen.

The docstring of a command is its help.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from operator import itemgetter
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from squeezefilm.api.film import Film, factor_combinations
from squeezefilm.columns import error_column, error_columns
from squeezefilm.config.loading import load_film
from squeezefilm.config.notes import unit_notes
from squeezefilm.errors import InputError
from squeezefilm.film.validity import OK
from squeezefilm.formatting import ERROR_PERCENT_COLUMNS, json_text, result_lines_text
from squeezefilm.lazy import pd
from squeezefilm.reynolds.solver import METHODS
from squeezefilm.table_writer import checked_table_path, write_table
from squeezefilm.units import error_text, value_and_error_texts

PAPER_CONFIG_PATH = Path(__file__).parents[3] / "config" / "paper.yaml"
"""Where the library lies in a checkout; an installed one has no study of its own."""
HELP_OF_FACTOR = {
    "h0": "mean gap, e.g. 5um",
    "hv": "amplitude at the profile's maximum, e.g. 2um",
    "x": "pad's centre, e.g. -2mm; default: 0 m",
    "y": "the same along y",
    "phi_r": "instead of --x and --y: distance from the centre, e.g. 2.9mm",
    "phi": "and direction, e.g. 45deg",
}
SEVERAL_VALUES_HELP = (
    "each a value, several (5um,6um) or first:last:count (5:10:6um: 6 values), in every combination"
)

OptionAdder = Callable[[argparse.ArgumentParser], list[argparse.Action]]
CommandFunction = Callable[[argparse.Namespace], int | None]


def command(*options: OptionAdder) -> Callable[[CommandFunction], SimpleNamespace]:
    """Make a function a command that has some options."""
    return lambda run: SimpleNamespace(run=run, options=options)


def option(name: str, metavar: str | None = None, help: str = "", **how: Any) -> OptionAdder:
    """An option, or what stands without one."""
    return lambda parser: [parser.add_argument(name, metavar=metavar, help=help, **how)]


def table_output_option(name: str, metavar: str, help: str, **how: Any) -> OptionAdder:
    """An option for a table to write, whose name is checked before anything is solved."""
    return option(name, metavar, help, type=checked_table_path, **how)


def flag_option(name: str, help: str) -> OptionAdder:
    """An option without a value."""
    return lambda parser: [parser.add_argument(name, action="store_true", help=help)]


def factor_options(*without: str, many: bool = True) -> OptionAdder:
    """Options for the factors, but for those in ``without``; ``many`` values of each."""

    def add_factor_options(parser: argparse.ArgumentParser) -> list[argparse.Action]:
        title = "points" if many else "the point"
        group = parser.add_argument_group(title, SEVERAL_VALUES_HELP if many else None)
        return [
            group.add_argument(f"--{name.replace('_', '-')}", metavar="QUANTITY", help=text)
            for name, text in HELP_OF_FACTOR.items()
            if name not in without
        ]

    return add_factor_options


CONFIG_OPTION = option("--config", "CONFIG.yaml", "the study; default: a checkout's paper.yaml")
STUDY_OPTION = option("--config", "CONFIG.yaml", "the study", required=True)
DEVICE_OPTION = option(
    "--device", help="instead of SQUEEZEFILM_DEVICE and the config's solver.device"
)
TOLERANCE_OPTION = option(
    "--tolerance", help="instead of the config's solver.tolerance", type=float
)
METHOD_OPTION = option("--method", help="instead of the config's solver.method", choices=METHODS)
JSON_OPTION = flag_option(
    "--json", "print one point as a JSON object; keys: docs/reference/columns.md"
)
SOLVER_OPTIONS = (CONFIG_OPTION, TOLERANCE_OPTION, METHOD_OPTION, DEVICE_OPTION, JSON_OPTION)
FILM_OPTIONS = (CONFIG_OPTION, DEVICE_OPTION, JSON_OPTION)
FIT_ARGUMENT = option("fit", "FIT.json", "the fitted model")
FORCES_ARGUMENT = option("forces", "FORCES.csv", "simulated forces")
SCENES_ARGUMENT = option("scenes", "SCENES.csv", "table of scenes", nargs="?")
OUTPUT_OPTION = table_output_option(
    "--output", "TABLE.csv", "table to write; without it the table is shown"
)
RESULT_OPTIONS = (OUTPUT_OPTION, JSON_OPTION)


def film_of_options(options: argparse.Namespace, outputs: Sequence[str] | None = ()) -> Film:
    """The film of a study, of which no section is checked that film and solver do not need.

    Raises InputError where none is named and there is none, and as ``load_film`` does.
    """
    if options.config is None and not PAPER_CONFIG_PATH.exists():
        raise InputError("give a study by --config CONFIG.yaml")
    given = {name: getattr(options, name, None) for name in ("tolerance", "method", "device")}
    config = load_film(options.config or PAPER_CONFIG_PATH)
    print_notes(unit_notes(config))
    return Film(config, given | {"outputs": outputs})


def print_notes(notes: Iterable[str]) -> None:
    """Print notes on a study beside the results."""
    for note in notes:
        print(f"note: {note}", file=sys.stderr)


def points_of_options(options: argparse.Namespace, times: int = 1) -> dict[str, tuple[float, ...]]:
    """Every combination of the options' values, a column for each factor given.

    Args:
        times: how many results each of these points has.

    Raises InputError for a value without its unit, both forms of a position, or too many points.
    """
    columns = factor_combinations(
        option="--{}", **{name: getattr(options, name, None) for name in HELP_OF_FACTOR}
    )
    check_json_option(options, times * len(next(iter(columns.values()), ())))
    return columns


def points_unless_scenes_table(options: argparse.Namespace) -> dict[str, tuple[float, ...]]:
    """Return the points that options give, none where they name a table of scenes.

    Raises InputError as ``points_of_options`` does, for both or neither, and without h0 or hv.
    """
    points = points_of_options(options)
    if points if options.scenes else not {"h0_m", "hv_m"} <= set(points):
        raise InputError("give a table of scenes, or points by --h0 and --hv")
    return points


def study_name_column(options: argparse.Namespace) -> dict[str, str]:
    """The column of a table for ``--output`` that names the study; none for one that is printed."""
    return {"study": Path(options.config or PAPER_CONFIG_PATH).stem} if options.output else {}


def check_json_option(options: argparse.Namespace, count: int) -> None:
    """Raise InputError where ``--json`` is given for other than one point, or with a table."""
    if getattr(options, "json", False) and (count > 1 or options.output):
        raise InputError("--json prints one point: give a single one, and no --output")


def result_text(row: Mapping[Any, Any], options: argparse.Namespace) -> str:
    """Return one result as lines for people, or as a JSON object for scripts."""
    return json_text(row) if getattr(options, "json", False) else result_lines_text(row)


def write_or_print_rows(table: pd.DataFrame, options: argparse.Namespace, **about: str) -> None:
    """Write a table to ``--output``, or print it: one row in lines, or as a JSON object.

    What is printed has no more digits than its error leaves.

    Args:
        about: what is known of all rows.
    """
    check_json_option(options, len(table))
    if not options.output and len(table) == 1:
        print(result_text(table.to_dict("records")[0] | about, options))
    elif not options.output:
        print_table(table, **about)
    else:
        write_table(table, options.output)
        if about:
            noted = int(table.get("note", pd.Series(dtype=str)).fillna("").ne("").sum())
            note = f"in the table, of {noted} of {len(table)} rows" * bool(noted)
            print(result_lines_text({**about, "note": note}))


def print_table(table: pd.DataFrame, **about: str) -> None:
    """Print a table for people, and below it what is known of all rows and notes on some.

    Columns without content are not shown, and errors stand beside their values; rows have numbers
    where a note needs them.
    """
    table = table.set_index(pd.RangeIndex(1, len(table) + 1))
    texts, notes = _without_notes(table)
    for name in map(str, texts):
        errors = error_columns(name, table)
        for error in errors:
            pairs = [
                value_and_error_texts(*value_and_error)
                for value_and_error in zip(table[name], table[error], strict=True)
            ]
            texts[error] = [text for _, text in pairs]
        if errors:
            largest = table[errors].max(axis=1)
            texts[name] = [
                value_and_error_texts(*value_and_error)[0]
                for value_and_error in zip(table[name], largest, strict=True)
            ]
        if (error := error_column(name)) in errors:
            texts[name] += (" ± " + texts.pop(error)).where(texts[name] != "", "")
        if name in ERROR_PERCENT_COLUMNS:
            texts[name] = table[name].map(error_text, na_action="ignore")
    how: dict[str, Any] = {"na_rep": "", "float_format": lambda value: f"{value:.4g}"}
    print(texts.to_string(index=bool(notes), **how))
    if about or notes:
        print(result_lines_text({**about, "note": notes}))


def _without_notes(table: pd.DataFrame) -> tuple[pd.DataFrame, list[str]]:
    """Return the columns with content, their reasons as references, and a note for each reason."""
    texts = table.drop(columns=[name for name in table if table[name].eq("").all()])
    rows_of_reason: dict[str, list[Any]] = {}
    for name in (each for each in ("status", "validity", "note") if each in texts):
        for row, reason in table[name].dropna().items():
            if reason not in ("", OK):
                rows_of_reason.setdefault(reason, []).append(row)
                texts.loc[row, name] = "see note"
    return texts.drop(columns="note", errors="ignore"), [
        f"row{'s' * (len(rows) > 1)} {', '.join(map(str, rows))}: {reason}"
        for reason, rows in sorted(rows_of_reason.items(), key=itemgetter(1))
    ]
