"""What a scene needs of the full problem, and what can be left out of it without any error."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from squeezefilm.reynolds.spectral import axis
from squeezefilm.scene import Scene

# Values of a profile that should agree by symmetry agree to rounding.
SYMMETRIC = 1e-13
PROBE_POINTS = 24


@dataclass(frozen=True)
class Needs:
    """The domain and the terms that a scene needs.

    Attributes:
        fold_x, fold_y: the film is even about the finger's middle along x, y: half is enough.
        bearing: the finger slides.
        flow_terms: 1 for viscous flow, more for a rarefied gas.
        polytropic: the gas is not isothermal.
        uniform: the whole finger sees the full amplitude.
        curvature_x, curvature_y: largest |∂²s/∂X²|, |∂²s/∂Y²| of the profile under the finger,
            lengths in units of the finger's sides.
    """

    fold_x: bool
    fold_y: bool
    bearing: bool
    flow_terms: int
    polytropic: bool
    uniform: bool
    curvature_x: float
    curvature_y: float

    @property
    def halves_left_out(self) -> tuple[LeftOut, ...]:
        """Mirror images of what is solved."""
        why = "the profile is even about the finger's middle, and nothing else breaks that"
        folds = (("mirror half in x", self.fold_x), ("mirror half in y", self.fold_y))
        return tuple(LeftOut(what, why) for what, fold in folds if fold)

    @property
    def terms_left_out(self) -> tuple[LeftOut, ...]:
        """Terms of the full equation that are zero for this scene."""
        parts = (
            (not self.bearing, "bearing term", "the finger is at rest"),
            (self.flow_terms == 1, "rarefaction", "gas.rarefaction is none"),
            (not self.polytropic, "heating", "gas.polytropic_exponent is 1"),
        )
        return tuple(LeftOut(what, why) for out, what, why in parts if out)


@dataclass(frozen=True)
class LeftOut:
    """One thing that a scene does not need, and why not."""

    what: str
    why: str


def needs_of(scene: Scene) -> Needs:
    """What the scene needs, found from its profile, motion and gas.

    Sliding along x breaks the symmetry along x.
    """
    even_x, even_y, uniform, curvature_x, curvature_y = _shape_under_finger(_Place(scene))
    bearing = scene.bearing_number != 0
    return Needs(
        fold_x=even_x and not bearing,
        fold_y=even_y,
        bearing=bearing,
        flow_terms=len(scene.flow_coefficients),
        polytropic=scene.gas.polytropic_exponent != 1,
        uniform=uniform,
        curvature_x=curvature_x,
        curvature_y=curvature_y,
    )


class _Place:
    """A scene as far as the profile under the finger goes: scenes at one place are equal."""

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self.key = (scene.actuator.profile, scene.finger, scene.x_m, scene.y_m)

    def __hash__(self) -> int:
        return hash(self.key)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Place) and self.key == other.key


@lru_cache(maxsize=4096)
def _shape_under_finger(place: _Place) -> tuple[bool, bool, bool, float, float]:
    """Evenness along x and y, uniformity, and largest curvature along x and y."""
    probe = axis(PROBE_POINTS, False)
    x, y = np.meshgrid(probe.all_nodes, probe.all_nodes, indexing="ij")
    s = place.scene.amplitude(x, y)
    twice = probe.derivative @ probe.derivative
    return (
        bool(np.abs(s[::-1] - s).max() < SYMMETRIC),
        bool(np.abs(s[:, ::-1] - s).max() < SYMMETRIC),
        bool(np.abs(s - 1).max() < SYMMETRIC),
        float(np.abs(twice @ s).max()),
        float(np.abs(s @ twice.T).max()),
    )
