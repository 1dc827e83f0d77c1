"""Commands about a film in use: the gap under a load, and how forces follow an amplitude."""

from __future__ import annotations

import argparse
import sys
from typing import Any

import numpy as np

from squeezefilm.api.dynamics import (
    DEFAULT_FREQUENCIES_TEXT,
    levitation_scenes,
    levitations,
    parse_loads,
)
from squeezefilm.cli.options import (
    FILM_OPTIONS,
    SCENES_ARGUMENT,
    SOLVER_OPTIONS,
    command,
    factor_options,
    film_of_options,
    option,
    points_of_options,
    points_unless_scenes_table,
    print_table,
    result_text,
    study_name_column,
    table_output_option,
    write_or_print_rows,
)
from squeezefilm.dynamics.levitation import valid_range_text
from squeezefilm.dynamics.levitation_tables import levitation_table
from squeezefilm.dynamics.response import (
    gain_table,
    response_table,
    start_and_stop_table,
    with_gain_errors,
)
from squeezefilm.errors import InputError, RunError, prefix_errors
from squeezefilm.film.positions import CARTESIAN_COLUMNS
from squeezefilm.film.validity import OK, validity_text
from squeezefilm.formatting import (
    NOT_AVAILABLE_TEXT,
    error_text_in_unit,
    interval_text,
    labelled_text,
    scene_row,
    value_text,
)
from squeezefilm.lazy import pd
from squeezefilm.parallel import print_step
from squeezefilm.table_writer import write_table
from squeezefilm.tables import read_scenes
from squeezefilm.units import parse_quantities

MOTION_ERRORS_TEXT = "of stiffness, resonance and damping ratio: without the modelling error"


@command(
    option("--load", "QUANTITY", "e.g. 0.5N; 0.1N,0.2N; 0.1:1:10N"),
    option("--mass", "QUANTITY", "levitated mass, e.g. 50g; 50g,60g, for the resonance"),
    table_output_option(
        "--output", "LEVITATION.csv", "table of all columns to write, a row per load and point"
    ),
    *SOLVER_OPTIONS,
    factor_options("h0"),
)
def levitate(options: argparse.Namespace) -> None:
    """The gap at which the film carries a load, its stiffness, resonance and damping.

      squeezefilm levitate --load 0.5N --hv 1.5um [--mass 50g]
      squeezefilm levitate --mass 10:50:5g --hv 1.5um
      squeezefilm levitate --load 0.1:1:10N --hv 1um,2um --output LEVITATION.csv

    The gap is found by simulations at the pad's position. Its modelling error is the modelling
    error of the force divided by the stiffness; `h0_error_m` is the numerical error, and
    `h0_measurement_noise_m` what the noise of a scanned profile adds.

    There is no gap where no gap carries the load, where the modelling error (by the known effects,
    where one is unknown) exceeds a tenth of the gap, and outside the limits of validity of the
    film equation. The `status` of a row gives the reason, and the exit status is 1; a single load
    ends with the ranges within the limits of validity. Where `unknown_effects` is not empty, the
    modelling error is unknown: do not use the gap without a measurement.

    `stiffness_n_per_m` is −∂F/∂h0 for slow motion at constant amplitude; its error does not contain
    the noise of the scan. `stable` means that the force falls as the gap grows; oscillations may
    still grow. The errors of stiffness, resonance and damping ratio do not contain the modelling
    error.

    `other_gaps_m` are approximate smaller gaps that carry the same load. Without --load the load is
    the weight of each mass. With a mass, `resonance_hz` = |Im λ|/2π and `damping_ratio` = −Re λ/|λ|
    (1 is critical) describe its vertical free oscillation exp(λt), where λ is the root of the
    equation of motion with the film's stiffness at λ. Their errors contain that of this stiffness,
    at the gap found.

    `modelling_error_lower_percent` and `…_upper_percent` bound the change of the force by neglected
    effects. `note` gives the terms that `auto` does not include, those included near their limit,
    the reason for a resonance that is missing or has an error as large as itself, and a slower
    return of the gap without oscillation. Of several loads each gap is printed on stderr as soon as
    it is known.
    """
    film = film_of_options(options)
    if options.hv is None or options.load is options.mass is None:
        raise InputError("give --load and --hv, or --mass and --hv")
    loads = parse_loads(options.load, options.mass, option="--{}")
    points = points_of_options(options, times=len(loads))
    scenes = levitation_scenes(film, points, option="--{}")
    alone = options.output is None and len(scenes) * len(loads) == 1
    rows = []
    for row in levitations(film, scenes, loads):
        rows.append(row)
        if not alone:
            gap = _named(_gap_texts(row)) if row["status"] == OK else row["status"]
            print_step(f"{_named(_load_texts(row))}: {gap}")
    if (scan := film.scan) is not None:
        without = "note: the error of the stiffness does not include the scan's measurement noise"
        print(without, *scan.warnings, sep="\n", file=sys.stderr)
    if not alone:
        if options.output is None:
            texts = pd.DataFrame([_load_texts(row) | _levitation_texts(row) for row in rows])
            texts = texts.assign(status=texts.pop("status"))  # the last column
            print_table(texts.fillna(""), errors=MOTION_ERRORS_TEXT)
        else:
            write_table(levitation_table(rows).assign(**study_name_column(options)), options.output)
        if missing := sum(row["status"] != OK for row in rows):
            raise RunError(f"no gap for {missing} of {len(rows)} rows; `status` has the reason")
        return
    status = rows[0]["status"]
    if options.json or status == OK:
        print(result_text(rows[0], options))
    if status != OK:
        raise RunError(
            f"{status}; {valid_range_text(scenes[0], **film.solver().levitation_arguments)}"
        )


def _load_texts(row: dict[str, Any]) -> dict[str, str]:
    """Return mass, load, amplitude and position of a row by their labels."""
    texts = {"mass": f"{1e3 * row['mass_kg']:.6g} g"} if "mass_kg" in row else {}
    texts |= {"load": value_text(row["load_n"], "N"), "hv": value_text(row["hv_m"], "m")}
    return texts | {name[0]: value_text(row[name], "m") for name in CARTESIAN_COLUMNS if row[name]}


def _gap_texts(row: dict[str, Any]) -> dict[str, str]:
    """Return the gap of a row and its errors by their labels."""
    ends = [1e6 * row[f"h0_modelling_error_{end}_m"] for end in ("lower", "upper")]
    known = np.isfinite(ends).all()
    texts = {"gap": value_text(row["h0_m"], "m", error=row["h0_error_m"])}
    texts["modelling error"] = f"{interval_text(*ends)} µm" if known else NOT_AVAILABLE_TEXT
    if noise_m := row["h0_measurement_noise_m"]:
        noise = error_text_in_unit(noise_m, value=row["h0_m"], unit="m")
        texts["measurement noise"] = f"± {noise}"
    return texts


def _named(texts: dict[str, str]) -> str:
    return ", ".join(f"{label} {text}" for label, text in texts.items())


def _levitation_texts(row: dict[str, Any]) -> dict[str, str]:
    """Return the results of a row by their labels, or the reason for none."""
    if row["status"] != OK:
        return {"status": row["status"]}
    names = ("stiffness_n_per_m", "resonance_hz", "damping_ratio", "stable", "unknown_effects")
    texts = dict(labelled_text(name, row) for name in names if name in row)
    short = {label: text.partition(" (")[0] for label, text in texts.items()}
    return _gap_texts(row) | short | {"status": OK, "note": row["note"]}


@command(
    SCENES_ARGUMENT,
    table_output_option("--output", "RESPONSE.csv", "table to write, a row per scene"),
    table_output_option("--gains", "GAINS.csv", "table to write, a row per scene and frequency"),
    table_output_option(
        "--steps",
        "STEPS.csv",
        "table to write of the mean force after start and stop, a row per scene and time",
    ),
    option(
        "--frequencies",
        "QUANTITY",
        f"of the modulation: several with commas, or first:last:count; {DEFAULT_FREQUENCIES_TEXT}",
        default=DEFAULT_FREQUENCIES_TEXT,
    ),
    *FILM_OPTIONS,
    factor_options(),
)
def response(options: argparse.Namespace) -> None:
    """Response of the mean force to a changing amplitude: gain, phase and settling times.

      squeezefilm response --h0 5um --hv 2.2um [--frequencies 10Hz,100Hz,300Hz]
      squeezefilm response --h0 5:10:6um --hv 1um,2um --output RESPONSE.csv [--gains GAINS.csv]
      squeezefilm response SCENES.csv --config CONFIG.yaml --steps STEPS.csv

    The gain is the relative change of the force per relative change of the amplitude: 2 or a
    little more for slow modulation (`static_gain`, whose relative error is `error`).

    Part of the force follows at once (`instantaneous_fraction`; `lasting_fraction` remains when the
    surface stops), the rest with the gas that passes the film edge: `instantaneous_gain` is what
    remains of the gain far above `corner_hz`, at which the difference of both gains has fallen by
    3 dB. `settling_start_s` is the time until the force stays within 5 % after the surface starts,
    `settling_stop_s` until 5 % is left after it stops. Their errors contain the phase of the start
    or stop; the fractions are means over it.

    By the film equation averaged over a period of the vibration, without inertia and thermal
    effects; films whose averaged settled force is over 3 % in error are not supported. What the
    averaged equation neglects is stated as a change in %: first-order slip by the same equation
    with slip, inertia and thermal effects by the periodic forces' gain for slow modulation (their
    effect on corner and settling times is not available).

    `validity` is `ok`, or the limits of validity that a scene exceeds under this equation.
    The exit status is 1 for a single scene outside them, and where a scene has no response.
    """
    film = film_of_options(options)
    points = points_unless_scenes_table(options)
    frequency_hz = np.array(
        parse_quantities(options.frequencies, option="--frequencies", unit="Hz")
    )
    table = read_scenes(options.scenes) if options.scenes else pd.DataFrame(points)
    alone = not options.scenes and len(table) == 1
    if not alone and options.output is options.gains is options.steps is None:
        raise InputError("several scenes need --output, --gains or --steps")
    with prefix_errors(options.scenes):
        scenes = film.scenes(table)
    if alone or options.gains is not None:
        gained = gain_table(table, scenes, frequency_hz)
    if alone or options.output is not None:
        solver = film.solver()
        table_of_responses = response_table(
            table, scenes, tolerance=solver.tolerance, device=solver.device
        )
        if alone and table_of_responses["status"].iloc[0] != OK:
            raise RunError(table_of_responses["status"].iloc[0])
        for reason in gained.loc[gained["status"] != OK, "status"] if alone else ():
            raise InputError(f"--frequencies {options.frequencies}: {reason}")
        if alone and options.output is None:
            shown = ["error"] if options.json else ["gain_error", "phase_error_deg"]
            shown = ["frequency_hz", "gain", "phase_deg", *shown]
            own = with_gain_errors(gained)[shown].to_dict("records")
            row = table_of_responses.to_dict("records")[0] | {
                "gains": own,
                **scene_row(scenes[0].viscous()),
            }
            row["static_gain_error"] = row["error"] * row["static_gain"]
            row["equation"] = f"period-averaged {row['equation']}"
            row["note"] = (
                "of inertia and thermal effects only the change of the static gain is known"
            )
            print(result_text(row, options))
        else:
            write_or_print_rows(table_of_responses, options)
    if options.gains is not None:
        write_table(gained, options.gains)
    if options.steps is not None:
        write_table(start_and_stop_table(table, scenes), options.steps)
    if alone and (valid := validity_text(scenes[0].viscous())) != OK:
        raise RunError(f"outside the limits of validity: {valid}")
    if options.output is not None and (table_of_responses["status"] != OK).any():
        missing = sum(table_of_responses["status"] != OK)
        raise RunError(f"{missing} of {len(table)} scenes have no response: see `status`")
