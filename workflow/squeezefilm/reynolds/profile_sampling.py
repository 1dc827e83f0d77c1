"""A profile under the pad, sampled until an interpolant through the samples sees all of it.

As Chebfun does (Battles and Trefethen 2004): a profile is sampled on finer and finer Chebyshev
grids until the interpolant through them is right at points that stand in no relation to any grid;
the decay of its Chebyshev coefficients then gives how many nodes each direction needs. All of the
pad's positions are sampled at once.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from squeezefilm.film.outline import DiscCoordinates, Outline
from squeezefilm.film.profiles import narrow_feature_points
from squeezefilm.film.scene import PadPositions
from squeezefilm.film.symmetry import ROUNDING_TOLERANCE
from squeezefilm.reynolds.grid import MAX_NODES_ACROSS
from squeezefilm.reynolds.spectral import (
    AngleAxis,
    Axis,
    cached_angle_axis,
    cached_axis,
    cached_time_axis,
)

SAMPLED_NODE_COUNTS = (24, 48, 96, 192, MAX_NODES_ACROSS)
# Points at which the first interpolant is checked, and the others, which are tried where it fails.
FIRST_CHECK_POINT_COUNT, LATER_CHECK_POINT_COUNT = 100, 1000
# Numbers of samples that are worked on at a time: more would fall out of the caches.
SAMPLES_PER_BATCH = 2**17

PadCoordinates = Outline | DiscCoordinates | None


@dataclass(frozen=True, eq=False)
class ProfileResolution:
    """Resolution of profiles by Chebyshev grids, relative to the largest value under the pad.

    Attributes:
        interpolation_error: largest difference of interpolant and profile at points that are no
            nodes, (n,).
        largest_error_position: where, in [0, 1] across the pad: (n, 2).
        curvature: largest |∂²s/∂X²|, |∂²s/∂Y²| of the interpolant, lengths in units of the pad's
            sides: (n, 2).
        tail_sums: what an interpolant with k nodes along x, y misses of this one: (n, 2, most k +
            1).
    """

    interpolation_error: np.ndarray
    largest_error_position: np.ndarray
    curvature: np.ndarray
    tail_sums: np.ndarray

    def __getitem__(self, rows: np.ndarray | slice) -> ProfileResolution:
        return ProfileResolution(*(each[rows] for each in vars(self).values()))

    def needed_nodes(self, fraction: float) -> np.ndarray:
        """Nodes along x and y that miss no more than a share, (n, 2)."""
        return np.argmax(self.tail_sums <= fraction, axis=2)

    def error_with_node_counts(
        self, nodes: tuple[int, int], rows: np.ndarray | slice
    ) -> np.ndarray:
        """Return the errors of interpolants with so many nodes along x, y, (n, 2)."""
        most = self.tail_sums.shape[2] - 1
        return np.array([self.tail_sums[rows, k, min(n + 2, most)] for k, n in enumerate(nodes)]).T


class SampledProfiles:
    """A profile with the pad at some positions, sampled as finely as is asked.

    Attributes:
        coordinates: those in which it is sampled; None of a rectangle.
        even_x, even_y: whether all of it is even about the pad's middle along x, y: (positions,).
    """

    def __init__(self, places: PadPositions, coordinates: PadCoordinates) -> None:
        count = len(places.x_m)
        self.places, self.coordinates = places, coordinates
        self.even_x, self.even_y = np.empty((2, count), dtype=bool)
        self._largest = np.empty(count)
        self._samples: list[ProfileResolution | None] = [None] * len(SAMPLED_NODE_COUNTS)
        self._row = np.full((len(SAMPLED_NODE_COUNTS), count), -1)
        self._at: dict[float, ProfileResolution] = {}
        self._landmarks = _landmarks_under_pad(places)
        self._sample_level(0, np.arange(count))

    def resolution_at(self, fraction: float) -> ProfileResolution:
        """Return samples of the first level whose error is at most a fraction, else the last."""
        if fraction not in self._at:
            rows = np.arange(len(self._largest))
            parts, which = [], []
            for level in range(len(SAMPLED_NODE_COUNTS)):
                self._sample_level(level, rows[self._row[level, rows] < 0])
                samples = self._samples[level]
                assert samples is not None
                found = samples[self._row[level, rows]]
                enough = (found.interpolation_error <= fraction) | (
                    level == len(SAMPLED_NODE_COUNTS) - 1
                )
                parts.append(found[enough])
                which.append(rows[enough])
                rows = rows[~enough]
                if not rows.size:
                    break
            order = np.argsort(np.concatenate(which))
            self._at[fraction] = (
                parts[0] if len(parts) == 1 else join_profile_resolutions(parts)[order]
            )
        return self._at[fraction]

    def narrowest_feature_m(self) -> float:
        """Width in metres, at half height, of the profile's least resolved feature."""
        first, place, pad = self._samples[0], self.places, self.places.pad_profile.pad
        assert first is not None
        x, y = first.largest_error_position[0]
        angle = np.pi / 4 * np.arange(8)
        way_m = pad.length_x_m * np.geomspace(1e-6, 1, 300)
        values = place.component_amplitudes(
            (x + np.outer(way_m, np.cos(angle)) / pad.length_x_m).ravel(),
            (y + np.outer(way_m, np.sin(angle)) / pad.length_y_m).ravel(),
        )
        here = place.component_amplitudes(np.array([x]), np.array([y]))
        changed = np.abs(values - here).max(axis=(0, 1)).reshape(300, 8)
        far = (changed >= first.interpolation_error[0] * self._largest[0] / 2).any(axis=1)
        return float(2 * way_m[np.argmax(far) if far.any() else -1])

    def _sample_level(self, level: int, rows: np.ndarray) -> None:
        """Sample a level at some positions, together as many as fit the caches."""
        if not rows.size:
            return
        sampler = _sampling_matrices(SAMPLED_NODE_COUNTS[level], self.coordinates)
        step = max(1, SAMPLES_PER_BATCH // (sampler.grid_x.size + sampler.x.size))
        alone = np.isin(rows, list(self._landmarks))
        plain = rows[~alone]
        batches = [plain[start : start + step] for start in range(0, len(plain), step)]
        batches += list(rows[alone][:, None])
        known = self._samples[level]
        parts = [known] if known else []
        for some in batches:
            landmarks = self._landmarks.get(int(some[0]))
            samples, s, between = _sample_profiles(self.places.subset(some), sampler, landmarks)
            self._row[level, some] = sum(
                len(each.interpolation_error) for each in parts
            ) + np.arange(len(some))
            parts.append(samples)
            if level == 0:
                self._find_symmetries(some, samples, s, between)
        self._samples[level] = join_profile_resolutions(parts)

    def _find_symmetries(
        self, rows: np.ndarray, first: ProfileResolution, s: np.ndarray, between: np.ndarray
    ) -> None:
        """Find symmetries from the values of the first level, at the nodes and between them."""
        self._largest[rows] = _largest_magnitude(s, between)
        same = ROUNDING_TOLERANCE * self._largest[rows]
        # Else what the nodes show holds between them.
        look_closer = (first.interpolation_error > ROUNDING_TOLERANCE) | (
            self.coordinates is not None
        )
        for even, axis_ in ((self.even_x, 2), (self.even_y, 3)):
            even[rows] = True
            if self.coordinates is None:
                even[rows] = np.abs(np.flip(s, axis_) - s).max(axis=(0, 2, 3)) <= same
            closer = look_closer & even[rows]
            if closer.any():
                some = self.places.subset(rows[closer])
                far = _mirror_difference(some, self.coordinates, along_x=axis_ == 2)
                even[rows[closer]] = far <= same[closer]


def join_profile_resolutions(parts: Sequence[ProfileResolution]) -> ProfileResolution:
    """Concatenate samples; tails are padded with zeros beyond their last node."""
    if len(parts) == 1:
        return parts[0]
    width = max(each.tail_sums.shape[2] for each in parts)
    more = [((0, 0), (0, 0), (0, width - each.tail_sums.shape[2])) for each in parts]
    tails = [np.pad(each.tail_sums, beyond) for each, beyond in zip(parts, more, strict=True)]
    missed, worst, curvature = (
        np.concatenate([getattr(each, name) for each in parts])
        for name in ("interpolation_error", "largest_error_position", "curvature")
    )
    return ProfileResolution(missed, worst, curvature, np.concatenate(tails))


def _largest_magnitude(s: np.ndarray, between: np.ndarray) -> np.ndarray:
    """Largest magnitude on the nodes and between them, (positions,)."""
    return np.maximum(np.abs(s).max(axis=(0, 2, 3)), np.abs(between).max(axis=(0, 2)))


def _mirror_difference(
    places: PadPositions, coordinates: PadCoordinates, *, along_x: bool
) -> np.ndarray:
    """Largest difference to the mirror image, between the nodes, (positions,)."""
    sampler = _sampling_matrices(SAMPLED_NODE_COUNTS[1], coordinates)
    x, y = sampler.x, sampler.y
    mirrored = (1 - x, y) if along_x else (x, 1 - y)
    return np.abs(places.component_amplitudes(*mirrored) - places.component_amplitudes(x, y)).max(
        axis=(0, 2)
    )


def _sample_profiles(
    places: PadPositions,
    sampler: _SamplingMatrices,
    landmarks: tuple[np.ndarray, np.ndarray] | None,
) -> tuple[ProfileResolution, np.ndarray, np.ndarray]:
    """Samples of a profile, its parts on a grid's nodes, ends included, and between them.

    A complex profile has two parts, and needs what the worse of them needs.

    Args:
        landmarks: points in [0, 1] across the pad that are looked at too.
    """
    x, y, to_x, to_y = sampler.x, sampler.y, sampler.to_x, sampler.to_y
    if landmarks:
        u, v = landmarks
        if sampler.coordinates:
            u, v = sampler.coordinates.coordinates(u, v)
            landmarks = sampler.coordinates.side_fractions(u, v)
        x, y = np.append(x, landmarks[0]), np.append(y, landmarks[1])
        to_x = np.vstack([to_x, sampler.line.matrix_to_points(u)])
        to_y = np.vstack([to_y, sampler.across.matrix_to_points(v)])
    everywhere = places.component_amplitudes(
        np.append(sampler.grid_x, x), np.append(sampler.grid_y, y)
    )
    nodes = len(sampler.line.all_nodes), len(sampler.across.all_nodes)
    s = everywhere[..., : sampler.grid_x.size].reshape(*everywhere.shape[:2], *nodes)
    between = everywhere[..., sampler.grid_x.size :]
    largest = np.abs(everywhere).max(axis=(0, 2))
    largest[largest == 0] = 1.0
    with np.errstate(all="ignore"):  # of a profile that has no finite value somewhere
        interpolated = np.einsum("psij,ij->psi", to_x @ s, to_y)
        missed = np.abs(interpolated - between).max(axis=0) / largest[:, None]
        coefficients = np.abs(sampler.to_coefficients @ s @ sampler.to_coefficients_y.T).max(axis=0)
        coefficients /= largest[:, None, None]
        curvature = [
            np.abs(second).max(axis=(0, 2, 3))
            for second in (sampler.twice @ s, s @ sampler.twice_y.T)
        ]
    worst = np.argmax(missed, axis=1)
    tails = [_tail_sums(coefficients.sum(axis=2)), _tail_sums(coefficients.sum(axis=1))]
    samples = ProfileResolution(
        interpolation_error=missed[np.arange(len(worst)), worst],
        largest_error_position=np.stack([x[worst], y[worst]], axis=1),
        curvature=np.stack(curvature, axis=1),
        tail_sums=np.stack(tails, axis=1),
    )
    return samples, s, between


def _points_between_nodes(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Points in [0, 1]² that no two mirror each other: Roberts' sequence of the plastic number."""
    index = np.arange(1, 1 + count)
    plastic = 1.32471795724474602596
    return (0.5 + index / plastic) % 1, (0.5 + index / plastic**2) % 1


def _tail_sums(coefficients: np.ndarray) -> np.ndarray:
    """Sums of coefficients (n, k) from each on, up to all of them, where it is zero: (n, k + 1)."""
    sums = np.cumsum(coefficients[:, ::-1], axis=1)[:, ::-1]
    return np.concatenate([sums, np.zeros((len(sums), 1))], axis=1)


class _SamplingMatrices:
    """Matrices for sampling on a grid of so many points, whatever the profile.

    Attributes:
        coordinates: of an outline, or of a disc; None of a rectangle.
        line, across: the axes along which a profile is sampled, of an outline its coordinates.
        grid_x, grid_y: the nodes; x, y: points between them, in no relation to any grid.
        to_x, to_y: interpolation from the nodes along x, y to those points.
        to_coefficients, to_coefficients_y: along x, y Chebyshev coefficients from values at the
            nodes; of coordinates around, Fourier's, by rising harmonic.
        twice, twice_y: second derivatives on the nodes.
    """

    def __init__(self, points: int, coordinates: PadCoordinates) -> None:
        self.coordinates = coordinates
        self.line = line = cached_axis(points, False)
        across: Axis | AngleAxis = (
            cached_angle_axis(points + 2, False, False) if coordinates else line
        )
        self.across, order = across, points + 1
        u, v = _points_between_nodes(
            FIRST_CHECK_POINT_COUNT if points == SAMPLED_NODE_COUNTS[0] else LATER_CHECK_POINT_COUNT
        )
        ends = np.ones(order + 1)
        ends[[0, -1]] = 0.5
        cosines = np.cos(np.pi * np.outer(np.arange(order + 1), np.arange(order + 1)) / order)
        self.to_coefficients = 2 / order * ends[:, None] * cosines * ends
        self.to_coefficients_y = self.to_coefficients
        nodes = np.meshgrid(line.all_nodes, across.all_nodes, indexing="ij")
        self.grid_x, self.grid_y = (each.ravel() for each in nodes)
        self.x, self.y = u, v
        if coordinates:
            v = 2 * np.pi * v
            self.grid_x, self.grid_y = coordinates.side_fractions(self.grid_x, self.grid_y)
            self.x, self.y = coordinates.side_fractions(u, v)
            turns = cached_time_axis(points + 2)
            rising = np.argsort(turns.harmonic_orders, kind="stable")
            self.to_coefficients_y = turns.fourier_matrix[rising] * np.sqrt(2 / (points + 2))
        self.to_x, self.to_y = line.matrix_to_points(u), across.matrix_to_points(v)
        self.twice = line.derivative_matrix @ line.derivative_matrix
        self.twice_y = across.derivative_matrix @ across.derivative_matrix


_sampling_matrices = lru_cache(maxsize=8 * len(SAMPLED_NODE_COUNTS))(_SamplingMatrices)


def _landmarks_under_pad(places: PadPositions) -> dict[int, tuple[np.ndarray, np.ndarray]]:
    """The profile's landmarks under the pad, in [0, 1] across it, where there are any."""
    x_m, y_m = narrow_feature_points(places.pad_profile.profile)
    if not len(x_m):
        return {}
    pad = places.pad_profile.pad
    turned_back = replace(pad, rotation_deg=-pad.rotation_deg)
    along_x, along_y = turned_back.to_actuator_axes(
        x_m - places.x_m[:, None], y_m - places.y_m[:, None]
    )
    x, y = 0.5 + along_x / pad.length_x_m, 0.5 + along_y / pad.length_y_m
    inside = (x > 0) & (x < 1) & (y > 0) & (y < 1)
    if pad.smooth_outline:
        inside &= pad.contains_positions(x, y)
    some = np.flatnonzero(inside.any(axis=1)).tolist()
    return {row: (x[row, inside[row]], y[row, inside[row]]) for row in some}
