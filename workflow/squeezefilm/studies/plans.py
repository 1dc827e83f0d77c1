"""Which points are simulated: the screen, the four-factor plan, samples and sweeps."""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from squeezefilm.config.loading import Config
from squeezefilm.designs.box import Box
from squeezefilm.film.symmetry import Symmetry
from squeezefilm.solution import POLAR, as_in, form_of
from squeezefilm.studies.study import surface_of, symmetry_of
from squeezefilm.tables import FACTOR_COLUMNS

if TYPE_CHECKING:
    from scipy.stats import qmc

CENTRED = FACTOR_COLUMNS[:2]
"""The factors of a finger that stays at the centre."""
VALIDATION_SAMPLES = ("validation_two_factor", "validation_four_factor")
"""The plans of independent points, uniform over the declared space: finger centred, anywhere."""
POSITIONS_SEED, EXPONENT = 1, 10
"""Of the sequence of positions, and of two, the most points that it may have."""
# Points of a sweep that are held at a time, and that a Parquet file keeps together.
PIECE = 2**17


def level_values(levels: dict[str, Any]) -> np.ndarray:
    """The evenly spaced values of a ``{start, stop, levels}`` section, shape (levels,).

    Rounded to twelve digits, so that a plan reads 7e-06 and not 7.000000000000001e-06.
    """
    values = np.linspace(levels["start"], levels["stop"], levels["levels"])
    return np.array([float(f"{value:.12g}") for value in values])


def centred_grid(
    *, h0_m: np.ndarray, hv_m: np.ndarray, position: tuple[str, ...] = POLAR
) -> pd.DataFrame:
    """Every gap with every amplitude, finger centred (the screen of Fig. 7, the control grid)."""
    gaps, amplitudes = np.meshgrid(h0_m, hv_m, indexing="ij")
    return plan(h0_m=gaps.ravel(), hv_m=amplitudes.ravel(), position=position)


def plan(
    *,
    h0_m: Sequence[float] | np.ndarray,
    hv_m: Sequence[float] | np.ndarray,
    position: tuple[str, ...] = (),
    **place: Sequence[float] | np.ndarray | float,
) -> pd.DataFrame:
    """A plan with the columns of a scenes table; points are numbered from 1.

    The position's form is that of ``place``, whose columns it gives, or ``position``; at the centre
    where it is left out.
    """
    centre = dict.fromkeys(position or form_of(place), 0.0)
    table = pd.DataFrame({"h0_m": h0_m, "hv_m": hv_m, **centre, **place}, dtype=float)
    table.insert(0, "point_id", np.arange(1, len(table) + 1).astype(str))
    return table


def finger_positions(config: Config) -> list[tuple[float, float]]:
    """The centre, then those of the section ``positions``, in the surface's form.

    With ``points`` they fill the reachable space. Without, they are those written (Fig. 15), with
    their images, as far as the scene's own symmetry does not make them the same.
    """
    positions = config["positions"]
    if "points" in positions:
        return space_filling(symmetry_of(config), positions)
    return symmetry_of(config).places(positions)


def space_filling(symmetry: Symmetry, positions: dict[str, Any]) -> list[tuple[float, float]]:
    """Positions that fill the reachable space, so that no wave of the profile can alias with them.

    The centre, then a scrambled Sobol' sequence over the space's limits, whose first quarter is
    moved to the edges: the far one of the first factor, and the nearer one of the second.
    """
    limits = symmetry.limits(positions)
    sequence = _sobol(len(limits), seed=POSITIONS_SEED).random_base2(EXPONENT)
    unit = sequence[: positions["points"] - 1]
    # Neighbours of the sequence, for those at a distance that is a power of two lie side by side.
    edge = len(unit) // 4
    unit[: edge // 2, 0] = 1.0
    unit[edge // 2 : edge, 1] = np.round(unit[edge // 2 : edge, 1])
    box = Box(tuple(limits), *zip(*limits.values(), strict=True))
    first, second = np.vectorize(lambda value: float(f"{value:.12g}"))(box.from_unit(unit)).T
    return [(0.0, 0.0), *zip(first.tolist(), second.tolist(), strict=True)]


def four_factor_plan(
    *,
    positions: Sequence[tuple[float, float]],
    h0_m: Sequence[float] | np.ndarray,
    hv_m: Sequence[float] | np.ndarray,
    position: tuple[str, ...] = POLAR,
) -> pd.DataFrame:
    """Every finger position with every (h0, hv) point of a two-factor design (section V)."""
    design = pd.DataFrame({"h0_m": h0_m, "hv_m": hv_m})
    return plan(**pd.DataFrame(positions, columns=position).merge(design, how="cross"))


def box_of(config: Config, *, centred: bool = False) -> Box:
    """The box of a study's factors: the screen's gaps and amplitudes, the finger's positions.

    From the section ``screen``; unless the finger is centred also from ``positions``, ``actuator``
    and ``finger``. Positions are those that represent all by the scene's symmetry.
    """
    limits = {
        each: tuple(config["screen"][each][end] for end in ("start", "stop")) for each in CENTRED
    }
    if not centred:
        limits |= symmetry_of(config).limits(config["positions"])
    lower, upper = zip(*limits.values(), strict=True)
    return Box(tuple(limits), lower, upper)


def declared_ranges(config: Config, *, centred: bool) -> dict[str, tuple[float, float]]:
    """The limits of the declared space by factor; those of a centred finger's position are zero."""
    ranges = box_of(config, centred=centred).ranges
    return ranges | {name: (0.0, 0.0) for name in surface_of(config).position if name not in ranges}


def _position_count(config: Config) -> int:
    return config["positions"].get("points") or len(finger_positions(config))


def plan_sizes(config: Config) -> dict[str, int]:
    """The number of points of each plan that is simulated in chunks."""
    grid = {name: config[name] for name in ("screen", "error_map")}
    return {
        **{name: g["h0_m"]["levels"] * g["hv_m"]["levels"] for name, g in grid.items()},
        "four_factor": config["design"]["points"] * _position_count(config),
        **{name: config[name]["points"] for name in ("four_factor_control", "sweep")},
        **dict.fromkeys(VALIDATION_SAMPLES, config["validation"]["points"]),
    }


def sweep_pieces(
    *, points: int, first: int, seed: int, **ranges: tuple[float, float]
) -> Iterator[pd.DataFrame]:
    """Points of a Sobol' sequence, which fills the ranges of the four factors evenly; in pieces.

    Scrambled by the seed. The sequence is one: sweeps from ``first`` 0 and 1000, of 1000 points
    each, are the sweep of 2000 points in two parts. Points are numbered by their place in it.
    """
    sequence = _sobol(4, seed=seed)
    if first:
        sequence.fast_forward(first)
    for begin in range(first, first + points, PIECE):
        end = min(begin + PIECE, first + points)
        with warnings.catch_warnings():
            # Of numbers of points that are no power of two: they fill the box less evenly.
            warnings.filterwarnings("ignore", message="The balance", category=UserWarning)
            table = _within(ranges, sequence.random(end - begin))
        yield table.assign(point_id=np.arange(begin + 1, end + 1).astype(str))


def _sobol(factors: int, *, seed: int) -> qmc.Sobol:
    from scipy.stats import qmc  # slow to import, and only needed here

    return qmc.Sobol(factors, rng=seed)


def random_plan(*, points: int, seed: int, **ranges: tuple[float, float]) -> pd.DataFrame:
    """Points drawn uniformly from ranges of the factors, as control points.

    Equal seeds give equal points.
    """
    return _within(ranges, np.random.default_rng(seed).random((points, 4)))


def _within(ranges: dict[str, tuple[float, float]], unit: np.ndarray) -> pd.DataFrame:
    """The plan of points in [0, 1] over ranges, shape (points, 4)."""
    names = as_in(FACTOR_COLUMNS, ranges)
    lower, upper = np.transpose([ranges[name] for name in names])
    return plan(**dict(zip(names, (lower + (upper - lower) * unit).T, strict=True)))
