"""A gas that is not isothermal: its density follows the pressure as ρ = P^(1/n)."""

from __future__ import annotations

from squeezefilm.film.scene import OperatingPoints, Scene
from squeezefilm.reynolds.terms.term import AbsentTerm, NamedNumbers, Term


class Polytropic(Term):
    label = "polytropic gas"
    NAME = "polytropic"
    ABSENT_TERM = AbsentTerm("polytropic gas", "gas.polytropic_exponent is 1")
    KERNEL_FILE = "terms/polytropic_over_period.cl"

    @classmethod
    def of(cls, scene: Scene) -> Polytropic | None:
        return cls() if scene.gas.polytropic_exponent != 1 else None

    def equation_numbers(self, scene: OperatingPoints) -> NamedNumbers:
        return {"inverse_exponent": 1 / scene.gas.polytropic_exponent}
