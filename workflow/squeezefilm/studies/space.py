"""The space of a study's experiments, its pad positions, and points as plans.

A point is a row (h0_m, hv_m), and where the pad moves its position in the surface's form.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from squeezefilm.config.study import Positions, Study
from squeezefilm.designs.space import Array, Space
from squeezefilm.errors import InputError
from squeezefilm.film.positions import POLAR_COLUMNS, cartesian_from_polar, find_position_columns
from squeezefilm.film.symmetry import Symmetry
from squeezefilm.film.validity import solvable_scene_mask
from squeezefilm.lazy import pd
from squeezefilm.tables import FACTOR_COLUMNS

if TYPE_CHECKING:
    from scipy.stats import qmc

CENTRED_FACTOR_COLUMNS = FACTOR_COLUMNS[:2]
"""The factors of a pad that stays at the centre."""
SPACE_FILLING_SEED, SOBOL_POINTS_EXPONENT = 1, 10
"""Of the sequence of positions, and of two, the most points that it may have."""


def round_to_twelve_digits(values: Array) -> Array:
    """Numbers with twelve digits, so that a limit reads 7e-06 and not 7.000000000000001e-06."""
    rounded = [float(f"{value:.12g}") for value in values.flat]
    return np.array(rounded).reshape(values.shape)


def plan_table(factors: pd.DataFrame, *, position: tuple[str, ...] = POLAR_COLUMNS) -> pd.DataFrame:
    """A plan with the columns of a scenes table; points are numbered from 1.

    At the centre, in the form ``position``, where the factors have no position.
    """
    form = find_position_columns(factors) if len(factors.columns) > 2 else position
    table = factors.reindex(columns=[*CENTRED_FACTOR_COLUMNS, *form], fill_value=0.0).astype(float)
    table.insert(0, "point_id", np.arange(1, len(table) + 1).astype(str))
    return table


def pad_positions(config: Study) -> list[tuple[float, float]]:
    """The centre, then those of the section ``positions``, in the surface's form.

    With ``points`` they fill the reachable space. Without, they are those written (Fig. 15), with
    their images, as far as the scene's own symmetry does not make them the same.
    """
    positions = config.positions
    if positions.points:
        return space_filling_positions(config.symmetry(), positions)
    return config.symmetry().pad_positions(positions)


def space_filling_positions(symmetry: Symmetry, positions: Positions) -> list[tuple[float, float]]:
    """Positions that fill the reachable space, so that no wave of the profile can alias with them.

    The centre, then a scrambled Sobol' sequence over the space's limits, whose first quarter is
    moved to the edges: the far one of the first factor, and the nearer one of the second.
    """
    limits = symmetry.limits(positions)
    sequence = sobol_sampler(len(limits), seed=SPACE_FILLING_SEED).random_base2(
        SOBOL_POINTS_EXPONENT
    )
    unit = sequence[: positions.points - 1]
    # Neighbours of the sequence, for those at a distance that is a power of two lie side by side.
    edge = len(unit) // 4
    unit[: edge // 2, 0] = 1.0
    unit[edge // 2 : edge, 1] = np.round(unit[edge // 2 : edge, 1])
    return [(0.0, 0.0), *map(tuple, round_to_twelve_digits(Space(limits).from_unit(unit)).tolist())]


def sobol_sampler(factors: int, *, seed: int) -> qmc.Sobol:
    """A scrambled Sobol' sequence."""
    from scipy.stats import qmc  # slow to import, and only needed here

    return qmc.Sobol(factors, rng=seed)


def space_of_study(config: Study, *, centred: bool = False) -> Space:
    """The space of a study: the screen's gaps and amplitudes, the pad's positions.

    From the section ``screen``; unless the pad is centred also from ``positions``, ``actuator``
    and ``pad``. Positions are those that represent all by the scene's symmetry. A point can be
    simulated where surface and pad do not touch and the pad lies on the surface.
    """
    gaps, amplitudes = config.screen.h0_m, config.screen.hv_m
    limits = {"h0_m": (gaps.start, gaps.stop), "hv_m": (amplitudes.start, amplitudes.stop)}
    if not centred:
        limits |= config.symmetry().limits(config.positions)
    position = config.actuator.surface.position_columns

    def solvable_mask(points: Array) -> NDArray[np.bool_]:
        h0_m, hv_m, *place = np.transpose(points)
        x_m, y_m = place or np.zeros((2, len(points)))
        if position == POLAR_COLUMNS:
            x_m, y_m = cartesian_from_polar(x_m, y_m).values()
        return solvable_scene_mask(config.read_film().scenes(h0_m, hv_m, x_m, y_m))

    return Space(limits, solvable_mask, position)


def table_of_points(points: Array, space: Space) -> pd.DataFrame:
    """Points as a plan, numbered from 1; twelve digits, so that a limit reads 2e-06."""
    return plan_table(
        pd.DataFrame(round_to_twelve_digits(points), columns=space.names),
        position=space.position_columns,
    )


def points_of_table(table: pd.DataFrame, space: Space) -> Array:
    """The rows of a table of scenes as points.

    Raises InputError where the pad is off the centre of a space in which it stays there.
    """
    moved = find_position_columns(table)[
        : 1 if find_position_columns(table) == POLAR_COLUMNS else 2
    ]
    if len(space.limits) == 2 and np.any(table[list(moved)].to_numpy() != 0):
        raise InputError(f"{moved[0]}: the pad is moved, in a space in which it is centred")
    return table[list(space.names)].to_numpy(dtype=float)
