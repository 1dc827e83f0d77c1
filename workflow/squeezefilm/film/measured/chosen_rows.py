"""The rows of one measurement among those that a scan's table has of each position."""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

from squeezefilm.errors import InputError, prefix_errors
from squeezefilm.film.measured.cells import distinct_values_text, normalise_cells
from squeezefilm.film.measured.columns import FREQUENCY_UNITS_HZ, ScanColumn
from squeezefilm.film.measured.scan import (
    MAX_MODE_DISTANCE_FRACTION,
    MIN_SCAN_POINTS,
    SAME_POSITION_DISTANCE_M,
    nearest_spectral_line,
)
from squeezefilm.lazy import pd
from squeezefilm.text_tables.cells import parse_numbers

# Of all nodes of a body: the share of a face's, of others, and how far off they are, over the face.
MIN_FACE_FRACTION, MIN_OFF_FRACTION, MIN_OFF_FACE_HEIGHT_FRACTION = 0.1, 0.1, 0.05
DIRECTION_PATTERN = re.compile("[-+]?[xyz][-+]?")
# So many rows at a place that differ in time are a time series.
MIN_TIME_SERIES_ROWS = 8
TIME_SERIES_REMEDY = "export amplitude and phase at the actuator's frequency"


def rows_of_requested_measurement(
    cells: pd.DataFrame, others: Sequence[ScanColumn], rows: str
) -> tuple[pd.DataFrame, list[ScanColumn], list[str]]:
    """The rows of one measurement, as in ``read_scan``, the columns that they do not set, notes."""
    free, notes = list(others), list[str]()
    for condition in filter(None, map(str.strip, rows.split(";"))):
        name, _, value = (part.strip() for part in condition.rpartition("="))
        names = {other.name.lower(): other for other in others}
        with prefix_errors(f"actuator.profile.rows: {condition!r}"):
            if name.lower() not in names:
                known = ", ".join(repr(other.name) for other in others)
                raise InputError(f"needs COLUMN = VALUE, the column one of {known}")
            column = names[name.lower()]
            values = normalise_cells(cells[column.column_index])
            cells = cells[values == normalise_cells(pd.Series([value]))[0]]
            are_directions = values.str.fullmatch(DIRECTION_PATTERN).all()
            if are_directions and not cells.empty and "z" not in value.lower():
                notes.append(
                    f"{condition!r} is a motion in the plane of x and y; that along the "
                    "surface's normal squeezes a film"
                )
            if cells.empty:
                raise InputError(f"no row has this value; {distinct_values_text(values)}")
        free = [other for other in free if other is not column]
    return cells, free, notes


def reject_points_off_surface(
    cells: pd.DataFrame, others: Sequence[ScanColumn], columns: dict[str, ScanColumn]
) -> None:
    """Reject all nodes of a body, many at one height, others far from it; and a surface in x-z."""
    for column in others:
        if column.quantity != "height" or "x" not in columns or cells.empty:
            continue
        x_m, z_m = (
            parse_numbers(cells[axis.column_index]) * (axis.size or columns["x"].size or 1.0)
            for axis in (columns["x"], column)
        )
        flat = [columns[name] for name in ("x", "y") if name in columns]
        flat = [axis for axis in flat if cells[axis.column_index].nunique() == 1]
        if len(flat) == 1 and z_m.nunique() > MIN_SCAN_POINTS:
            raise InputError(
                f"{flat[0].name!r} is {cells[flat[0].column_index].iloc[0]} everywhere, and "
                f"{column.name!r} is not: the surface lies across it; swap the two names in the "
                "header (the motion is that along the surface's normal)"
            )
        heights = normalise_cells(cells[column.column_index])
        common = heights.mode().iloc[-1]
        at_face = heights == common
        apart = abs(z_m - z_m[at_face].iloc[0])
        if (
            at_face.mean() > MIN_FACE_FRACTION
            and (apart > MIN_OFF_FACE_HEIGHT_FRACTION * np.ptp(x_m)).mean() > MIN_OFF_FRACTION
        ):
            raise InputError(
                f"column {column.name!r} has points at several heights, {z_m.min() * 1e3:.4g} to "
                f"{z_m.max() * 1e3:.4g} mm; take those of the surface by actuator.profile.rows: "
                f"{column.name} = {common} or another height; or leave the column out"
            )


def one_row_per_position(
    table: pd.DataFrame,
    cells: pd.DataFrame,
    others: Sequence[ScanColumn],
    *,
    frequency_hz: float,
    are_chosen: bool,
) -> tuple[pd.DataFrame, list[str]]:
    """The rows of one measurement at each place, and notes on which these are.

    Args:
        table: quantities, whose places may stand repeatedly.
        cells, others: all cells of the same rows, and the columns that are no such quantities.
        frequency_hz: as in ``read_scan``.
        are_chosen: whether the study says which rows these are.

    Raises:
        InputError: for a time series, for rows at another frequency, and for several measurements
            at a place, with the column that tells them apart.
    """
    notes = []
    for column in others:
        if column.quantity == "frequency":
            table, chosen = _rows_at_frequency(table, cells, column, frequency_hz, are_chosen)
            notes += chosen
    position = _position_keys(table)
    if not position.duplicated().any():
        return table, notes
    for column in others:
        written = cells.loc[table.index, column.column_index]
        values = normalise_cells(written)
        differing = values.groupby(position).nunique()[position[position.duplicated()].unique()]
        if differing.median() < 2:
            continue
        recurs = _recurs_at_positions(table, values)
        if column.quantity == "time" and (
            recurs or len(values) >= MIN_TIME_SERIES_ROWS * position.nunique()
        ):
            raise InputError(
                f"column {column.name!r} has several instants at each place: a time series is no "
                f"shape; {TIME_SERIES_REMEDY}"
            )
        if recurs:
            axis = "; or call it x, y or phi, with its unit, if it is the other coordinate"
            axis *= len({"x", "y", "r", "phi"} & {*table}) < 2
            remedy = _remedy_of_values(values, written, column.name)
            raise InputError(
                f"places have several rows each, which column {column.name!r} tells apart: "
                f"{distinct_values_text(values)}; {remedy}{axis}"
            )
    return table, notes


def _remedy_of_values(values: pd.Series, written: pd.Series, name: str) -> str:
    """A remedy that takes the rows of one value: of directions that along z, the normal."""
    if not values.str.fullmatch(DIRECTION_PATTERN).all():
        return f"take one by actuator.profile.rows: {name} = {values.iloc[0]}"
    along_normal = written[values.str.contains("z")]
    if along_normal.empty:
        return "none is along z, the surface's normal; export that motion"
    return (
        "take that along the surface's normal by actuator.profile.rows: "
        f"{name} = {along_normal.iloc[0].strip()}"
    )


def _rows_at_frequency(
    table: pd.DataFrame,
    cells: pd.DataFrame,
    column: ScanColumn,
    frequency_hz: float,
    are_chosen: bool,
) -> tuple[pd.DataFrame, list[str]]:
    """The rows of the frequency nearest to the actuator's, and a note on it.

    A column without a unit is in that one in which a frequency is near. A single frequency, or that
    of chosen rows, may be of a model's mode, which need not be where the actuator's is.
    """
    values = parse_numbers(cells.loc[table.index, column.column_index])
    lines = values.dropna().unique()
    recurs = _recurs_at_positions(table, values)
    if not len(lines) or not (column.size or (recurs and not column.unit)):
        return table, []
    if not recurs:
        lines = np.median(lines, keepdims=True)
    sizes = [column.size] if column.size else list(FREQUENCY_UNITS_HZ.values())
    nearest = [nearest_spectral_line(size * lines, frequency_hz) for size in sizes]
    line_hz, far = next((line for line in nearest if not line[1]), nearest[0])
    is_near_mode = abs(line_hz / frequency_hz - 1) < MAX_MODE_DISTANCE_FRACTION
    if far and not (is_near_mode and (are_chosen or len(lines) == 1)):
        unit = "" if column.size else "; write its unit, or leave it out if it is no frequency"
        raise InputError(f"column {column.name!r}: {far}{unit}")
    if not recurs:
        return table, []
    size = sizes[nearest.index((line_hz, far))]
    return table[size * values == line_hz], [f"rows at {line_hz:.7g} Hz in {column.name!r}"]


def _position_keys(table: pd.DataFrame) -> pd.Series:
    """A name of each row's place, which rows at the same place share."""
    r, phi = (table.get(name, pd.Series(0.0, table.index)) for name in ("r", "phi"))
    x = table.get("x", r * np.cos(phi))
    y = table.get("y", r * np.sin(phi))
    steps = pd.DataFrame({"x": x, "y": y}).div(SAME_POSITION_DISTANCE_M).round()
    return steps.groupby(["x", "y"], sort=False).ngroup()


def _recurs_at_positions(table: pd.DataFrame, values: pd.Series) -> bool:
    """Tell whether values stand each at many places: those of a setting, no measurement."""
    return 0 < values.nunique() <= 2 * len(values) / _position_keys(table).nunique()
