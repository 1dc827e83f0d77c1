"""Figures of a film: effects that the equation neglects, loads, modulation."""

from functools import partial
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from squeezefilm.columns import COLUMNS
from squeezefilm.film.positions import find_position_columns
from squeezefilm.film.validity import OK
from squeezefilm.formatting import column_label
from squeezefilm.solution import MODELLING_ERROR_COLUMNS
from squeezefilm.units import error_text
from squeezefilm_workflow.reporting.figures import parts, style
from squeezefilm_workflow.reporting.notes import (
    bound_percent_text,
    reynolds_validity_limit,
    signed_text,
)
from squeezefilm_workflow.reporting.results import Results

COLOUR_OF_EFFECT = {
    "inertia": style.BLUE,
    "slip": style.VERMILLION,
    "thermal": style.ORANGE,
    "edge_loss": style.GREEN,
    "edge_flow": style.PURPLE,
    "total": style.GREY,
}
CONTOUR_MARGIN_FRACTION = 0.04
"""Contours nearer to the least or the largest value, as a share of the range, have no room."""
LABEL_HEIGHT_FRACTION = 0.065
"""Height of a label, as a share of the axes."""
LINE_COLOURS = (style.BLUE, style.GREEN, style.VERMILLION, style.PURPLE)
MAX_DRAWN_GAIN_ERROR = 0.03
"""Of a gain that is drawn."""
MAX_VALID_REYNOLDS = reynolds_validity_limit("inertia neglected").not_applicable_above


def error_budget(results: Results) -> Figure:
    """A map for each effect and for their sum, and lines over the position."""
    screen = _budgets_of_plan(results, "screen")
    along = _budgets_of_plan(results, "four_factor")
    figure = style.new_figure(wide=True, height_in=4.3)
    grid = figure.add_gridspec(2, 4)
    squares = [grid[row, column] for row, columns in ((0, 4), (1, 2)) for column in range(columns)]
    *panels, last = [figure.add_subplot(part) for part in (*squares, grid[1, 2:])]
    maps = zip("abcdef", panels, COLOUR_OF_EFFECT.items(), strict=True)
    for letter, axes, (name, colour) in maps:
        look: dict[str, Any] = {"colors": colour, "linestyles": "solid"}
        look["levels"] = _contour_levels(screen[f"{name}_percent"])
        title = f"({letter}) {_panel_title(screen['included_effects'], name)} (%)"
        _draw_map(
            axes, screen, f"{name}_percent", title, form=partial(signed_text, digits=3), **look
        )
        axes.title.set_fontsize(6)
    shown = _draw_effects(last, along)
    lower, upper = screen[MODELLING_ERROR_COLUMNS].to_numpy().T
    off, half = _errors_text(screen["edge_flow_error_percent"]), _errors_text((upper - lower) / 2)
    first = f"Differences of solved forces; (d): C = 1; (e): {off}. Total: middle of the interval, "
    first += f"(f): {half}, band: the interval."
    place = f"h0 = {along['h0_um'].iloc[0]:.3g} µm, hv = {along['hv_um'].iloc[0]:.3g} µm"
    notes = f"{first} {parts.interpolation_note(screen)}", f"(g): {place}; {shown}"
    style.add_note(figure, *notes, results.validity_note)
    return figure


def _counts_text(reasons: pd.Series, *, of: int) -> str:
    """Return each reason with the number of the films that have it."""
    counts = reasons.value_counts(sort=False)
    return "; ".join(f"{count} of {of} films: {reason}" for reason, count in counts.items())


def _errors_text(errors: Any) -> str:
    """Return the least and the largest of the films' errors, in % of the force."""
    known = np.asarray(errors, dtype=float)
    known = known[np.isfinite(known)]
    if not known.size:
        return "error not known"
    ends = dict.fromkeys((error_text(known.min()), error_text(known.max())))
    return f"± {' to '.join(ends)} %"


def _panel_title(included_effects: pd.Series, name: str) -> str:
    """Return an effect's name and in how many of the films the forces include the effect."""
    if name == "total":
        return "all neglected effects"
    films, number = len(included_effects), sum(name in row for row in included_effects)
    state = {0: "neglected", films: "included"}.get(number, f"included in {number} of {films}")
    return f"{column_label(name)}, {state}"


def _budgets_of_plan(results: Results, plan: str) -> pd.DataFrame:
    effects = (f"{name}_percent" for name in COLOUR_OF_EFFECT if name != "total")
    table = results.budget(plan, *effects, "edge_flow_error_percent")
    lengths = [name for name in find_position_columns(table) if name.endswith("_m")]
    return parts.with_micrometre_columns(table).assign(
        **{f"{name[:-1]}mm": parts.metres_to_micrometres(table[name]) / 1e3 for name in lengths},
        total_percent=table[MODELLING_ERROR_COLUMNS].mean(axis="columns", skipna=False),
    )


def _contour_levels(values: pd.Series) -> list[float]:
    """Levels of contours with room for them between the least and the largest value."""
    low, high = values.min(), values.max()
    edge = CONTOUR_MARGIN_FRACTION * (high - low)
    ticks = MaxNLocator(nbins=8).tick_values(low, high) if len(values.dropna()) else []
    return [level for level in ticks if low + edge <= level <= high - edge] or [low]


def _draw_effects(axes: Axes, rows: pd.DataFrame) -> str:
    """Draw each effect over the first coordinate, for the least of the other and the largest.

    Positions that share no coordinate are dots without lines. Returns what the markers mean.
    """
    on_disc = "phi_deg" in rows
    coordinate, other = ("phi_r_mm", "phi_deg") if on_disc else ("x_mm", "y_mm")
    rows = rows.drop_duplicates([coordinate, other]).sort_values(coordinate)
    off = rows[rows[coordinate] != 0]
    least, farthest = min(0.0, float(rows[coordinate].min())), float(rows[coordinate].max())
    ends: list[tuple[float, str, str]] = []
    hollow: dict[str, Any] = {"marker": "o", "mfc": "white", "ms": 6}
    full: dict[str, Any] = {"marker": "s", "ms": 3}
    ends_of_other = off[other].min(), off[other].max()
    scattered = off[other].value_counts()[[*ends_of_other]].max() < 2
    centre = rows[coordinate] == 0 if on_disc else False
    lines = [(hollow, centre | (rows[other] == ends_of_other[0]))] if not scattered else []
    lines += [(full, (rows[other] == ends_of_other[1]) | centre | scattered)]
    full |= {"linestyle": "none"} if scattered else {}
    for look, chosen in lines:
        along = rows[chosen].drop_duplicates(coordinate)
        for name, colour in COLOUR_OF_EFFECT.items():
            values = along[f"{name}_percent"]
            axes.plot(along[coordinate], values, color=colour, **look)
            if name == "total" and not scattered:
                ends_of_total = along[MODELLING_ERROR_COLUMNS].to_numpy().T
                axes.fill_between(along[coordinate], *ends_of_total, color=colour, alpha=0.15, lw=0)
            if look is full and np.isfinite(values.iloc[-1]):
                ends.append((float(values.iloc[-1]), column_label(name), colour))
    # From the lowest up and none over another.
    low, high = axes.get_ylim()
    last = -np.inf
    for value, text, colour in sorted(ends):
        last = max(value, last + LABEL_HEIGHT_FRACTION * (high - low))
        parts.annotate_at(
            axes, text, (farthest, last), (6, 0), va="center", color=colour, fontsize=6
        )
    axes.set_xlim(least - 0.05 * farthest, farthest + 0.7 * (farthest - least) or 1.0)
    axes.hlines(0, least, farthest, color="black", linewidth=0.5)
    ticks = MaxNLocator(nbins=5, steps=[1, 2, 5, 10]).tick_values(least, farthest)
    axes.set_xticks([tick for tick in ticks if least <= tick <= farthest])
    label = r"radial position $\phi_r$ (mm)" if on_disc else "$x$ (mm)"
    axes.set(xlabel=label, ylabel="change of the force (%)")
    axes.set_title(f"(g) along {'the radius' if on_disc else 'x'}")
    axes.grid(True)
    name, unit = (r"$\phi_\varphi$", "°") if on_disc else ("$y$", " mm")
    least, largest = ends_of_other
    if scattered:
        return f"squares: positions, {name} from {least:.3g} to {largest:.3g}{unit}.".replace(
            "-", "−"
        )
    return f"circles: {name} = {least:g}{unit}, squares: {name} = {largest:g}{unit}."


def response(results: Results) -> Figure:
    """Two maps of gap and amplitude above lines over the frequency of modulation."""
    errors = ("corner_error_hz", "instantaneous_fraction_error")
    file = "simulations/screen/response.csv"
    table = results.table(file, "h0_m", "hv_m", "corner_hz", *errors)
    table.loc[table["corner_error_hz"] >= table["corner_hz"], "corner_hz"] = np.nan
    table["instantaneous_percent"] = 100 * table["instantaneous_fraction"]
    maps = parts.with_micrometre_columns(table)
    columns = ("h0_m", "hv_m", "frequency_hz", "gain", "phase_deg", "error")
    lines = parts.with_micrometre_columns(results.table("simulations/screen/gains.csv", *columns))
    lines = lines[
        (lines["hv_um"] == lines["hv_um"].max()) & (lines["error"] <= MAX_DRAWN_GAIN_ERROR)
    ]
    figure, ((corner, prompt), (gain, phase)) = style.subplots(2, 2, wide=True, height_in=4.6)
    _draw_map(corner, maps, "corner_hz", "(a) corner frequency (Hz)")
    _draw_map(prompt, maps, "instantaneous_percent", "(b) fraction present at start (%)")
    _draw_lines(gain, lines, "gain", "(c) gain")
    gain.set_ylabel("relative force change over\nrelative amplitude change (–)")
    _draw_lines(phase, lines, "phase_deg", "(d) phase")
    phase.set_ylabel("phase of the force (°)")
    unknown = maps.loc[maps["status"] != OK, "status"].str.removeprefix("not supported: ")
    notes = [f"(a, b): {parts.interpolation_note(maps)}"]
    corner_errors = (maps["corner_error_hz"] / maps["corner_hz"]).dropna()
    if len(corner_errors):
        fraction_error = maps["instantaneous_fraction_error"].max()
        notes[0] += (
            f" Error of (a) up to {bound_percent_text(corner_errors.max())}, of (b) up to "
            f"{bound_percent_text(fraction_error)} of the settled force."
        )
    if len(lines):
        notes.append(
            f"(c, d): hv = {lines['hv_um'].iloc[0]:.3g} µm; relative error up to "
            f"{bound_percent_text(lines['error'].max())}; negative: the force lags."
        )
    if len(unknown):
        reasons = unknown.str.split(" (", regex=False).str[0]
        notes.append(f"Not available, {_counts_text(reasons, of=len(maps))}.")
    if len(outside := maps[maps["validity"] != OK]):
        # Each film has a number of its own.
        reasons = outside["validity"].str.replace(r" = [\d.e+-]+", "", regex=True)
        notes.append(f"Outside the limits of validity, {_counts_text(reasons, of=len(maps))}.")
    style.add_note(figure, *notes)
    return figure


def _draw_map(
    axes: Axes, maps: pd.DataFrame, name: str, title: str, *, form: Any = "%.4g", **look: Any
) -> None:
    """Contour lines of a quantity of the films; numbers where lines would have no room."""
    grid = parts.grid_arrays_of_table(maps, name)
    axes.set(**parts.GAP_AMPLITUDE_LABELS, title=title)
    parts.limit_axes_to_grid(axes, grid)
    known = maps[maps[name].notna()]
    if known.empty:
        parts.write_not_known(axes)
        return
    if min(known["h0_um"].nunique(), known["hv_um"].nunique()) < 2:  # no lines between films
        axes.plot(known["h0_um"], known["hv_um"], "k.", markersize=3)
        for h0_um, hv_um, value in known[["h0_um", "hv_um", name]].to_numpy():
            axes.text(h0_um, hv_um, f"  {value:.3g}", fontsize=6, va="center")
        axes.margins(0.05)
        axes.autoscale()
        return
    usual: dict[str, Any] = {"colors": "black", "levels": 7, "linewidths": 0.9}
    lines = axes.contour(*grid[:2], np.ma.masked_invalid(grid[2]), **usual | look)
    axes.clabel(lines, fontsize=6, fmt=form)


def _draw_lines(axes: Axes, lines: pd.DataFrame, name: str, title: str) -> None:
    """One line for each of three gaps, named in a legend beside the gain."""
    axes.set_title(title)
    gaps = sorted(lines["h0_um"].unique())
    if not gaps:
        parts.write_not_known(axes)
        return
    axes.set(xscale="log", xlabel="frequency of modulation (Hz)")
    axes.grid(True)
    chosen = dict.fromkeys(gaps[index] for index in (0, len(gaps) // 2, -1))
    for gap, colour in zip(chosen, LINE_COLOURS, strict=False):
        line = lines[lines["h0_um"] == gap].sort_values("frequency_hz")
        axes.plot(line["frequency_hz"], line[name], color=colour, label=f"{gap:.3g} µm")
    if name == "gain":
        axes.legend(title="$h_0$", fontsize=6, title_fontsize=6)


def levitation(results: Results) -> Figure:
    """Gap and stiffness over the load, for each amplitude of the table; hollow beyond Re 10."""
    table = results.table("simulations/screen/levitation.csv", "load_n", "hv_m", "h0_m", "status")
    screen = parts.with_micrometre_columns(results.scenes("screen"))
    data = parts.with_micrometre_columns(table).assign(
        stiffness_kn_per_m=COLUMNS["stiffness_n_per_m"].in_shown_unit(table["stiffness_n_per_m"])
    )
    figure, (gap, stiffness) = style.subplots(1, 2, wide=True, height_in=2.6)
    gap.axhspan(screen["h0_um"].min(), screen["h0_um"].max(), color="0.92", zorder=0)
    amplitudes = sorted(data["hv_um"].unique())
    for amplitude, colour in zip(amplitudes, LINE_COLOURS, strict=False):
        rows = data[data["hv_um"] == amplitude].dropna(subset="h0_um").sort_values("load_n")
        within = rows["modified_reynolds"] <= MAX_VALID_REYNOLDS
        label = f"$h_v$ = {amplitude:.3g} µm"
        for axes, name in ((gap, "h0_um"), (stiffness, "stiffness_kn_per_m")):
            axes.plot(rows["load_n"], rows[name], color=colour, label=label)
            for fill, some in ((colour, rows[within]), ("white", rows[~within])):
                axes.plot(some["load_n"], some[name], "o", color=colour, markerfacecolor=fill, ms=4)
        # Contact, beyond the last load with a gap: no line of another amplitude is crossed.
        last_n, most_n = rows["load_n"].max(), data["load_n"].max()
        gap.plot([last_n, 1.2 * most_n], 2 * [amplitude], ":", color=colour, linewidth=1.2)
    gap.set(title="(a) gap", ylabel="gap $h_0$ (µm)")
    stiffness.set(title="(b) stiffness", ylabel="stiffness (kN/m)")
    for axes in (gap, stiffness):
        axes.set(xscale="log", yscale="log", xlabel="load (N)")
        style.set_plain_log_ticks(axes.xaxis)
        style.set_plain_log_ticks(axes.yaxis)
        axes.grid(True)
    stiffness.legend(fontsize=6)
    known = table[table["h0_m"].notna()]
    note = f"A gap is given for {len(known)} of {len(table)} pairs of load and amplitude"
    ends = known[["h0_modelling_error_lower_m", "h0_modelling_error_upper_m"]].abs().max(axis=1)
    if (shares := (ends / known["h0_m"]).dropna()).size:
        note += f"; modelling error up to {bound_percent_text(float(shares.max()))} of a gap"
    marks = "Dotted: h0 = hv (contact); grey: gaps of the study"
    if len(amplitudes) < (levels := screen["hv_um"].nunique()):
        marks = f"{len(amplitudes)} of the screen's {levels} amplitudes. {marks}"
    if (known["modified_reynolds"] > MAX_VALID_REYNOLDS).any():
        marks += f"; hollow: Re above {MAX_VALID_REYNOLDS:g}"
    style.add_note(figure, f"{note}.", f"{marks}.", results.validity_note)
    return figure
