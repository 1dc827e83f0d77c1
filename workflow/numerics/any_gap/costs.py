"""What a gap that is shaped at rest costs beside an even one: processor time, and why."""

from __future__ import annotations

from dataclasses import replace
from statistics import fmean, median
from typing import Any

import numpy as np
import pandas as pd

from numerics.any_gap.cases import shape, travelling
from numerics.films import SINC, Film
from numerics.timing import processor_seconds
from squeezefilm.film.vibration.shapes import StandingWave
from squeezefilm.io.solution import Solution
from squeezefilm.reynolds.device import Device
from squeezefilm.reynolds.needs import Needs, needs_of
from squeezefilm.reynolds.periodic.refinement import solve_periodic

SIGMA = (20.0, 583.0, 2331.0)
EPSILON = (0.1, 0.42)
SEED = 17
PLACES = {"centred": (0.0, 0.0), "off centre": (0.1, 0.05)}
STANDING = StandingWave(0.02, 0.0, crest_m=0.0)
# Gaps in units of h0, or motions, each with the plain film that it is held against.
KINDS: dict[str, tuple[dict[str, Any], dict[str, Any]]] = {
    "tilted by 0.2": ({"gap": shape(0.2)}, {}),
    "tilted by 0.4": ({"gap": shape(0.4)}, {}),
    "tilted by 0.6": ({"gap": shape(0.6)}, {}),
    "tilted by 0.4 and across by 0.2": ({"gap": shape(0.4, 0.2)}, {}),
    "tilted by 0.6 and across by 0.2": ({"gap": shape(0.6, 0.2)}, {}),
    "bulging by 0.3": ({"gap": shape(bulge=0.3)}, {}),
    "hollow by 0.15": ({"gap": shape(bulge=-0.15)}, {}),
    "travelling wave, beside a standing one": (
        {"profile": travelling(2.0)},
        {"profile": STANDING},
    ),
}


def costs(*, films: int, repeats: int, tolerance: float, device: Device) -> pd.DataFrame:
    """Rows: each of KINDS at each place; medians of repeats, taken by turns in one run.

    ``seconds_over_plain`` is as a user sees it, ``seconds_over_same_part`` beside the plain film
    solved on the same half or quarter of the finger, which is all that symmetry makes of it.

    Args:
        films: for each of SIGMA, solved in one call.
    """
    epsilons = np.random.default_rng(SEED).uniform(*EPSILON, films)
    rows = []
    for place, (x, y) in PLACES.items():
        for kind, (own, plain) in KINDS.items():
            base = [
                Film("", epsilon, sigma, profile=SINC, x=x, y=y)
                for epsilon in epsilons
                for sigma in SIGMA
            ]
            scenes = [
                [replace(film, **what).scene for film in base] for what in (plain, plain, own)
            ]
            needs = [[needs_of(scene) for scene in some] for some in scenes]
            needs[1] = [
                replace(even, fold_x=its.fold_x, fold_y=its.fold_y)
                for even, its in zip(needs[1], needs[2], strict=True)
            ]

            def run(which: int, scenes: Any = scenes, needs: Any = needs) -> Run:
                return _run(scenes[which], needs[which], tolerance=tolerance, device=device)

            runs = [[run(which) for which in range(3)] for _ in range(repeats + 1)][1:]
            seconds = [median(each[which][0] for each in runs) for which in range(3)]
            solutions = [runs[0][which][1] for which in range(3)]
            work, iterations = (
                [fmean(getattr(one, name) for one in some) for some in solutions]
                for name in ("work", "krylov_iterations")
            )
            rows.append(
                {
                    "kind": kind,
                    "place": place,
                    "films": len(base),
                    "refused": sum(one.status != "ok" for one in solutions[2]),
                    "seconds_over_plain": seconds[2] / seconds[0],
                    "seconds_over_same_part": seconds[2] / seconds[1],
                    "work_over_plain": work[2] / work[0],
                    "work_over_same_part": work[2] / work[1],
                    "iterations_over_same_part": iterations[2] / iterations[1],
                    "milliseconds": 1e3 * seconds[2] / len(base),
                }
            )
    return pd.DataFrame(rows)


Run = tuple[float, list[Solution]]


def _run(scenes: Any, needs: list[Needs], *, tolerance: float, device: Device) -> Run:
    # As new: a scene keeps what it was asked for.
    scenes = [replace(scene) for scene in scenes]
    begin = processor_seconds()
    solutions = solve_periodic(scenes, needs, tolerance=tolerance, device=device)
    return processor_seconds() - begin, solutions
