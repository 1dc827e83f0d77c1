"""Why the paper's errors are larger: which shortcuts would give them.

The screen simulated anew with numerical shortcuts, and the fits repeated: which of them would give
the errors that the paper reports.
"""

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from reporting.figures.parts import style

INPUTS = {
    "table": "numerics/paper_signature.csv",
}
# Few periods from ambient pressure: kind → line, label.
MARCHES = {"from_mean_gap": ("-", "mean gap"), "from_widest_gap": ("--", "widest gap")}
OTHERS = ("loose", "long_steps")


def draw(data: pd.DataFrame) -> Figure:
    """Marches stopped after so many periods, and the other shortcuts; thin lines: the paper."""
    style.check_known({"none", *MARCHES, *OTHERS}, data["kind"], what="kind of shortcut")
    figure = style.new_figure(width_in=style.DOUBLE_COLUMN_IN, height_in=3.5)
    errors, forces, others = figure.subplots(1, 3, width_ratios=(1, 1, 1.15))
    paper = data.iloc[0]
    converged = data[data["kind"] == "none"].iloc[0]
    for kind, (line, start) in MARCHES.items():
        march = data[data["kind"] == kind]
        for name, colour, label in (
            ("screen_fit_error", style.BLUE, "fit on the screen"),
            ("design_fit_error", style.VERMILLION, "fit on five points"),
        ):
            errors.plot(
                march["periods"],
                100 * march[name],
                "o" + line,
                color=colour,
                markersize=2.6,
                label=f"{label}, from the {start}",
            )
        forces.plot(
            march["periods"],
            march["extrapolated_force_n"],
            "o" + line,
            color="black",
            markersize=2.6,
            label=f"from the {start}",
        )
    _paper_line(errors, 100 * paper["paper_screen_error"], style.BLUE)
    _paper_line(errors, 100 * paper["paper_design_error"], style.VERMILLION)
    _paper_line(forces, paper["paper_force_n"], "black")
    forces.axhline(converged["extrapolated_force_n"], color="0.5", linewidth=0.8, linestyle=":")
    errors.set_yscale("log")
    errors.set_ylabel("global error of a fit (%)")
    forces.set_yscale("log")
    forces.set_ylim(0.6, 3)
    forces.set_yticks([0.6, 0.8, 1, 1.5, 2, 3], ["0.6", "0.8", "1", "1.5", "2", "3"])
    forces.minorticks_off()
    forces.set_ylabel(r"force at $h_0$ = 5 µm, $h_v$ = 2.2 µm (N)")
    for panel in (errors, forces):
        panel.set_xlabel("periods marched")
        panel.grid(True)
    single = data[~data["kind"].isin(MARCHES) & (data["status"] == "ok")]
    rows = range(len(single))
    for name, colour, marker in (
        ("screen_fit_error", style.BLUE, "o"),
        ("design_fit_error", style.VERMILLION, "s"),
    ):
        others.plot(100 * single[name], rows, marker, color=colour, markersize=3.2)
        others.axvline(
            100 * paper[f"paper_{name.removesuffix('_fit_error')}_error"],
            color=colour,
            linewidth=0.8,
        )
    others.set_yticks(rows, [_wrapped(name) for name in single["variant"]], fontsize=6)
    others.set_ylim(len(single) - 0.5, -0.5)
    others.set_xscale("log")
    others.set_xlabel("global error of a fit (%)")
    others.grid(True, axis="x")
    handles, labels = errors.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=2)
    style.add_note(figure, data)
    return figure


def _paper_line(axes: Axes, value: float, colour: str) -> None:
    axes.axhline(value, color=colour, linewidth=0.8)


def _wrapped(name: str) -> str:
    return name.replace(", ", ",\n", 1) if len(name) > 20 else name
