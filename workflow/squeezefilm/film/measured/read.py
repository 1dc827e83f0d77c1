"""A scanning vibrometer's file as it was exported, read as points and complex amplitudes.

A table of text is in UTF-8, UTF-16 or Latin-1, its cells separated by commas, semicolons, tabs or
blanks, with a decimal point, or a comma where it does not separate cells. A row stands for a point;
lines before the one that names columns, and lines that begin with #, are ignored. The header names
quantities, each with its unit (``x_mm``, ``X [mm]``, ``X/mm``, ``x position mm``):

    x_mm, y_mm          or  r_mm  or  r_mm, phi_deg     place, from the actuator's centre
    amplitude_um        or  real_um, imaginary_um       peak amplitude, or with its sign
    phase_deg           or  sign                        optional

Velocities (mm/s) are divided by the angular frequency. Of several measurements at each
place one is taken: that at the actuator's frequency, or the rows that are asked for. A row whose
amplitude is empty or ``nan`` is a point that was not measured: it is excluded from profile and
noise, and a note names its line.

Universal files (.uff, .unv) are read by pyuff: a function (data set 58) for each point, of which
the line at the actuator's frequency is taken; points are those of data set 15 or 2411, in the units
of data set 164.
"""

from __future__ import annotations

import csv
import io
import math
import re
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from squeezefilm.errors import InputError, naming, needing, refuse
from squeezefilm.lazy import pd
from squeezefilm.units import sizes

LENGTHS_M = sizes("m")
SPEEDS_M_PER_S = {f"{name}/s": size for name, size in LENGTHS_M.items()}
MOTIONS = LENGTHS_M | SPEEDS_M_PER_S
ANGLES_RAD = {name: math.radians(degrees) for name, degrees in sizes("deg").items()}
MOTION_NAMES = ("displacement", "disp", "displ", "velocity", "vel")
# Each with its units, in small letters, and their sizes, and its names.
QUANTITIES = {
    "x": (LENGTHS_M, ("x",)),
    "y": (LENGTHS_M, ("y",)),
    "r": (LENGTHS_M, ("r", "radius")),
    "phi": (ANGLES_RAD, ("phi", "theta", "angle")),
    "amplitude": (MOTIONS, ("amplitude", "magnitude", "amp", "ampl", "mag", *MOTION_NAMES)),
    "real": (MOTIONS, ("real", "re")),
    "imaginary": (MOTIONS, ("imaginary", "imag", "im")),
    "phase": (ANGLES_RAD, ("phase", "phase angle")),
    "sign": ({"": 1.0}, ("sign",)),
}
OTHERS = {
    "frequency": (
        {name.lower(): size for name, size in sizes("Hz").items()},
        ("frequency", "freq"),
    ),
    "time": (sizes("s"), ("time",)),
}
"""Quantities by which rows of a place may differ, likewise."""
KNOWN = QUANTITIES | OTHERS
NAMES = {name: quantity for quantity, (_, names) in KNOWN.items() for name in names}
# Words beside the one that names the quantity.
BESIDE = {"position", "pos", "coordinate", "coord", "part", "value", *MOTION_NAMES}
FORM = "columns such as x_mm, y_mm, amplitude_um, phase_deg or r_mm, amplitude_um"

BLANKS = " "
SEPARATORS = ("\t", ";", ",", BLANKS)
# Among which the line that names columns is sought, and by how many quantities it is known.
FIRST_LINES, FEWEST_NAMED = 100, 2
COMMENT = re.compile(r"\s*#[#\s]*")
MISSING = ("", "nan", "na", "n/a", "-")
# In the file's unit. Writers of universal files, pyuff too, put 1.8e308 for infinity.
LARGEST = 1e9
FEWEST_POINTS, PLACES_NAMED = 8, 6
# So many rows at a place that differ in time are a time series; places closer than this are one.
INSTANTS, SAME_PLACE_M = 8, 1e-6

UNIVERSAL = (".uff", ".unv", ".uf", ".bunv")
# Data sets; types of abscissa and ordinate; types of functions; the direction z.
NODES, UNITS, FUNCTION = (15, 2411), 164, 58
FREQUENCY, DISPLACEMENT, VELOCITY, ACCELERATION = 18, 8, 11, 12
TIME_OR_POWER = (1, 2, 3, 9)
POWER, COHERENCES = (2, 3, 9), (6, 21, 26)
# By which power of the angular frequency a motion is larger than a displacement.
MOTION_PER_M = {DISPLACEMENT: 0, VELOCITY: 1, ACCELERATION: 2}
NORMAL = 3
# From the frequency, in distances between lines; of a file with one line as a share of it.
FARTHEST_LINE, FARTHEST_SHARE = 0.6, 0.01


@dataclass(frozen=True)
class Scan:
    """Measured points in metres and the complex amplitude there, each of shape (points,).

    Without angles it is ``radial``: ``x_m`` is the distance from the centre and ``y_m`` zero.
    ``lines`` are the rows' places in the file and ``missing`` counts points without an amplitude.
    ``signed`` tells whether phase, sign or an amplitude below zero tells on which side of a node a
    point is. ``notes`` say how the file was read.
    """

    path: Path
    x_m: np.ndarray
    y_m: np.ndarray
    amplitude_m: np.ndarray
    lines: np.ndarray
    missing: int
    signed: bool
    notes: tuple[str, ...] = ()
    radial: bool = False


def read_scan(path: Path | str, *, frequency_hz: float | None = None, rows: str = "") -> Scan:
    """Read a vibrometer's file.

    Args:
        path: a table of text, or a universal file by its ending.
        frequency_hz: of the vibration, for velocities and spectra; without it they are invalid.
        rows: ``COLUMN = VALUE`` of the rows that are taken from a table with several measurements,
            with semicolons between several conditions.

    Raises:
        InputError: naming the file and the row or column that is wrong, and what is allowed.
    """
    path = Path(path)
    if not path.exists():
        raise InputError(f"{path}: there is no such scan")
    with naming(path):
        universal = path.suffix.lower() in UNIVERSAL
        if universal and rows:
            raise InputError("actuator.profile.rows is of tables; a universal file has no columns")
        scan = _universal(path, frequency_hz) if universal else _table(path, frequency_hz, rows)
    points = len(scan.x_m)
    refuse(
        path,
        {
            f"{points} measured points ({scan.missing} missing); a profile needs at least "
            f"{FEWEST_POINTS}": points < FEWEST_POINTS,
            "every amplitude is zero: there is no profile": not np.any(scan.amplitude_m),
        },
    )
    return scan


def _lacking(places: Sequence[int], *, what: str) -> list[str]:
    """A note that names the points without an amplitude, if there are any."""
    named = ", ".join(map(str, places[:PLACES_NAMED])) + ", …" * (len(places) > PLACES_NAMED)
    many = "s" * (len(places) > 1)
    return [
        f"{len(places)} point{many} without an amplitude, excluded from profile and noise "
        f"({what}{many} {named})"
    ] * bool(len(places))


def _angular_frequency(frequency_hz: float | None) -> float:
    if frequency_hz is None:
        raise InputError("velocities and spectra need the actuator's frequency")
    return 2 * math.pi * frequency_hz


class Column(NamedTuple):
    """A quantity, the unit it is in ("" if none is named), its place in a row, and its name.

    ``size`` is the unit's in SI units and radians; None of one that the quantity has not.
    """

    quantity: str
    unit: str
    size: float | None
    place: int
    name: str


def column_of(name: str, place: int = 0) -> Column | None:
    """The column that a cell of a header names; None for one that a scan does not have."""
    name = name.strip("\"' \t")
    breaks = re.finditer(r"[\s_/,\[(]+", name)
    ends = [(name[: at.start()], name[at.end() :].strip(" ])").lower()) for at in breaks]
    # The likeliest first. Decibels are known, to be named in a message: the file does not tell what
    # 0 dB is.
    known = [each for each in ends if each[1] in MOTIONS | ANGLES_RAD or "db" in each[1]]
    for words, unit in (*known, (name, ""), *ends[-1:]):
        parts = [part for part in re.split(r"[\s_\-.:]+", words.lower()) if part]
        core = [part for part in parts if part not in BESIDE] or parts[:1]
        if quantity := NAMES.get(" ".join(core)):
            return Column(quantity, unit, KNOWN[quantity][0].get(unit), place, name)
    return None


def _named(header: Sequence[str]) -> list[Column]:
    """The columns that a header names; ``X centre (mm)`` is x where nothing else is."""
    columns = [column for at, name in enumerate(header) if (column := column_of(name, at))]
    known = {column.quantity for column in columns if column.size}
    for at, name in enumerate(header):
        quantity, *words = re.split(r"[\s_\[(]+", name.strip("\"' \t").lower().rstrip(" ])"))
        if quantity in {"x", "y"} - known and words and words[-1] in LENGTHS_M:
            columns.append(Column(quantity, words[-1], LENGTHS_M[words[-1]], at, name))
    return columns


def _columns(header: Sequence[str], wanted: Collection[str]) -> dict[str, Column]:
    """The columns of some quantities, by these, each with its unit.

    Raises InputError for a quantity without a unit, or that stands twice.
    """
    named = _named(header)
    usable = {column.quantity for column in named if column.size}
    if "imaginary" in usable and "phase" not in usable:
        wanted = {*wanted} - {"amplitude"}
    elif "amplitude" in usable:
        wanted = {*wanted} - {"real", "imaginary"}
    columns: dict[str, Column] = {}
    for column in sorted(named, key=lambda each: each.size is None):
        if column.quantity not in wanted:
            continue
        first = columns.setdefault(column.quantity, column)
        units = ", ".join(f"{column.quantity}_{unit}" for unit in QUANTITIES[column.quantity][0])
        if not first.size:
            hint = "; decibels are not supported" * column.unit.startswith("db")
            raise InputError(f"column {column.name!r} needs a unit, one of {units}{hint}")
        if column.size and first is not column:
            raise InputError(
                f"the column {column.quantity!r} stands twice: {first.name!r} and "
                f"{column.name!r}; leave one of them out"
            )
    return columns


def read_points(
    path: Path,
    wanted: Collection[str] = tuple(QUANTITIES),
    *,
    what: str,
    form: str,
    frequency_hz: float | None = None,
    rows: str | None = None,
) -> tuple[pd.DataFrame, int, pd.Index, list[str]]:
    """Points of a table of text, by their lines in the file.

    Args:
        wanted: quantities.
        what, form: what the table is and what it needs, for messages.
        frequency_hz: by which velocities become displacements.
        rows: of which measurement, as in ``read_scan``; None where a place may stand repeatedly.

    Returns: the quantities, in SI units and radians; the line of the header; the lines of points
    that lack an amplitude, which are excluded; and notes on how the file was read.

    Raises:
        InputError: naming the line or column that is wrong.
    """
    header, line, cells, notes = _cells(path, what=what, form=form)
    with naming(f"line {line}"):
        columns = _columns(header, wanted)
        motion = [columns[name] for name in ("amplitude", "real", "imaginary") if name in columns]
        if len({column.unit in SPEEDS_M_PER_S for column in motion}) > 1:
            raise InputError("real and imaginary part must be both displacements or velocities")
    taken = {column.place for column in columns.values()}
    if ignored := [repr(name) for at, name in enumerate(header) if at not in taken]:
        notes.append(f"ignored columns: {', '.join(ignored)}")
    amplitudes = cells[[column.place for column in motion]]
    lacking = cells.index[amplitudes.map(str.lower).isin(MISSING).any(axis=1)]
    cells = cells.drop(lacking)
    table = pd.DataFrame({name: _numbers(cells, column) for name, column in columns.items()})
    if rows is not None:
        others = [
            column_of(name, at) or Column("", "", None, at, name) for at, name in enumerate(header)
        ]
        others = [column for column in others if column.place not in taken]
        table, chosen = _one_measurement(table, cells, others, rows=rows, frequency_hz=frequency_hz)
        notes += chosen
    for column in motion:
        if column.unit in SPEEDS_M_PER_S:
            table[column.quantity] /= _angular_frequency(frequency_hz)
            notes.append(f"{column.name!r} divided by the angular frequency")
    return table, line, lacking, [*notes, *_lacking(lacking.tolist(), what="line")]


def _one_measurement(
    table: pd.DataFrame,
    cells: pd.DataFrame,
    others: Sequence[Column],
    *,
    rows: str,
    frequency_hz: float | None,
) -> tuple[pd.DataFrame, list[str]]:
    """The rows of one measurement at each place, and notes on which these are.

    Args:
        table: quantities, whose places may stand repeatedly.
        cells, others: all cells of the same rows, and the columns that are no such quantities.
        rows, frequency_hz: as in ``read_scan``.

    Raises:
        InputError: for rows that are not there, a time series, and for several measurements at a
            place, with the column that tells them apart.
    """
    notes, asked = [], set()
    for condition in filter(None, map(str.strip, rows.split(";"))):
        name, _, value = (part.strip() for part in condition.rpartition("="))
        names = {other.name.lower(): other for other in others}
        with naming(f"actuator.profile.rows: {condition!r}"):
            if name.lower() not in names:
                known = ", ".join(repr(other.name) for other in others)
                raise InputError(f"needs COLUMN = VALUE, the column one of {known}")
            column = names[name.lower()]
            values = _plain(cells.loc[table.index, column.place])
            table = table[values == _plain(pd.Series([value]))[0]]
            if table.empty:
                raise InputError(f"no row has this value; {_values_in(values)}")
        asked.add(column.place)
    for column in others:
        if column.quantity == "frequency" and column.size and column.place not in asked:
            values_hz = _number(cells.loc[table.index, column.place]) * column.size
            if not _recurs(table, values_hz):
                continue
            if frequency_hz is None:
                raise InputError(f"the rows of {column.name!r} need the actuator's frequency")
            line_hz, far = _nearest_line(values_hz.unique(), frequency_hz)
            if far:
                raise InputError(f"column {column.name!r}: {far}")
            table = table[values_hz == line_hz]
            notes.append(f"rows at {line_hz:.7g} Hz in {column.name!r}")
    place = _places_of(table)
    if not place.duplicated().any():
        return table, notes
    for column in others:
        values = _plain(cells.loc[table.index, column.place])
        differing = values.groupby(place).nunique()[place[place.duplicated()].unique()]
        if differing.median() < 2:
            continue
        recurs = _recurs(table, values)
        if column.quantity == "time" and (recurs or len(values) >= INSTANTS * place.nunique()):
            raise InputError(
                f"column {column.name!r} has several instants at each place: a time series is no "
                "shape; export amplitude and phase at the actuator's frequency"
            )
        if recurs:
            raise InputError(
                f"places have several rows each, which column {column.name!r} tells apart: "
                f"{_values_in(values)}; take one by actuator.profile.rows: {column.name} = "
                f"{values.iloc[0]}"
            )
    return table, notes


def _number(cells: pd.Series) -> pd.Series:
    """Numbers of cells, with decimal points or commas; NaN of others."""
    return pd.to_numeric(cells.str.replace(",", "."), errors="coerce").astype(float)


def _plain(cells: pd.Series) -> pd.Series:
    """Cells in small letters, numbers in one spelling."""
    numbers = _number(cells)
    return cells.str.strip().str.lower().where(numbers.isna(), numbers.map("{:.9g}".format))


def _values_in(values: pd.Series) -> str:
    """The values of a column in words, the first of many."""
    counts = values.value_counts(sort=False)
    named = [f"{value} ({count} rows)" for value, count in counts.items()]
    return "it has " + ", ".join(named[:PLACES_NAMED]) + ", …" * (len(named) > PLACES_NAMED)


def _places_of(table: pd.DataFrame) -> pd.Series:
    """A name of each row's place, which rows at the same place share."""
    r, phi = (table.get(name, pd.Series(0.0, table.index)) for name in ("r", "phi"))
    x = table.get("x", r * np.cos(phi))
    y = table.get("y", r * np.sin(phi))
    steps = pd.DataFrame({"x": x, "y": y}).div(SAME_PLACE_M).round()
    return steps.groupby(["x", "y"], sort=False).ngroup()


def _recurs(table: pd.DataFrame, values: pd.Series) -> bool:
    """Tell whether values stand each at many places: those of a setting, no measurement."""
    return 0 < values.nunique() <= 2 * len(values) / _places_of(table).nunique()


def _table(path: Path, frequency_hz: float | None, rows: str) -> Scan:
    """The scan in a table of text."""
    table, line, lacking, notes = read_points(
        path, what="scan", form=FORM, frequency_hz=frequency_hz, rows=rows
    )
    known = set(table)
    place = known & {"x", "y", "r", "phi"}
    columns = "; ".join([f"the columns are {', '.join(map(str, table))}", *notes])
    refuse(
        f"line {line}",
        {
            f"the place of a point is x and y, or r, or r and phi; {columns}": place
            not in ({"x", "y"}, {"r", "phi"}, {"r"}),
            f"column 'amplitude_um' is missing; a scan has {FORM}; {columns}": not known
            & {"amplitude", "real", "imaginary"},
            "real and imaginary part go together": len(known & {"real", "imaginary"}) == 1,
            "give sign or phase, not both": {"sign", "phase"} <= known,
        },
    )
    whole = table.reindex(columns=list(QUANTITIES)).fillna({"sign": 1.0}).fillna(0.0)
    x, y, r, phi, size, real, imaginary, phase, sign = whole.to_numpy().T
    directed = bool(known & {"phase", "sign"})
    wrong = {
        "r must not be negative": r < 0,
        "sign must be 1 or -1": sign**2 != 1,
        "amplitude must not be negative where phase or sign tells its direction": (size < 0)
        & directed,
    }
    for problem, where in wrong.items():
        for number in table.index[where][:1]:
            raise InputError(f"line {number}: {problem}")
    amplitude = (size * np.exp(1j * phase) + real + 1j * imaginary) * sign
    z = x + 1j * y + r * np.exp(1j * phi)
    signed = directed or "imaginary" in known or bool(np.any(amplitude.real < 0))
    lines, missing, radial = table.index.to_numpy(), len(lacking), place == {"r"}
    return Scan(path, z.real, z.imag, amplitude, lines, missing, signed, tuple(notes), radial)


def _cells(path: Path, *, what: str, form: str) -> tuple[list[str], int, pd.DataFrame, list[str]]:
    """The header's cells and line, the other cells by their line in the file, and notes."""
    try:
        text, encoding = _decoded(path.read_bytes())
    except OSError as error:
        raise InputError(f"the {what} cannot be read: {error}") from None
    lines = io.StringIO(text, newline=None).read().split("\n")
    index, separator = _header(lines, what=what, form=form)
    header = _split(COMMENT.sub("", lines[index], count=1), separator)
    rows: dict[int, list[str]] = {}
    for number, line in enumerate(lines[index + 1 :], index + 2):
        if not line.strip(" \t,;") or COMMENT.match(line):
            continue
        rows[number] = cells = _split(line, separator)
        if len(cells) != len(header):
            hint = "; decimal commas need another separator, such as semicolons"
            hint *= separator == "," and len(cells) > len(header)
            raise InputError(
                f"line {number}: {len(cells)} cells where the header has {len(header)}{hint}"
            )
    above = sum(bool(line.strip()) and not COMMENT.match(line) for line in lines[:index])
    notes = [f"read as {encoding}"] * (encoding != "utf-8")
    notes += [f"{above} lines before the header ignored"] * bool(above)
    table = pd.DataFrame(list(rows.values()), list(rows), range(len(header)), dtype=object)
    return header, index + 1, table, notes


def _split(line: str, separator: str) -> list[str]:
    """A line's cells."""
    if separator == BLANKS:
        line = " ".join(line.split())
    try:
        return [cell.strip() for cell in next(csv.reader([line], delimiter=separator))]
    except csv.Error as error:
        raise InputError(f"{line[:60]!r} cannot be read: {error}") from None


def _decoded(content: bytes) -> tuple[str, str]:
    """A text and its encoding: by the byte order mark, by zeros between letters, or as it fits."""
    start, half = content[:1000], min(len(content), 1000) / 4
    little = start.startswith(b"\xff\xfe") or start[1::2].count(0) > half
    if little or start.startswith(b"\xfe\xff") or start[::2].count(0) > half:
        encoding = "utf-16-le" if little else "utf-16-be"
        return content.decode(encoding, errors="replace").removeprefix("\ufeff"), encoding
    try:
        return content.decode("utf-8-sig"), "utf-8"
    except UnicodeDecodeError:
        return content.decode("latin-1"), "latin-1"


def _header(lines: Sequence[str], *, what: str, form: str) -> tuple[int, str]:
    """The place of the line that names columns, which may be a comment, and its separator."""
    filled = [index for index, line in enumerate(lines) if line.strip(" \t,;")]
    plain = [index for index in filled if not COMMENT.match(lines[index])]
    if not plain:
        raise InputError(f"the {what} is empty; it needs {form}")
    comments = [index for index in filled if index < plain[0]]
    for index in (*plain[:FIRST_LINES], *comments[:FIRST_LINES]):
        line, named = COMMENT.sub("", lines[index], count=1), {}
        below = next((lines[row] for row in plain if row > index), "")
        for separator in SEPARATORS:
            cells = _split(line, separator)
            count = len({column.quantity for column in _named(cells)})
            if count >= FEWEST_NAMED:
                # Headers have words with blanks and commas: the row below tells the separator.
                named[separator] = len(cells) == len(_split(below, separator)), count
        if named:
            return index, max(named, key=named.__getitem__)
    first = lines[plain[0]].strip()[:60]
    raise InputError(f"line {plain[0] + 1}: no header names the columns: {first!r}; give {form}")


def _numbers(table: pd.DataFrame, column: Column) -> pd.Series:
    """A column's values in SI units; raises InputError naming the line of one that is none."""
    cells, name = table[column.place], column.quantity
    comma, point = (cells.str.contains(sign, regex=False) for sign in ",.")
    if comma.any() and point.any():
        line, cell = next(cells[point].items())
        raise InputError(
            f"line {line}: {name} has a point in {cell!r}, and a comma in other rows; one of them "
            "must be the decimal sign, and nothing stands between thousands"
        )
    values = _number(cells)
    for line, cell in cells[~(values.abs() <= LARGEST)][:1].items():
        raise InputError(f"line {line}: {name} is {cell!r}, not a finite number")
    return values * (column.size or 1.0)


def _universal(path: Path, frequency_hz: float | None) -> Scan:
    """The scan in a universal file; a point's line is its function's number."""
    with needing("scans", what="a universal file (or export the scan as text)"):
        import pyuff
    omega = _angular_frequency(frequency_hz)
    try:
        file = pyuff.UFF(str(path))
        kinds_of_sets = [int(kind) for kind in file.get_set_types()]
    except Exception as error:  # whatever a damaged file makes of it
        raise InputError(f"not a universal file that pyuff reads: {error}") from None
    sets: list[dict[str, Any]] = []
    for number, kind in enumerate(kinds_of_sets):
        if kind in (*NODES, UNITS, FUNCTION):
            try:
                sets.append(file.read_sets(number))
            except Exception as error:
                raise InputError(f"set {number + 1} (data set {kind}): {error}") from None
    length = next((float(each["length"]) for each in sets if each.get("type") == UNITS), 1.0)
    places = {
        int(node): complex(x, y) / length
        for each in sets
        if each.get("type") in NODES
        for node, x, y in zip(each["node_nums"], each["x"], each["y"], strict=True)
    }
    every = [each for each in sets if each.get("type") == FUNCTION]
    functions = [each for each in every if abs(int(each["rsp_dir"])) == NORMAL] or every
    functions, aside = _of_motion(functions, places)
    nodes = [int(each["rsp_node"]) for each in functions]
    kinds = {int(each.get("ordinate_spec_data_type", 0)) for each in functions}
    refuse(
        "universal file",
        {
            "no functions (data set 58) are in it": not every,
            f"no function is a shape; {'; '.join(aside)}": not functions,
            "a node has several functions; export one, or that along z": len(set(nodes))
            < len(nodes),
            "the functions are not all displacements (type 8), velocities (11) or accelerations "
            f"(12) but of type {', '.join(map(str, sorted(kinds)))}": kinds
            not in [{kind} for kind in MOTION_PER_M],
        },
    )
    rows = [_line_at(each, omega / (2 * math.pi)) for each in functions]
    measured, lines_hz = (np.array(column) for column in zip(*rows, strict=True))
    numbers, seen = 1 + np.arange(len(nodes)), np.isfinite(measured)
    amplitude = measured[seen].astype(complex) / omega ** MOTION_PER_M[min(kinds)]
    if kinds == {ACCELERATION}:
        amplitude = -amplitude
    place = np.array([places[node] for node in nodes])[seen]
    signed = np.iscomplexobj(measured) or bool(np.any(amplitude.real < 0))
    notes = (
        *aside,
        f"read at {lines_hz.min():.7g} Hz",
        *_lacking(numbers[~seen].tolist(), what="function"),
    )
    missing = int(np.sum(~seen))
    return Scan(path, place.real, place.imag, amplitude, numbers[seen], missing, signed, notes)


def _of_motion(
    functions: Sequence[dict[str, Any]], places: Collection[int]
) -> tuple[list[dict[str, Any]], list[str]]:
    """The functions that may be a shape, and a note for each kind of the others."""
    kept, aside = [], dict.fromkeys(("coherences", "power spectra", "functions without a place"), 0)
    for function in functions:
        kind = int(function.get("func_type", 0))
        if kind in COHERENCES:
            aside["coherences"] += 1
        elif kind in POWER and len(functions) > len(places):
            aside["power spectra"] += 1
        elif int(function["rsp_node"]) not in places:
            aside["functions without a place"] += 1
        else:
            kept.append(function)
    return kept, [f"{count} {name} ignored" for name, count in aside.items() if count]


def _line_at(function: dict[str, Any], frequency_hz: float) -> tuple[complex | float, float]:
    """The amplitude at the line nearest to the frequency, and that line.

    It is NaN where the function is not finite there, or zero at all lines: nothing was measured.
    """
    lines, data = np.asarray(function["x"], dtype=float), np.asarray(function["data"])
    line_hz, far = _nearest_line(lines, frequency_hz)
    nearest = int(np.argmax(lines == line_hz))
    kind, over = (int(function.get(key, 0)) for key in ("func_type", "abscissa_spec_data_type"))
    refuse(
        f"node {int(function['rsp_node'])}",
        {
            "a function of time or a power spectrum; export amplitudes or frequency responses": kind
            in TIME_OR_POWER
            or over != FREQUENCY,
            far: far,
        },
    )
    seen = np.any(data) and np.abs(data[nearest]) <= LARGEST
    sign = math.copysign(1.0, int(function["rsp_dir"])) if seen else np.nan
    return sign * data[nearest], line_hz


def _nearest_line(lines_hz: np.ndarray, frequency_hz: float) -> tuple[float, str]:
    """The line of a spectrum nearest to a frequency, and why it is too far from it, if it is."""
    line_hz = float(lines_hz[np.argmin(np.abs(lines_hz - frequency_hz))])
    steps_hz = np.diff(np.sort(lines_hz))
    farthest = FARTHEST_LINE * steps_hz.max(initial=0.0) or FARTHEST_SHARE * frequency_hz
    far = (
        f"its lines go from {lines_hz.min():.7g} to {lines_hz.max():.7g} Hz, and the actuator "
        f"vibrates at {frequency_hz:.7g} Hz (actuator.frequency)"
    )
    return line_hz, far if abs(line_hz - frequency_hz) > farthest else ""
