"""The explorer: one page of HTML in which fitted models can be played with, and nothing else.

The page carries all it needs (models, simulated forces, drawing library) and asks nothing of any
server. It computes the force itself: each model is the code that ``squeezefilm export`` writes,
model.js what ``squeezefilm.models.amplitude_for_force`` does with it, modulation.js reads what
``squeezefilm response`` found, and words.js has numbers in words.
"""

import json
import re
from collections.abc import Hashable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from math import isnan
from pathlib import Path
from typing import Any

import pandas as pd

from reporting.notes import Inertia
from reporting.results import Results
from squeezefilm.errors import InputError
from squeezefilm.models.export import source
from squeezefilm.models.fit_file import FittedModel, read_fit
from squeezefilm.solution import as_in, form_of
from squeezefilm.tables import FACTOR_COLUMNS, read_json

HERE = Path(__file__).parent
PAGE = "page.html"
PARTS = {
    "STYLE": "page.css",
    "MODEL": "model.js",
    "MODULATION": "modulation.js",
    "WORDS": "words.js",
    "SCRIPT": "page.js",
}
WORDS = {"two_factor": "two factors", "four_factor": "four factors"}
FILM = ["h0_m", "hv_m"]


@dataclass(frozen=True)
class Models:
    """The models on the page, by their names there.

    Attributes:
        fits: fitted models; the first is shown first.
        plans: of each fit, the plan that it was fitted on.
        left_out: names of models that could not be fitted, with the reason.
    """

    fits: dict[str, FittedModel] = field(default_factory=dict)
    plans: dict[str, str] = field(default_factory=dict)
    left_out: dict[str, str] = field(default_factory=dict)


def models_of(results: Results, *, fits: Sequence[str], candidates: Sequence[str]) -> Models:
    """The study's fits, each of its plan, and candidates with the finger anywhere."""
    models = Models()
    for name in fits:
        models.fits[name], models.plans[name] = results.fit(name), name
    for name in candidates:
        path = results.folder / f"models/four_factor/{name}.json"
        values = read_json(path)
        if "refused" in values:
            models.left_out[name] = str(values["refused"])
            continue
        key = f"{name} on four_factor"
        models.fits[key], models.plans[key] = read_fit(path), "four_factor"
    return models


def explorer_page(
    config: Mapping[str, Any],
    models: Models,
    forces: Mapping[str, pd.DataFrame],
    *,
    drawing_library: str,
    modulation: Mapping[str, Any] | None = None,
) -> str:
    """The page as text.

    Args:
        config: the study: its name, gas and actuator, and the point to begin with.
        forces: simulated forces, by the name of their plan, for the drawings.
        drawing_library: plotly.js as text.
        modulation: how films follow a changing amplitude (see modulation_of), if known.

    Raises InputError without fits or forces, or for a fit that the page cannot compute with.
    """
    if not models.fits or not forces:
        raise InputError("explorer: give at least one fit and one table of forces")
    start = config["extrapolation"]
    data = {
        "fits": [_fit(name, fit, models.plans[name]) for name, fit in models.fits.items()],
        "left_out": models.left_out,
        "plans": list(forces),
        "simulations": [
            [index, *(float(value) for value in row)]
            for index, table in enumerate(forces.values())
            for row in table[[*as_in(FACTOR_COLUMNS, table), "force_n"]].itertuples(index=False)
        ],
        "position": form_of(next(iter(forces.values()))),
        "inertia": asdict(Inertia.of(config)),
        "modulation": modulation,
        "start": {name: start[name] for name in ("h0_m", "hv_m", "force_n")},
    }
    parts = {name: (HERE / file).read_text(encoding="utf-8") for name, file in PARTS.items()}
    parts |= {"LIBRARY": drawing_library, "DATA": _json(data), "STUDY": config["study"]}
    parts["MODELS"] = "\n".join(_code(name, fit) for name, fit in models.fits.items())
    page = (HERE / PAGE).read_text(encoding="utf-8")
    return re.sub(r"\{\{(\w+)\}\}", lambda marker: parts[marker[1]], page)


def _fit(name: str, fit: FittedModel, plan: str) -> dict[str, Any]:
    model = fit.force_model
    label = f"{WORDS.get(fit.model, fit.model)}, nothing fitted"
    if fit.theta:
        of = "its plan" if plan == fit.model else plan.replace("_", " ")
        label = f"{WORDS.get(fit.model, fit.model)}, {fit.points} simulations ({of})"
    return {
        "name": name,
        "label": label,
        "plan": plan,
        "factors": list(model.factor_names),
        "moves": not model.is_centred,
        "interval": None if fit.interval is None else fit.interval.model_dump(mode="json"),
        "statement": fit.statement,
        "gaps_m": fit.ranges["h0_m"] if fit.interval is None else fit.interval.ranges["h0_m"],
    }


def _code(name: str, fit: FittedModel) -> str:
    """The model as a script's line that puts it among MODELS."""
    code = source(fit, "javascript").replace("</", "<\\/")
    return f"MODELS[{json.dumps(name)}] = (() => {{\n{code}return {fit.model};\n}})();"


def _json(values: Mapping[str, Any]) -> str:
    """JSON with full double precision that cannot end the script it stands in."""
    return json.dumps(values, allow_nan=False, separators=(",", ":")).replace("</", "<\\/")


def modulation_of(response: pd.DataFrame, gains: pd.DataFrame) -> dict[str, Any]:
    """How the force follows a modulated amplitude: films on a grid of gap and amplitude.

    From the two tables of ``squeezefilm response`` for one plan of a centred finger. The page
    shows, at a point, what lies between the films around it.

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


def _film(row: Mapping[Hashable, Any], gains: pd.DataFrame) -> dict[str, Any]:
    """One film's numbers, None where a modulation is too fast, or why it has none."""
    if row["status"] != "ok":
        return {"why": row["status"]}
    if gains["gain"].isna().all():
        return {"why": gains["status"].iloc[0]}
    return {
        **{name: row[name] for name in ("corner_hz", "static_gain", "prompt_gain")},
        "error": float(gains["error"].max()),
        **{
            name: [None if isnan(value) else value for value in gains[name]]
            for name in ("gain", "phase_deg")
        },
    }
