"""A gap of any shape: H = G(x, y) + ε (s₁ sin T + s₂ cos T).

No term of the equation but what all of them work in. Without it the kernels are compiled for a gap
that is even at rest and moves in one phase, H = 1 + ε s sin T (grid_over_period.cl).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from squeezefilm.film.scene import Scene
from squeezefilm.reynolds.terms.term import NEGLIGIBLE, LeftOut, Numbers, Term

SHAPED, TWO_PHASES = "gap that is shaped at rest", "vibration in two phases"


@dataclass(frozen=True)
class AnyGap(Term):
    """``label`` says in which way the gap is not the plain one.

    Its numbers: the least gap over h0 in a period, and what the gap at rest is over h0 more than 1
    for each metre that it is wider than h0.
    """

    NAME = "any_gap"
    ABSENT = LeftOut("gap of any shape", "it is even at rest and moves in one phase")

    @classmethod
    def of(cls, scene: Scene) -> AnyGap | None:
        if scene.plain:
            return None
        shaped = not scene.finger.gap.flat
        both = ", ".join(
            label for label, has in ((SHAPED, shaped), (TWO_PHASES, scene.two_phases)) if has
        )
        return cls(both)

    @classmethod
    def put_back(cls, scene: Scene) -> Scene:
        gap = replace(scene.finger.gap, bulge_m=NEGLIGIBLE * scene.h0_m)
        return replace(scene, finger=replace(scene.finger, gap=gap))

    def numbers(self, scene: Scene) -> Numbers:
        return {"narrowest": scene.narrowest, "per_rise": 1 / scene.h0_m}

    def knows_limit(self, name: str) -> bool:
        return name != "closed-form"

    def refused_by_march(self, scene: Scene) -> str:
        return f"march is for a gap that is even at rest and moves in one phase, not a {self.label}"

    def refused_in_modes(self, scene: Scene) -> str:
        return ""
