"""A periodic film at points of quadrature: its mean and first harmonics, and its extremes.

All answers that are means over film and period ask of the pressure no more than p₀ + p₁ sin T +
p₂ cos T at every point, for the gap that weighs them has no other harmonics.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from squeezefilm.film.outline import Outline
from squeezefilm.film.scene import Scene
from squeezefilm.reynolds.answers.rim_momentum import momentum_out
from squeezefilm.reynolds.effects.fields import lines_of
from squeezefilm.reynolds.grid import Grid
from squeezefilm.reynolds.spectral import axis, period

# Distance of the points whose gaps' difference is a slope, of the finger's length: waves as long as
# a tenth of it are missed by 4e-9, and as little is rounded where the surface hardly moves.
STEP = 3e-4
# Points each way of a closer look at an extreme, how much closer each is, and how many there are.
LOOK, CLOSER, LOOKS = 9, 3.0, 8
# Of a field, what rounding leaves of an odd one that is made even.
ROUNDED = 1e-9

QUARTERS = np.pi / 2 * np.arange(4)


@dataclass(frozen=True)
class Sample:
    """One film.

    Attributes:
        x, y: points across the pad in [0, 1], shape (Q,).
        weights: of the mean over the pad, sum 1.
        overpressure: P − 1 at the points and equidistant instants from phase 0, (Q, instants).
        largest, least: of P − 1 over pad and period.
        images: the places of each point's mirror images among the points, itself included.
        momentum_n: what leaves over the rim along the finger's x and y, of a gas with inertia.
    """

    scene: Scene
    x: np.ndarray
    y: np.ndarray
    weights: np.ndarray
    overpressure: np.ndarray
    largest: float
    least: float
    images: tuple[np.ndarray, ...]
    momentum_n: tuple[float, float] = (0.0, 0.0)

    @cached_property
    def phases(self) -> np.ndarray:
        return period(self.overpressure.shape[1]).nodes

    @cached_property
    def pressure(self) -> np.ndarray:
        """p₀, p₁, p₂, shape (3, Q)."""
        parts = np.stack([np.ones_like(self.phases), *_first(self.phases)])
        return np.asarray((self.overpressure @ parts.T).T / len(self.phases))

    @cached_property
    def gap(self) -> np.ndarray:
        """The gap over h0 likewise."""
        return motion(self.scene, self.x, self.y)

    @cached_property
    def slopes(self) -> tuple[np.ndarray, np.ndarray]:
        """The gap's derivatives along the finger's x and y, over its lengths: each (3, Q)."""
        return self._slope(STEP, 0.0), self._slope(0.0, STEP)

    def _slope(self, in_x: float, in_y: float) -> np.ndarray:
        """By a difference of fourth order, for which the profile is asked beyond the rim too."""
        far, near, after, beyond = (
            motion(self.scene, self.x + k * in_x, self.y + k * in_y) for k in (-2, -1, 1, 2)
        )
        return np.asarray((8 * (after - near) - (beyond - far)) / (12 * (in_x + in_y)))

    def symmetric(self, field: np.ndarray) -> np.ndarray:
        """What a mean with the pressure, even where the film is, sees of a field (..., Q)."""
        seen = np.mean([field[..., image] for image in self.images], axis=0)
        odd = np.abs(seen).max() < ROUNDED * np.abs(field).max()
        return np.zeros_like(field) if odd else np.asarray(seen)

    def mean(self, weight: np.ndarray) -> float:
        """⟨w (P − 1)⟩ over pad and period, for w₀ + w₁ sin T + w₂ cos T, shape (3, Q)."""
        return float(_product(weight, self.pressure) @ self.weights)

    def size(self, weight: np.ndarray) -> float:
        """Root of the mean square of such a weight."""
        return float(np.sqrt(_product(weight, weight) @ self.weights))


def _product(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Mean over the period of two fields of three parts, shape (Q,)."""
    return np.asarray(one[0] * other[0] + (one[1] * other[1] + one[2] * other[2]) / 2)


def _first(phases: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    return 2 * np.sin(phases), 2 * np.cos(phases)


def motion(scene: Scene, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """The gap over h0 at rest, its motion with sin T and with cos T, shape (3, ...)."""
    at_0, at_90, at_180, at_270 = np.moveaxis(scene.gap(x, y, QUARTERS), -1, 0)
    return np.stack([(at_90 + at_270) / 2, (at_90 - at_270) / 2, (at_0 - at_180) / 2])


def on_grid(scene: Scene, grid: Grid, unknowns: np.ndarray) -> Sample:
    """A film from its state on a grid, shape (fields, nx, ny, nt), at all nodes.

    Those of the rim and of mirror images are among them.
    """
    field = unknowns[0]
    if grid.outline:
        return _on_outline(scene, grid, field, grid.outline)
    for which, folded in enumerate((grid.x.folded, grid.y.folded)):
        if folded:  # the other half is its image
            field = np.concatenate([field, np.flip(field, axis=which)], axis=which)
    field = np.pad(field, [(1, 1), (1, 1), (0, 0)])
    along = [axis(each.full_points, folded=False) for each in (grid.x, grid.y)]
    weights = np.multiply.outer(*(lines_of(each).weights for each in along))
    places = np.arange(weights.size).reshape(weights.shape)
    images = [places]
    for which, folded in enumerate((grid.x.folded, grid.y.folded)):
        if folded:
            images += [np.flip(each, axis=which) for each in images]

    def at(x: np.ndarray, y: np.ndarray, phases: np.ndarray) -> np.ndarray:
        to_x, to_y = (line.to_points(each) for line, each in zip(along, (x, y), strict=True))
        in_x = (to_x @ field.reshape(len(field), -1)).reshape(-1, *field.shape[1:])
        return np.asarray(to_y @ in_x @ grid.t.at(phases).T)

    nodes = (*(each.all_nodes for each in along), grid.t.nodes)
    x, y = grid.positions
    return Sample(
        scene,
        x=x,
        y=y,
        weights=weights.ravel(),
        overpressure=field.reshape(-1, grid.nt),
        largest=_extreme(field, nodes, at),
        least=-_extreme(-field, nodes, lambda *where: -at(*where)),
        images=tuple(image.ravel() for image in images),
        momentum_n=momentum_out(scene, grid, unknowns)
        if scene.gas.inertia == "included"
        else (0.0, 0.0),
    )


def _on_outline(scene: Scene, grid: Grid, field: np.ndarray, outline: Outline) -> Sample:
    """The same in an outline's coordinates, where each place lies at two points."""
    if grid.x.folded:
        field = np.concatenate([field, np.flip(field, axis=0)])
    along, around = axis(grid.x.full_points, folded=False), grid.around
    field = np.pad(field[:, around.unfolded], [(1, 1), (0, 0), (0, 0)])
    u, v = np.meshgrid(along.all_nodes, around.all_nodes, indexing="ij")
    density = outline.stretch(outline.rim * (2 * u - 1), v) / outline.mean_stretch
    places = np.arange(u.size).reshape(u.shape)
    images = [places]
    for mirrored in around.mirrored:
        images += [each[:, mirrored] for each in images]

    def at(u: np.ndarray, v: np.ndarray, phases: np.ndarray) -> np.ndarray:
        in_u = np.einsum("pa,abi->pbi", along.to_points(u), field)
        return np.asarray(around.to_points(v) @ in_u @ grid.t.at(phases).T)

    nodes = along.all_nodes, around.all_nodes, grid.t.nodes
    x, y = outline.positions(u.ravel(), v.ravel())
    return Sample(
        scene,
        x=x,
        y=y,
        weights=(lines_of(along).weights[:, None] * density / len(around.all_nodes)).ravel(),
        overpressure=field.reshape(-1, grid.nt),
        largest=_extreme(field, nodes, at, around=True),
        least=-_extreme(-field, nodes, lambda *where: -at(*where), around=True),
        images=tuple(image.ravel() for image in images),
    )


def _extreme(
    field: np.ndarray,
    nodes: tuple[np.ndarray, ...],
    at: Callable[..., np.ndarray],
    *,
    around: bool = False,
) -> float:
    """The largest value near the largest at the nodes, of what interpolates them."""
    best = np.unravel_index(int(np.argmax(field)), field.shape)
    centre = [float(each[k]) for each, k in zip(nodes, best, strict=True)]
    reach = [
        float(np.diff(each)[max(k - 1, 0) : k + 1].max())
        for each, k in zip(nodes, best, strict=True)
    ]
    found = float(field[best])
    ends, turns = (0.0, 1.0), (-np.inf, np.inf)
    bounds = [ends, turns if around else ends, turns]
    for _ in range(LOOKS):
        look = [
            np.clip(np.linspace(c - r, c + r, LOOK), *bound)
            for c, r, bound in zip(centre, reach, bounds, strict=True)
        ]
        values = at(*look)
        nearest = np.unravel_index(int(np.argmax(values)), values.shape)
        if values[nearest] > found:
            found = float(values[nearest])
            centre = [float(each[k]) for each, k in zip(look, nearest, strict=True)]
        reach = [each / CLOSER for each in reach]
    return found
