"""Amplitudes measured by a scanning vibrometer, made into a smooth profile with known errors.

A scan is a CSV file with one row per point. Its header names quantity and unit:

    x_mm, y_mm          or  r_mm  or  r_mm, phi_deg     place, from the actuator's centre
    amplitude_um                                        peak amplitude, or with a sign of its own
    phase_deg           or  sign                        optional

Units: m, mm, um (or µm) and nm; deg and rad. A row whose amplitude is empty or ``nan`` is a point
that could not be measured and is left out.

The profile is the least-squares sum of Zernike modes up to a degree that is chosen by leave-one-out
cross-validation. The film equation needs the profile's curvature, so that a smooth global basis
serves it better than splines with their knots. Least squares also say how sure the profile is at
every place: the standard error that noise leaves, from the residuals.
"""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np

from squeezefilm.errors import InputError
from squeezefilm.profiles.shapes import Modes, largest_magnitude
from squeezefilm.profiles.zernike import modes_at, orders_up_to

LENGTHS_M = {"m": 1.0, "mm": 1e-3, "um": 1e-6, "µm": 1e-6, "μm": 1e-6, "nm": 1e-9}
ANGLES_RAD = {"deg": math.pi / 180, "°": math.pi / 180, "rad": 1.0}
UNITS: Mapping[str, Mapping[str, float]] = {
    "x": LENGTHS_M,
    "y": LENGTHS_M,
    "r": LENGTHS_M,
    "phi": ANGLES_RAD,
    "amplitude": LENGTHS_M,
    "phase": ANGLES_RAD,
    "sign": {"": 1.0},
}
PLACES = ({"x", "y"}, {"r", "phi"}, {"r"})
COLUMN = re.compile(r"(?P<quantity>[a-z]+?)(?:_(?P<unit>[^_]+))?")
FORM = "columns such as x_mm, y_mm, amplitude_um, phase_deg or r_mm, amplitude_um"

FEWEST_POINTS, MOST_POINTS = 8, 20_000
LARGEST_DEGREE = 24
POINTS_PER_MODE = 3
# Degrees whose cross-validation is this close to the best are as good: the coarsest is taken.
AS_GOOD = 1.001
# A profile that is less sure than this share of its maximum somewhere is not known there.
LARGEST_ERROR = 0.25
# Nor is one that has no measured point within this share of the disc's radius.
LARGEST_HOLE = 0.35
# Share of the motion, in rms, out of phase with the rest: more is a travelling wave.
LARGEST_QUADRATURE = 0.3
OUTLIER = 4.5


@dataclass(frozen=True)
class Scan:
    """Measured points in metres and the complex amplitude there, each of shape (points,).

    Without angles ``y_m`` is None and ``x_m`` the distance from the centre. ``lines`` are the
    rows' places in the file and ``missing`` counts points without an amplitude.
    """

    path: Path
    x_m: np.ndarray
    y_m: np.ndarray | None
    amplitude_m: np.ndarray
    lines: np.ndarray
    missing: int


@dataclass(frozen=True, eq=False)
class SmoothedScan:
    """A scan and the profile through it.

    Attributes:
        profile: the smooth profile, its largest magnitude on the disc 1.
        peak_m: amplitude at that maximum.
        noise_m: standard deviation of the noise, from the residuals.
        quadrature: rms share of the motion that is out of phase, dropped.
        degree: of the polynomial; ``scores`` has the rms error of cross-validation by degree.
        x_m, y_m, measured_m, residual_m: the points and what the profile leaves of them.
        outliers: which of them lie further from the rest than noise does.
        root: (modes, modes) factor by which noise enters the coefficients.
    """

    scan: Scan
    profile: Modes
    peak_m: float
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

    def standard_error(self, *, x_m: np.ndarray, y_m: np.ndarray) -> np.ndarray:
        """Standard error of the profile by noise, in units of its maximum."""
        radius = self.profile.surface_radius_m
        modes = modes_at(self.profile.orders, x=x_m / radius, y=y_m / radius)
        return self.noise_m / self.peak_m * np.linalg.norm(modes @ self.root, axis=-1)

    def again(self, *, count: int, seed: int) -> list[Modes]:
        """Profiles that scans with other noise would have given: residuals drawn anew.

        The residuals are widened by √(points/(points − modes)) to the noise's size, which their
        fit has shrunk (Davison and Hinkley, Bootstrap Methods, 1997, 6.2).
        """
        points, modes = len(self.residual_m), len(self.profile.coefficients)
        radius = self.profile.surface_radius_m
        basis = modes_at(self.profile.orders, x=self.x_m / radius, y=self.y_m / radius)
        centred = (self.residual_m - self.residual_m.mean()) * math.sqrt(points / (points - modes))
        random = np.random.default_rng(seed)
        drawn = []
        for _ in range(count):
            noise = random.choice(centred, size=points)
            change = self.root @ (self.root.T @ (basis.T @ noise))
            coefficients = self.peak_m * np.array(self.profile.coefficients) + change
            drawn.append(_normalised(coefficients, self.profile.orders, radius)[0])
        return drawn


@lru_cache(maxsize=16)
def smoothed_scan(path: Path, *, surface_radius_m: float, axisymmetric: bool) -> SmoothedScan:
    """The smooth profile of a scan on a disc; read and fitted once a process.

    Raises:
        InputError: naming the file and the row or column that is wrong, or what the points do not
            determine.
    """
    scan = read_scan(path)
    if scan.y_m is None and not axisymmetric:
        raise InputError(
            f"{path}: points along a radius, without angles, can only give an axisymmetric "
            "profile; say so by actuator.profile.axisymmetric: true"
        )
    x_m, y_m = scan.x_m, np.zeros_like(scan.x_m) if scan.y_m is None else scan.y_m
    off = np.flatnonzero(np.hypot(x_m, y_m) > surface_radius_m * (1 + 1e-6))
    if len(off):
        raise InputError(
            f"{path}: line {scan.lines[off[0]]}: the point lies "
            f"{np.hypot(x_m, y_m)[off[0]] * 1e3:.2f} mm from the centre, off the actuator's "
            f"{surface_radius_m * 1e3:.2f} mm disc (actuator.surface_radius_m)"
        )
    measured, quadrature = _in_one_phase(scan)
    fit = _best_fit(scan, x_m / surface_radius_m, y_m / surface_radius_m, measured, axisymmetric)
    # Half a period later every amplitude has the other sign: positive at its largest by choice.
    fitted = measured - fit.residual
    sign = 1.0 if fitted[np.argmax(np.abs(fitted))] > 0 else -1.0
    profile, peak_m = _normalised(sign * fit.coefficients, fit.orders, surface_radius_m)
    noise_m = math.sqrt(float(fit.residual @ fit.residual) / (len(measured) - len(fit.orders)))
    spread = 1.4826 * np.median(np.abs(fit.residual)) + 1e-12 * peak_m
    smoothed = SmoothedScan(
        scan=scan,
        profile=profile,
        peak_m=peak_m,
        noise_m=noise_m,
        quadrature=quadrature,
        degree=fit.degree,
        scores=fit.scores,
        x_m=x_m,
        y_m=y_m,
        measured_m=sign * measured,
        residual_m=sign * fit.residual,
        outliers=np.abs(fit.residual) > OUTLIER * spread,
        root=fit.root,
    )
    _refuse_unknown(smoothed, axisymmetric=axisymmetric)
    return smoothed


def read_scan(path: Path | str) -> Scan:
    """Read a vibrometer's table.

    Raises:
        InputError: naming the file and the row or column that is wrong, and what is allowed.
    """
    path = Path(path)
    rows = _rows(path)
    header = rows[0][1]
    scale = _columns(header, path=path)
    values: list[list[float]] = []
    lines: list[int] = []
    missing = 0
    for line, cells in rows[1:]:
        if len(cells) != len(header):
            raise InputError(
                f"{path}: line {line}: {len(cells)} cells where the header has {len(header)}"
            )
        row = dict(zip(scale, cells, strict=True))
        if row["amplitude"].lower() in ("", "nan", "na"):
            missing += 1
            continue
        values.append(
            [_number(row[name], path=path, line=line, name=name) * scale[name] for name in scale]
        )
        lines.append(line)
    if len(values) > MOST_POINTS:
        raise InputError(f"{path}: {len(values)} points; at most {MOST_POINTS} are taken")
    if len(values) < FEWEST_POINTS:
        raise InputError(
            f"{path}: {len(values)} measured points ({missing} missing); a profile needs at least "
            f"{FEWEST_POINTS}"
        )
    table = dict(zip(scale, np.array(values).T, strict=True))
    _check_values(table, path=path, lines=lines)
    amplitude = table["amplitude"].astype(complex)
    if "sign" in table:
        amplitude *= table["sign"]
    if "phase" in table:
        amplitude *= np.exp(1j * table["phase"])
    x_m, y_m = table.get("x"), table.get("y")
    if x_m is None:
        x_m = table["r"]
        if "phi" in table:
            x_m, y_m = x_m * np.cos(table["phi"]), x_m * np.sin(table["phi"])
    return Scan(
        path=path, x_m=x_m, y_m=y_m, amplitude_m=amplitude, lines=np.array(lines), missing=missing
    )


def _rows(path: Path) -> list[tuple[int, list[str]]]:
    """Each row's line in the file with its cells; blank lines and comments are left out."""
    try:
        with path.open(newline="", encoding="utf-8-sig") as handle:
            reader = csv.reader(handle, strict=True)
            rows = [(reader.line_num, [cell.strip() for cell in cells]) for cells in reader]
    except FileNotFoundError:
        raise InputError(f"{path}: there is no such scan") from None
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise InputError(f"{path}: the scan cannot be read: {error}") from None
    rows = [(line, cells) for line, cells in rows if any(cells) and not cells[0].startswith("#")]
    if not rows:
        raise InputError(f"{path}: the scan is empty; it needs {FORM}")
    return rows


def _columns(header: list[str], *, path: Path) -> dict[str, float]:
    """The quantities in the order of the columns, each with the size of its unit in SI."""
    scale: dict[str, float] = {}
    for name in header:
        match = COLUMN.fullmatch(name)
        quantity, unit = (match["quantity"], match["unit"] or "") if match else ("", "")
        if quantity not in UNITS:
            raise InputError(f"{path}: line 1: unknown column {name!r}; a scan has {FORM}")
        if unit not in UNITS[quantity]:
            units = ", ".join(f"{quantity}_{unit}" for unit in UNITS[quantity] if unit)
            raise InputError(
                f"{path}: line 1: column {name!r} needs a unit, one of {units or quantity}"
            )
        if quantity in scale:
            raise InputError(f"{path}: line 1: the column {quantity!r} stands twice")
        scale[quantity] = UNITS[quantity][unit]
    place = set(scale) & {"x", "y", "r", "phi"}
    if place not in PLACES:
        raise InputError(
            f"{path}: line 1: the place of a point is x and y, or r, or r and phi; "
            f"the columns are {', '.join(header)}"
        )
    if "amplitude" not in scale:
        raise InputError(f"{path}: line 1: column 'amplitude_um' is missing; a scan has {FORM}")
    if {"sign", "phase"} <= set(scale):
        raise InputError(f"{path}: line 1: give sign or phase, not both")
    return scale


def _number(text: str, *, path: Path, line: int, name: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if "_" in text or not math.isfinite(value) or abs(value) > 1e9:
        raise InputError(f"{path}: line {line}: {name} is {text!r}, not a finite number")
    return value


def _check_values(table: Mapping[str, np.ndarray], *, path: Path, lines: list[int]) -> None:
    """Refuse a radius below zero, a sign that is none, an amplitude below zero with a phase."""
    wrong = {
        "r must not be negative": "r" in table and table["r"] < 0,
        "sign must be 1 or -1": "sign" in table and np.abs(table["sign"]) != 1,
        "amplitude must not be negative where phase or sign tells its direction": (
            ("phase" in table or "sign" in table) and table["amplitude"] < 0
        ),
    }
    for message, rows in wrong.items():
        if np.any(rows):
            raise InputError(f"{path}: line {lines[int(np.argmax(rows))]}: {message}")
    if not np.any(table["amplitude"]):
        raise InputError(f"{path}: every amplitude is zero: there is no profile")


def _in_one_phase(scan: Scan) -> tuple[np.ndarray, float]:
    """The amplitude along the phase of most of the motion, and the rms share across it.

    The phase that holds most is half that of Σ u² (the ellipse's major axis).
    """
    phase = np.angle(np.sum(scan.amplitude_m**2)) / 2
    turned = scan.amplitude_m * np.exp(-1j * phase)
    share = math.sqrt(float(np.mean(turned.imag**2) / np.mean(np.abs(turned) ** 2)))
    if share > LARGEST_QUADRATURE:
        raise InputError(
            f"{scan.path}: {share:.0%} of the motion is out of phase with the rest: a travelling "
            "wave, or phases that are noise; the film equation here takes standing vibrations"
        )
    return turned.real, share


@dataclass(frozen=True)
class _Fit:
    """Least squares on the modes up to one degree."""

    degree: int
    orders: tuple[tuple[int, int], ...]
    coefficients: np.ndarray
    residual: np.ndarray
    root: np.ndarray
    scores: dict[int, float]


def _best_fit(
    scan: Scan, x: np.ndarray, y: np.ndarray, measured: np.ndarray, axisymmetric: bool
) -> _Fit:
    """Least squares up to the degree of least leave-one-out error.

    The error at a left-out point is e/(1 − h), h its leverage, without fitting again (Allen's
    PRESS).
    """
    step = 2 if axisymmetric else 1
    fits: dict[int, _Fit] = {}
    scores: dict[int, float] = {}
    for degree in range(0, LARGEST_DEGREE + 1, step):
        orders = orders_up_to(degree, axisymmetric=axisymmetric)
        if POINTS_PER_MODE * len(orders) > len(measured) and degree > 0:
            break
        basis = modes_at(orders, x=x, y=y)
        orthogonal, triangle = np.linalg.qr(basis)
        if np.linalg.cond(triangle) > 1e8:
            break
        coefficients = np.linalg.solve(triangle, orthogonal.T @ measured)
        residual = measured - basis @ coefficients
        leverage = np.sum(orthogonal**2, axis=1)
        if leverage.max() > 1 - 1e-6:
            break
        scores[degree] = float(np.sqrt(np.mean((residual / (1 - leverage)) ** 2)))
        root = np.linalg.inv(triangle)
        fits[degree] = _Fit(degree, orders, coefficients, residual, root, scores)
    if not fits:
        raise InputError(f"{scan.path}: the points do not determine a profile")
    best = min(scores.values())
    return fits[min(degree for degree, score in scores.items() if score <= AS_GOOD * best)]


def _normalised(
    coefficients: np.ndarray, orders: tuple[tuple[int, int], ...], radius_m: float
) -> tuple[Modes, float]:
    """The profile with largest magnitude 1, and that magnitude."""
    raw = Modes(orders=orders, coefficients=tuple(coefficients), surface_radius_m=radius_m)
    peak = largest_magnitude(lambda x_m, y_m: raw.amplitude(x_m=x_m, y_m=y_m), radius_m=radius_m)
    return Modes(orders, tuple(float(c) for c in coefficients / peak), radius_m), peak


def _refuse_unknown(smoothed: SmoothedScan, *, axisymmetric: bool) -> None:
    """Refuse a profile that the scan leaves open somewhere on the disc."""
    from scipy.spatial import cKDTree

    path, disc_m = smoothed.scan.path, smoothed.profile.surface_radius_m
    radius_m, angle = np.meshgrid(
        np.linspace(0, disc_m, 41), np.linspace(0, 2 * np.pi, 72, endpoint=False), indexing="ij"
    )
    x_m, y_m = radius_m * np.cos(angle), radius_m * np.sin(angle)
    if axisymmetric:  # a point stands for the circle through it
        measured, places = np.hypot(smoothed.x_m, smoothed.y_m)[:, None], radius_m[..., None]
    else:
        measured = np.column_stack([smoothed.x_m, smoothed.y_m])
        places = np.stack([x_m, y_m], axis=-1)
    distance, _ = cKDTree(measured).query(places)
    error = smoothed.standard_error(x_m=x_m, y_m=y_m)
    hole = np.unravel_index(np.argmax(distance), distance.shape)
    worst = np.unravel_index(np.argmax(error), error.shape)
    if distance[hole] > LARGEST_HOLE * disc_m:
        where = f"r = {radius_m[hole] * 1e3:.2f} mm"
        if not axisymmetric:
            where = f"x = {x_m[hole] * 1e3:.2f} mm, y = {y_m[hole] * 1e3:.2f} mm"
        raise InputError(
            f"{path}: no point was measured within {distance[hole] * 1e3:.1f} mm of {where}; the "
            "scan needs points there, or actuator.surface_radius_m is too large"
        )
    if error[worst] > LARGEST_ERROR:
        raise InputError(
            f"{path}: the profile is known to ±{error[worst]:.0%} of its maximum only at "
            f"x = {x_m[worst] * 1e3:.2f} mm, y = {y_m[worst] * 1e3:.2f} mm; the scan needs more "
            "points there, or less noise"
        )
