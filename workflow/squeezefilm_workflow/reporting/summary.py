"""Results of a study, as values: for its page (summary.md) and its report's first page."""

from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
import pandas as pd

from squeezefilm.columns import COLUMNS
from squeezefilm.config.keys import number_text
from squeezefilm.config.notes import differences_from_paper
from squeezefilm.film.pad import net_points_on_pad
from squeezefilm.film.positions import POLAR_COLUMNS, find_position_columns
from squeezefilm.film.scene import Gas
from squeezefilm.formatting import column_label, interval_text
from squeezefilm.formatting import number_text as padded_number_text
from squeezefilm.provenance import provenance_record
from squeezefilm.solution import MODELLING_ERROR_COLUMNS
from squeezefilm.units import error_text, value_and_error_texts
from squeezefilm_workflow.reporting.models import rows_of_extreme_amplitudes
from squeezefilm_workflow.reporting.notes import (
    CLAIM_COLUMNS_SHOWN,
    claim_verdict_counts,
    max_simulation_error_fraction,
    percent_text,
    rounded_up_text,
)
from squeezefilm_workflow.reporting.pages import Page, html_of_markdown, render_template
from squeezefilm_workflow.reporting.results import Results

EFFECT_COLUMN_STEMS = ("inertia", "slip", "thermal", "edge_loss", "edge_flow")
NEGLIGIBLE_FRACTION = 1e-3
"""Share of a range's largest value below which its least is as good as 0."""


def summary_page(results: Results, *, pictures: Mapping[str, str], **about: Sequence[str]) -> Page:
    """The study on one page, the first page of its report, and what made them.

    Args:
        pictures: the figures with which both open, by what they show.
    """
    values = summary_values(results, **about) | {"pictures": pictures}
    guide = "paper_guide.rst" if results.config.paper else "study_guide.rst"
    body = html_of_markdown(render_template("in_short.md", **values), folder=results.folder)
    front = render_template("front.rst", study=results.config.study, body=body, guide=guide)
    device = results.read_json_file("simulations/device.json")
    facts = provenance_record(results.config.sections_as_dict(), device=device)
    return Page(values, {"front": front, "provenance": facts})


def summary_values(
    results: Results, *, plans: Sequence[str], fits: Sequence[str], pairs: Sequence[str]
) -> dict[str, Any]:
    """Return the values of the template ``summary.md`` and its ``in_short.md``.

    Args:
        pairs: validations, each ``FIT_on_PLAN``.

    Raises InputError for a result that is missing or lacks what it must have.
    """
    config = results.config
    tables = {plan: results.simulated_points(plan) for plan in plans}
    sections = config.sections_as_dict("gas", "actuator", "pad", "solver")
    settings = pd.json_normalize(sections, sep=": ").iloc[0].map(_setting_text)
    on_disc = find_position_columns(next(iter(tables.values()))) == POLAR_COLUMNS
    return {
        **headline_values(results),
        "frequency_khz": f"{config.actuator.frequency_hz / 1e3:g}",
        "terms": list(_added_term_texts(config.gas, tables)),
        "position": "distance r and direction φ"
        if on_disc
        else "x and y from the surface's centre",
        "total": sum(len(table) for table in tables.values()),
        "plans": pd.DataFrame([_plan_summary_row(plan, table) for plan, table in tables.items()]),
        "variant": ", ".join(differences_from_paper(config)),
        "settings": settings.rename_axis("setting").reset_index(name="value"),
        "tolerance": f"{config.solver.tolerance:g}",
        "largest_error": max(map(max_simulation_error_fraction, tables.values())),
        "methods": sorted(
            {method for table in tables.values() for method in table["method"].dropna()}
        ),
        "device": results.read_json_file("simulations/device.json").get("device", "unknown"),
        "profile_uncertainty": max(results.fit(fit).profile_uncertainty for fit in fits),
        "errors": pd.DataFrame(
            [
                *_recommended_model_rows(results),
                *(_validation_error_row(results, pair) for pair in pairs),
            ]
        ),
        "effects": _effect_rows(results),
    }


def headline_values(results: Results) -> dict[str, Any]:
    """Return the values of the template ``in_short.md``.

    Raises InputError for a result that is missing or lacks what it must have.
    """
    config, noise, recommended = results.config, 0.0, None
    film, mapped = config.read_film(), results.forces("error_map").sort_values("force_n")
    file = "simulations/extrapolation/forces.csv"
    forces = results.forces("extrapolation").set_index("point_id")
    point = results.row(forces, "operating_point", file)
    if results.has_file("profile/summary.json"):
        noise = results.read_json_file("profile/summary.json").get(
            "largest_force_noise_fraction", 0.0
        )
    if not config.paper:
        columns = ("space", "model", "validation_error", "force_n")
        recommended = results.table("models/recommended.csv", *columns).dropna(subset="model")
    return {
        "study": config.study,
        "point": point,
        "amplitude_ratio": round(point["hv_m"] / config.screen.hv_m.stop, 6),
        "force": "{} N ± {} N".format(
            *value_and_error_texts(point["force_n"], point["force_error_n"])
        ),
        "noise": noise,
        "under": np.abs(film.pad_profile.amplitude(*net_points_on_pad(film.pad), x_m=0.0, y_m=0.0)),
        "extremes": list(mapped.iloc[[-1, 0]].itertuples()),
        "full": results.fit("screen"),
        "on_screen": results.validation_errors("screen", "screen"),
        "on_map": results.validation_errors("two_factor_design", "error_map"),
        "fitted": results.fit("two_factor_design").points,
        "judged": results.validation_errors("two_factor_design", "screen"),
        "claims": claim_verdict_counts(results.table("claims.csv", *CLAIM_COLUMNS_SHOWN))
        if config.paper
        else None,
        "recommended": recommended,
        "measured": config.measurements and results.read_json_file("measurements/summary.json"),
        "amplitudes": _amplitude_rows,
        "target": config.extrapolation,
        "modelling_error": modelling_error_text(results),
        "beyond": results.validity_note,
    }


def _amplitude_rows(table: pd.DataFrame) -> pd.DataFrame:
    """The least and the largest amplitude for the target force, and the error of that force."""
    table = rows_of_extreme_amplitudes(table)
    amplitudes = zip(1e6 * table["hv_m"], 1e6 * table["hv_error_95_m"], strict=True)
    shown = [
        value_and_error_texts(*value_and_error)[0] if np.isfinite(value_and_error[0]) else "none"
        for value_and_error in amplitudes
    ]
    error = table["error_95_percent"].map(lambda percentage: f"{error_text(percentage)} %")
    return pd.DataFrame(
        {
            "pad": table["space"].map({"two_factor": "at the centre", "four_factor": "anywhere"}),
            "model": table["model"],
            **{
                name: values.map(partial(number_text, digits=3))
                for name, values in _position_texts(table).items()
            },
            "hv (µm)": shown,
            "95 % error": error.where(table["error_95_percent"].notna(), table["note"]),
        }
    )


def _position_texts(table: pd.DataFrame) -> dict[str, pd.Series]:
    """The pad's positions by name and unit."""
    return {
        f"{column.text_symbol} ({column.shown_unit})": column.in_shown_unit(table[column.name])
        for column in map(COLUMNS.__getitem__, find_position_columns(table))
    }


def modelling_error_text(results: Results) -> str:
    """Return the bounds of the modelling error at the screen's least and largest gap.

    Over all amplitudes of the screen; an empty text where they are not known.
    """
    table = results.budget("screen")
    if not np.isfinite(table[MODELLING_ERROR_COLUMNS].to_numpy(dtype=float)).all():
        return ""
    lower, upper = MODELLING_ERROR_COLUMNS
    bounds = table.groupby("h0_m").agg({lower: "min", upper: "max"}).iloc[[0, -1]]
    texts = [
        f"{_bounds_text(low, high)} % (h0 = {1e6 * h0_m:g} µm)"
        for h0_m, low, high in bounds.itertuples()
    ]
    return " to ".join(dict.fromkeys(texts))


def _change_text(percent: float) -> str:
    return padded_number_text(percent).replace("-", "−") if np.isfinite(percent) else "not known"


def _bounds_text(lower: float, upper: float) -> str:
    text = interval_text(lower, upper).replace(" to ", "…").replace("-", "−")
    return text if np.isfinite([lower, upper]).all() else "not known"


def _effect_rows(results: Results) -> pd.DataFrame:
    """Each effect at the screen's least and largest gap, at its largest amplitude."""
    effects = (f"{name}_percent" for name in EFFECT_COLUMN_STEMS)
    table = results.budget("screen", *effects)
    table = table[table["hv_m"] == table["hv_m"].max()].sort_values("h0_m")
    labels = [*map(column_label, EFFECT_COLUMN_STEMS), "all together (modelling error)"]
    shown: dict[str, Any] = {"effect": labels}
    for _, row in table.iloc[[0, -1]].iterrows():
        present = row["included_effects"].split("; ")
        shown[f"h0 = {1e6 * row['h0_m']:g} µm"] = [
            *(
                "in the forces" if name in present else _change_text(row[f"{name}_percent"])
                for name in EFFECT_COLUMN_STEMS
            ),
            _bounds_text(*row[MODELLING_ERROR_COLUMNS]),
        ]
    return pd.DataFrame(shown)


def _added_term_texts(gas: Gas, tables: Mapping[str, pd.DataFrame]) -> Iterator[str]:
    """Terms of the study's equation beyond the paper's, as in the simulations if there are any."""
    absent = [row for table in tables.values() for row in table["absent_terms"].dropna()]
    for name, chosen in (("inertia", gas.inertia), ("thermal", gas.thermal)):
        if chosen != "none" and not all(name in terms_absent for terms_absent in absent):
            where = "" if chosen == "included" else " where needed"
            yield f"{column_label(name)}{where}"


def _plan_summary_row(plan: str, table: pd.DataFrame) -> dict[str, str]:
    columns = {"h0 (µm)": 1e6 * table["h0_m"], "hv (µm)": 1e6 * table["hv_m"]}
    columns |= _position_texts(table) | {"F (N)": table["force_n"]}
    return {
        "plan": plan,
        "simulations": str(len(table)),
        **{name: _column_range_text(values) for name, values in columns.items()},
        "largest relative error of F, estimated": rounded_up_text(
            max_simulation_error_fraction(table)
        ),
    }


def _validation_error_row(results: Results, pair: str) -> dict[str, str]:
    fit, _, plan = pair.partition("_on_")
    errors = results.validation_errors(fit, plan)
    inside, band = 100 * errors["fraction_within_band"], 100 * errors["band"]
    h0_um, hv_um = 1e6 * errors["worst_h0_m"], 1e6 * errors["worst_hv_m"]
    return {
        "model fitted on": f"{fit} ({results.fit(fit).points} points)",
        "compared on": f"{plan} ({errors['points']:g} points)",
        "global error": percent_text(errors["global_error"]),
        "worst": (
            f"{percent_text(errors['worst_relative_error'])} (h0 {h0_um:.3g}, hv {hv_um:.3g} µm)"
        ),
        "within the band": f"{inside:.3g} % within ±{band:g} %",
    }


def _recommended_model_rows(results: Results) -> Iterator[dict[str, str]]:
    """Yield the errors of the recommended models, none of which the paper's study has."""
    if results.config.paper:
        return
    table = results.table("models/recommended.csv", "fit_points", "worst_error")
    for _, best in table.dropna(subset="model").drop_duplicates("space")[::-1].iterrows():
        space, model = best["space"], best["model"]
        plan = "screen" if space == "two_factor" else space
        yield {
            "model fitted on": f"{plan} ({best['fit_points']:g} points), recommended: {model}",
            "compared on": f"validation_{space} ({best['validation_points']:g} points)",
            "global error": percent_text(best["validation_error"]),
            "worst": f"{percent_text(best['worst_error'])} (validation_two_factor, "
            f"validation_four_factor, four_factor: {best['simulations']:g} points)",
            "within the band": "–",
        }


def _column_range_text(column: pd.Series) -> str:
    """Range from the least to the largest; values that are negligible beside the largest are 0."""
    low, high = float(column.min()), float(column.max())
    low = 0.0 if abs(low) < NEGLIGIBLE_FRACTION * abs(high) else low
    return " … ".join(dict.fromkeys(number_text(end, digits=3) for end in (low, high)))


def _setting_text(value: Any) -> str:
    if isinstance(value, Sequence) and not isinstance(value, str):
        return ", ".join(map(str, value))
    return f"{value:g}" if isinstance(value, float) else str(value)
