"""How hard a scene's film is on a grid: its gap in numbers, and how slowly its errors may fall."""

from __future__ import annotations

from math import sqrt
from typing import TypedDict

from squeezefilm.film.scene import Scene
from squeezefilm.reynolds.error_estimate import THIN_LAYER_FALL

# Chebyshev nodes see the layer at a sliding surface's trailing rim, Λ/(1 − ε) times thinner than
# the finger, if there are this many times the root of that. Else errors fall as slowly as first
# order: of 40 films with more than 100 one (Λ 98, ε 0.87, at a tolerance of 0.1) was off by 1.8
# times its estimate, another by 0.98; with this least fall it is 7 times the change, as for 28
# nodes and 32.
NODES_PER_SLIDING = 2.0
SLIDING_FALL = 0.7
# Above this errors may go up and down from grid to grid; below 1e4 none of 996 films was beyond its
# estimate, but one at 9963 came to 0.9 of it.
UNEVEN_SIGMA = 5e3
# Above this at the narrowest place of a gap that is shaped at rest the first grid is for a layer as
# thin again: 60 such films of a draw (1e-4) took half of the time, for fewer went on to more grids.
THIN_SIGMA = 1e4


class GapNumbers(TypedDict):
    """A scene's gap as a first grid goes by it, arguments of ``first_grid``."""

    epsilon: float
    sigma: float
    bend: float


def gap_numbers(scene: Scene) -> GapNumbers:
    """A gap that is shaped at rest is as hard as its narrowest place, and as closed, everywhere."""
    if scene.finger.gap.flat:
        return {"epsilon": scene.epsilon, "sigma": scene.sigma, "bend": 0.0}
    bulge = 8 * abs(scene.finger.gap.bulge_m) / scene.h0_m
    return {
        "epsilon": scene.closure(),
        "sigma": _hardest_sigma(scene),
        "bend": bulge / scene.epsilon if scene.epsilon else 0.0,
    }


def _hardest_sigma(scene: Scene) -> float:
    least = min(1.0, scene.rest_range[0])
    sigma = scene.sigma / least**2
    return sigma if sigma < THIN_SIGMA else sigma / least**2


def least_fall(scene: Scene, nodes_x: int) -> float:
    """Factor by which changes from grid to grid are believed to fall at most.

    Args:
        nodes_x: across the finger along x, of the coarser grid.
    """
    if scene.bearing_number:
        layers = abs(scene.bearing_number) / (1 - gap_numbers(scene)["epsilon"])
        if nodes_x < NODES_PER_SLIDING * sqrt(layers):
            return SLIDING_FALL
    sigma = scene.sigma if scene.finger.gap.flat else _hardest_sigma(scene)
    sigma *= max(1.0, scene.aspect) ** 2
    return THIN_LAYER_FALL if sigma > UNEVEN_SIGMA else 0.0
