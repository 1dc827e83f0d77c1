"""How far derivatives are off beside their errors."""

from collections.abc import Sequence

import numpy as np
from films import PISTON, SINC, film

from squeezefilm.film.scene import Scene
from squeezefilm.quantities.derivatives import with_derivatives
from squeezefilm.reynolds import solve


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
