"""Which answers a scene does not have, known before anything is solved."""

from __future__ import annotations

import numpy as np

from squeezefilm.film.scene import Scene
from squeezefilm.reynolds.answers.samples import motion

AT_REST = "stiffness and damping are not known of a surface at rest"
TWO_PHASES = "stiffness and damping are of a surface that moves in one phase"
RAREFIED = "the shear of a sliding wall is not derived with fukui-kaneko"
# Motion with cos ωt over ε that counts as none.
NEGLIGIBLE = 1e-14


def formula_refusals(scene: Scene) -> dict[str, str]:
    """Why an output is missing, or a part of it, by its name in OUTPUTS (io/solution.py)."""
    found = {}
    if scene.epsilon == 0:
        found["harmonics"] = AT_REST
    elif np.abs(motion(scene, *scene.inside())[2]).max() > NEGLIGIBLE * scene.epsilon:
        found["harmonics"] = TWO_PHASES
    if scene.bearing_number != 0 and scene.gas.rarefaction == "fukui-kaneko":
        found["thrust"] = RAREFIED
    return found
