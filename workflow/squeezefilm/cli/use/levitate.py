"""The gap at which the film carries a load, its stiffness, and whether it is stable.

  squeezefilm levitate --load 0.5N --hv 1.5um [--mass 50g]
  squeezefilm levitate --mass 10g --hv 1.5um
  squeezefilm levitate --load 0.1N:1N:10 --hv 1um,2um --output LEVITATION.csv
  squeezefilm levitate --like FORCES.csv --config CONFIG.yaml --output LEVITATION.csv

Each gap is sought with simulations, at the finger's place. Its modelling error is that of the
force, by what the film equation neglects, over the stiffness; the numerical error and a measured
profile's noise are in `h0_error_m` alone. No gap is given where the modelling error is more than a
tenth of the gap, or outside the film equation's limits of validity: a row of a table keeps the
reason as its `status`, as a load that no gap carries does; one load alone ends with exit status 1
and the range of loads that have a gap.
`stiffness_n_per_m` is that of slow motion, −∂F/∂h0 with the amplitude kept and without the scan's
noise, and `stable` is said of vertical motion alone. `others_m` are smaller gaps, roughly, that
carry the same load. With a mass, which is its own load where none is given, `resonance_hz` and
`damping_ratio` (1 is critical) are those of its free oscillation exp(st), vertically, |Im s|/2π and
−Re s/|s|: s is the root of its equation of motion with the film's stiffness at s.
`left_out_least_percent` and `…_most_percent` of the force say what neglected effects are worth,
with what higher orders may add, and `above_range` names what is too large for a first order. `note`
says which terms `auto` does not include and why, what stretches an included term, and why there is
no resonance. `--like` takes eight loads and three amplitudes over the range of a table of forces.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from dataclasses import replace
from math import isfinite
from typing import Any

import numpy as np
import pandas as pd

from squeezefilm.api.forces import scan_parts
from squeezefilm.cli import which_study
from squeezefilm.cli.options import add_point_options, points_in
from squeezefilm.config.loading import Config
from squeezefilm.dynamics.levitation import (
    Levitation,
    Resonance,
    levitate,
    resonance,
    trustworthy,
)
from squeezefilm.errors import InputError, RunError
from squeezefilm.film.validity import GAPS_M, check_scene
from squeezefilm.parallel import progress_bar
from squeezefilm.quantities.model_error import budget_text
from squeezefilm.reynolds import node_cache
from squeezefilm.studies.solver_settings import add_solver_arguments, device_of, solver_settings
from squeezefilm.studies.study import scenes_in, smoothed_scan_of
from squeezefilm.tables import read_forces, write_table
from squeezefilm.units import quantities, quantity

LOADS, AMPLITUDES = 8, 3
AMPLITUDES_M = (1e-9, 1e-4)
GRAVITY_M_PER_S2 = 9.80665
COLUMNS = [
    "load_n",
    "hv_m",
    "h0_m",
    "h0_error_m",
    "h0_modelling_error_lower_m",
    "h0_modelling_error_upper_m",
    "others_m",
    "stiffness_n_per_m",
    "stiffness_error_n_per_m",
    "stable",
    "epsilon",
    "modified_reynolds",
    "inertia",
    "left_out_least_percent",
    "left_out_most_percent",
    "above_range",
    "status",
    "note",
]
MASS_COLUMNS = ["resonance_hz", "damping_ratio"]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--load", metavar="QUANTITY", help="e.g. 0.5N; 0.1N,0.2N; 0.1N:1N:10")
    parser.add_argument("--mass", metavar="QUANTITY", help="that floats, e.g. 50g, for a resonance")
    parser.add_argument("--like", metavar="FORCES.csv", help="loads and amplitudes of a table")
    parser.add_argument("--output", metavar="LEVITATION.csv", help="table to write, a row a load")
    parser.add_argument("--config", metavar="CONFIG.yaml", help=which_study.HELP)
    parser.add_argument(
        "--device", help="instead of SQUEEZEFILM_DEVICE and the config's solver.device"
    )
    add_solver_arguments(parser)
    add_point_options(parser, without=("h0",))


def run(options: argparse.Namespace) -> None:
    config = which_study.film_at(options.config)
    settings = solver_settings(config, tolerance=options.tolerance, method=options.method)
    mass_kg = None if options.mass is None else quantity(options.mass, option="--mass", unit="kg")
    if mass_kg is not None and mass_kg <= 0:
        raise InputError(f"--mass {options.mass!r} must be positive")
    loads_n, points = _asked(options, mass_kg=mass_kg)
    with node_cache.one_build_at_a_time():
        device = device_of(config, option=options.device)
    how = settings.how(device) | {"model_tolerance": settings.model_tolerance}
    table, failures, found, moving = levitations(loads_n, points, config, how, mass_kg=mass_kg)
    smoothed = smoothed_scan_of(config)
    if smoothed is not None:
        without = "note: errors of stiffness are without the scan's"
        print(without, *smoothed.warnings, sep="\n", file=sys.stderr)
    if options.output is not None:
        write_table(table, options.output)
        return
    if len(table) > 1:
        print(table.to_string(index=False, na_rep="", float_format="{:.4g}".format))
        return
    if failures:
        failures.append(trustworthy(scenes_in(points, config)[0], **how))
        raise RunError("; ".join(failures))
    assert found is not None
    _show(found)
    if moving is not None:
        print(f"vertical motion of {mass_kg:g} kg: {_words(moving)}")


def levitations(
    loads_n: Sequence[float],
    points: pd.DataFrame,
    config: Config,
    how: dict[str, Any],
    *,
    mass_kg: float | None = None,
) -> tuple[pd.DataFrame, list[str], Levitation | None, Resonance | None]:
    """A table with a row for each point and load, the failures, and the last gap in full."""
    smoothed, rows, failures = smoothed_scan_of(config), [], []
    found = moving = None
    with progress_bar(len(loads_n) * len(points), unit="load", name="levitate") as bar:
        for scene in scenes_in(points, config, check=False):
            for load_n in loads_n:
                row: dict[str, object] = {"load_n": load_n, "hv_m": scene.hv_m}
                try:
                    check_scene(scene)
                    found = levitate(scene, load_n=load_n, **how)
                    if smoothed is not None:
                        (part,) = scan_parts([found.scene], smoothed, device=how["device"])
                        more_m = part.total_n / abs(found.stiffness_n_per_m)
                        found = replace(found, h0_error_m=found.h0_error_m + more_m)
                    moving = None if mass_kg is None else resonance(found, mass_kg=mass_kg)
                    row |= _row(found, moving)
                except (InputError, RunError) as error:
                    row["status"] = str(error).removeprefix("load: ")
                    failures.append(str(error))
                rows.append(row)
                bar.update(1)
    columns = COLUMNS + MASS_COLUMNS * (mass_kg is not None)
    return pd.DataFrame(rows).reindex(columns=columns), failures, found, moving


def like(path: str) -> tuple[list[float], list[float]]:
    """Loads and amplitudes over the range of a table of forces."""
    table = read_forces(path)
    known = table.loc[table["force_n"] > 0, "force_n"]
    if known.empty:
        raise InputError(f"{path}: has no force above 0")
    loads_n = [float(each) for each in np.geomspace(known.min(), known.max(), LOADS)]
    levels = np.sort(table["hv_m"].unique())
    places = np.linspace(0, len(levels) - 1, AMPLITUDES).round().astype(int)
    return loads_n, list(dict.fromkeys(levels[places].tolist()))


def _asked(
    options: argparse.Namespace, *, mass_kg: float | None
) -> tuple[list[float], pd.DataFrame]:
    """Loads, or the mass's weight, and the places and amplitudes that they are asked at."""
    if options.like is not None:
        if options.load is not None or options.hv is not None:
            raise InputError("give either --like or --load and --hv, not both")
        loads_n, amplitudes_m = like(options.like)
        options.hv = ",".join(f"{each!r}m" for each in amplitudes_m)
    else:
        if options.hv is None or (options.load is None and mass_kg is None):
            raise InputError("give --load and --hv, or --mass and --hv, or --like FORCES.csv")
        if options.load is not None:
            loads_n = quantities(options.load, option="--load", unit="N")
        elif mass_kg is not None:
            loads_n = [GRAVITY_M_PER_S2 * mass_kg]
        if min(loads_n) <= 0:
            raise InputError(f"--load {options.load!r} must be positive")
    return loads_n, points_at(points_in(options))


def points_at(points: pd.DataFrame) -> pd.DataFrame:
    """The amplitudes and places at which gaps are sought."""
    wrong = points.loc[~points["hv_m"].between(*AMPLITUDES_M), "hv_m"]
    if len(wrong):
        least, most = AMPLITUDES_M
        raise InputError(f"--hv: {wrong.iloc[0]:g} m must lie within {least:g} … {most:g} m")
    # Of the gap, which is sought, the largest: there surface and finger do not touch.
    return points.assign(h0_m=GAPS_M[1])


def _row(found: Levitation, moving: Resonance | None) -> dict[str, object]:
    scene, budget = found.scene, found.budget
    least, most = budget.modelling_error_percent
    lower_m, upper_m = found.modelling_error_m
    notes = list(found.notes)
    if budget.basis:
        notes.append(f"left out: of {budget.basis}")
    row: dict[str, object] = {
        "h0_m": scene.h0_m,
        "h0_error_m": found.h0_error_m,
        "h0_modelling_error_lower_m": lower_m,
        "h0_modelling_error_upper_m": upper_m,
        "others_m": "; ".join(f"{each:.3g}" for each in found.others_m),
        "stiffness_n_per_m": found.stiffness_n_per_m,
        "stiffness_error_n_per_m": found.stiffness_error_n_per_m,
        "stable": found.stable,
        "epsilon": scene.epsilon,
        "modified_reynolds": scene.modified_reynolds,
        "inertia": scene.gas.inertia,
        "left_out_least_percent": least,
        "left_out_most_percent": most,
        "above_range": "; ".join(budget.above_range),
        "status": "ok",
    }
    if moving is not None:
        row |= {"resonance_hz": moving.frequency_hz, "damping_ratio": moving.damping_ratio}
        notes += filter(None, [moving.reason])
    return row | {"note": "; ".join(notes)}


def _words(moving: Resonance) -> str:
    """A resonance and its damping, or why there is none."""
    return moving.reason or (
        f"free oscillation at about {float(f'{moving.frequency_hz:.3g}'):g} Hz, damping ratio "
        f"about {moving.damping_ratio:.2g}"
    )


def _show(found: Levitation) -> None:
    scene = found.scene
    print(
        f"gap {1e6 * scene.h0_m:.6g} µm ± {1e6 * found.h0_error_m:.2g} µm for "
        f"{found.force_n:.6g} N at hv = {1e6 * scene.hv_m:g} µm (ε {scene.epsilon:.3g}, "
        f"Re {scene.modified_reynolds:.2g}, inertia {scene.gas.inertia})"
    )
    lower, upper = (1e6 * each for each in found.modelling_error_m)
    known = f"{lower:+.2g} to {upper:+.2g} µm" if isfinite(lower) else "not known"
    print(f"modelling error of the gap {known}")
    print(
        f"stiffness {found.stiffness_n_per_m:.4g} N/m ± {found.stiffness_error_n_per_m:.2g} N/m "
        f"of slow motion: {'stable' if found.stable else 'not stable'}, vertically"
    )
    if found.others_m:
        others = ", ".join(f"{1e6 * each:.3g} µm" for each in found.others_m)
        print(f"note: the same force at smaller gaps too, about {others}")
    print(f"beyond the equation: {budget_text(found.budget)}")
    for note in found.notes:
        print(f"note: {note}")
