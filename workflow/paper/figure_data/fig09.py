"""Data of Figure 9: the triplets of all searches, in every scaling of the factors."""

from __future__ import annotations

import pandas as pd

from paper.figure_data import searches
from reporting.figure_data.common import Inputs, add_limits, micrometres
from reporting.pages.notes import one_digit
from squeezefilm.io.tables import read_scenes
from squeezefilm.studies.config import Config

INPUTS = searches.INPUTS
SECTIONS: tuple[str, ...] = ()


def build(inputs: Inputs, config: Config) -> pd.DataFrame:
    """One row per point of each search, the study's own scaling first."""
    own, number, scalings = searches.patterns_found(inputs["summary"])
    points = searches.read_searches(inputs["searches"])
    data = pd.DataFrame(
        {
            "scaling": points["scaling"],
            "search": points["search"],
            "pattern": points["pattern"],
            "h0_um": micrometres(points["h0_m"]),
            "hv_um": micrometres(points["hv_m"]),
            "objective": points["objective"],
        }
    ).sort_values("scaling", key=lambda names: names != own, kind="stable")
    least = scalings[own][0]["objective"]
    behind = [
        f"{pattern['pattern']} {one_digit(pattern['objective_excess'] / least)}"
        for pattern in scalings[own][1:]
    ]
    excess = f" O above that of A, in proportion: {', '.join(behind)} in (a)." if behind else ""
    note = (
        f"{number} searches on criterion (12) in each unit of the distances between points, which "
        f"the paper does not state; (a) is used further on.{excess} Letters are given anew in each "
        "panel."
    )
    return add_limits(data, read_scenes(inputs["plan"])).assign(note=note)
