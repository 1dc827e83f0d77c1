"""The patterns that searches for a D-optimal design ended in, for Figures 9 to 11."""

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from reporting.figures.parts import plane, style
from reporting.figures.parts.tables import Inputs, add_limits, micrometres
from reporting.pages.notes import one_digit
from squeezefilm.io.errors import InputError
from squeezefilm.io.tables import read_json, read_scenes


def patterns_found(path: Path) -> tuple[str, int, dict[str, list[dict[str, Any]]]]:
    """The study's own scaling, the number of searches, and the patterns of each scaling.

    Raises InputError naming the file and the entry that is missing.
    """
    summary = read_json(path)
    try:
        return summary["scaling"], int(summary["searches"]), dict(summary["scalings"])
    except (KeyError, TypeError, ValueError) as error:
        raise InputError(f"{path}: not a summary of searches: {error} is missing") from None


def pattern_table(inputs: Inputs, *, order: int) -> pd.DataFrame:
    """Data of one pattern of the study's own scaling, the best being of order 0.

    Layers design (its points) and ridge (equal hv/h0 through a point, within the space); where
    there are fewer patterns, a row of layer absent.
    """
    screen = read_scenes(inputs["plan"])
    scaling, searches, scalings = patterns_found(inputs["summary"])
    patterns = scalings[scaling]
    columns = ["layer", "epsilon", "h0_um", "hv_um"]
    if order >= len(patterns):
        found = ", ".join(f"{each['pattern']} ({each['count']})" for each in patterns)
        note = f"All {searches} searches ended in other patterns: {found}."
        data = pd.DataFrame([{"layer": "absent"}], columns=columns)
        return add_limits(data, screen).assign(note=note)
    pattern = patterns[order]
    rows = []
    for point in pattern["points"]:
        epsilon = point["hv_m"] / point["h0_m"]
        rows.append(("design", epsilon, point["h0_m"], point["hv_m"]))
        lowest = max(screen["h0_m"].min(), screen["hv_m"].min() / epsilon)
        highest = min(screen["h0_m"].max(), screen["hv_m"].max() / epsilon)
        rows += [
            ("ridge", epsilon, h0_m, epsilon * h0_m) for h0_m in np.linspace(lowest, highest, 11)
        ]
    data = pd.DataFrame(rows, columns=columns)
    data["h0_um"], data["hv_um"] = micrometres(data["h0_um"]), micrometres(data["hv_um"])
    behind = pattern["objective_excess"] / patterns[0]["objective"]
    rank = "the least" if order == 0 else f"{one_digit(behind)} above that of A, in proportion"
    note = (
        f"Pattern {pattern['pattern']}: {pattern['count']} of {searches} searches on criterion "
        f"(12); O = {pattern['objective']:.7g}, {rank}; "
        f"D-efficiency {pattern['d_efficiency']:.6f}. "
        "Dashed: equal hv/h0, along which the model does not change, so that the distances of "
        "(12) alone tell points apart."
    )
    return add_limits(data, screen).assign(note=note)


def draw(data: pd.DataFrame) -> Figure:
    """One pattern: layers design (three dots) and ridge (the line of equal hv/h0 through each).

    Without a row of the layer design the plane stays empty and says so.
    """
    figure = style.new_figure()
    axes = figure.subplots()
    for _, line in style.rows(data, "ridge").groupby("epsilon"):
        axes.plot(line["h0_um"], line["hv_um"], color="0.55", linestyle=(0, (4, 2)), linewidth=0.9)
    design = style.rows(data, "design")
    plane.dots(axes, design, fill="black", markersize=6, zorder=3)
    plane.set_up(axes, data, headroom=0.3)
    labels = [
        f"({h0:.3g}, {hv:.3g}) µm\n$h_v/h_0$ = {epsilon:.3f}"
        for h0, hv, epsilon in zip(design["h0_um"], design["hv_um"], design["epsilon"], strict=True)
    ]
    plane.label_points(axes, design, labels=labels)
    if design.empty:
        axes.text(
            0.5,
            0.5,
            "no such pattern:\nall searches ended in the\npatterns shown before",
            transform=axes.transAxes,
            ha="center",
            va="center",
        )
    style.add_note(figure, data)
    return figure
