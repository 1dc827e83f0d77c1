"""What a scan leaves open in the forces that are simulated with its profile."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pandas as pd

from squeezefilm.config.loading import Config
from squeezefilm.errors import InputError, RunError
from squeezefilm.film.measured.smooth import SmoothedScan
from squeezefilm.film.measured.tables import described, profile_table, summary_of
from squeezefilm.film.scene import Scene
from squeezefilm.film.symmetry import Directions
from squeezefilm.quantities.model_error import resolve_auto_terms
from squeezefilm.reynolds import solve
from squeezefilm.reynolds.device import Device
from squeezefilm.studies.plans import plan
from squeezefilm.studies.solver_settings import device_of
from squeezefilm.studies.study import scenes_in, smoothed_scan_of, symmetry_of

# The spread is a few per cent at most: forces need not be finer than this to show it.
TOLERANCE = 1e-3
DRAWS, SEED = 50, 1
COVERAGE = 0.95


def scan_errors(
    scenes: Sequence[Scene],
    smoothed: SmoothedScan,
    *,
    device: Device,
    draws: int = DRAWS,
    seed: int = SEED,
) -> pd.DataFrame:
    """Solve the scenes again with profiles of other noise, and estimate what was neglected.

    Returns:
        In newtons, a row for each scene: ``force_n`` with the profile, to TOLERANCE; ``spread_n``,
        ``lowest_n``, ``highest_n``, standard deviation and range over profiles with other noise;
        ``noise_n``, half of the interval that holds the noise's part with COVERAGE: the spread's,
        and all that was taken off the profile's maximum as the noise's;
        ``out_of_phase_n``, by what the force is low without motion out of phase that was neglected;
        ``scan_error_n``, the sum of both.

    Raises:
        RunError: naming a scene that has no force.
    """
    from scipy.special import stdtrit

    scenes = resolve_auto_terms(scenes, device=device)
    profiles = [smoothed.profile, *smoothed.residual_bootstrap(count=draws, seed=seed)]
    every = [
        replace(scene, actuator=replace(scene.actuator, profile=profile))
        for profile in profiles
        for scene in scenes
    ]
    solutions = solve(every, tolerance=TOLERANCE, device=device)
    for scene, solution in zip(every, solutions, strict=True):
        if solution.status != "ok":
            raise RunError(f"point {scene.point_id}: {solution.status}")
    forces = np.array([solution.force_n for solution in solutions]).reshape(len(profiles), -1)
    spread_n = forces[1:].std(axis=0, ddof=1)
    quantile = float(stdtrit(draws - 1, (1 + COVERAGE) / 2))
    # Small forces go as the square of the amplitude over its maximum, large ones faster.
    share = smoothed.profile.largest - 1
    bias = np.array([2 * share / (1 - scene.epsilon) for scene in scenes])
    effect = np.zeros(len(scenes))
    if not smoothed.profile.is_complex:
        effect[:] = [out_of_phase_effect(scene, smoothed) for scene in scenes]
    force_n = np.abs(forces[0])
    noise_n, out_of_phase_n = quantile * spread_n + bias * force_n, effect * force_n
    return pd.DataFrame(
        {
            "force_n": forces[0],
            "spread_n": spread_n,
            "noise_n": noise_n,
            "out_of_phase_n": out_of_phase_n,
            "lowest_n": forces[1:].min(axis=0),
            "highest_n": forces[1:].max(axis=0),
            "scan_error_n": noise_n + out_of_phase_n,
        }
    )


def out_of_phase_effect(scene: Scene, smoothed: SmoothedScan) -> float:
    """By which share the scene's force is low without the motion out of phase: an estimate.

    Small forces go as the sum of both squares under the pad. With more motion a force grows faster,
    a piston's of little motion out of phase (closed form, σ → ∞) by less than 1/(1 − ε).
    """
    x, y = scene.inside()
    other = replace(scene, actuator=replace(scene.actuator, profile=smoothed.out_of_phase))
    first, second = (float(np.mean(each.amplitude(x, y) ** 2)) for each in (scene, other))
    return second / first / (1 - scene.epsilon) if first else math.inf


def errors_in_study(
    config: Config, smoothed: SmoothedScan, *, draws: int, seed: int
) -> pd.DataFrame:
    """Forces of some of a study's scenes, and what the scan leaves open in them."""
    points = _points(config)
    scenes = scenes_in(points, config)
    errors = scan_errors(scenes, smoothed, device=device_of(config), draws=draws, seed=seed)
    force_n = errors["force_n"].abs()
    return points.join(
        errors.drop(columns="scan_error_n").assign(
            noise_share=errors["noise_n"] / force_n,
            scan_error_n=errors["scan_error_n"],
            scan_error_share=errors["scan_error_n"] / force_n,
        )
    )


@dataclass(frozen=True, eq=False)
class ScanReport:
    """What a scan leaves open: forces of some scenes, the profile as a table, a summary, a text."""

    forces: pd.DataFrame
    profile: pd.DataFrame
    summary: dict[str, Any]
    text: str


def scan_report(config: Config, *, draws: int = DRAWS, seed: int = SEED) -> ScanReport:
    """Smooth the scan of a study and simulate some of its scenes with other noise.

    Args:
        draws: profiles with other noise; seed of the draws.

    Raises InputError for a study whose profile is not measured.
    """
    smoothed = smoothed_scan_of(config)
    if smoothed is None:
        kind = config["actuator"]["profile"]["kind"]
        raise InputError(f"{config.path}: actuator.profile: {kind} is not measured")
    forces = errors_in_study(config, smoothed, draws=draws, seed=seed)
    summary = summary_of(
        smoothed,
        noise=float(forces["noise_share"].max()),
        error=float(forces["scan_error_share"].max()),
    )
    text = described(summary)
    note = "; ".join(" ".join(line.split()) for line in text.splitlines())
    return ScanReport(forces, profile_table(smoothed).assign(note=note), summary, text)


def _points(config: Config) -> pd.DataFrame:
    """The largest amplitude over the smallest and the largest gap, and farthest from the centre."""
    gaps, amplitude = config["screen"]["h0_m"], config["screen"]["hv_m"]["stop"]
    found, positions = symmetry_of(config), config["positions"]
    places = found.places(positions)[1:]
    if isinstance(found, Directions):
        farthest = max(positions["phi_r_m"])
        places = [place for place in places if place[0] == farthest]
    rows = [(gaps["start"], 0.0, 0.0), (gaps["stop"], 0.0, 0.0)]
    rows += [(gaps["start"], *place) for place in places]
    gap, first, second = zip(*rows, strict=True)
    place = dict(zip(found.position, (first, second), strict=True))
    return plan(h0_m=gap, hv_m=[amplitude] * len(gap), **place)
