"""The profile under a finger as far as it decides on symmetry and grid, measured before solving.

As Chebfun does (Battles and Trefethen 2004): the profile is sampled on finer and finer Chebyshev
grids until the interpolant through them is right at points that stand in no relation to any grid;
the decay of its Chebyshev coefficients then says how many nodes each direction needs.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from squeezefilm.film.outline import Outline
from squeezefilm.film.profiles import landmarks_of
from squeezefilm.film.scene import AtPlace, Scene
from squeezefilm.reynolds.grid import MOST_SPACE
from squeezefilm.reynolds.outlines.around import Around, around
from squeezefilm.reynolds.spectral import Axis, axis, period

# Values of a profile that should agree by symmetry agree to rounding, relative to its largest.
SYMMETRIC = 1e-13
PROBES = (24, 48, 96, 192, MOST_SPACE)
# Points at which the first interpolant is judged, and the others, which are tried where it fails.
FEW, MANY = 100, 1000


@dataclass(frozen=True, eq=False)
class Probe:
    """What one Chebyshev grid sees of a profile; shares are of its largest value under the finger.

    Attributes:
        missed: largest difference of interpolant and profile at the points that are no nodes.
        worst: where, in [0, 1] across the finger.
        curvature_x, curvature_y: largest |∂²s/∂X²|, |∂²s/∂Y²| of the interpolant, lengths in units
            of the finger's sides.
        tail_x, tail_y: entry k: what an interpolant with k nodes along x, y misses of this one.
    """

    missed: float
    worst: tuple[float, float]
    curvature_x: float
    curvature_y: float
    tail_x: np.ndarray
    tail_y: np.ndarray

    @lru_cache(maxsize=1024)  # noqa: B019 - probes are kept by place anyway
    def nodes(self, share: float) -> tuple[int, int]:
        """Nodes along x and y that miss no more than a share."""
        return int(np.argmax(self.tail_x <= share)), int(np.argmax(self.tail_y <= share))


class UnderFinger:
    """A profile at one place of a finger, looked at as closely as is asked.

    Attributes:
        finger: the finger.
        even_x, even_y: whether all of it is even about the finger's middle along x, y.
        uniform: the whole finger sees the full amplitude.
    """

    def __init__(self, scene: Scene) -> None:
        self._scene = scene
        self.finger = scene.finger
        self._landmarks = _landmarks_under(scene)
        parts, between, first = _probed(scene, PROBES[0], self._landmarks)
        self._probes = [first]
        self._largest = max(float(np.abs(parts).max()), float(np.abs(between).max()))
        same = SYMMETRIC * self._largest
        self.even_x = self.even_y = True
        if scene.finger.smooth_outline is None:
            self.even_x = bool(np.abs(parts[:, ::-1] - parts).max() <= same)
            self.even_y = bool(np.abs(parts[:, :, ::-1] - parts).max() <= same)
        # Else what the nodes say holds between them.
        if first.missed > SYMMETRIC or scene.finger.smooth_outline:
            self.even_x = self.even_x and self._mirrored(along_x=True) <= same
            self.even_y = self.even_y and self._mirrored(along_x=False) <= same
        still = max(np.abs(parts - 1).max(), np.abs(between - 1).max()) < SYMMETRIC
        self.uniform = bool(still) and not scene.actuator.profile.is_complex

    def probe(self, share: float) -> Probe:
        """The first that misses no more than a share, else the finest that there is."""
        for probe in self._probes:
            if probe.missed <= share:
                return probe
        for points in PROBES[len(self._probes) :]:
            *_, probe = _probed(self._scene, points, self._landmarks)
            self._probes.append(probe)
            if probe.missed <= share:
                break
        return self._probes[-1]

    @property
    def feature_m(self) -> float:
        """Width of what the coarsest probe misses most, at half of its height."""
        scene, (x, y) = self._scene, self._probes[0].worst
        angle = np.pi / 4 * np.arange(8)
        way_m = scene.finger.length_x_m * np.geomspace(1e-6, 1, 300)
        values = scene.parts(
            x + np.outer(way_m, np.cos(angle)) / scene.finger.length_x_m,
            y + np.outer(way_m, np.sin(angle)) / scene.finger.length_y_m,
        )
        here = scene.parts(np.array(x), np.array(y))[:, None, None]
        changed = np.abs(values - here).max(axis=0)
        far = (changed >= self._probes[0].missed * self._largest / 2).any(axis=1)
        return float(2 * way_m[np.argmax(far) if far.any() else -1])

    def _mirrored(self, *, along_x: bool) -> float:
        """Largest difference to the mirror image, between the nodes."""
        prober = _prober(PROBES[1], self._scene.finger.smooth_outline)
        x, y = prober.x, prober.y
        mirrored = (1 - x, y) if along_x else (x, 1 - y)
        return float(np.abs(self._scene.parts(*mirrored) - self._scene.parts(x, y)).max())


def under_finger(scene: Scene) -> UnderFinger:
    """The profile under a scene's finger; one for all scenes at one place."""
    return _at_place(scene.at)


@lru_cache(maxsize=4096)
def _at_place(place: AtPlace) -> UnderFinger:
    return UnderFinger(place.scene)


def _probed(
    scene: Scene, points: int, landmarks: tuple[np.ndarray, np.ndarray]
) -> tuple[np.ndarray, np.ndarray, Probe]:
    """The profile on a grid's nodes, ends included, and between them, and what they say.

    A profile in two phases has two parts, and needs what the worse of them needs.
    """
    outline = scene.finger.smooth_outline
    prober = _prober(points, outline)
    x, y, to_x, to_y = prober.x, prober.y, prober.to_x, prober.to_y
    if len(landmarks[0]):
        u, v = landmarks
        if outline:
            u, v = outline.coordinates(u, v)
            landmarks = outline.positions(u, v)
        x, y = np.append(x, landmarks[0]), np.append(y, landmarks[1])
        along = _axes(points, outline)
        to_x, to_y = (
            np.vstack([to_x, along[0].to_points(u)]),
            np.vstack([to_y, along[1].to_points(v)]),
        )
    everywhere = scene.parts(np.append(prober.grid_x, x), np.append(prober.grid_y, y))
    s = everywhere[:, : prober.grid_x.size].reshape(-1, points + 2, points + 2)
    between = everywhere[:, prober.grid_x.size :]
    largest = float(np.abs(everywhere).max()) or 1.0
    missed = np.abs(((to_x @ s) * to_y).sum(axis=2) - between).max(axis=0) / largest
    worst = int(np.argmax(missed))
    coefficients = np.abs(prober.to_coefficients @ s @ prober.to_coefficients_y.T).max(axis=0)
    coefficients /= largest
    return (
        s,
        between,
        Probe(
            missed=float(missed[worst]),
            worst=(float(x[worst]), float(y[worst])),
            curvature_x=float(np.abs(prober.twice @ s).max()),
            curvature_y=float(np.abs(s @ prober.twice_y.T).max()),
            tail_x=_tail(coefficients.sum(axis=1)),
            tail_y=_tail(coefficients.sum(axis=0)),
        ),
    )


def _between(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Points in [0, 1]² that no two mirror each other: Roberts' sequence of the plastic number."""
    index = np.arange(1, 1 + count)
    plastic = 1.32471795724474602596
    return (0.5 + index / plastic) % 1, (0.5 + index / plastic**2) % 1


def _tail(coefficients: np.ndarray) -> np.ndarray:
    """Sums of coefficients from the k-th on, for k up to all of them, where it is zero."""
    return np.append(np.cumsum(coefficients[::-1])[::-1], 0.0)


@dataclass(frozen=True, eq=False)
class _Prober:
    """What a probe of so many points has of its own, whatever the profile.

    Attributes:
        grid_x, grid_y: its nodes; x, y: points between them, in no relation to any grid.
        to_x, to_y: interpolation from the nodes along x, y to those points.
        to_coefficients, to_coefficients_y: along x, y Chebyshev coefficients from values at the
            nodes; of coordinates around, Fourier's, by rising harmonic.
        twice, twice_y: second derivatives on the nodes.
    """

    grid_x: np.ndarray
    grid_y: np.ndarray
    x: np.ndarray
    y: np.ndarray
    to_x: np.ndarray
    to_y: np.ndarray
    to_coefficients: np.ndarray
    to_coefficients_y: np.ndarray
    twice: np.ndarray
    twice_y: np.ndarray


def _axes(points: int, outline: Outline | None) -> tuple[Axis, Axis | Around]:
    """Those along which a profile is probed: under an outline its own coordinates."""
    return axis(points, False), around(points + 2, False, False) if outline else axis(points, False)


@lru_cache(maxsize=8 * len(PROBES))
def _prober(points: int, outline: Outline | None) -> _Prober:
    line, across = _axes(points, outline)
    nodes, order = line.all_nodes, points + 1
    u, v = _between(FEW if points == PROBES[0] else MANY)
    ends = np.ones(order + 1)
    ends[[0, -1]] = 0.5
    cosines = np.cos(np.pi * np.outer(np.arange(order + 1), np.arange(order + 1)) / order)
    to_coefficients = to_coefficients_y = 2 / order * ends[:, None] * cosines * ends
    at_nodes = grid_x, grid_y = np.meshgrid(nodes, across.all_nodes, indexing="ij")
    x, y = u, v
    if outline:
        v = 2 * np.pi * v
        (grid_x, grid_y), (x, y) = outline.positions(*at_nodes), outline.positions(u, v)
        turns = period(points + 2)
        rising = np.argsort(turns.harmonics, kind="stable")
        to_coefficients_y = turns.fourier[rising] * np.sqrt(2 / (points + 2))
    return _Prober(
        grid_x=grid_x.ravel(),
        grid_y=grid_y.ravel(),
        x=x,
        y=y,
        to_x=line.to_points(u),
        to_y=across.to_points(v),
        to_coefficients=to_coefficients,
        to_coefficients_y=to_coefficients_y,
        twice=line.derivative @ line.derivative,
        twice_y=across.derivative @ across.derivative,
    )


def _landmarks_under(scene: Scene) -> tuple[np.ndarray, np.ndarray]:
    """The profile's landmarks under the finger, in [0, 1] across it."""
    x_m, y_m = landmarks_of(scene.actuator.profile)
    along_x, along_y = scene.finger.turned_back(x_m - scene.x_m, y_m - scene.y_m)
    x, y = 0.5 + along_x / scene.finger.length_x_m, 0.5 + along_y / scene.finger.length_y_m
    inside = (x > 0) & (x < 1) & (y > 0) & (y < 1)
    if scene.finger.smooth_outline:
        inside &= scene.finger.within(x, y)
    return x[inside], y[inside]
