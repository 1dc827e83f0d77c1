"""Error against run time: relative error of the force by processor time.

Relative error of the mean force over processor time, a panel for each film, a line for each method
refined along its own path; to the lower left is better. The reference shares nothing with any
method, with inertia it is the solver's own force on a finer grid; no error can be seen below the
grey band. Without inertia: the same film's force by the Reynolds equation, held against that
equation. Inside the orange band the error is larger than that of the empirical model fitted to this
study's screen. The films are those of the paper's actuator, whatever the study.
"""

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from reporting.figures.parts import style

INPUTS = {
    "table": "numerics/work_precision.csv",
}
SKY = "#56B4E9"
Key = tuple[str, str, bool]
"""Method, path, and whether it is in a batch."""
# key → colour, marker, line, label; several lines may share a label.
STYLES: dict[Key, tuple[str, str, str, str]] = {
    ("auto", "tolerance", False): ("black", "o", "-", "this solver, by tolerance"),
    ("auto", "tolerance", True): ("black", "o", ":", "… in a batch"),
    ("periodic", "tolerance", False): (style.BLUE, "d", "-", "periodic state, by tolerance"),
    ("periodic", "tolerance", True): (style.BLUE, "d", ":", "… in a batch"),
    ("without_inertia", "tolerance", False): (style.GREY, "d", "-", "… without inertia"),
    ("without_inertia", "tolerance", True): (style.GREY, "d", ":", "… in a batch"),
    ("periodic", "balanced", False): (SKY, "s", "-", "periodic state, given grid"),
    ("periodic", "balanced", True): (SKY, "s", ":", "… in a batch"),
    ("periodic", "space", False): (SKY, "^", "--", "… refined in space alone"),
    ("periodic", "time", False): (SKY, ">", "--", "… refined in time alone"),
    ("fast-limit", "no setting", False): ("black", "P", "", "limit σ → ∞"),
    ("boundary-layer", "no setting", False): ("black", "*", "", "… with boundary layer"),
    ("small-amplitude", "no setting", False): ("black", "X", "", "limit ε → 0"),
    ("matched-limit", "no setting", False): ("black", "p", "", "both limits matched"),
    ("periodic_numpy", "balanced", False): (
        style.GREY,
        "D",
        "-",
        "same algorithm, NumPy, no symmetry",
    ),
    ("chebyshev_anderson", "balanced", False): (
        style.GREEN,
        "v",
        "-",
        "Chebyshev, Radau, Anderson",
    ),
    ("elements_anderson", "balanced", False): (
        style.ORANGE,
        "<",
        "-",
        "finite elements, CN, Anderson",
    ),
    ("elements_from_rest", "balanced", False): (
        style.VERMILLION,
        "p",
        "-",
        "finite elements, CN from rest",
    ),
    ("elements_from_rest_freefem", "balanced", False): (
        style.VERMILLION,
        "P",
        "--",
        "finite elements, CN from rest, FreeFEM",
    ),
    ("volumes_from_rest", "balanced", False): (
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
    keys = zip(warm["method"], warm["path"], (warm["batch"] > 1).tolist(), strict=True)
    style.check_known(STYLES, keys, what="method, path and batch")
    scenes = list(dict.fromkeys(warm["scene"]))
    columns = min(4, len(scenes))
    rows = -(-len(scenes) // columns)
    figure = style.new_figure(
        width_in=style.DOUBLE_COLUMN_IN, height_in=1.0 + (2.1 if rows > 1 else 2.4) * rows
    )
    axes = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
    lowest = 0.2 * float(warm["reference_uncertainty"].min())
    seconds = warm["cpu_seconds"]
    for panel in axes.ravel()[len(scenes) :]:
        panel.set_visible(False)
    drawn: dict[Key, Line2D] = {}
    for panel, scene in zip(axes.ravel(), scenes, strict=False):
        drawn |= _panel(panel, warm[warm["scene"] == scene], lowest=lowest)
        panel.set_title(scene.replace(", ε", "\nε"), fontsize=7)
        panel.set_xlim(0.5 * seconds.min(), 2 * seconds.max())
        panel.set_ylim(lowest, 1)
    for column in axes.T:
        lowest_panel = [panel for panel in column if panel.get_visible()][-1]
        lowest_panel.set_xlabel("processor time per film (s)")
        lowest_panel.tick_params(labelbottom=True)
    for panel in axes[:, 0]:
        panel.set_ylabel("relative error of the force")
    shown = [drawn[key] for key in STYLES if key in drawn]
    figure.legend(
        [*shown, Patch(color="#FBE3D0"), Patch(color="0.85")],
        [
            *(str(line.get_label()) for line in shown),
            "error above the empirical model's own",
            "uncertainty of the reference",
        ],
        loc="outside upper center",
        ncols=3,
        fontsize=6.5,
    )
    style.add_note(figure, data)
    return figure


def _panel(axes: Axes, data: pd.DataFrame, *, lowest: float) -> dict[Key, Line2D]:
    """The lines of one film, by their key."""
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.grid(True)
    model_error = float(data["model_error"].iloc[0])
    floor = float(data["reference_uncertainty"].iloc[0])
    axes.axhspan(model_error, 10, color="#FBE3D0", linewidth=0, zorder=0)
    axes.axhspan(lowest, floor, color="0.85", linewidth=0, zorder=0)
    drawn = {}
    for key, (colour, marker, line, label) in STYLES.items():
        method, path, batched = key
        chosen = data[
            (data["method"] == method) & (data["path"] == path) & ((data["batch"] > 1) == batched)
        ]
        if len(chosen):
            [drawn[key]] = axes.plot(
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
    return drawn
