"""What leaving things out saves: run time with one thing put back, and the error kept.

The terms and symmetries that the solver leaves out put back one by one: the same forces, at what
cost.
"""

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from reporting.figures.parts import style

INPUTS = {
    "table": "numerics/left_out.csv",
}
AS_NEEDED = "nothing (as needed)"
COLOURS = (style.ORANGE, style.GREEN, style.BLUE)


def draw(data: pd.DataFrame) -> Figure:
    """Bars of processor time over the scenes as they need, beside the worst error of each way."""
    figure = style.new_figure(width_in=style.DOUBLE_COLUMN_IN, height_in=3.3)
    cost, error = figure.subplots(1, 2, sharey=True, width_ratios=(3, 2))
    data = data.assign(put_back=data["put_back"].fillna("").replace("", AS_NEEDED))
    names = list(dict.fromkeys(data["put_back"]))
    groups = list(data.groupby("tolerance", sort=False))
    height = 0.8 / len(groups)
    for number, (tolerance, rows) in enumerate(groups):
        places = np.array([names.index(name) for name in rows["put_back"]])
        places = places + (number - (len(groups) - 1) / 2) * height
        colour = COLOURS[number % len(COLOURS)]
        label = f"tolerance {tolerance:g}"
        cost.barh(places, rows["cpu_ratio"], height=height, color=colour, label=label)
        error.plot(rows["worst_error"], places, "o", color=colour, markersize=3.5)
        error.axvline(float(tolerance), color=colour, linestyle="--")  # type: ignore[arg-type]
    cost.axvline(1, color="black", linewidth=0.6)
    cost.set_yticks(range(len(names)), names)
    cost.invert_yaxis()
    cost.set_xscale("log")
    cost.set_xlabel("processor time over that of the scenes as they need (–)")
    cost.set_ylabel("put back")
    cost.set_title("(a) cost")
    cost.grid(axis="x")
    error.set_xscale("log")
    error.set_xlabel("worst relative error (–)")
    error.set_title("(b) error; dashed: asked for")
    error.grid(axis="x")
    figure.legend(*cost.get_legend_handles_labels(), loc="outside upper center", ncols=3)
    style.add_note(figure, data)
    return figure
