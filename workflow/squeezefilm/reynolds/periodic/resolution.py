"""How fine a grid a scene needs: a first guess from its numbers, and the next finer grid.

The guess only decides the cost. Whether it was right is judged afterwards, by the error estimate.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from math import asinh, ceil, inf, log, log10, pi, sqrt
from typing import TypedDict

from squeezefilm.film.outline import Outline
from squeezefilm.film.scene import Scene
from squeezefilm.reynolds.error_estimate import THIN_LAYER_FALL, margin_of
from squeezefilm.reynolds.grid import MOST_SPACE, Grid
from squeezefilm.reynolds.needs import Needs
from squeezefilm.reynolds.terms import layer_stiffness_of, numbers_of, unknown_fields
from squeezefilm.reynolds.under_finger import Probe, UnderFinger

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


def first_grids(
    scene: Scene, needs: Needs, *, tolerance: float, room: float = MOST_UNKNOWNS, kept: bool = False
) -> tuple[Grid, ...]:
    """Those of the first launch: a start, if it pays, and those that it takes to know the error.

    Args:
        room: most unknowns of a grid that the device has memory for.
        kept: whether states are, of which quantities ask for more than the force does.
    """
    plain = not kept and needs.outline is None and margin_of(needs.terms) == 1
    # Twice the change to the second grid must be below the tolerance, or a third is needed; but
    # plain films want fewer nodes than the guess.
    plain_share = 1.0 if tolerance > TIGHT_BELOW else TIGHT_SHARE
    share, step = (plain_share, TWOS) if plain else (FIRST_SHARE, FOURS)
    first = grid_for(scene, needs, tolerance=tolerance, share=share, room=room, step=step)
    return with_finer(first, needs, tolerance, room, step)


def grid_for(
    scene: Scene,
    needs: Needs,
    *,
    tolerance: float,
    share: float = FIRST_SHARE,
    room: float = MOST_UNKNOWNS,
    step: int = FOURS,
) -> Grid:
    """A grid that is to leave a share of the tolerance."""
    numbers, terms = gap_numbers(scene), needs.terms
    return first_grid(
        **numbers,
        bearing=abs(scene.bearing_number),
        aspect=scene.aspect,
        needs=needs,
        tolerance=tolerance,
        share=share,
        # Only what has unknowns of its own lags; without terms no layer but the squeezing's counts.
        slow=float(numbers_of(scene, terms)["slow"]) if unknown_fields(terms) > 1 else 1.0,  # type: ignore[arg-type]
        stiffness=layer_stiffness_of(scene, terms, sigma=numbers["sigma"]) if terms else 1.0,
        room=room,
        step=step,
    )


def probe_for(needs: Needs, *, tolerance: float) -> Probe:
    """What is known of a scene's profile as closely as the tolerance asks."""
    return needs.profile.probe(_share(tolerance))


def nodes_for_profile(needs: Needs, *, tolerance: float) -> tuple[int, int]:
    """Nodes along x and y without which a grid would not see the profile."""
    return _nodes_for(needs.profile, _share(tolerance))


@lru_cache(maxsize=4096)
def _nodes_for(profile: UnderFinger, share: float) -> tuple[int, int]:
    return profile.probe(share).nodes(share)


def _share(tolerance: float) -> float:
    return min(LARGEST_MISSED, sqrt(tolerance))


@lru_cache(maxsize=4096)
def unseen_profile(needs: Needs, *, tolerance: float) -> str | None:
    """Why no grid sees the profile under the finger, if so."""
    probe, share = probe_for(needs, tolerance=tolerance), _share(tolerance)
    if not probe.missed < inf:
        return "the profile has no finite value at some place under the finger"
    most = MOST_FIRST_FOLDED * 2 if needs.fold_x and needs.fold_y else MOST_FIRST
    if probe.missed <= share and max(probe.nodes(share)) <= most:
        return None
    finger = needs.profile.finger
    side_m = max(finger.length_x_m, finger.length_y_m)
    apart_m = pi / 2 * side_m / (MOST_SPACE + 1)
    return (
        f"the profile has a feature about {1e6 * needs.profile.feature_m:.2g} µm wide under the "
        f"finger: the finest grid, {MOST_SPACE} points across {1e3 * side_m:g} mm, up to "
        f"{1e6 * apart_m:.2g} µm apart, does not show it to {share:.1g} of the profile's largest "
        "value, as this tolerance asks"
    )


def first_grid(
    *,
    epsilon: float,
    sigma: float,
    aspect: float,
    needs: Needs,
    tolerance: float,
    bearing: float = 0.0,
    bend: float = 0.0,
    share: float = FIRST_SHARE,
    slow: float = 1.0,
    stiffness: float = 1.0,
    room: float = MOST_UNKNOWNS,
    step: int = FOURS,
) -> Grid:
    """A grid whose force error is about a share of ``tolerance``, relative.

    Time: powers of 1/(1 + ε sin T) have harmonics that decay like ρ^k, ρ = ε / (1 + √(1 − ε²)).

    Args:
        bend: what the gap at rest adds to the profile's curvature.
        slow: share of the harmonics that the equation is whole for (time_modes.py).
        stiffness: by which terms make layers at the rim ask for more nodes, in units of σ.
        room: most unknowns that there is memory for, on the next finer grid too.
        step: of which unknowns along the axes are multiples, FOURS or TWOS.
    """
    wanted = share * tolerance
    digits = log10(1 / wanted)
    ratio = epsilon / (1 + sqrt(1 - epsilon**2))
    instants = float(LEAST_TIME)
    if ratio > 0:
        left = min(log(TIME_SHARE / 3), log(TIME_FORCE) + 2 * log(epsilon))
        instants = (log(tolerance) + left) / log(ratio)
    if sigma * max(1.0, aspect) ** 2 < INCOMPRESSIBLE:
        instants += 4
    seen = _seen(needs, tolerance)
    bent_x, bent_y = seen.curvature_x + bend, seen.curvature_y + bend
    layers = stiffness * sigma
    layer_x = max(layers, SLIDING_LAYER * (bearing / (1 - epsilon)) ** 2)
    layer_y = layers * aspect**2
    if outline := needs.outline:
        layer_x = layers * outline.rim_stretch[1] * (2 * outline.rim) ** 2
    nodes_x = max(seen.nodes_x, _nodes(digits, epsilon=epsilon, sigma=layer_x, curvature=bent_x))
    if outline:
        nodes_y = max(seen.nodes_y, _nodes_around(digits, epsilon, bent_y, outline))
    else:
        nodes_y = max(
            seen.nodes_y, _nodes(digits, epsilon=epsilon, sigma=layer_y, curvature=bent_y)
        )
    return _with_room(
        seen,
        _unknowns(nodes_x, seen.share_x, step),
        _unknowns(nodes_y, seen.share_y, step),
        min(4 * ceil(max(LEAST_TIME / min(slow, 1.0), instants) / 4), MOST_FIRST_TIME),
        room,
        step,
    )


@dataclass(frozen=True, eq=False)
class _Seen:
    """What the profile asks of a grid, whatever the film.

    Attributes:
        nodes_x, nodes_y: without which a grid would not see it.
        curvature_x, curvature_y: its largest.
        plain: a grid of the scene's kind.
        share_x, share_y: nodes across the finger for each of its unknowns.
    """

    nodes_x: int
    nodes_y: int
    curvature_x: float
    curvature_y: float
    plain: Grid
    share_x: int
    share_y: int


@lru_cache(maxsize=4096)
def _seen(needs: Needs, tolerance: float) -> _Seen:
    probe = probe_for(needs, tolerance=tolerance)
    plain = Grid(4, 4, LEAST_TIME, needs.fold_x, needs.fold_y, needs.outline)
    nodes = nodes_for_profile(needs, tolerance=tolerance)
    shares = (along.full_points // along.points for along in (plain.x, plain.y))
    return _Seen(*nodes, probe.curvature_x, probe.curvature_y, plain, *shares)


@lru_cache(maxsize=4096)
def _with_room(seen: _Seen, nx: int, ny: int, nt: int, room: float, step: int) -> Grid:
    """The grid, or one that is as much coarser as it takes for a finer one to have room."""
    grid = replace(seen.plain, nx=nx, ny=ny, nt=nt)
    while finer_grid(grid, room=room, step=step) is None and grid.sees(seen.nodes_x, seen.nodes_y):
        grid = _coarser(grid, step)
    return grid


def _nodes(digits: float, *, epsilon: float, sigma: float, curvature: float) -> float:
    """Nodes across the finger for a rim layer and for a narrow gap, whichever wants more.

    A Chebyshev grid resolves a layer of width √(2/σ) with a number of nodes proportional to
    σ^(1/4), the factor growing with the wanted digits (fitted to the centred sinc's errors). The
    gap 1 − ε + ε c X²/2 at its narrowest has zeros ±iδ off the middle, which slow the convergence
    to that of the ellipse through them, r = 2δ + √(1 + 4δ²) per node (Trefethen 2000, ch. 5); the
    force, being a mean, converges with about the power 1.6 of it (fitted).
    """
    layer = 7 + 0.36 * digits * max(sigma, 1.0) ** 0.25
    if epsilon == 0 or curvature == 0:
        return layer
    width = sqrt(2 * (1 - epsilon) / (epsilon * curvature))
    narrow = 4 + digits * log(10) / (1.6 * asinh(2 * width))
    return max(layer, narrow)


def _nodes_around(digits: float, epsilon: float, curvature: float, outline: Outline) -> float:
    """Nodes around an outline.

    The layer's width along the rim goes with the area behind a point, which has no zero nearer to
    real ν than about the rim's μ; the gap has those of ``_nodes``. Coefficients fall by as much for
    each of half the nodes.
    """
    strip = outline.strip
    if epsilon and curvature:
        strip = min(strip, sqrt(2 * (1 - epsilon) / (epsilon * curvature)))
    return 8 + digits * log(10) / (0.8 * strip)


def _unknowns(nodes: float, share: int, step: int) -> int:
    """Unknowns along an axis, one for so many nodes: a multiple of a step."""
    most = MOST_FIRST_FOLDED if share > 1 else MOST_FIRST
    return min(step * ceil(nodes / share / step), most)


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


@lru_cache(maxsize=4096)
def with_finer(
    first: Grid, needs: Needs, tolerance: float, room: float, step: int
) -> tuple[Grid, ...]:
    """The grid, one that starts it, if that pays, and the finer one that tells its error."""
    seen = nodes_for_profile(needs, tolerance=tolerance)
    wanted = _start(first, seen, step), first, finer_grid(first, room=room, step=step)
    return tuple(grid for grid in wanted if grid is not None)


def _start(grid: Grid, seen: tuple[int, int], step: int) -> Grid | None:
    start = start_grid(grid, step)
    # What does not see the profile is no guess.
    return start if start and start.sees(*seen) else None


@lru_cache(maxsize=4096)
def profile_fall(
    needs: Needs, coarse: tuple[int, int], fine: tuple[int, int], *, tolerance: float
) -> float:
    """Factor by which what is missed of the profile falls from nodes to nodes, or degree to degree.

    0 if the fine one misses next to nothing: then it is not the profile that changes the force.

    Args:
        coarse, fine: nodes across the finger along x and y (``Grid.across``).
    """
    least = NEXT_TO_NOTHING * tolerance
    probe = needs.profile.probe(least)
    fall = 0.0
    for tail, before, after in zip((probe.tail_x, probe.tail_y), coarse, fine, strict=True):
        most = len(tail) - 1
        missed = float(tail[min(after + 2, most)])
        if missed > least:
            fall = max(fall, missed / float(tail[min(before + 2, most)]))
    return fall


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


class GapNumbers(TypedDict):
    """A scene's gap as a first grid goes by it, arguments of ``first_grid``."""

    epsilon: float
    sigma: float
    bend: float


def gap_numbers(scene: Scene) -> GapNumbers:
    """A gap that is shaped at rest is as hard as its narrowest place, and as closed, everywhere."""
    if scene.finger.gap.flat:
        return {"epsilon": scene.epsilon, "sigma": scene.sigma, "bend": 0.0}
    bulge = 8 * abs(scene.finger.gap.bulge_m) / scene.h0_m
    return {
        "epsilon": scene.closure(),
        "sigma": _hardest_sigma(scene),
        "bend": bulge / scene.epsilon if scene.epsilon else 0.0,
    }


def _hardest_sigma(scene: Scene) -> float:
    least = min(1.0, scene.rest_range[0])
    sigma = scene.sigma / least**2
    return sigma if sigma < THIN_SIGMA else sigma / least**2


def least_fall(scene: Scene, nodes_x: int) -> float:
    """Factor by which changes from grid to grid are believed to fall at most.

    Args:
        nodes_x: across the finger along x, of the coarser grid.
    """
    if scene.bearing_number:
        layers = abs(scene.bearing_number) / (1 - gap_numbers(scene)["epsilon"])
        if nodes_x < NODES_PER_SLIDING * sqrt(layers):
            return SLIDING_FALL
    sigma = scene.sigma if scene.finger.gap.flat else _hardest_sigma(scene)
    sigma *= max(1.0, scene.aspect) ** 2
    return THIN_LAYER_FALL if sigma > UNEVEN_SIGMA else 0.0
