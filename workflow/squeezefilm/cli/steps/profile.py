"""Smooth a measured vibration profile, and say what its noise does to profile and forces.

    squeezefilm profile --config config/mine.yaml --points points.csv --summary summary.json \\
        --forces forces.csv --figure profile.csv

The profile is the one that every simulation of the study uses. Its noise is drawn anew, from the
residuals, and some of the study's scenes are simulated with each profile that comes out. FORCES.csv
has their forces with the half of the interval that holds the noise's part in 95 % of all scans
(`noise_n`), by what they are low without motion out of phase (`out_of_phase_n`), and the sum of
both (`scan_error_n`), which the solver's own error adds to.
"""

from __future__ import annotations

import argparse
from dataclasses import asdict

import numpy as np
import pandas as pd

from squeezefilm.film.vibration import residuals as figure
from squeezefilm.film.vibration.scan_tables import points_table, summary_of
from squeezefilm.film.vibration.scans import SmoothedScan
from squeezefilm.io.errors import InputError
from squeezefilm.io.tables import ScenePoint, write_json, write_table
from squeezefilm.reynolds.device import choose_device
from squeezefilm.studies.config import Config, load_config
from squeezefilm.studies.scan_errors import DRAWS, SEED, scan_errors
from squeezefilm.studies.study import directions_of, scene_of, smoothed_scan_of

SECTIONS = ("gas", "actuator", "finger", "solver", "screen", "positions")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--config", required=True, metavar="CONFIG.yaml")
    parser.add_argument("--points", required=True, metavar="POINTS.csv")
    parser.add_argument("--summary", required=True, metavar="SUMMARY.json")
    parser.add_argument("--forces", required=True, metavar="FORCES.csv")
    parser.add_argument("--figure", required=True, metavar="FIGURE.csv")
    parser.add_argument("--draws", type=int, default=DRAWS, help="profiles with other noise")
    parser.add_argument("--seed", type=int, default=SEED, help="of the draws")


def run(options: argparse.Namespace) -> None:
    if not 2 <= options.draws <= 10_000:
        raise InputError(f"--draws {options.draws}: a spread needs 2 to 10000 profiles")
    config = load_config(options.config).only(SECTIONS)
    smoothed = smoothed_scan_of(config)
    if smoothed is None:
        kind = config["actuator"]["profile"]["kind"]
        raise InputError(f"{options.config}: actuator.profile: {kind} is not measured")
    points = points_table(smoothed)
    forces = _errors(config, smoothed, draws=options.draws, seed=options.seed)
    summary = summary_of(
        smoothed,
        noise=float(forces["noise_share"].max()),
        error=float(forces["scan_error_share"].max()),
    )
    write_table(points, options.points)
    write_table(forces, options.forces)
    write_table(figure.build(smoothed, summary), options.figure)
    write_json(summary, options.summary)
    print(figure.note(summary, name=smoothed.scan.path.name))


def _errors(config: Config, smoothed: SmoothedScan, *, draws: int, seed: int) -> pd.DataFrame:
    """Forces of some scenes with the profile, and what the scan leaves open in them."""
    points = _points(config)
    scenes = [scene_of(point, config) for point in points]
    device = choose_device(config["solver"]["device"])
    errors = scan_errors(scenes, smoothed, device=device, draws=draws, seed=seed)
    force_n = np.abs(errors.force_n)
    return pd.DataFrame([asdict(point) for point in points]).assign(
        force_n=errors.force_n,
        spread_n=errors.spread_n,
        noise_n=errors.noise_n,
        noise_share=errors.noise_n / force_n,
        out_of_phase_n=errors.out_of_phase_n,
        scan_error_n=errors.total_n,
        scan_error_share=errors.total_n / force_n,
        lowest_n=errors.lowest_n,
        highest_n=errors.highest_n,
    )


def _points(config: Config) -> list[ScenePoint]:
    """The largest amplitude over the smallest and the largest gap, and farthest from the centre."""
    gaps, amplitude = config["screen"]["h0_m"], config["screen"]["hv_m"]["stop"]
    radius = max(config["positions"]["phi_r_m"])
    places = [(gaps["start"], 0.0, 0.0), (gaps["stop"], 0.0, 0.0)]
    angles = directions_of(config).images(config["positions"]["phi_deg"])
    places += [(gaps["start"], radius, angle) for angle in angles]
    return [
        ScenePoint(str(number), gap, amplitude, r, angle)
        for number, (gap, r, angle) in enumerate(places, start=1)
    ]
