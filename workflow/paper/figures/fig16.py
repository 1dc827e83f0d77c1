"""Figure 16: the optimal design with four factors.

The five optimal points in four dimensions, (a) in the plane of mean gap and amplitude, (b) in that
of angle and radius: by the determinant alone, as in the paper, and with the points kept physically
distinct. Equal numbers belong to one point.
"""

from typing import Any

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from reporting.figures.parts import plane, style
from reporting.figures.parts.tables import Inputs, add_limits, plane_table
from squeezefilm.config.loading import Config
from squeezefilm.io.tables import read_design, read_scenes

INPUTS = {
    "plan": "simulations/four_factor/scenes.csv",
    "screen": "simulations/screen/scenes.csv",
    "design": "designs/four_factor.csv",
    "distinct": "designs/four_factor_distinct.csv",
}
_LOOKS: tuple[dict[str, Any], ...] = (
    {"marker": "o", "color": style.BLUE, "markersize": 8, "markerfacecolor": "none"},
    {"marker": "D", "color": style.VERMILLION, "markersize": 4},
)


def build(inputs: Inputs, config: Config) -> pd.DataFrame:
    """One row per point of each form's design, numbered from 1."""
    designs = {
        "the paper's criterion": read_design(inputs["design"]),
        "physically distinct points": read_design(inputs["distinct"]),
    }
    screen, plan = read_scenes(inputs["screen"]), read_scenes(inputs["plan"])
    parts = [
        plane_table(design, layer="design").assign(
            form=form,
            point=range(1, len(design) + 1),
            phi_r_mm=(design["phi_r_m"] * 1e3).round(9),
            phi_deg=design["phi_deg"].round(9),
        )
        for form, design in designs.items()
    ]
    data = add_limits(pd.concat(parts, ignore_index=True), screen)
    paper = designs["the paper's criterion"]
    note = (
        "Numbers tell the points of a design apart. At radius 0 every angle is one and the same "
        f"scene: of the {len(paper)} points by the paper's criterion {distinct_scenes(paper)} are "
        "different scenes. Of places with equal hv/h0, all as good, the one far from the "
        "others is taken."
    )
    return data.assign(
        phi_r_max_mm=round(float(plan["phi_r_m"].max()) * 1e3, 9),
        phi_max_deg=plan["phi_deg"].max(),
        note=note,
    )


def distinct_scenes(design: pd.DataFrame) -> int:
    """How many different scenes a design has: at the centre the angle makes no difference."""
    centred = design["phi_r_m"] < 1e-9
    scenes = pd.DataFrame(
        {
            "h0_um": (design["h0_m"] * 1e6).round(3),
            "hv_um": (design["hv_m"] * 1e6).round(3),
            "phi_r_mm": (design["phi_r_m"] * 1e3).round(3),
            "phi_deg": design["phi_deg"].round(3).where(~centred, 0.0),
        }
    )
    return len(scenes.drop_duplicates())


def draw(data: pd.DataFrame) -> Figure:
    """Panel a: amplitude over gap; panel b: radius over angle. Numbers tell the points apart."""
    figure = style.new_figure(width_in=style.DOUBLE_COLUMN_IN, height_in=3.0)
    left, right = figure.subplots(1, 2)
    for order, (form, points) in enumerate(data.groupby("form", sort=False)):
        look = _LOOKS[order % len(_LOOKS)]
        for axes, x, y in ((left, "h0_um", "hv_um"), (right, "phi_deg", "phi_r_mm")):
            axes.plot(
                points[x],
                points[y],
                linestyle="none",
                clip_on=False,
                zorder=3,
                label=form if axes is left else None,
                **look,
            )
            _number(axes, points, x=x, y=y, above=order == 0, colour=look["color"])
    plane.set_up(left, data)
    left.set_title("(a)")
    radius = float(data["phi_r_max_mm"].iloc[0])
    plane.set_up_positions(right, data["phi_max_deg"], margin=0.1)
    right.set_ylim(-0.13 * radius, 1.15 * radius)
    right.set_title("(b)")
    figure.legend(loc="outside upper center", ncols=2, handletextpad=0.3)
    style.add_note(figure, data)
    return figure


def _number(axes: Axes, points: pd.DataFrame, *, x: str, y: str, above: bool, colour: str) -> None:
    """Write the points' numbers, together where points coincide in this projection."""
    places = points.assign(x=points[x].round(2), y=points[y].round(2)).groupby(["x", "y"])
    for (at_x, at_y), here in places:
        axes.annotate(
            ", ".join(f"{number}" for number in here["point"]),
            (at_x, at_y),
            xytext=(0, 6 if above else -6),
            textcoords="offset points",
            ha="center",
            va="bottom" if above else "top",
            fontsize=7,
            color=colour,
        )
