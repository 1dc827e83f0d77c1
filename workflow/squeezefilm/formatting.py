"""Results for people, a line ``label  value unit`` for each item, and for scripts as JSON.

Both come from a row: values by the names of a table's columns. A function that takes something from
a row removes it, so that the columns that nothing takes are shown by their names.
"""

import json
from collections.abc import Mapping
from math import floor, isfinite, log10, nan
from typing import Any

from squeezefilm.tables import THIS_SCENE
from squeezefilm.units import error_column, to_its_error, unit_of_column

LABELS = {
    "force": "mean force",
    "h0": "gap h0",
    "hv": "amplitude hv",
    "error_99": "prediction error (99 %)",
    "profile_uncertainty": "measurement noise (95 %)",
    "inertia": "gas inertia",
    "edge_loss": "edge inflow loss",
    "flow_factor": "slip beyond first order",
    "epsilon": "excursion ratio",
    "sigma": "squeeze number",
    "knudsen": "Knudsen number",
    "modified_reynolds": "modified Reynolds number",
}
"""Of columns without their unit, where the name itself is none."""
NUMBERS = ("epsilon", "sigma", "bearing_number", "knudsen", "modified_reynolds")
FACTORS = ("h0_m", "hv_m", "x_m", "y_m", "phi_r_m", "phi_deg")
RESULTS = ("force_n", "h0_m", "hv_m")
FRACTIONS = ("error", "global_error", "worst_relative_error", "worst_error")
NOT_SHOWN = (
    *("point_id", "terms", "domain", "inertia", "newton_steps", "residual", "sum_lower_percent"),
    *("sum_upper_percent", "h0_modelling_error_lower_m", "h0_modelling_error_upper_m"),
)
NOT_AVAILABLE, REMAINDER = "not available", "_remainder_percent"
# Least length or time in milli, least number without an exponent, least effect shown in per cent.
LEAST_MILLI, LEAST_PLAIN, LEAST_EFFECT = 1e-4, 1e-4, 0.01

Row = dict[str, Any]
Lines = list[tuple[str, str]]


def label_of(name: str) -> str:
    """Return the label of a column without its unit."""
    return LABELS.get(name, name.replace("dforce_d", "dF/d").replace("_", " "))


def plain(value: float, *, sign: str = "+", digits: int = 2, least: float = LEAST_PLAIN) -> str:
    """Return some digits of a number, and all before the point; an exponent below the least."""
    shown = f"{value:{sign}.{digits - 1}e}"
    if not isfinite(value) or 0 < abs(value) < least:
        return shown
    places = digits - 1 - floor(log10(abs(float(shown)))) if value else 0
    return f"{value:{sign}.{max(places, 0)}f}"


def percent(*values: float, sign: str = "+", digits: int = 2) -> str:
    """Return per cent, or the ends of a range of them, as people write them."""
    return " to ".join(plain(each, sign=sign, digits=digits, least=1e-9) for each in values) + " %"


def value_text(value: Any, unit: str = "", *, error: float | None = None, digits: int = 3) -> str:
    """Return a value with its unit and error, by the digits that this leaves."""
    if not isinstance(value, float) or value != value:
        return {"True": "yes", "False": "no", "nan": NOT_AVAILABLE}.get(str(value), str(value))
    if unit == "%":
        off = "" if error is None else f"± {percent(error, sign='', digits=1)}"
        return percent(value, sign="").replace("%", off or "%")
    size = 1.0
    if unit in ("m", "s") and 0 < abs(value) < 1:
        prefix, size = ("m", 1e3) if abs(value) >= LEAST_MILLI else ("µ", 1e6)
        unit = prefix + unit
    text = f"{size * value:.{max(digits, len(f'{abs(size * value):.0f}'))}g}"
    if error is not None:
        text = " ± ".join(to_its_error(size * value, size * error))
    return f"{text} {unit}".strip()


def in_lines(row: Mapping[Any, Any]) -> str:
    """Return a row as lines: the result, its errors, other values, scene and solver, notes."""
    rest = {name: value for name, value in row.items() if name not in NOT_SHOWN}
    effects, result, scene = _effects(rest), _result(rest), _scene(rest)
    scene = [("validity", rest.pop("validity", "")), *scene, *_solver(rest)]
    scene += [(name, rest.pop(name, "")) for name in ("device", "model", "validation", "note")]
    scene += [("note", note.removeprefix("note: ")) for note in rest.pop("notes", ())]
    errors = {name: error_column(name, rest) for name in rest}
    others = [
        (label_of(stem), value_text(100 * value, "%") if stem in FRACTIONS else text)
        for name, value in rest.items()
        if name not in errors.values() and value not in ("", "ok", None)
        for stem, unit in [unit_of_column(name)]
        for text in [value_text(value, unit, error=rest.get(errors[name]))]
    ]
    lines = [(label, text) for label, text in (*result, *effects, *others, *scene) if text]
    wide, before = max(len(label) for label, _ in lines), ["", *(label for label, _ in lines)]
    return "\n".join(
        f"{label if label != above else '':{wide}}  {text}"
        for (label, text), above in zip(lines, before, strict=False)
    )


def _result(row: Row) -> Lines:
    """Take the result and its errors from a row: lines about them, or why there is none."""
    name = next((each for each in RESULTS if error_column(each, row)), "")
    value, (stem, unit), status = row.pop(name, nan), unit_of_column(name), row.pop("status", "ok")
    why = f": {status}" * (status != "ok")
    if not isfinite(value):
        return [(label_of(stem or "force"), NOT_AVAILABLE + why)] if name or why else []
    column, noise = str(error_column(name, row)), row.pop("h0_noise_m", 0.0)
    tolerance = f" (tolerance {row.pop('tolerance'):g})" if "tolerance" in row else ""
    label = "prediction error (95 %)" if "95" in column else "numerical error"
    errors = [
        (label, row.pop(column) - noise, tolerance),
        ("measurement noise", row.pop("noise_n", noise), " (95 %, from the scan)"),
        ("quadrature motion", row.pop("out_of_phase_n", 0.0), " (in the scan, neglected)"),
    ]
    number, _, rest = value_text(value, unit, error=max(each for _, each, _ in errors)).partition(
        "±"
    )
    lines = [(label_of(stem), f"{number}{rest.split()[-1]}")]
    for what, error, source in errors:
        share = f", {percent(100 * abs(error / value), sign='', digits=1)}" if value else ""
        text = f"± {value_text(error, unit, digits=1)}{share}{source}"
        if error or what == label:
            lines.append((what, text if isfinite(error) else NOT_AVAILABLE))
    return [*lines, ("note", why.removeprefix(": "))]


def _scene(row: Row) -> Lines:
    """Take the operating point, its dimensionless numbers and the equation from a row."""
    units = {name: unit_of_column(name) for name in FACTORS if name in row}
    point = [
        f"{k} = {value_text(row.pop(name), unit, digits=6)}" for name, (k, unit) in units.items()
    ]
    numbers = {name: row.pop(name, 0) for name in NUMBERS}
    named = [f"{label_of(name)} {value_text(each)}" for name, each in numbers.items() if each]
    lines = [("operating point", ", ".join(point)), ("dimensionless", ", ".join(named))]
    return [*lines, ("equation", row.pop("equation", ""))]


def _effects(row: Row) -> Lines:
    """Take the modelling error from a row: lines about all neglected effects, and each of them."""
    if "geometry" not in row:
        return []
    size, unit = row.get("force_n", nan) / 100, "N"
    if "stiffness_n_per_m" in row:
        size, unit = 1e4 * row["load_n"] / abs(row["stiffness_n_per_m"]), "µm"

    def change(*percents: float) -> str:
        ends = " to ".join(plain(size * each) for each in percents)
        return f"{ends} {unit}, " * isfinite(size) + percent(*percents)

    have, invalid = (row.pop(k).split("; ") for k in ("included_effects", "first_order_invalid"))
    ends = [row.pop(f"modelling_error_{end}_percent") for end in ("lower", "upper")]
    other, edge = row.pop("geometry").removeprefix(THIS_SCENE), row.pop("edge_loss_upper_percent")
    status = row.pop("budget_status" if "budget_status" in row else "status")
    total = f"{change(*ends)} of the force" if isfinite(ends[0]) else NOT_AVAILABLE
    total += f": {status}" * (status != "ok") + f" for this pad, but for {other}" * bool(other)
    total += ", not reliable" * bool({*invalid} - {*have, ""})
    names = [name.removesuffix(REMAINDER) for name in row if name.endswith(REMAINDER)]
    effects = {k: (row.pop(f"{k}_percent"), row.pop(f"{k}{REMAINDER}")) for k in names}
    lines, _ = [("modelling error", total)], row.pop("bearing_percent")
    for name, (effect, off) in sorted(effects.items(), key=lambda each: -abs(each[1][0])):
        text = (
            change(effect, *[edge] * (name == "edge_loss")) if isfinite(effect) else NOT_AVAILABLE
        )
        text += f" ± {percent(off, sign='', digits=1)}" * (name == "depth_averaged")
        if name in invalid:
            first = f"first-order estimate {percent(effect)}"
            text = f"not reliable ({first}, outside its validity range)"
        if status == "ok" and name not in have and not abs(effect) + off < LEAST_EFFECT:
            lines.append((f"  {label_of(name)}", text))
    return lines


def _solver(row: Row) -> Lines:
    """Take from a row how its force was found, or would be."""
    sizes = [f"{size:.0f}" for name in ("nx", "ny", "nt") if (size := row.pop(name, 0))]
    flat, folds = row.pop("pad_shape", "rectangle") == "rectangle", row.pop("simplifications", "")
    axes = ("x", "y", "time") if flat else ("radius", "angle", "time")
    grid = f", grid {' × '.join(sizes)} ({', '.join(axes[: len(sizes)])})" * bool(sizes)
    steps = f", {row.get('krylov_iterations')} GMRES iterations" * bool(
        row.pop("krylov_iterations", 0)
    )
    halves = [axis for axis in "xy" if f"mirror half in {axis}" in folds]
    domain = (
        f"{' and '.join(halves) or 'none'} ({('whole', 'half', 'quarter')[len(halves)]} domain)"
    )
    lines = [("solver", row.pop("method", "") + grid + steps), ("symmetry", domain * bool(sizes))]
    if mflop := row.pop("expected_mflop", 0):
        expected = f"± {percent(100 * row.pop('expected_error'), sign='', digits=1)} expected"
        lines.insert(0, ("numerical error", f"{expected} (tolerance {row.pop('tolerance'):g})"))
        lines.append(("expected cost", f"{plain(mflop, sign='')} Mflop"))
    reasons = row.pop("why", "").split("; ")
    return [*lines, *(("not needed", each) for each in reasons if "mirror half" not in each)]


def json_text(row: Mapping[Any, Any]) -> str:
    """Return a row as a JSON object; what is not a number is null."""
    text = json.dumps(row, default=lambda each: each.item())
    values = json.loads(text, parse_constant=lambda name: None)
    return json.dumps(values, ensure_ascii=False, indent=2)
