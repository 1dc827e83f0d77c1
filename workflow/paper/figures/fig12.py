"""Figure 12: the optimal design in the space of the experiment.

The optimal design (black) in the space of the experiment, with the screen (white). The letters name
the patterns that a point is of; a plus marks a point added by augmentation.
"""

import pandas as pd
from matplotlib.figure import Figure

from reporting.figures.parts import plane, style
from reporting.figures.parts.tables import Inputs, add_limits, plane_table
from squeezefilm.config.loading import Config
from squeezefilm.io.tables import read_design, read_scenes

INPUTS = {
    "plan": "simulations/screen/scenes.csv",
    "design": "designs/two_factor.csv",
}
AUGMENTATION = "augmentation"


def build(inputs: Inputs, config: Config) -> pd.DataFrame:
    """Layers screen and design; ``label`` names the patterns of a point, + if it was added."""
    screen, design = read_scenes(inputs["plan"]), read_design(inputs["design"])
    labels = design["origin"].str.replace(" and ", ", ").replace(AUGMENTATION, "+")
    data = pd.concat(
        [
            plane_table(screen, layer="screen"),
            plane_table(design, layer="design").assign(label=labels),
        ],
        ignore_index=True,
    )
    added = int((design["origin"] == AUGMENTATION).sum())
    note = f"{len(design)} points instead of {len(screen)}. Letters: a point's patterns"
    if added:
        note += (
            f"; +: added by best augmentation, for the patterns have {len(design) - added} "
            "distinct points"
        )
    return add_limits(data, screen).assign(note=f"{note}.")


def draw(data: pd.DataFrame) -> Figure:
    """Layers screen (white dots) and design (black dots, each with a label)."""
    figure = style.new_figure()
    axes = figure.subplots()
    screen, design = style.rows(data, "screen"), style.rows(data, "design")
    label = f"screen, {len(screen)} points"
    plane.dots(axes, screen, fill="white", markersize=4, markeredgewidth=0.6, label=label)
    label = f"optimal design, {len(design)} points"
    plane.dots(axes, design, fill="black", markersize=6, label=label)
    plane.set_up(axes, data)
    plane.label_points(axes, design, labels=design["label"])
    figure.legend(loc="outside upper center", ncols=2, handletextpad=0.2)
    style.add_note(figure, data)
    return figure
