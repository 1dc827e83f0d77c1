"""A given pressure on the film's edge, P = 1 + g, in place of the ambient one.

Unknown stays the pressure on the inner nodes, zero on the edge: by collocation the flow is affine
in what stands there, and so are the pressure and its slope on the points of velocities. What g adds
are arrays of the host, which knows it (quantities/edge_effects.py). That gas at the edge is warmer
by g is neglected.
"""

from __future__ import annotations

from squeezefilm.film.scene import Scene
from squeezefilm.reynolds.terms.term import Term


class EdgePressure(Term):
    """No scene has it by itself: a batch brings its arrays (periodic/launch.py)."""

    label = "edge pressure"
    NAME = "edge_pressure"
    KERNEL_FILE = "terms/edge_pressure_over_period.cl"
    KERNEL_HOOKS = ("residual",)
    OPERATOR_NAMES = (
        *("edge_flow", "edge_values_x", "edge_slope_x"),
        *("edge_values_y", "edge_slope_y"),
    )

    @classmethod
    def of(cls, scene: Scene) -> EdgePressure | None:
        return None
