"""The space of a study's experiments: its limits, and the points in it that can be simulated.

A point is a row (h0_m, hv_m), and where the finger moves its position in the surface's form. A
point can be simulated where surface and finger do not touch and the finger lies on the surface.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from squeezefilm.config.loading import Config
from squeezefilm.designs.box import Box, coordinates, grid
from squeezefilm.errors import InputError
from squeezefilm.film.scene import Film
from squeezefilm.film.validity import exist
from squeezefilm.solution import POLAR, cartesian, form_of
from squeezefilm.studies.plans import box_of, plan
from squeezefilm.studies.study import film_in, surface_of

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Space:
    """The limits of a study's factors, and its film.

    box names h0_m and hv_m for a finger that stays at the centre, or all four factors.
    """

    box: Box
    film: Film
    position: tuple[str, str] = POLAR

    @classmethod
    def of(cls, config: Config, *, centred: bool) -> Space:
        """The space of a study: the screen's ranges and the finger positions'."""
        box = box_of(config, centred=centred)
        return cls(box, film_in(config), surface_of(config).position)

    @property
    def centred(self) -> bool:
        return len(self.box.names) == 2

    def allowed(self, points: Array) -> NDArray[np.bool_]:
        """Which points, shape (n, k), can be simulated, shape (n,)."""
        columns = dict(zip(self.box.names, np.transpose(points), strict=True))
        x_m, y_m = (columns.get(name, np.zeros(len(points))) for name in self.position)
        if self.position == POLAR:
            x_m, y_m = cartesian(x_m, y_m).values()
        return exist(self.film.scenes(columns["h0_m"], columns["hv_m"], x_m, y_m))

    def grid(self, most: int, *, distinct: bool) -> Array:
        """A grid of at most so many points, limits included, without those not allowed.

        With distinct=True the directions of a finger at the centre, which are one and the same
        scene, come once.
        """
        factors = len(self.box.names)
        levels = max(2, int(most ** (1 / factors) + 1e-9))
        points = grid(self.box, levels)
        if distinct and "phi_deg" in self.box.names:
            first, last = self.box.lower[3], self.box.upper[3]
            if last - first == 360:  # the last direction is the first again
                points = points[points[:, 3] < last]
            points = points[(points[:, 2] > 0) | (points[:, 3] == first)]
        return points[self.allowed(points)]

    def sample(self, points: int, *, seed: int) -> Array:
        """A fair sample of the space: every place is as likely as any other.

        From a scrambled Halton sequence, whose points keep out of each other's way: means over a
        few of them scatter less than over independent points. Those not allowed are left out.
        """
        from scipy.stats import qmc  # slow to import, and only needed here

        return self._drawn(points, qmc.Halton(len(self.box.names), rng=seed).random)

    def independent_sample(self, points: int, *, seed: int) -> Array:
        """Independent points, uniform over the factors' ranges; those not allowed are left out."""
        random = np.random.default_rng(seed)
        return self._drawn(points, lambda count: random.random((count, len(self.box.names))))

    def _drawn(self, points: int, draw: Callable[[int], Array]) -> Array:
        found = np.empty((0, len(self.box.names)))
        for _ in range(100):
            drawn = self.box.from_unit(draw(points))
            found = np.concatenate([found, drawn[self.allowed(drawn)]])
            if len(found) >= points:
                return found[:points]
        raise InputError("positions: hardly any finger position of the study lies on the surface")

    def coordinates(self, points: Array) -> Array:
        """Where distances between points are taken: equal for points that are the same scene."""
        return coordinates("scene", self.box)(points)

    def table(self, points: Array) -> pd.DataFrame:
        """The points as a plan, numbered from 1; twelve digits, so that a limit reads 2e-06."""
        rounded = np.array([[float(f"{value:.12g}") for value in row] for row in points])
        columns = dict(zip(self.box.names, rounded.reshape(points.shape).T, strict=True))
        return plan(**columns, position=self.position)

    def points(self, table: pd.DataFrame) -> Array:
        """The rows of a table of scenes as points.

        Raises InputError where the finger is off the centre of a space in which it stays there.
        """
        moved = form_of(table)[: 1 if form_of(table) == POLAR else 2]
        if self.centred and np.any(table[list(moved)].to_numpy() != 0):
            raise InputError(f"{moved[0]}: the finger is moved, in a space in which it is centred")
        return table[list(self.box.names)].to_numpy(dtype=float)
