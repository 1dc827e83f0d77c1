"""The explorer: one page of HTML in which fitted models can be played with, and nothing else.

The page carries all it needs (models, simulated forces, drawing library) and asks nothing of any
server. It computes the force itself: each model is the code that ``squeezefilm export`` writes,
model.js what ``squeezefilm.models.amplitude_for_force`` does with it, modulation.js reads what
``squeezefilm response`` found, and words.js has numbers in words.
"""

import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pandas as pd

from reporting.pages.notes import Inertia
from squeezefilm.io.errors import InputError
from squeezefilm.io.positions import as_in, form_of
from squeezefilm.io.tables import FACTOR_COLUMNS
from squeezefilm.models.export import source
from squeezefilm.models.fit_file import FittedModel

HERE = Path(__file__).parent
PAGE = "page.html"
# Its file, so that the page rests on it.
LANGUAGE = "javascript"
PARTS = {
    "STYLE": "page.css",
    "MODEL": "model.js",
    "MODULATION": "modulation.js",
    "WORDS": "words.js",
    "SCRIPT": "page.js",
}
WORDS = {"two_factor": "two factors", "four_factor": "four factors"}


@dataclass(frozen=True)
class Study:
    """What the page is about.

    Attributes:
        name: of the study.
        fits: fitted models, by their names on the page; the first is shown first.
        plans: of each fit, the plan that it was fitted on.
        forces: simulated forces, by the name of their plan, for the drawings.
        force_n: wanted force to begin with.
        h0_m, hv_m: gap and amplitude to begin with.
        inertia: how large it is in this gas.
        modulation: how films follow a changing amplitude, as modulation.py has it, if known.
        left_out: names of models that could not be fitted, with the reason.
    """

    name: str
    fits: Mapping[str, FittedModel]
    plans: Mapping[str, str]
    forces: Mapping[str, pd.DataFrame]
    force_n: float
    h0_m: float
    hv_m: float
    inertia: Inertia
    modulation: Mapping[str, Any] | None = None
    left_out: Mapping[str, str] = field(default_factory=dict)


def explorer_page(study: Study, *, drawing_library: str) -> str:
    """The page as text; ``drawing_library`` is plotly.js as text.

    Raises InputError without fits or forces, or for a fit that the page cannot compute with.
    """
    if not study.fits or not study.forces:
        raise InputError("explorer: give at least one fit and one table of forces")
    parts = {name: (HERE / file).read_text(encoding="utf-8") for name, file in PARTS.items()}
    parts |= {"LIBRARY": drawing_library, "DATA": _json(_data(study)), "STUDY": study.name}
    parts["MODELS"] = "\n".join(_code(name, fit) for name, fit in study.fits.items())
    page = (HERE / PAGE).read_text(encoding="utf-8")
    return re.sub(r"\{\{(\w+)\}\}", lambda marker: parts[marker[1]], page)


def _data(study: Study) -> dict[str, Any]:
    return {
        "fits": [_fit(name, fit, study.plans[name]) for name, fit in study.fits.items()],
        "left_out": dict(study.left_out),
        "plans": list(study.forces),
        "simulations": [
            [index, *(float(value) for value in row)]
            for index, table in enumerate(study.forces.values())
            for row in table[[*as_in(FACTOR_COLUMNS, table), "force_n"]].itertuples(index=False)
        ],
        "position": form_of(next(iter(study.forces.values()))),
        "inertia": {
            name: getattr(study.inertia, name)
            for name in ("reynolds_per_h0_square", "most_reynolds", "beyond")
        },
        "modulation": study.modulation,
        "start": {"h0_m": study.h0_m, "hv_m": study.hv_m, "force_n": study.force_n},
    }


def _fit(name: str, fit: FittedModel, plan: str) -> dict[str, Any]:
    model = fit.force_model
    word = WORDS.get(fit.model, fit.model)
    taught = f"{fit.points} simulations" if fit.theta else "nothing fitted"
    said = "its plan" if plan == fit.model else plan.replace("_", " ")
    return {
        "name": name,
        "label": f"{word}, {taught}" + (f" ({said})" if fit.theta else ""),
        "plan": plan,
        "factors": list(model.factor_names),
        "moves": not model.is_centred,
        "interval": None if fit.interval is None else fit.interval.model_dump(mode="json"),
        "statement": fit.statement,
        "gaps_m": fit.ranges["h0_m"] if fit.interval is None else fit.interval.ranges["h0_m"],
    }


def _code(name: str, fit: FittedModel) -> str:
    """The model as a script's line that puts it among MODELS."""
    code = source(fit, LANGUAGE).replace("</", "<\\/")
    return f"MODELS[{json.dumps(name)}] = (() => {{\n{code}return {fit.model};\n}})();"


def _json(values: Mapping[str, Any] | Sequence[Any]) -> str:
    """JSON with full double precision that cannot end the script it stands in."""
    return json.dumps(values, allow_nan=False, separators=(",", ":")).replace("</", "<\\/")
