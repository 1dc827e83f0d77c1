"""The grids that a scene is begun on."""

from __future__ import annotations

from squeezefilm.film.scene import Scene
from squeezefilm.reynolds.grid import Grid
from squeezefilm.reynolds.needs import Needs
from squeezefilm.reynolds.periodic.changes import judged_from_coarser, margin_of
from squeezefilm.reynolds.periodic.gap_numbers import gap_numbers
from squeezefilm.reynolds.periodic.resolution import (
    FIRST_SHARE,
    FOURS,
    JUDGED_SHARE,
    MOST_UNKNOWNS,
    TWOS,
    at_least_judged,
    first_grid,
    nodes_for_profile,
    profile_fall,
    up_to,
    with_finer,
)
from squeezefilm.reynolds.terms import layer_stiffness_of, numbers_of, unknown_fields

# Tolerance below which a plain film's first grid is to leave less: there too many wanted a third.
TIGHT_BELOW, TIGHT_SHARE = 4e-7, 0.2


def first_grids(
    scene: Scene,
    needs: Needs,
    *,
    tolerance: float,
    room: float = MOST_UNKNOWNS,
    refined: bool = False,
) -> tuple[Grid, ...]:
    """Those of the first launch: a start, if it pays, and those that it takes to know the error.

    Args:
        room: most unknowns of a grid that the device has memory for.
        refined: whether the last grid must be finer than the one before in every direction.
    """
    plain = not refined and needs.outline is None and margin_of(needs.terms) == 1
    # Twice the change to the second grid must be below the tolerance, or a third is needed; but
    # plain films want fewer nodes than the guess.
    plain_share = JUDGED_SHARE if tolerance > TIGHT_BELOW else TIGHT_SHARE
    share, step = (plain_share, TWOS) if plain else (FIRST_SHARE, FOURS)
    first = grid_for(scene, needs, tolerance=tolerance, share=share, room=room, step=step)
    # A finer grid tells a smooth film's error with less work than coarser ones.
    judged = not refined and judged_from_coarser(needs.terms, tolerance=tolerance)
    if judged and _rough(needs, first, tolerance):
        last = grid_for(scene, needs, tolerance=tolerance, share=JUDGED_SHARE, room=room)
        seen = nodes_for_profile(needs, tolerance=tolerance)
        if grids := up_to(at_least_judged(last), seen):
            return grids
    return with_finer(first, needs, tolerance, room, step)


def _rough(needs: Needs, grid: Grid, tolerance: float) -> bool:
    """Whether a grid misses something of a profile that is of finite smoothness."""
    return profile_fall(needs, grid.across, grid.across, tolerance=tolerance) > 0


def grid_for(
    scene: Scene,
    needs: Needs,
    *,
    tolerance: float,
    share: float = FIRST_SHARE,
    room: float = MOST_UNKNOWNS,
    step: int = FOURS,
) -> Grid:
    """A grid that is to leave a share of the tolerance."""
    numbers, terms = gap_numbers(scene), needs.terms
    return first_grid(
        **numbers,
        bearing=abs(scene.bearing_number),
        aspect=scene.aspect,
        needs=needs,
        tolerance=tolerance,
        share=share,
        # Only what has unknowns of its own lags; without terms no layer but the squeezing's counts.
        slow=float(numbers_of(scene, terms)["slow"]) if unknown_fields(terms) > 1 else 1.0,  # type: ignore[arg-type]
        stiffness=layer_stiffness_of(scene, terms, sigma=numbers["sigma"]) if terms else 1.0,
        room=room,
        step=step,
    )
