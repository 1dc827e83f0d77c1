"""Where a formula may hide a spot too narrow for evenly spread samples to be sure to meet it.

The other profiles are as fine at one place as at any other; a formula can be flat everywhere but at
one point. It is scanned once, on a net of the whole surface, and the places where it differs most
from its neighbourhood are looked at closer.
"""

from functools import lru_cache

import numpy as np

from squeezefilm.film.vibration.shapes import Formula, TwoPhases, Vibration

# Lines of the net along each axis: a spot wider than about a thousandth of the surface is met.
LINES = 1000
# The net is searched in TILES × TILES parts, and the most remarkable of them are followed up.
TILES = 20
FOLLOWED = 16
MOST_STEPS = 60


def landmarks_of(profile: Vibration) -> tuple[np.ndarray, np.ndarray]:
    """Points x_m, y_m that a sampling of the profile should not leave out; none but for formulas.

    A spot narrower than a five-hundredth of half the surface, with no trace beyond, can be missed.
    """
    if isinstance(profile, Formula):
        return _landmarks(profile)
    if isinstance(profile, TwoPhases):
        of_both = zip(landmarks_of(profile.first), landmarks_of(profile.second), strict=True)
        x_m, y_m = map(np.concatenate, of_both)
        return x_m, y_m
    return np.zeros(0), np.zeros(0)


@lru_cache(maxsize=16)
def _landmarks(formula: Formula) -> tuple[np.ndarray, np.ndarray]:
    # Uneven lines, so that nothing with a period hides between them.
    uneven = np.arange(LINES) * 0.6180339887498949 % 1
    lines = 2 * (np.arange(LINES) + uneven) / LINES - 1
    x_lines_m, y_lines_m = (half * lines for half in formula.surface.half_m)
    with np.errstate(all="ignore"):
        s = formula.amplitude(x_m=x_lines_m[:, None], y_m=y_lines_m[None, :])
        bends = np.maximum(_bends(s, x_lines_m), _bends(s.T, y_lines_m).T)
    bends[formula.surface.reach(x_lines_m[:, None], y_lines_m[None, :]) > 1] = 0.0
    side = LINES // TILES
    tiles = bends.reshape(TILES, side, TILES, side).transpose(0, 2, 1, 3).reshape(TILES**2, -1)
    first = np.argsort(-tiles.max(axis=1), kind="stable")[:FOLLOWED]
    row, column = np.divmod(tiles[first].argmax(axis=1), side)
    x_m = x_lines_m[first // TILES * side + row]
    y_m = y_lines_m[first % TILES * side + column]
    return _climbed(formula, x_m, y_m)


def _bends(s: np.ndarray, lines_m: np.ndarray) -> np.ndarray:
    """How far each value is off the line through its neighbours along the first axis."""
    share = ((lines_m[1:-1] - lines_m[:-2]) / (lines_m[2:] - lines_m[:-2]))[:, None]
    bends = np.zeros(s.shape)
    bends[1:-1] = np.abs(s[1:-1] - (1 - share) * s[:-2] - share * s[2:])
    return np.nan_to_num(bends, nan=0.0, posinf=0.0)


def _climbed(formula: Formula, x_m: np.ndarray, y_m: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The points moved to where the profile stands out most from what is two lines away."""
    line_x_m, line_y_m = (2 * half / LINES for half in formula.surface.half_m)

    def contrast(x_m: np.ndarray, y_m: np.ndarray) -> np.ndarray:
        off_x_m = 2 * line_x_m * np.array([0, 1, -1, 0, 0])
        off_y_m = 2 * line_y_m * np.array([0, 0, 0, 1, -1])
        s = formula.amplitude(x_m=x_m[..., None] + off_x_m, y_m=y_m[..., None] + off_y_m)
        return np.nan_to_num(np.abs(s[..., 0] - s[..., 1:].mean(axis=-1)), posinf=0.0)

    angle = np.pi / 4 * np.arange(8)
    around = np.append(0.0, np.cos(angle)), np.append(0.0, np.sin(angle))
    step = np.ones(len(x_m))
    each = np.arange(len(x_m))
    with np.errstate(all="ignore"):
        for _ in range(MOST_STEPS):
            tried_x = x_m[:, None] + line_x_m * step[:, None] * around[0]
            tried_y = y_m[:, None] + line_y_m * step[:, None] * around[1]
            best = contrast(tried_x, tried_y).argmax(axis=1)
            x_m, y_m = tried_x[each, best], tried_y[each, best]
            step = np.where(best == 0, step / 2, step)
    return x_m, y_m
