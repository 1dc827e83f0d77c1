"""Forces under random ellipses and patches at 1e-4, beside much closer ones, and what they cost.

    PYTHONPATH=tests/numerics python tests/numerics/outline_errors.py COUNT SEED

A row for each pad; at the end the largest errors, over tolerance and estimate, and the wall-clock
time of all of them in one call over that of flat rectangles of the same numbers.
"""

import random
import sys
import tempfile
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
from films import PISTON, film

from squeezefilm.film.finger import GapShape
from squeezefilm.film.outline import read_contour
from squeezefilm.film.scene import Scene
from squeezefilm.reynolds.solver import solve

TOLERANCE, CLOSE = 1e-4, 3e-6
TURN = 2 * np.pi * np.arange(200) / 200
DENSE = 2 * np.pi * np.arange(40_000) / 40_000


def drawn(rng: random.Random, folder: Path) -> tuple[Scene, Scene, str]:
    """A pad, a flat rectangle of the same numbers, and what it is."""
    numbers = {"epsilon": rng.uniform(0.02, 0.9), "sigma": 10 ** rng.uniform(0, 5)}
    numbers["aspect"] = 2 ** rng.uniform(-1.7, 1.7)
    for place in rng.choice(["", "", "x", "y", "xy"]):
        numbers[place] = rng.uniform(0.02, 0.4)
    gas = rng.choice([{}, {}, {"rarefaction": "fukui-kaneko", "polytropic_exponent": 1.4}])
    profile = rng.choice([{}, {}, {"profile": PISTON}])
    flat = film(**numbers, **gas, **profile)  # type: ignore[arg-type]
    kind = rng.choice(["ellipse", "patch"])
    sides = {"length_x_m": flat.finger.length_x_m, "length_y_m": flat.finger.length_y_m}
    contour = None
    if kind == "patch":
        half_x, half_y = 500 * sides["length_x_m"], 500 * sides["length_y_m"]
        size, waves = min(half_x, half_y), range(2, 6)
        parts = [(k, rng.uniform(-0.25, 0.25) * size / k**2, rng.uniform(0, 6.28)) for k in waves]

        def rim(turn: np.ndarray) -> np.ndarray:
            wavy = sum(part * np.cos(k * turn + phase) for k, part, phase in parts)
            return half_x * np.cos(turn) + 1j * half_y * np.sin(turn) + np.exp(1j * turn) * wavy

        path = folder / f"{rng.random()}.csv"
        rows = "".join(f"{z.real:.9f},{z.imag:.9f}\n" for z in rim(TURN))
        path.write_text(f"x_mm,y_mm\n{rows}", encoding="utf-8")
        extents = 1e-3 * np.ptp(rim(DENSE).real), 1e-3 * np.ptp(rim(DENSE).imag)
        contour = read_contour(path, sides_m=extents)
        sides = dict(zip(sides, extents, strict=True))
    gap = GapShape()
    if rng.random() < 0.3:
        room = 0.5 * flat.h0_m * (1 - flat.epsilon)
        tilts = (rng.uniform(-room, room) for _ in range(2))
        gap = GapShape(*tilts, bulge_m=rng.uniform(-room, room) / 2)
    finger = replace(
        flat.finger, shape="curve" if contour else kind, contour=contour, gap=gap, **sides
    )
    return replace(flat, finger=finger), flat, kind


def main(count: int, seed: int) -> None:
    rng = random.Random(seed)
    with tempfile.TemporaryDirectory() as folder:
        films = [drawn(rng, Path(folder)) for _ in range(count)]
    pads, flats = [pad for pad, _, _ in films], [flat for _, flat, _ in films]
    worst = [0.0, 0.0, 0.0]
    refused = 0
    solve(pads, tolerance=1e-2)
    for pad, _, kind in films:
        begun = time.perf_counter()
        (found,) = solve([pad], tolerance=TOLERANCE)
        seconds = time.perf_counter() - begun
        (close,) = solve([pad], tolerance=CLOSE)
        row = f"{kind:8} eps {pad.epsilon:.2f} sigma {pad.sigma:8.3g} aspect {pad.aspect:.2f}"
        if (found.status, close.status) != ("ok", "ok"):
            refused += 1
            print(f"{row}: {found.status} | {close.status}", flush=True)
            continue
        off = abs(found.force_n - close.force_n)
        shares = off / abs(close.force_n) / TOLERANCE, off / found.force_error_n, seconds
        worst = [max(pair) for pair in zip(worst, shares, strict=True)]
        text = "of the tolerance {:.3f}, of the estimate {:.3f}, {:.3f} s".format(*shares)
        print(f"{row}: {text}", flush=True)
    print("largest: of the tolerance {:.2f}, of the estimate {:.2f}, {:.2f} s".format(*worst))
    print(f"without a force: {refused} of {count}")
    ratios = []
    for _ in range(3):
        times = [time.perf_counter()]
        solve(pads, tolerance=TOLERANCE)
        times.append(time.perf_counter())
        solve(flats, tolerance=TOLERANCE, method="periodic")
        times.append(time.perf_counter())
        ratios.append(np.diff(times)[0] / np.diff(times)[1])
    print(f"time over that of flat rectangles: {sorted(ratios)[1]:.1f}")


if __name__ == "__main__":
    main(int(sys.argv[1]), int(sys.argv[2]))
