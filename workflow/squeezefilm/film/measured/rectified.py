"""Whether amplitudes without phase or sign are those of a mode with a node line, folded up at it.

|s| has a kink along a node line that smooth modes cannot follow, and s has none. So signs are
sought with which smooth modes describe the points clearly better than without: alternately fitted
and taken from the fit (error reduction; Fienup, Applied Optics 21, 1982, 2758), from many patterns
of nodes. Where no region is found whose sign matters, there is no fold.
"""

from collections.abc import Iterator

import numpy as np

from squeezefilm.film.measured.least_squares import Points, best_fit

FOLDED = (
    "the scan has no phase or sign and looks folded up at a node line: the force is that of "
    "another surface, and no error here contains the difference"
)

SEARCH_DEGREE = 9
ROUNDS = 15
# Squares of residuals, in the noise's variance, are cut here: strays are in both fits.
LARGEST_SQUARE = 25.0
# The signs must save this many squares, and this share of one for each point.
LEAST_SAVING, LEAST_SAVING_PER_POINT = 40.0, 0.1
# Amplitudes turned must be this many times the noise, on average: else their sign does not matter.
LEAST_TURNED = 3.0
LEAST_NOISE = 1e-3


def looks_folded(points: Points, amplitude: np.ndarray) -> bool:
    """Whether signs describe the amplitudes, none negative, clearly better than none."""
    # Strays would draw the fits to themselves.
    amplitude = np.minimum(amplitude, 1.3 * float(np.quantile(amplitude, 0.98)))
    signs = _best_signs(points, amplitude)
    turned = signs < 0
    if turned.mean() > 0.5:
        turned = ~turned
    if not turned.any():
        return False
    signed = best_fit(points, signs * amplitude).held_out
    plain = best_fit(points, amplitude).held_out
    noise = 1.4826 * float(np.median(np.abs(signed))) + LEAST_NOISE * float(np.median(amplitude))
    if amplitude[turned].mean() < LEAST_TURNED * noise:
        return False
    squares = [np.minimum((each / noise) ** 2, LARGEST_SQUARE).sum() for each in (plain, signed)]
    least = max(LEAST_SAVING, LEAST_SAVING_PER_POINT * len(amplitude))
    return bool(squares[0] - squares[1] > least)


def _best_signs(points: Points, amplitude: np.ndarray) -> np.ndarray:
    """The signs under which modes of SEARCH_DEGREE or less leave least of the amplitudes."""
    degree = max(each for each in points.degrees if each <= SEARCH_DEGREE)
    orthogonal = points.decomposed[0][:, : len(points.orders(degree))]
    patterns = (_rings if points.axisymmetric else _patterns)(points.x, points.y)
    signs = np.where(np.stack(list(patterns)) < 0, -1.0, 1.0)  # (patterns, points)
    for _ in range(ROUNDS):
        fitted = (signs * amplitude) @ orthogonal @ orthogonal.T
        fitted *= np.sign(fitted[:, :1])  # both sides of a node are alike
        same = {np.packbits(row < 0).tobytes(): row for row in fitted}
        signs = np.where(np.stack(list(same.values())) < 0, -1.0, 1.0)
    signed = signs * amplitude
    left = np.linalg.norm(signed - signed @ orthogonal @ orthogonal.T, axis=1)
    best: np.ndarray = signs[np.argmin(left)]
    return best


def _rings(x: np.ndarray, y: np.ndarray) -> Iterator[np.ndarray]:
    """One or two node circles."""
    r, radii = np.hypot(x, y), np.linspace(0.15, 0.95, 9)
    for index, first in enumerate(radii):
        yield r - first
        for second in radii[index + 3 :]:
            yield (r - first) * (r - second)


def _patterns(x: np.ndarray, y: np.ndarray) -> Iterator[np.ndarray]:
    """Node circles, parallel node lines and crossing ones."""
    yield from _rings(x, y)
    angle, r = np.arctan2(y, x), np.hypot(x, y)
    for direction in np.arange(0, np.pi, np.pi / 6):
        along = x * np.cos(direction) + y * np.sin(direction)
        for waves in (0.35, 0.6, 0.9, 1.3, 1.8):  # across the radius
            for phase in np.arange(0, np.pi, np.pi / 4):
                yield np.cos(2 * np.pi * waves * along + phase)
    for diameters in (2, 3, 4, 5):
        for turn in np.arange(0, np.pi, np.pi / 4):
            nodes = np.cos(diameters * angle + turn)
            yield nodes
            yield nodes * (r - 0.6)
