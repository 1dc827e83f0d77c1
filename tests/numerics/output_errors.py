"""How far answers beside the force are off beside their errors.

PYTHONPATH=tests/numerics python tests/numerics/output_errors.py [FILMS [SEED]]
"""

import sys
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from derivative_errors import drawn

from squeezefilm.film.scene import Scene
from squeezefilm.quantities.outputs import FROM_STATE, with_outputs
from squeezefilm.reynolds import solve
from squeezefilm.solution import OUTPUTS

ASKED = tuple(name for name in OUTPUTS if name in FROM_STATE)


def with_inertia(scenes: Sequence[Scene]) -> list[Scene]:
    """Every third, of those that may have it."""
    return [
        replace(scene, gas=replace(scene.gas, inertia="included"))
        if k % 3 == 0
        and scene.gas.rarefaction != "fukui-kaneko"
        and scene.bearing_number == 0
        and scene.modified_reynolds * scene.epsilon < 1
        else scene
        for k, scene in enumerate(scenes)
    ]


def shares(scenes: Sequence[Scene], *, tolerance: float, judge: float) -> dict[str, list[float]]:
    """Each answer's difference from that of a tighter tolerance over the errors of both."""
    solutions = solve(scenes, tolerance=1e-2)
    mine, true = (
        with_outputs(scenes, solutions, outputs=ASKED, tolerance=t) for t in (tolerance, judge)
    )
    found = defaultdict(list)
    for each, other in zip(mine, true, strict=True):
        a, b = each.outputs, other.outputs
        assert a is not None
        assert b is not None
        if a.status != b.status:
            print(f"{tolerance:g}: {a.status}; judge: {b.status}")
        for name in a.value.keys() & b.value.keys():
            if allowed := a.error[name] + b.error[name]:
                found[name].append(abs(a.value[name] - b.value[name]) / allowed)
    return found


if __name__ == "__main__":
    films = int(sys.argv[1]) if len(sys.argv) > 1 else 40
    seed = int(sys.argv[2]) if len(sys.argv) > 2 else 1
    scenes = with_inertia(drawn(films, seed=seed))
    for tolerance in (1e-2, 1e-3, 1e-4):
        for name, found in shares(scenes, tolerance=tolerance, judge=1e-6).items():
            print(f"{tolerance:g} {name}: {len(found)}, {np.max(found):.2g} of the errors at most")
