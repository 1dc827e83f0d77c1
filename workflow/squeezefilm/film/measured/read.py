"""A scanning vibrometer's file as it was exported, read as points and complex amplitudes.

A table of text is in UTF-8, UTF-16 or Latin-1, its cells separated by commas, semicolons, tabs or
blanks, with a decimal point, or a comma where it does not separate cells. A row stands for a point;
lines before the one that names columns, and lines that begin with #, are ignored. The header names
quantities, each with its unit (``x_mm``, ``X [mm]``, ``X/mm``, ``x position mm``):

    x_mm, y_mm          or  r_mm  or  r_mm, phi_deg     place, from the actuator's centre
    amplitude_um        or  real_um, imaginary_um       peak amplitude, or with a sign of its own
    phase_deg           or  sign                        optional

Velocities (mm/s) are divided by the angular frequency. A row whose amplitude is empty or ``nan`` is
a point that was not measured: it is excluded from profile and noise, and a note names its line.

Universal files (.uff, .unv) are read by pyuff: a function (data set 58) for each point, of which
the line at the actuator's frequency is taken; points are those of data set 15 or 2411, in the units
of data set 164.
"""

from __future__ import annotations

import csv
import io
import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from squeezefilm.errors import InputError, naming, needing, refuse
from squeezefilm.units import sizes

LENGTHS_M = sizes("m")
SPEEDS_M_PER_S = {f"{name}/s": size for name, size in LENGTHS_M.items()}
MOTIONS = LENGTHS_M | SPEEDS_M_PER_S
ANGLES_RAD = {name: math.radians(degrees) for name, degrees in sizes("deg").items()}
QUANTITIES: Mapping[str, tuple[Mapping[str, float], tuple[str, ...]]] = {
    "x": (LENGTHS_M, ("x",)),
    "y": (LENGTHS_M, ("y",)),
    "r": (LENGTHS_M, ("r", "radius")),
    "phi": (ANGLES_RAD, ("phi", "theta", "angle")),
    "amplitude": (MOTIONS, ("amplitude", "magnitude", "amp", "mag", "displacement", "velocity")),
    "real": (MOTIONS, ("real", "re")),
    "imaginary": (MOTIONS, ("imaginary", "imag", "im")),
    "phase": (ANGLES_RAD, ("phase", "phase angle")),
    "sign": ({"": 1.0}, ("sign",)),
}
"""Each with its units and their sizes, and its names."""
NAMES = {name: quantity for quantity, (_, names) in QUANTITIES.items() for name in names}
KNOWN_UNITS = {unit.lower() for unit in (*MOTIONS, *ANGLES_RAD)}
# Words beside the one that names the quantity.
BESIDE = {"position", "pos", "coordinate", "coord", "displacement", "velocity", "part", "value"}
IN_BRACKETS = re.compile(r"(?P<words>.*?)[\s_]*[\[(]\s*(?P<unit>[^\])]*?)\s*[\])]")
FORM = "columns such as x_mm, y_mm, amplitude_um, phase_deg or r_mm, amplitude_um"

SEPARATORS = ("\t", ";", ",", None)
"""None: blanks, as many as there are."""
FIRST_LINES, FEWEST_NAMED = 100, 2
"""Among which the one that names columns is sought, and by how many quantities it is known."""
COMMENT = re.compile(r"\s*#[#\s]*")
MISSING = ("", "nan", "na", "n/a", "-")
LARGEST = 1e9
"""In the file's unit. Writers of universal files, pyuff too, put 1.8e308 for infinity."""
FEWEST_POINTS, MOST_POINTS = 8, 3_000_000
MOST_MISSING = 0.5
"""Share of a scan's points that may lack an amplitude."""
PLACES_NAMED = 6

UNIVERSAL = (".uff", ".unv", ".uf", ".bunv")
# Data sets; types of abscissa and ordinate; types of functions; the direction z.
NODES, UNITS, FUNCTION = (15, 2411), 164, 58
FREQUENCY, DISPLACEMENT, VELOCITY = 18, 8, 11
TIME_OR_POWER = (1, 2, 3, 9)
NORMAL = 3
FARTHEST_LINE, FARTHEST_SHARE = 0.6, 0.01
"""From the frequency, in distances between lines; of a file with one line as a share of it."""


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


def read_scan(path: Path | str, *, frequency_hz: float | None = None) -> Scan:
    """Read a vibrometer's file.

    Args:
        path: a table of text, or a universal file by its ending.
        frequency_hz: of the vibration, for velocities and spectra; without it they are refused.

    Raises:
        InputError: naming the file and the row or column that is wrong, and what is allowed.
    """
    path = Path(path)
    if not path.exists():
        raise InputError(f"{path}: there is no such scan")
    scan = (_universal if path.suffix.lower() in UNIVERSAL else _table)(path, frequency_hz)
    points, missing = len(scan.x_m), scan.missing
    refuse(
        path,
        {
            f"{points} points; at most {MOST_POINTS} are taken": points > MOST_POINTS,
            f"{points} measured points ({missing} missing); a profile needs at least "
            f"{FEWEST_POINTS}": points < FEWEST_POINTS,
            "every amplitude is zero: there is no profile": not np.any(scan.amplitude_m),
            f"{missing} of {points + missing} points have no amplitude; at most "
            f"{MOST_MISSING:.0%} of them may lack it": missing > MOST_MISSING * (points + missing),
        },
    )
    return scan


def _notes(lacking: np.ndarray, *, what: str) -> list[str]:
    """A note that names the points without an amplitude, if there are any."""
    if not len(lacking):
        return []
    named = ", ".join(map(str, lacking[:PLACES_NAMED])) + ", …" * (len(lacking) > PLACES_NAMED)
    many = "s" * (len(lacking) > 1)
    return [
        f"{len(lacking)} point{many} without an amplitude, excluded from profile and noise "
        f"({what}{many} {named})"
    ]


def _angular_frequency(frequency_hz: float | None, *, path: Path) -> float:
    if frequency_hz is None:
        raise InputError(f"{path}: velocities and spectra need the actuator's frequency")
    return 2 * math.pi * frequency_hz


class Column(NamedTuple):
    """A quantity, the unit it is in ("" if none is named), its place in a row, and its name."""

    quantity: str
    unit: str
    place: int
    name: str

    @property
    def size(self) -> float | None:
        """The size of its unit in SI units and radians; None of one that the quantity has not."""
        return QUANTITIES[self.quantity][0].get(self.unit)

    @property
    def is_velocity(self) -> bool:
        return self.unit in SPEEDS_M_PER_S


def column_of(name: str, place: int = 0) -> Column | None:
    """The column that a cell of a header names; None for one that a scan does not have."""
    name = name.strip().strip("\"'").strip()
    if bracketed := IN_BRACKETS.fullmatch(name):
        pairs = [(bracketed["words"], bracketed["unit"])]
    else:  # the likeliest first
        breaks = [match.start() for match in re.finditer(r"[\s_/,]", name)]
        ends = [(name[:at], name[at + 1 :].strip()) for at in breaks]
        # Decibels are known, to be named in a message: the file does not tell what 0 dB is.
        known = [each for each in ends if each[1].lower() in KNOWN_UNITS or "db" in each[1].lower()]
        pairs = [*known, (name, ""), *(ends if len(ends) == 1 else [])]
    for words, unit in pairs:
        parts = [part for part in re.split(r"[\s_\-.:]+", words.lower()) if part]
        core = [part for part in parts if part not in BESIDE] or parts[:1]
        if quantity := NAMES.get(" ".join(core)):
            units = QUANTITIES[quantity][0]
            alike = [each for each in units if each.lower() == unit.lower()]
            return Column(quantity, unit if unit in units else (*alike, unit)[0], place, name)
    return None


def columns_of(header: Iterable[str], wanted: Iterable[str], *, where: str) -> dict[str, Column]:
    """The columns of some quantities, by these, each with its unit.

    Raises InputError, naming the place, for a quantity without a unit, or that stands twice.
    """
    known = [column for at, name in enumerate(header) if (column := column_of(name, at))]
    columns: dict[str, Column] = {}
    for column in sorted(known, key=lambda each: each.size is None):
        first = columns.get(column.quantity)
        if column.quantity not in wanted or (first and column.size is None):
            continue
        if column.size is None:
            units = ", ".join(
                f"{column.quantity}_{unit}" for unit in QUANTITIES[column.quantity][0]
            )
            hint = "; decibels are not supported" * column.unit.lower().startswith("db")
            raise InputError(f"{where}: column {column.name!r} needs a unit, one of {units}{hint}")
        if first:
            raise InputError(
                f"{where}: the column {column.quantity!r} stands twice: {first.name!r} and "
                f"{column.name!r}; leave one of them out"
            )
        columns[column.quantity] = column
    return columns


def _columns(header: Sequence[str], *, where: str) -> tuple[dict[str, Column], list[str]]:
    """The columns that make a scan, by their quantities, and a note on those ignored."""
    named = [column_of(name) for name in header]
    usable = {column.quantity for column in named if column and column.size is not None}
    wanted = set(QUANTITIES)
    if "imaginary" in usable and "phase" not in usable:
        wanted -= {"amplitude"}
    elif "amplitude" in usable:
        wanted -= {"real", "imaginary"}
    columns = columns_of(header, wanted, where=where)
    parts = [columns[name] for name in ("real", "imaginary") if name in columns]
    unknown = [name.strip() for name, column in zip(header, named, strict=True) if not column]
    other = f"; unknown columns: {', '.join(map(repr, unknown))}" if unknown else ""
    refuse(
        where,
        {
            "the place of a point is x and y, or r, or r and phi; the columns are "
            f"{', '.join(header)}": set(columns) & {"x", "y", "r", "phi"}
            not in ({"x", "y"}, {"r", "phi"}, {"r"}),
            f"column 'amplitude_um' is missing; a scan has {FORM}{other}": not parts
            and "amplitude" not in columns,
            "real and imaginary part go together, both displacements or both velocities": parts
            and (len(parts) < 2 or parts[0].is_velocity != parts[1].is_velocity),
            "give sign or phase, not both": {"sign", "phase"} <= set(columns),
        },
    )
    taken = {column.place for column in columns.values()}
    ignored = [repr(name.strip()) for at, name in enumerate(header) if at not in taken]
    return columns, [f"ignored columns: {', '.join(ignored)}"] if ignored else []


def _table(path: Path, frequency_hz: float | None) -> Scan:
    """The scan in a table of text."""
    header, header_line, cells, notes = read_cells(path, what="scan", form=FORM)
    columns, ignored = _columns(header, where=f"{path}: line {header_line}")
    notes += ignored
    motion = [columns[name].place for name in ("amplitude", "real", "imaginary") if name in columns]
    measured = ~cells[motion].apply(lambda column: column.str.lower()).isin(MISSING).any(axis=1)
    lines, lacking = cells.index[measured].to_numpy(), cells.index[~measured].to_numpy()
    table = {}
    for quantity, column in columns.items():
        table[quantity] = numbers(cells[measured], column, path=path)
        if column.is_velocity:
            table[quantity] /= _angular_frequency(frequency_hz, path=path)
            notes.append(f"{column.name!r} divided by the angular frequency")
    phase, sign = table.get("phase", 0.0), table.get("sign", np.ones(len(lines)))
    against = "amplitude must not be negative where phase or sign tells its direction"
    wrong = {
        "r must not be negative": table.get("r", sign**2) < 0,
        "sign must be 1 or -1": sign**2 != 1,
    }
    if "phase" in table or "sign" in table:
        wrong[against] = table.get("amplitude", sign**2) < 0
    for problem, rows in wrong.items():
        for line in lines[rows][:1]:
            raise InputError(f"{path}: line {line}: {problem}")
    if "real" in table:
        amplitude = table["real"] + 1j * table["imaginary"]
    else:
        amplitude = table["amplitude"] * np.exp(1j * phase)
    amplitude = amplitude * sign
    if "r" in table:
        place = table["r"] * np.exp(1j * table.get("phi", 0.0))
    else:
        place = table["x"] + 1j * table["y"]
    signed = {"phase", "sign", "imaginary"} & set(table) or np.any(amplitude.real < 0)
    return Scan(
        path=path,
        x_m=place.real,
        y_m=place.imag,
        amplitude_m=amplitude,
        lines=lines,
        missing=len(lacking),
        signed=bool(signed),
        notes=(*notes, *_notes(lacking, what="line")),
        radial="r" in table and "phi" not in table,
    )


def read_cells(
    path: Path, *, what: str, form: str
) -> tuple[list[str], int, pd.DataFrame, list[str]]:
    """The header's cells and line, the other cells by their line in the file, and notes.

    ``what`` a table of points is and which ``form`` it needs are for messages.
    """
    try:
        text, encoding = _decoded(path.read_bytes())
    except OSError as error:
        raise InputError(f"{path}: the {what} cannot be read: {error}") from None
    lines = io.StringIO(text, newline=None).read().split("\n")
    with naming(path):
        index, separator = _header(lines, what=what, form=form)
    above = [line for line in lines[:index] if line.strip() and not COMMENT.match(line)]
    lines[index] = COMMENT.sub("", lines[index], count=1)
    rows: dict[int, list[str]] = {}
    for number, line in enumerate(lines[index:], index + 1):
        if COMMENT.match(line):
            continue
        cells = line.split()
        if separator:
            try:
                (cells,) = csv.reader([line or separator], delimiter=separator, strict=True)
            except csv.Error as error:
                raise InputError(f"{path}: line {number}: cannot be read: {error}") from None
        if any(map(str.strip, cells)):
            rows[number] = [cell.strip() for cell in cells]
    header = rows.pop(index + 1)
    for number, cells in rows.items():
        if (count := len(cells)) != len(header):
            hint = "; decimal commas need another separator, such as semicolons"
            hint *= separator == "," and count > len(header)
            raise InputError(
                f"{path}: line {number}: {count} cells where the header has {len(header)}{hint}"
            )
    notes = [] if encoding == "utf-8" else [f"read as {encoding}"]
    notes += [f"{len(above)} lines before the header ignored"] if above else []
    table = pd.DataFrame(list(rows.values()), list(rows), range(len(header)), dtype=object)
    return header, index + 1, table, notes


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


def _header(lines: Sequence[str], *, what: str, form: str) -> tuple[int, str | None]:
    """The place of the line that names columns, which may be a comment, and its separator."""
    filled = [index for index, line in enumerate(lines) if line.strip(" \t,;")]
    plain = [index for index in filled if not COMMENT.match(lines[index])]
    if not plain:
        raise InputError(f"the {what} is empty; it needs {form}")
    comments = [index for index in filled if index < plain[0]]
    for index in (*plain[:FIRST_LINES], *comments[:FIRST_LINES]):
        line = COMMENT.sub("", lines[index], count=1)
        named = {
            separator: len({column.quantity for cell in cells if (column := column_of(cell))})
            for separator, cells in ((each, line.split(each)) for each in SEPARATORS)
        }
        separator = max(SEPARATORS, key=lambda each: named[each])
        if named[separator] >= FEWEST_NAMED:
            return index, separator
    first = lines[plain[0]].strip()[:60]
    raise InputError(f"line {plain[0] + 1}: no header names the columns: {first!r}; give {form}")


def numbers(table: pd.DataFrame, column: Column, *, path: Path) -> np.ndarray:
    """A column's values in SI units; raises InputError naming the line of one that is none."""
    cells, name = table[column.place], column.quantity
    comma, point = (cells.str.contains(sign, regex=False) for sign in ",.")
    if comma.any() and point.any():
        line, cell = next(cells[point].items())
        raise InputError(
            f"{path}: line {line}: {name} has a point in {cell!r}, and a comma in other rows; one "
            "of them must be the decimal sign, and nothing stands between thousands"
        )
    values = pd.to_numeric(cells.str.replace(",", "."), errors="coerce").to_numpy(dtype=float)
    for line, cell in cells[~(np.abs(values) <= LARGEST)][:1].items():
        raise InputError(f"{path}: line {line}: {name} is {cell!r}, not a finite number")
    return values * (column.size or 1.0)


def _universal(path: Path, frequency_hz: float | None) -> Scan:
    """The scan in a universal file; a point's line is its function's number."""
    with needing("scans", what="a universal file (or export the scan as text)"):
        import pyuff
    omega = _angular_frequency(frequency_hz, path=path)
    try:
        sets = pyuff.UFF(str(path)).read_sets()
    except Exception as error:  # whatever a damaged file makes of it
        raise InputError(f"{path}: not a universal file that pyuff reads: {error}") from None
    sets = sets if isinstance(sets, list) else [sets]
    length = next((float(each["length"]) for each in sets if each.get("type") == UNITS), 1.0)
    places = {
        int(node): complex(x, y) / length
        for each in sets
        if each.get("type") in NODES
        for node, x, y in zip(each["node_nums"], each["x"], each["y"], strict=True)
    }
    functions = [each for each in sets if each.get("type") == FUNCTION]
    if len({abs(int(each["rsp_dir"])) for each in functions}) > 1:
        functions = [each for each in functions if abs(int(each["rsp_dir"])) == NORMAL]
    nodes = [int(each["rsp_node"]) for each in functions]
    kinds = {int(each.get("ordinate_spec_data_type", 0)) for each in functions}
    unplaced = set(nodes) - set(places)
    refuse(
        path,
        {
            "no places of points (data set 15 or 2411) are in the file": not places,
            "no functions (data set 58) along one direction or z are in the file": not functions,
            f"the node {min(unplaced, default=0)} of a function has no place (set 15)": unplaced,
            "a node has several functions; export one for each point": len(set(nodes)) < len(nodes),
            "the functions are neither displacements (type 8) nor velocities (11) but of type "
            f"{', '.join(map(str, sorted(kinds)))}": kinds not in ({DISPLACEMENT}, {VELOCITY}),
        },
    )
    rows = [_line_at(each, frequency_hz=omega / (2 * math.pi), path=path) for each in functions]
    measured, lines_hz = (np.array(column) for column in zip(*rows, strict=True))
    amplitude = measured.astype(complex) / (omega if kinds == {VELOCITY} else 1.0)
    seen, numbers = np.isfinite(amplitude), 1 + np.arange(len(nodes))
    place = np.array([places[node] for node in nodes])[seen]
    return Scan(
        path=path,
        x_m=place.real,
        y_m=place.imag,
        amplitude_m=amplitude[seen],
        lines=numbers[seen],
        missing=int(np.sum(~seen)),
        signed=np.iscomplexobj(measured) or bool(np.any(amplitude[seen].real < 0)),
        notes=(f"read at {lines_hz.min():.7g} Hz", *_notes(numbers[~seen], what="function")),
    )


def _line_at(
    function: dict[str, Any], *, frequency_hz: float, path: Path
) -> tuple[complex | float, float]:
    """The amplitude at the line nearest to the frequency, and that line.

    It is NaN where the function is not finite there, or zero at all lines: nothing was measured.
    """
    lines, data = np.asarray(function["x"], dtype=float), np.asarray(function["data"])
    nearest = int(np.argmin(np.abs(lines - frequency_hz)))
    apart = float(np.diff(lines).max()) if len(lines) > 1 else 0.0
    farthest = FARTHEST_LINE * apart if apart else FARTHEST_SHARE * frequency_hz
    off = abs(lines[nearest] - frequency_hz)
    kind, over = (int(function.get(key, 0)) for key in ("func_type", "abscissa_spec_data_type"))
    refuse(
        f"{path}: node {int(function['rsp_node'])}",
        {
            "a function of time or a power spectrum; export amplitudes or frequency responses": kind
            in TIME_OR_POWER
            or over != FREQUENCY,
            f"its lines go from {lines.min():.7g} to {lines.max():.7g} Hz, and the actuator "
            f"vibrates at {frequency_hz:.7g} Hz (actuator.frequency_hz)": off > farthest,
        },
    )
    if not (np.any(data) and np.abs(data[nearest]) <= LARGEST):
        return np.nan * data[nearest], float(lines[nearest])
    sign = -1 if int(function["rsp_dir"]) < 0 else 1
    return sign * data[nearest], float(lines[nearest])
