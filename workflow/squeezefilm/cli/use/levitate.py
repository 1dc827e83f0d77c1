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
from math import isfinite

from squeezefilm.api.forces import scan_error_of
from squeezefilm.cli.options import add_options, add_point_options, film_at, points_in
from squeezefilm.dynamics.levitation import (
    Levitation,
    Resonance,
    levitations,
    loads_like,
    trustworthy,
)
from squeezefilm.errors import InputError, RunError
from squeezefilm.film.validity import GAPS_M
from squeezefilm.quantities.model_error import budget_text
from squeezefilm.reynolds.device import one_build_at_a_time
from squeezefilm.studies.solver_settings import device_of, solver_settings
from squeezefilm.tables import write_table
from squeezefilm.units import quantities, quantity

AMPLITUDES_M = (1e-9, 1e-4)
GRAVITY_M_PER_S2 = 9.80665


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--load", metavar="QUANTITY", help="e.g. 0.5N; 0.1N,0.2N; 0.1N:1N:10")
    parser.add_argument("--mass", metavar="QUANTITY", help="that floats, e.g. 50g, for a resonance")
    parser.add_argument("--like", metavar="FORCES.csv", help="loads and amplitudes of a table")
    parser.add_argument("--output", metavar="LEVITATION.csv", help="table to write, a row a load")
    add_options(parser, "config", "device", "tolerance", "method")
    add_point_options(parser, without=("h0",))


def run(options: argparse.Namespace) -> None:
    film = film_at(options.config)
    settings = solver_settings(film.config, tolerance=options.tolerance, method=options.method)
    mass_kg = None if options.mass is None else quantity(options.mass, option="--mass", unit="kg")
    if mass_kg is not None and mass_kg <= 0:
        raise InputError(f"--mass {options.mass!r} must be positive")
    loads_n = _loads(options, mass_kg=mass_kg)
    points = points_in(options)
    least, most = AMPLITUDES_M
    for wrong in points.loc[~points["hv_m"].between(least, most), "hv_m"]:
        raise InputError(f"--hv: {wrong:g} m must lie within {least:g} … {most:g} m")
    # Of the gap, which is sought, the largest: there surface and finger do not touch.
    scenes = film.scenes(points.assign(h0_m=GAPS_M[1]))
    with one_build_at_a_time():
        device = device_of(film.config, option=options.device)
    how = settings.how(device) | {"model_tolerance": settings.model_tolerance}
    scan = film.scan
    table, found, moving = levitations(
        scenes, loads_n, how=how, scan_error_n=scan_error_of(scan, device=device), mass_kg=mass_kg
    )
    if scan is not None:
        without = "note: errors of stiffness are without the scan's"
        print(without, *scan.warnings, sep="\n", file=sys.stderr)
    if options.output is not None:
        write_table(table, options.output)
    elif len(table) > 1:
        print(table.to_string(index=False, na_rep="", float_format="{:.4g}".format))
    elif found is None or table["status"].iloc[0] != "ok":
        raise RunError(f"{table['status'].iloc[0]}; {trustworthy(scenes[0], **how)}")
    else:
        _show(found)
        if moving is not None:
            print(f"vertical motion of {mass_kg:g} kg: {_words(moving)}")


def _loads(options: argparse.Namespace, *, mass_kg: float | None) -> list[float]:
    """Loads, or the mass's weight; of a table its range, and its amplitudes as options."""
    if options.like is not None:
        if options.load is not None or options.hv is not None:
            raise InputError("give either --like or --load and --hv, not both")
        loads_n, amplitudes_m = loads_like(options.like)
        options.hv = ",".join(f"{each!r}m" for each in amplitudes_m)
        return loads_n
    if options.hv is None or (options.load is None and mass_kg is None):
        raise InputError("give --load and --hv, or --mass and --hv, or --like FORCES.csv")
    if options.load is None and mass_kg is not None:
        return [GRAVITY_M_PER_S2 * mass_kg]
    loads_n = quantities(options.load, option="--load", unit="N")
    if min(loads_n) <= 0:
        raise InputError(f"--load {options.load!r} must be positive")
    return loads_n


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
