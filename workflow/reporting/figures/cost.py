"""Cost against size: run time and memory by the size of the problem.

Run time and memory against the number of scenes, points, instants and threads, with fitted
exponents; films of the paper's actuator, whatever the study.
"""

import math

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke
from matplotlib.ticker import NullLocator

from reporting.figures.parts import style

INPUTS = {
    "table": "numerics/cost.csv",
}
COLOURS = {"auto": "black", "periodic": style.BLUE}
LABELS = {"auto": "method chosen", "periodic": "periodic state"}
PANELS = {
    "scenes": "scenes",
    "points": "points across the finger",
    "instants": "instants of the period",
    "cores": "threads",
    "chunk": "scenes a call",
}


def draw(data: pd.DataFrame) -> Figure:
    """Seconds per scene, log-log, with the fitted exponent of the run's time; memory last."""
    figure = style.new_figure(width_in=style.DOUBLE_COLUMN_IN, height_in=4.2)
    style.check_known(PANELS, data["axis"], what="axis")
    style.check_known(COLOURS, data["method"], what="method")
    panels = figure.subplots(2, 3).ravel()
    for panel, (axis, label) in zip(panels, PANELS.items(), strict=False):
        panel.set_xscale("log")
        panel.set_yscale("log")
        panel.grid(True)
        panel.set_xlabel(label)
        grows: list[tuple[str, str]] = []
        for method, line in data[data["axis"] == axis].groupby("method"):
            exponent, start = line["exponent"].iloc[0], line["exponent_from"].iloc[0]
            for name, marker, style_of_line in (
                ("cpu_seconds", "o", "-"),
                ("wall_seconds", "", ":"),
            ):
                what = "processor time" if name == "cpu_seconds" else "wall time"
                panel.plot(
                    line["size"],
                    line[name] / line["scenes"],
                    marker + style_of_line,
                    color=COLOURS[str(method)],
                    markersize=3,
                    label=f"{LABELS[str(method)]}, {what}",
                )
            if pd.notna(exponent):
                grows.append((str(method), f"run ∝ size$^{{{exponent:.2f}}}$ from {start:g}"))
        for height, (method, text) in enumerate(reversed(grows)):
            panel.text(
                0.97,
                0.95 - 0.09 * height,
                text,
                transform=panel.transAxes,
                ha="right",
                va="top",
                fontsize=6,
                color=COLOURS[method],
                path_effects=[withStroke(linewidth=2, foreground="white")],
            )
        _plain_ticks(panel, data.loc[data["axis"] == axis, "size"])
    for panel in panels[::3]:
        panel.set_ylabel("seconds per scene")
    memory = panels[-1]
    memory.set_xscale("log")
    memory.grid(True)
    memory.set_xlabel("scenes")
    memory.set_ylabel("largest memory (MB)")
    for method, line in data[data["axis"] == "scenes"].groupby("method"):
        memory.plot(
            line["size"],
            line["peak_bytes"] / 1e6,
            "o-",
            color=COLOURS[str(method)],
            markersize=3,
        )
    memory.set_ylim(bottom=0)
    memory.margins(x=0.1)
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=4)
    style.add_note(figure, data)
    return figure


def _plain_ticks(axes: Axes, sizes: pd.Series) -> None:
    """Ticks at the sizes themselves, and whole decades of seconds with some room."""
    if len(set(sizes)) <= 7 and max(sizes) < 1000:
        ticks = sorted(set(sizes))
        axes.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
        axes.xaxis.set_minor_locator(NullLocator())
    axes.margins(x=0.1)
    low, high = axes.dataLim.intervaly
    bottom, top = math.floor(math.log10(low) - 0.1), math.ceil(math.log10(high) + 0.3)
    axes.set_ylim(10**bottom, 10**top)
