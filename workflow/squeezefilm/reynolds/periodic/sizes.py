"""How large a grid's linear systems are, and what a kernel must know of it beforehand."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from squeezefilm.reynolds.grid import Grid
from squeezefilm.reynolds.layout import Columns
from squeezefilm.reynolds.terms import Terms, parts_of, unknown_fields

LEAST_KRYLOV, MOST_KRYLOV = 20, 80
LARGEST_WORKSPACE_BYTES = 256 * 2**20


@lru_cache(maxsize=256)
def most_krylov(grid: Grid, terms: Terms) -> int:
    """Krylov iterations that a Newton step may take: as many as there is room for."""
    room = LARGEST_WORKSPACE_BYTES // (8 * grid.count * unknown_fields(terms)) - 8
    return min(max(room, LEAST_KRYLOV), MOST_KRYLOV)


@lru_cache(maxsize=256)
def sizes_of(grid: Grid, terms: Terms) -> Columns:
    """What a kernel must know of a grid before it can find anything."""
    whole_x, whole_y = grid.x.in_halves, grid.y.in_halves
    sizes = {
        "nx": grid.nx,
        "ny": grid.ny,
        "nt": grid.nt,
        "most_krylov": most_krylov(grid, terms),
        "whole_x": whole_x,
        "whole_y": whole_y,
        "whole_modes_x": whole_x and not any("x" in term.BREAKS for term in terms),
    }
    return tuple(sizes), np.array(list(sizes.values()), dtype=np.int64)


@lru_cache(maxsize=4096)
def iteration_flops(grid: Grid, terms: Terms = ()) -> float:
    """Floating-point operations of one Krylov iteration's products."""
    in_space = 2 + max(parts_of(terms), 1) + sum(term.SPACE_PRODUCTS for term in terms)
    in_time = 2 + sum(term.TIME_PRODUCTS for term in terms)
    return 2.0 * grid.count * (in_space * sum(grid.space_products) + in_time * grid.nt)
