"""Amplitudes measured by a scanning vibrometer, made into a smooth profile with known errors.

The profile is the least-squares sum of the surface's modes (surfaces.py), up to a degree that
cross-validation finds (mode_fit.py).

Points far from the rest are excluded and the rest is fitted again. The film equation needs the
profile's curvature, so that a smooth global basis serves it better than splines with their knots.
Least squares also say how sure the profile is at every place: the standard error that noise leaves,
from the residuals.

Where the scan has phases, what moves a quarter of a period from the rest is fitted likewise. If
forces depend on it the profile is complex: both are fitted together, by the same modes.

The largest of a noisy profile is too large on average. The bias is estimated from profiles with
more noise of the same size and from noise among equal maxima, and is taken off the maximum to which
the profile is scaled.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path

import numpy as np

from squeezefilm.errors import InputError, prefix_errors, raise_first_problem
from squeezefilm.film.measured.mode_fit import MAX_MODE_DEGREE, ModeFit, ScanPoints, best_mode_fit
from squeezefilm.film.measured.placement import edge_note, origin_note, read_scan_on_surface
from squeezefilm.film.measured.scan import (
    Scan,
    average_repeated_points,
    limit_point_count,
    list_text,
    turned_to_main_phase,
)
from squeezefilm.film.profiles import ModeSum, ScanFile, largest_magnitude
from squeezefilm.film.surfaces import Disc, ModeOrders, Surface

# An axisymmetric profile is doubted where angles leave less than this share of what it leaves, and
# the points that this is looked at with.
MAX_RESIDUAL_RATIO_WITH_ANGLES, MAX_POINTS_FOR_ANGLE_CHECK = 0.5, 2000
# A profile that is less sure than this share of its maximum somewhere is not known there.
MAX_PROFILE_ERROR = 0.25
# Nor is one that has no measured point within this share of a disc's radius, or of half a
# rectangle's shorter side.
MAX_HOLE_RADIUS_FRACTION = 0.35
# Points of a half of the surface reach so far into the other one, over its half side.
MAX_PART_OVERLAP_FRACTION = 0.1
# What the smooth motion out of phase may do to forces, as a share, and be neglected.
MAX_QUADRATURE_FORCE_CHANGE = 1e-3
# A point is far from the rest beyond this many standard deviations of the noise, and never if it is
# nearer than this share of the largest amplitude: that may be the profile's own fine structure.
OUTLIER_STANDARD_DEVIATIONS, MIN_OUTLIER_RESIDUAL_RATIO = 4.5, 0.005
# More such points, as a share, are no outliers.
MAX_OUTLIER_POINT_FRACTION = 0.05
MAX_OUTLIER_REFITS = 20
# A maximum so far above the largest at the measured points is extrapolated.
MAX_OVERSHOOT_RATIO = 1.05
# Points nearer to the centre, over the distance of the farthest, have no direction.
MIN_DIRECTION_RADIUS_FRACTION = 0.05
# Draws of noise by which the bias of the maximum is estimated.
PEAK_BIAS_DRAW_COUNT, PEAK_BIAS_SEED = 200, 1
# A place may be the largest if it is lower by no more than this many standard errors.
RIVAL_PEAK_STANDARD_ERRORS = 2.0
UNSIGNED_WARNING = (
    "the scan has no phase and no amplitude below zero: all amplitudes are taken to one side, and "
    "over a node line the force is that of another surface, which no error here contains"
)


@dataclass(frozen=True, eq=False)
class SmoothedScan:
    """A scan and the profile through it.

    Attributes:
        profile: the smooth motion in units of its maximum, along the phase of most of it; complex
            where the motion a quarter of a period apart counts.
        out_of_phase: that motion alone, in the same units.
        peak_m: amplitude at the maximum, and ``peak_bias_m`` what was taken off it as the noise's.
        noise_m: standard deviation of the noise, from the residuals.
        quadrature: rms share of the motion that is out of phase, its noise included.
        fit: the modes' least squares.
        measured_amplitude_m: the points' amplitudes, turned to the phase of most of the motion;
            complex where the profile is, else the part in this phase.
        peak_search_modes: the modes where the maximum is taken, shape (modes, places).
        outlier_mask: which of them lie further from the rest than noise does; they are not fitted.
    """

    scan: Scan
    profile: ModeSum
    out_of_phase: ModeSum
    peak_m: float
    peak_bias_m: float
    noise_m: float
    quadrature: float
    fit: ModeFit
    measured_amplitude_m: np.ndarray
    outlier_mask: np.ndarray
    peak_search_modes: np.ndarray

    def standard_error(self, *, x_m: np.ndarray, y_m: np.ndarray) -> np.ndarray:
        """Standard error of the profile, of each part of a complex one, over its maximum."""
        modes = self.profile.surface.modes_at(self.profile.orders, x_m, y_m)
        return self.noise_m / self.peak_m * np.linalg.norm(modes @ self.fit.root, axis=-1)

    def mode_misfit(self, *, x_m: np.ndarray, y_m: np.ndarray) -> np.ndarray:
        """Estimate the part of modes that the points do not determine, over the maximum."""
        modes = self.profile.surface.modes_at(self.profile.orders, x_m, y_m)
        return np.asarray(np.abs(modes @ self.fit.undetermined_coefficients_m) / self.peak_m)

    @property
    def profiles_with_misfit(self) -> list[ModeSum]:
        """The profiles with so much more and less, over their maxima; none without a misfit."""
        misfit_m = self.fit.undetermined_coefficients_m
        if not np.any(misfit_m):
            return []
        raw_m = self.peak_m * np.array(self.profile.coefficients)
        return self._scaled_profiles(np.array([raw_m + misfit_m, raw_m - misfit_m]))

    def _scaled_profiles(self, coefficients_m: np.ndarray) -> list[ModeSum]:
        """Profiles of coefficients, shape (profiles, modes), scaled as this one is."""
        raw_m = self.peak_m * np.array(self.profile.coefficients)
        # The finer search for the maximum moves it by as little for each.
        finer = (self.peak_m + self.peak_bias_m) / _largest_mode_sum(raw_m, self.peak_search_modes)
        peaks_m = (
            _largest_mode_sum(coefficients_m, self.peak_search_modes) * finer - self.peak_bias_m
        )
        return [
            replace(self.profile, coefficients=tuple((coefficients / peak).tolist()))
            for coefficients, peak in zip(coefficients_m, peaks_m, strict=True)
        ]

    @property
    def residual_m(self) -> np.ndarray:
        """Return the residuals of the measured amplitudes, in metres."""
        fitted = self.profile.amplitude(x_m=self.scan.x_m, y_m=self.scan.y_m)
        return np.asarray(self.measured_amplitude_m - self.peak_m * fitted)

    @property
    def warnings(self) -> tuple[str, ...]:
        """Return the warnings and notes on the scan, a line each."""
        unsigned = [f"warning: {UNSIGNED_WARNING}"] * (not self.scan.has_phase_or_sign)
        outliers = self.scan.lines[self.outlier_mask].tolist()
        many = "s" * (len(outliers) > 1)
        excluded = f"{len(outliers)} outlier{many} excluded (line{many} {list_text(outliers)})"
        notes = (*self.scan.notes, *[excluded] * bool(outliers))
        return (*unsigned, *(f"note: {note}" for note in notes))

    def bootstrap_profiles(self, *, count: int, seed: int) -> list[ModeSum]:
        """Profiles that scans with other noise would have given: residuals drawn again.

        The residuals are widened by √(points/(points − modes)) to the noise's size, which their
        fit has shrunk (Davison and Hinkley, Bootstrap Methods, 1997, 6.2).
        """
        surface, orders, fitted = self.profile.surface, self.profile.orders, ~self.outlier_mask
        basis = surface.modes_at(orders, self.scan.x_m[fitted], self.scan.y_m[fitted])
        points, modes = basis.shape
        residual = self.residual_m[fitted]
        residual = residual - residual.mean()
        noise_m = np.random.default_rng(seed).choice(
            residual * math.sqrt(points / (points - modes)), size=(count, points)
        )
        raw_m = self.peak_m * np.array(self.profile.coefficients)
        drawn_m = raw_m + (noise_m @ basis) @ self.fit.root @ self.fit.root.T
        return self._scaled_profiles(drawn_m)


def smoothed_scan_of_file(
    path: Path, settings: ScanFile, surface: Surface, *, frequency_hz: float
) -> SmoothedScan:
    """The smooth profile of a scan's file, as ``smooth_scan`` makes it.

    Raises InputError naming the file, and the place of the error or the undetermined region.
    """
    scan = read_scan_on_surface(path, settings, surface, frequency_hz=frequency_hz)
    return smooth_scan(scan, settings, surface)


def smooth_scan(scan: Scan, settings: ScanFile, surface: Surface) -> SmoothedScan:
    """The smooth profile of a scan on a surface.

    Raises InputError naming the file, and what its points do not determine.
    """
    notes = (*edge_note(scan, surface), *origin_note(scan, surface))
    scan = replace(scan, notes=(*scan.notes, *notes))
    scan = limit_point_count(average_repeated_points(scan))
    coordinate = "r" if settings.axisymmetric else settings.along
    points = ScanPoints(surface, coordinate, scan.x_m, scan.y_m)
    # Re u e^(iωt) is both parts' s₁ sin T + s₂ cos T with T = ωt + π/2.
    measured = turned_to_main_phase(scan.amplitude_m)
    quadrature = math.sqrt(float(np.mean(measured.imag**2) / np.mean(np.abs(measured) ** 2)))
    with prefix_errors(scan.path):
        fit, kept, fitted = _fit_without_outliers(points, scan.lines, measured.real)
        other = best_mode_fit(fitted, measured.imag[kept])
        if _mean_square_of_profile(
            other, surface
        ) > MAX_QUADRATURE_FORCE_CHANGE * _mean_square_of_profile(fit, surface):
            fit, kept, _ = _fit_without_outliers(points, scan.lines, measured)
        else:
            measured = measured.real
    smooth = points.mode_values(fit.orders) @ fit.coefficients
    # Half a period later every amplitude has the other sign: positive at its largest by choice.
    turn = 1.0 if smooth.real[np.argmax(np.abs(smooth.real))] > 0 else -1.0
    freedom = (1 + np.iscomplexobj(measured)) * (kept.sum() - len(fit.orders))
    noise_m = float(np.linalg.norm((measured - smooth)[kept]) / math.sqrt(freedom))

    def scaled_profile_of_fit(fit: ModeFit, size_m: float) -> ModeSum:
        return ModeSum(fit.orders, tuple((turn * fit.coefficients / size_m).tolist()), surface)

    largest_m = _largest_profile_magnitude(scaled_profile_of_fit(fit, 1.0))
    at_points = fitted.mode_values(fit.orders).T
    if settings.scale == "measured":
        scale_modes, peak_m = at_points, float(_largest_mode_sum(fit.coefficients, at_points))
    else:
        scale_modes, peak_m = _modes_on_net(fit.orders, surface), largest_m
        note = extrapolated_maximum_note(fit, surface, at_points=at_points, noise_m=noise_m)
        scan = replace(scan, notes=(*scan.notes, *note))
    bias_m = min(_peak_bias_m(fit, noise_m, scale_modes), MAX_PROFILE_ERROR * peak_m)
    peak_m -= bias_m
    if points.coordinate and not scan.is_radial:
        scan = replace(scan, notes=(*scan.notes, *other_variation_note(points, measured.real, fit)))
    scan = replace(scan, notes=(*scan.notes, *few_directions_note(fitted, fit)))
    result = SmoothedScan(
        scan=scan,
        profile=replace(scaled_profile_of_fit(fit, peak_m), largest_magnitude=largest_m / peak_m),
        out_of_phase=scaled_profile_of_fit(other, peak_m),
        peak_m=peak_m,
        peak_bias_m=bias_m,
        noise_m=noise_m,
        quadrature=quadrature,
        fit=fit,
        measured_amplitude_m=turn * measured,
        outlier_mask=~kept,
        peak_search_modes=scale_modes,
    )
    _reject_undetermined_profile(result, coordinate=points.coordinate)
    return result


def few_directions_note(points: ScanPoints, fit: ModeFit) -> list[str]:
    """A note where the points' directions from a disc's centre are what limits the degree.

    A mode of n nodal diameters needs more than 2 n directions.
    """
    if points.coordinate or not isinstance(points.surface, Disc):
        return []
    position = points.x_m + 1j * points.y_m
    outside = position[np.abs(position) > MIN_DIRECTION_RADIUS_FRACTION * np.abs(position).max()]
    directions = len(np.unique(np.round(np.degrees(np.angle(outside))) % 360))
    return [
        f"{directions} directions are too few for modes above degree {fit.degree}; scan more, or "
        "say actuator.profile.axisymmetric: true if the shape is so"
    ] * bool(np.any(fit.undetermined_coefficients_m) and directions <= 2 * (fit.degree + 1))


def other_variation_note(points: ScanPoints, measured: np.ndarray, fit: ModeFit) -> list[str]:
    """A note where a profile of two coordinates leaves far less."""
    subset = slice(None, None, -(-len(measured) // MAX_POINTS_FOR_ANGLE_CHECK))
    try:
        free = best_mode_fit(
            replace(points.subset_of_points(subset), coordinate=""), measured[subset]
        )
    except InputError:  # too few points for angles
        return []
    ratio = free.leave_one_out_error / fit.leave_one_out_error
    what, remedy = (
        ("is not axisymmetric: a profile with angles leaves", "say {}axisymmetric: false")
        if points.coordinate == "r"
        else ("varies across too: a profile of x and y leaves", "leave {}along out")
    )
    return [
        f"the scan {what} {ratio:.2g} of what this one does, and no noise or error here holds; "
        f"{remedy.format('actuator.profile.')}"
    ] * (ratio <= MAX_RESIDUAL_RATIO_WITH_ANGLES)


def extrapolated_maximum_note(
    fit: ModeFit, surface: Surface, *, at_points: np.ndarray, noise_m: float
) -> list[str]:
    """A note where the maximum is extrapolated, or less known than at the measured points."""
    net = _modes_on_net(fit.orders, surface)
    largest_m, measured_m = (
        float(_largest_mode_sum(fit.coefficients, at)) for at in (net, at_points)
    )
    bias_m, bias_at_points_m = (_peak_bias_m(fit, noise_m, at) for at in (net, at_points))
    less_known = bias_m - bias_at_points_m > (MAX_OVERSHOOT_RATIO - 1) / 2 * measured_m
    return [
        f"the profile's maximum is {largest_m * 1e6:.4g} µm, and {measured_m * 1e6:.4g} µm at the "
        f"measured points: it overshoots between or beyond the last rows, where noise adds "
        f"{bias_m * 1e6:.2g} µm, and with it the scale of all forces is uncertain. Scan more rows "
        "at the edge, or say actuator.profile.scale: measured"
    ] * bool(less_known or largest_m > MAX_OVERSHOOT_RATIO * measured_m)


def _fit_without_outliers(
    points: ScanPoints, lines: np.ndarray, measured: np.ndarray
) -> tuple[ModeFit, np.ndarray, ScanPoints]:
    """Least squares on the points that are not far from the rest; which those are, and they.

    Points are excluded and taken back in until they stay the same (iterated trimming; Rousseeuw
    and Leroy, Robust Regression and Outlier Detection, 1987).
    """
    kept, near = points, np.ones(len(measured), dtype=bool)
    largest = np.sort(np.abs(measured))[-max(5, len(measured) // 20) :]
    floor = MIN_OUTLIER_RESIDUAL_RATIO * float(np.median(largest))
    for _ in range(MAX_OUTLIER_REFITS):
        fit = best_mode_fit(kept, measured[near])
        residual = measured - points.mode_values(fit.orders) @ fit.coefficients
        parts = np.abs([residual.real, residual.imag][: 1 + np.iscomplexobj(residual)])
        noise = 1.4826 * np.median(parts, axis=1, keepdims=True)
        last = near
        near = np.all(parts <= np.maximum(OUTLIER_STANDARD_DEVIATIONS * noise, floor), axis=0)
        if np.array_equal(near, last):
            break
        kept = points.subset_of_points(near)
    outliers = np.flatnonzero(~near)
    if len(outliers) > max(1, MAX_OUTLIER_POINT_FRACTION * len(measured)):
        named = ", ".join(map(str, lines[outliers[:6]]))
        remedy = "look at them"
        if not np.any(measured[outliers]):
            remedy = "their amplitude is 0; write nan where nothing was measured"
        raise InputError(
            f"{len(outliers)} of {len(measured)} points (lines {named}, …) lie far from every "
            f"smooth profile through the rest: more than stray points; {remedy}"
        )
    return best_mode_fit(kept, measured[near]), near, kept


@lru_cache(maxsize=32)
def _modes_on_net(orders: ModeOrders, surface: Surface) -> np.ndarray:
    """The modes on the surface's net, shape (modes, points)."""
    x_m, y_m, _ = surface.net_points_and_weights()
    return surface.modes_at(orders, x_m.ravel(), y_m.ravel()).T


def _mean_square_of_profile(fit: ModeFit, surface: Surface) -> float:
    """∫ s², times a constant: small forces go as the square, and those of both motions add.

    studies/tasks/scan_errors.py has the effect on one scene.
    """
    return float(
        surface.net_points_and_weights()[2].ravel()
        @ (fit.coefficients @ _modes_on_net(fit.orders, surface)) ** 2
    )


def _largest_profile_magnitude(profile: ModeSum) -> float:
    """Largest magnitude of a profile on its surface."""

    def amplitude(x_m: np.ndarray, y_m: np.ndarray) -> np.ndarray:
        return np.asarray(profile.amplitude(x_m=x_m, y_m=y_m))

    return largest_magnitude(amplitude, surface=profile.surface)


def _largest_mode_sum(coefficients: np.ndarray, modes: np.ndarray) -> np.ndarray:
    """Largest magnitude of sums of modes (modes, places); coefficients of shape (…, modes)."""
    return np.asarray(np.abs(coefficients @ modes).max(axis=-1))


def _peak_bias_m(fit: ModeFit, noise_m: float, modes: np.ndarray) -> float:
    """Return the bias of the largest magnitude by noise.

    More noise adds less than this noise did where several places are the largest but for noise: of
    those the noisiest is the largest now. Were they all equal, noise would add its own largest. The
    bias is taken halfway.
    """
    random, shape = np.random.default_rng(PEAK_BIAS_SEED), (PEAK_BIAS_DRAW_COUNT, len(fit.orders))
    noise = noise_m * random.standard_normal(shape)
    if np.iscomplexobj(fit.coefficients):
        noise = noise + 1j * noise_m * random.standard_normal(shape)
    # Every draw and its mirror image: without curvature the mean is zero, not nearly so.
    change = np.concatenate([noise, -noise]) @ fit.root.T
    values = fit.coefficients @ modes
    largest = np.abs(values).max()
    with_noise = _largest_mode_sum(fit.coefficients + change, modes).mean()
    error_m = noise_m * np.linalg.norm(fit.root.T @ modes, axis=0)
    rivals = np.abs(values) + RIVAL_PEAK_STANDARD_ERRORS * error_m >= largest
    phases = values[rivals].conj() / np.abs(values[rivals])
    among_equals = ((change @ modes[:, rivals]) * phases).real.max(axis=1).mean()
    return max(float(with_noise - largest + among_equals) / 2, 0.0)


def _reject_undetermined_profile(smoothed: SmoothedScan, *, coordinate: str) -> None:
    """Reject a profile that the scan does not determine somewhere on the surface."""
    scan, surface = smoothed.scan, smoothed.profile.surface
    x_m, y_m, _ = surface.net_points_and_weights()
    measured, net_points = (scan.x_m + 1j * scan.y_m)[~smoothed.outlier_mask], x_m + 1j * y_m
    if coordinate:  # a point stands for the circle or the line through it
        measured, net_points = (
            np.asarray({"r": np.abs(at), "x": at.real, "y": at.imag}[coordinate], dtype=complex)
            for at in (measured, net_points)
        )
    distance = np.array(
        [np.abs(np.subtract.outer(row, measured)).min(axis=1) for row in net_points]
    )
    error = smoothed.standard_error(x_m=x_m, y_m=y_m) + smoothed.mode_misfit(x_m=x_m, y_m=y_m)
    hole, worst = (
        np.unravel_index(np.argmax(badness), badness.shape) for badness in (distance, error)
    )
    named = [f"x = {x_m[at] * 1e3:.2f} mm, y = {y_m[at] * 1e3:.2f} mm" for at in (hole, worst)]
    # Nearly square cells; a standard error falls as their side does, or faster.
    spacing_mm = 2e3 * math.sqrt(math.prod(surface.half_extents_m) / len(measured))
    remedy = (
        "the scan needs points up to there, every "
        f"{spacing_mm * MAX_PROFILE_ERROR / error[worst]:.2g} mm (now about {spacing_mm:.2g}), "
        f"less noise, or {surface.config_key} that ends where it does"
    )
    if smoothed.fit.degree == MAX_MODE_DEGREE:
        remedy = "shorter waves than these resolve need an actuator.profile by formula"
    sides = [
        min(each.max(), -each.min()) < MAX_PART_OVERLAP_FRACTION * half < 0.5 * np.ptp(each)
        for each, half in zip((scan.x_m, scan.y_m), surface.half_extents_m, strict=True)
    ]
    part = f"; of a model of a half or a quarter {surface.whole_of_part}" * any(sides)
    if coordinate:
        named[0] = f"{coordinate} = {net_points[hole].real * 1e3:.2f} mm"
    raise_first_problem(
        scan.path,
        {
            f"no point was measured within {distance[hole] * 1e3:.1f} mm of {named[0]}; the scan "
            f"needs points there, or {surface.config_key} is too large{part}": distance[hole]
            > MAX_HOLE_RADIUS_FRACTION * min(surface.half_extents_m),
            f"the profile is known to ±{error[worst]:.0%} of its maximum only at {named[1]}, by "
            f"modes of degree {smoothed.fit.degree}; {remedy}": error[worst] > MAX_PROFILE_ERROR,
            "the profile's maximum cannot be told from the noise; the scan needs more points, or "
            "less noise": smoothed.peak_bias_m >= MAX_PROFILE_ERROR * smoothed.peak_m,
        },
    )
