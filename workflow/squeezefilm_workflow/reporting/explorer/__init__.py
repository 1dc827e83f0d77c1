"""The explorer: one page of HTML in which fitted models can be played with, and nothing else.

The page carries all it needs (models, simulated forces, drawing library) and asks nothing of any
server. It computes the force itself: each model is the code that ``squeezefilm export`` writes,
model.js what ``squeezefilm.models.fit_file`` does with it, modulation.js reads what
``squeezefilm response`` found, and formatting.js has numbers in words.
"""

import json
from collections.abc import Mapping, Sequence
from typing import Any

import pandas as pd

from squeezefilm.files import read_json
from squeezefilm.film.positions import columns_in_table_form, find_position_columns
from squeezefilm.models.export import source_code
from squeezefilm.models.fit_file import FittedModel, fit_from_values, read_fit
from squeezefilm.tables import FACTOR_COLUMNS
from squeezefilm_workflow.reporting.notes import inertia_page_values, with_minus_signs
from squeezefilm_workflow.reporting.pages import render_template
from squeezefilm_workflow.reporting.results import Results
from squeezefilm_workflow.reporting.summary import modelling_error_text

FILM_FACTOR_COLUMNS = ["h0_m", "hv_m"]
LABEL_OF_FIT_SUFFIX = {"_distinct": "distinct points", "_design": "design points"}
"""Points that a model is fitted to, by the end of their plan's name."""


def explorer_page(
    results: Results,
    *,
    fits: Sequence[str],
    candidates: Sequence[str],
    forces: Mapping[str, pd.DataFrame],
    drawing_library: str,
) -> str:
    """The page as text.

    Args:
        fits: names of the study's fits, each of its plan; the first is shown first, but for the
            models that the study recommends.
        candidates: names of models with the pad anywhere.
        forces: simulated forces, by the name of their plan, for the drawings.
        drawing_library: plotly.js as text.

    Raises InputError for a fit that is missing or that the page cannot compute with.
    """
    config, not_available = results.config, {}
    best = _recommended_models(results)
    models = best | {name: (results.fit(name), name) for name in fits if name not in best}
    for name in candidates:
        path = results.folder / f"models/four_factor/{name}.json"
        values = read_json(path)
        if "not_supported" in values:
            not_available[name] = str(values["not_supported"])
        else:
            models.setdefault(
                f"{name} on four_factor", (fit_from_values(values, source=path), "four_factor")
            )
    data = {
        "fits": [
            _fit_for_explorer(name, fit, plan, best=name in best)
            for name, (fit, plan) in models.items()
        ],
        "not_available": not_available,
        "plans": list(forces),
        "simulations": [
            [index, *row]
            for index, table in enumerate(forces.values())
            for row in table[
                [*columns_in_table_form(FACTOR_COLUMNS, table), "force_n"]
            ].values.tolist()
        ],
        "position": find_position_columns(next(iter(forces.values()))),
        "inertia": inertia_page_values(config),
        "modulation": _modulation_response(results),
        "start": config.extrapolation.model_dump(),
    }
    # In full double precision, and so that no text ends the script it stands in.
    shown = json.dumps(data, allow_nan=False, separators=(",", ":")).replace("</", "<\\/")
    code = "\n".join(_model_javascript(name, fit) for name, (fit, _) in models.items())
    texts = {"library": drawing_library, "models": code, "data": shown}
    texts["modelling_error"] = modelling_error_text(results)
    return render_template("explorer.html", study=config.study, **texts)


def _recommended_models(results: Results) -> dict[str, tuple[FittedModel, str]]:
    """Return the models that the study recommends and their plans, that of any position first.

    Nothing of the paper, whose own models are shown first.
    """
    if results.config.paper:
        return {}
    table = results.table("models/recommended.csv", "space", "model").dropna(subset="model")
    models = {}
    for space, model in table[["space", "model"]].drop_duplicates()[::-1].to_numpy():
        plan = "screen" if space == "two_factor" else space
        name = plan if model == space else f"{model} on {space}"
        models[name] = read_fit(results.candidate_fit_file(space, model)), plan
    return models


def _fit_for_explorer(name: str, fit: FittedModel, plan: str, *, best: bool) -> dict[str, Any]:
    model = fit.force_model
    kind = next((kind for end, kind in LABEL_OF_FIT_SUFFIX.items() if plan.endswith(end)), "points")
    return {
        "name": name,
        "label": f"{fit.model.replace('_factor', ' factors')}, "
        + (f"{fit.points} {kind}" if fit.theta else "nothing fitted")
        + ", recommended" * best,
        "plan": plan,
        "factors": list(model.factor_names),
        "moves": not model.is_for_centred_pad,
        "interval": None
        if fit.prediction_interval is None
        else fit.prediction_interval.model_dump(mode="json"),
        "low_coverage": []
        if fit.prediction_interval is None
        else [region._asdict() for region in fit.prediction_interval.low_coverage_regions()],
        "statement": with_minus_signs(fit.statement),
        "gaps_m": fit.ranges["h0_m"]
        if fit.prediction_interval is None
        else fit.prediction_interval.ranges["h0_m"],
    }


def _model_javascript(name: str, fit: FittedModel) -> str:
    """The model as a script's line that puts it among MODELS."""
    code = source_code(fit, "javascript").replace("</", "<\\/")
    return f"MODELS[{json.dumps(name)}] = (() => {{\n{code}return {fit.model};\n}})();"


def _modulation_response(results: Results) -> dict[str, Any]:
    """Return the force's response to a modulated amplitude: films on a grid of gap and amplitude.

    From the two tables of ``squeezefilm response`` for the screen. The page shows, at a point, what
    lies between the films around it.
    """
    response = results.table("simulations/screen/response.csv", *FILM_FACTOR_COLUMNS, "status")
    gains = results.table(
        "simulations/screen/gains.csv", *FILM_FACTOR_COLUMNS, "frequency_hz", "gain"
    )
    by_film: dict[Any, pd.DataFrame] = dict(iter(gains.groupby(FILM_FACTOR_COLUMNS)))
    films = [
        {name: row[name] for name in FILM_FACTOR_COLUMNS}
        | _film_response(row, by_film[row["h0_m"], row["hv_m"]])
        for row in response.to_dict(orient="records")
    ]
    return {
        **{name: sorted(set(response[name])) for name in FILM_FACTOR_COLUMNS},
        "frequency_hz": sorted(set(gains["frequency_hz"])),
        "films": films,
    }


def _film_response(row: Mapping[Any, Any], gains: pd.DataFrame) -> dict[str, Any]:
    """One film's numbers, None where a modulation is too fast, or why it has none."""
    if row["status"] != "ok":
        return {"why": row["status"]}
    if gains["gain"].isna().all():
        return {"why": gains["status"].iloc[0]}
    lines = gains[["gain", "phase_deg", "error"]]
    known: dict[Any, Any] = lines.astype(object).where(lines.notna(), None).to_dict("list")
    return {
        **{name: row[name] for name in ("corner_hz", "static_gain", "instantaneous_gain")},
        **known,
    }
