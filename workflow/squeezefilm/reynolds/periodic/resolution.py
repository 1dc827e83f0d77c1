"""How fine a grid a scene needs: a first guess from its numbers, and the next finer grid.

The guess only decides the cost. Whether it was right is judged afterwards, by the error estimate.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import lru_cache
from math import ceil, inf, log, log10, pi, sqrt

import numpy as np

from squeezefilm.film.outline import Outline
from squeezefilm.film.scene import Rows, Scenes, distinct
from squeezefilm.reynolds.error_estimate import THIN_LAYER_FALL, margin_of
from squeezefilm.reynolds.grid import MOST_SPACE, Grid
from squeezefilm.reynolds.needs import Needs
from squeezefilm.reynolds.terms import Terms, layer_stiffness_of, numbers_of, unknown_fields

# Instants beyond this are refused: at ε = 0.98 and σ = 1e6 a force good to 1e-6 needs 112.
MOST_TIME = 192
# Unknowns beyond which a scene takes minutes.
MOST_UNKNOWNS = 5_000_000
LEAST_TIME = 8
# Share of the tolerance that the first of two grids is to leave: with all of it, twice the change
# to the second would be above the tolerance, and a third grid be needed.
FIRST_SHARE = 1 / 3
# The start grid's points per direction, as a share of the first grid's.
START_SHARE = 0.6
TIME_SHARE = 0.15
# What the instants may leave of a force that is of second order in the amplitude, over its square:
# a change of 1.3 ρ^nt/ε² was seen from 8 instants to 12 (ε 0.2–0.25, σ 700–2300).
TIME_FORCE = 0.3
# Of which unknowns along an axis are multiples: kernels are fastest at four, two are the least.
FOURS, TWOS = 4, 2
# Share of the tolerance that a grid may miss of the profile without a look at how fast that falls.
NEXT_TO_NOTHING = 0.1
# A sliding surface makes a layer at the trailing rim, as thin as that of a squeeze number of so
# many times (Λ/(1 − ε))² (fitted to pistons, Λ 46–250).
SLIDING_LAYER = 24.0
# Below this squeeze number the film is nearly incompressible and its pressure goes like 1/H³,
# with stronger harmonics than the gas spring's 1/H.
INCOMPRESSIBLE = 10.0

# A profile is seen by a grid that misses no more of it than this or the root of the tolerance: a
# force is a mean, good to about the square of what the interpolant misses.
LARGEST_MISSED = 1e-2
# Tolerance below which a plain film's first grid is to leave less: there too many wanted a third.
TIGHT_BELOW, TIGHT_SHARE = 4e-7, 0.2
# Chebyshev nodes see the layer at a sliding surface's trailing rim, Λ/(1 − ε) times thinner than
# the finger, if there are this many times the root of that. Else errors fall as slowly as first
# order: of 40 films with more than 100 one (Λ 98, ε 0.87, at a tolerance of 0.1) was off by 1.8
# times its estimate, another by 0.98; with this least fall it is 7 times the change, as for 28
# nodes and 32.
NODES_PER_SLIDING = 2.0
SLIDING_FALL = 0.7
# Above this errors may go up and down from grid to grid; below 1e4 none of 996 films was beyond its
# estimate, but one at 9963 came to 0.9 of it.
UNEVEN_SIGMA = 5e3
# Above this at the narrowest place of a gap that is shaped at rest the first grid is for a layer as
# thin again: 60 such films of a draw (1e-4) took half of the time, for fewer went on to more grids.
THIN_SIGMA = 1e4
# Stands for zero in a denominator.
TINY = 1e-300


def first_grids(
    needs: Needs, *, tolerance: float, room: float = MOST_UNKNOWNS, kept: bool = False
) -> tuple[list[tuple[Grid, ...]], np.ndarray]:
    """Those of the first launch: a start, if it pays, and those that it takes to know the error.

    Args:
        room: most unknowns of a grid that the device has memory for.
        kept: whether states are, of which quantities ask for more than the force does.

    Returns:
        The sequences of grids, and which of them each scene is begun on, (n,).
    """
    # Twice the change to the second grid must be below the tolerance, or a third is needed; but
    # plain films want fewer nodes than the guess.
    plain = 1.0 if tolerance > TIGHT_BELOW else TIGHT_SHARE, TWOS
    if kept:
        plain = FIRST_SHARE, FOURS
    chosen, which = _choose(needs, tolerance=tolerance, room=room, plain=plain)
    return [_with_finer(*each) for each in chosen], which


def share_of(tolerance: float) -> float:
    """Share of a profile that a grid may miss at a tolerance."""
    return min(LARGEST_MISSED, sqrt(tolerance))


def nodes_for_profile(needs: Needs, *, tolerance: float) -> np.ndarray:
    """Nodes along x and y without which a grid would not see the profile, (n, 2)."""
    share = share_of(tolerance)
    return needs.once("nodes", lambda share: needs.samples(share).nodes(share), share)


def unseen_profiles(needs: Needs, *, tolerance: float) -> dict[int, str]:
    """The scenes whose profile under the finger no grid sees, and why."""
    return needs.once("unseen", lambda tolerance: _unseen_profiles(needs, tolerance), tolerance)


def _unseen_profiles(needs: Needs, tolerance: float) -> dict[int, str]:
    share = share_of(tolerance)
    missed = needs.samples(share).missed
    most = np.where(needs.fold_x & needs.fold_y, 2 * MOST_FIRST_FOLDED, MOST_FIRST)
    nodes = nodes_for_profile(needs, tolerance=tolerance).max(axis=1)
    rows = np.flatnonzero(~((missed <= share) & (nodes <= most))).tolist()
    return {row: _unseen(needs, row, float(missed[row]), share) for row in rows}


def _unseen(needs: Needs, row: int, missed: float, share: float) -> str:
    if not missed < inf:
        return "the profile has no finite value at some place under the finger"
    sampled, position = needs.position(row)
    finger = sampled.places.pad.finger
    side_m = max(finger.length_x_m, finger.length_y_m)
    apart_m = pi / 2 * side_m / (MOST_SPACE + 1)
    return (
        f"the profile has a feature about {1e6 * sampled.feature_m(position):.2g} µm wide under "
        f"the finger: the finest grid, {MOST_SPACE} points across {1e3 * side_m:g} mm, up to "
        f"{1e6 * apart_m:.2g} µm apart, does not show it to {share:.1g} of the profile's largest "
        "value, as this tolerance asks"
    )


Chosen = tuple[Grid, tuple[int, int], float, int]
"""A grid as it is wanted, nodes that see the profile, room for unknowns, their step."""


def _choose(
    needs: Needs,
    *,
    tolerance: float,
    room: float,
    plain: tuple[float, int] = (FIRST_SHARE, FOURS),
) -> tuple[list[Chosen], np.ndarray]:
    """Grids whose force errors are about a share of the tolerance, and which each scene has, (n,).

    Args:
        plain: share and step of unknowns for films of no other outline or margin than the plain.
    """
    scenes = needs.scenes
    samples = needs.samples(share_of(tolerance))
    seen = nodes_for_profile(needs, tolerance=tolerance)
    known: dict[Chosen, int] = {}
    which = np.empty(len(needs), dtype=np.int64)
    outlines = [film.finger.smooth_outline for film in scenes.films]
    for kind, outline, rows in _alike(needs, outlines):
        is_plain = outline is None and margin_of(needs.kinds[kind]) == 1
        share, step = plain if is_plain else (FIRST_SHARE, FOURS)
        some = scenes if isinstance(rows, slice) else scenes[rows]
        folds = needs.fold_x[rows], needs.fold_y[rows]
        wanted = _points(
            some,
            needs.kinds[kind],
            outline,
            nodes=seen[rows],
            curvature=samples.curvature[rows],
            folds=folds,
            tolerance=tolerance,
            share=share,
            step=step,
        )
        columns = np.array([*wanted, *folds, *seen[rows].T], dtype=np.int64)
        code = np.ravel_multi_index(tuple(columns), (512, 512, 256, 2, 2, 512, 512))
        first, of_code = distinct(code)
        numbers = []
        for nx, ny, nt, fold_x, fold_y, *nodes in columns[:, first].T.tolist():
            grid = Grid(nx, ny, nt, bool(fold_x), bool(fold_y), outline)
            numbers.append(known.setdefault((grid, tuple(nodes), room, step), len(known)))
        which[rows] = np.array(numbers)[of_code]
    return list(known), which


def _alike(
    needs: Needs, outlines: Sequence[Outline | None]
) -> Iterator[tuple[int, Outline | None, Rows]]:
    """Scenes of like terms and outlines."""
    if len(needs.kinds) == len(set(outlines)) == 1:
        yield 0, outlines[0], slice(None)
        return
    different = list(dict.fromkeys(outlines))
    outline = np.array([different.index(each) for each in outlines])[needs.scenes.film_index]
    for kind, at in sorted({*zip(needs.kind.tolist(), outline.tolist(), strict=True)}):
        yield kind, different[at], np.flatnonzero((needs.kind == kind) & (outline == at))


def _points(
    scenes: Scenes,
    terms: Terms,
    outline: Outline | None,
    *,
    nodes: np.ndarray,
    curvature: np.ndarray,
    folds: tuple[np.ndarray, np.ndarray],
    tolerance: float,
    share: float,
    step: int,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Unknowns nx, ny and instants nt, each (n,), that leave a share of the tolerance.

    Time: powers of 1/(1 + ε sin T) have harmonics that decay like ρ^k, ρ = ε / (1 + √(1 − ε²)).

    Args:
        nodes: along x, y without which a grid would not see the profile, (n, 2).
        curvature: of the profile, (n, 2).
        step: of which unknowns along the axes are multiples, FOURS or TWOS.
    """
    digits = log10(1 / (share * tolerance))
    epsilon, sigma, bend = gap_numbers(scenes)
    aspect = scenes.aspect
    with np.errstate(divide="ignore", invalid="ignore"):  # of films at rest
        ratio = epsilon / (1 + np.sqrt(1 - epsilon**2))
        left = np.minimum(log(TIME_SHARE / 3), log(TIME_FORCE) + 2 * np.log(epsilon))
        instants = np.where(ratio > 0, (log(tolerance) + left) / np.log(ratio), LEAST_TIME)
    instants += 4.0 * (sigma * np.maximum(1.0, aspect) ** 2 < INCOMPRESSIBLE)
    # Only what has unknowns of its own lags; without terms no layer but the squeezing's counts.
    lags = unknown_fields(terms) > 1
    slow = np.minimum(numbers_of(scenes, terms)["slow"], 1.0) if lags else 1.0
    nt = np.minimum(4 * np.ceil(np.maximum(LEAST_TIME / slow, instants) / 4), MOST_FIRST_TIME)
    layers = (layer_stiffness_of(scenes, terms, sigma=sigma) if terms else 1.0) * sigma
    bent_x, bent_y = curvature.T + bend
    if outline:
        layer_x = layers * outline.rim_stretch[1] * (2 * outline.rim) ** 2
        wanted_y = _nodes_around(digits, epsilon, bent_y, outline)
        along, across = folds if outline.turned else folds[::-1]
        shares = [1 + along, (1 + along) * (1 + across)]
    else:
        sliding = (np.abs(scenes.bearing_number) / (1 - epsilon)) ** 2
        layer_x = np.maximum(layers, SLIDING_LAYER * sliding)
        wanted_y = _nodes(digits, epsilon=epsilon, sigma=layers * aspect**2, curvature=bent_y)
        shares = [1 + fold for fold in folds]
    wanted_x = _nodes(digits, epsilon=epsilon, sigma=layer_x, curvature=bent_x)
    nx, ny = (
        _unknowns(np.maximum(at_least, wanted), each, step)
        for at_least, wanted, each in zip(nodes.T, (wanted_x, wanted_y), shares, strict=True)
    )
    return nx, ny, nt


def _nodes(
    digits: float, *, epsilon: np.ndarray, sigma: np.ndarray, curvature: np.ndarray
) -> np.ndarray:
    """Nodes across the finger for a rim layer and for a narrow gap, whichever wants more.

    A Chebyshev grid resolves a layer of width √(2/σ) with a number of nodes proportional to
    σ^(1/4), the factor growing with the wanted digits (fitted to the centred sinc's errors). The
    gap 1 − ε + ε c X²/2 at its narrowest has zeros ±iδ off the middle, which slow the convergence
    to that of the ellipse through them, r = 2δ + √(1 + 4δ²) per node (Trefethen 2000, ch. 5); the
    force, being a mean, converges with about the power 1.6 of it (fitted).
    """
    layer = 7 + 0.36 * digits * np.maximum(sigma, 1.0) ** 0.25
    width = np.sqrt(2 * (1 - epsilon) / np.maximum(epsilon * curvature, TINY))
    return np.maximum(layer, 4 + digits * log(10) / (1.6 * np.arcsinh(2 * width)))


def _nodes_around(
    digits: float, epsilon: np.ndarray, curvature: np.ndarray, outline: Outline
) -> np.ndarray:
    """Nodes around an outline.

    The layer's width along the rim goes with the area behind a point, which has no zero nearer to
    real ν than about the rim's μ; the gap has those of ``_nodes``. Coefficients fall by as much for
    each of half the nodes.
    """
    width = np.sqrt(2 * (1 - epsilon) / np.maximum(epsilon * curvature, TINY))
    return 8 + digits * log(10) / (0.8 * np.minimum(outline.strip, width))


def _unknowns(nodes: np.ndarray, share: np.ndarray, step: int) -> np.ndarray:
    """Unknowns along an axis, one for so many nodes: a multiple of a step."""
    most = np.where(share > 1, MOST_FIRST_FOLDED, MOST_FIRST)
    return np.minimum(step * np.ceil(nodes / share / step), most)


@lru_cache(maxsize=4096)
def _with_room(grid: Grid, seen: tuple[int, int], room: float, step: int) -> Grid:
    """The grid, or one that is as much coarser as it takes for a finer one to have room."""
    while finer_grid(grid, room=room, step=step) is None and grid.sees(*seen):
        grid = _coarser(grid, step)
    return grid


@lru_cache(maxsize=4096)
def _with_finer(wanted: Grid, seen: tuple[int, int], room: float, step: int) -> tuple[Grid, ...]:
    """The grid, one that starts it, if that pays, and the finer one that tells its error."""
    first = _with_room(wanted, seen, room, step)
    start = start_grid(first, step)
    # What does not see the profile is no guess.
    grids = start if start and start.sees(*seen) else None, first
    return tuple(
        each for each in (*grids, finer_grid(first, room=room, step=step)) if each is not None
    )


@lru_cache(maxsize=4096)
def start_grid(grid: Grid, step: int) -> Grid | None:
    """A coarse grid whose state is a cheap first guess on ``grid``; None where it is small already.

    A solve from rest takes about twice the iterations of one from a guess.
    """
    start = replace(
        grid,
        nx=_fewer(grid.nx, step, fold=grid.fold_x),
        ny=_fewer(grid.ny, step, fold=grid.fold_y),
        nt=max(LEAST_TIME, 4 * ceil(START_SHARE * grid.nt / 4)),
    )
    return start if start.count < 0.5 * grid.count else None


def _fewer(points: int, step: int, *, fold: bool) -> int:
    return max(4 if fold else 8, step * round(START_SHARE * points / step))


def profile_fall(
    needs: Needs,
    coarse: tuple[int, int],
    fine: tuple[int, int],
    *,
    tolerance: float,
    rows: Rows = slice(None),
) -> np.ndarray:
    """Factors by which what is missed of profiles falls from nodes to nodes, or degree to degree.

    0 if the fine ones miss next to nothing: then it is not the profile that changes the force.

    Args:
        coarse, fine: nodes across the finger along x and y (``Grid.across``).
        rows: which of the scenes; all if left out.
    """
    least = NEXT_TO_NOTHING * tolerance
    samples = needs.samples(least)
    missed, before = samples.missed_by(fine, rows), samples.missed_by(coarse, rows)
    fall = np.divide(missed, before, out=np.zeros_like(missed), where=missed > least)
    return np.asarray(fall.max(axis=1))


def _coarser(grid: Grid, step: int) -> Grid:
    nx, ny = (step * (5 * points // (6 * step)) for points in (grid.nx, grid.ny))
    nt = 4 * (5 * grid.nt // 24)
    return replace(grid, nx=nx, ny=ny, nt=max(LEAST_TIME, nt))


@lru_cache(maxsize=4096)
def finer_grid(grid: Grid, *, room: float = MOST_UNKNOWNS, step: int = FOURS) -> Grid | None:
    """The next grid of a scene's sequence, finer in every direction; None past the limits.

    In every direction, because the difference between two grids shows no error that both share.
    """
    finer = replace(
        grid,
        nx=grid.nx + _part(grid.nx, 5, step, fold=grid.fold_x),
        ny=grid.ny + _part(grid.ny, 5, step, fold=grid.fold_y),
        nt=_more_instants(grid.nt),
    )
    if max(finer.x.full_points, finer.y.full_points) > MOST_SPACE or finer.nt > MOST_TIME:
        return None
    return finer if finer.count <= room else None


def _part(points: int, share: int, step: int, *, fold: bool) -> int:
    """About one in so many points, in steps; never less than four nodes across the finger."""
    least = 1 if fold else FOURS // step
    return step * max(least, round(points / share / step))


def _more_instants(points: int) -> int:
    """About a fifth more."""
    return points + _part(points, 5, FOURS, fold=False)


def _most_first(most: int) -> int:
    """The most points from which the next finer grid, which tells the error, has room."""
    some = range(4, most + 1, 4)
    return max(points for points in some if points + _part(points, 5, FOURS, fold=False) <= most)


MOST_FIRST, MOST_FIRST_FOLDED = _most_first(MOST_SPACE), _most_first(MOST_SPACE // 2)
MOST_FIRST_TIME = _most_first(MOST_TIME)


def gap_numbers(scenes: Scenes) -> tuple[np.ndarray, np.ndarray, np.ndarray | float]:
    """Scenes' gaps as first grids go by them: ε, σ, and what the gap adds to a profile's curvature.

    A gap that is shaped at rest is as hard as its narrowest place, and as closed, everywhere.
    """
    flat = scenes.column(lambda film: film.finger.gap.flat)
    if np.all(flat):
        return scenes.epsilon, scenes.sigma, 0.0
    bulge_m = scenes.column(lambda film: abs(film.finger.gap.bulge_m))
    bend = 8 * bulge_m / scenes.h0_m / np.maximum(scenes.epsilon, TINY) * (scenes.epsilon > 0)
    return np.where(flat, scenes.epsilon, scenes.closure), _hardest_sigma(scenes), bend


def _hardest_sigma(scenes: Scenes) -> np.ndarray:
    least = np.minimum(1.0, scenes.rest_range[0])
    sigma = scenes.sigma / least**2
    return np.where(sigma < THIN_SIGMA, sigma, sigma / least**2)


def least_fall(scenes: Scenes, nodes_x: int) -> np.ndarray:
    """Factors by which changes from grid to grid are believed to fall at most, (n,).

    Args:
        nodes_x: across the finger along x, of the coarser grid.
    """
    epsilon, sigma, _ = gap_numbers(scenes)
    uneven = sigma * np.maximum(1.0, scenes.aspect) ** 2 > UNEVEN_SIGMA
    fall = np.where(uneven, THIN_LAYER_FALL, 0.0)
    layers = np.abs(scenes.bearing_number) / (1 - epsilon)
    return np.where(nodes_x < NODES_PER_SLIDING * np.sqrt(layers), SLIDING_FALL, fall)
