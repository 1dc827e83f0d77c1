"""Levitations over loads and amplitudes, as rows of a table."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import product
from typing import Any, NamedTuple

import numpy as np

from squeezefilm.dynamics.levitation import Levitation, levitate
from squeezefilm.dynamics.resonance import resonance
from squeezefilm.errors import InputError, RunError
from squeezefilm.film.positions import CARTESIAN_COLUMNS
from squeezefilm.film.scene import Scene
from squeezefilm.formatting import position_row, scene_row
from squeezefilm.lazy import pd
from squeezefilm.parallel import track_progress
from squeezefilm.quantities.model_error import budget_row
from squeezefilm.tables import read_forces

# Loads and amplitudes over the range of a table of forces.
TABLE_LOAD_COUNT, TABLE_AMPLITUDE_COUNT = 8, 4

# Of a table of levitations, between the load and its status.
LEVITATION_COLUMNS: dict[str, Callable[[Levitation], object]] = {
    "h0_m": lambda part: part.scene.h0_m,
    "h0_error_m": lambda part: part.h0_error_m,
    "h0_modelling_error_lower_m": lambda part: part.modelling_error_m[0],
    "h0_modelling_error_upper_m": lambda part: part.modelling_error_m[1],
    "other_gaps_m": lambda part: "; ".join(f"{each:.3g}" for each in part.other_gaps_m),
    "stiffness_n_per_m": lambda part: part.stiffness_n_per_m,
    "stiffness_error_n_per_m": lambda part: part.stiffness_error_n_per_m,
    "stable": lambda part: part.is_stable,
    "epsilon": lambda part: part.scene.epsilon,
    "modified_reynolds": lambda part: part.scene.modified_reynolds,
    "inertia": lambda part: part.scene.gas.inertia,
    "modelling_error_lower_percent": lambda part: part.budget.modelling_error_percent[0],
    "modelling_error_upper_percent": lambda part: part.budget.modelling_error_percent[1],
    "unknown_effects": lambda part: "; ".join(part.budget.unknown_effect_names),
}


class Load(NamedTuple):
    """A load on a film, and its mass.

    Attributes:
        force_n: weight, or another force.
        mass_kg: levitated mass, for its resonance; None where there is none.
    """

    force_n: float
    mass_kg: float | None = None


RESONANCE_COLUMNS = ("resonance_hz", "resonance_error_hz", "damping_ratio", "damping_ratio_error")


def loads_and_amplitudes_of_table(path: str) -> tuple[list[float], list[float]]:
    """Loads and amplitudes over the range of a table of forces.

    Raises InputError where no force is positive.
    """
    table = read_forces(path)
    known = table.loc[table["force_n"] > 0, "force_n"]
    if known.empty:
        raise InputError(f"{path}: has no force above 0")
    loads_n = np.geomspace(known.min(), known.max(), TABLE_LOAD_COUNT)
    levels = np.sort(table["hv_m"].unique())
    level_rows = np.linspace(0, len(levels) - 1, TABLE_AMPLITUDE_COUNT).round().astype(int)
    return loads_n.tolist(), list(dict.fromkeys(levels[level_rows].tolist()))


def levitation_rows(
    scenes: Sequence[Scene],
    loads: Sequence[Load],
    *,
    how: dict[str, Any],
    scan_error_n: Callable[[Scene], float],
) -> Iterator[dict[str, object]]:
    """Rows of a table of levitations, as they are known: for each scene and load, its gap sought.

    Args:
        how: the settings of ``levitate``.
        scan_error_n: uncertainty of a scene's force by the noise of a measured profile.
    """
    with track_progress(len(loads) * len(scenes), unit="load", name="levitate") as bar:
        for scene, (load_n, mass_kg) in product(scenes, loads):
            row: dict[str, object] = {} if mass_kg is None else {"mass_kg": mass_kg}
            row |= {"load_n": load_n, "hv_m": scene.hv_m, **position_row(scene)}
            try:
                levitation = levitate(scene, load_n=load_n, **how)
                noise_m = scan_error_n(levitation.scene) / abs(levitation.stiffness_n_per_m)
                notes = [*levitation.notes]
                row |= scene_row(levitation.scene) | budget_row(levitation.budget)
                row |= {name: of(levitation) for name, of in LEVITATION_COLUMNS.items()}
                row |= {
                    "budget_status": levitation.budget.status,
                    "h0_measurement_noise_m": noise_m,
                }
                if mass_kg is not None:
                    *motion, reason = resonance(levitation, mass_kg=mass_kg)
                    row |= dict(zip(RESONANCE_COLUMNS, motion, strict=True))
                    notes += [reason] * bool(reason)
                row |= {"status": "ok", "note": "; ".join(notes)}
            except (InputError, RunError) as error:
                row["status"] = str(error).removeprefix("load: ")
            yield row
            bar.update(1)


def levitation_table(rows: Iterable[dict[str, object]]) -> pd.DataFrame:
    """A table of ``levitation_rows``, without the columns of dimensionless numbers and effects."""
    columns = ["load_n", "hv_m", *CARTESIAN_COLUMNS]
    columns += [*LEVITATION_COLUMNS, "h0_measurement_noise_m", "status", "note"]
    table = pd.DataFrame(rows)
    if "mass_kg" in table:
        columns = ["mass_kg", *columns, *RESONANCE_COLUMNS]
    return table.reindex(columns=columns)
