"""How the force follows a modulated amplitude, for the page: films on a grid of gap and amplitude.

The page shows, at a point, what lies between the films around it; each number is the library's
(``squeezefilm response``).
"""

from collections.abc import Hashable, Mapping
from math import isnan
from typing import Any

import pandas as pd

from squeezefilm.io.errors import InputError

FILM = ["h0_m", "hv_m"]


def modulation(response: pd.DataFrame, gains: pd.DataFrame) -> dict[str, Any]:
    """From the two tables of ``squeezefilm response`` for one plan of a centred finger.

    Raises InputError for tables of different films.
    """
    by_film: dict[Any, pd.DataFrame] = dict(iter(gains.groupby(FILM)))
    rows = response.to_dict(orient="records")
    places = [(row["h0_m"], row["hv_m"]) for row in rows]
    if set(by_film) != set(places):
        raise InputError("explorer: response and gains are of different films")
    return {
        **{name: sorted(set(response[name])) for name in FILM},
        "frequency_hz": list(by_film[places[0]]["frequency_hz"]),
        "films": [
            dict(zip(FILM, place, strict=True)) | _film(row, by_film[place])
            for place, row in zip(places, rows, strict=True)
        ],
    }


def _known(column: pd.Series) -> list[float | None]:
    """None where a modulation is too fast for the slow film."""
    return [None if isnan(value) else value for value in column]


def _film(row: Mapping[Hashable, Any], gains: pd.DataFrame) -> dict[str, Any]:
    """One film's numbers, or why it has none."""
    if row["status"] != "ok":
        return {"why": row["status"]}
    if gains["gain"].isna().all():
        return {"why": gains["status"].iloc[0]}
    return {
        "corner_hz": row["corner_hz"],
        "static_gain": row["static_gain"],
        "prompt_gain": row["prompt_gain"],
        "error": float(gains["error"].max()),
        "gain": _known(gains["gain"]),
        "phase_deg": _known(gains["phase_deg"]),
    }
