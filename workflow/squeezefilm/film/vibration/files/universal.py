"""Universal files (.uff, .unv), as vibrometers export them: one function a point, data set 58.

Read by pyuff. Points are those of data set 15 or 2411, in the units of data set 164; of each
function the line at the actuator's frequency is taken.
"""

import importlib
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from squeezefilm.io.errors import InputError

SUFFIXES = (".uff", ".unv", ".uf", ".bunv")
NODES, UNITS, FUNCTION = (15, 2411), 164, 58
FREQUENCY = 18
"""Of the abscissa (abscissa_spec_data_type)."""
DISPLACEMENT, VELOCITY = 8, 11
TIME_RESPONSE, POWER_SPECTRA = 1, (2, 3, 9)
NORMAL = 3
"""The direction z, in which the surface vibrates."""
LARGEST = 1e9
"""In the file's unit. Writers of the format, pyuff too, put 0 for NaN and 1.8e308 for infinity."""
FARTHEST_LINE = 0.6
"""From the frequency, in distances between lines; of a file with one line as a share of it …"""
FARTHEST_SHARE = 0.01


@dataclass(frozen=True)
class Measured:
    """Points in metres and the complex amplitude there, in metres or in metres a second.

    The amplitude is NaN where there is none.
    """

    x_m: np.ndarray
    y_m: np.ndarray
    amplitude: np.ndarray
    is_velocity: bool
    has_phase: bool
    notes: list[str]


def read_universal(path: Path, *, frequency_hz: float) -> Measured:
    """The points of a universal file and their amplitudes at a frequency.

    Raises InputError naming the file and what it lacks.
    """
    reader = _pyuff()
    if not path.is_file():
        raise InputError(f"{path}: there is no such scan")
    try:
        sets = reader.UFF(str(path)).read_sets()
    except Exception as error:  # whatever a damaged file makes of it
        raise InputError(f"{path}: not a universal file that pyuff reads: {error}") from None
    sets = sets if isinstance(sets, list) else [sets]
    places = _places(sets, path=path)
    functions = _normal([each for each in sets if each.get("type") == FUNCTION], path=path)
    rows = [_amplitude(each, frequency_hz=frequency_hz, path=path) for each in functions]
    nodes = [int(each["rsp_node"]) for each in functions]
    for node in nodes:
        if node not in places:
            raise InputError(f"{path}: the node {node} of a function has no place (data set 15)")
    if len(set(nodes)) < len(nodes):
        twice = next(node for node in nodes if nodes.count(node) > 1)
        raise InputError(f"{path}: node {twice} has several functions; export one for each point")
    x_m, y_m = np.array([places[node] for node in nodes]).T
    amplitude = np.array([value for value, _ in rows])
    lines = sorted({line for _, line in rows})
    kind = {int(each.get("ordinate_spec_data_type", 0)) for each in functions}
    if kind not in ({DISPLACEMENT}, {VELOCITY}):
        raise InputError(
            f"{path}: the functions are neither displacements (type 8) nor velocities (11) but of "
            f"type {', '.join(map(str, sorted(kind)))}"
        )
    return Measured(
        x_m=x_m,
        y_m=y_m,
        amplitude=amplitude,
        is_velocity=kind == {VELOCITY},
        has_phase=bool(np.iscomplexobj(amplitude)),
        notes=[f"read at {lines[0]:.7g} Hz"],
    )


def _pyuff() -> ModuleType:
    try:
        return importlib.import_module("pyuff")
    except ImportError:
        raise InputError(
            "universal files are read by pyuff, which is not installed here: `pip install pyuff`, "
            "or export the scan as text"
        ) from None


def _places(sets: list[dict[str, Any]], *, path: Path) -> dict[int, tuple[float, float]]:
    """x_m and y_m of each node."""
    length = next((float(each["length"]) for each in sets if each.get("type") == UNITS), 1.0)
    places = {}
    for each in sets:
        if each.get("type") in NODES:
            for node, x, y in zip(each["node_nums"], each["x"], each["y"], strict=True):
                places[int(node)] = (float(x) / length, float(y) / length)
    if not places:
        raise InputError(f"{path}: no places of points (data set 15 or 2411) are in the file")
    return places


def _normal(functions: list[dict[str, Any]], *, path: Path) -> list[dict[str, Any]]:
    """The functions along z; all of them where there is one direction."""
    directions = {abs(int(each["rsp_dir"])) for each in functions}
    if not functions:
        raise InputError(f"{path}: no functions (data set 58) are in the file")
    if len(directions) > 1 and NORMAL not in directions:
        raise InputError(f"{path}: the functions have several directions, and none is along z")
    wanted = NORMAL if len(directions) > 1 else directions.pop()
    return [each for each in functions if abs(int(each["rsp_dir"])) == wanted]


def _amplitude(
    function: dict[str, Any], *, frequency_hz: float, path: Path
) -> tuple[complex | float, float]:
    """The amplitude at the line nearest to the frequency, and that line.

    It is NaN where the function is not finite there, or zero at all lines: nothing was measured.
    """
    node, kind = int(function["rsp_node"]), int(function.get("func_type", 0))
    where = f"{path}: node {node}"
    if kind == TIME_RESPONSE or int(function.get("abscissa_spec_data_type", 0)) != FREQUENCY:
        raise InputError(f"{where}: a function of time; export spectra or frequency responses")
    if kind in POWER_SPECTRA:
        raise InputError(f"{where}: a power spectrum; export amplitudes or frequency responses")
    lines, data = np.asarray(function["x"], dtype=float), np.asarray(function["data"])
    nearest = int(np.argmin(np.abs(lines - frequency_hz)))
    apart = float(np.diff(lines).max()) if len(lines) > 1 else 0.0
    farthest = FARTHEST_LINE * apart if apart else FARTHEST_SHARE * frequency_hz
    if abs(lines[nearest] - frequency_hz) > farthest:
        raise InputError(
            f"{where}: its lines go from {lines.min():.7g} to {lines.max():.7g} Hz, and the "
            f"actuator vibrates at {frequency_hz:.7g} Hz (actuator.frequency)"
        )
    sign = -1 if int(function["rsp_dir"]) < 0 else 1
    if not (np.any(data) and np.abs(data[nearest]) <= LARGEST):
        return np.nan * data[nearest], float(lines[nearest])
    return sign * data[nearest], float(lines[nearest])
