"""Pictures of tables that commands write: forces, gaps, amplitudes, responses.

Results over the factor with most values, a line for each combination of the others; or a map where
the pad moves along both axes.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import cycle
from typing import Any

import matplotlib as mpl
import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.ticker import ScalarFormatter

from squeezefilm.columns import COLUMNS, Column, error_column
from squeezefilm.dynamics.response import with_gain_errors
from squeezefilm.errors import InputError
from squeezefilm.film.positions import CARTESIAN_COLUMNS, POLAR_COLUMNS, cartesian_from_polar
from squeezefilm.film.validity import OK
from squeezefilm.formatting import NON_NEGATIVE_QUANTITIES
from squeezefilm.units import error_text, split_unit
from squeezefilm_workflow.reporting.figures import parts, style

MARKERS = "os^DvPX*<>ph"
MAX_CURVE_LINES = len(MARKERS)
MAX_MARKERS = 24
"""Of a line, about."""
MAP_WIDTH_IN, MAP_MARGINS_IN, MAP_SHAPE_RANGE = 2.0, 0.7, (0.5, 1.6)
"""Of a map: the width of its axes, title, labels and note, the range of height over width."""


@dataclass(frozen=True)
class DrawnResult:
    """A column that is drawn, those of errors of which a bar is the sum, and its factors.

    Attributes:
        modelling_error_columns: columns of the lower and the upper bound of its modelling error.
        lower_panel_columns: columns that are drawn in panels below, where the table has values of
            them.
        error_kind: what the bars are.
    """

    result_column: str
    error_columns: tuple[str, ...]
    factor_columns: tuple[str, ...]
    modelling_error_columns: tuple[str, ...] = ()
    lower_panel_columns: tuple[str, ...] = ()
    error_kind: str = "numerical error"


POSITION_COLUMNS = (*CARTESIAN_COLUMNS, *POLAR_COLUMNS)
NON_NEGATIVE_COLUMNS = {name for name in COLUMNS if split_unit(name)[0] in NON_NEGATIVE_QUANTITIES}
"""A bar of these does not reach below zero."""
DRAWN_RESULT_OF_COLUMN = {
    "load_n": DrawnResult(
        "h0_m",
        ("h0_error_m", "h0_measurement_noise_m"),
        ("load_n", "hv_m", "mass_kg"),
        ("h0_modelling_error_lower_m", "h0_modelling_error_upper_m"),
        ("stiffness_n_per_m", "resonance_hz"),
    ),
    "hv_error_95_m": DrawnResult("hv_m", ("hv_error_95_m",), ("force_n", "h0_m")),
    "force_n": DrawnResult(
        "force_n",
        ("force_error_n", "measurement_noise_n", "misfit_n", "quadrature_n", "error_95_n"),
        ("h0_m", "hv_m"),
    ),
    "corner_hz": DrawnResult(
        "corner_hz",
        ("corner_error_hz",),
        ("h0_m", "hv_m"),
        lower_panel_columns=("settling_start_s", "instantaneous_fraction"),
        error_kind="error of averaging, of settling also the phase, without neglected effects",
    ),
    "gain": DrawnResult(
        "gain",
        ("gain_error",),
        ("frequency_hz", "h0_m", "hv_m"),
        lower_panel_columns=("phase_deg",),
        error_kind="error of averaging, without neglected effects",
    ),
    "rising_n": DrawnResult(
        "rising_n", (), ("time_s", "h0_m", "hv_m"), lower_panel_columns=("falling_n",)
    ),
}
"""What is drawn of a table that has a column: of levitations, amplitudes, forces, responses,
gains, forces over time."""


def curve_figure(table: pd.DataFrame) -> Figure:
    """Return a picture of a table's result.

    Args:
        table: factors, a result of DRAWN_RESULT_OF_COLUMN with its errors, and ``validity`` and
            ``study``, if any.

    Raises InputError for a table without such a result, for a single point, and for more than
    MAX_CURVE_LINES lines.
    """
    result = next(
        (DRAWN_RESULT_OF_COLUMN[name] for name in DRAWN_RESULT_OF_COLUMN if name in table), None
    )
    if result is None or result.result_column not in table:
        raise InputError(
            "there is nothing to draw; drawn are tables of `simulate`, `predict`, `levitate`, "
            "`amplitude-for` and `response`; of a scan `squeezefilm profile --table FILE` makes "
            "what `squeezefilm plot profile FILE` draws"
        )
    if "gain" in table:
        table = with_gain_errors(table)
    factors = [name for name in (*result.factor_columns, *POSITION_COLUMNS) if name in table]
    pairs = table[[name for name in ("load_n", "mass_kg") if name in table]].drop_duplicates()
    if "mass_kg" in pairs and len(pairs) > 1 and (pairs.nunique() == len(pairs)).all():
        factors.remove("load_n")  # each mass is carried with its weight
    counts = {name: table[name].nunique() for name in factors}
    varied = [name for name in factors if counts[name] > 1]
    known = table[table[result.result_column].notna()]
    error = known[[name for name in result.error_columns if name in table]].sum(axis=1)
    within = known.get("validity", pd.Series(OK, known.index)) == OK
    bounds = [name for name in result.modelling_error_columns if name in table]
    unknown = known[bounds].isna().any(axis=1)
    predictions = [name for name in result.error_columns if "95" in name and name in table]
    not_validated = known[predictions].isna().any(axis=1)
    known = known.assign(error=error, filled=within & ~unknown & ~not_validated)
    distances = [name for name in factors if name in POSITION_COLUMNS and name != "phi_deg"]
    is_centred = not table[distances].any(axis=None)
    at_one = [name for name in factors if counts[name] == 1]
    at_one = [name for name in at_one if not (is_centred and name in POSITION_COLUMNS)]
    title = [_factor_value_text(name, known[name].iloc[0]) for name in at_one if len(known)]
    title += ["pad centred"] * is_centred
    title += [f"study {name}" for name in table.get("study", pd.Series(dtype=str)).unique()]
    if varied in ([*CARTESIAN_COLUMNS], [*POLAR_COLUMNS]):
        figure, *notes = _draw_map(known, result, varied)
    else:
        figure, *notes = _draw_lines(table, known, result, counts, varied)
    figure.axes[0].set_title(", ".join(title), fontsize=7)
    reasons = ["outside the limits of validity"] * (not within.all())
    reasons += ["modelling error unknown"] * bool(unknown.any())
    reasons += ["not validated, error unknown"] * bool(not_validated.any())
    if reasons:
        notes.append(f"Hollow: {' or '.join(reasons)}.")
    if without := len(table) - len(known):
        reason = "status" if "status" in table else "validity or note"
        notes.append(
            f"Without a result: {without} of {len(table)} points; {reason} has the reason."
        )
    style.add_note(figure, *notes)
    return figure


def _factor_value_text(name: str, value: float) -> str:
    column = COLUMNS[name]
    number = f"{column.in_shown_unit(value):.4g}".replace("-", "−")
    return f"{column.title.split()[-1]} = {number} {column.shown_unit}"


def _axis_label(name: str) -> str:
    column = COLUMNS[name]
    unit = _unit_text(column)
    return f"{column.title} ({unit})" if unit else column.title


def _unit_text(column: Column) -> str:
    return (column.shown_unit or column.unit).removesuffix("1")


def _draw_lines(
    table: pd.DataFrame,
    known: pd.DataFrame,
    result: DrawnResult,
    counts: dict[str, int],
    varied: list[str],
) -> tuple[Figure, str]:
    """The result over the factor with most values, a line for each combination of the others."""
    along = max(counts, key=counts.__getitem__)
    others = [name for name in varied if name != along]
    lines = list(known.groupby(others)) if others else [((), known)]
    if counts[along] < 2 or len(lines) > MAX_CURVE_LINES:
        raise InputError(
            f"a curve has 2 points or more, and at most {MAX_CURVE_LINES} lines; points along "
            f"{along}: {counts[along]}, lines: {len(lines)}"
        )
    beside = [
        name for name in result.lower_panel_columns if name in known and known[name].notna().any()
    ]
    panels = [result.result_column, *beside]
    figure, all_axes = style.subplots(
        len(panels), 1, height_in=3.0 + 1.6 * len(beside), sharex=True, squeeze=False
    )
    for axes, name in zip(all_axes[:, 0], panels, strict=True):
        axes.set_ylabel(_axis_label(name))
        axes.grid(True)
    axes.set_xlabel(_axis_label(along))
    top = all_axes[0, 0]
    if along == "frequency_hz":
        top.set_xscale("log")
    colours = mpl.colormaps[style.SEQUENTIAL_COLOURMAP](np.linspace(0, 0.85, len(lines)))
    bounds = [name for name in result.modelling_error_columns if name in known]
    for (_, rows), colour, marker in zip(lines, colours, cycle(MARKERS)):
        rows = rows.sort_values(along)
        at = COLUMNS[along].in_shown_unit(rows[along])
        look: dict[str, Any] = {"color": colour, "marker": marker, "markersize": 3}
        spaced = {"markevery": max(1, len(rows) // MAX_MARKERS)}
        label = ", ".join(_factor_value_text(name, rows[name].iloc[0]) for name in others)
        for axes, name in zip(all_axes[:, 0], panels, strict=True):
            column = COLUMNS[name]
            own = "error" if name == result.result_column else error_column(name)
            value = column.in_shown_unit(rows[name])
            error = column.in_shown_unit(rows.get(own, 0 * rows[name]))
            below = np.minimum(error, value) if name in NON_NEGATIVE_COLUMNS else error
            axes.errorbar(at, value, [below, error], **look, **spaced, label=label)
            doubtful = ~rows["filled"]
            hollow = look | {"linestyle": "", "markerfacecolor": "white", "zorder": 3}
            axes.plot(at[doubtful], value[doubtful], **hollow)
            label = ""
        if bounds:
            low, high = (
                COLUMNS[result.result_column].in_shown_unit(rows[result.result_column] + rows[name])
                for name in bounds
            )
            top.fill_between(at, low, high, color=colour, alpha=0.2, linewidth=0)
    missing = COLUMNS[along].in_shown_unit(
        table.loc[table[result.result_column].isna(), along].unique()
    )
    if len(missing):
        below = {"transform": top.get_xaxis_transform(), "clip_on": False}
        top.plot(missing, np.zeros(len(missing)), "x", color="0.3", **below)
    if others:
        figure.legend(loc="outside upper center", ncols=max(1, 4 - len(others)))
    notes = [_error_bars_text(known, result, beside)]
    if "resonance_hz" in panels:
        notes += ["Bars of the resonance: averaging, thermal effects and inertia."]
        if without := int(known["resonance_hz"].isna().sum()):
            notes += [
                f"Without a resonance: {without} of {len(known)} points; note has the reason."
            ]
    notes += ["Bands: the gap with the modelling error."] * bool(bounds)
    return figure, " ".join(notes)


def _error_bars_text(known: pd.DataFrame, result: DrawnResult, beside: Sequence[str]) -> str:
    """Describe the bars of the result, and their largest length.

    Args:
        beside: results in panels below, whose bars have other lengths.
    """
    if not {*result.error_columns} & {*known}:
        return "Errors: not in the table."
    own = f"of the {COLUMNS[result.result_column].label} " * bool(beside)
    return f"Bars: {_error_kind(known, result)}, {own}at most {_largest_error_text(known, result)}."


def _error_kind(known: pd.DataFrame, result: DrawnResult) -> str:
    columns = [name for name in result.error_columns if name in known]
    if any("95" in name for name in columns):
        return "prediction error (95 %)"
    scanned = any(known[name].any() for name in columns if "noise" in name)
    return f"{result.error_kind} and measurement noise" if scanned else result.error_kind


def _largest_error_text(known: pd.DataFrame, result: DrawnResult) -> str:
    column = COLUMNS[result.result_column]
    error = error_text(column.in_shown_unit(known["error"].max()))
    return f"{error} {_unit_text(column)}".rstrip()


def _draw_map(known: pd.DataFrame, result: DrawnResult, position: list[str]) -> tuple[Figure, str]:
    """The result over the pad's position."""
    at = {name: known[name] for name in position}
    x_m, y_m = (at if position == [*CARTESIAN_COLUMNS] else cartesian_from_polar(**at)).values()
    column = COLUMNS[result.result_column]
    dots = pd.DataFrame(
        {"x": 1e3 * x_m, "y": 1e3 * y_m, "value": column.in_shown_unit(known[result.result_column])}
    )
    dots = dots.assign(filled=known["filled"]).round({"x": 9, "y": 9}).drop_duplicates(["x", "y"])
    height_over_width = np.ptp(dots["y"]) / max(np.ptp(dots["x"]), 1e-9)
    height_in = MAP_WIDTH_IN * float(np.clip(height_over_width, *MAP_SHAPE_RANGE)) + MAP_MARGINS_IN
    figure, axes = style.subplots(height_in=height_in)
    try:
        drawn = axes.tricontourf(dots["x"], dots["y"], dots["value"], levels=14)
    except (ValueError, RuntimeError):
        raise InputError("the positions lie on a line, or are fewer than three: no map") from None
    for filled, rows in dots.groupby("filled"):  # none without points: its extent is the corner's
        fill = "black" if filled else "white"
        parts.draw_dots(axes, rows, fill=fill, x="x", y="y", markersize=2.6)
    axes.set(aspect="equal", xlabel=_axis_label("x_m"), ylabel=_axis_label("y_m"))
    ticks = ScalarFormatter(useOffset=False)
    figure.colorbar(drawn, ax=axes, pad=0.02, format=ticks, label=_axis_label(result.result_column))
    kind, largest = _error_kind(known, result), _largest_error_text(known, result)
    error = f"{kind[0].upper()}{kind[1:]}: at most {largest}."
    return figure, f"{error} Colours: interpolated linearly between dots."
