"""A smoothed scan as a file: smoothing takes up to a minute, reading what came of it no time."""

import hashlib
import json
from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np

from squeezefilm.film.vibration.scans import SmoothedScan
from squeezefilm.film.vibration.shapes import Modes
from squeezefilm.film.vibration.surfaces import Surface
from squeezefilm.film.vibration.vibrometer import Scan
from squeezefilm.io.atomic import digest, whole_file
from squeezefilm.io.errors import InputError

ARRAYS = ("x_m", "y_m", "measured_m", "residual_m", "outliers", "root")
OF_MODES = ("orders", "coefficients", "largest")
OF_SCAN = ("x_m", "y_m", "amplitude_m", "lines")
NUMBERS = ("peak_m", "peak_bias_m", "noise_m", "quadrature", "degree", "folded")


def write_smoothed(smoothed: SmoothedScan, path: Path, *, settings: Mapping[str, Any]) -> None:
    """Write all of a smoothed scan, whole or not at all; equal ones make equal files.

    Args:
        settings: with which it was smoothed (scans.smoothed_scan).

    Raises InputError where the file cannot be written.
    """
    scan = smoothed.scan
    facts = {
        "made_from": _made_from(scan.path, settings),
        **{name: getattr(smoothed, name) for name in NUMBERS},
        "scores": list(smoothed.scores.items()),
        "profile": _plain(smoothed.profile),
        "out_of_phase": _plain(smoothed.out_of_phase),
        "missing": scan.missing,
        "signed": scan.signed,
        "notes": scan.notes,
        "cell_m": scan.cell_m,
    }
    arrays = {name: getattr(smoothed, name) for name in ARRAYS}
    arrays |= {f"scan_{name}": getattr(scan, name) for name in OF_SCAN if name != "y_m"}
    if scan.y_m is not None:
        arrays["scan_y_m"] = scan.y_m
    with whole_file(path) as part, part.open("wb") as handle:
        np.savez(handle, facts=np.array(json.dumps(facts)), **arrays)


@lru_cache(maxsize=4)
def _read(path: Path, changed_ns: int) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    try:
        with np.load(path, allow_pickle=False) as file:
            arrays = {name: file[name] for name in file.files}
        return json.loads(str(arrays.pop("facts"))), arrays
    except (OSError, ValueError, KeyError, BadZipFile, EOFError) as error:
        raise InputError(f"{path}: not a smoothed scan: {error}") from None


def read_smoothed(path: Path, scan: Path, *, settings: Mapping[str, Any]) -> SmoothedScan:
    """What write_smoothed wrote, for a scan's file.

    Raises InputError for a file that is none, or was made from another scan or other settings.
    """
    facts, arrays = _read(path, path.stat().st_mtime_ns)
    if facts["made_from"] != _made_from(scan, settings):
        raise InputError(
            f"{path}: was smoothed from another {scan.name}, or with other settings of "
            "actuator.profile; `snakemake profile` makes it anew"
        )
    numbers: dict[str, Any] = {name: facts[name] for name in NUMBERS}
    values: dict[str, Any] = {name: arrays[name] for name in ARRAYS}
    return SmoothedScan(
        scan=Scan(
            path=scan,
            y_m=arrays.get("scan_y_m"),
            **{name: arrays[f"scan_{name}"] for name in OF_SCAN if name != "y_m"},
            missing=facts["missing"],
            signed=facts["signed"],
            notes=tuple(facts["notes"]),
            cell_m=facts["cell_m"],
        ),
        profile=_modes(facts["profile"], settings["surface"]),
        out_of_phase=_modes(facts["out_of_phase"], settings["surface"]),
        scores={int(degree): score for degree, score in facts["scores"]},
        **numbers,
        **values,
    )


def _plain(modes: Modes) -> dict[str, Any]:
    """Modes as plain values, but for the surface, which is one of the settings."""
    return {name: getattr(modes, name) for name in OF_MODES}


def _modes(plain: Mapping[str, Any], surface: Surface) -> Modes:
    orders = tuple((int(n), int(m)) for n, m in plain["orders"])
    return Modes(orders, tuple(plain["coefficients"]), surface, largest=plain["largest"])


def _made_from(scan: Path, settings: Mapping[str, Any]) -> str:
    text = json.dumps(dict(settings), sort_keys=True, default=repr)
    return hashlib.sha256(f"{digest(scan)} {text}".encode()).hexdigest()
