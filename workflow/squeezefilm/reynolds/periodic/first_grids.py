"""The grids that a scene is begun on."""

from __future__ import annotations

from squeezefilm.film.scene import Scene
from squeezefilm.reynolds.grid import Grid
from squeezefilm.reynolds.needs import Needs
from squeezefilm.reynolds.periodic.changes import judged_from_coarser, margin_of
from squeezefilm.reynolds.periodic.resolution import (
    FIRST_SHARE,
    FOURS,
    JUDGED_SHARE,
    MOST_UNKNOWNS,
    TWOS,
    at_least_judged,
    first_grid,
    gap_numbers,
    nodes_for_profile,
    profile_fall,
    up_to,
    with_finer,
)
from squeezefilm.reynolds.terms import layer_stiffness_of, numbers_of

# Tolerance below which a finer grid tells a smooth film's error with less work than coarser ones.
FINER_BELOW = 2e-4


def first_grids(
    scene: Scene, needs: Needs, *, tolerance: float, room: float = MOST_UNKNOWNS
) -> tuple[Grid, ...]:
    """Those of the first launch: a start, if it pays, and those that it takes to know the error.

    Args:
        room: most unknowns of a grid that the device has memory for.
    """
    seen = nodes_for_profile(needs, tolerance=tolerance)
    plain = needs.outline is None and margin_of(needs.terms) == 1
    # Twice the change to the second grid must be below the tolerance, or a third is needed; but
    # plain films want fewer nodes than the guess.
    share, step = (JUDGED_SHARE, TWOS) if plain else (FIRST_SHARE, FOURS)
    first = grid_for(scene, needs, tolerance=tolerance, share=share, room=room, step=step)
    smooth = profile_fall(needs, first.across, first.across, tolerance=tolerance) == 0
    finer_pays = plain and smooth and tolerance < FINER_BELOW
    if judged_from_coarser(needs.terms, tolerance=tolerance) and not finer_pays:
        last = grid_for(scene, needs, tolerance=tolerance, share=JUDGED_SHARE, room=room)
        if grids := up_to(at_least_judged(last), seen):
            return grids
    return with_finer(first, seen, room, step)


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
    numbers = gap_numbers(scene)
    return first_grid(
        **numbers,
        bearing=abs(scene.bearing_number),
        aspect=scene.aspect,
        needs=needs,
        tolerance=tolerance,
        share=share,
        # Without terms nothing lags.
        slow=float(numbers_of(scene, needs.terms)["slow"]) if needs.terms else 1.0,  # type: ignore[arg-type]
        stiffness=layer_stiffness_of(scene, needs.terms, sigma=numbers["sigma"]),
        room=room,
        step=step,
    )
