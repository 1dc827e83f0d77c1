"""Errors of forces due to the noise of the scan of their profile."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pandas as pd

from squeezefilm.config.film import FilmSections
from squeezefilm.config.study import Study
from squeezefilm.errors import InputError, RunError, point_text
from squeezefilm.film.measured.smooth import SmoothedScan
from squeezefilm.film.profiles import ModeSum
from squeezefilm.film.scene import Scene, Scenes
from squeezefilm.film.surfaces import Disc
from squeezefilm.film.symmetry import DirectionSector
from squeezefilm.formatting import percent_text, result_lines_text
from squeezefilm.quantities.model_error import resolve_auto_terms
from squeezefilm.reynolds import solve
from squeezefilm.reynolds.device import Device
from squeezefilm.solution import SOLUTION_COLUMNS, Solutions
from squeezefilm.studies.solver_settings import device_of_config
from squeezefilm.studies.space import plan_table
from squeezefilm.studies.study import scenes_of_table
from squeezefilm.units import round_up_error

# The spread is a few per cent at most: forces need not be finer than this to show it.
SCAN_FORCE_TOLERANCE = 1e-3
BOOTSTRAP_DRAWS, BOOTSTRAP_SEED = 50, 1
# Part of the variance of noise under the pad in directions of which none is solved for; the others
# stand for it.
NEGLECTED_NOISE_FRACTION = 0.03
# Half of the interval that holds 95 %, over the spread: Student's t at 97.5 % with BOOTSTRAP_DRAWS
# − 1 degrees of freedom (scipy.special takes 0.2 s to import).
COVERAGE_FACTOR = 2.0095752371292392


def scan_errors_table(
    scenes: Sequence[Scene],
    smoothed: SmoothedScan,
    *,
    device: Device,
    solved: Callable[..., Solutions] = solve,
) -> pd.DataFrame:
    """Solve the scenes again with profiles of other noise, and estimate what was neglected.

    Args:
        solved: solves scenes as ``solve``, with the quantities beside the force that are wanted.

    Returns:
        In newtons, a row for each scene: ``force_n`` with the profile, to SCAN_FORCE_TOLERANCE;
        ``spread_n``, the standard deviation over profiles with other noise;
        ``measurement_noise_n``, half of the interval that holds the noise's part in 95 % of scans:
        the spread's, and all that was taken off the profile's maximum as noise; ``misfit_n``, by
        modes that the points do not determine; ``quadrature_n``, by what the force is low without
        motion out of phase that was neglected; ``scan_error_n``, the sum of all. The same noise,
        with the misfit, of each other quantity, in its unit: ``thrust_x_measurement_noise_n`` of
        ``thrust_x_n``.

    Raises:
        RunError: naming a scene that has no force.
    """
    scenes = resolve_auto_terms(scenes, device=device)
    drawn = smoothed.bootstrap_profiles(count=BOOTSTRAP_DRAWS, seed=BOOTSTRAP_SEED)
    noises = [_NoiseUnderPad.of(scene, smoothed.profile, drawn) for scene in scenes]
    misfits = smoothed.profiles_with_misfit
    every = [
        replace(scene, actuator=replace(scene.actuator, profile=profile))
        for scene, noise in zip(scenes, noises, strict=True)
        for profile in (smoothed.profile, *misfits, *noise.profiles)
    ]
    solutions = solved(every, tolerance=SCAN_FORCE_TOLERANCE, device=device)
    for row in np.flatnonzero(solutions.status != "ok").tolist():
        raise RunError(f"{point_text(every[row].point_id)}: {solutions.status[row]}")
    values = solutions.to_frame().drop(columns=[*SOLUTION_COLUMNS[1:]])
    numbers = values.select_dtypes("number")
    ends = np.cumsum([1 + len(misfits) + len(noise.profiles) for noise in noises])
    rows = [numbers.iloc[slice(*ends_of)] for ends_of in zip([0, *ends], ends, strict=False)]
    own = values.loc[[of_film.index[0] for of_film in rows]].reset_index(drop=True)
    off = [(of_film.iloc[1 : 1 + len(misfits)] - of_film.iloc[0]).abs().max() for of_film in rows]
    misfit = pd.DataFrame(off).fillna(0.0)
    spread = pd.DataFrame(
        [
            noise.spread(of_film.iloc[0], of_film.iloc[1 + len(misfits) :])
            for noise, of_film in zip(noises, rows, strict=True)
        ],
        columns=numbers.columns,
    )
    # Small forces go as the square of the amplitude over its maximum, large ones faster.
    bias = 2 * smoothed.peak_bias_m / smoothed.peak_m / (1 - Scenes.of(scenes).epsilon)
    neglected = not smoothed.profile.is_complex
    effect = [quadrature_effect_fraction(scene, smoothed) if neglected else 0.0 for scene in scenes]
    table = pd.DataFrame({"force_n": own["force_n"], "spread_n": spread["force_n"]})
    size_n = table["force_n"].abs()
    noise = COVERAGE_FACTOR * spread + own[spread.columns].abs().mul(bias, axis=0)
    table["measurement_noise_n"] = noise["force_n"]
    table["quadrature_n"] = effect * size_n
    table["noise_fraction"] = table["measurement_noise_n"] / size_n
    table["misfit_n"] = misfit["force_n"]
    table["scan_error_n"] = table[["measurement_noise_n", "misfit_n", "quadrature_n"]].sum(axis=1)
    for name in map(str, noise):
        if "_error" in name:
            quantity = name.replace("_error", "")
            of_scan = noise[quantity] + misfit[quantity]
            table[name.replace("_error", "_measurement_noise")] = of_scan
    return table.assign(scan_error_fraction=table["scan_error_n"] / size_n)


@dataclass(frozen=True)
class _NoiseUnderPad:
    """Noise of a profile as a scene's force answers to it: in few directions, or draw by draw.

    Attributes:
        profiles: with as much noise as is usual in each direction, and with as much less; or as
            drawn, where this is fewer.
        factors: of each draw in each direction, (draws, directions); None for profiles as drawn.
    """

    profiles: Sequence[ModeSum]
    factors: np.ndarray | None

    @classmethod
    def of(cls, scene: Scene, profile: ModeSum, drawn: Sequence[ModeSum]) -> _NoiseUnderPad:
        """Principal components of draws under the pad: noise elsewhere moves no force."""
        x_m, y_m = scene.inside()
        amplitudes = [
            replace(scene, actuator=replace(scene.actuator, profile=shape)).amplitude(x_m, y_m)
            for shape in (profile, *drawn)
        ]
        own, *others = np.reshape(amplitudes, (len(amplitudes), -1))
        changes = np.array(others) - own
        left, sizes, _ = np.linalg.svd(np.hstack([changes.real, changes.imag]), full_matrices=False)
        rest = np.append(np.cumsum(sizes[::-1] ** 2)[::-1], 0.0)
        count = np.count_nonzero(rest > NEGLECTED_NOISE_FRACTION * rest[0])
        if 2 * count >= len(drawn):
            return cls(drawn, None)
        directions, coefficients = left[:, :count], np.array(profile.coefficients)
        steps = directions.T @ ([shape.coefficients for shape in drawn] - coefficients)
        steps /= np.sqrt(len(drawn))
        # These directions stand for the variance of the others too.
        widening = np.sqrt(rest[0] / (rest[0] - rest[count]))
        return cls(
            [
                replace(profile, coefficients=tuple(values.tolist()))
                for values in (*(coefficients + steps), *(coefficients - steps))
            ],
            widening * np.sqrt(len(drawn)) * directions,
        )

    def spread(self, own: pd.Series, values: pd.DataFrame) -> pd.Series:
        """Return standard deviations over the draws, by the values with this one's profiles."""
        if self.factors is None:
            return values.std()
        more, less = np.split(values.to_numpy() - own.to_numpy(), 2)
        changes = self.factors @ (more - less) / 2 + self.factors**2 @ (more + less) / 2
        return pd.Series(changes.std(axis=0, ddof=1), index=values.columns)


def quadrature_effect_fraction(scene: Scene, smoothed: SmoothedScan) -> float:
    """Estimate of the relative change of a force by the neglected quadrature component.

    Small forces go as the sum of both squares under the pad. With more motion a force grows faster,
    a piston's of little motion out of phase (closed form, σ → ∞) by less than 1/(1 − ε).
    """
    x, y = scene.inside()
    other = replace(scene, actuator=replace(scene.actuator, profile=smoothed.out_of_phase))
    first, second = (float(np.mean(film.amplitude(x, y) ** 2)) for film in (scene, other))
    return second / first / (1 - scene.epsilon) if first else math.inf


def scan_errors_of_study(config: Study, smoothed: SmoothedScan) -> pd.DataFrame:
    """Forces of some of a study's scenes, and their errors by the scan."""
    points, device = _extreme_scenes(config), device_of_config(config)
    return points.join(scan_errors_table(scenes_of_table(points, config), smoothed, device=device))


def scan_report(config: FilmSections) -> tuple[pd.DataFrame, pd.DataFrame, dict[str, Any], str]:
    """Smooth the scan of a film and simulate some scenes of its study, if any, with other noise.

    Returns: forces of some scenes, the profile as a table, the largest errors of forces, and lines
        about all.

    Raises InputError for a film whose profile is not measured.
    """
    smoothed = config.smoothed_scan()
    if smoothed is None:
        kind = config.actuator.profile.kind
        raise InputError(f"{config.path}: actuator.profile: {kind} is not measured")
    forces = (
        scan_errors_of_study(config, smoothed)
        if isinstance(config, Study)
        else pd.DataFrame(columns=["noise_fraction", "scan_error_fraction"])
    )
    noise, error = (float(forces[f"{part}_fraction"].max()) for part in ("noise", "scan_error"))
    x_m, y_m, _ = smoothed.profile.surface.net_points_and_weights()
    unsure = _rounded_up_percent_text(float(smoothed.standard_error(x_m=x_m, y_m=y_m).max()))
    misfit = _rounded_up_percent_text(float(smoothed.mode_misfit(x_m=x_m, y_m=y_m).max()))
    summary = {"largest_force_noise_fraction": noise, "largest_force_error_fraction": error}
    point_noise = percent_text(100 * smoothed.noise_m / smoothed.peak_m, sign="")
    rms = f"{percent_text(100 * smoothed.quadrature, sign='')} rms including its noise"
    row = {
        "measurement noise of a force": "`squeezefilm simulate` shows it with each force"
        if forces.empty
        else f"at most {_rounded_up_percent_text(noise)} (95 %)",
        "largest amplitude": f"{smoothed.peak_m * 1e6:.4g} µm",
        "noise of a point": f"{point_noise} of the largest amplitude",
        "standard error of the profile": f"at most {unsure} of the largest amplitude",
        "misfit of the profile": f"at most {misfit} of the largest amplitude, too few points",
        "quadrature motion": rms + ", neglected" * (not smoothed.profile.is_complex),
        "points": len(smoothed.measured_amplitude_m),
        "degree of the modes": smoothed.fit.degree,
        "notes": [warning.removeprefix("note: ") for warning in smoothed.warnings],
    }
    row |= {} if smoothed.profiles_with_misfit else {"misfit of the profile": ""}
    text = result_lines_text(row)
    shown = "; ".join(" ".join(line.split()) for line in text.splitlines())
    return forces, profile_table(smoothed).assign(note=shown), summary, text


def _rounded_up_percent_text(error: float) -> str:
    return percent_text(100 * round_up_error(error), sign="")


def profile_table(smoothed: SmoothedScan) -> pd.DataFrame:
    """The points and what the profile leaves of them, and the profile with its standard error.

    Layers ``points`` and ``outliers``; of a disc ``profile``, the least and largest value over all
    angles and the largest error at each distance from the centre; of a rectangle ``map``.
    """
    scan, micrometres = smoothed.scan, smoothed.peak_m * 1e6
    points = {
        "layer": np.where(smoothed.outlier_mask, "outliers", "points"),
        "line": scan.lines,
        "x_mm": scan.x_m * 1e3,
        "y_mm": scan.y_m * 1e3,
        "r_mm": np.hypot(scan.x_m, scan.y_m) * 1e3,
        "amplitude_um": smoothed.measured_amplitude_m.real * 1e6,
        "residual_um": smoothed.residual_m.real * 1e6,
    }
    x_m, y_m, _ = smoothed.profile.surface.net_points_and_weights()
    drawn: dict[str, Any] = {"layer": "map", "x_mm": x_m.ravel() * 1e3, "y_mm": y_m.ravel() * 1e3}
    profile = smoothed.profile.amplitude(x_m=x_m, y_m=y_m).real * micrometres
    error = smoothed.standard_error(x_m=x_m, y_m=y_m) * micrometres
    if isinstance(smoothed.profile.surface, Disc):
        drawn = {"layer": "profile", "r_mm": x_m[:, 0] * 1e3, "error_um": error.max(axis=1)}
        drawn |= {"profile_min_um": profile.min(axis=1), "profile_max_um": profile.max(axis=1)}
    else:
        drawn |= {"profile_um": profile.ravel(), "error_um": error.ravel()}
    table = pd.concat([pd.DataFrame(points), pd.DataFrame(drawn)], ignore_index=True).round(9)
    return table.astype({"line": "Int64"}).assign(noise_um=round(smoothed.noise_m * 1e6, 9))


def _extreme_scenes(config: Study) -> pd.DataFrame:
    """The largest amplitude over the smallest and the largest gap, and farthest from the centre."""
    gaps, amplitude = config.screen.h0_m, config.screen.hv_m.stop
    symmetry, positions = config.symmetry(), config.positions
    pad_positions = symmetry.pad_positions(positions)[1:]
    if isinstance(symmetry, DirectionSector):
        farthest = max(positions.phi_r_m)
        pad_positions = [position for position in pad_positions if position[0] == farthest]
    rows = [(gaps.start, 0.0, 0.0), (gaps.stop, 0.0, 0.0)]
    rows += [(gaps.start, *position) for position in pad_positions]
    return plan_table(
        pd.DataFrame(rows, columns=["h0_m", *symmetry.position_columns]).assign(hv_m=amplitude)
    )
