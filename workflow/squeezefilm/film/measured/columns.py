"""The columns of a scan's table: what its header's words mean, in which unit.

The words stand in scan_words.csv, so that a program or a language is lines there: those that name a
quantity together, those that may stand beside it, and those of a cell that tell whether a row is
valid. Words of a motion alone are its amplitude, with a direction its part along z, with a quantity
(``Velocity Real``) that.
"""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np

from squeezefilm.errors import InputError
from squeezefilm.film.measured.scan import (
    MAX_FREQUENCY_OFFSET_FRACTION,
    MAX_MODE_DISTANCE_FRACTION,
    list_text,
    nearest_spectral_line,
)
from squeezefilm.text_tables.header import Column, Vocabulary, split_cells
from squeezefilm.text_tables.header_cells import (
    fold_accents,
    normalised_unit,
    possible_words_and_units,
    sizes_of_normalised_units,
    words_of_file,
)
from squeezefilm.units import unit_sizes

LENGTH_UNITS_M = sizes_of_normalised_units("m")
# Units of motions, and by which power of the angular frequency they are larger than a displacement.
OMEGA_POWER_OF_SUFFIX = {"": 0, "/s": 1, "/s²": 2}
MOTION_UNITS = {
    name + end: size for end in OMEGA_POWER_OF_SUFFIX for name, size in LENGTH_UNITS_M.items()
}
MOTION_UNITS |= {"g": 9.80665, "mg": 9.80665e-3}
OMEGA_POWER_OF_UNIT = {
    name + end: power for end, power in OMEGA_POWER_OF_SUFFIX.items() for name in LENGTH_UNITS_M
}
OMEGA_POWER_OF_UNIT |= {"g": 2, "mg": 2}
ANGLE_UNITS_RAD = {name: math.radians(degrees) for name, degrees in unit_sizes("deg").items()}
ANGLE_UNITS_RAD |= {"cycles": 2 * math.pi, "mrad": 1e-3}
FREQUENCY_UNITS_HZ = {name.lower(): size for name, size in unit_sizes("Hz").items()}
COORDINATE_UNITS = dict.fromkeys(("x", "y", "r"), LENGTH_UNITS_M) | {"phi": ANGLE_UNITS_RAD}
AMPLITUDE_UNITS = dict.fromkeys(("amplitude", "real", "imaginary"), MOTION_UNITS) | {
    "phase": ANGLE_UNITS_RAD
}
UNITS_OF_SCAN_QUANTITY = COORDINATE_UNITS | AMPLITUDE_UNITS | {"sign": {"": 1.0}}
"""What a scan is read from, each with its units, in small letters, and their sizes."""
UNITS_OF_QUANTITY = UNITS_OF_SCAN_QUANTITY | {
    "normal": MOTION_UNITS,
    "frequency": FREQUENCY_UNITS_HZ,
    "time": unit_sizes("s"),
}
ROW_STATUS_QUANTITIES = ("status", "valid", "invalid", "uncertain")
UNITS_OF_QUANTITY |= {
    "line": LENGTH_UNITS_M,
    "height": LENGTH_UNITS_M,
    "level": {},
    "mean": dict(MOTION_UNITS),  # no motion beside an amplitude, which it is the mean of
    **{name: {} for name in ROW_STATUS_QUANTITIES},
}
"""The same, with the amplitude along z, what rows of a place may differ by, a place on a line or
along z, a motion in decibels, whether a row is valid, and the mean of several motions."""
MOTION_QUANTITIES = {name for name, units in UNITS_OF_QUANTITY.items() if units is MOTION_UNITS}
SIZE_OF_OTHER_UNIT = {**ANGLE_UNITS_RAD, **FREQUENCY_UNITS_HZ, "s": 1.0}
ALL_UNITS = {*MOTION_UNITS, *SIZE_OF_OTHER_UNIT}
USUAL_UNITS = dict.fromkeys(("x", "y", "r"), "mm") | {"phi": "deg", "phase": "deg", "sign": "1"}
USUAL_MOTION_UNITS = ("um", "mm/s", "m/s²")
MOTION_NAMES = ("displacement", "velocity", "acceleration")
AT_FREQUENCY_PATTERN = re.compile(
    r"@.*freq[^=]*=\s*(\d+(?:\.\d*)?(?:[eE][-+]?\d+)?)(?:[-+][-+\d.eE]+i)?\s*([A-Za-z]*)"
)
"""How a program writes the frequency at which a column was solved, of a mode a complex one."""
OVER_DRIVE_PATTERN = re.compile(
    r"(?:(?<=[sg²2])\s*/\s*v|\s*/\s*(?:n|lbf))(?=[\s\])]*\Z)", re.IGNORECASE
)
"""The voltage or force that a response is over; m/V alone may be a decoder's scale."""
FREQUENCY_IN_NAME_PATTERN = re.compile(
    r"(?:\A\W*|(?<=\w)(?:\s*@\s*|[\s_]+(?:at\s+|bei\s+)?))(\d+(?:[.,]\d*)?)\s*([kM]?Hz)\b",
    re.IGNORECASE,
)
"""The same in a name: ``43270 Hz Magnitude``, ``Amplitude 43.27 kHz [um]``."""
FREQUENCY_NAME_PATTERN = re.compile(r"\W*\d+(?:[.,]\d*)?\s*[kM]?Hz\b\s*(|[\[(].*)", re.IGNORECASE)
"""The same as the whole name, but for a unit in brackets."""
FREQUENCY_PATTERN = re.compile(r"\d+(?:[.,]\d+)?\s*[kM]?Hz\b", re.IGNORECASE)
DECIBELS_PATTERN = re.compile(
    r"db[\W_]*(?:(?:re|ref|rel|relative|referred|bezogen|to|auf)[\W_]+)*"
    r"([\d.]+(?:e[-+]?\d+)?)?[\W_]*(\D\S*(?: \S+)?)"
)
"""Decibels with their reference: ``dB re 1 um``, ``dB (m/s)``, ``dB/1.00n m/s``."""
AMPLITUDE_SYMBOL_PATTERN = re.compile(r"\A\s*[Aa](?=[\s_/\[(])")
"""An amplitude's symbol before its unit: ``A / µm``."""
VOLTS_PATTERN = re.compile(r"[\s_/\[(][mµ\u03bcun]?V(?: ?rms)?[\])]?\s*$", re.IGNORECASE)
RMS_OR_PEAK_UNIT_PATTERN = re.compile(
    r"\s*([\[(][^\[\]()]+?)[\s_(,;]+(rms|eff|pk-?pk|p-?p|s-?s|0-?pk?|peak|pk)\)?([\])])$",
    re.IGNORECASE,
)
"""An effective value or an extent that stands behind the unit: ``[mm/s RMS]``, ``(um p-p)``."""
AXIS_BEHIND_WORD_PATTERN = re.compile(r"(?<=[a-z]{3})(?=[XY](?:[\W_]|$))")
"""Where MATLAB leaves out a blank: ``StageX_mm_``."""
LABVIEW_X_NAME = "X_Value"
"""LabVIEW's first column, of times or empty, which is no place."""

WORDS_OF_MEANING = words_of_file("scan_words.csv")
QUANTITY_OF_WORDS = {
    frozenset(words.split()): quantity
    for quantity in UNITS_OF_QUANTITY
    for words in WORDS_OF_MEANING.get(quantity, ())
}
MOTION_WORDS_BY_KIND = [{*WORDS_OF_MEANING[name]} for name in MOTION_NAMES]
MOTION_WORDS = {*WORDS_OF_MEANING["normal"]}.union(*MOTION_WORDS_BY_KIND)
COMPONENT_WORDS = {*WORDS_OF_MEANING["component"]}
VIBRATION_WORDS = MOTION_WORDS | {"vib", "vibration"}
DIRECTION_WORDS, IGNORED_WORDS = {*WORDS_OF_MEANING["direction"]}, {*WORDS_OF_MEANING["beside"]}
# The motion that letters alone are, by the power of the angular frequency, if their unit fits.
OMEGA_POWER_OF_LETTER = {"u": 0, "dz": 0, "v": 1, "a": 2}
# The amplitude of a harmonic motion over its effective value, its extent from peak to peak, itself.
AMPLITUDE_FACTORS = {"rms": math.sqrt(2), "span": 0.5, "peak": 1.0}
AMPLITUDE_FACTOR_OF_WORDS = [
    (words.split(), ratio)
    for kind, ratio in AMPLITUDE_FACTORS.items()
    for words in WORDS_OF_MEANING[kind]
]
# What tells that a motion is a component, which has a sign, and that it is none.
COMPONENT_NAMES = {
    *("directional", "gerichtete", "richtungsverformung", "directionnelle", "direccional"),
    *("direzionale", "方向変形"),
}
UNSIGNED_WORDS = {*WORDS_OF_MEANING["amplitude"], "uampz", "peak", "pk", "0p", "max", "total"}


@dataclass(frozen=True)
class ScanColumn(Column):
    """A column of a scan, whose angles are in radians.

    ``amplitude_factor`` is the amplitude over what the column has: √2 for effective values.
    ``power`` is that of the angular frequency by which a motion in the unit is larger than a
    displacement, and ``omega_power_of_name`` the same by the column's words, None if they do not
    say. In ``in_decibels`` the size is the reference's. A component of a vector ``is_signed``.
    """

    amplitude_factor: float = 1.0
    power: int = 0
    omega_power_of_name: int | None = None
    in_decibels: bool = False
    is_signed: bool = False

    @property
    def usual_unit(self) -> str:
        """The unit that a message suggests."""
        return USUAL_UNITS.get(self.quantity, USUAL_MOTION_UNITS[self.omega_power_of_name or 0])

    @property
    def frequency_hz(self) -> float | None:
        """The frequency that the name says, if any: ``w (um) @ freq=43270``."""
        if match := (
            AT_FREQUENCY_PATTERN.search(self.name) or FREQUENCY_IN_NAME_PATTERN.search(self.name)
        ):
            return float(match[1].replace(",", ".")) * FREQUENCY_UNITS_HZ.get(match[2].lower(), 1.0)
        return None


def quantity_of_words(words: Sequence[str], unit: str = "") -> str | None:
    """The quantity that words name; None for one that a scan does not have.

    The unit decides between two: ``in phase`` is a real part in µm and a phase in degrees.
    """
    core = {*words} - IGNORED_WORDS or {*words} & {*WORDS_OF_MEANING["line"]} or {*words[:1]}
    if {*words} & VIBRATION_WORDS:
        core -= {*WORDS_OF_MEANING["beside_motion"]}
    sets = [names for names in (frozenset(words), frozenset(core)) if names in QUANTITY_OF_WORDS]
    if sets:
        named = [QUANTITY_OF_WORDS[names] for names in sets]
        return min(named, key=lambda name: unit not in UNITS_OF_QUANTITY[name])
    of_words = {QUANTITY_OF_WORDS.get(frozenset([word])) for word in core}
    if len(of_words) == 1 and of_words != {None}:
        return of_words.pop()
    if core & COMPONENT_WORDS and (rest := frozenset(core - COMPONENT_WORDS)) in QUANTITY_OF_WORDS:
        quantity = QUANTITY_OF_WORDS[rest]
        if quantity == "height":
            return "normal"
        return quantity if quantity not in COORDINATE_UNITS else None
    means = {*WORDS_OF_MEANING["mean"]}
    if core & means and QUANTITY_OF_WORDS.get(frozenset(core - means)) == "amplitude":
        return "mean"
    rest = frozenset(core - MOTION_WORDS - COMPONENT_WORDS)
    if "z" in core and (part := QUANTITY_OF_WORDS.get(frozenset(core - {"z"}))) in AMPLITUDE_UNITS:
        return "normal" if part == "amplitude" else part
    if rest == core or not (rest or core & MOTION_WORDS):
        return None
    if rest and rest <= DIRECTION_WORDS:
        return "normal"
    kind = QUANTITY_OF_WORDS.get(rest - DIRECTION_WORDS) if rest else "amplitude"
    return kind if kind in {*AMPLITUDE_UNITS, "level"} else None


def scan_column_of_cell(name: str, column_index: int = 0) -> ScanColumn | None:
    """The column that a cell of a header names; None for one that a scan does not have."""
    if FREQUENCY_NAME_PATTERN.fullmatch(name) or (name == LABVIEW_X_NAME and not column_index):
        return None
    cell = OVER_DRIVE_PATTERN.sub("", FREQUENCY_IN_NAME_PATTERN.sub("", name))
    cell = RMS_OR_PEAK_UNIT_PATTERN.sub(r" \2 \1\3", cell)
    cell = AXIS_BEHIND_WORD_PATTERN.sub(" ", cell)
    for words, unit in possible_words_and_units(cell, ALL_UNITS):
        words, ratio = _split_amplitude_factor(words)
        quantity = quantity_of_words(words, unit)
        if {*words} - IGNORED_WORDS == {"z"} and OMEGA_POWER_OF_UNIT.get(unit):
            quantity = "normal"
        if quantity is None:
            continue
        named = next(
            (at for at, motion_words in enumerate(MOTION_WORDS_BY_KIND) if motion_words & {*words}),
            None,
        )
        size = UNITS_OF_QUANTITY[quantity].get(unit)
        power = OMEGA_POWER_OF_UNIT.get(unit, 0)
        decibels = False
        if unit.startswith("db") and quantity in ("amplitude", "normal", "level"):
            quantity = "normal" if quantity == "normal" else "amplitude"
            (size, power), decibels = _decibel_reference(unit), True
        return ScanColumn(quantity, unit, size, column_index, name, ratio, power, named, decibels)
    return None


def _decibel_reference(unit: str) -> tuple[float | None, int]:
    """The size of the motion that is 0 dB, None if the unit does not tell, and its power of ω."""
    match = DECIBELS_PATTERN.fullmatch(unit)
    named = normalised_unit(match[2]).replace(" ", "") if match else ""
    if match is None or named not in MOTION_UNITS:
        return None, 0
    return float(match[1] or 1) * MOTION_UNITS[named], OMEGA_POWER_OF_UNIT[named]


def _split_amplitude_factor(words: list[str]) -> tuple[list[str], float]:
    """Words of an amplitude in place of those of AMPLITUDE_FACTOR_OF_WORDS, and its ratio to what
    they name."""
    for named, ratio in AMPLITUDE_FACTOR_OF_WORDS:
        for at in range(len(words)):
            if words[at : at + len(named)] == named:
                rest = [*words[:at], *words[at + len(named) :]]
                named_motion = {*WORDS_OF_MEANING["amplitude"], *WORDS_OF_MEANING["level"]}
                return rest + ["amplitude"] * (not {*rest} & named_motion), ratio
    return words, 1.0


class ScanVocabulary(Vocabulary):
    """The columns of scans and outlines."""

    units = ALL_UNITS
    places = ("x", "y", "r")
    planes = (("x", "y"), ("r", "phi"))

    def column(self, cell: str, column_index: int = 0) -> ScanColumn | None:
        return scan_column_of_cell(cell, column_index)

    def quantities(self, header: Sequence[str]) -> Collection[str]:
        known = {column.quantity for column in self.columns(header)} - {*ROW_STATUS_QUANTITIES}
        return known - {"line"} if known & {*COORDINATE_UNITS} else known

    def size_of_unit(self, cell: str) -> float | None:
        motion = self.column(f"amplitude [{cell}]")
        if motion and motion.size:
            return motion.size * motion.amplitude_factor
        return SIZE_OF_OTHER_UNIT.get(normalised_unit(OVER_DRIVE_PATTERN.sub("", cell)))

    def size_in_name(self, name: str) -> float | None:
        own = self.column(name) or _motion_column_of_letter(name, 0)
        return own.size * own.amplitude_factor if own and own.size and own.unit else None


SCAN_VOCABULARY = ScanVocabulary()


def header_columns(header: Sequence[str]) -> list[ScanColumn]:
    """The columns that a header names.

    A lock-in amplifier's ``R [V]`` is no radius, and ``Theta`` beside it a phase.
    """
    named = [column for at, name in enumerate(header) if (column := scan_column_of_cell(name, at))]
    kept = [column for column in named if not _is_voltage_of_lock_in(column)]
    if len(kept) < len(named) and "r" not in {column.quantity for column in kept}:
        kept = [
            replace(column, quantity="phase") if column.quantity == "phi" else column
            for column in kept
        ]
    return kept


def _is_voltage_of_lock_in(column: ScanColumn) -> bool:
    """Tell whether a column is the magnitude ``R [V]``."""
    return column.quantity == "r" and bool(VOLTS_PATTERN.search(column.name))


def names_with_frequency_above(
    header: Sequence[str], above: Sequence[str], separator: str
) -> list[str]:
    """Names of motions with the frequencies of merged cells above them: ``38.5 kHz Ampl. [nm]``.

    They stay as they are where the motions are not alike below each frequency, or some are beside.
    """
    motions = [
        column.column_index for column in header_columns(header) if _is_part_of_motion(column)
    ]
    for line in above:
        cells = split_cells(line, separator)
        starts = [at for at, cell in enumerate(cells) if FREQUENCY_PATTERN.fullmatch(cell)]
        width = len(motions) // max(len(starts), 1)
        groups = [range(start, start + width) for start in starts]
        names = [[*header[start : start + width]] for start in starts]
        are_merged = [at for group in groups for at in group] == motions
        if len(starts) > 1 and are_merged and all(group == names[0] for group in names):
            frequency = {at: cells[group.start] for group in groups for at in group}
            return [f"{frequency.get(at, '')} {name}".strip() for at, name in enumerate(header)]
    return [*header]


def _is_part_of_motion(column: ScanColumn) -> bool:
    return column.quantity in {*MOTION_QUANTITIES, "phase"}


def select_columns(
    header: Sequence[str],
    wanted: Collection[str],
    *,
    frequency_hz: float | None,
    above: Sequence[str] = (),
) -> tuple[dict[str, ScanColumn], list[str]]:
    """The columns of some quantities, by these, and notes on the choice.

    Of several parts of a motion that along z is taken, of several frequencies the actuator's.

    Args:
        above: lines above the header, which may tell columns apart.

    Raises:
        InputError: for a quantity that stands twice.
    """
    named = _with_ambiguous_columns(header_columns(header), header)
    usable = {column.quantity for column in named if column.size}
    if "imaginary" in usable and "phase" not in usable:
        wanted = {*wanted} - {"amplitude"}
    other = "normal" if "amplitude" in usable and "normal" not in usable else "amplitude"
    if "normal" in {column.quantity for column in named}:
        named = [column for column in named if column.quantity != other]
    named = [
        replace(column, quantity="amplitude", is_signed=_is_signed_component(column))
        if column.quantity in ("normal", "amplitude")
        else column
        for column in named
    ]
    if "amplitude" in wanted and {"amplitude", "normal"} & usable:
        wanted = {*wanted} - {"real", "imaginary"}
    named = [column for column in named if column.quantity in wanted]
    named, notes = _columns_at_frequency(named, frequency_hz)
    columns: dict[str, ScanColumn] = {}
    for column in sorted(named, key=lambda candidate: candidate.size is None):
        first = columns.setdefault(column.quantity, column)
        names = {re.sub(r"\d+", "", twin.name.lower()) for twin in (first, column)}
        remedy = "leave one of them out"
        above_hz = next(filter(None, map(FREQUENCY_PATTERN.findall, above)), [])
        if len(above_hz) > 1:
            remedy = (
                f"write the frequencies above into the names, as in '{above_hz[0]} {first.name}', "
                "or keep the columns of one"
            )
        elif len(names) == 1:
            remedy += ", or write one column with their mean"
        if first is not column and (column.size or not first.size):
            _reject_data_sets_side_by_side(named)
            raise InputError(
                f"the column {column.quantity!r} stands twice: {first.name!r} and "
                f"{column.name!r}; {remedy}"
            )
    return dict(sorted(columns.items(), key=lambda entry: entry[1].column_index)), notes


def _reject_data_sets_side_by_side(named: Sequence[ScanColumn]) -> None:
    """Reject places that stand repeatedly, each with another quantity, as digitisers write them."""
    counts = Counter(column.quantity for column in named)
    repeated = [quantity for quantity, count in counts.items() if count > 1]
    if len(repeated) > 1 and {*repeated} & {*COORDINATE_UNITS}:
        names = [repr(column.name) for column in named if column.quantity in repeated]
        is_curve = not {*counts} & {*AMPLITUDE_UNITS}
        kept = "x_mm, amplitude_um" if is_curve else "x_mm, y_mm, amplitude_um"
        raise InputError(
            f"several data sets side by side: {list_text(names)}; keep the columns of one, with a "
            f"quantity and a unit in each name, such as {kept}"
        )


def _is_signed_component(column: ScanColumn) -> bool:
    """Tell whether a motion is a vector's component, which has a sign: ``u:2``, ``UZ``, ``w``.

    An amplitude, by its name, has none.
    """
    words = {*re.split(r"[\W_]+", fold_accents(column.name))}
    is_component = column.quantity == "normal" or words & COMPONENT_NAMES
    is_size = column.in_decibels or column.amplitude_factor != 1 or words & UNSIGNED_WORDS
    return bool(is_component and not is_size)


def _with_ambiguous_columns(named: list[ScanColumn], header: Sequence[str]) -> list[ScanColumn]:
    """Columns with those whose words tell what they are only where no other column is it.

    These are a position without a direction, and, as the motion, letters without a unit, A in µm, a
    mean of several columns and levels.
    """
    known = {column.quantity for column in named}
    if not known & {*COORDINATE_UNITS}:
        named = [
            replace(column, quantity="x") if column.quantity == "line" else column
            for column in named
        ]
    letters = [
        column for at, name in enumerate(header) if (column := _motion_column_of_letter(name, at))
    ]
    if known & MOTION_QUANTITIES:
        return named + [column for column in letters if column.unit]
    levels = [
        replace(column, quantity="amplitude", unit="db", in_decibels=True)
        for column in named
        if column.quantity == "level"
    ]
    means = [replace(column, quantity="amplitude") for column in named if column.quantity == "mean"]
    symbols = [
        replace(column, name=name)
        for at, name in enumerate(header)
        if AMPLITUDE_SYMBOL_PATTERN.match(name)
        and (column := scan_column_of_cell(AMPLITUDE_SYMBOL_PATTERN.sub("amplitude", name), at))
    ]
    lines = [column for at, name in enumerate(header) if (column := _motion_at_frequency(name, at))]
    return named + (letters or symbols or means or levels or lines)


def _motion_at_frequency(name: str, column_index: int) -> ScanColumn | None:
    """The motion or the phase that is called by its frequency: ``29.8 kHz [um]``."""
    match = FREQUENCY_NAME_PATTERN.fullmatch(name)
    if not match:
        return None
    ways = [
        scan_column_of_cell(f"{quantity} {match[1]}", column_index) for quantity in AMPLITUDE_UNITS
    ]
    known = [column for column in ways if column and (column.size or column is ways[0])]
    return replace(known[-1] if known[-1].quantity == "phase" else known[0], name=name)


def _motion_column_of_letter(name: str, column_index: int) -> ScanColumn | None:
    """The motion that a cell names by a letter, and its unit if it has one: ``v [m/s]``."""
    for words, unit in possible_words_and_units(OVER_DRIVE_PATTERN.sub("", name), ALL_UNITS):
        power = OMEGA_POWER_OF_LETTER.get(words[0]) if len(words) == 1 else None
        if power is not None and (not unit or OMEGA_POWER_OF_UNIT.get(unit) == power):
            return ScanColumn(
                "amplitude", unit, MOTION_UNITS.get(unit), column_index, name, 1.0, power, power
            )
    return None


def remedies_of_unused_columns(header: Sequence[str], used: Collection[ScanColumn]) -> list[str]:
    """Remedies for a missing amplitude, by the columns that are not used and may have it."""
    places = {column.column_index for column in used}
    unused = {at: name for at, name in enumerate(header) if at not in places}
    named = [column for column in header_columns(header) if column.column_index in unused]
    lock_in = [
        column.name
        for column in named
        if column.quantity in ("x", "y")
        and (VOLTS_PATTERN.search(column.name) or OMEGA_POWER_OF_UNIT.get(column.unit))
    ]
    known = {column.column_index for column in named}
    unknown = [name for at, name in unused.items() if at not in known]
    magnitudes = [
        name for name in unknown if (told := scan_column_of_cell(name)) and told.quantity == "r"
    ]
    angles = [
        column.name
        for column in header_columns(header)
        if column.quantity == "phase"
        and replace(column, quantity="phi") == scan_column_of_cell(column.name, column.column_index)
    ]
    voltages = [] if magnitudes else [name for name in unknown if VOLTS_PATTERN.search(name)]
    motions = [
        name
        for name in unknown
        if next(possible_words_and_units(name, ALL_UNITS))[1] in MOTION_UNITS
    ]
    heights = [column.name for column in named if column.quantity == "height" and column.size]
    values = heights if not motions else motions * (len(motions) == 1)
    columns_by_stem: dict[str, list[str]] = {}
    for name in unused.values():
        stem = re.sub(r"\d+", "", name)
        told = scan_column_of_cell(f"amplitude{stem[stem.find('[') :]}") if "[" in stem else None
        if told and told.size and "=" not in stem:
            columns_by_stem.setdefault(stem, []).append(name)
    repeated = max(columns_by_stem.values(), key=len, default=[])
    remedies = [
        f"call {list_text([*map(repr, lock_in)])} of a lock-in amplifier real_mm/s, imaginary_mm/s "
        "or the like (only the shape counts)"
    ] * bool(lock_in)
    remedies += [
        f"call {list_text([*map(repr, magnitudes + angles)])} of a lock-in amplifier velocity_mm/s"
        f"{', phase_deg' * len(angles)} or the like (only the shape counts)"
    ] * (len(magnitudes) == 1)
    remedies += [
        f"call {name!r} velocity_mm/s or the like if a vibrometer's (only the shape counts)"
        for name in voltages * (len(voltages) == 1)
    ]
    remedies += [f"call {name!r} amplitude_um if the vibration's amplitude" for name in values]
    if len(repeated) > 1:
        unit = repeated[0][repeated[0].index("[") :]
        remedies.append(
            f"if {list_text([*map(repr, repeated)])} are repeated measurements, leave one column, "
            f"or their mean, and call it amplitude {unit}"
        )
    return remedies


def remedy_of_unknown_places(header: Sequence[str]) -> str:
    """A remedy for a missing place, by a position on a line, and by words not known of an axis."""
    named = header_columns(header)
    known = {column.column_index for column in named}
    on_line = [repr(column.name) for column in named if column.quantity == "line"]
    names = dict(zip("x", on_line, strict=False)) | {
        axis: repr(name)
        for at, name in enumerate(header)
        for axis in ("x", "y")
        if at not in known and name != LABVIEW_X_NAME
        if axis in re.split(r"[\W_]+", AXIS_BEHIND_WORD_PATTERN.sub(" ", name).lower())
    }
    if not names:
        return ""
    called = ", ".join(f"{axis}_mm" for axis in names)
    return f"; call {', '.join(names.values())} {called} if the place"


def unit_problems(columns: Collection[ScanColumn]) -> list[str]:
    """Problems of the columns' units, all at once, each with what is allowed."""
    lacking = [column for column in columns if not column.size]
    levels = [column for column in lacking if column.in_decibels]
    unknown = [column for column in lacking if column.unit and column not in levels]
    bare = [column for column in lacking if not column.unit and column not in levels]
    problems = [
        f"{column.name!r} is {MOTION_NAMES[column.omega_power_of_name]} by its name and "
        f"{MOTION_NAMES[column.power]} by its unit; correct one of them"
        for column in columns
        if column.size
        and column.quantity != "phase"
        and column.omega_power_of_name not in (None, column.power)
    ]
    shape = "of a motion only the shape counts, so that a constant factor may be wrong"
    if levels:
        problems.append(
            f"decibels of {_quoted_names(levels)} have no reference; write one, as in "
            f"{_suggested_names(levels, 'dB re 1 ')} ({shape})"
        )
    if unknown:
        units = ", ".join(repr(column.unit) for column in unknown)
        problems.append(
            f"the unit {units} of {_quoted_names(unknown)} is not known; write another into "
            f"the header, as in {_suggested_names(unknown)}"
        )
    if bare:
        problems.append(
            f"no unit is known of {_quoted_names(bare)}; write it into the header, as in "
            f"{_suggested_names(bare)}"
        )
    if unknown or bare:
        problems[-1] += (
            f". Lengths are in {', '.join(LENGTH_UNITS_M)}, motions also over s or s² and in g, "
            f"angles in {', '.join(ANGLE_UNITS_RAD)}"
        )
    if any(column.quantity in MOTION_QUANTITIES for column in (*unknown, *bare)):
        problems[-1] += f" ({shape})"
    return problems


def _quoted_names(columns: Collection[ScanColumn]) -> str:
    return ", ".join(repr(column.name) for column in columns)


def _suggested_names(columns: Collection[ScanColumn], before: str = "") -> str:
    """Columns as they should be called, with a unit in place of their own."""
    stems = [
        re.sub(
            r"\W*\bdb.*|\s*(?:\[[^\[\]]*\]|[\[(][^\[(]*[\])])\s*$",
            "",
            column.name,
            flags=re.IGNORECASE,
        )
        if column.unit
        else re.sub(r"\s*\[[^\[]*\]$", "", column.name)
        for column in columns
    ]
    return ", ".join(
        f"{stem} [{before}{column.usual_unit}]" for stem, column in zip(stems, columns, strict=True)
    )


def _columns_at_frequency(
    named: list[ScanColumn], frequency_hz: float | None
) -> tuple[list[ScanColumn], list[str]]:
    """The columns at the actuator's frequency, and all that have none, and a note."""
    lines_hz = np.array(
        [column.frequency_hz for column in named if column.frequency_hz is not None]
    )
    several = len(set(lines_hz)) > 1
    if frequency_hz is None or not len(lines_hz):
        return named, []
    line_hz, far = nearest_spectral_line(lines_hz, frequency_hz)
    of_model = any(AT_FREQUENCY_PATTERN.search(column.name) for column in named)
    most = MAX_MODE_DISTANCE_FRACTION if of_model else MAX_FREQUENCY_OFFSET_FRACTION
    are_khz = of_model and bool(min(abs(1e3 * lines_hz / frequency_hz - 1)) <= most)
    in_khz = f"; if they are in kHz, write the unit: @ freq={lines_hz[0]:.7g} kHz" * are_khz
    if far and several:
        raise InputError(f"the columns' frequencies: {far}{in_khz}")
    if abs(line_hz / frequency_hz - 1) > most:
        raise InputError(
            f"the columns are at {line_hz:.7g} Hz, and the actuator vibrates at "
            f"{frequency_hz:.7g} Hz (actuator.frequency){in_khz}"
        )
    kept = [column for column in named if column.frequency_hz in (None, line_hz)]
    return kept, [f"columns at {line_hz:.7g} Hz"]
