"""D-optimal designs of nonlinear experiments: the points at which simulations teach most.

A design of N points has the matrix F of derivatives of the response with respect to the
parameters (paper eq. 5); |det(F'F)^-1| (eq. 11) is the squared volume of the parameters'
uncertainty and is made small. The paper adds the inverse distances between the points (eq. 12),
to keep them apart. Nothing here knows a particular model: a response enters through its gradient,
a function from points, shape (n, k), to derivatives, shape (n, p). What several searches have in
common are patterns of points, and their union is a design too.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import Bounds, linear_sum_assignment, minimize

from squeezefilm.designs.optimal import GradientFunction, log_determinant
from squeezefilm.designs.space import Array, CoordinateFunction, Space, pair_distances
from squeezefilm.errors import InputError
from squeezefilm.models.search import genetic_search

SINGULAR_CRITERION_VALUE = 1e100
"""Value of a criterion where parameters cannot be told apart or points coincide."""

GENETIC_POPULATION, GENETIC_GENERATIONS = 100, 60
RANDOM_KICK_COUNT = 2
RANDOM_KICK_SIZE = 0.05
"""Descents from a design kicked by so much, in unit factors, before a search is believed."""
EQUAL_CRITERION_TOLERANCE = 1e-9
"""Share up to which two values of a criterion are one: what rounding makes of a determinant."""
TRIAL_POINTS_PER_RATIO_LINE = 101
"""Places tried on a line of equally good points."""
SAME_POINT_DISTANCE = 0.05
"""Distance in unit factors up to which two points are one."""


def inverse_determinant(derivatives: ArrayLike) -> Array:
    """|det(F'F)^-1| (paper eq. 11) of designs with derivatives F of shape (..., N, p).

    From the triangular factor of F, whose condition is the root of that of F'F.
    SINGULAR_CRITERION_VALUE where F'F is singular. Derivatives that are undefined (NaN) count as no
    information.
    """
    derivatives = np.asarray(derivatives, dtype=float)
    points, parameters = derivatives.shape[-2:]
    if points < parameters:
        return np.full(derivatives.shape[:-2], SINGULAR_CRITERION_VALUE)
    usable = np.where(np.isfinite(derivatives), derivatives, 0.0)
    triangle = np.linalg.qr(usable, mode="r")
    determinant = np.prod(np.diagonal(triangle, axis1=-2, axis2=-1), axis=-1) ** 2
    return 1 / np.maximum(determinant, 1 / SINGULAR_CRITERION_VALUE)


def sum_of_inverse_distances(points: ArrayLike) -> Array:
    """Sum of 1/|xi_i - xi_j| over all pairs of points (in eq. 12), shape (..., N, k) -> (...).

    SINGULAR_CRITERION_VALUE where two points coincide.
    """
    return np.sum(1 / np.maximum(pair_distances(points), 1 / SINGULAR_CRITERION_VALUE), axis=-1)


def d_efficiency(derivatives: ArrayLike, optimal: ArrayLike) -> float:
    """D-efficiency of a design, (det M / det M_opt)^(1/p) with M = F'F/N; one is the best.

    Both arguments are derivatives F, shape (N, p), with numbers of points that may differ.
    """
    gain = log_determinant(derivatives) - log_determinant(optimal)
    return float(np.exp(gain[0] / np.shape(derivatives)[-1]))


@dataclass(frozen=True)
class Criterion:
    """The paper's criterion of a design, to be minimised.

    The determinant (11) alone; plus the inverse distances of (12) where `distance_coordinates`
    gives the coordinates to take them in; and, where `separation` is set, only for designs whose
    points are at least that far apart in the coordinates `separation_coordinates`
    (SINGULAR_CRITERION_VALUE for any other).
    """

    model_derivatives: GradientFunction
    space: Space
    distance_coordinates: CoordinateFunction | None = None
    separation_coordinates: CoordinateFunction | None = None
    separation: float = 0.0

    def derivatives(self, designs: Array) -> Array:
        """F of designs of shape (..., N, k), shape (..., N, p)."""
        rows = self.model_derivatives(designs.reshape(-1, designs.shape[-1]))
        return rows.reshape(*designs.shape[:-1], rows.shape[-1])

    def value(self, designs: Array) -> Array:
        """Value of designs of shape (..., N, k), shape (...)."""
        value = inverse_determinant(self.derivatives(designs))
        if self.distance_coordinates is not None:
            value = value + sum_of_inverse_distances(self.distance_coordinates(designs))
        far = self.distances_beyond_separation(designs).min(axis=-1) >= -1e-9
        return np.where(far, np.minimum(value, SINGULAR_CRITERION_VALUE), SINGULAR_CRITERION_VALUE)

    def distances_beyond_separation(self, designs: Array) -> Array:
        """Distance of each pair of points beyond the separation, shape (..., N(N-1)/2)."""
        if self.separation_coordinates is None:
            return np.zeros((*designs.shape[:-2], 1))
        return pair_distances(self.separation_coordinates(designs)) - self.separation


@dataclass(frozen=True, eq=False)
class Design:
    """A design found by a search: its points, shape (N, k), in the factors' own units.

    value is the criterion's.
    """

    points: Array
    value: float


def search_design(criterion: Criterion, points: int, *, seed: int) -> Design:
    """One search for the best design of so many points: genetic algorithm, then a local descent.

    The descent can end on a saddle, halfway along a line of equal hv/h0 on which the criterion
    hardly changes. So it is repeated from points kicked off the design found, and the best is kept.
    Equal arguments give an equal result. Raises InputError where no design with a finite
    criterion was found.
    """
    space = criterion.space
    shape = (points, len(space.names))
    rough = genetic_search(
        lambda flat: criterion.value(space.from_unit(flat.reshape(-1, *shape))),
        lower=np.zeros(np.prod(shape)),
        upper=np.ones(np.prod(shape)),
        seed=seed,
        population=GENETIC_POPULATION,
        first=10 * GENETIC_POPULATION,
        generations=GENETIC_GENERATIONS,
    )
    best = local_descent(criterion, space.from_unit(rough.x.reshape(shape)))
    for kick in np.random.default_rng(seed).normal(
        scale=RANDOM_KICK_SIZE, size=(RANDOM_KICK_COUNT, *shape)
    ):
        start = space.from_unit(np.clip(space.to_unit(best.points) + kick, 0, 1))
        if float(criterion.value(start)) < SINGULAR_CRITERION_VALUE:
            best = min(best, local_descent(criterion, start), key=lambda design: design.value)
    return best


def local_descent(criterion: Criterion, points: Array) -> Design:
    """The local optimum near a design, shape (N, k).

    Sequential quadratic programming in unit factors, on the logarithm of the criterion, repeated
    until it no longer falls. Raises InputError for a design whose criterion is not finite.
    """
    space = criterion.space
    start = float(criterion.value(points))
    if start >= SINGULAR_CRITERION_VALUE:
        raise InputError(
            "design: F'F is singular, or points are closer than allowed; give more points than "
            "parameters, a wider box or a smaller separation"
        )

    def designs_from_unit(unit: Array) -> Array:
        return space.from_unit(unit.reshape(*unit.shape[:-1], *points.shape))

    # The separation is left to the constraint: a wall in the objective would stop the descent.
    smooth = replace(criterion, separation_coordinates=None)

    def log_criterion(unit: Array) -> Array:
        return np.log(smooth.value(designs_from_unit(unit)) / start)

    def separation_constraints(unit: Array) -> Array:
        return criterion.distances_beyond_separation(designs_from_unit(unit))

    apart = {
        "type": "ineq",
        "fun": separation_constraints,
        "jac": lambda u: _value_and_gradient(separation_constraints, u)[1],
    }
    best, value = np.clip(space.to_unit(points).ravel(), 0, 1), 0.0
    for _ in range(20):
        step = minimize(
            lambda u: _value_and_gradient(log_criterion, u),
            best,
            jac=True,
            method="SLSQP",
            bounds=Bounds(np.zeros(len(best)), np.ones(len(best))),
            constraints=[] if criterion.separation_coordinates is None else [apart],
            options={"ftol": 1e-14, "maxiter": 500},
        )
        unit = np.clip(step.x, 0, 1)
        fell = value - float(np.log(criterion.value(designs_from_unit(unit)) / start))
        if fell > 0:
            best, value = unit, value - fell
        if fell < 1e-11:
            break
    designs_found = designs_from_unit(best)
    return Design(_sorted_points(designs_found, space), float(criterion.value(designs_found)))


def spread_along_ratio_lines(
    criterion: Criterion, design: Design, *, ratio: tuple[str, str]
) -> Design:
    """Return the design with distant points among equally good ones, as eq. 12 would choose.

    A response that knows two factors by their ratio alone, here named, is the same all along a line
    of equal ratio: the determinant leaves a point free there, and rounding would choose its place.
    Point by point, of TRIAL_POINTS_PER_RATIO_LINE on its line those are taken at which the
    criterion is the same, and of them the one with the least sum of inverse distances in unit
    factors.
    """
    space = criterion.space
    columns = [space.names.index(name) for name in ratio]
    low, high = space.lower_and_upper_limits[:, columns]
    points = design.points
    for number, point in enumerate(points):
        both = point[columns]
        ends = np.max(low / both), np.min(high / both)
        scale = np.append(1.0, np.linspace(*ends, TRIAL_POINTS_PER_RATIO_LINE))
        trials = np.repeat(points[None], len(scale), axis=0)
        trials[:, number, columns] = np.clip(scale[:, None] * both, low, high)
        equal = criterion.value(trials) <= design.value * (1 + EQUAL_CRITERION_TOLERANCE)
        distances = np.where(equal, sum_of_inverse_distances(space.to_unit(trials)), np.inf)
        points = trials[int(np.argmin(distances))] if equal.any() else points
    return replace(design, points=_sorted_points(points, space))


def _value_and_gradient(function: Callable[[Array], Array], unit: Array) -> tuple[Array, Array]:
    """Value, and derivative by differences that stay within [0, 1], in one call of the function.

    It takes a stack of arguments.
    """
    shift = 1e-6 * np.eye(len(unit))
    above, below = np.minimum(unit + shift, 1), np.maximum(unit - shift, 0)
    width = np.diagonal(above - below)
    value = function(np.concatenate([unit[None], above, below]))
    rise = value[1 : len(unit) + 1] - value[len(unit) + 1 :]
    return value[0], (rise.T / width).squeeze()


def _sorted_points(points: Array, space: Space) -> Array:
    """Points in a fixed order: by the first factor, then the second, and so on."""
    return points[np.lexsort(np.round(space.to_unit(points), 4).T[::-1])]


@dataclass(frozen=True, eq=False)
class DesignPattern:
    """Designs that are the same but for the order of their points.

    design is the best of them, design_indices are their places among all designs.
    """

    name: str
    design: Design
    design_indices: tuple[int, ...]


@dataclass(eq=False)
class PatternPoint:
    """One place in the space of the experiment, shape (k,), and the names of the patterns that have
    a point there, or the word augmentation."""

    point: Array
    pattern_names: list[str]


def find_design_patterns(designs: Sequence[Design], space: Space) -> list[DesignPattern]:
    """Designs gathered into patterns, the best first, named A, B, C ...

    Two designs are the same pattern where their points can be paired so that no pair is further
    apart than SAME_POINT_DISTANCE. From the best design on, each joins the first pattern whose best
    design it equals in this sense, or starts a new one.
    """
    groups: dict[int, list[int]] = {}
    for index in np.argsort([design.value for design in designs], kind="stable").tolist():
        points = designs[index].points
        same = (
            best
            for best in groups
            if _largest_pair_distance(points, designs[best].points, space) <= SAME_POINT_DISTANCE
        )
        groups.setdefault(next(same, index), []).append(index)
    return [
        DesignPattern(chr(ord("A") + number), designs[best], tuple(group))
        for number, (best, group) in enumerate(groups.items())
    ]


def distinct_support_points(patterns: Sequence[DesignPattern], space: Space) -> list[PatternPoint]:
    """The distinct points of all patterns, each with the patterns it occurs in.

    Of points that are one the first pattern's is kept.
    """
    regions: list[PatternPoint] = []
    for pattern in patterns:
        for point in pattern.design.points:
            gaps = [np.linalg.norm(space.to_unit(point) - space.to_unit(r.point)) for r in regions]
            if min(gaps, default=np.inf) > SAME_POINT_DISTANCE:
                regions.append(PatternPoint(point, [pattern.name]))
            elif pattern.name not in (near := regions[int(np.argmin(gaps))]).pattern_names:
                near.pattern_names.append(pattern.name)
    return regions


def add_corner_points(
    criterion: Criterion, regions: Sequence[PatternPoint], points: int
) -> list[PatternPoint]:
    """Regions extended to so many points, each time by the corner with the least criterion.

    The points given stay where they are. A free point would settle next to one that is there
    already, the determinant outweighing the distances of (12) by far; a simulation has no scatter,
    and a near replicate teaches nothing.
    Raises InputError where there are more regions than points wanted, or no corner is left.
    """
    if len(regions) > points:
        raise InputError(
            f"design: {len(regions)} distinct points were found, more than the {points} wanted; "
            f"ask for at least {len(regions)}"
        )
    # Without distances in the criterion a replicate would be as good as any other point.
    spaced = replace(
        criterion, distance_coordinates=criterion.distance_coordinates or criterion.space.to_unit
    )
    candidates, extended = criterion.space.levels(2), list(regions)
    while len(extended) < points:
        kept = [region.point for region in extended]
        trials = np.array([[*kept, corner] for corner in candidates])
        values = spaced.value(trials)
        if values.min() >= SINGULAR_CRITERION_VALUE:
            raise InputError(f"design: no corner is left for one of {points} points; ask for fewer")
        extended.append(PatternPoint(candidates[int(np.argmin(values))], ["augmentation"]))
    return extended


def _largest_pair_distance(points: Array, others: Array, space: Space) -> float:
    """Largest distance within pairs of points of two designs, paired by least squares."""
    if len(points) != len(others):
        return float("inf")
    gaps = np.linalg.norm(space.to_unit(points)[:, None] - space.to_unit(others)[None], axis=-1)
    return float(gaps[linear_sum_assignment(gaps**2)].max())
