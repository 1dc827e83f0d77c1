"""Smooth outlines of pads in conformal coordinates, in which the film equation keeps its form.

The inside of an outline is the image of the strip |μ| ≤ edge, ν around, under

    x + iy = Σ_n a_n cosh n(μ + iν),

each point twice, at (μ, ν) and (−μ, −ν): cosh nζ is Chebyshev's polynomial of cosh ζ. One
coefficient is an ellipse in elliptic coordinates. The map is analytic, so that
Δ = (∂²/∂μ² + ∂²/∂ν²) / |dz/dζ|².
"""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass
from functools import cached_property, lru_cache
from math import atanh, log, pi, sqrt
from pathlib import Path

import numpy as np
from numpy.polynomial.chebyshev import chebder, chebval

from squeezefilm.errors import InputError, prefix_errors

# Sides of the ellipse on which a map is based: nearer to a disc the foci fall together, and the map
# of the disc itself would need no ν at the centre. With 1.05 16 nodes across reach what takes 19
# here; but the area varies more around, and a disc off centre takes 1.6 times as many iterations,
# with inertia twice as many.
MIN_MAP_ASPECT = 1.01
# Points around by which a map is found, and how well it meets the outline, relative to its size.
MAP_POINT_COUNT = 256
MAP_TOLERANCE = 1e-12
# The same for outlines that are known less well.
CURVE_MAP_POINT_COUNT = 512
CURVE_MAP_TOLERANCE = 1e-8
MAX_MAP_ITERATIONS = 30
TOO_SHARP_MESSAGE = (
    "a notch, a neck or a corner is too sharp for its coordinates; smooth the outline, or take the "
    "ellipse that it is most like"
)
# Points by which an outline is drawn.
OUTLINE_SAMPLE_COUNT = 1024


@dataclass(frozen=True, eq=False)
class Outline:
    """A pad's outline; lengths are in units of the pad's length along x, from its centre.

    Attributes:
        coefficients: a_n, n = 0, 1, …, complex.
        edge_mu: μ on the outline.
        aspect: length along y.
        turned: the longer side lies along y: ν = 0 is at the end of the y axis.
        even_x, even_y: whether the outline is even about its middle along x, y.
        map_error: what the truncated coefficients are, over the outline's size.
        point_scatter: how far the points of its file lie off it.
    """

    coefficients: np.ndarray
    edge_mu: float
    aspect: float
    turned: bool = False
    even_x: bool = False
    even_y: bool = False
    map_error: float = MAP_TOLERANCE
    point_scatter: float = 0.0

    @cached_property
    def points(self) -> np.ndarray:
        """Points x + iy all along it, shape (OUTLINE_SAMPLE_COUNT,)."""
        return self.point_at(
            np.array(self.edge_mu), 2 * pi * np.arange(OUTLINE_SAMPLE_COUNT) / OUTLINE_SAMPLE_COUNT
        )

    def contains_positions(self, z: np.ndarray) -> np.ndarray:
        """Return whether positions x + iy, shape (N,), lie within the outline."""
        inside = []
        for batch in np.array_split(z, max(1, len(z) // 500)):
            ways = self.points[None] - batch[:, None]
            turn = np.angle(np.roll(ways, -1, axis=1) * ways.conj())
            inside.append(np.abs(turn.sum(axis=1)) > np.pi)
        return np.concatenate(inside)

    @cached_property
    def area(self) -> float:
        n = np.arange(len(self.coefficients))
        return float(pi / 2 * (n * np.abs(self.coefficients) ** 2) @ np.sinh(2 * n * self.edge_mu))

    def symmetries_in_nu(self, fold_x: bool, fold_y: bool) -> tuple[bool, bool]:
        """Return whether a film that is even along x, y is so at ν, −ν, and at ν, π − ν."""
        return (fold_x, fold_y) if self.turned else (fold_y, fold_x)

    def side_fractions(self, across: np.ndarray, nu: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Places in [0, 1] across the pad's sides, for μ from −edge to edge in [0, 1] and ν."""
        z = self.point_at(self.edge_mu * (2 * across - 1), nu)
        return 0.5 + z.real, 0.5 + z.imag / self.aspect

    def point_at(self, mu: np.ndarray, nu: np.ndarray) -> np.ndarray:
        """x + iy of coordinates of a common shape."""
        return np.asarray(chebval(np.cosh(mu + 1j * np.asarray(nu)), self.coefficients))

    def conformal_map_slope(self, mu: np.ndarray, nu: np.ndarray) -> np.ndarray:
        """d(x + iy)/d(μ + iν)."""
        zeta = mu + 1j * np.asarray(nu)
        return np.asarray(np.sinh(zeta) * chebval(np.cosh(zeta), chebder(self.coefficients)))

    def conformal_map_log_slope(self, mu: np.ndarray, nu: np.ndarray) -> np.ndarray:
        """z″/z′, with z = x + iy as a function of μ + iν."""
        zeta = mu + 1j * np.asarray(nu)
        c, first = np.cosh(zeta), chebder(self.coefficients)
        more = np.sinh(zeta) * chebval(c, chebder(first)) / chebval(c, first)
        return np.asarray(1 / np.tanh(zeta) + more)

    def map_jacobian(self, mu: np.ndarray, nu: np.ndarray) -> np.ndarray:
        """Jacobian J = |d(x + iy)/d(μ + iν)|², the pad's area per area of (μ, ν)."""
        return np.asarray(np.abs(self.conformal_map_slope(mu, nu)) ** 2)

    @cached_property
    def mean_map_jacobian(self) -> float:
        """Mean of the Jacobian J over the strip that maps to the pad."""
        return self.area / (2 * pi * self.edge_mu)

    @cached_property
    def jacobian_varies_more_with_nu(self) -> bool:
        """Return whether the Jacobian J varies more with ν than with μ."""
        mu, nu = np.meshgrid(np.linspace(0, self.edge_mu, 33), np.linspace(0, 2 * pi, 128)[:-1])
        area = self.map_jacobian(mu, nu)
        return bool(np.var(area.mean(axis=1)) > np.var(area.mean(axis=0)))

    @cached_property
    def analyticity_width(self) -> float:
        """Approximate half-width |Im ν| of the strip around real ν in which J has no zero."""
        waves = len(self.coefficients) - 1
        return min(self.edge_mu, -log(self.map_error) / waves) if waves > 1 else self.edge_mu

    @cached_property
    def mean_edge_jacobian(self) -> float:
        """Mean of the Jacobian J on the outline, where the film has its boundary layers."""
        return float(np.mean(self.edge_jacobian_range))

    @cached_property
    def edge_jacobian_range(self) -> tuple[float, float]:
        """Smallest and largest Jacobian J on the outline."""
        around = self.map_jacobian(
            np.array(self.edge_mu), np.linspace(0, 2 * pi, 4 * MAP_POINT_COUNT)
        )
        return float(around.min()), float(around.max())

    def coordinates(self, x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the coordinates of places inside, shape (N,), by Newton's method."""
        x, y = x - 0.5, (y - 0.5) * self.aspect
        mu, nu = np.meshgrid(np.linspace(0, self.edge_mu, 33), np.linspace(0, 2 * pi, 128))
        zeta = (mu + 1j * nu).ravel()
        z = x + 1j * y
        nearest = np.abs(self.point_at(zeta.real, zeta.imag)[None] - z[:, None]).argmin(axis=1)
        zeta_found = zeta[nearest]
        for _ in range(8):
            slope = self.conformal_map_slope(zeta_found.real, zeta_found.imag)
            step = (self.point_at(zeta_found.real, zeta_found.imag) - z) / np.where(
                slope == 0, 1, slope
            )
            zeta_found = zeta_found - step * np.minimum(1, 0.1 / np.maximum(np.abs(step), 1e-300))
        return (1 + np.clip(zeta_found.real / self.edge_mu, -1, 1)) / 2, zeta_found.imag


class DiscCoordinates:
    """Coordinates of a disc: places in [0, 1] across a diameter and its angle.

    Each point lies at two of them, as of an outline's.
    """

    def side_fractions(
        self, across: np.ndarray, angle: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Places in [0, 1] across the pad's sides."""
        return 0.5 + (across - 0.5) * np.cos(angle), 0.5 + (across - 0.5) * np.sin(angle)

    def coordinates(self, x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the coordinates of places inside, shape (N,)."""
        return 0.5 + np.hypot(x - 0.5, y - 0.5), np.arctan2(y - 0.5, x - 0.5)


DISC_COORDINATES = DiscCoordinates()


@lru_cache(maxsize=256)
def ellipse_outline(aspect: float) -> Outline:
    """An ellipse of axes 1 along x and ``aspect`` along y."""
    longer, shorter = max(1.0, aspect) / 2, min(1.0, aspect) / 2
    turn = 1j if aspect > 1 else 1.0
    if longer >= MIN_MAP_ASPECT * shorter:
        coefficients = np.array([0, turn * sqrt(longer**2 - shorter**2)])
        edge_mu = atanh(shorter / longer)
    else:
        edge_mu = atanh(1 / MIN_MAP_ASPECT)
        waves = np.array([longer - shorter, 0, longer + shorter]) / 2
        coefficients = turn * conformal_map_coefficients(waves, edge_mu).real
        coefficients[::2] = 0  # of both symmetries
    return Outline(coefficients, edge_mu, aspect, aspect > 1, even_x=True, even_y=True)


def conformal_map_coefficients(
    curve: np.ndarray,
    edge_mu: float,
    *,
    points: int = MAP_POINT_COUNT,
    exact: float = MAP_TOLERANCE,
    first_guess: Callable[[np.ndarray], np.ndarray] = np.copy,
) -> np.ndarray:
    """The coefficients a_n by which the strip up to ``edge_mu`` is mapped inside a closed curve.

    Newton's method for the curve's parameter over ν: on the edge the Fourier coefficients of
    x + iy obey Z_(−n) = exp(−2 n edge) Z_n.

    Args:
        curve: waves of x + iy, against the clock (``_curve_and_slope``).
        points: around, by which it is found.
        exact: how well it meets the curve, relative to its size.
        first_guess: of the curve's parameter at ν.

    Raises:
        InputError: if the map does not meet the curve.
    """
    half = points // 2
    nu = 2 * pi * np.arange(points) / points
    n = np.arange(1, half)
    decay = np.exp(-2 * n * edge_mu)
    waves = np.exp(-1j * np.outer(n, nu)) / points
    angle = first_guess(nu)
    for _ in range(MAX_MAP_ITERATIONS):
        z, slope = _curve_and_slope(curve, angle)
        spectrum = np.fft.fft(z) / points
        off = spectrum[:half:-1] - decay * spectrum[1:half]
        size = float(np.abs(z - z.mean()).max())
        if np.abs(off).max() <= exact * size:
            break
        jacobian = (waves.conj() - decay[:, None] * waves) * slope
        rows = np.vstack([jacobian.real, jacobian.imag])
        step = np.linalg.lstsq(rows, -np.concatenate([off.real, off.imag]), rcond=1e-10)[0]
        angle = angle + step * min(1.0, 0.3 / float(np.abs(step).max()))
    else:
        raise InputError(f"no conformal map of the outline was found: {TOO_SHARP_MESSAGE}")
    coefficients = spectrum[:half] * np.append(1, 2 * np.exp(-n * edge_mu))
    kept = np.abs(coefficients[1:]) * np.cosh(np.minimum(n * edge_mu, 700)) > exact * size
    last = int(np.flatnonzero(kept).max(initial=0)) + 2
    if last >= half - 2:
        raise InputError(
            f"the conformal map of the outline has too many waves: {TOO_SHARP_MESSAGE}"
        )
    return coefficients[:last]


CONTOUR_FORMAT_TEXT = (
    "a header x_mm,y_mm (or another unit) and a point of the edge in each row, one after the other"
)
MIN_CONTOUR_POINTS, MAX_CONTOUR_POINTS = 16, 4000
# Waves around the edge, the shortest that a smooth curve through the points may have.
MAX_CURVE_WAVES = 40
# How far points may lie off that curve where nothing else is said, over the longer side; and how
# near it comes, if it can.
DEFAULT_POINT_SCATTER, TARGET_CURVE_DISTANCE = 1e-4, 1e-5
# The way from the last point to the first, over the longest between others, that is no gap.
MAX_CLOSING_GAP_RATIO = 4.0
# How well the sides that a study says must be the curve's, relative.
SIDES_TOLERANCE = 1e-4


def read_contour(path: Path, *, sides_m: tuple[float, float], scatter_m: float = 0.0) -> Outline:
    """The smooth curve through the points of a file; it is read once, unless it changes.

    Args:
        path: of a table of points.
        sides_m: its extents along x and y, which must be those that are meant.
        scatter_m: how far points may lie off it; 0 stands for DEFAULT_POINT_SCATTER times the
            longer side.

    Raises:
        InputError: naming file and line where the points make no outline, or sides are others.
    """
    if not path.is_file():
        raise InputError(f"{path}: there is no such outline")
    return _cached_contour_outline(path, path.stat().st_mtime_ns, sides_m, scatter_m)


@lru_cache(maxsize=16)
def _cached_contour_outline(
    path: Path, _changed: int, sides_m: tuple[float, float], scatter_m: float
) -> Outline:
    with prefix_errors(path):
        waves, off_m = _fitted_curve(_contour_points(path), scatter_m=scatter_m)
        return _outline_of_curve(_scale_curve_to_sides(waves, off_m, sides_m), sides_m, off_m)


def _missing_coordinate_problems(known: Collection[str]) -> dict[str, bool]:
    """Problems of an outline with some quantities."""
    return {
        f"there is no column x or y; an outline is {CONTOUR_FORMAT_TEXT}": {*known} != {"x", "y"}
    }


def _contour_points(path: Path) -> np.ndarray:
    """Points x + iy in metres, against the clock, checked."""
    from squeezefilm.film.measured.table import read_point_table  # as long as a small film

    table, _, _ = read_point_table(
        path,
        ("x", "y"),
        what="outline",
        form=CONTOUR_FORMAT_TEXT,
        complete=_missing_coordinate_problems,
    )
    z = (table["x"] + 1j * table["y"]).to_numpy()
    if len(z) > 1 and z[0] == z[-1]:  # the first again closes it
        z = z[:-1]
    if not MIN_CONTOUR_POINTS <= len(z) <= MAX_CONTOUR_POINTS:
        raise InputError(
            f"{len(z)} points; an outline has {MIN_CONTOUR_POINTS} to {MAX_CONTOUR_POINTS}"
        )
    steps = np.abs(np.roll(z, -1) - z)
    if steps[-1] > MAX_CLOSING_GAP_RATIO * steps[:-1].max():
        raise InputError(
            f"the outline is not closed: its last point is {steps[-1] * 1e3:.3g} mm from the "
            "first, and no others that follow each other are more than "
            f"{steps[:-1].max() * 1e3:.3g} mm apart"
        )
    return z if _twice_triangle_areas(z).sum() > 0 else z[::-1]


def _twice_triangle_areas(contour: np.ndarray) -> np.ndarray:
    """Twice the areas of the triangles (origin, point k, point k + 1) of a closed contour."""
    return np.asarray((contour.conj() * np.roll(contour, -1)).imag)


def _fitted_curve(points: np.ndarray, *, scatter_m: float) -> tuple[np.ndarray, float]:
    """Fit a closed Fourier curve with as few waves as the points' scatter allows.

    Returns the coefficients and the largest distance of a point from the curve.

    Its parameter goes with the way along the points.
    """
    steps = np.abs(np.roll(points, -1) - points)
    parameter = 2 * np.pi * np.append(0, np.cumsum(steps[:-1])) / steps.sum()
    longer = max(float(np.ptp(points.real)), float(np.ptp(points.imag)))
    allowed = scatter_m or DEFAULT_POINT_SCATTER * longer
    most = min(MAX_CURVE_WAVES, len(points) // 3)
    for waves in range(1, most + 1):
        terms = np.exp(1j * np.multiply.outer(parameter, np.arange(-waves, waves + 1)))
        fit = np.linalg.lstsq(terms, points, rcond=None)[0]
        off = float(np.abs(terms @ fit - points).max())
        if off <= (scatter_m or TARGET_CURVE_DISTANCE * longer):
            break
    if off <= allowed:
        return fit, off
    raise InputError(
        f"points of the outline lie up to {off * 1e6:.3g} µm off the smooth curve of {most} waves "
        f"through them, and {allowed * 1e6:.3g} µm are allowed: write pad.outline.scatter if "
        "they are known no better, give more points, or round corners off"
    )


def _curve_and_slope(waves: np.ndarray, parameter: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """x + iy = Σ_k waves_k exp(i k parameter), k = −n … n, on a closed curve; its derivative."""
    k = np.arange(len(waves)) - len(waves) // 2
    terms = np.exp(1j * np.multiply.outer(parameter, k))
    return terms @ waves, terms @ (1j * k * waves)


def _scale_curve_to_sides(
    waves: np.ndarray, off_m: float, sides_m: tuple[float, float]
) -> np.ndarray:
    """Return the curve over the pad's length along x, centred, with the sides of the study."""
    contour, _ = _curve_and_slope(
        waves, 2 * np.pi * np.arange(4 * OUTLINE_SAMPLE_COUNT) / (4 * OUTLINE_SAMPLE_COUNT)
    )
    extents = np.array([np.ptp(contour.real), np.ptp(contour.imag)])
    if np.any(np.abs(extents - sides_m) > SIDES_TOLERANCE * extents + 2 * off_m):
        x, y, study_x, study_y = (f"{1e3 * side:.6g} mm" for side in (*extents, *sides_m))
        raise InputError(
            f"the outline is {x} × {y}, and the study says {study_x} × {study_y}: write "
            f"pad.length_x: {x}, pad.length_y: {y}"
        )
    waves = waves.copy()
    waves[len(waves) // 2] -= (
        complex(*(f.max() + f.min() for f in (contour.real, contour.imag))) / 2
    )
    # The sides are rounded to the digits of the study; both are the same pad after this.
    mirrored, aspect = waves[::-1].conj(), sides_m[1] / sides_m[0]
    along_x, along_y = (waves + mirrored) / 2 / extents[0], (waves - mirrored) / 2 / extents[1]
    return np.asarray(along_x + along_y * aspect)


def _outline_of_curve(curve: np.ndarray, sides_m: tuple[float, float], off_m: float) -> Outline:
    """A curve in conformal coordinates; raises InputError where there are none."""
    parameters = 2 * np.pi * np.arange(OUTLINE_SAMPLE_COUNT + 1) / OUTLINE_SAMPLE_COUNT
    contour, _ = _curve_and_slope(curve, parameters[:-1])
    weights = _twice_triangle_areas(contour)
    from_centre = contour - (weights * (contour + np.roll(contour, -1))).sum() / 3 / weights.sum()
    # Second moments of the inside tell the ellipse that it is most like.
    one, other = from_centre, np.roll(from_centre, -1)
    turning = weights @ (one**2 + one * other + other**2)
    size = weights @ (abs(one) ** 2 + (one * other.conj()).real + abs(other) ** 2)
    elongation = min(abs(turning) / size, 0.9999)
    shape = max(np.sqrt((1 + elongation) / (1 - elongation)), MIN_MAP_ASPECT)
    direction = np.exp(0.5j * np.angle(turning)) if elongation > 1e-9 else 1.0
    angles = np.unwrap(np.angle(from_centre / direction))
    if not (np.all(np.diff(angles) > 0) and angles[-1] - angles[0] <= 2 * np.pi):
        raise InputError(
            "the outline is not star-shaped: seen from its middle it lies behind itself, or it "
            "crosses itself; such pads are not supported, and points must follow each other "
            "around the edge"
        )

    def first_guess(nu: np.ndarray) -> np.ndarray:
        wanted = np.unwrap(np.angle(np.cos(nu) + 1j / shape * np.sin(nu)))
        turns = np.floor((wanted - angles[0]) / (2 * np.pi))
        along = np.append(angles, angles[0] + 2 * np.pi)
        return np.interp(wanted - 2 * np.pi * turns, along, parameters) + 2 * np.pi * turns

    mu = float(np.arctanh(1 / shape))
    coefficients = conformal_map_coefficients(
        curve, mu, points=CURVE_MAP_POINT_COUNT, exact=CURVE_MAP_TOLERANCE, first_guess=first_guess
    )
    aspect, scatter = sides_m[1] / sides_m[0], off_m / sides_m[0]
    return Outline(coefficients, mu, aspect, map_error=CURVE_MAP_TOLERANCE, point_scatter=scatter)
