"""Data of the picture of uncertainty: one force of the paper against what it rests on."""

from __future__ import annotations

import pandas as pd

from reporting.figure_data.common import Inputs
from squeezefilm.io.sources import read_columns
from squeezefilm.studies.config import Config

INPUTS = ("table", "curves")
SECTIONS: tuple[str, ...] = ()

SHOWN = "simulation_at_2.2"


def build(inputs: Inputs, config: Config) -> pd.DataFrame:
    """Layers curve (force over the change of one assumption) and range (over plausible values)."""
    columns = ("claim_id", "claim", "assumption", "verdict", "force_low_n", "force_high_n")
    table = read_columns(inputs["table"], columns=columns)
    curves = read_columns(inputs["curves"], columns=("claim_id", "assumption", "change_percent"))
    table = table[table["claim_id"] == SHOWN]
    curves = curves[curves["claim_id"] == SHOWN]
    first = table.iloc[0]
    explaining = list(table.loc[table["verdict"] == "explains", "assumption"])
    data = pd.concat(
        [
            curves[["assumption", "change_percent", "plausible", "force_n"]].assign(layer="curve"),
            table[["assumption", "force_low_n", "force_high_n", "verdict"]].assign(layer="range"),
        ],
        ignore_index=True,
    )
    note = (
        f"{first['claim'].capitalize()}, each assumption changed alone and the force simulated "
        f"anew: {first['ours_n']:.3f} N with those of this study, {first['paper_n']:g} N in the "
        "paper (grey: what rounds to that). Thick, and on the right: plausible values. "
        + (
            f"What explains the difference: {', '.join(explaining)}."
            if explaining
            else "None of them explains the difference."
        )
    )
    limits = {name: first[name] for name in ("paper_n", "paper_low_n", "paper_high_n", "ours_n")}
    return data.assign(**limits, note=note)
