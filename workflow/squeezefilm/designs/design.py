"""D-optimal designs of nonlinear experiments: the points at which simulations teach most.

A design of N points has the matrix F of derivatives of the response with respect to the
parameters (paper eq. 5); |det(F'F)^-1| (eq. 11) is the squared volume of the parameters'
uncertainty and is made small. The paper adds the inverse distances between the points (eq. 12),
to keep them apart. Nothing here knows a particular model: a response enters through its gradient,
a function from points, shape (n, k), to derivatives, shape (n, p).

Coordinates. A distance between points needs a common measure of their factors; eq. (12) does not
name it and the outcome depends on it, so it is always given by name (see `coordinates`).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import Bounds, linear_sum_assignment, minimize

from squeezefilm.designs.exact_design import exchange
from squeezefilm.io.errors import InputError
from squeezefilm.models.search import genetic_search

Array = NDArray[np.float64]
Gradient = Callable[[Array], Array]
Coordinates = Callable[[Array], Array]

SINGULAR = 1e100
"""Value of a criterion where parameters cannot be told apart or points coincide."""

SCALINGS = ("unit", "micrometre", "metre", "scene")


KICKS = 2
KICK = 0.05
"""Descents from a design kicked by so much, in unit factors, before a search is believed."""


@dataclass(frozen=True)
class Box:
    """The space of the experiment: one lower and one upper limit for each named factor."""

    names: tuple[str, ...]
    lower: tuple[float, ...]
    upper: tuple[float, ...]

    def __post_init__(self) -> None:
        if not len(self.names) == len(self.lower) == len(self.upper) > 0:
            raise InputError("box: give one name, one lower and one upper limit for each factor")
        for name, low, high in zip(self.names, self.lower, self.upper, strict=True):
            if not (np.isfinite(low) and np.isfinite(high) and low < high):
                raise InputError(
                    f"box: {name} goes from {low} to {high}; the lower limit must be less than "
                    "the upper one and both finite"
                )

    def to_unit(self, points: ArrayLike) -> Array:
        """Points, shape (..., k), with each factor scaled to [0, 1]."""
        low, high = np.array(self.lower), np.array(self.upper)
        return (np.asarray(points, dtype=float) - low) / (high - low)

    def from_unit(self, unit: ArrayLike) -> Array:
        """The inverse of to_unit; the ends of [0, 1] give the limits exactly."""
        low, high, unit = np.array(self.lower), np.array(self.upper), np.asarray(unit, dtype=float)
        return low * (1 - unit) + high * unit


def coordinates(scaling: str, box: Box) -> Coordinates:
    """The coordinates in which distances between points are taken.

    unit: every factor scaled to [0, 1]; micrometre, metre: the factors as they are, all of them
    lengths; scene: h0 and hv scaled to [0, 1], and the polar position as x and y over the largest
    radius, so that two angles at the centre are one and the same scene.
    Raises InputError for an unknown name, or one that does not suit the box's factors.
    """
    if scaling not in SCALINGS:
        raise InputError(f"scaling {scaling!r} is unknown; known are {', '.join(SCALINGS)}")
    if scaling == "unit":
        return box.to_unit
    if scaling == "scene":
        return _scene_coordinates(box)
    if not all(name.endswith("_m") for name in box.names):
        raise InputError(f"scaling {scaling!r} is for factors that are lengths; use unit or scene")
    per_metre = {"micrometre": 1e6, "metre": 1.0}[scaling]
    return lambda points: np.asarray(points, dtype=float) * per_metre


def _scene_coordinates(box: Box) -> Coordinates:
    if box.names != ("h0_m", "hv_m", "phi_r_m", "phi_deg"):
        raise InputError(
            "scaling 'scene' is for the factors h0_m, hv_m, phi_r_m, phi_deg in this order; "
            f"got {', '.join(box.names)}"
        )

    def of(points: Array) -> Array:
        points = np.asarray(points, dtype=float)
        radius = points[..., 2] / box.upper[2]
        angle = np.deg2rad(points[..., 3])
        position = np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=-1)
        return np.concatenate([box.to_unit(points)[..., :2], position], axis=-1)

    return of


def information_determinant(derivatives: ArrayLike) -> Array:
    """det(F'F) of designs with derivatives F of shape (..., N, p); zero where N < p.

    From the triangular factor of F, whose condition is the root of that of F'F.
    Derivatives that are undefined (NaN) count as no information.
    """
    derivatives = np.asarray(derivatives, dtype=float)
    points, parameters = derivatives.shape[-2:]
    if points < parameters:
        return np.zeros(derivatives.shape[:-2])
    usable = np.where(np.isfinite(derivatives), derivatives, 0.0)
    triangle = np.linalg.qr(usable, mode="r")
    return np.prod(np.diagonal(triangle, axis1=-2, axis2=-1), axis=-1) ** 2


def inverse_determinant(derivatives: ArrayLike) -> Array:
    """|det(F'F)^-1| (paper eq. 11), shape (...); SINGULAR where F'F is singular."""
    determinant = np.asarray(information_determinant(derivatives))
    return 1 / np.maximum(determinant, 1 / SINGULAR)


def pair_distances(points: ArrayLike) -> Array:
    """Distance between every two points of a design, shape (..., N, k) -> (..., N(N-1)/2).

    points are in the coordinates that distances are taken in.
    """
    points = np.asarray(points, dtype=float)
    i, j = np.triu_indices(points.shape[-2], k=1)
    return np.linalg.norm(points[..., i, :] - points[..., j, :], axis=-1)


def inverse_distances(points: ArrayLike) -> Array:
    """Sum of 1/|xi_i - xi_j| over all pairs of points (in eq. 12), shape (..., N, k) -> (...).

    SINGULAR where two points coincide.
    """
    return np.sum(1 / np.maximum(pair_distances(points), 1 / SINGULAR), axis=-1)


def d_efficiency(derivatives: ArrayLike, optimal: ArrayLike) -> float:
    """D-efficiency of a design, (det M / det M_opt)^(1/p) with M = F'F/N; one is the best.

    Both arguments are derivatives F, shape (N, p), with numbers of points that may differ.
    """
    parameters = np.shape(derivatives)[-1]

    def root(f: ArrayLike) -> float:
        return float(information_determinant(f) ** (1 / parameters) / np.shape(f)[-2])

    return root(derivatives) / root(optimal)


@dataclass(frozen=True)
class Criterion:
    """What a design is judged by: small is good.

    The determinant (11) alone; plus the inverse distances of (12) where `distance` gives the
    coordinates to take them in; and, where `separation` is set, only for designs whose points are
    at least that far apart in the coordinates `apart` (SINGULAR for any other).
    """

    gradient: Gradient
    box: Box
    distance: Coordinates | None = None
    apart: Coordinates | None = None
    separation: float = 0.0

    def derivatives(self, designs: Array) -> Array:
        """F of designs of shape (..., N, k), shape (..., N, p)."""
        rows = self.gradient(designs.reshape(-1, designs.shape[-1]))
        return rows.reshape(*designs.shape[:-1], rows.shape[-1])

    def value(self, designs: Array) -> Array:
        """Value of designs of shape (..., N, k), shape (...)."""
        value = inverse_determinant(self.derivatives(designs))
        if self.distance is not None:
            value = value + inverse_distances(self.distance(designs))
        return np.where(self.spare(designs) >= -1e-9, np.minimum(value, SINGULAR), SINGULAR)

    def spare(self, designs: Array) -> Array:
        """By how much the closest pair of points exceeds the separation, shape (...)."""
        if self.apart is None:
            return np.zeros(designs.shape[:-2])
        return np.min(pair_distances(self.apart(designs)), axis=-1) - self.separation


@dataclass(frozen=True, eq=False)
class Design:
    """A design found by a search: its points, shape (N, k), in the factors' own units.

    value is the criterion's, inverse_determinant the part (11) of it.
    """

    points: Array
    value: float
    inverse_determinant: float


@dataclass(frozen=True, eq=False)
class Pattern:
    """Designs that are the same but for the order of their points.

    design is the best of them, count their number, excess its value above the best pattern's.
    """

    name: str
    design: Design
    count: int
    excess: float


@dataclass(frozen=True, eq=False)
class Region:
    """One place in the space of the experiment, shape (k,), and the patterns that have a point
    there; no pattern where the point was added by augmentation."""

    point: Array
    patterns: tuple[str, ...]

    @property
    def origin(self) -> str:
        """The patterns' names, or the word augmentation."""
        return " and ".join(self.patterns) or "augmentation"


def search_design(
    criterion: Criterion,
    points: int,
    *,
    seed: int,
    population: int = 100,
    generations: int = 60,
) -> Design:
    """One search for the best design of so many points: genetic algorithm, then a local descent.

    The descent can end on a saddle, halfway along a line of equal hv/h0 on which the criterion
    hardly changes. So it is repeated from points kicked off the design found, and the best is kept.
    Equal arguments give an equal result. Raises InputError where no design with a finite
    criterion was found.
    """
    factors = len(criterion.box.names)
    found = genetic_search(
        lambda flat: criterion.value(criterion.box.from_unit(flat.reshape(-1, points, factors))),
        lower=np.zeros(points * factors),
        upper=np.ones(points * factors),
        seed=seed,
        population=population,
        first=10 * population,
        generations=generations,
    )
    box = criterion.box
    best = refine(criterion, box.from_unit(found.x.reshape(points, factors)))
    kicks = np.random.default_rng(seed).normal(scale=KICK, size=(KICKS, points, factors))
    for kick in kicks:
        start = box.from_unit(np.clip(box.to_unit(best.points) + kick, 0, 1))
        if float(criterion.value(start)) < SINGULAR:
            best = min(best, refine(criterion, start), key=lambda design: design.value)
    return best


def refine(criterion: Criterion, points: Array, *, fixed: int = 0) -> Design:
    """The local optimum near a design, shape (N, k); its first `fixed` points stay where they are.

    Sequential quadratic programming in unit factors, on the logarithm of the criterion, repeated
    until it no longer falls. Raises InputError for a design whose criterion is not finite.
    """
    box, shape = criterion.box, points[fixed:].shape
    kept = points[:fixed]
    start = float(criterion.value(points))
    if start >= SINGULAR:
        raise InputError(
            "design: F'F is singular, or points are closer than allowed; give more points than "
            "parameters, a wider box or a smaller separation"
        )

    def designs(unit: Array) -> Array:
        moved = box.from_unit(unit.reshape(*unit.shape[:-1], *shape))
        return np.concatenate(
            [np.broadcast_to(kept, (*unit.shape[:-1], *kept.shape)), moved], axis=-2
        )

    # The separation is left to the constraint: a wall in the objective would stop the descent.
    smooth = replace(criterion, apart=None)

    def objective(unit: Array) -> Array:
        return np.log(smooth.value(designs(unit)) / start)

    constraints: list[Any] = []
    if criterion.apart is not None:
        apart, separation = criterion.apart, criterion.separation

        def spares(unit: Array) -> Array:
            return pair_distances(apart(designs(unit))) - separation

        constraints.append({"type": "ineq", "fun": spares, "jac": lambda u: _slopes(spares, u)})
    best = np.clip(box.to_unit(points[fixed:]).ravel(), 0, 1)
    value = 0.0
    for _ in range(20):
        step = minimize(
            lambda u: float(objective(u)),
            best,
            jac=lambda u: _slopes(objective, u),
            method="SLSQP",
            bounds=Bounds(np.zeros(len(best)), np.ones(len(best))),
            constraints=constraints,
            options={"ftol": 1e-14, "maxiter": 500},
        )
        unit = np.clip(step.x, 0, 1)
        reached = float(np.log(criterion.value(designs(unit)) / start))
        fell = value - reached
        if fell > 0:
            best, value = unit, reached
        if fell < 1e-11:
            break
    found = designs(best)
    return Design(
        points=found if fixed else _sorted(found, box),
        value=float(criterion.value(found)),
        inverse_determinant=float(inverse_determinant(criterion.derivatives(found))),
    )


def find_patterns(designs: Sequence[Design], box: Box, *, threshold: float = 0.05) -> list[Pattern]:
    """Designs gathered into patterns, the best first, named A, B, C ...

    Two designs are the same pattern where their points can be paired so that no pair is further
    apart than the threshold, in unit factors. From the best design on, each joins the first
    pattern whose best design it equals in this sense, or starts a new one.
    """
    groups: list[list[Design]] = []
    for design in sorted(designs, key=lambda each: each.value):
        for group in groups:
            if _mismatch(design.points, group[0].points, box) <= threshold:
                group.append(design)
                break
        else:
            groups.append([design])
    return [
        Pattern(
            name=chr(ord("A") + index),
            design=group[0],
            count=len(group),
            excess=group[0].value - groups[0][0].value,
        )
        for index, group in enumerate(groups)
    ]


def find_regions(patterns: Sequence[Pattern], box: Box, *, threshold: float = 0.05) -> list[Region]:
    """The distinct points of all patterns, each with the patterns it occurs in.

    Points closer than the threshold in unit factors are one; the first pattern's point is kept.
    """
    regions: list[Region] = []
    for pattern in patterns:
        for point in pattern.design.points:
            gaps = [
                float(np.linalg.norm(box.to_unit(point) - box.to_unit(region.point)))
                for region in regions
            ]
            if gaps and min(gaps) <= threshold:
                near = int(np.argmin(gaps))
                known = regions[near].patterns
                names = known if pattern.name in known else (*known, pattern.name)
                regions[near] = Region(regions[near].point, names)
            else:
                regions.append(Region(point, (pattern.name,)))
    return regions


def augment(
    criterion: Criterion,
    regions: Sequence[Region],
    points: int,
    *,
    candidates: Array,
    refined: bool = False,
) -> list[Region]:
    """Regions extended to so many points, each time by the candidate with the least criterion.

    The points given stay where they are. candidates has shape (c, k): `corners(box)`, or a grid
    with refined=True for a point free to move in the whole box. The determinant outweighs the
    distances of (12) by far, so a free point settles next to a point that is there already; a
    simulation has no scatter, and a near replicate teaches nothing. Corners are told apart.
    Raises InputError where there are more regions than points wanted, or no candidate is left.
    """
    if len(regions) > points:
        raise InputError(
            f"design: {len(regions)} distinct points were found, more than the {points} wanted; "
            f"ask for at least {len(regions)}"
        )
    # Without distances in the criterion a replicate would be as good as any other point.
    spaced = replace(criterion, distance=criterion.distance or criterion.box.to_unit)
    extended = list(regions)
    while len(extended) < points:
        kept = np.array([region.point for region in extended])
        trials = np.concatenate(
            [np.broadcast_to(kept, (len(candidates), *kept.shape)), candidates[:, None]], axis=1
        )
        values = spaced.value(trials)
        if values.min() >= SINGULAR:
            raise InputError("design: no candidate is left for another point; give more candidates")
        added = trials[int(np.argmin(values))]
        if refined:
            added = refine(spaced, added, fixed=len(kept)).points
        extended.append(Region(added[-1], ()))
    return extended


def corners(box: Box) -> Array:
    """The corners of the space of the experiment, shape (2^k, k)."""
    return grid(box, 2)


def grid(box: Box, levels: int) -> Array:
    """Points of a regular grid with so many levels per factor, shape (levels^k, k)."""
    axes = np.meshgrid(*[np.linspace(0, 1, levels)] * len(box.names), indexing="ij")
    return box.from_unit(np.stack(axes, axis=-1).reshape(-1, len(box.names)))


def exchange_design(
    criterion: Criterion, points: int, *, levels: int, starts: int = 4, seed: int = 1
) -> Design:
    """The best design found on a fine grid, by exchange of points, then refined off the grid.

    By the determinant alone, with the separation where one is set, from a grid of so many levels
    per factor (see exact_design). It shares no step with search_design but the last refinement, and
    so serves to check it. Raises InputError where every start ended in a singular design.
    """
    candidates = grid(criterion.box, levels)
    found = exchange(
        criterion.derivatives(candidates),
        points,
        coordinates=criterion.apart and criterion.apart(candidates),
        separation=criterion.separation,
        starts=starts,
        seed=seed,
    )
    return refine(criterion, candidates[found.chosen])


def _slopes(function: Callable[[Array], Array], unit: Array, step: float = 1e-6) -> Array:
    """Derivative by differences that stay within [0, 1]; function takes a stack of arguments."""
    shift = step * np.eye(len(unit))
    above, below = np.minimum(unit + shift, 1), np.maximum(unit - shift, 0)
    width = np.diagonal(above - below)
    return ((function(above) - function(below)).T / width).squeeze()


def _sorted(points: Array, box: Box) -> Array:
    """Points in a fixed order: by the first factor, then the second, and so on."""
    return points[np.lexsort(np.round(box.to_unit(points), 4).T[::-1])]


def _mismatch(points: Array, others: Array, box: Box) -> float:
    """Largest distance within pairs of points of two designs, paired by least squares."""
    if len(points) != len(others):
        return float("inf")
    gaps = np.linalg.norm(box.to_unit(points)[:, None] - box.to_unit(others)[None], axis=-1)
    return float(gaps[linear_sum_assignment(gaps**2)].max())
