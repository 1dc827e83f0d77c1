"""A scan in a universal file (.uff, .unv), read by pyuff.

A function (data set 58) for each point, of which the line at the actuator's frequency is taken;
points are those of data set 15 or 2411, in the units of data set 164.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from squeezefilm.errors import InputError, needing, refuse
from squeezefilm.film.measured.scan import (
    LARGEST,
    Scan,
    angular_frequency,
    missing_points,
    nearest_line,
)

# Data sets; types of abscissa and ordinate; types of functions; the direction z.
NODES, UNITS, FUNCTION = (15, 2411), 164, 58
FREQUENCY, DISPLACEMENT, VELOCITY, ACCELERATION = 18, 8, 11, 12
TIME_OR_POWER = (1, 2, 3, 9)
POWER, COHERENCES = (2, 3, 9), (6, 21, 26)
# By which power of the angular frequency a motion is larger than a displacement.
MOTION_PER_M = {DISPLACEMENT: 0, VELOCITY: 1, ACCELERATION: 2}
NORMAL = 3


def read_universal(path: Path, frequency_hz: float | None) -> Scan:
    """The scan in a universal file; a point's line is its function's number."""
    with needing("scans", what="a universal file (or export the scan as text)"):
        import pyuff
    omega = angular_frequency(frequency_hz)
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
        *missing_points(numbers[~seen].tolist(), what="function"),
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
    line_hz, far = nearest_line(lines, frequency_hz)
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
