"""Grids of a scene: a first guess from its numbers, and the next finer grid.

The guess only decides the cost. The error estimate shows afterwards if it was right.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import lru_cache
from math import ceil, inf, log, log10, pi, sqrt
from typing import Any

import numpy as np

from squeezefilm.film.outline import Outline
from squeezefilm.film.pad import Pad
from squeezefilm.film.scene import MAX_CACHED_POSITIONS, Film, Rows, Scenes, equal_row_groups
from squeezefilm.reynolds.error_estimate import (
    THIN_LAYER_CONVERGENCE_RATIO,
    THIN_LAYER_VELOCITY_CONVERGENCE_RATIO,
)
from squeezefilm.reynolds.grid import MAX_NODES_ACROSS, Grid
from squeezefilm.reynolds.plan import SolvePlan, solve_plan_of
from squeezefilm.reynolds.terms import (
    Terms,
    equation_numbers,
    have_velocity_terms,
    is_radial,
    max_layer_sigma_factor,
    unknown_field_count,
)

# Instants beyond this are refused: at ε = 0.98 and σ = 1e6 a force good to 1e-6 needs 112.
MAX_TIME_POINTS = 192
# Unknowns beyond which a scene takes minutes.
MAX_UNKNOWNS = 5_000_000
MIN_TIME_POINTS = 8
# Share of the tolerance that the first of two grids is to leave: with all of it, twice the change
# to the second would be above the tolerance, and a third grid be needed.
FIRST_GRID_TOLERANCE_FRACTION = 1 / 3
# The start grid's points per direction, as a share of the first grid's.
START_GRID_POINTS_FRACTION = 0.6
# Unknowns of a first grid below which a start costs the host more than it saves the device.
MIN_UNKNOWNS_WITH_START = 4_000
TIME_ERROR_FRACTION = 0.15
# What the instants may leave of a force that is of second order in the amplitude, over its square:
# a change of 1.3 ρ^nt/ε² was seen from 8 instants to 12 (ε 0.2–0.25, σ 700–2300).
TIME_ERROR_PER_EPSILON_SQUARED = 0.3
# Of which unknowns along an axis are multiples: kernels are fastest at four, two are the least.
FAST_NODE_MULTIPLE, MIN_NODE_MULTIPLE = 4, 2
# Share of the tolerance that a grid may miss of the profile without a look at how fast that falls.
NEGLIGIBLE_ERROR_PER_TOLERANCE = 0.1
# A sliding surface makes a layer at the trailing edge, as thin as that of a squeeze number of so
# many times (Λ/(1 − ε))² (fitted to pistons, Λ 46–250).
SLIDING_LAYER_SIGMA_FACTOR = 24.0
# Below this squeeze number the film is nearly incompressible and its pressure goes like 1/H³,
# with stronger harmonics than the gas spring's 1/H.
INCOMPRESSIBLE_SIGMA = 10.0

# A profile is seen by a grid that misses no more of it than this or the root of the tolerance: a
# force is a mean, good to about the square of what the interpolant misses.
MAX_PROFILE_ERROR = 1e-2
# That share for a plain film goes with the root of the tolerance, for the tighter it is the more
# digits the guess lacks: factor, least and largest share. Of shares from 0.02 to 10 it takes about
# the fewest operations on 400 films of the paper's space at 1e-6 and below. Larger shares take
# fewer at 1e-4; but with twice the tolerance a film (judged_films.csv in tests/numerics/data) is
# off by 1.5 times its estimate.
PLAIN_FIRST_GRID_FACTOR = 500.0
PLAIN_FIRST_GRID_FRACTIONS = (0.2, 1.0)
# Above this errors may go up and down from grid to grid; below 1e4 none of 996 films was beyond its
# estimate, but one at 9963 came to 0.9 of it. With inertia or thermal effects, where waves steepen,
# films from 3500 to 4500 were off by up to 1.43 times theirs.
ERRATIC_CONVERGENCE_SIGMA, ERRATIC_VELOCITY_SIGMA = 5e3, 2.5e3
# Above this at the narrowest place of a gap that is shaped at rest the first grid is for a layer as
# thin again: 60 such films of a draw (1e-4) took half of the time, for fewer went on to more grids.
NONUNIFORM_THIN_LAYER_SIGMA = 1e4
# The most points along an axis, whole or folded, and instants, from which the next finer grid,
# which tells the error, has room within MAX_NODES_ACROSS and MAX_TIME_POINTS.
MAX_FIRST_GRID_NODES, MAX_FIRST_GRID_FOLDED_NODES, MAX_FIRST_GRID_TIME_POINTS = 268, 132, 160
# Stands for zero in a denominator.
TINY_DENOMINATOR = 1e-300


def first_grids(
    plan: SolvePlan,
    rows: Rows = slice(None),
    *,
    tolerance: float,
    capacity: float = MAX_UNKNOWNS,
    kept: bool = False,
) -> Iterator[tuple[np.ndarray, Terms, tuple[Grid, ...]]]:
    """Scenes of like terms and pad shape, their terms, and the grids of their first launch.

    These are a start, if it pays, and those that it takes to know the error. Force errors on the
    first of the latter are about a share of the tolerance.

    Args:
        rows: which of the scenes; default all.
        room: most unknowns of a grid that the device has memory for.
        kept: whether states are, of which quantities ask for more than the force does.
    """
    for kind, film, rows_of_group in _groups_by_terms_and_pad(plan, rows):
        terms, pad = plan.term_sets[kind], film.pad
        outline = _coordinate_outline(pad, terms)
        part, step = FIRST_GRID_TOLERANCE_FRACTION, FAST_NODE_MULTIPLE
        if pad.smooth_outline is None and not have_velocity_terms(terms) and not kept:
            part = float(
                np.clip(PLAIN_FIRST_GRID_FACTOR * sqrt(tolerance), *PLAIN_FIRST_GRID_FRACTIONS)
            )
            step = MIN_NODE_MULTIPLE
        how: dict[str, Any] = {"tolerance": tolerance, "part_of_tolerance": part, "step": step}
        columns = _needed_points(plan, rows_of_group, film, **how)
        numbers = np.arange(len(plan.scenes))[rows_of_group]
        for rows_on_grids in equal_row_groups(*columns):
            points = tuple(columns[:, rows_on_grids[0]].tolist())
            grids = _grid_sequence(points, outline, capacity, step)
            yield numbers[rows_on_grids], terms, grids


def _coordinate_outline(pad: Pad, terms: Terms) -> Outline | None:
    """The outline in whose coordinates a film is solved; None in a rectangle's or on a radius."""
    return None if is_radial(terms) else pad.smooth_outline


def allowed_profile_error(tolerance: float) -> float:
    """Largest fraction of a profile that a grid may leave unresolved, min(0.01, √tolerance)."""
    return min(MAX_PROFILE_ERROR, sqrt(tolerance))


def nodes_for_profile(plan: SolvePlan, *, tolerance: float) -> np.ndarray:
    """Least nodes along x and y that resolve the profile, (n, 2)."""
    missed = allowed_profile_error(tolerance)
    return plan.compute_cached(
        "nodes", lambda missed: plan.profile_resolution(missed).needed_nodes(missed), missed
    )


def unresolved_profile_reasons(plan: SolvePlan, *, tolerance: float) -> dict[int, str]:
    """Return the reasons for scenes whose profile no grid resolves, by row."""
    share = allowed_profile_error(tolerance)
    missed = plan.profile_resolution(share).interpolation_error
    most = np.where(
        plan.fold_x & plan.fold_y, 2 * MAX_FIRST_GRID_FOLDED_NODES, MAX_FIRST_GRID_NODES
    )
    nodes = nodes_for_profile(plan, tolerance=tolerance).max(axis=1)
    rows = np.flatnonzero(~((missed <= share) & (nodes <= most))).tolist()
    return {row: _unresolved_reason(plan, row, float(missed[row]), share) for row in rows}


def _unresolved_reason(plan: SolvePlan, row: int, missed: float, missed_fraction: float) -> str:
    if not missed < inf:
        return "the profile has no finite value at some place under the pad"
    ((_, sampled, _),) = solve_plan_of(plan.scenes[row]).sampled_profiles_by_film
    pad = sampled.places.pad_profile.pad
    side_m = max(pad.length_x_m, pad.length_y_m)
    apart_m = pi / 2 * side_m / (MAX_NODES_ACROSS + 1)
    return (
        f"the profile has a feature about {1e6 * sampled.narrowest_feature_m():.2g} µm wide under "
        f"the pad: the finest grid, {MAX_NODES_ACROSS} points across {1e3 * side_m:g} mm, up to "
        f"{1e6 * apart_m:.2g} µm apart, does not resolve it to {missed_fraction:.1g} of the "
        "largest "
        "amplitude, as this tolerance needs"
    )


def _groups_by_terms_and_pad(plan: SolvePlan, rows: Rows) -> Iterator[tuple[int, Film, Rows]]:
    """Group the scenes by terms, outline and aspect ratio; yield kind, a film and rows."""
    films = plan.scenes.films
    if len(plan.term_sets) == len(films) == 1:
        yield 0, films[0], rows
        return
    pads = [(film.pad.smooth_outline, film.pad.length_y_m / film.pad.length_x_m) for film in films]
    first_alike = np.array([pads.index(pad) for pad in pads])[plan.scenes.film_index]
    numbers = np.arange(len(plan.scenes))[rows]
    for rows_of_group in equal_row_groups(plan.term_set_index[rows], first_alike[rows]):
        first = numbers[rows_of_group[0]]
        film = films[plan.scenes.film_index[first]]
        yield int(plan.term_set_index[first]), film, numbers[rows_of_group]


def _needed_points(
    plan: SolvePlan,
    rows: Rows,
    film: Film,
    *,
    tolerance: float,
    part_of_tolerance: float,
    step: int,
) -> np.ndarray:
    """Unknowns nx, ny and instants nt of scenes like a film's that leave a share of the tolerance.

    Below them, in (7, n), whether half is enough along x, y, and nodes along them without which a
    grid would not see the profile.

    Time: powers of 1/(1 + ε sin T) have harmonics that decay like ρ^k, ρ = ε / (1 + √(1 − ε²)).

    Args:
        step: of which unknowns along the axes are multiples, FAST_NODE_MULTIPLE or
            MIN_NODE_MULTIPLE.
    """
    scenes = plan.scenes if isinstance(rows, slice) else plan.scenes[rows]
    terms = plan.term_sets[plan.term_set_index[rows][0]]
    digits = log10(1 / (part_of_tolerance * tolerance))
    outline, aspect = (
        _coordinate_outline(film.pad, terms),
        film.pad.length_y_m / film.pad.length_x_m,
    )
    nodes = nodes_for_profile(plan, tolerance=tolerance)[rows].T
    curvature = plan.profile_resolution(allowed_profile_error(tolerance)).curvature[rows].T
    folds = np.array([plan.fold_x[rows], plan.fold_y[rows]])
    epsilon, sigma, bend = effective_gap_parameters(scenes)
    moving = np.maximum(epsilon, TINY_DENOMINATOR)  # of films at rest, too, there are logarithms
    ratio = moving / (1 + np.sqrt(1 - epsilon**2))
    left = np.minimum(
        log(TIME_ERROR_FRACTION / 3), log(TIME_ERROR_PER_EPSILON_SQUARED) + 2 * np.log(moving)
    )
    instants = np.where(epsilon > 0, (log(tolerance) + left) / np.log(ratio), MIN_TIME_POINTS)
    instants += 4.0 * (sigma * max(1.0, aspect) ** 2 < INCOMPRESSIBLE_SIGMA)
    slow: Any = 1.0
    layers = sigma
    layer_x = layers
    if terms:  # without, no layer but the squeezing's counts, and nothing lags
        if unknown_field_count(terms) > 1:
            slow = np.minimum(equation_numbers(scenes, terms)["slow"], 1.0)
        layers = max_layer_sigma_factor(scenes, terms, sigma=sigma) * sigma
        sliding = (np.abs(scenes.bearing_number) / (1 - epsilon)) ** 2
        layer_x = np.maximum(layers, SLIDING_LAYER_SIGMA_FACTOR * sliding)
    nt = np.minimum(
        4 * np.ceil(np.maximum(MIN_TIME_POINTS / slow, instants) / 4), MAX_FIRST_GRID_TIME_POINTS
    )
    layer_y, fold_factors = layers * aspect**2, 1.0 + folds
    # Zeros of the gap at its narrowest, 1 − ε + ε c X²/2, off the middle.
    width = np.sqrt(2 * (1 - epsilon) / np.maximum(epsilon * (curvature + bend), TINY_DENOMINATOR))
    if outline:
        layer_x = layer_x * outline.edge_jacobian_range[1] * (2 * outline.edge_mu) ** 2
        along, across = folds if outline.turned else folds[::-1]
        fold_factors = np.array([1.0 + along, (1 + along) * (1 + across)])
    wanted = _nodes_for_layers(digits, sigma=np.array([layer_x, layer_y]), width=width)
    if outline:
        wanted[1] = _nodes_around_outline(digits, width[1], outline)
    most = np.where(fold_factors > 1, MAX_FIRST_GRID_FOLDED_NODES, MAX_FIRST_GRID_NODES)
    unknowns = np.minimum(step * np.ceil(np.maximum(nodes, wanted) / fold_factors / step), most)
    if is_radial(terms):
        unknowns[1] = 1  # which stands for all around
    return np.concatenate([unknowns, nt[None], folds, nodes])


def _nodes_for_layers(digits: float, *, sigma: np.ndarray, width: np.ndarray) -> np.ndarray:
    """Nodes across the pad for a edge layer and for a narrow gap, whichever wants more.

    A Chebyshev grid resolves a layer of width √(2/σ) with a number of nodes proportional to
    σ^(1/4), the factor growing with the wanted digits (fitted to the centred sinc's errors). The
    gap's zeros ±iδ off the middle slow the convergence to that of the ellipse through them,
    r = 2δ + √(1 + 4δ²) per node (Trefethen 2000, ch. 5); the force, being a mean, converges with
    about the power 1.6 of it (fitted).
    """
    layer = 7 + 0.36 * digits * np.maximum(sigma, 1.0) ** 0.25
    return np.maximum(layer, 4 + digits * log(10) / (1.6 * np.arcsinh(2 * width)))


def _nodes_around_outline(digits: float, width: np.ndarray, outline: Outline) -> np.ndarray:
    """Nodes around an outline.

    The layer's width along the edge goes with the area behind a point, which has no zero nearer to
    real ν than about the edge's μ; the gap has those of ``_nodes_for_layers``. Coefficients
    fall by as much for each of half the nodes.
    """
    return 8 + digits * log(10) / (0.8 * np.minimum(outline.analyticity_width, width))


@lru_cache(maxsize=4096)
def _grid_sequence(
    points: tuple[float, ...], outline: Outline | None, capacity: float, step: int
) -> tuple[Grid, ...]:
    """A grid of ``_needed_points``, one that starts it, if that pays, and a finer one.

    The finer one tells the grid's error. The grid is as much coarser than asked for as it takes for
    a finer one to have room.
    """
    nx, ny, nt, fold_x, fold_y, *nodes = points
    first = Grid(int(nx), int(ny), int(nt), bool(fold_x), bool(fold_y), outline)
    while (finer := finer_grid(first, capacity=capacity, step=step)) is None:
        if not first.has_min_nodes(*nodes):
            break
        nx, ny = (step * (5 * points // (6 * step)) for points in (first.nx, first.ny))
        first = _resized_grid(
            first, nx=nx, ny=ny, nt=max(MIN_TIME_POINTS, 4 * (5 * first.nt // 24))
        )
    start = start_grid(first, step) if first.unknown_count >= MIN_UNKNOWNS_WITH_START else None
    # What does not see the profile is no guess.
    starts = [start] if start and start.has_min_nodes(*nodes) else []
    return *starts, first, *([finer] if finer else [])


def start_grid(grid: Grid, step: int) -> Grid | None:
    """A coarse grid whose state is a cheap first guess on ``grid``; None where it is small already.

    A solve from rest takes about twice the iterations of one from a guess.
    """
    start = _resized_grid(
        grid,
        nx=_start_grid_points(grid.nx, step, fold=grid.fold_x),
        ny=_start_grid_points(grid.ny, step, fold=grid.fold_y),
        nt=max(MIN_TIME_POINTS, 4 * ceil(START_GRID_POINTS_FRACTION * grid.nt / 4)),
    )
    return start if start.unknown_count < 0.5 * grid.unknown_count else None


def _resized_grid(grid: Grid, *, nx: int, ny: int, nt: int) -> Grid:
    """A grid with other numbers of points; that along a radius keeps its one unknown around."""
    return replace(grid, nx=nx, ny=1 if grid.is_radial else ny, nt=nt)


def _start_grid_points(points: int, step: int, *, fold: bool) -> int:
    return max(4 if fold else 8, step * round(START_GRID_POINTS_FRACTION * points / step))


def profile_error_ratio(
    plan: SolvePlan,
    coarse: tuple[int, int],
    fine: tuple[int, int],
    *,
    tolerance: float,
    rows: Rows = slice(None),
) -> np.ndarray:
    """Factors by which what is missed of profiles falls from nodes to nodes, or degree to degree.

    0 if the fine ones miss next to nothing: then it is not the profile that changes the force.

    Args:
        coarse, fine: nodes across the pad along x and y (``Grid.across``).
        rows: which of the scenes; default all.
    """

    def error_ratio_of_rows(rows: Rows) -> np.ndarray:
        least = NEGLIGIBLE_ERROR_PER_TOLERANCE * tolerance
        samples = plan.profile_resolution(least)
        missed, before = (
            samples.error_with_node_counts(fine, rows),
            samples.error_with_node_counts(coarse, rows),
        )
        falls = np.divide(missed, before, out=np.zeros_like(missed), where=missed > least)
        return np.asarray(falls.max(axis=1))

    if len(plan.scenes) > MAX_CACHED_POSITIONS:
        return error_ratio_of_rows(rows)
    return plan.compute_cached(
        "fall", lambda *_: error_ratio_of_rows(slice(None)), coarse, fine, tolerance
    )[rows]


@lru_cache(maxsize=4096)
def finer_grid(
    grid: Grid, *, capacity: float = MAX_UNKNOWNS, step: int = FAST_NODE_MULTIPLE
) -> Grid | None:
    """The next grid of a scene's sequence, finer in every direction; None past the limits.

    In every direction, because the difference between two grids shows no error that both share.
    """
    finer = _resized_grid(
        grid,
        nx=grid.nx + _nodes_to_add(grid.nx, step, fold=grid.fold_x),
        ny=grid.ny + _nodes_to_add(grid.ny, step, fold=grid.fold_y),
        nt=grid.nt + _nodes_to_add(grid.nt, FAST_NODE_MULTIPLE, fold=False),
    )
    if (
        max(finer.x.full_point_count, finer.y.full_point_count) > MAX_NODES_ACROSS
        or finer.nt > MAX_TIME_POINTS
    ):
        return None
    return finer if finer.unknown_count <= capacity else None


def _nodes_to_add(points: int, step: int, *, fold: bool) -> int:
    """About a fifth of the points, in steps; never less than four nodes across the pad."""
    least = 1 if fold else FAST_NODE_MULTIPLE // step
    return step * max(least, round(points / 5 / step))


def effective_gap_parameters(scenes: Scenes) -> tuple[np.ndarray, np.ndarray, np.ndarray | float]:
    """Scenes' gaps as first grids go by them: ε, σ, and what the gap adds to a profile's curvature.

    A gap that is shaped at rest is as hard as its narrowest place, and as closed, everywhere.
    """
    if scenes.is_flat:
        return scenes.epsilon, scenes.sigma, 0.0
    flat = scenes.film_value_column(lambda film: film.pad.gap.flat)
    crown_m = scenes.film_value_column(lambda film: abs(film.pad.gap.crown_m))
    bend = (
        8
        * crown_m
        / scenes.h0_m
        / np.maximum(scenes.epsilon, TINY_DENOMINATOR)
        * (scenes.epsilon > 0)
    )
    least = np.minimum(1.0, scenes.static_gap_ratio_range[0])
    sigma = scenes.sigma / least**2
    sigma = np.where(sigma < NONUNIFORM_THIN_LAYER_SIGMA, sigma, sigma / least**2)
    return np.where(flat, scenes.epsilon, scenes.closure), sigma, bend


def min_convergence_ratio(scenes: Scenes, terms: Terms) -> np.ndarray:
    """Lower bounds on the convergence ratios from grid to grid, (n,)."""
    _, sigma, _ = effective_gap_parameters(scenes)
    most, ratio = ERRATIC_CONVERGENCE_SIGMA, THIN_LAYER_CONVERGENCE_RATIO
    if have_velocity_terms(terms):
        most, ratio = ERRATIC_VELOCITY_SIGMA, THIN_LAYER_VELOCITY_CONVERGENCE_RATIO
    return ratio * (sigma * np.maximum(1.0, scenes.aspect) ** 2 > most)
