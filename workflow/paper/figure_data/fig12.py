"""Data of Figure 12: the points of the optimal design and those of the screen."""

from __future__ import annotations

import pandas as pd

from reporting.figure_data.common import Inputs, add_limits, plane_table
from squeezefilm.io.tables import read_design, read_scenes
from squeezefilm.studies.config import Config

INPUTS = ("plan", "design")
SECTIONS: tuple[str, ...] = ()
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
