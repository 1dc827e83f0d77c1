"""Tables of films in use: the gaps that carry loads, and how forces follow a changing amplitude.

A row that could not be had keeps its place, with the reason as its ``status``.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, replace
from functools import partial
from math import nan
from typing import Any

import numpy as np
import pandas as pd

from squeezefilm.dynamics.levitation import Levitation, Resonance, levitate, resonance
from squeezefilm.dynamics.response import (
    MOST_MODULATION,
    gain_changes,
    gains,
    response,
    slip_changes,
    steps_of,
)
from squeezefilm.errors import InputError, RunError
from squeezefilm.film.scene import Scene
from squeezefilm.film.validity import validity
from squeezefilm.parallel import progress_bar
from squeezefilm.reynolds.device import Device
from squeezefilm.tables import read_forces

LEVITATION_COLUMNS = [
    "load_n",
    "hv_m",
    "h0_m",
    "h0_error_m",
    "h0_modelling_error_lower_m",
    "h0_modelling_error_upper_m",
    "others_m",
    "stiffness_n_per_m",
    "stiffness_error_n_per_m",
    "stable",
    "epsilon",
    "modified_reynolds",
    "inertia",
    "left_out_least_percent",
    "left_out_most_percent",
    "above_range",
    "status",
    "note",
]
LOADS, AMPLITUDES = 8, 3
"""Over the range of a table of forces."""
MASS_COLUMNS = ["resonance_hz", "damping_ratio"]


def loads_like(path: str) -> tuple[list[float], list[float]]:
    """Loads and amplitudes over the range of a table of forces.

    Raises InputError where no force is positive.
    """
    table = read_forces(path)
    known = table.loc[table["force_n"] > 0, "force_n"]
    if known.empty:
        raise InputError(f"{path}: has no force above 0")
    loads_n = np.geomspace(known.min(), known.max(), LOADS)
    levels = np.sort(table["hv_m"].unique())
    places = np.linspace(0, len(levels) - 1, AMPLITUDES).round().astype(int)
    return loads_n.tolist(), list(dict.fromkeys(levels[places].tolist()))


def levitations(
    scenes: Sequence[Scene],
    loads_n: Sequence[float],
    *,
    how: dict[str, Any],
    scan_error_n: Callable[[Scene], float],
    mass_kg: float | None = None,
) -> tuple[pd.DataFrame, Levitation | None, Resonance | None]:
    """A table with a row for each scene and load, whose gap is sought, and the last gap in full.

    Args:
        how: the settings of ``levitate``.
        scan_error_n: what the scan of a measured profile leaves open in a scene's force.
        mass_kg: that floats, for its resonance.
    """
    rows = []
    found = moving = None
    with progress_bar(len(loads_n) * len(scenes), unit="load", name="levitate") as bar:
        for scene in scenes:
            for load_n in loads_n:
                row: dict[str, object] = {"load_n": load_n, "hv_m": scene.hv_m}
                try:
                    found = levitate(scene, load_n=load_n, **how)
                    more_m = scan_error_n(found.scene) / abs(found.stiffness_n_per_m)
                    found = replace(found, h0_error_m=found.h0_error_m + more_m)
                    moving = None if mass_kg is None else resonance(found, mass_kg=mass_kg)
                    row |= _levitation_row(found, moving)
                except (InputError, RunError) as error:
                    row["status"] = str(error).removeprefix("load: ")
                rows.append(row)
                bar.update(1)
    columns = LEVITATION_COLUMNS + MASS_COLUMNS * (mass_kg is not None)
    return pd.DataFrame(rows).reindex(columns=columns), found, moving


def _levitation_row(found: Levitation, moving: Resonance | None) -> dict[str, object]:
    scene, budget = found.scene, found.budget
    least, most = budget.modelling_error_percent
    lower_m, upper_m = found.modelling_error_m
    of_another = [f"left out: of {budget.basis}"] if budget.basis else []
    row = {
        "h0_m": scene.h0_m,
        "h0_error_m": found.h0_error_m,
        "h0_modelling_error_lower_m": lower_m,
        "h0_modelling_error_upper_m": upper_m,
        "others_m": "; ".join(f"{each:.3g}" for each in found.others_m),
        "stiffness_n_per_m": found.stiffness_n_per_m,
        "stiffness_error_n_per_m": found.stiffness_error_n_per_m,
        "stable": found.stable,
        "epsilon": scene.epsilon,
        "modified_reynolds": scene.modified_reynolds,
        "inertia": scene.gas.inertia,
        "left_out_least_percent": least,
        "left_out_most_percent": most,
        "above_range": "; ".join(budget.above_range),
        "status": "ok",
        "note": "; ".join(
            filter(None, [*found.notes, *of_another, moving.reason if moving else ""])
        ),
    }
    if moving is not None:
        row |= {"resonance_hz": moving.frequency_hz, "damping_ratio": moving.damping_ratio}
    return row


def response_validity(scene: Scene) -> str:
    """That of the response's equation, which has neither inertia nor heat."""
    return validity(replace(scene, gas=replace(scene.gas, inertia="none", heat="none")))


def neglected(
    scenes: Sequence[Scene], *, tolerance: float, device: Device
) -> list[dict[str, float]]:
    """Changes in % of the scenes' responses by what the averaged film neglects, by columns."""
    by_gas = gain_changes(scenes, tolerance=tolerance, device=device)
    return [slip_changes(scene) | row for scene, row in zip(scenes, by_gas, strict=True)]


def responses(
    table: pd.DataFrame, scenes: Sequence[Scene], *, tolerance: float, device: Device
) -> pd.DataFrame:
    """The table with the response of each scene."""
    rows: list[dict[Any, Any]] = []
    with progress_bar(len(scenes), unit="scene", name="response") as bar:
        for scene in scenes:
            rows.append(_or_reason(partial(response, scene)))
            bar.update(1)
    known = [k for k, row in enumerate(rows) if row["status"] == "ok"]
    found = neglected([scenes[k] for k in known], tolerance=tolerance, device=device)
    for k, changes in zip(known, found, strict=True):
        rows[k] |= changes
    valid = [response_validity(scene) for scene in scenes]
    return pd.concat([table.assign(validity=valid), pd.DataFrame(rows)], axis=1)


def all_gains(
    table: pd.DataFrame, scenes: Sequence[Scene], frequency_hz: np.ndarray
) -> pd.DataFrame:
    """The table with a row for each scene and frequency: gain and phase."""
    unknown = dict.fromkeys(("gain", "phase_deg", "error"), nan)

    def found(scene: Scene) -> pd.DataFrame:
        slow = frequency_hz <= MOST_MODULATION * scene.actuator.frequency_hz
        parts = [
            pd.DataFrame(_or_reason(partial(gains, scene, some), frequency_hz=some, **unknown))
            for some in (frequency_hz[slow], frequency_hz[~slow])
            if some.size
        ]
        return pd.concat(parts, ignore_index=True)

    return _behind(table, scenes, found)


def all_steps(table: pd.DataFrame, scenes: Sequence[Scene]) -> pd.DataFrame:
    """The table with a row for each scene and time: the mean force after start and stop."""
    unknown = {name: [nan] for name in ("time_s", "rising_n", "falling_n")}
    return _behind(
        table,
        scenes,
        lambda scene: pd.DataFrame(_or_reason(partial(steps_of, scene), **unknown)),
    )


def _behind(
    table: pd.DataFrame, scenes: Sequence[Scene], found: Callable[[Scene], pd.DataFrame]
) -> pd.DataFrame:
    """Each row of the table, with its validity, beside each row that is found for its scene."""
    parts = []
    for row, scene in zip(table.to_dict(orient="records"), scenes, strict=True):
        rows = found(scene)
        same = pd.DataFrame([row | {"validity": response_validity(scene)}] * len(rows))
        parts.append(pd.concat([same, rows], axis=1))
    return pd.concat(parts, ignore_index=True)


def _or_reason(find: Callable[[], Any], **unknown: Any) -> dict[Any, Any]:
    """What is found, with status ``ok``; or what is unknown, with the reason as its status."""
    try:
        return {**asdict(find()), "status": "ok"}
    except (InputError, RunError) as error:
        return {**unknown, "status": str(error)}
