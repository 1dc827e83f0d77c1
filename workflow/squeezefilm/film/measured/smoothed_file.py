"""A smoothed scan kept in a file: smoothing takes up to a minute, reading no time.

The file, NumPy's .npz, has an array for each value and holds no code.
"""

from __future__ import annotations

from dataclasses import fields
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from squeezefilm.errors import InputError
from squeezefilm.files import atomic_file, file_digest
from squeezefilm.film.measured.mode_fit import ModeFit
from squeezefilm.film.measured.scan import Scan
from squeezefilm.film.measured.smooth import SmoothedScan
from squeezefilm.film.profiles import ModeSum, ScanFile
from squeezefilm.film.surfaces import Surface

KIND_OF_PART = {"scan": Scan, "profile": ModeSum, "out_of_phase": ModeSum, "fit": ModeFit}
"""Parts of a smoothed scan, whose values are stored behind the part's name."""
GIVEN_FIELDS = ("path", "surface")
"""What a reader knows already."""
TUPLE_FIELDS = ("notes", "origin_m", "orders", "coefficients")
"""Values of parts that are tuples where others are arrays."""


def write_smoothed_scan(
    smoothed: SmoothedScan, path: Path, settings: ScanFile, surface: Surface, *, frequency_hz: float
) -> None:
    """Write a smoothed scan, whole or not at all.

    Args:
        settings, surface, frequency_hz: with which it was smoothed (``smoothed_scan_of_file``).

    Raises InputError where the file cannot be written.
    """
    values = {name: getattr(smoothed, name) for name in _field_names(SmoothedScan)}
    for part, kind in KIND_OF_PART.items():
        whole = values.pop(part)
        values |= {f"{part}.{name}": getattr(whole, name) for name in _field_names(kind)}
    made_from = _fingerprint(smoothed.scan.path, settings, surface, frequency_hz)
    with atomic_file(path) as unfinished, unfinished.open("wb") as file:
        np.savez(file, allow_pickle=False, made_from=made_from, **values)


@lru_cache(maxsize=4)
def read_smoothed_scan(
    path: Path, scan: Path, settings: ScanFile, surface: Surface, *, frequency_hz: float
) -> SmoothedScan:
    """Return the smoothed scan that ``write_smoothed_scan`` wrote.

    Raises InputError for a file that is none, or was made from another scan or other settings.
    """
    try:
        with np.load(path, allow_pickle=False) as file:
            values = {name: each if each.ndim else each.item() for name, each in file.items()}
        made_from = values.pop("made_from")
        given: dict[type, dict[str, Any]] = {Scan: {"path": scan}, ModeSum: {"surface": surface}}
        for part, kind in KIND_OF_PART.items():
            stored = {name: values.pop(f"{part}.{name}") for name in _field_names(kind)}
            for name in stored.keys() & {*TUPLE_FIELDS}:
                stored[name] = _as_tuple(stored[name].tolist())
            values[part] = kind(**given.get(kind, {}), **stored)
        smoothed = SmoothedScan(**values)
    except Exception as error:  # whatever a damaged file makes of it
        raise InputError(f"{path}: not a smoothed scan: {error}") from None
    if made_from != _fingerprint(scan, settings, surface, frequency_hz):
        raise InputError(
            f"{path}: was smoothed from another {scan.name}, or with other settings of "
            "actuator.profile; `snakemake profile` updates it"
        )
    return smoothed


def _field_names(kind: Any) -> list[str]:
    return [field.name for field in fields(kind) if field.name not in GIVEN_FIELDS]


def _as_tuple(values: list[Any]) -> tuple[Any, ...]:
    return tuple(tuple(value) if isinstance(value, list) else value for value in values)


def _fingerprint(scan: Path, settings: ScanFile, surface: Surface, frequency_hz: float) -> str:
    return f"{file_digest(scan)} {settings} {surface} {frequency_hz}"
