"""Figures 15 and 16: the positions of the pad, and the optimal design with four factors."""

from typing import Any

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from squeezefilm_workflow.paper.figures.vibration import max_centre_distance_mm
from squeezefilm_workflow.reporting.figures import parts, style
from squeezefilm_workflow.reporting.results import Results

_MARKER_STYLES: tuple[dict[str, Any], ...] = (
    {"marker": "o", "color": style.BLUE, "markersize": 8, "markerfacecolor": "none"},
    {"marker": "D", "color": style.VERMILLION, "markersize": 4},
)


def fig15(results: Results) -> tuple[Figure, pd.DataFrame]:
    """One dot per position; the dashed line is the largest radius on the actuator."""
    plan = results.scenes("four_factor")
    positions = plan.groupby(["phi_r_m", "phi_deg"], as_index=False).size()
    limit_mm = max_centre_distance_mm(results.config)
    label = "pad stays on the actuator at every angle"
    data = pd.DataFrame(
        {
            "phi_deg": positions["phi_deg"],
            "phi_r_mm": (positions["phi_r_m"] * 1e3).round(9),
            "points": positions["size"],
            "phi_r_limit_mm": limit_mm,
        }
    )
    figure, axes = style.subplots()
    axes.axhline(limit_mm, color=style.VERMILLION, linestyle=style.DASHED_LINE, label=label)
    look = {"markersize": 5, "markeredgewidth": 0.5}
    parts.draw_dots(axes, data, x="phi_deg", y="phi_r_mm", fill=style.BLUE, **look)
    for angle in data["phi_deg"][data["phi_r_mm"] == 0]:
        text = "centre: the same at every angle"
        parts.annotate_at(axes, text, (angle, 0), (8, 0), va="center", fontsize=7)
    top = 1.15 * max(data["phi_r_mm"].max(), limit_mm)
    axes.set_ylim(-0.06 * top, top)
    parts.set_up_position_axes(axes, data["phi_deg"], margin=1 / 15)
    figure.legend(loc="outside upper center", handlelength=1.8)
    note = f"{len(plan)} simulations at {len(positions)} positions, our assumption."
    style.add_note(figure, note, results.validity_note)
    return figure, data


def fig16(results: Results) -> tuple[Figure, pd.DataFrame]:
    """Panel a: amplitude over gap; panel b: radius over angle. Numbers tell the points apart."""
    designs = {
        "the paper's criterion": results.design("four_factor"),
        "physically distinct points": results.design("four_factor_distinct"),
    }
    screen, plan = results.scenes("screen"), results.scenes("four_factor")
    tables = [
        parts.gap_amplitude_table(design, layer="design").assign(
            form=form,
            point=range(1, len(design) + 1),
            phi_r_mm=(design["phi_r_m"] * 1e3).round(9),
            phi_deg=design["phi_deg"].round(9),
        )
        for form, design in designs.items()
    ]
    data = pd.concat(tables, ignore_index=True)
    figure, (left, right) = style.subplots(1, 2, wide=True, height_in=3.0)
    for look, (form, points) in zip(_MARKER_STYLES, data.groupby("form", sort=False), strict=True):
        for axes, x, y in ((left, "h0_um", "hv_um"), (right, "phi_deg", "phi_r_mm")):
            label = form if axes is left else None
            usual = {"linestyle": "none", "clip_on": False, "zorder": 3}
            axes.plot(points[x], points[y], label=label, **usual, **look)
            _write_point_numbers(
                axes, points, x=x, y=y, above=look is _MARKER_STYLES[0], colour=look["color"]
            )
    parts.set_up_gap_amplitude_axes(left, screen)
    left.set_title("(a)")
    radius = 1e3 * float(plan["phi_r_m"].max())
    parts.set_up_position_axes(right, plan["phi_deg"], margin=0.1)
    for axes, high in ((left, left.get_ylim()[1]), (right, 1.05 * radius)):
        axes.set_ylim(0.0, 1.1 * high)  # room for numbers
    right.set_title("(b)")
    right.tick_params(axis="x", pad=8)  # marks at radius 0 lie on the axis
    figure.legend(loc="outside upper center", ncols=2, handletextpad=0.3)
    note = "Equal numbers in (a) and (b): one point; at radius 0 all angles are the same position."
    style.add_note(figure, note, results.validity_note)
    return figure, data


def _write_point_numbers(
    axes: Axes, points: pd.DataFrame, *, x: str, y: str, above: bool, colour: str
) -> None:
    """Write the points' numbers, together where points coincide in this projection.

    Above a point, or beside it towards the middle: below it the axis may lie.
    """
    middle = (points[x].min() + points[x].max()) / 2
    groups = points.assign(x=points[x].round(2), y=points[y].round(2)).groupby(["x", "y"])
    for (at_x, at_y), here in groups:
        text = ", ".join(here["point"].astype(str))
        side, right = ("left", 7) if at_x <= middle else ("right", -7)
        ha, offset = ("center", (0, 7)) if above else (side, (right, -1))
        look = {"ha": ha, "va": "bottom", "color": colour, "fontsize": 7}
        parts.annotate_at(axes, text, (at_x, at_y), offset, **look)
