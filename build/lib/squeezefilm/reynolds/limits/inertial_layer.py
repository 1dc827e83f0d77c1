"""The rim's boundary layer with the gas' inertia: functions of excursion ratio and Reynolds number.

What the core of the film sees of the layer (layer_state.py) is ψ² on the rim, the layer's own
overpressure d, and the changes g and h of the rim's ψ² with the slopes of the profile and of the
core. They were computed once, by ``python -m squeezefilm.reynolds.limits.inertial_layer``, and are
stored as (ψ² − 1)/a², d/a², g/a and h/a² at Chebyshev points: in Re up to MOST_REYNOLDS and, for
each Re, in −ln(1 − a²) up to a = ``largest(Re)``. Somewhere beyond, waves steepen to a shock in the
layer, and no periodic state was found that a finer grid would not change.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np
from numpy.polynomial import chebyshev

from squeezefilm.reynolds.spectral import period

TABLE = Path(__file__).with_name("inertial_layer.csv")
COLUMNS = (
    *("reynolds", "a", "rise_over_a_squared"),
    *("d_over_a_squared", "g_over_a", "h_over_a_squared"),
)
MOST_REYNOLDS = 10.0
REYNOLDS_ROWS, ROWS = 14, 18
# Nodes across the layer and, from small excursions to the largest, over the period.
NODES, INSTANTS = 88, (12, 48)
# Share of the shortest waves in time from which on a state is not to be relied on.
MOST_UNRESOLVED = 5e-3


@dataclass(frozen=True)
class RimValues:
    """The layer's functions at points of the rim, each of one shape; NaN beyond the table.

    rise: ψ² − 1; d: ∫₀^∞ ⟨P − ψ/H⟩ dξ; g, h: ψ² is changed by (g ∂a/∂n + h ∂ψ²/∂n)/√σ, n inward.
    """

    rise: np.ndarray
    d: np.ndarray
    g: np.ndarray
    h: np.ndarray


def largest(reynolds: np.ndarray | float) -> np.ndarray:
    """The largest excursion ratio of the table: 0.9 without inertia, 0.4 at Re = 10."""
    return 0.9 / (1 + np.asarray(reynolds, dtype=float) / 8)


def rim_values(a: np.ndarray, reynolds: np.ndarray) -> RimValues:
    """The functions at excursion ratios ``a``, shape (B, …), of films with ``reynolds``, (B,)."""
    reynolds = np.asarray(reynolds, dtype=float)
    films = a.reshape(len(reynolds), -1)
    most = largest(reynolds)[:, None]
    inside = (np.abs(films) <= most) & (reynolds[:, None] <= MOST_REYNOLDS)
    place = 2 * _stretched(np.minimum(np.abs(films), most)) / _stretched(most) - 1
    powers = chebyshev.chebvander(place, ROWS - 1)
    of_film = chebyshev.chebvander(
        2 * np.minimum(reynolds, MOST_REYNOLDS) / MOST_REYNOLDS - 1, REYNOLDS_ROWS - 1
    )
    series = np.einsum("br,kra->bka", of_film, _series())
    values = np.einsum("bka,bma->kbm", series, powers)
    ratio = np.where(inside, films, np.nan)
    scaled = values * np.stack([ratio**2, ratio**2, ratio, ratio**2])
    return RimValues(*scaled.reshape(4, *a.shape))


def table_nodes() -> np.ndarray:
    """Reynolds numbers and excursion ratios of the table's rows, shape (REYNOLDS_ROWS, ROWS, 2)."""
    reynolds = (chebyshev.chebpts1(REYNOLDS_ROWS) + 1) / 2 * MOST_REYNOLDS
    share = (chebyshev.chebpts1(ROWS) + 1) / 2
    a = np.sqrt(-np.expm1(-np.outer(_stretched(largest(reynolds)), share)))
    return np.stack([np.broadcast_to(reynolds[:, None], a.shape), a], axis=2)


def compute(reynolds: float, excursions: np.ndarray) -> np.ndarray:
    """Rows of the table at one Reynolds number and rising a > 0, shape (len(excursions), 6).

    Raises:
        ArithmeticError: where no state is found or it is not resolved.
    """
    from squeezefilm.reynolds.limits.layer_state import Layer, LayerGrid, LayerState

    rows = []
    last: LayerState | None = None
    for a in map(float, excursions):
        share = (a / float(largest(reynolds))) ** 2
        instants = 2 * round((INSTANTS[0] + (INSTANTS[1] - INSTANTS[0]) * share) / 2)
        layer = Layer(a, reynolds, LayerGrid(NODES, reynolds, period(instants)))
        last = layer.solve(last)
        if last.unresolved > MOST_UNRESOLVED:
            raise ArithmeticError(f"the layer at a = {a:g}, Re = {reynolds:g} is not resolved")
        seen = layer.seen(last)
        rise = (seen.mass_square - 1) / a**2
        rows.append((reynolds, a, rise, seen.d / a**2, seen.g / a, seen.h / a**2))
    return np.array(rows)


def read_table() -> np.ndarray:
    """The rows, Reynolds number by Reynolds number, shape (REYNOLDS_ROWS, ROWS, 6)."""
    rows = np.loadtxt(TABLE, delimiter=",", skiprows=1)
    return rows.reshape(REYNOLDS_ROWS, ROWS, len(COLUMNS))


def write_table() -> None:
    """Compute every row anew; about half an hour of one core."""
    rows = [compute(float(of_one[0, 0]), of_one[:, 1]) for of_one in table_nodes()]
    lines = [
        ",".join(COLUMNS),
        *(",".join(map(repr, row.tolist())) for row in np.concatenate(rows)),
    ]
    TABLE.write_text("\n".join(lines) + "\n", encoding="utf-8")


def _stretched(a: np.ndarray | float) -> np.ndarray:
    return -np.log1p(-np.square(a))


@lru_cache(maxsize=1)
def _series() -> np.ndarray:
    """Chebyshev coefficients of the four functions in Re and a, (4, REYNOLDS_ROWS, ROWS)."""
    values = np.moveaxis(read_table()[:, :, 2:], 2, 0)
    of_reynolds, of_a = (
        np.linalg.inv(chebyshev.chebvander(chebyshev.chebpts1(count), count - 1))
        for count in (REYNOLDS_ROWS, ROWS)
    )
    series: np.ndarray = of_reynolds @ values @ of_a.T
    return series


if __name__ == "__main__":
    write_table()
