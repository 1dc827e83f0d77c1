"""What a scene needs of the full problem, and what can be left out of it without any error."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from squeezefilm.scene import Scene

# Values of a profile that should agree by symmetry agree to rounding.
SYMMETRIC = 1e-13


@dataclass(frozen=True)
class Needs:
    """The domain and the terms that a scene needs.

    Attributes:
        fold_x, fold_y: the film is even about the finger's middle along x, y: half is enough.
        bearing: the finger slides.
        flow_terms: 1 for viscous flow, more for a rarefied gas.
        polytropic: the gas is not isothermal.
    """

    fold_x: bool
    fold_y: bool
    bearing: bool
    flow_terms: int
    polytropic: bool

    @property
    def left_out(self) -> tuple[tuple[str, str], ...]:
        """What the scene does not need, each with the reason."""
        parts = (
            (self.fold_x, "mirror half in x", "the profile is even about the finger's middle"),
            (self.fold_y, "mirror half in y", "the profile is even about the finger's middle"),
            (not self.bearing, "bearing term", "the finger is at rest"),
            (self.flow_terms == 1, "rarefaction", "gas.rarefaction is none"),
            (not self.polytropic, "heating", "gas.polytropic_exponent is 1"),
        )
        return tuple((what, why) for out, what, why in parts if out)

    @property
    def left_out_text(self) -> str:
        return "; ".join(what for what, _ in self.left_out)


def needs_of(scene: Scene) -> Needs:
    """What the scene needs, found from its profile, motion and gas.

    Sliding along x breaks the symmetry along x.
    """
    nodes = (np.arange(12) + 0.37) / 12.5
    x, y = np.meshgrid(nodes, nodes, indexing="ij")
    s = scene.amplitude(x, y)
    bearing = scene.bearing_number != 0
    even_x = np.abs(scene.amplitude(1 - x, y) - s).max() < SYMMETRIC
    even_y = np.abs(scene.amplitude(x, 1 - y) - s).max() < SYMMETRIC
    return Needs(
        fold_x=bool(even_x) and not bearing,
        fold_y=bool(even_y),
        bearing=bearing,
        flow_terms=len(scene.flow_coefficients),
        polytropic=scene.gas.polytropic_exponent != 1,
    )
