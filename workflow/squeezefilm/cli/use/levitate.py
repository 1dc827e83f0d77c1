"""The gap at which the film carries a load, its stiffness, and whether it is stable.

  squeezefilm levitate --load 0.5N --hv 1.5um [--mass 50g]
  squeezefilm levitate --load 0.1N:1N:10 --hv 1um,2um --output LEVITATION.csv
  squeezefilm levitate --like FORCES.csv --config CONFIG.yaml --output LEVITATION.csv

Each gap is sought with simulations, at the finger's place. `stiffness_n_per_m` is that of slow
motion, −∂F/∂h0 with the amplitude kept, and `stable` is said of vertical motion alone. With a mass,
`resonance_hz` and `damping_ratio` (1 is critical) are those of its free vertical motion: a film
that moves fast is stiffer, and gas that is pressed out damps. With a measured profile the gap's
error has what the scan's noise and its motion out of phase leave open; the stiffness's is without.
What the film equation leaves out of the force is in neither; `left_out_least_percent` and
`…_most_percent` of the force say what it is worth, with what higher orders may add, and
`above_range` names what is too large for a first order. `note` says what stretches an included
term, and why there is no resonance. `--like` takes eight loads and three amplitudes over the range
of a table of forces. A load that no gap carries keeps its row, with the reason as its `status`.
"""

from __future__ import annotations

import argparse
import sys
from dataclasses import replace
from math import isfinite

import numpy as np
import pandas as pd

from squeezefilm.api.forces import scan_parts
from squeezefilm.api.points import scene_points_of
from squeezefilm.cli import which_study
from squeezefilm.cli.points import add_point_options, points_in
from squeezefilm.film.scene import Scene
from squeezefilm.io.errors import InputError, RunError
from squeezefilm.io.progress import progress_bar
from squeezefilm.io.tables import ScenePoint, read_forces, write_table
from squeezefilm.io.typed_units import quantities, quantity
from squeezefilm.reynolds import node_cache
from squeezefilm.reynolds.dynamics.levitation import Levitation, levitate
from squeezefilm.reynolds.dynamics.resonance import Resonance, resonance
from squeezefilm.reynolds.effects.budget import Budget, budgets
from squeezefilm.reynolds.effects.words import budget_text
from squeezefilm.reynolds.terms import notes_of
from squeezefilm.studies.solver_settings import add_solver_arguments, device_of, solver_settings
from squeezefilm.studies.study import scene_of, smoothed_scan_of

LOADS, AMPLITUDES = 8, 3
AMPLITUDES_M = (1e-9, 1e-4)


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
    config = which_study.study_at(options.config)
    settings = solver_settings(
        config, tolerance=options.tolerance, method=options.method, outputs=()
    )
    mass_kg = None if options.mass is None else quantity(options.mass, option="--mass", unit="kg")
    if mass_kg is not None and mass_kg <= 0:
        raise InputError(f"--mass {options.mass!r} must be positive")
    loads_n, points = _asked(options)
    with node_cache.one_build_at_a_time():
        device = device_of(config, option=options.device)
    smoothed = smoothed_scan_of(config)
    rows, failures = [], []
    with progress_bar(len(loads_n) * len(points), unit="load", name="levitate") as bar:
        for point in points:
            for load_n in loads_n:
                row: dict[str, object] = {"load_n": load_n, "hv_m": point.hv_m}
                try:
                    found = levitate(
                        scene_of(point, config),
                        load_n=load_n,
                        tolerance=settings.tolerance,
                        model_tolerance=settings.model_tolerance,
                        method=settings.method,
                        device=device,
                    )
                    if smoothed is not None:
                        (part,) = scan_parts([found.scene], smoothed, device=device)
                        more_m = part.total_n / abs(found.stiffness_n_per_m)
                        found = replace(found, h0_error_m=found.h0_error_m + more_m)
                    (budget,) = budgets([found.scene], device=device)
                    moving = None if mass_kg is None else resonance(found, mass_kg=mass_kg)
                    row |= _row(found, budget, moving)
                except (InputError, RunError) as error:
                    row["status"] = str(error).removeprefix("load: ")
                    failures.append(str(error))
                rows.append(row)
                bar.update(1)
    table = pd.DataFrame(rows)
    if smoothed is not None:
        without = "note: errors of stiffness are without the scan's"
        print(without, *smoothed.warnings, sep="\n", file=sys.stderr)
    if options.output is not None:
        write_table(table, options.output)
        return
    if failures:
        raise RunError("; ".join(failures))
    if len(rows) > 1:
        print(table.to_string(index=False, float_format=lambda value: f"{value:.4g}"))
        return
    _show(found, budget)
    if moving is not None:
        print(f"vertical motion of {mass_kg:g} kg: {_words(moving)}")


def _asked(options: argparse.Namespace) -> tuple[list[float], list[ScenePoint]]:
    """Loads, and the places and amplitudes that they are asked at; gaps are not looked at."""
    if options.like is not None:
        if options.load is not None or options.hv is not None:
            raise InputError("give either --like or --load and --hv, not both")
        table = read_forces(options.like)
        known = table.loc[table["force_n"] > 0, "force_n"]
        if known.empty:
            raise InputError(f"{options.like}: has no force above 0")
        loads_n = [float(each) for each in np.geomspace(known.min(), known.max(), LOADS)]
        levels = np.sort(table["hv_m"].unique())
        places = np.linspace(0, len(levels) - 1, AMPLITUDES).round().astype(int)
        options.hv = ",".join(f"{each!r}m" for each in dict.fromkeys(levels[places].tolist()))
    else:
        if options.load is None or options.hv is None:
            raise InputError("give --load and --hv, or --like FORCES.csv")
        loads_n = quantities(options.load, option="--load", unit="N")
        if min(loads_n) <= 0:
            raise InputError(f"--load {options.load!r} must be positive")
    points = points_in(options)
    wrong = points.loc[~points["hv_m"].between(*AMPLITUDES_M), "hv_m"]
    if len(wrong):
        least, most = AMPLITUDES_M
        raise InputError(f"--hv: {wrong.iloc[0]:g} m must lie within {least:g} … {most:g} m")
    return loads_n, scene_points_of(points.assign(h0_m=2 * points["hv_m"]))


def _row(found: Levitation, budget: Budget, moving: Resonance | None) -> dict[str, object]:
    scene: Scene = found.scene
    least, most = budget.sums(left_out_only=True)
    notes = notes_of(scene)
    if budget.basis:
        notes.append(f"left out: of {budget.basis}")
    row: dict[str, object] = {
        "h0_m": scene.h0_m,
        "h0_error_m": found.h0_error_m,
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
    if not moving.reason:
        return (
            f"resonance at about {float(f'{moving.frequency_hz:.2g}'):g} Hz, damping ratio about "
            f"{moving.damping_ratio:.2g}"
        )
    about = f" (damping ratio about {moving.damping_ratio:.2g})"
    return moving.reason + about * isfinite(moving.damping_ratio)


def _show(found: Levitation, budget: Budget) -> None:
    scene = found.scene
    print(
        f"gap {1e6 * scene.h0_m:.6g} µm ± {1e6 * found.h0_error_m:.2g} µm for "
        f"{found.force_n:.6g} N at hv = {1e6 * scene.hv_m:g} µm (ε {scene.epsilon:.3g}, "
        f"Re {scene.modified_reynolds:.2g}, inertia {scene.gas.inertia})"
    )
    print(
        f"stiffness {found.stiffness_n_per_m:.4g} N/m ± {found.stiffness_error_n_per_m:.2g} N/m "
        f"of slow motion: {'stable' if found.stable else 'not stable'}, vertically"
    )
    if found.others_m:
        others = ", ".join(f"{1e6 * each:.3g} µm" for each in found.others_m)
        print(f"note: the same force at smaller gaps too, about {others}")
    least, most = (
        1e6 * percent / 100 * found.force_n / found.stiffness_n_per_m
        for percent in budget.sums(left_out_only=True)
    )
    beyond = f"beyond the equation: {budget_text(budget)}"
    known = isfinite(least) and not budget.above_range
    print(beyond + f": {least:+.2g} to {most:+.2g} µm of the gap" * known)
    for note in notes_of(scene):
        print(f"note: {note}")
