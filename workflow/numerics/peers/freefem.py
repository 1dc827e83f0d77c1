"""Finite elements once more, by FreeFEM where it is installed: what its user would write.

The scheme of finite_elements.py on quadratic triangles (freefem.edp), in a process of its own: its
time includes the start of the program and a factorisation for each Newton step, as in its manual.

Order: 2 in time, 4 in space for the force on a smooth film.
Source: Hecht, J. Numer. Math. 20 (2012), 251-265.
"""

import shutil
import subprocess
import tempfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from numerics.peers.finite_elements import NEWTON_STEPS, NEWTON_TOLERANCE, marched_rung
from numerics.peers.yardstick import Amplitude, Fold, YardstickResult, graded_edges
from numerics.timing import processor_seconds
from squeezefilm.io.errors import RunError

PROGRAM = "FreeFem++"
SCRIPT = Path(__file__).with_name("freefem.edp")


def installed() -> bool:
    """Whether there is a FreeFEM on the path."""
    return shutil.which(PROGRAM) is not None


def periodic_force(
    *,
    epsilon: float,
    sigma: float,
    amplitude: Amplitude,
    cells: int = 8,
    steps: int = 32,
    periods: int = 150,
    fold: Fold = (False, False),
) -> YardstickResult:
    """Mean force in p0 l0^2 over the last period from rest.

    cells: elements along each half side, folded or not, each of two triangles; steps: time steps a
    period; periods: marched.

    Raises RunError when FreeFEM stops before it is done.
    """
    start = processor_seconds()
    edges = [graded_edges(cells=cells, folded=folded) for folded in fold]
    counts = [len(each) - 1 for each in edges]
    numbers = [*counts, *map(int, fold), steps, periods, epsilon, sigma]
    numbers += [NEWTON_STEPS, NEWTON_TOLERANCE, *np.concatenate(edges)]
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        _run(folder, [0, *numbers])
        x, y = np.loadtxt(folder / "points.txt", unpack=True)
        np.savetxt(folder / "shape.txt", amplitude(x, y), fmt="%.17g")
        _run(folder, [1, *numbers])
        force, change = np.loadtxt(folder / "result.txt")
    return YardstickResult(
        force=float(force) * 2 ** sum(fold),
        cpu_seconds=processor_seconds() - start,
        periods=periods,
        change=float(change),
        settings={"cells": cells, "steps": steps, "fold": fold},
    )


def _run(folder: Path, numbers: Sequence[float]) -> None:
    """Run the script in a folder; the numbers are what it reads from settings.txt."""
    text = "".join(f"{number:.17g}\n" for number in numbers)
    (folder / "settings.txt").write_text(text, encoding="utf-8")
    command = [PROGRAM, "-nw", "-v", "0", str(SCRIPT)]
    run = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    if run.returncode:
        said = "; ".join(line.strip() for line in (run.stdout + run.stderr).splitlines()[:3])
        raise RunError(f"FreeFEM stopped: {said}")


METHODS = {"elements_from_rest_freefem": marched_rung}
DEVICE = "FreeFEM"
