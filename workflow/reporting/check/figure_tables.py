"""The tables that figures are drawn from, and the paper's tables, column by column."""

from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

import pandas as pd

from reporting.check.quantities import (
    Quantity,
    by_name,
    column_quantities,
    guarded,
    text_of,
)
from reporting.check.tolerances import (
    DERIVED,
    GIVEN,
    PLACE,
    Close,
    Closeness,
    Tolerance,
)
from squeezefilm.io.sources import read_columns

DATA, TABLES = "figure data", "tables"
GIVEN_COLUMNS = (
    "radius_mm",
    "angle_deg",
    "x_mm",
    "y_mm",
    "amplitude_ratio",
    "h0_um",
    "hv_um",
    "phi_r_mm",
    "phi_deg",
    "phi_r_limit_mm",
    "points",
    "band_percent",
    "h0_min_um",
    "h0_max_um",
    "hv_min_um",
    "hv_max_um",
    "phi_r_max_mm",
    "phi_max_deg",
)
OF_DESIGNS = (
    "fig09",
    "fig10",
    "fig11",
    "fig12",
    "fig13",
    "fig16",
    "error_map",
    "overview",
    "budget",
)
PLACES = ("epsilon", "h0_um", "hv_um", "phi_r_mm", "phi_deg")


def figure_quantities(results: Path, closeness: Closeness) -> Iterator[Quantity]:
    """Every figure's table but its note, which names the device."""
    folder = results / "figures"
    for name in by_name(folder, "*.csv"):
        path = folder / f"{name}.csv"
        yield from guarded(DATA, name, partial(_figure, name, path, closeness))


def _figure(name: str, path: Path, closeness: Closeness) -> Iterator[Quantity]:
    data = read_columns(path, columns=("note",)).drop(columns="note")
    steady = STEADY.get(name, lambda table: table)(data)
    yield from column_quantities(DATA, name, steady, tolerances=_of_figure(name, closeness, steady))


def _of_figure(name: str, closeness: Closeness, table: pd.DataFrame) -> dict[str, Tolerance]:
    """The tolerance of each column of numbers; any that is not listed is a derived one."""
    known: dict[str, Tolerance] = {
        column: DERIVED for column in table.columns if table[column].dtype == float
    }
    known |= {column: GIVEN for column in GIVEN_COLUMNS}
    if name in OF_DESIGNS:
        known |= {column: PLACE for column in PLACES}
    if name == "levitation":  # its gaps are found: where a force is as large as a load
        known["h0_um"] = closeness.force
    known |= {
        "force_n": closeness.model,
        "relative_error_percent": closeness.relative_error,
        "objective": closeness.parameters,
        "text": closeness.shown,
    }
    return {column: tolerance for column, tolerance in known.items() if column in table}


def _best_patterns(data: pd.DataFrame) -> pd.DataFrame:
    """One search that ended in each scaling's best pattern: which others do is chance."""
    best = data[data["pattern"] == "A"]
    first = best.groupby("scaling", sort=True)["search"].transform("min")
    once = best[best["search"] == first].drop(columns="search")
    return once.sort_values(["scaling", "h0_um", "hv_um"], kind="stable")


STEADY: dict[str, Callable[[pd.DataFrame], pd.DataFrame]] = {"fig09": _best_patterns}
"""What of a figure's table is the same on every machine, where that is not all of it."""


def table_quantities(results: Path, closeness: Closeness) -> Iterator[Quantity]:
    """The paper's tables: parameters loosely, errors as what they are."""
    for number in ("1", "2", "3"):
        path = results / "tables" / f"table{number}.csv"
        make = _ranges if number == "2" else _parameters
        yield from guarded(
            TABLES,
            f"table {number}",
            partial(make, f"table {number}", path, closeness),
        )


def _ranges(item: str, path: Path, closeness: Closeness) -> Iterator[Quantity]:
    del closeness
    table = read_columns(path, columns=("factor", "symbol", "unit", "minimum", "maximum"))
    yield from column_quantities(
        TABLES, item, table, tolerances={"minimum": GIVEN, "maximum": GIVEN}
    )


def _parameters(item: str, path: Path, closeness: Closeness) -> Iterator[Quantity]:
    table = read_columns(path, columns=("fit", "points", "quantity", "unit", "value"))
    yield from column_quantities(TABLES, item, table.drop(columns="value"), tolerances={})
    for fit, rows in table.groupby("fit", sort=False):
        errors = rows["unit"] == "%"
        percent = Close(absolute=100 * closeness.residual.absolute)
        for name, chosen, tolerance in (
            ("parameters", rows[~errors], closeness.parameters),
            ("global error", rows[errors], percent),
        ):
            cells = dict(zip(chosen["quantity"], map(text_of, chosen["value"]), strict=True))
            yield Quantity(TABLES, item, f"{name}, {fit}", cells, tolerance)
