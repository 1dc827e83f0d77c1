"""How accurate a simulation must be: what force errors do to the fit and the design.

What random errors in the forces do to the fit and to the design: everything moves in proportion.
"""

import pandas as pd
from matplotlib.figure import Figure

from reporting.figures.parts import style

INPUTS = {
    "table": "numerics/conditioning.csv",
}
LINES = {
    ("parameter_move", "screen"): (style.BLUE, "o-", "parameters, 60 points"),
    ("parameter_move", "design"): (style.BLUE, "o:", "parameters, five points"),
    ("model_move", "screen"): (
        style.GREEN,
        "s-",
        "model's force, 60 points",
    ),
    ("model_move", "design"): (
        style.GREEN,
        "s:",
        "model's force, five points",
    ),
    ("design_move", "screen"): (
        style.VERMILLION,
        "^-",
        "design points, unit factors",
    ),
}


def draw(data: pd.DataFrame) -> Figure:
    """Log-log; the grey line is a move as large as the force error."""
    moves = data[data["force_error"].notna()]
    style.check_known(LINES, zip(moves["quantity"], moves["points"], strict=True), what="quantity")
    figure = style.new_figure(height_in=3.4)
    axes = figure.subplots()
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.grid(True)
    for (quantity, points), (colour, line, label) in LINES.items():
        chosen = data[(data["quantity"] == quantity) & (data["points"] == points)]
        chosen = chosen[chosen["value"] > 0].sort_values("force_error")
        axes.plot(
            chosen["force_error"],
            chosen["value"],
            line,
            color=colour,
            markersize=3.2,
            markerfacecolor="white" if line.endswith(":") else colour,
            label=label,
        )
    sizes = sorted(data["force_error"].dropna().unique())
    axes.plot(sizes, sizes, color="0.6", linewidth=0.8, label="as large as the force error")
    axes.set_xlabel("relative error of each simulated force")
    axes.set_ylabel("move")
    figure.legend(
        loc="outside upper center", ncols=2, fontsize=6.5, handlelength=1.6, columnspacing=1.0
    )
    style.add_note(figure, data)
    return figure
