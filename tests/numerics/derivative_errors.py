"""How far derivatives are off beside their errors, and what they cost beside forces.

PYTHONPATH=tests/numerics python tests/numerics/derivative_errors.py [FILMS [SEED]]
"""

import sys
import time
from collections.abc import Sequence
from pathlib import Path
from statistics import median

import numpy as np
import pandas as pd
from films import PISTON, SINC, film

from squeezefilm.config.loading import load_config
from squeezefilm.film.scene import Scene
from squeezefilm.io.tables import scene_points
from squeezefilm.reynolds import solve
from squeezefilm.reynolds.effects.derivatives import with_derivatives
from squeezefilm.studies.study import scene_of

ROOT = Path(__file__).parents[2]
PLANS = ("screen_forces", "four_factor_forces")


def drawn(count: int, *, seed: int) -> list[Scene]:
    """Films of all kinds."""
    random = np.random.default_rng(seed)
    return [
        film(
            epsilon=random.uniform(0.01, 0.8),
            sigma=10 ** random.uniform(-0.5, 4.5),
            profile=PISTON if random.random() < 0.2 else SINC,
            x=random.choice([0.0, random.uniform(0, 0.3)]),
            y=random.choice([0.0, random.uniform(0, 0.3)]),
            bearing=random.choice([0.0, 0.0, 10 ** random.uniform(-2, 1.3)]),
            aspect=random.choice([1.0, 10 ** random.uniform(-0.4, 0.4)]),
            rarefaction=str(random.choice(["none", "slip", "fukui-kaneko"])),
            knudsen=10 ** random.uniform(-3, -1.7),
            polytropic_exponent=float(random.choice([1.0, 1.2, 1.4])),
        )
        for _ in range(count)
    ]


def shares(scenes: Sequence[Scene], *, tolerance: float, judge: float) -> list[float]:
    """Each derivative's difference from that of a tighter tolerance over the errors of both."""
    solutions = solve(scenes, tolerance=tolerance)
    mine, true = (with_derivatives(scenes, solutions, tolerance=t) for t in (tolerance, judge))
    found = []
    for each, other in zip(mine, true, strict=True):
        a, b = each.derivatives, other.derivatives
        assert a is not None
        assert b is not None
        if (a.status, b.status) != ("ok", "ok"):
            print(f"{tolerance:g}: {a.status}; judge: {b.status}")
            continue
        for number, value in a.value.items():
            if allowed := a.error[number] + b.error[number]:
                found.append(abs(value - b.value[number]) / allowed)
    return found


def cost(scenes: Sequence[Scene], *, tolerance: float) -> tuple[float, float]:
    """Processor seconds of the forces and of their derivatives, medians of three."""
    pairs = []
    for _ in range(4):
        start = time.process_time()
        solutions = solve(scenes, tolerance=tolerance)
        solved = time.process_time()
        with_derivatives(scenes, solutions, tolerance=tolerance)
        pairs.append((solved - start, time.process_time() - solved))
    forces, derivatives = zip(*pairs[1:], strict=True)
    return median(forces), median(derivatives)


def planned(name: str) -> list[Scene]:
    """The scenes of one of the paper's plans."""
    config = load_config(ROOT / "config" / "paper.yaml")
    table = pd.read_csv(ROOT / "tests" / "reference" / f"{name}.csv", dtype={"point_id": str})
    return [scene_of(point, config) for point in scene_points(table)]


def main(count: str = "40", seed: str = "1") -> None:
    scenes = drawn(int(count), seed=int(seed))
    for tolerance in (1e-2, 1e-3, 1e-4):
        each = shares(scenes, tolerance=tolerance, judge=1e-5)
        print(
            f"{tolerance:g}: {len(each)} derivatives, off by {max(each):.2f} of the error at most"
        )
    for name in PLANS:
        plan = planned(name)
        for tolerance in (1e-4, 1e-6):
            forces, derivatives = cost(plan, tolerance=tolerance)
            print(
                f"{name} at {tolerance:g}: forces {forces:.3f} s, derivatives {derivatives:.3f} s"
            )


if __name__ == "__main__":
    main(*sys.argv[1:])
