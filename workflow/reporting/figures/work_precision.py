"""Error against run time: relative error of the force by processor time.

Relative error of the mean force over processor time, a panel for each film, a line for each method
refined along its own path; to the lower left is better. The reference shares nothing with any
method; no error can be seen below the grey band. Inside the orange band the error is larger than
that of the fitted empirical model.
"""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from reporting.figures.parts import style

INPUTS = {
    "table": "numerics/work_precision.csv",
}
COLUMNS = (
    "scene",
    "method",
    "path",
    "batch",
    "start",
    "relative_error",
    "reference_uncertainty",
    "cpu_seconds",
    "model_error",
    "note",
)
SKY = "#56B4E9"
CHOSEN = "method chosen by the solver"
OWN = "periodic state, OpenCL"
# (method, path, batched) → colour, marker, line, label
STYLES: dict[tuple[str, str, bool], tuple[str, str, str, str]] = {
    (CHOSEN, "tolerance", False): ("black", "o", "-", "this solver, by tolerance"),
    (CHOSEN, "tolerance", True): ("black", "o", ":", "… in a batch"),
    (OWN, "tolerance", False): (style.BLUE, "d", "-", "periodic state, by tolerance"),
    (OWN, "tolerance", True): (style.BLUE, "d", ":", "… in a batch "),
    (OWN, "balanced", False): (SKY, "s", "-", "periodic state, given grid"),
    (OWN, "balanced", True): (SKY, "s", ":", "… in a batch  "),
    (OWN, "space", False): (SKY, "^", "--", "… refined in space alone"),
    (OWN, "time", False): (SKY, ">", "--", "… refined in time alone"),
    ("fast-limit", "no setting", False): ("black", "P", "", "limit σ → ∞"),
    ("boundary-layer", "no setting", False): ("black", "*", "", "… with boundary layer"),
    ("small-amplitude", "no setting", False): ("black", "X", "", "limit ε → 0"),
    ("matched-limit", "no setting", False): ("black", "p", "", "both limits matched"),
    ("time march, OpenCL", "tolerance", False): (
        "#8C510A",
        "8",
        "-",
        "time march, OpenCL",
    ),
    ("periodic state, NumPy", "balanced", False): (
        style.GREY,
        "D",
        "-",
        "same algorithm, NumPy, no symmetry",
    ),
    ("Chebyshev, Radau, Anderson", "balanced", False): (
        style.GREEN,
        "v",
        "-",
        "Chebyshev, Radau, Anderson",
    ),
    ("finite elements, Crank–Nicolson, Anderson", "balanced", False): (
        style.ORANGE,
        "<",
        "-",
        "finite elements, CN, Anderson",
    ),
    ("finite elements, Crank–Nicolson from rest", "balanced", False): (
        style.VERMILLION,
        "p",
        "-",
        "finite elements, CN from rest",
    ),
    ("finite elements, Crank–Nicolson from rest, FreeFEM", "balanced", False): (
        style.VERMILLION,
        "P",
        "--",
        "finite elements, CN from rest, FreeFEM",
    ),
    ("finite volumes, BDF from rest", "balanced", False): (
        style.PURPLE,
        "h",
        "-",
        "finite volumes, BDF from rest",
    ),
}


def draw(data: pd.DataFrame) -> Figure:
    """Lines are paths of refinement when warm; cold starts are in the table alone.

    Bands: above, errors larger than the empirical model's own; below, the reference's uncertainty.
    """
    warm = data[(data["start"] == "warm") & (data["relative_error"] < np.inf)]
    scenes = list(dict.fromkeys(warm["scene"]))
    columns = min(4, len(scenes))
    rows = -(-len(scenes) // columns)
    figure = style.new_figure(
        width_in=style.DOUBLE_COLUMN_IN, height_in=1.0 + (1.9 if rows > 1 else 2.4) * rows
    )
    axes = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
    lowest = 0.2 * float(warm["reference_uncertainty"].min())
    seconds = warm["cpu_seconds"]
    for panel in axes.ravel()[len(scenes) :]:
        panel.set_visible(False)
    for panel, scene in zip(axes.ravel(), scenes, strict=False):
        _panel(panel, warm[warm["scene"] == scene], lowest=lowest)
        panel.set_title(scene, fontsize=7)
        panel.set_xlim(0.5 * seconds.min(), 2 * seconds.max())
        panel.set_ylim(lowest, 1)
    for panel in axes[-1]:
        panel.set_xlabel("processor time per film (s)")
    for panel in axes[:, 0]:
        panel.set_ylabel("relative error of the force")
    handles = dict(zip(*reversed(panel_handles(axes.ravel()[: len(scenes)].tolist())), strict=True))
    figure.legend(
        [*handles.values(), Patch(color="#FBE3D0"), Patch(color="0.85")],
        [*handles, "error above the empirical model's own", "uncertainty of the reference"],
        loc="outside upper center",
        ncols=3,
        fontsize=6.5,
    )
    style.add_note(figure, data)
    return figure


def panel_handles(panels: list[Axes]) -> tuple[list[object], list[str]]:
    """Handles and labels of all panels in the order of STYLES; a label stands once."""
    found: dict[object, object] = {}
    for panel in panels:
        for handle, label in zip(*panel.get_legend_handles_labels(), strict=True):
            found.setdefault(label, handle)
    return list(found.values()), [str(label) for label in found]


def _panel(axes: Axes, data: pd.DataFrame, *, lowest: float) -> None:
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.grid(True)
    model_error = float(data["model_error"].iloc[0])
    floor = float(data["reference_uncertainty"].iloc[0])
    axes.axhspan(model_error, 10, color="#FBE3D0", linewidth=0, zorder=0)
    axes.axhspan(lowest, floor, color="0.85", linewidth=0, zorder=0)
    for (method, path, batched), (colour, marker, line, label) in STYLES.items():
        chosen = data[
            (data["method"] == method) & (data["path"] == path) & ((data["batch"] > 1) == batched)
        ]
        if len(chosen):
            axes.plot(
                chosen["cpu_seconds"],
                np.maximum(chosen["relative_error"], floor),
                color=colour,
                marker=marker,
                linestyle=line,
                linewidth=0.9,
                markersize=3.2,
                markerfacecolor="white" if batched else colour,
                markeredgewidth=0.7,
                label=label,
            )
