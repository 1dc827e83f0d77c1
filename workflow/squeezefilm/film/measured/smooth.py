"""Amplitudes measured by a scanning vibrometer, made into a smooth profile with known errors.

The profile is the least-squares sum of the surface's modes (surfaces.py). Leave-one-out
cross-validation says up to which degree they describe the points best; two degrees more are taken
along every side, so that what the profile neglects is small beside what noise does to it
(undersmoothing: Wasserman, All of Nonparametric Statistics, 2006, 5.7). Where there are too few
points for these, the last two degrees estimate the misfit, an error besides the noise.

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
from dataclasses import dataclass, fields, is_dataclass, replace
from decimal import Decimal
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from squeezefilm.errors import InputError, prefix_errors, raise_first_problem
from squeezefilm.files import atomic_file, file_digest
from squeezefilm.film.measured.centre import centre_of_symmetry
from squeezefilm.film.measured.read import read_scan
from squeezefilm.film.measured.scan import SAME_POSITION_DISTANCE_M, PointRemedies, Scan
from squeezefilm.film.profiles import ModeSum, largest_magnitude
from squeezefilm.film.surfaces import Disc, ModeOrders, Rectangle, Surface

MAX_MODE_DEGREE = 24
# The fewest points per mode that cross-validation looks at, and for degrees above its best one.
MIN_POINTS_PER_MODE, MIN_POINTS_PER_EXTRA_MODE = 1.5, 3
MAX_CONDITION_NUMBER = 1e8
# One less the leverage of a point that others determine too.
MIN_ONE_MINUS_LEVERAGE = 1e-6
# Degrees above the best by cross-validation, so that the misfit is small beside the noise.
EXTRA_MODE_DEGREES = 2
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
# Draws of noise by which the bias of the maximum is estimated.
PEAK_BIAS_DRAW_COUNT, PEAK_BIAS_SEED = 200, 1
# A place may be the largest if it is lower by no more than this many standard errors.
RIVAL_PEAK_STANDARD_ERRORS = 2.0
UNSIGNED_PROBLEM = (
    "the amplitudes have no phase and no sign: across a node line they would be those of another "
    "surface. Give a column phase_deg or sign, or say actuator.profile.sign: unknown if the "
    "surface has no node line"
)
UNSIGNED_WARNING = (
    "the scan has no phase or sign: all amplitudes are taken to one side, and over a node line the "
    "force is that of another surface, which no error here contains"
)
# A scan of a smaller share of its surface's radius or half side has another unit, if it fits then;
# and by how much points may miss a surface that is only to be told.
MIN_SCAN_EXTENT_FRACTION, EXTENT_TOLERANCE_FRACTION = 0.1, 0.03
# Points on the edge may lie beyond it by so much, or by the last digit of coordinates up to more.
EDGE_TOLERANCE_FRACTION, MAX_EDGE_TOLERANCE_FRACTION = 1e-3, 0.01
ROUND_OFF_FRACTION = 1e-6
# Digits of a coordinate that are not of its conversion to metres.
COORDINATE_DIGITS = 12
# Origins are proposed in steps of so much.
ORIGIN_STEP_M = 1e-6
# About the middle of their extents, which may be off by half their distance, they miss it by more.
MIDDLE_TOLERANCE_FRACTION = 0.1
# An origin is doubted that is so much further from the shape's centre than this may be off.
MIN_ORIGIN_OFFSET_FRACTION = 0.005
# More points are not fitted: enough for all modes to be known to a hundredth of the noise.
MAX_FITTED_POINTS, THINNING_SEED = 20_000, 1


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
        return (*unsigned, *(f"note: {note}" for note in self.scan.notes))

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
    path: Path,
    *,
    frequency_hz: float | None = None,
    rows: str = "",
    origin_m: tuple[float, float] = (0.0, 0.0),
    **settings: Any,
) -> SmoothedScan:
    """The smooth profile of a scan's file, as ``smooth_scan`` makes it.

    Raises InputError naming the file, and the place of the error or the undetermined region.
    """
    scan = checked_scan_of_file(
        path, frequency_hz=frequency_hz, rows=rows, origin_m=origin_m, **settings
    )
    return smooth_scan(scan, **settings)


def checked_scan_of_file(
    path: Path,
    *,
    frequency_hz: float | None = None,
    rows: str = "",
    origin_m: tuple[float, float] = (0.0, 0.0),
    **settings: Any,
) -> Scan:
    """The points of a scan's file, which ``smooth_scan`` may make a profile of by the settings.

    Raises InputError naming all that the file or the settings need for it.
    """
    remedies = point_remedies(origin_m=origin_m, **settings)
    scan = read_scan(
        path, frequency_hz=frequency_hz, rows=rows, origin_m=origin_m, remedies=remedies
    )
    check_points(scan, **settings)
    return scan


def smooth_scan(
    scan: Scan,
    *,
    surface: Surface,
    axisymmetric: bool,
    along: str = "",
    sign: str = "measured",
    scale: str = "surface",
) -> SmoothedScan:
    """The smooth profile of a scan on a surface.

    Args:
        along: on a rectangle the coordinate, x or y, that the shape depends on alone.
        sign: ``unknown`` takes amplitudes without phase or sign to one side; ``measured`` rejects
            them.
        scale: whether the maximum is that on the whole ``surface``, or at the ``measured`` points.

    Raises InputError naming the file, and what its points do not determine.
    """
    check_points(scan, surface=surface, axisymmetric=axisymmetric, along=along, sign=sign)
    notes = (*_edge_note(scan, surface), *_origin_note(scan, surface))
    scan = replace(scan, notes=(*scan.notes, *notes))
    scan = limit_point_count(average_repeated_points(scan))
    points = ScanPoints(surface, "r" if axisymmetric else along, scan.x_m, scan.y_m)
    # Re u e^(iωt) is both parts' s₁ sin T + s₂ cos T with T = ωt + π/2.
    measured = _turned_to_main_phase(scan.amplitude_m)
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
    if scale == "measured":
        scale_modes, peak_m = at_points, float(_largest_mode_sum(fit.coefficients, at_points))
    else:
        scale_modes, peak_m = _modes_on_net(fit.orders, surface), largest_m
        note = extrapolated_maximum_note(fit, surface, at_points=at_points, noise_m=noise_m)
        scan = replace(scan, notes=(*scan.notes, *note))
    bias_m = min(_peak_bias_m(fit, noise_m, scale_modes), MAX_PROFILE_ERROR * peak_m)
    peak_m -= bias_m
    if points.coordinate and not scan.is_radial:
        scan = replace(scan, notes=(*scan.notes, *other_variation_note(points, measured.real, fit)))
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


@dataclass(frozen=True, eq=False)
class ScanPoints:
    """Measurement points of a scan.

    Attributes:
        coordinate: r, x or y, that modes depend on alone; "" if on two.
        x_m, y_m: the points, shape (points,).
        wave_ratio: of the family of modes (surfaces.py).
    """

    surface: Surface
    coordinate: str
    x_m: np.ndarray
    y_m: np.ndarray
    wave_ratio: float = 1.0

    @cached_property
    def with_each_mode_family(self) -> list[ScanPoints]:
        """The same points with each family of the surface's modes."""
        return [replace(self, wave_ratio=ratio) for ratio in self.surface.wave_ratios]

    def subset_of_points(self, rows: np.ndarray | slice) -> ScanPoints:
        """Some of the points."""
        return replace(self, x_m=self.x_m[rows], y_m=self.y_m[rows])

    def mode_values(self, orders: ModeOrders) -> np.ndarray:
        """Values of modes at the points, shape (points, modes)."""
        return self.surface.modes_at(orders, self.x_m, self.y_m)

    def orders_up_to(self, degree: int, *, degrees_more: int = 0) -> ModeOrders:
        """The family's modes up to a degree, and so many degrees more along every side."""
        return self.surface.orders_up_to(
            degree,
            degrees_more=degrees_more,
            coordinate=self.coordinate,
            wave_ratio=self.wave_ratio,
        )

    @cached_property
    def orders_by_degree(self) -> dict[int, ModeOrders]:
        """The modes up to each degree that so many points allow.

        Those of a degree come before those of the next.
        """
        degrees = range(0, MAX_MODE_DEGREE + 1, 2 if self.coordinate == "r" else 1)
        every = {n: self.orders_up_to(n) for n in degrees}
        enough = len(self.x_m) / MIN_POINTS_PER_MODE
        return {n: orders for n, orders in every.items() if len(orders) <= enough}

    @cached_property
    def qr_decomposition(self) -> tuple[np.ndarray, np.ndarray]:
        """The QR decomposition of the modes up to the largest degree, which serves all."""
        q, r = np.linalg.qr(self.mode_values(self.orders_by_degree[max(self.orders_by_degree)]))
        return q, r


@dataclass(frozen=True)
class ModeFit:
    """Least squares on the modes up to one degree.

    ``leave_one_out_error`` is the least rms error, over degrees, at held-out points, and ``root``
    (modes, modes) the factor by which the points' noise enters the coefficients: their covariance
    is noise² root rootᵀ. ``misfit_coefficients_m``, coefficients too, estimates what degrees add
    that the points do not determine; it is zero where EXTRA_MODE_DEGREES above the best degree are
    taken.
    """

    degree: int
    orders: ModeOrders
    coefficients: np.ndarray
    root: np.ndarray
    leave_one_out_error: float
    undetermined_coefficients_m: np.ndarray


def best_mode_fit(points: ScanPoints, measured: np.ndarray) -> ModeFit:
    """Least squares by the family of modes of least leave-one-out error.

    Raises InputError where the points determine no profile.
    """
    fits = [_best_fit_of_mode_family(family, measured) for family in points.with_each_mode_family]
    return min(fits, key=lambda fit: fit.leave_one_out_error)


def _best_fit_of_mode_family(points: ScanPoints, measured: np.ndarray) -> ModeFit:
    """Least squares, EXTRA_MODE_DEGREES above the degree of least leave-one-out error.

    The error at a left-out point is e/(1 − h), h its leverage, without fitting again (Allen's
    PRESS).

    Raises InputError where the points determine no profile.
    """
    orthogonal, triangle = points.qr_decomposition
    # More modes are never better determined: where the most are, one condition number will do.
    sure = np.linalg.cond(triangle) <= MAX_CONDITION_NUMBER
    scores: dict[int, float] = {}
    for degree, orders in points.orders_by_degree.items():
        count = len(orders)
        determined = sure or np.linalg.cond(triangle[:count, :count]) <= MAX_CONDITION_NUMBER
        score = _leave_one_out_error(orthogonal[:, :count], measured)
        if not determined or not np.isfinite(score):
            break
        scores[degree] = score
    if not scores:
        raise InputError("the points do not determine a profile")
    best = min(scores, key=scores.__getitem__)
    more, orders, orthogonal, triangle = _modes_with_extra_degrees(points, best)
    degree, root = best + more, np.linalg.inv(triangle)
    coefficients = root @ (orthogonal.T @ measured)
    misfit_m = np.zeros_like(coefficients)
    if EXTRA_MODE_DEGREES <= degree < min(best + EXTRA_MODE_DEGREES, MAX_MODE_DEGREE):
        # The change by the last degrees, by so much less as errors at held-out points fall on half
        # the way to them.
        lower_orders = points.orders_by_degree[degree - EXTRA_MODE_DEGREES]
        lower = np.linalg.lstsq(points.mode_values(lower_orders), measured, rcond=None)[0]
        fall = math.sqrt(
            _leave_one_out_error(orthogonal, measured) / scores[degree - EXTRA_MODE_DEGREES]
        )
        change = coefficients.copy()
        change[[orders.index(order) for order in lower_orders]] -= lower
        misfit_m = min(fall, 1.0) * change
    return ModeFit(degree, orders, coefficients, root, scores[best], misfit_m)


def _leave_one_out_error(orthogonal: np.ndarray, measured: np.ndarray) -> float:
    """Rms error at held-out points, one by one; infinite where a point alone determines a mode.

    Args:
        orthogonal: modes made orthonormal at the points, shape (points, modes).
    """
    left = 1 - np.sum(orthogonal**2, axis=1)
    if left.min() < MIN_ONE_MINUS_LEVERAGE:
        return math.inf
    residual = measured - orthogonal @ (orthogonal.T @ measured)
    return float(np.sqrt(np.mean(np.abs(residual / left) ** 2)))


def _modes_with_extra_degrees(
    points: ScanPoints, best: int
) -> tuple[int, ModeOrders, np.ndarray, np.ndarray]:
    """Up to EXTRA_MODE_DEGREES above the best degree: how many, their modes and their QR
    decomposition.

    Along every side of the surface: waves along one side choose a family with few modes along the
    other, where the profile may have a slope that is as small as the noise.
    """
    enough = len(points.x_m) / MIN_POINTS_PER_EXTRA_MODE
    for more in range(min(EXTRA_MODE_DEGREES, MAX_MODE_DEGREE - best), 0, -1):
        orders = points.orders_up_to(best, degrees_more=more)
        if len(points.orders_by_degree[best]) < len(orders) <= enough:
            q, r = np.linalg.qr(points.mode_values(orders))
            left = 1 - np.sum(q**2, axis=1).max()
            if np.linalg.cond(r) <= MAX_CONDITION_NUMBER and left >= MIN_ONE_MINUS_LEVERAGE:
                return more, orders, q, r
    orders = points.orders_by_degree[best]
    return 0, orders, *np.linalg.qr(points.mode_values(orders))


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


def point_remedies(
    *,
    surface: Surface,
    axisymmetric: bool,
    along: str = "",
    sign: str = "measured",
    origin_m: tuple[float, float] = (0.0, 0.0),
    scale: str = "surface",
) -> PointRemedies:
    """Return the texts on what a study must settle about points, "" where it has."""
    settled = axisymmetric or bool(along)
    return PointRemedies(
        on_line=surface.line_scan_problem * (not settled),
        on_one_side=(
            "its points lie on one side of x = 0 or y = 0: if they are a part of the surface, "
            f"{surface.whole_of_part}; if they are all of it, say where its centre is by "
            "actuator.profile.origin"
        )
        * (not settled and origin_m == (0.0, 0.0)),
        unsigned=UNSIGNED_PROBLEM * (sign != "unknown"),
    )


def check_points(
    scan: Scan,
    *,
    surface: Surface,
    axisymmetric: bool,
    along: str = "",
    sign: str = "measured",
    scale: str = "surface",
) -> None:
    """Reject a scan with a point off the surface, or whose coordinates or signs are too few."""
    reach = surface.relative_distance(scan.x_m, scan.y_m)
    remedies = point_remedies(surface=surface, axisymmetric=axisymmetric, along=along, sign=sign)
    problems = [remedies.unsigned * (not scan.has_phase_or_sign)]
    at_m = {"x": scan.x_m, "y": scan.y_m}
    on_line = scan.is_radial or (
        isinstance(surface, Rectangle)
        and min(map(np.ptp, at_m.values())) < SAME_POSITION_DISTANCE_M
    )
    problems += [remedies.on_line * bool(on_line)]
    problems += [
        f"the points do not lie along {along} (actuator.profile.along); name their column {along}"
    ] * bool(along and not np.ptp(at_m[along]) > SAME_POSITION_DISTANCE_M)
    problems += [
        f"line {scan.lines[row]}: the point lies "
        f"{surface.position_text(scan.x_m[row], scan.y_m[row])}, off the actuator's "
        f"{surface.text} ({surface.config_key}){_fitting_origin_or_unit_note(scan, surface)}"
        for row in [np.argmax(reach)]
        if reach[row] > 1 + edge_tolerance(scan, surface)
    ]
    if any(problems):
        raise InputError(f"{scan.path}: {'; and '.join(filter(None, problems))}")
    if (
        hint := _fitting_origin_or_unit_note(scan, surface)
        if reach.max() < MIN_SCAN_EXTENT_FRACTION
        else ""
    ):
        raise InputError(
            f"{scan.path}: all points lie at the centre of the {surface.text} "
            f"({surface.config_key}){hint}"
        )


def edge_tolerance(scan: Scan, surface: Surface) -> float:
    """Relative distance by which points on the edge may lie beyond it: by their last digit."""
    drawn, last_digit_m = slice(None, None, -(-len(scan.x_m) // MAX_POINTS_FOR_ANGLE_CHECK)), 0.0
    for at_m in (scan.x_m + scan.origin_m[0], scan.y_m + scan.origin_m[1]):
        largest = Decimal(np.abs(at_m).max()).adjusted() if np.any(at_m) else -np.inf
        written = [Decimal(f"{value:.{COORDINATE_DIGITS}g}").normalize() for value in at_m[drawn]]
        # The largest has as many digits as any: zeros at the end are not always written.
        digit_count = max(len(value.as_tuple().digits) for value in written)
        last_digit_m = max(last_digit_m, 10.0 ** (largest - digit_count + 1))
    own = last_digit_m / min(surface.half_extents_m)
    return min(max(own, EDGE_TOLERANCE_FRACTION), MAX_EDGE_TOLERANCE_FRACTION)


def _edge_note(scan: Scan, surface: Surface) -> list[str]:
    """A note on points beyond the edge, by no more than ``edge_tolerance``."""
    beyond = surface.relative_distance(scan.x_m, scan.y_m) - 1
    count, most_um = int(np.sum(beyond > ROUND_OFF_FRACTION)), 1e6 * min(surface.half_extents_m)
    return [
        f"{count} points up to {most_um * beyond.max():.2g} µm beyond the edge "
        f"({surface.config_key}) are taken for rounded ones on it"
    ] * bool(count)


def _fitting_origin_or_unit_note(scan: Scan, surface: Surface) -> str:
    """The origin or the unit of positions by which a scan would cover its surface, if any."""
    reach = float(surface.relative_distance(scan.x_m, scan.y_m).max())
    if reach > 1 and (note := _fitting_origin_note(scan, surface)):
        return note
    for factor, text in ((1e3, "1000 times larger"), (1e-3, "1000 times smaller")):
        if MIN_SCAN_EXTENT_FRACTION < factor * reach <= 1 + EXTENT_TOLERANCE_FRACTION:
            return (
                f"; they fit with positions {text}: give their unit as it is (in the header; in a "
                "universal file by data set 164, without which it is m)"
            )
    return ""


def _fitting_origin_note(scan: Scan, surface: Surface) -> str:
    """The origin with which all points lie on the surface: the shape's centre or their middle."""
    positions_m = np.stack([scan.x_m, scan.y_m])
    middle_m = (positions_m.min(axis=1) + positions_m.max(axis=1)) / 2
    half_extents_m = np.ptp(positions_m, axis=1) / 2
    margin_m = float(np.max((surface.half_extents_m - half_extents_m)[half_extents_m > 0]))
    origins = [(middle_m, "the middle of their extents")]
    if margin_m >= ORIGIN_STEP_M:
        doubt = f", which may be {1e3 * margin_m:.2g} mm off: write the actuator's true centre"
        origins = [(middle_m, origins[0][1] + doubt)]
    centre = _centre_of_symmetry(scan, middle_m, surface)
    if centre and centre[1] < margin_m / 2:
        offset_m, error_m = centre
        text = f"where the shape is symmetric (± {max(1e3 * error_m, 1e-3):.1g} mm)"
        origins.insert(0, (middle_m + offset_m, text))
    for position_m, text in origins:
        origin_m = ORIGIN_STEP_M * np.round((position_m + scan.origin_m) / ORIGIN_STEP_M) + 0.0
        x_m, y_m = origin_m - scan.origin_m
        beyond = surface.relative_distance(scan.x_m - x_m, scan.y_m - y_m).max() - 1
        origin_text = "[" + ", ".join(f"{1e3 * each:.6g} mm" for each in origin_m) + "]"
        if beyond <= edge_tolerance(scan, surface):
            return f"; all lie on it with actuator.profile.origin: {origin_text}, {text}"
    own_beyond = surface.relative_distance(scan.x_m, scan.y_m).max() - 1
    if own_beyond <= min(MIDDLE_TOLERANCE_FRACTION, beyond + EXTENT_TOLERANCE_FRACTION):
        return f"; if it ends there, say {surface.enclosing_text(scan.x_m, scan.y_m)}"
    if beyond <= EXTENT_TOLERANCE_FRACTION:
        return (
            f"; about the middle of their extents, {origin_text}, they reach beyond it by "
            f"{beyond:.1%}: say {surface.enclosing_text(scan.x_m - x_m, scan.y_m - y_m)} too"
        )
    return ""


def _centre_of_symmetry(
    scan: Scan, start_m: np.ndarray, surface: Surface
) -> tuple[np.ndarray, float] | None:
    """The shape's centre of symmetry from a position in the scan, and its error, if it has one."""
    x_m, y_m = scan.x_m - start_m[0], scan.y_m - start_m[1]
    if surface.relative_distance(x_m, y_m).max() > 1 + MIDDLE_TOLERANCE_FRACTION:
        return None
    scan = limit_point_count(average_repeated_points(replace(scan, x_m=x_m, y_m=y_m)))
    measured = _turned_to_main_phase(scan.amplitude_m).real
    try:
        of_radius = scan.is_radial and isinstance(surface, Disc)
        points = ScanPoints(surface, "r" * of_radius, scan.x_m, scan.y_m)
        fit = best_mode_fit(points, measured)
    except InputError:
        return None
    return centre_of_symmetry(scan.x_m, scan.y_m, measured, surface, fit.orders)


def _origin_note(scan: Scan, surface: Surface) -> list[str]:
    """A note where the shape is symmetric about another position than the origin given."""
    if scan.origin_m == (0.0, 0.0) or not (
        centre := _centre_of_symmetry(scan, np.zeros(2), surface)
    ):
        return []
    offset_m, error_m = centre
    distance_m = float(np.hypot(*offset_m))
    reach = surface.relative_distance(scan.x_m - offset_m[0], scan.y_m - offset_m[1]).max()
    least_m = error_m + MIN_ORIGIN_OFFSET_FRACTION * surface.half_extents_m[0]
    if distance_m <= least_m or reach > 1 + EXTENT_TOLERANCE_FRACTION:
        return []
    x_mm, y_mm = 1e3 * (offset_m + scan.origin_m)
    return [
        f"the shape is symmetric about [{x_mm:.2f} mm, {y_mm:.2f} mm] (± {1e3 * error_m:.1g} mm), "
        f"{1e3 * distance_m:.2f} mm from actuator.profile.origin: if the actuator's centre is "
        "there, write it; no error here contains this"
    ]


def _turned_to_main_phase(amplitude_m: np.ndarray) -> np.ndarray:
    """Amplitudes turned to the phase that holds most, half that of Σ u² (the major axis)."""
    return np.asarray(amplitude_m * np.exp(-0.5j * np.angle(np.sum(amplitude_m**2))))


def average_repeated_points(scan: Scan) -> Scan:
    """A scan with one point at each place, the mean of the rows there, at the first one's line.

    Rows of a place are no independent evidence of a shape between places: cross-validation holds
    them out together, and noise that they share is counted once.
    """
    steps = np.round(np.stack([scan.x_m, scan.y_m]) / SAME_POSITION_DISTANCE_M)
    _, first, position, rows = np.unique(
        steps, axis=1, return_index=True, return_inverse=True, return_counts=True
    )
    if rows.max() == 1:
        return scan
    real, imaginary = (
        np.bincount(position.ravel(), weights=part) / rows
        for part in (scan.amplitude_m.real, scan.amplitude_m.imag)
    )
    order = np.argsort(first)
    amplitude_m, kept = (real + 1j * imaginary)[order], first[order]
    columns = {name: getattr(scan, name)[kept] for name in ("x_m", "y_m", "lines")}
    note = f"{len(scan.x_m)} rows at {len(kept)} places: the mean at each place is fitted"
    return replace(scan, **columns, amplitude_m=amplitude_m, notes=(*scan.notes, note))


def limit_point_count(scan: Scan) -> Scan:
    """A scan of at most MAX_FITTED_POINTS points: itself, or as many of its points, drawn at
    random."""
    points = len(scan.x_m)
    if points <= MAX_FITTED_POINTS:
        return scan
    drawn = np.random.default_rng(THINNING_SEED).choice(points, MAX_FITTED_POINTS, replace=False)
    columns = ("x_m", "y_m", "amplitude_m", "lines")
    kept_columns = {name: getattr(scan, name)[np.sort(drawn)] for name in columns}
    note = f"{MAX_FITTED_POINTS} of {points} points are fitted, drawn at random"
    return replace(scan, **kept_columns, notes=(*scan.notes, note))


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


SMOOTHED_SCAN_FIELDS = {each.name for each in fields(SmoothedScan)}
TUPLE_FIELDS = {
    Scan: {"notes", "origin_m"},
    ModeFit: {"orders"},
    ModeSum: {"orders", "coefficients"},
}
"""Values that are tuples where others are arrays."""


def write_smoothed_scan(smoothed: SmoothedScan, path: Path, **settings: Any) -> None:
    """Write a smoothed scan, whole or not at all: smoothing takes up to a minute, reading no time.

    The file, NumPy's .npz, has an array for each value and holds no code.

    Args:
        settings: with which it was smoothed (``smoothed_scan_of_file``).

    Raises InputError where the file cannot be written.
    """
    values = _flattened_fields(smoothed) | {
        "made_from": _scan_fingerprint(smoothed.scan.path, settings)
    }
    with atomic_file(path) as part, part.open("wb") as file:
        np.savez(file, allow_pickle=False, **values)


def _scan_fingerprint(scan: Path, settings: dict[str, Any]) -> str:
    return f"{file_digest(scan)} {sorted(settings.items())}"


def _flattened_fields(part: Any) -> dict[str, Any]:
    """The values of a dataclass by names, those of its parts behind the part's; without places."""
    values: dict[str, Any] = {}
    for name in (each.name for each in fields(part)):
        value = getattr(part, name)
        if is_dataclass(value):
            values |= {f"{name}.{inner}": each for inner, each in _flattened_fields(value).items()}
        elif not isinstance(value, Path):
            values[name] = value
    return values


@lru_cache(maxsize=4)
def read_smoothed_scan(path: Path, scan: Path, **settings: Any) -> SmoothedScan:
    """Return the smoothed scan that write_smoothed wrote.

    Raises InputError for a file that is none, or was made from another scan or other settings.
    """
    try:
        with np.load(path, allow_pickle=False) as file:
            values = {name: each if each.ndim else each.item() for name, each in file.items()}
        made_from, surface = values["made_from"], settings["surface"]
        smoothed = SmoothedScan(
            scan=_rebuilt_dataclass(Scan, values, "scan.", path=scan),
            fit=_rebuilt_dataclass(ModeFit, values, "fit."),
            profile=_rebuilt_dataclass(ModeSum, values, "profile.", surface=surface),
            out_of_phase=_rebuilt_dataclass(ModeSum, values, "out_of_phase.", surface=surface),
            **{name: each for name, each in values.items() if name in SMOOTHED_SCAN_FIELDS},
        )
    except Exception as error:  # whatever a damaged file makes of it
        raise InputError(f"{path}: not a smoothed scan: {error}") from None
    if made_from != _scan_fingerprint(scan, settings):
        raise InputError(
            f"{path}: was smoothed from another {scan.name}, or with other settings of "
            "actuator.profile; `snakemake profile` updates it"
        )
    return smoothed


def _rebuilt_dataclass(kind: Any, values: dict[str, Any], place: str, **given: Any) -> Any:
    """A dataclass of stored values by names, which stand behind its place."""
    stored = {
        each.name: values[place + each.name] for each in fields(kind) if each.name not in given
    }
    for name in TUPLE_FIELDS[kind] & stored.keys():
        rows = stored[name].tolist()
        stored[name] = tuple(tuple(row) if isinstance(row, list) else row for row in rows)
    return kind(**given, **stored)
