"""A scan in a universal file (.uff, .unv), read by pyuff.

A function (data set 58) for each point, of which the line at the actuator's frequency is taken, or,
where there are none, the mode shape (data set 55, or results at nodes, 2414) at it; points are
those of data set 15 or 2411, in the units of data set 164. Only these sets are read.
"""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Collection, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from squeezefilm.errors import InputError, imports_from_extra, raise_first_problem
from squeezefilm.film.measured.scan import (
    MAX_FINITE_VALUE,
    MAX_MODE_DISTANCE_FRACTION,
    Scan,
    missing_points_note,
    nearest_spectral_line,
)

# Data sets; types of abscissa and ordinate; types of functions; the direction z.
NODES_DATASETS = (15, 2411)
UNITS_DATASET = 164
FUNCTION_DATASET = 58
MODE_SHAPE_DATASET = 55
RESULTS_DATASET = 2414
# Of results: where they are, their analysis and their kind of numbers.
AT_NODES_LOCATION, FREQUENCY_RESPONSE_ANALYSIS, COMPLEX_NUMBER_TYPE = 1, 5, 5
FREQUENCY_DATA_TYPE = 18
DISPLACEMENT_DATA_TYPE = 8
VELOCITY_DATA_TYPE = 11
ACCELERATION_DATA_TYPE = 12
TIME_OR_POWER_FUNCTION_TYPES = (1, 2, 3, 9)
POWER_SPECTRUM_FUNCTION_TYPES, COHERENCE_FUNCTION_TYPES = (2, 3, 9), (6, 21, 26)
# By which power of the angular frequency a motion is larger than a displacement.
OMEGA_POWER_OF_DATA_TYPE = {
    DISPLACEMENT_DATA_TYPE: 0,
    VELOCITY_DATA_TYPE: 1,
    ACCELERATION_DATA_TYPE: 2,
}
NORMAL_DIRECTION = 3
NAME_OF_DIRECTION = {
    number: f"{'+-'[number < 0]}{'XYZ'[abs(number) - 1]}" for number in (-3, -2, -1, 1, 2, 3)
}
RECIPROCAL_KEYS = {
    "rsp_node": "ref_node",
    "ref_node": "rsp_node",
    "rsp_dir": "ref_dir",
    "ref_dir": "rsp_dir",
}
REFERENCE_PATTERN = re.compile(r"\s*reference\s*=\s*(\S+)\s*", re.IGNORECASE)
# A mode is by this factor nearer to the actuator's frequency than any other.
MIN_FREQUENCY_OFFSET_RATIO = 3


def read_universal_file(path: Path, frequency_hz: float, rows: str) -> Scan:
    """The scan in a universal file; a point's line is its function's or node's number.

    Args:
        rows: ``mode = NUMBER``, which mode shape is taken, or ``reference = NODE`` of the
            functions, with its direction if the node has several: ``5+Z``.
    """
    with imports_from_extra("scans", what="a universal file (or export the scan as text)"):
        import pyuff
    try:
        file = pyuff.UFF(str(path))
        kinds_of_sets = [int(kind) for kind in file.get_set_types()]
    except Exception as error:  # whatever a damaged file makes of it
        raise InputError(f"not a universal file that pyuff reads: {error}") from None
    shape_set = MODE_SHAPE_DATASET if MODE_SHAPE_DATASET in kinds_of_sets else RESULTS_DATASET
    reference = REFERENCE_PATTERN.fullmatch(rows)
    of_mode = bool(rows) and not reference
    shapes = shape_set in kinds_of_sets and (of_mode or FUNCTION_DATASET not in kinds_of_sets)
    sets: list[dict[str, Any]] = []
    for number, kind in enumerate(kinds_of_sets):
        if kind in (*NODES_DATASETS, UNITS_DATASET, shape_set if shapes else FUNCTION_DATASET):
            try:
                sets.append(file.read_sets(number))
            except Exception as error:
                raise InputError(f"set {number + 1} (data set {kind}): {error}") from None
    length = next(
        (float(dataset["length"]) for dataset in sets if dataset.get("type") == UNITS_DATASET), 1.0
    )
    position_of_node = {
        int(node): complex(x, y) / length
        for dataset in sets
        if dataset.get("type") in NODES_DATASETS
        for node, x, y in zip(dataset["node_nums"], dataset["x"], dataset["y"], strict=True)
    }
    if not position_of_node:
        raise InputError("no positions of nodes (data set 15 or 2411) are in it; export them too")
    if shapes:
        modes = [dataset for dataset in sets if dataset.get("type") == MODE_SHAPE_DATASET]
        modes += [
            _results_as_mode_shape(dataset)
            for dataset in sets
            if dataset.get("type") == RESULTS_DATASET
        ]
        return _scan_of_mode_shape(path, modes, position_of_node, frequency_hz, rows)
    if of_mode:
        raise InputError(
            "actuator.profile.rows is of tables, or, of a universal file, 'mode = 2' (data sets 55 "
            "and 2414) or 'reference = 5' (data set 58)"
        )
    wanted = reference[1] if reference else ""
    return _scan_at_frequency(path, sets, position_of_node, frequency_hz, reference=wanted)


def _results_as_mode_shape(results: dict[str, Any]) -> dict[str, Any]:
    """Results at nodes (data set 2414) with the names that mode shapes have."""
    mode = {"node_nums": results.get("node_nums"), "spec_data_type": results["result_type"]}
    if results["analysis_type"] == FREQUENCY_RESPONSE_ANALYSIS and "z" in results:
        names = {"r3": "z", "freq": "frequency", "mode_n": "frequency_number"}
        return mode | {name: results[own] for name, own in names.items()}
    if results["dataset_location"] != AT_NODES_LOCATION or "data_at_node" not in results:
        raise InputError("the results (data set 2414) are not displacements at nodes; export these")
    values = np.array(results["data_at_node"])
    motion = (
        values[:, 4] + 1j * values[:, 5]
        if results["data_type"] == COMPLEX_NUMBER_TYPE
        else values[:, 2]
    )
    names = {"freq": "record12_field2", "mode_n": "record10_field6"}
    return mode | {"r3": motion} | {name: results[own] for name, own in names.items()}


def _scan_of_mode_shape(
    path: Path,
    modes: Sequence[dict[str, Any]],
    position_of_node: dict[int, complex],
    frequency_hz: float,
    rows: str,
) -> Scan:
    """The mode shape at the actuator's frequency, or the one that is asked for."""
    lines_hz = np.array(
        [float(m["freq"]) if "freq" in m else abs(m["eig"].imag) / (2 * math.pi) for m in modes]
    )
    numbers = [int(mode.get("mode_n", mode.get("freq_step_n", 0))) for mode in modes]
    named = ", ".join(
        f"{number} at {line_hz:.7g} Hz" for number, line_hz in zip(numbers, lines_hz, strict=True)
    )
    name, _, wanted = (part.strip() for part in rows.lower().partition("="))
    asked = [at for at, number in enumerate(numbers) if name == "mode" and wanted == f"{number}"]
    away = np.abs(lines_hz / frequency_hz - 1)
    nearest, *others = np.argsort(away)
    raise_first_problem(
        f"its modes are {named}",
        {
            f"actuator.profile.rows: {rows!r} is none of them; say mode = NUMBER": rows
            and not asked,
            f"none is at {frequency_hz:.7g} Hz (actuator.frequency); say which by "
            "actuator.profile.rows: mode = NUMBER": not rows
            and away[nearest] > MAX_MODE_DISTANCE_FRACTION,
            f"several are near {frequency_hz:.7g} Hz (actuator.frequency); say which by "
            f"actuator.profile.rows: mode = {numbers[nearest]}": not rows
            and others
            and away[others[0]]
            < min(MIN_FREQUENCY_OFFSET_RATIO * away[nearest] + 1e-3, MAX_MODE_DISTANCE_FRACTION),
        },
    )
    at = asked[0] if asked else int(nearest)
    mode, power = modes[at], OMEGA_POWER_OF_DATA_TYPE.get(int(modes[at]["spec_data_type"]), 0)
    nodes = np.asarray(mode["node_nums"], dtype=int)
    known = np.isin(nodes, list(position_of_node))
    amplitude = np.asarray(mode["r3"])[known].astype(complex)
    amplitude /= (2 * math.pi * frequency_hz) ** power
    positions = np.array([position_of_node[node] for node in nodes[known]])
    signed = np.iscomplexobj(mode["r3"]) or bool(np.any(amplitude.real < 0))
    notes = [f"mode shape {numbers[at]} at {lines_hz[at]:.7g} Hz along z"]
    notes += [f"{np.sum(~known)} nodes without a place ignored"] * bool(np.any(~known))
    return Scan(
        path, positions.real, positions.imag, amplitude, nodes[known], 0, signed, tuple(notes)
    )


def _scan_at_frequency(
    path: Path,
    sets: Sequence[dict[str, Any]],
    position_of_node: dict[int, complex],
    frequency_hz: float,
    *,
    reference: str,
) -> Scan:
    """The shape that functions have at the actuator's frequency, of one reference."""
    omega = 2 * math.pi * frequency_hz
    every = [dataset for dataset in sets if dataset.get("type") == FUNCTION_DATASET]
    is_roving_hammer = (
        len({(function["rsp_node"], function["rsp_dir"]) for function in every}) == 1 < len(every)
    )
    if is_roving_hammer:
        every = [
            function | {own: function[other] for own, other in RECIPROCAL_KEYS.items()}
            for function in every
        ]
    functions = [
        function for function in every if abs(int(function["rsp_dir"])) == NORMAL_DIRECTION
    ] or every
    beside = [f"{len(every) - len(functions)} functions along x or y ignored"]
    beside *= len(functions) < len(every)
    functions, aside = _motion_functions(functions, position_of_node)
    functions = _functions_of_reference(functions, reference)
    nodes = [int(function["rsp_node"]) for function in functions]
    kinds = {int(function.get("ordinate_spec_data_type", 0)) for function in functions}
    raise_first_problem(
        "universal file",
        {
            "no functions (data set 58), mode shapes (55) or results (2414) are in it": not every,
            f"no function is a shape; {'; '.join(aside)}": not functions,
            "a node has several functions; export one, or that along z": len(set(nodes))
            < len(nodes),
            "the functions are not all displacements (type 8), velocities (11) or accelerations "
            f"(12) but of type {', '.join(map(str, sorted(kinds)))}": kinds
            not in [{kind} for kind in OMEGA_POWER_OF_DATA_TYPE],
        },
    )
    rows = [_amplitude_at_spectral_line(function, omega / (2 * math.pi)) for function in functions]
    measured, lines_hz = (np.array(column) for column in zip(*rows, strict=True))
    numbers, seen = 1 + np.arange(len(nodes)), np.isfinite(measured)
    amplitude = measured[seen].astype(complex) / omega ** OMEGA_POWER_OF_DATA_TYPE[min(kinds)]
    if kinds == {ACCELERATION_DATA_TYPE}:
        amplitude = -amplitude
    positions = np.array([position_of_node[node] for node in nodes])[seen]
    signed = np.iscomplexobj(measured) or bool(np.any(amplitude.real < 0))
    missing, bare = int(np.sum(~seen)), len(position_of_node) - len(nodes)
    notes = (
        *["one response: a shape over the references, by reciprocity"] * is_roving_hammer,
        *beside,
        *aside,
        f"read at {lines_hz.min():.7g} Hz",
        *[f"{bare} nodes without a function ignored"] * bool(bare),
        *missing_points_note(numbers[~seen].tolist(), what="function"),
    )
    return Scan(
        path, positions.real, positions.imag, amplitude, numbers[seen], missing, signed, notes
    )


def _motion_functions(
    functions: Sequence[dict[str, Any]], known_nodes: Collection[int]
) -> tuple[list[dict[str, Any]], list[str]]:
    """The functions that may be a shape, and a note for each kind of the others."""
    kept, aside = [], dict.fromkeys(("coherences", "power spectra", "functions without a place"), 0)
    for function in functions:
        kind = int(function.get("func_type", 0))
        if kind in COHERENCE_FUNCTION_TYPES:
            aside["coherences"] += 1
        elif kind in POWER_SPECTRUM_FUNCTION_TYPES and len(functions) > len(known_nodes):
            aside["power spectra"] += 1
        elif int(function["rsp_node"]) not in known_nodes:
            aside["functions without a place"] += 1
        else:
            kept.append(function)
    return kept, [f"{count} {name} ignored" for name, count in aside.items() if count]


def _functions_of_reference(
    functions: Sequence[dict[str, Any]], reference: str
) -> list[dict[str, Any]]:
    """The functions with the reference that is asked for, or all of them."""
    names = [
        f"{int(function['ref_node'])}{NAME_OF_DIRECTION.get(int(function['ref_dir']), '')}"
        for function in functions
    ]
    counts = Counter(names)
    listing = ", ".join(f"{name} ({count} functions)" for name, count in counts.items())
    asked = [name for name in counts if reference in (name, name.rstrip("+-XYZR"))]
    ways = f"its references are {listing}; take one by actuator.profile.rows: reference = "
    nodes = {int(function["rsp_node"]) for function in functions}
    if reference and len(asked) != 1:
        raise InputError(f"{reference!r} is not one of them: {ways}{min(counts, default='')}")
    if not reference and len(counts) > 1 and len(nodes) < len(functions):
        raise InputError(f"a node has several functions; {ways}{names[0]}")
    return [
        function
        for function, name in zip(functions, names, strict=True)
        if name in (asked or counts)
    ]


def _amplitude_at_spectral_line(
    function: dict[str, Any], frequency_hz: float
) -> tuple[complex | float, float]:
    """The amplitude at the line nearest to the frequency, and that line.

    It is NaN where the function is not finite there, or zero at all lines: nothing was measured.
    """
    lines, data = np.asarray(function["x"], dtype=float), np.asarray(function["data"])
    line_hz, far = nearest_spectral_line(lines, frequency_hz)
    nearest = int(np.argmax(lines == line_hz))
    kind, over = (int(function.get(key, 0)) for key in ("func_type", "abscissa_spec_data_type"))
    raise_first_problem(
        f"node {int(function['rsp_node'])}",
        {
            "a function of time or a power spectrum; export amplitudes or frequency responses": kind
            in TIME_OR_POWER_FUNCTION_TYPES
            or over != FREQUENCY_DATA_TYPE,
            far: far,
        },
    )
    seen = np.any(data) and np.abs(data[nearest]) <= MAX_FINITE_VALUE
    sign = math.copysign(1.0, int(function["rsp_dir"])) if seen else np.nan
    return sign * data[nearest], line_hz
