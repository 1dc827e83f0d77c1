"""Where the equation of a study is stretched, in per cent of the force.

Of what a study leaves out, inertia and slip move the mean force most. Notes say by how much, from
half a per cent on; they are estimates, not corrections.
"""

from __future__ import annotations

from squeezefilm.film.scene import Scene
from squeezefilm.reynolds.terms import LEAST_SHARE, TERMS

# Inertia's share of the mean force per unit of ρωh0²/μ: 4.4 % (centred) to 5.4 % (at the rim of the
# paper's disc) where the velocity across the gap was resolved, σ 146–2331, ε up to 0.4. The share
# grows more slowly beyond a tenth, and is not known for films that the gas flows out of freely.
INERTIA_SHARE = 0.047
INERTIA_MOST = 0.10
INERTIA_LEAST_SIGMA = 100.0


def regime_notes(scene: Scene) -> list[str]:
    """Where the isothermal Reynolds equation of this study is stretched: inertia, rarefaction."""
    notes = (_inertia(scene), *(kind.note(scene) for kind in TERMS))
    return [note for note in notes if note]


def _inertia(scene: Scene) -> str:
    share = INERTIA_SHARE * scene.modified_reynolds
    if share < LEAST_SHARE:
        return ""
    number = f"modified Reynolds number {scene.modified_reynolds:.2g}"
    if scene.sigma < INERTIA_LEAST_SIGMA:
        return f"inertia, left out, changes the force by an unknown share ({number})"
    if share > INERTIA_MOST:
        return f"inertia, left out, adds about {INERTIA_MOST:.0%} or more of the force ({number})"
    return f"inertia, left out, adds about {share:.1%} of the force ({number})"
