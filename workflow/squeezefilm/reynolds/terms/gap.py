"""A non-uniform gap: H = G(x, y) + ε (s₁ sin T + s₂ cos T).

No term of the equation but what all of them work in; where it is shaped at rest, preconditioners
share the rows of the linear system (gap_over_period.cl). Without it the kernels are compiled for a
gap that is even at rest and moves in one phase, H = 1 + ε s sin T (grid_over_period.cl).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from squeezefilm.film.scene import Scene, Scenes
from squeezefilm.reynolds.terms.term import AbsentTerm, NamedNumbers, Term

NON_UNIFORM_GAP_TEXT, TWO_COMPONENTS_TEXT = "non-uniform gap", "two quadrature components"
# Two preconditioners pay where the widest gap at rest is so many times the narrowest, and nothing
# else has a share in the film: they were no better for pads that slide or are no rectangles, and
# worse with inertia. They are for diffusivities inside of those, by this share of the way from the
# geometric mean, as Chebyshev's points lie inside an interval.
TWO_PRECONDITIONERS_GAP_RATIO = 1.75
PRECONDITIONER_SPREAD_EXPONENT = 0.65
# Least gap at rest over the largest that they know of; kernels are compiled with gaps that are
# closed somewhere, too.
MIN_STATIC_GAP_RATIO = 1e-3


@dataclass(frozen=True)
class NonuniformGap(Term):
    """A static gap that is not uniform, or a motion with two quadrature components.

    ``label`` names which of the two the film has.

    Its numbers: the least gap over h0 in a period, and what the gap at rest is over h0 more than 1
    for each metre that it is wider than h0; of its preconditioners where it is shaped at rest.

    Attributes:
        preconditioner_count: preconditioners that each take a part of the linear system's rows; 0
            where one has all of them.
    """

    label: str
    preconditioner_count: int = 0

    NAME = "any_gap"
    KERNEL_FILE = "terms/gap_over_period.cl"
    SUPPORTS_SINGLE_PRECISION = True
    SUPPORTS_EXPANSIONS = True
    ABSENT_TERM = AbsentTerm(NON_UNIFORM_GAP_TEXT, "the gap is uniform at rest and moves in phase")

    @classmethod
    def of(cls, scene: Scene) -> NonuniformGap | None:
        shaped, complex_ = not scene.pad.gap.flat, scene.actuator.profile.is_complex
        if not (shaped or complex_):
            return None
        kinds = {NON_UNIFORM_GAP_TEXT: shaped, TWO_COMPONENTS_TEXT: complex_}
        both = ", ".join(label for label, has in kinds.items() if has)
        if not shaped:
            return cls(both)
        more = scene.bearing_number or scene.gas.inertia == "included"
        alone = not (more or scene.pad.smooth_outline)
        return cls(both, 2 if alone and cls.two_preconditioners_mask(Scenes.of([scene]))[0] else 1)

    @staticmethod
    def two_preconditioners_mask(scenes: Scenes) -> np.ndarray:
        """Return where the static gap varies enough for two preconditioners to be cheaper, (n,)."""
        least, most = scenes.static_gap_ratio_range
        return np.asarray(most > TWO_PRECONDITIONERS_GAP_RATIO * least)

    def equation_numbers(self, scenes: Scenes) -> NamedNumbers:
        numbers: NamedNumbers = {
            "narrowest": scenes.narrowest_gap_ratio,
            "per_rise": 1 / scenes.h0_m,
        }
        return (
            {**numbers, **_preconditioner_numbers(scenes, self.preconditioner_count)}
            if self.preconditioner_count
            else numbers
        )


def _preconditioner_numbers(scenes: Scenes, count: int) -> NamedNumbers:
    """Diffusivities, in units of an even film's, and the first's part of rows (gap_over_period.cl).

    The part in numbers a and b: a + b/G² where the gap at rest is G. That of a single one is the
    typical G over G where that is least and where it is largest.
    """
    least, most = scenes.static_gap_ratio_range
    least = np.maximum(least, MIN_STATIC_GAP_RATIO * most)
    middle = least * most
    if count == 1:
        typical = scenes.static_gap_ratio_mean
        per_square = typical / (1 / least + 1 / most)
        return {"diffusivities": (typical**2,), "part": (per_square / middle, per_square)}
    spread = (most / least) ** PRECONDITIONER_SPREAD_EXPONENT
    small, large = middle / spread, middle * spread
    per_square = 1 / (1 / small - 1 / large)
    return {"diffusivities": (small, large), "part": (-per_square / large, per_square)}
