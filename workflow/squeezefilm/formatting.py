"""Results for people, a line ``label  value unit`` for each item, and for scripts as JSON.

Both come from a row: values by the names of a table's columns. A function that takes something from
a row removes it, so that the columns that nothing takes are shown by their names.
"""

import json
from collections.abc import Mapping
from math import ceil, floor, isfinite, log10, nan
from typing import Any

from squeezefilm.columns import COLUMNS, error_columns
from squeezefilm.film.positions import CARTESIAN_COLUMNS
from squeezefilm.film.scene import Scene
from squeezefilm.film.validity import OK
from squeezefilm.reynolds.terms import absent_terms, terms_of
from squeezefilm.reynolds.terms.outline import SmoothOutline
from squeezefilm.reynolds.terms.polytropic import Polytropic
from squeezefilm.reynolds.terms.thermal import Thermal
from squeezefilm.units import (
    error_text,
    quantity_and_unit_of_column,
    round_up_error,
    split_unit,
    value_and_error_texts,
)

LABEL_OF_QUANTITY = {
    split_unit(column.name)[0]: column.label for column in COLUMNS.values() if column.label
}
"""Of columns without their unit, where the name itself is none."""
DIMENSIONLESS_COLUMNS = ("epsilon", "sigma", "bearing_number", "knudsen", "modified_reynolds")
SHOWN_FACTOR_COLUMNS = ("h0_m", "hv_m", "x_m", "y_m", "phi_r_m", "phi_deg")
MAIN_RESULT_COLUMNS = ("force_n", "h0_m", "hv_m")
LAST_COLUMNS = ("device", "model", "validation", "absent_term_reasons", "notes", "note")
FRACTION_COLUMNS = (
    "error",
    "expected_error",
    "global_error",
    "worst_relative_error",
    "worst_error",
)
ERROR_PERCENT_COLUMNS = (
    "error_95_percent",
    "error_95_without_scan_percent",
    "profile_uncertainty_percent",
)
"""Errors without a value beside them: rounded up, as those with one are."""
HIDDEN_COLUMNS = {"point_id", "terms", "absent_terms", "inertia", "newton_steps", "residual"} | {
    *("bearing_percent", "bearing_error_percent", "mass_kg"),
}
NOT_AVAILABLE_TEXT, EFFECT_ERROR_SUFFIX = "not available", "_error_percent"
NOT_VALIDATED_TEXT = "not validated"
"""Beginning of a note on a point that a model's validation does not cover."""
EFFECT_NAMES_SHOWN = (
    *("inertia", "thermal", "depth_averaged", "sheared_gas", "moving_profile", "ram_pressure"),
    *("slip", "flow_factor", "edge_loss", "edge_flow"),
)
# Effects whose error is no numerical one.
EFFECTS_WITH_ESTIMATED_ERROR = (
    "depth_averaged",
    "sheared_gas",
    "moving_profile",
    "ram_pressure",
    "flow_factor",
    "edge_flow",
)
# Never negative: an error as large as the value leaves an upper bound.
NON_NEGATIVE_QUANTITIES = (
    *("resonance", "damping_ratio", "settling_start", "settling_stop"),
    *("corner", "instantaneous_fraction", "lasting_fraction"),
)
# Of a levitation, whose modelling error is that of its gap.
COLUMNS_WITHOUT_MODELLING_ERROR = ("stiffness_n_per_m", "resonance_hz", "damping_ratio")
# An effect is shown as a bound where it is less than this fraction of its error.
MIN_EFFECT_OVER_ERROR = 0.1
SYMMETRY_OF_DOMAIN = {"whole": "none", "quarter": "x and y", "radius": "all around"}
MIN_VALUE_WITH_PREFIX, MIN_STIFFNESS_IN_MEGANEWTONS = 1e3, 1e7
"""Of stiffnesses in N/m: shown in kN/m and in MN/m from there."""
MIN_VALUE_SHOWN_IN_MILLI, MIN_VALUE_WITHOUT_EXPONENT, MIN_EFFECT_SHOWN_PERCENT = 1e-4, 1e-4, 0.05

Row = dict[str, Any]
LabelledLines = list[tuple[str, str]]


def column_label(name: str) -> str:
    """Return the label of a column without its unit."""
    effect, _, what = name.partition("_")
    if effect in ("slip", "inertia", "thermal") and what:
        return f"change of {column_label(what)} by {column_label(effect)}"
    spaced = name.replace("dforce_d", "dF/d ").replace("_", " ") if name.islower() else name
    return LABEL_OF_QUANTITY.get(name, spaced)


def scene_row(scene: Scene) -> dict[str, Any]:
    """Return what a result shows of its scene, by the names of columns."""
    terms = [t for t in terms_of(scene) if not isinstance(t, SmoothOutline | Polytropic)]
    named = [label for term in terms for label in term.label.split(", ")]
    absent = [term for term in absent_terms(terms_of(scene)) if term.assumption]
    exponent = scene.gas.polytropic_exponent
    thermal = "isothermal" if exponent == 1 else f"polytropic exponent {exponent:g}"
    assumed = [thermal if term is Thermal.ABSENT_TERM else term.assumption for term in absent]
    equation = ", ".join([f"Reynolds{' with ' * bool(named)}{' and '.join(named)}", *assumed])
    numbers = {name: getattr(scene, name) for name in ("h0_m", "hv_m", *DIMENSIONLESS_COLUMNS)}
    return numbers | position_row(scene) | {"pad_shape": scene.pad.shape, "equation": equation}


def position_row(scene: Scene) -> dict[str, float]:
    """Return the pad's position, without the last digits of coordinates that were polar."""
    return {name: round(getattr(scene, name), 12) for name in CARTESIAN_COLUMNS}


def number_text(
    value: float, *, sign: str = "+", digits: int = 2, least: float = MIN_VALUE_WITHOUT_EXPONENT
) -> str:
    """Return some digits of a number, and all before the point; an exponent below the least."""
    shown = f"{value:{sign}.{digits - 1}e}"
    if not isfinite(value) or 0 < abs(value) < least:
        return shown
    decimals = digits - 1 - floor(log10(abs(float(shown)))) if value else 0
    return f"{value:{sign}.{max(decimals, 0)}f}"


def percent_text(*values: float, sign: str = "+", digits: int = 2) -> str:
    """Return per cent, or the ends of a range of them, as people write them."""
    ends = [number_text(number, sign=sign, digits=digits, least=1e-9) for number in values]
    return f"{' to '.join(dict.fromkeys(ends))} %"


def interval_text(lower: float, upper: float, *, sign: str = "+", digits: int = 2) -> str:
    """Return the ends of an interval, rounded outward to some digits of the larger one."""
    largest = max(abs(lower), abs(upper))
    if not isfinite(largest) or largest == 0:
        return " to ".join(number_text(end, sign=sign) for end in (lower, upper))
    exponent = floor(log10(largest)) + 1 - digits
    # What rounding added to an end that lies on a step already is no reason for the next one.
    steps = floor(lower / 10**exponent + 1e-6), ceil(upper / 10**exponent - 1e-6)
    if largest < MIN_VALUE_WITHOUT_EXPONENT:
        ends = (float(step) * 10**exponent for step in steps)
        return " to ".join(number_text(end, sign=sign, digits=digits) for end in ends)
    return " to ".join(f"{step * 10**exponent:{sign}.{max(-exponent, 0)}f}" for step in steps)


def value_text(value: Any, unit: str = "", *, error: float | None = None, digits: int = 3) -> str:
    """Return a value with its unit and error, by the digits that this leaves."""
    if not isinstance(value, float) or value != value:
        return {"True": "yes", "False": "no", "nan": NOT_AVAILABLE_TEXT}.get(str(value), str(value))
    if unit == "%" and error is None:
        return percent_text(value, sign="")
    if unit == "%" and error is not None and error >= abs(value):
        return f"within ± {percent_text(round_up_error(abs(value) + error), sign='')}"
    size = 1.0
    if unit in ("m", "s") and 0 < abs(value) < 1:
        prefix, size = ("m", 1e3) if abs(value) >= MIN_VALUE_SHOWN_IN_MILLI else ("µ", 1e6)
        unit = prefix + unit
    if unit == "N/m" and abs(value) >= MIN_VALUE_WITH_PREFIX:
        mega = abs(value) >= MIN_STIFFNESS_IN_MEGANEWTONS
        unit, size = ("MN/m", 1e-6) if mega else ("kN/m", 1e-3)
    text = f"{size * value:.{max(digits, len(f'{abs(size * value):.0f}'))}g}"
    if error is not None:
        text = " ± ".join(value_and_error_texts(size * value, size * error))
    return f"{text} {unit}".strip()


def error_text_in_unit(error: float, *, value: float, unit: str) -> str:
    """Return the error of a value in the unit that the value is shown in."""
    return value_text(value, unit, error=error).partition("± ")[2]


def result_lines_text(row: Mapping[Any, Any]) -> str:
    """Return a row as lines: the result, its errors, other values, scene and solver, notes."""
    rest = {name: value for name, value in row.items() if name not in HIDDEN_COLUMNS}
    if not rest.get("bearing_number"):
        # Friction is of a sliding pad.
        rest = {name: value for name, value in rest.items() if "sliding_friction" not in name}
    effects, result = _take_effect_lines(rest), _take_result_lines(rest)
    last = [*_take_scene_lines(rest), *_take_solver_lines(rest)]
    last += [(column_label(name), rest.pop(name, "")) for name in LAST_COLUMNS]
    errors = {error for name in rest for error in error_columns(name, rest)}
    others = [
        labelled_text(name, rest)
        for name, value in rest.items()
        if name not in errors and value != "ok"
    ]
    lines = [
        (label, text)
        for label, texts in (*result, *effects, *others, *last)
        for text in (texts if isinstance(texts, list) else [texts])
        if text not in ("", "None")
    ]
    wide = max(len(label) for label, _ in lines)
    labels = [label * (k == 0 or label != lines[k - 1][0]) for k, (label, _) in enumerate(lines)]
    return "\n".join(f"{a:{wide}}  {text}" for a, (_, text) in zip(labels, lines, strict=True))


def labelled_text(name: str, row: Mapping[str, Any]) -> tuple[str, Any]:
    """Return the label of a row's value, and the value with its errors."""
    label = column_label(quantity_and_unit_of_column(name)[0])
    return label, _row_value_text(name, row[name], row)


def _row_value_text(name: str, value: Any, row: Mapping[str, Any]) -> Any:
    """Return a value of a row with its error, or the list of values that it holds."""
    if isinstance(value, list):
        return [_row_value_text(name, item, row) for item in value]
    if isinstance(value, Mapping):
        beside = {error for column in value for error in error_columns(column, value)}
        labelled = (labelled_text(column, value) for column in value if column not in beside)
        return ", ".join(map(" ".join, labelled))
    stem, unit = quantity_and_unit_of_column(name)
    if stem in FRACTION_COLUMNS:
        return value_text(100 * value, "%")
    if name in ERROR_PERCENT_COLUMNS and value == value:
        return f"{error_text(value)} %"
    errors = [row[error_column] for error_column in error_columns(name, row)]
    if errors and stem in NON_NEGATIVE_QUANTITIES and round_up_error(max(errors)) >= value:
        bound = value_text(round_up_error(value + max(errors)), unit)
        return f"below about {bound} (error as large as the value)"
    text = value_text(value, unit, error=max(errors, default=None))
    if column_label(stem).startswith("change of") and text[0].isdigit():
        text = f"+{text}"
    if "±" not in text:
        return text
    if len(errors) > 1:
        shown = [error_text_in_unit(error, value=value, unit=unit) for error in errors]
        text = f"{text.partition('±')[0]}± {', measurement noise ± '.join(shown)}"
    return text + " (without the modelling error)" * (name in COLUMNS_WITHOUT_MODELLING_ERROR)


def _take_result_lines(row: Row) -> LabelledLines:
    """Take the result and its errors out of a row, as lines; or the reason for its absence."""
    name = next((column for column in MAIN_RESULT_COLUMNS if error_columns(column, row)), "")
    value, status, (stem, unit) = (
        row.pop(name, nan),
        row.pop("status", "ok"),
        quantity_and_unit_of_column(name),
    )
    errors = {error_column: row.pop(error_column) for error_column in error_columns(name, row)}
    column, why = next(iter(errors), ""), f": {status}" * (status != "ok")
    error = errors.get(column, nan)
    reason, note = NOT_AVAILABLE_TEXT, str(row.get("note", ""))
    if "95" in column and (note.startswith(NOT_VALIDATED_TEXT) or not isfinite(value)):
        # What the model's errors are elsewhere is not of this point.
        reason = note
        for other in ("note", "validation", *ERROR_PERCENT_COLUMNS):
            row.pop(other, None)
    if not isfinite(value):
        row.pop("tolerance" if name else "", None)
        return [(column_label(stem or "force"), NOT_AVAILABLE_TEXT + why)] if name or why else []

    base = " of the amplitude" if name == "hv_m" else ""

    def error_and_percent_text(error: float, source: str) -> str:
        if not isfinite(error):
            return reason
        part = round_up_error(100 * abs(error / value)) if value else 0.0
        percentage = f", {percent_text(part, sign='')}{base}" if value else ""
        return f"± {error_text_in_unit(error, value=value, unit=unit)}{percentage}{source}"

    wider, bias = errors.get("error_99_n", 0.0), row.pop("quadrature_n", 0.0)
    noise = next((errors[error_column] for error_column in errors if "noise" in error_column), 0.0)
    misfit = row.pop("misfit_n", 0.0)
    row.pop("error_95_percent" if name == "force_n" else "", None)
    tolerance = f" (relative tolerance {row.pop('tolerance'):g})" if "tolerance" in row else ""
    number, _, rest = value_text(value, unit, error=max(error, noise, misfit)).partition("±")
    return [
        (column_label(stem), f"{number}{rest.split()[-1]}"),
        (
            "prediction error (95 %)" if "95" in column else "numerical error",
            error_and_percent_text(error, tolerance),
        ),
        ("prediction error (99 %)", error_and_percent_text(wider, "") * (wider > 0)),
        (
            "measurement noise",
            error_and_percent_text(noise, " (95 %, from the scan)") * bool(noise),
        ),
        (
            "misfit",
            error_and_percent_text(misfit, " (modes that the scan does not determine)")
            * (misfit > error),
        ),
        (
            "quadrature motion",
            error_and_percent_text(bias, " (in the scan, neglected)") * (bias > error),
        ),
        ("note", why.removeprefix(": ")),
    ]


def _take_scene_lines(row: Row) -> LabelledLines:
    """Take validity, operating point, dimensionless numbers and equation from a row."""
    validity = row.pop("validity", "")
    point = {
        quantity_and_unit_of_column(name): row.pop(name)
        for name in SHOWN_FACTOR_COLUMNS
        if name in row
    }
    numbers = {name: row.pop(name, 0) for name in DIMENSIONLESS_COLUMNS}
    texts = [
        f"{name} = {value_text(number, unit, digits=6)}" for (name, unit), number in point.items()
    ]
    named = [
        f"{column_label(name)} {value_text(number)}" for name, number in numbers.items() if number
    ]
    return [
        ("validity", "within limits" if validity == OK else validity),
        ("operating point", ", ".join(texts)),
        ("dimensionless", ", ".join(named)),
        ("equation", row.pop("equation", "")),
    ]


def _take_effect_lines(row: Row) -> LabelledLines:
    """Take the modelling error from a row: lines about all neglected effects, and each of them."""
    if "included_effects" not in row:
        return []
    size, unit = row.get("force_n", nan) / 100, "N"
    if "stiffness_n_per_m" in row:
        size, unit = 1e4 * row["load_n"] / abs(row["stiffness_n_per_m"]), "µm"

    def effect_change_text(*percents: float, sign: str = "+") -> str:
        scale = size if sign else abs(size)
        texts = [number_text(scale * bound, sign=sign) for bound in percents]
        ends = " to ".join(dict.fromkeys(texts))
        return f"{ends} {unit}, " * isfinite(size) + percent_text(*percents, sign=sign)

    included, unknown = (row.pop(k).split("; ") for k in ("included_effects", "unknown_effects"))
    ends = [row.pop(f"modelling_error_{end}_percent") for end in ("lower", "upper")]
    edge, higher = row.pop("edge_loss_upper_percent"), row.pop("higher_orders_percent")
    status = row.pop("budget_status" if "budget_status" in row else "status")
    names = [name for name in EFFECT_NAMES_SHOWN if f"{name}_percent" in row]
    effects = {
        name: (row.pop(f"{name}_percent"), row.pop(name + EFFECT_ERROR_SUFFIX)) for name in names
    }
    neglected = {name: effects[name] for name in names if name not in included}
    sizes = sorted(size * end for end in ends)
    if unit == "µm":  # with the second order of the gap's change
        sizes = [1e6 * row.pop(f"h0_modelling_error_{end}_m") for end in ("lower", "upper")]
    size_text = f"{interval_text(*sizes)} {unit}, " * isfinite(size)
    total = f"{size_text}{interval_text(*ends)} % of the {'force' if unit == 'N' else 'load'}"
    if not isfinite(ends[0]):
        total = NOT_AVAILABLE_TEXT + f": {status}" * (status != "ok")
        if reason := ", ".join(column_label(name) for name in unknown if name):
            total += f": {reason} not known"
    lines = [("modelling error", total)]
    if status != "ok":
        return lines
    for name, (effect, error) in sorted(
        neglected.items(), key=lambda effect_and_error: -abs(effect_and_error[1][0])
    ):
        text = effect_change_text(effect, *[edge] * (name == "edge_loss"))
        if name in EFFECTS_WITH_ESTIMATED_ERROR:
            bound = percent_text(round_up_error(error), sign="")
            text += f" ± {bound}" if isfinite(error) else ", error not known"
            if abs(effect) < MIN_EFFECT_OVER_ERROR * error:
                bound = percent_text(round_up_error(abs(effect) + error), sign="")
                text = f"within ± {bound}"
        if not abs(effect) + error < MIN_EFFECT_SHOWN_PERCENT:
            lines.append(
                (f"  {column_label(name)}", text if isfinite(effect) else NOT_AVAILABLE_TEXT)
            )
    together = (
        effect_change_text(higher)
        if isfinite(higher) and abs(higher) >= MIN_EFFECT_SHOWN_PERCENT
        else ""
    )
    return [*lines, ("  higher orders", together)]


def _take_solver_lines(row: Row) -> LabelledLines:
    """Take from a row how its force was found, or would be."""
    sizes = [f"{size:.0f}" for name in ("nx", "ny", "nt") if (size := row.pop(name, 0))]
    flat, domain = row.pop("pad_shape", "rectangle") == "rectangle", row.pop("domain", "")
    axes = ("x", "y", "time") if flat else ("radius", "angle", "time")
    solver = [row.pop("method", ""), f"grid {' × '.join(sizes)} ({', '.join(axes[: len(sizes)])})"]
    steps = row.pop("krylov_iterations", 0)
    part, _, axis = domain.partition(" in ")
    symmetry = f"{axis or SYMMETRY_OF_DOMAIN.get(part, '')} ({part} domain)"
    solver = solver[: 1 + bool(sizes)] + [f"{steps} GMRES iterations"] * bool(steps)
    return [("solver", ", ".join(solver)), ("symmetry", symmetry * bool(domain))]


def json_text(row: Mapping[Any, Any]) -> str:
    """Return a row as a JSON object; what is not a number is null."""
    text = json.dumps(row, default=lambda scalar: scalar.item())
    values = json.loads(text, parse_constant=lambda name: None)
    return json.dumps(values, ensure_ascii=False, indent=2)
