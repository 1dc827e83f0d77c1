"""The explorer: one page of HTML in which fitted models can be played with, and nothing else.

The page carries all it needs (models, simulated forces, drawing library) and asks nothing of any
server. It computes the force itself: model.js is the formula of ``squeezefilm.models.force_model``,
trust.js the rule of ``squeezefilm.models.trust``.
"""

import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd

from squeezefilm.io.errors import InputError
from squeezefilm.io.positions import as_in, form_of
from squeezefilm.io.tables import FACTOR_COLUMNS
from squeezefilm.models.experiments import factors_of
from squeezefilm.models.fitted import FittedModel
from squeezefilm.models.force_model import get_model

HERE = Path(__file__).parent
PAGE = "page.html"
PARTS = {"STYLE": "page.css", "MODEL": "model.js", "TRUST": "trust.js", "SCRIPT": "page.js"}
WORDS = {"two_factor": "two factors", "four_factor": "four factors"}


@dataclass(frozen=True)
class Study:
    """What the page is about.

    Attributes:
        name: of the study.
        fits: fitted models, by the name of the plan they were fitted on; the first is shown first.
        forces: simulated forces, by the name of their plan; a model is judged by those of them
            that it was not fitted to.
        force_n: wanted force to begin with.
        h0_m, hv_m: gap and amplitude to begin with.
        band: relative error up to which a model is trusted.
    """

    name: str
    fits: Mapping[str, FittedModel]
    forces: Mapping[str, pd.DataFrame]
    force_n: float
    h0_m: float
    hv_m: float
    band: float


def explorer_page(study: Study, *, drawing_library: str) -> str:
    """The page as text; ``drawing_library`` is plotly.js as text.

    Raises InputError without fits or forces, or for a fit of a model that the page does not know.
    """
    if not study.fits or not study.forces:
        raise InputError("explorer: give at least one fit and one table of forces")
    parts = {name: (HERE / file).read_text(encoding="utf-8") for name, file in PARTS.items()}
    parts |= {"LIBRARY": drawing_library, "DATA": _json(_data(study)), "STUDY": study.name}
    page = (HERE / PAGE).read_text(encoding="utf-8")
    return re.sub(r"\{\{(\w+)\}\}", lambda marker: parts[marker[1]], page)


def _data(study: Study) -> dict[str, Any]:
    return {
        "fits": [
            {**_fit(name, fit), "trust": _trust(name, fit, study)}
            for name, fit in study.fits.items()
        ],
        "plans": list(study.forces),
        "simulations": [
            [index, *(float(value) for value in row)]
            for index, table in enumerate(study.forces.values())
            for row in table[[*as_in(FACTOR_COLUMNS, table), "force_n"]].itertuples(index=False)
        ],
        "position": form_of(next(iter(study.forces.values()))),
        "band": study.band,
        "start": {"h0_m": study.h0_m, "hv_m": study.hv_m, "force_n": study.force_n},
    }


def _fit(name: str, fit: FittedModel) -> dict[str, Any]:
    if fit.model not in WORDS:
        raise InputError(
            f"fit {name!r}: the explorer knows the models {', '.join(WORDS)}, not {fit.model!r}"
        )
    model = get_model(fit.model)
    if len(fit.theta) != len(model.parameter_names):
        raise InputError(
            f"fit {name!r}: the {fit.model} model has {len(model.parameter_names)} parameters, "
            f"not {len(fit.theta)}"
        )
    plan = name.removeprefix(f"{fit.model}_").replace("_", " ")
    plan = "its plan" if plan == fit.model.replace("_", " ") else plan
    return {
        "name": name,
        "label": f"{WORDS[fit.model]}, {fit.points} simulations ({plan})",
        "moves": "phi_r_m" in model.factor_names,
        "theta": [*fit.theta, *(0.0 for _ in range(5 - len(fit.theta)))],
    }


def _trust(name: str, fit: FittedModel, study: Study) -> dict[str, Any]:
    """The evidence of a fit, with the study's simulations that it never saw."""
    forces = pd.concat(list(study.forces.values()), ignore_index=True)
    judged = fit.judged_by(
        factors_of(forces),
        force_n=forces["force_n"],
        force_error_n=forces["force_error_n"],
    )
    if judged.trust is None:
        raise InputError(f"fit {name!r}: its file does not tell its points; fit it anew")
    return judged.trust.to_dict()


def _json(values: Mapping[str, Any] | Sequence[Any]) -> str:
    """JSON with full double precision that cannot end the script it stands in."""
    return json.dumps(values, allow_nan=False, separators=(",", ":")).replace("</", "<\\/")
