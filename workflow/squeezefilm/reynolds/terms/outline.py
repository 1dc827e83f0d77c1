"""A smooth outline that is no rectangle: the area behind each point weighs what changes in time.

In the conformal coordinates of the outline (film/outline.py) the equation times that area has the
rectangle's form but for this weight J/J̄ of σ d(Hρ)/dT; the term adds what is more than 1 of it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from squeezefilm.film.scene import Scene
from squeezefilm.reynolds.terms.term import Arrays, Term

if TYPE_CHECKING:
    from squeezefilm.reynolds.grid import Grid

# How far points may lie off an outline that is exact, over its length.
EXACT = 1e-9


@dataclass(frozen=True)
class SmoothOutline(Term):
    label: str = "smooth outline"

    NAME = "outline"
    OVER_PERIOD = "terms/outline_over_period.cl"
    HOOKS = ("residual", "response")
    IN_SINGLE = True
    TIME_PRODUCTS = 1
    # Without, one of 199 films, a slender ellipse (σ 5e4), used 0.97 of its estimate.
    LEAST_FALL = 0.1

    @classmethod
    def of(cls, scene: Scene) -> SmoothOutline | None:
        return cls() if scene.pad.smooth_outline else None

    @classmethod
    def note(cls, scene: Scene) -> str:
        contour = scene.pad.contour
        if contour is None or contour.scatter < EXACT:
            return ""
        off_um = contour.scatter * scene.pad.length_x_m * 1e6
        return (
            f"the outline's points lie up to {off_um:.2g} µm off it: what that leaves open of the "
            "force is not in its error"
        )

    def matrices(self, grid: Grid, *, aspect: float) -> Arrays:
        assert grid.outline
        area = np.asarray(grid.density) * grid.outline.mean_stretch
        return {"stretch": area / grid.outline.typical_stretch - 1}

    def refused_on_grid(self, scene: Scene) -> str:
        for name in ("inertia", "heat"):
            if getattr(scene.gas, name) == "included":
                return f"not supported: gas.{name} under a pad that is not a rectangle"
        return ""
