"""The space of a study's experiments: its limits, and the points in it that can be simulated.

A point is a row (h0_m, hv_m), and where the pad moves its position in the surface's form. A
point can be simulated where surface and pad do not touch and the pad lies on the surface.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from squeezefilm.config.study import Positions, Study
from squeezefilm.designs.box import Array, Box, coordinates, grid
from squeezefilm.errors import InputError
from squeezefilm.film.positions import POLAR, cartesian, form_of
from squeezefilm.film.scene import Film
from squeezefilm.film.symmetry import Symmetry
from squeezefilm.film.validity import exist
from squeezefilm.lazy import pd
from squeezefilm.tables import FACTOR_COLUMNS

if TYPE_CHECKING:
    from scipy.stats import qmc

CENTRED = FACTOR_COLUMNS[:2]
"""The factors of a pad that stays at the centre."""
POSITIONS_SEED, EXPONENT = 1, 10
"""Of the sequence of positions, and of two, the most points that it may have."""


def twelve(values: Array) -> Array:
    """Numbers with twelve digits, so that a limit reads 7e-06 and not 7.000000000000001e-06."""
    rounded = [float(f"{value:.12g}") for value in values.flat]
    return np.array(rounded).reshape(values.shape)


def plan(factors: pd.DataFrame, *, position: tuple[str, ...] = POLAR) -> pd.DataFrame:
    """A plan with the columns of a scenes table; points are numbered from 1.

    At the centre, in the form ``position``, where the factors have no position.
    """
    form = form_of(factors) if len(factors.columns) > 2 else position
    table = factors.reindex(columns=[*CENTRED, *form], fill_value=0.0).astype(float)
    table.insert(0, "point_id", np.arange(1, len(table) + 1).astype(str))
    return table


def pad_positions(config: Study) -> list[tuple[float, float]]:
    """The centre, then those of the section ``positions``, in the surface's form.

    With ``points`` they fill the reachable space. Without, they are those written (Fig. 15), with
    their images, as far as the scene's own symmetry does not make them the same.
    """
    positions = config.positions
    if positions.points:
        return space_filling(config.symmetry(), positions)
    return config.symmetry().places(positions)


def space_filling(symmetry: Symmetry, positions: Positions) -> list[tuple[float, float]]:
    """Positions that fill the reachable space, so that no wave of the profile can alias with them.

    The centre, then a scrambled Sobol' sequence over the space's limits, whose first quarter is
    moved to the edges: the far one of the first factor, and the nearer one of the second.
    """
    limits = symmetry.limits(positions)
    sequence = sobol(len(limits), seed=POSITIONS_SEED).random_base2(EXPONENT)
    unit = sequence[: positions.points - 1]
    # Neighbours of the sequence, for those at a distance that is a power of two lie side by side.
    edge = len(unit) // 4
    unit[: edge // 2, 0] = 1.0
    unit[edge // 2 : edge, 1] = np.round(unit[edge // 2 : edge, 1])
    box = Box(tuple(limits), *zip(*limits.values(), strict=True))
    return [(0.0, 0.0), *map(tuple, twelve(box.from_unit(unit)).tolist())]


def sobol(factors: int, *, seed: int) -> qmc.Sobol:
    """A scrambled Sobol' sequence."""
    from scipy.stats import qmc  # slow to import, and only needed here

    return qmc.Sobol(factors, rng=seed)


def box_of(config: Study, *, centred: bool = False) -> Box:
    """The box of a study's factors: the screen's gaps and amplitudes, the pad's positions.

    From the section ``screen``; unless the pad is centred also from ``positions``, ``actuator``
    and ``pad``. Positions are those that represent all by the scene's symmetry.
    """
    gaps, amplitudes = config.screen.h0_m, config.screen.hv_m
    limits = {"h0_m": (gaps.start, gaps.stop), "hv_m": (amplitudes.start, amplitudes.stop)}
    if not centred:
        limits |= config.symmetry().limits(config.positions)
    return Box(tuple(limits), *zip(*limits.values(), strict=True))


def declared_ranges(config: Study, *, centred: bool) -> dict[str, tuple[float, float]]:
    """The limits of the declared space by factor; those of a centred pad's position are zero."""
    centre = dict.fromkeys(config.actuator.surface.position if centred else (), (0.0, 0.0))
    return box_of(config, centred=centred).ranges | centre


@dataclass(frozen=True)
class Space:
    """The limits of a study's factors, and its film.

    box names h0_m and hv_m for a pad that stays at the centre, or all four factors.
    """

    box: Box
    film: Film
    position: tuple[str, str] = POLAR

    @classmethod
    def of(cls, config: Study, *, centred: bool) -> Space:
        """The space of a study: the screen's ranges and the pad positions'."""
        box = box_of(config, centred=centred)
        return cls(box, config.read_film(), config.actuator.surface.position)

    def allowed(self, points: Array) -> NDArray[np.bool_]:
        """Mask of the points, shape (n, k), that can be simulated, shape (n,)."""
        h0_m, hv_m, *place = np.transpose(points)
        x_m, y_m = place or np.zeros((2, len(points)))
        if self.position == POLAR:
            x_m, y_m = cartesian(x_m, y_m).values()
        return exist(self.film.scenes(h0_m, hv_m, x_m, y_m))

    def grid(self, most: int, *, distinct: bool) -> Array:
        """A grid of at most so many points, limits included, without those not allowed.

        With distinct=True the directions of a pad at the centre, which are one and the same
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
        few of them scatter less than over independent points. Those not allowed are excluded.
        """
        from scipy.stats import qmc  # slow to import, and only needed here

        return self._drawn(points, qmc.Halton(len(self.box.names), rng=seed).random)

    def independent_sample(self, points: int, *, seed: int) -> Array:
        """Independent points, uniform over the factors' ranges; those not allowed are excluded."""
        random = np.random.default_rng(seed)
        return self._drawn(points, lambda count: random.random((count, len(self.box.names))))

    def _drawn(self, points: int, draw: Callable[[int], Array]) -> Array:
        found = np.empty((0, len(self.box.names)))
        for _ in range(100):
            drawn = self.box.from_unit(draw(points))
            found = np.concatenate([found, drawn[self.allowed(drawn)]])
            if len(found) >= points:
                return found[:points]
        raise InputError("positions: hardly any pad position of the study lies on the surface")

    def coordinates(self, points: Array) -> Array:
        """Coordinates for distances between points: equal for points that are the same scene."""
        return coordinates("scene", self.box)(points)

    def table(self, points: Array) -> pd.DataFrame:
        """The points as a plan, numbered from 1; twelve digits, so that a limit reads 2e-06."""
        return plan(pd.DataFrame(twelve(points), columns=self.box.names), position=self.position)

    def points(self, table: pd.DataFrame) -> Array:
        """The rows of a table of scenes as points.

        Raises InputError where the pad is off the centre of a space in which it stays there.
        """
        moved = form_of(table)[: 1 if form_of(table) == POLAR else 2]
        if len(self.box.names) == 2 and np.any(table[list(moved)].to_numpy() != 0):
            raise InputError(f"{moved[0]}: the pad is moved, in a space in which it is centred")
        return table[list(self.box.names)].to_numpy(dtype=float)
