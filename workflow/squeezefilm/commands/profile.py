"""Smooth a measured vibration profile, and say what its noise does to profile and forces.

    squeezefilm profile --config config/mine.yaml --points points.csv --summary summary.json \\
        --forces forces.csv --figure profile.csv

The profile is the one that every simulation of the study uses. Its noise is drawn anew, from the
residuals, and some of the study's scenes are simulated with each profile that comes out.
"""

from __future__ import annotations

import argparse
from dataclasses import asdict, replace

import numpy as np
import pandas as pd

from squeezefilm.errors import InputError, RunError
from squeezefilm.figure_data import profile as figure
from squeezefilm.profiles.scan_tables import points_table, summary_of
from squeezefilm.profiles.scans import SmoothedScan
from squeezefilm.reynolds import solve
from squeezefilm.reynolds.device import choose_device
from squeezefilm.studies.config import Config, load_config
from squeezefilm.studies.study import directions_of, scene_of, smoothed_scan_of
from squeezefilm.tables import ScenePoint, write_json, write_table

SECTIONS = ("gas", "actuator", "finger", "solver", "screen", "positions")
# The spread is a few per cent at most: forces need not be finer than this to show it.
TOLERANCE = 1e-3


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--config", required=True, metavar="CONFIG.yaml")
    parser.add_argument("--points", required=True, metavar="POINTS.csv")
    parser.add_argument("--summary", required=True, metavar="SUMMARY.json")
    parser.add_argument("--forces", required=True, metavar="FORCES.csv")
    parser.add_argument("--figure", required=True, metavar="FIGURE.csv")
    parser.add_argument("--draws", type=int, default=20, help="profiles with other noise")
    parser.add_argument("--seed", type=int, default=1, help="of the draws")


def run(options: argparse.Namespace) -> None:
    if not 2 <= options.draws <= 10_000:
        raise InputError(f"--draws {options.draws}: a spread needs 2 to 10000 profiles")
    config = load_config(options.config).only(SECTIONS)
    smoothed = smoothed_scan_of(config)
    if smoothed is None:
        kind = config["actuator"]["profile"]["kind"]
        raise InputError(f"{options.config}: actuator.profile: {kind} is not measured")
    points = points_table(smoothed)
    forces = _spread(config, smoothed, draws=options.draws, seed=options.seed)
    summary = summary_of(smoothed, spread=float(forces["noise_share"].max()))
    write_table(points, options.points)
    write_table(forces, options.forces)
    write_table(figure.build(smoothed, summary), options.figure)
    write_json(summary, options.summary)
    print(figure.note(summary, name=smoothed.scan.path.name))


def _spread(config: Config, smoothed: SmoothedScan, *, draws: int, seed: int) -> pd.DataFrame:
    """Forces of some scenes with the profile, and their spread over profiles with other noise."""
    points = _points(config)
    scenes = [scene_of(point, config) for point in points]
    profiles = [smoothed.profile, *smoothed.again(count=draws, seed=seed)]
    every = [
        replace(scene, actuator=replace(scene.actuator, profile=profile))
        for profile in profiles
        for scene in scenes
    ]
    device = choose_device(config["solver"]["device"])
    solutions = solve(every, tolerance=TOLERANCE, device=device)
    for scene, solution in zip(every, solutions, strict=True):
        if solution.status != "ok":
            raise RunError(f"point {scene.point_id}: {solution.status}")
    forces = np.array([solution.force_n for solution in solutions]).reshape(len(profiles), -1)
    table = pd.DataFrame([asdict(point) for point in points])
    spread = forces[1:].std(axis=0, ddof=1)
    return table.assign(
        force_n=forces[0],
        noise_n=spread,
        noise_share=spread / np.abs(forces[0]),
        lowest_n=forces[1:].min(axis=0),
        highest_n=forces[1:].max(axis=0),
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
