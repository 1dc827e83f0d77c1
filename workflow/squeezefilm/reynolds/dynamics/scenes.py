"""The slow film of a scene, and how good it is there."""

from __future__ import annotations

import numpy as np

from squeezefilm.film.scene import Scene
from squeezefilm.reynolds.asymptotics.composite import edge_layer_expansion
from squeezefilm.reynolds.asymptotics.films import expansion_axis
from squeezefilm.reynolds.asymptotics.scenes import expansion_numbers
from squeezefilm.reynolds.dynamics.slow_film import SlowFilm, slow_film
from squeezefilm.reynolds.terms import terms_of
from squeezefilm.reynolds.terms.inertia import Inertia

# Unknowns along each side of the grids that are tried, and what the next must gain.
POINTS = (11, 15, 21, 31)
GAIN = 0.9


def refused(scene: Scene) -> str:
    """Why a scene's response is not known; empty where it is."""
    if scene.finger.shape != "rectangle":
        return "the response was derived for rectangular fingers"
    if not scene.finger.gap.flat:
        return "the response was derived for a gap that is even at rest, not tilted or bulging"
    if scene.epsilon == 0:
        return "the surface is at rest"
    unknown = [term.label for term in terms_of(scene) if term.expansion_numbers(scene) is None]
    unknown += [term.label for term in terms_of(scene) if isinstance(term, Inertia)]
    if unknown:
        return f"the response is not derived with {', '.join(unknown)}"
    return ""


def slow_film_of(scene: Scene) -> tuple[SlowFilm, float]:
    """The slow film on a grid that shows all that it can, and its relative error at rest.

    A finer grid is taken as long as it makes the error smaller by a tenth.
    """
    best = film_on(scene, POINTS[0])
    for points in POINTS[1:]:
        finer = film_on(scene, points)
        if not finer[1] < GAIN * best[1]:
            break
        best = finer
    return best


def film_on(scene: Scene, points: int) -> tuple[SlowFilm, float]:
    """The slow film on one grid, and its relative error at rest.

    The error is that of the settled force, by the edge layer's expansion: it may be infinite.
    """
    nodes = expansion_axis(points).all_nodes
    film = slow_film(
        epsilon=scene.epsilon,
        sigma=scene.sigma,
        amplitude=scene.amplitude(*np.meshgrid(nodes, nodes, indexing="ij")),
        aspect=scene.aspect,
        slip=expansion_numbers(scene).get("slip", 0.0),
    )
    limit = edge_layer_expansion(film.films)
    with np.errstate(divide="ignore", invalid="ignore"):
        return film, float(np.abs(limit.error / limit.mean)[0])
