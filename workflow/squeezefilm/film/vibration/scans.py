"""Amplitudes measured by a scanning vibrometer, made into a smooth profile with known errors.

The profile is the least-squares sum of Zernike modes. Leave-one-out cross-validation says up to
which degree they describe the points best; two degrees more are taken, so that what is left out of
the profile is small beside what noise does to it (undersmoothing: Wasserman, All of Nonparametric
Statistics, 2006, 5.7). Points far from the rest are left out and the rest is fitted anew. The film
equation needs the profile's curvature, so that a smooth global basis serves it better than splines
with their knots. Least squares also say how sure the profile is at every place: the standard error
that noise leaves, from the residuals.

Where the scan has phases, what moves a quarter of a period from the rest is fitted likewise, and is
the profile's second part if forces depend on it.

The largest of a noisy profile is too large on average, by what profiles with more noise of the same
size tell; that much is taken off the maximum to which the profile is scaled.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path

import numpy as np

from squeezefilm.film.vibration.binning import averaging_loss, binned
from squeezefilm.film.vibration.folds import FOLDED, looks_folded
from squeezefilm.film.vibration.least_squares import Fit, best_fit, wants_angles
from squeezefilm.film.vibration.maxima import bias_of_largest, largest_on_net
from squeezefilm.film.vibration.shapes import (
    Modes,
    TwoPhases,
    Vibration,
    largest_magnitude,
    phasor_of,
)
from squeezefilm.film.vibration.surfaces import Surface
from squeezefilm.film.vibration.vibrometer import Scan, read_scan
from squeezefilm.io.errors import InputError

# A profile that is less sure than this share of its maximum somewhere is not known there.
LARGEST_ERROR = 0.25
# Nor is one that has no measured point within this share of a disc's radius, or of half a
# rectangle's shorter side.
LARGEST_HOLE = 0.35
# What the smooth motion out of phase may do to forces, as a share, and be left out.
LARGEST_OUT_OF_PHASE = 1e-3
# A point is far from the rest beyond this many standard deviations of the noise, and never if it is
# nearer than this share of the largest amplitude: that may be the profile's own fine structure.
OUTLIER, LEAST_OUTLIER = 4.5, 0.005
# More such points, as a share, are no strays.
LARGEST_STRAY = 0.05
REFITS = 20


@dataclass(frozen=True, eq=False)
class SmoothedScan:
    """A scan and the profile through it.

    Attributes:
        profile: the smooth motion in the phase of most of it, in units of the maximum of all.
        out_of_phase: that a quarter of a period apart, in the same units; dropped if it is small.
        peak_m: amplitude at the maximum, and ``peak_bias_m`` what was taken off it as the noise's.
        noise_m: standard deviation of the noise, from the residuals.
        quadrature: rms share of the motion that is out of phase, its noise included.
        degree: of the polynomial; ``scores`` has the rms error of cross-validation by degree.
        x_m, y_m, measured_m, residual_m: the points and what the profile leaves of them.
        outliers: which of them lie further from the rest than noise does; they are not fitted.
        root: (modes, modes) factor by which noise enters the coefficients.
        folded: all amplitudes were taken to one side although they look folded at a node line.
    """

    scan: Scan
    profile: Modes
    out_of_phase: Modes
    peak_m: float
    peak_bias_m: float
    noise_m: float
    quadrature: float
    degree: int
    scores: dict[int, float]
    x_m: np.ndarray
    y_m: np.ndarray
    measured_m: np.ndarray
    residual_m: np.ndarray
    outliers: np.ndarray
    root: np.ndarray
    folded: bool

    def standard_error(self, *, x_m: np.ndarray, y_m: np.ndarray) -> np.ndarray:
        """Standard error of the profile by noise, in units of its maximum."""
        half_x_m, half_y_m = self.profile.surface.half_m
        places = {"x": x_m / half_x_m, "y": y_m / half_y_m}
        modes = self.profile.surface.modes_at(self.profile.orders, **places)
        return self.noise_m / self.peak_m * np.linalg.norm(modes @ self.root, axis=-1)

    @property
    def out_of_phase_effect(self) -> float:
        """By which share forces are low without the motion out of phase, on average."""
        return _share_of_squares(self.out_of_phase, self.profile)

    @property
    def two_phases(self) -> bool:
        """Whether the motion out of phase is part of the vibration."""
        return self.out_of_phase_effect > LARGEST_OUT_OF_PHASE

    @property
    def phases(self) -> tuple[Modes, ...]:
        """The parts of the vibration."""
        return (self.profile, self.out_of_phase) if self.two_phases else (self.profile,)

    @property
    def vibration(self) -> Vibration:
        return _vibration(self.phases)

    @property
    def averaging_loss(self) -> float:
        """What averaging points over cells takes off the profile at most, of its maximum."""
        x_m, y_m, _ = self.profile.surface.net()
        losses = [
            averaging_loss(part, cell_m=self.scan.cell_m, x_m=x_m, y_m=y_m) for part in self.phases
        ]
        return math.hypot(*losses)

    @property
    def warnings(self) -> tuple[str, ...]:
        """What is to be said beside its numbers, a line each."""
        folded = [f"warning: {FOLDED}"] * self.folded
        return (*folded, *(f"note: {note}" for note in self.scan.notes))

    def residual_bootstrap(self, *, count: int, seed: int) -> list[Vibration]:
        """Profiles that scans with other noise would have given: residuals drawn anew.

        The residuals are widened by √(points/(points − modes)) to the noise's size, which their
        fit has shrunk (Davison and Hinkley, Bootstrap Methods, 1997, 6.2). Those of two phases are
        drawn apart.
        """
        surface, fitted = self.profile.surface, ~self.outliers
        half_x_m, half_y_m = surface.half_m
        places = {"x": self.x_m[fitted] / half_x_m, "y": self.y_m[fitted] / half_y_m}
        _, across, _ = _in_phases(self.scan)
        random = np.random.default_rng(seed)
        drawn_parts, raw_parts = [], []
        for part in self.phases:
            basis = surface.modes_at(part.orders, **places)
            points, modes = basis.shape
            if part is self.profile:
                root, residual = self.root, self.residual_m[fitted]
            else:
                root = np.linalg.inv(np.linalg.qr(basis, mode="r"))
                residual = across[fitted] - basis @ (root @ (root.T @ (across[fitted] @ basis)))
            centred = (residual - residual.mean()) * math.sqrt(points / (points - modes))
            noise = random.choice(centred, size=(count, points))
            raw_m = self.peak_m * np.array(part.coefficients)
            raw_parts.append((raw_m[None], part.orders))
            drawn_parts.append((raw_m + (noise @ basis) @ root @ root.T, part.orders))
        # The finer search for the maximum moves it by as little for each.
        finer = (self.peak_m + self.peak_bias_m) / largest_on_net(raw_parts, surface)[0]
        peaks = largest_on_net(drawn_parts, surface) * finer - self.peak_bias_m
        return [
            _vibration(
                [
                    Modes(orders, tuple(map(float, drawn[k] / peak)), surface, part.largest)
                    for (drawn, orders), part in zip(drawn_parts, self.phases, strict=True)
                ]
            )
            for k, peak in enumerate(peaks)
        ]


@lru_cache(maxsize=16)
def smoothed_scan(
    path: Path,
    *,
    surface: Surface,
    axisymmetric: bool,
    sign: str = "measured",
    frequency_hz: float | None = None,
) -> SmoothedScan:
    """The smooth profile of a scan's file on a surface; read and fitted once a process.

    Raises InputError naming the file, and what is wrong where or what its points leave open.
    """
    return smoothed(
        read_scan(path, frequency_hz=frequency_hz),
        surface=surface,
        axisymmetric=axisymmetric,
        sign=sign,
    )


def smoothed(
    scan: Scan, *, surface: Surface, axisymmetric: bool, sign: str = "measured"
) -> SmoothedScan:
    """The smooth profile of a scan on a surface.

    Args:
        sign: ``unknown`` takes amplitudes without phase or sign as they are although they look
            folded up at a node line; ``measured`` refuses them.

    Raises InputError naming the file, and what its points do not determine.
    """
    places_on(scan, surface, axisymmetric=axisymmetric)  # names a line of the file
    scan = binned(scan)
    x_m, y_m = places_on(scan, surface, axisymmetric=axisymmetric)
    in_phase, across, quadrature = _in_phases(scan)
    half_x_m, half_y_m = surface.half_m
    x, y = x_m / half_x_m, y_m / half_y_m
    folded = not scan.signed and looks_folded(
        scan.path, surface, x=x, y=y, amplitude=np.abs(in_phase), axisymmetric=axisymmetric
    )
    if folded and sign != "unknown":
        raise InputError(
            f"{scan.path}: the amplitudes have no phase and no sign, and look like those of a mode "
            "with a node line, folded up at it: forces would be those of another surface. Give a "
            "column phase_deg or sign, or say actuator.profile.sign: unknown to take them as they "
            "are"
        )
    fit, kept = _without_strays(scan, surface, x, y, in_phase, axisymmetric)
    other = best_fit(scan.path, surface, x[kept], y[kept], across[kept], axisymmetric)
    parts = [Modes(each.orders, tuple(each.coefficients), surface) for each in (fit, other)]
    if _share_of_squares(parts[1], parts[0]) > LARGEST_OUT_OF_PHASE:
        _, near = _without_strays(scan, surface, x, y, across, axisymmetric)
        kept &= near
        fit, other = (
            best_fit(scan.path, surface, x[kept], y[kept], each[kept], axisymmetric)
            for each in (in_phase, across)
        )
    residual = in_phase - surface.modes_at(fit.orders, x=x, y=y) @ fit.coefficients
    # Half a period later every amplitude has the other sign: positive at its largest by choice.
    fitted = in_phase - residual
    turn = 1.0 if fitted[np.argmax(np.abs(fitted))] > 0 else -1.0
    noise_m = float(np.linalg.norm(residual[kept]) / math.sqrt(kept.sum() - len(fit.orders)))
    raw = [
        Modes(each.orders, tuple(map(float, turn * each.coefficients)), surface)
        for each in (fit, other)
    ]
    moving = 1 + (_share_of_squares(raw[1], raw[0]) > LARGEST_OUT_OF_PHASE)
    vibration = _vibration(raw[:moving])
    largest_m = largest_magnitude(
        lambda x_m, y_m: phasor_of(vibration, x_m=x_m, y_m=y_m), surface=surface
    )
    bias_m = bias_of_largest([fit, other][:moving], noise_m, surface)
    bias_m = min(bias_m, LARGEST_ERROR * largest_m)
    peak_m = largest_m - bias_m
    round_by_choice = axisymmetric and scan.y_m is not None
    if round_by_choice and (note := wants_angles(scan.path, surface, x, y, in_phase, fit)):
        scan = replace(scan, notes=(*scan.notes, note))
    result = SmoothedScan(
        scan=scan,
        profile=_in_units(turn * fit.coefficients, fit, peak_m, surface, largest_m),
        out_of_phase=_in_units(turn * other.coefficients, other, peak_m, surface, largest_m),
        peak_m=peak_m,
        peak_bias_m=bias_m,
        noise_m=noise_m,
        quadrature=quadrature,
        degree=fit.degree,
        scores=fit.scores,
        x_m=x_m,
        y_m=y_m,
        measured_m=turn * in_phase,
        residual_m=turn * residual,
        outliers=~kept,
        root=fit.root,
        folded=folded,
    )
    _refuse_unknown(result, axisymmetric=axisymmetric)
    return result


def places_on(scan: Scan, surface: Surface, *, axisymmetric: bool) -> tuple[np.ndarray, np.ndarray]:
    """The points' x_m and y_m, all of them on the surface.

    Raises InputError naming the line of one that is not.
    """
    if scan.y_m is None and not axisymmetric:
        raise InputError(
            f"{scan.path}: points along a radius, without angles, can only give an axisymmetric "
            "profile; say so by actuator.profile.axisymmetric: true"
        )
    x_m, y_m = scan.x_m, np.zeros_like(scan.x_m) if scan.y_m is None else scan.y_m
    off = np.flatnonzero(surface.reach(x_m, y_m) > 1 + 1e-6)
    if len(off):
        raise InputError(
            f"{scan.path}: line {scan.lines[off[0]]}: the point lies "
            f"{surface.where(x_m[off[0]], y_m[off[0]])}, off the actuator's {surface.text} "
            f"({surface.key})"
        )
    return x_m, y_m


def _in_phases(scan: Scan) -> tuple[np.ndarray, np.ndarray, float]:
    """The amplitude along the phase of most of the motion, that across, and its rms share.

    The phase that holds most is half that of Σ u² (the ellipse's major axis). Re u e^(iωt) is
    both parts' s₁ sin T + s₂ cos T with T = ωt + π/2.
    """
    phase = np.angle(np.sum(scan.amplitude_m**2)) / 2
    turned = scan.amplitude_m * np.exp(-1j * phase)
    share = math.sqrt(float(np.mean(turned.imag**2) / np.mean(np.abs(turned) ** 2)))
    return turned.real, turned.imag, share


def _share_of_squares(part: Modes, whole: Modes) -> float:
    """∫ s₂² / ∫ s₁²: small forces go as the square of the amplitude, and both motions add.

    scan_errors.py has the effect on one scene.
    """
    x_m, y_m, weights = whole.surface.net()
    second, first = (
        np.sum(weights * modes.amplitude(x_m=x_m, y_m=y_m) ** 2) for modes in (part, whole)
    )
    return float(second / first)


def _vibration(phases: Sequence[Modes]) -> Vibration:
    """Of one part or two."""
    if len(phases) == 1:
        return phases[0]
    first, second = phases
    return TwoPhases(first, second, largest=first.largest)


def _without_strays(
    scan: Scan,
    surface: Surface,
    x: np.ndarray,
    y: np.ndarray,
    measured: np.ndarray,
    axisymmetric: bool,
) -> tuple[Fit, np.ndarray]:
    """Least squares on the points that are not far from the rest, and which those are.

    Points are left out and taken back in until they stay the same (iterated trimming; Rousseeuw
    and Leroy, Robust Regression and Outlier Detection, 1987).
    """
    kept = np.ones(len(measured), dtype=bool)
    floor = LEAST_OUTLIER * float(np.median(np.sort(np.abs(measured))[-max(5, len(x) // 20) :]))
    for _ in range(REFITS):
        fit = best_fit(scan.path, surface, x[kept], y[kept], measured[kept], axisymmetric)
        residual = np.abs(measured - surface.modes_at(fit.orders, x=x, y=y) @ fit.coefficients)
        near = residual <= max(OUTLIER * 1.4826 * float(np.median(residual)), floor)
        if np.array_equal(near, kept):
            break
        kept = near
    strays = np.flatnonzero(~kept)
    if len(strays) > max(1, LARGEST_STRAY * len(kept)):
        lines = ", ".join(str(line) for line in scan.lines[strays[:6]])
        raise InputError(
            f"{scan.path}: {len(strays)} of {len(kept)} points (lines {lines}, …) lie far from "
            "every smooth profile through the rest: more than stray points; look at them"
        )
    fit = best_fit(scan.path, surface, x[kept], y[kept], measured[kept], axisymmetric)
    return fit, kept


def _in_units(
    coefficients: np.ndarray, fit: Fit, peak_m: float, surface: Surface, largest_m: float
) -> Modes:
    return Modes(
        fit.orders, tuple(float(c) for c in coefficients / peak_m), surface, largest_m / peak_m
    )


def _refuse_unknown(smoothed: SmoothedScan, *, axisymmetric: bool) -> None:
    """Refuse a profile that the scan leaves open somewhere on the surface."""
    from scipy.spatial import cKDTree

    path, surface = smoothed.scan.path, smoothed.profile.surface
    x_m, y_m, _ = surface.net()
    seen = ~smoothed.outliers
    if axisymmetric:  # a point stands for the circle through it
        measured = np.hypot(smoothed.x_m, smoothed.y_m)[seen, None]
        places = np.hypot(x_m, y_m)[..., None]
    else:
        measured = np.column_stack([smoothed.x_m, smoothed.y_m])[seen]
        places = np.stack([x_m, y_m], axis=-1)
    distance, _ = cKDTree(measured).query(places)
    error = smoothed.standard_error(x_m=x_m, y_m=y_m)
    hole = np.unravel_index(np.argmax(distance), distance.shape)
    worst = np.unravel_index(np.argmax(error), error.shape)
    if distance[hole] > LARGEST_HOLE * min(surface.half_m):
        where = f"r = {places[hole][0] * 1e3:.2f} mm"
        if not axisymmetric:
            where = f"x = {x_m[hole] * 1e3:.2f} mm, y = {y_m[hole] * 1e3:.2f} mm"
        raise InputError(
            f"{path}: no point was measured within {distance[hole] * 1e3:.1f} mm of {where}; the "
            f"scan needs points there, or {surface.key} is too large"
        )
    if error[worst] > LARGEST_ERROR:
        raise InputError(
            f"{path}: the profile is known to ±{error[worst]:.0%} of its maximum only at "
            f"x = {x_m[worst] * 1e3:.2f} mm, y = {y_m[worst] * 1e3:.2f} mm; the scan needs more "
            "points there, or less noise"
        )
    if smoothed.peak_bias_m >= LARGEST_ERROR * smoothed.peak_m:
        raise InputError(
            f"{path}: the profile's maximum cannot be told from the noise; the scan needs more "
            "points, or less noise"
        )
