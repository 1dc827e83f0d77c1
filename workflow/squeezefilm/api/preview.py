"""What ``simulate --dry-run`` shows: how scenes would be solved, as a table and in words."""

from __future__ import annotations

from collections.abc import Sequence

import pandas as pd

from squeezefilm.film.scene import Scene
from squeezefilm.film.validity import OK, validity
from squeezefilm.quantities.outputs import refusals
from squeezefilm.reynolds.device import Device
from squeezefilm.reynolds.solver import Preview, previews
from squeezefilm.reynolds.terms import notes_of
from squeezefilm.studies.solver_settings import SolverSettings

ALIKE = ["method", "domain", "terms", "left_out"]


def preview_table(
    scenes: Sequence[Scene], *, settings: SolverSettings, device: Device
) -> pd.DataFrame:
    """A row for each scene: its numbers, method, domain, terms and first grid, nothing solved.

    But for what decides on terms that are ``auto``: a state on a coarse grid.
    """
    scenes = settings.resolved(scenes, device)
    found = previews(scenes, tolerance=settings.tolerance, method=settings.method)
    table = pd.DataFrame([_row(*each) for each in zip(scenes, found, strict=True)])
    if settings.outputs:
        table["outputs_refused"] = [_asked_in_vain(scene, settings) for scene in scenes]
    return table


def preview_text(table: pd.DataFrame, *, tolerance: float) -> str:
    """A table of previews in words: one scene by itself, several by how they are treated."""
    if len(table) == 1:
        row = table.iloc[0].drop(["point_id", "left_out"])
        shown = {
            name: f"{value:.4g}" if isinstance(value, float) else str(value)
            for name, value in row.items()
        }
        wide = max(map(len, map(str, shown)))
        return "\n".join(f"{name:{wide}}  {value}" for name, value in shown.items() if value)
    kinds = table.assign(scenes=1).groupby(ALIKE, sort=False, as_index=False)
    summary = kinds.agg(
        scenes=("scenes", "sum"),
        **{name: (name, "max") for name in ("nx", "ny", "nt", "expected_error")},
        expected_mflop=("expected_mflop", "sum"),
    )
    lines = [f"{len(table)} scenes at tolerance {tolerance:g}:", ""]
    lines.append(summary.to_string(index=False, float_format=lambda value: f"{value:.3g}"))
    for column, what in (
        ("status", "end otherwise than ok"),
        ("validity", "are outside the limits of validity"),
        ("outputs_refused", "lack outputs"),
        ("notes", "carry notes"),
    ):
        if column in table:
            some = table[~table[column].isin(["", OK])]
            lines += [
                f"{len(alike)} scenes {what}, such as point {alike['point_id'].iloc[0]}: {words}"
                for words, alike in some.groupby(column, sort=False)
            ]
    return "\n".join(lines)


def _asked_in_vain(scene: Scene, settings: SolverSettings) -> str:
    """The outputs that a scene will not have, or not whole, and why."""
    found = refusals(scene, tolerance=settings.tolerance)
    return "; ".join(f"{name}: {found[name]}" for name in settings.outputs if name in found)


def _row(scene: Scene, preview: Preview) -> dict[str, object]:
    numbers = ("point_id", "epsilon", "sigma", "bearing_number", "knudsen", "modified_reynolds")
    left_out = [(part.what, f"{part.what}: {part.why}") for part in preview.left_out]
    return {
        **{name: getattr(scene, name) for name in numbers},
        "method": preview.method,
        "status": preview.status,
        "validity": validity(scene),
        "domain": preview.domain,
        "terms": "; ".join(preview.terms),
        **{name: getattr(preview, name) for name in ("nx", "ny", "nt")},
        "left_out": "; ".join(what for what, _ in left_out),
        "why": "; ".join(why for _, why in left_out),
        "expected_error": preview.expected_error,
        "expected_mflop": preview.expected_mflop,
        "notes": "; ".join(notes_of(scene)),
    }
