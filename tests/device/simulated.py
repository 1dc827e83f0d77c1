"""Tiny films on whichever device is named: what Oclgrind watches, work-item by work-item.

python tests/device/simulated.py DEVICE ITEMS KERNEL [FAULT] prints mean overpressures as JSON.
"""

import json
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

from squeezefilm.film.scene import Scenes
from squeezefilm.reynolds.device import Device, choose_device
from squeezefilm.reynolds.grid import Grid
from squeezefilm.reynolds.periodic.launch import Batch, grid_on_pad, launch, uses_single_precision
from squeezefilm.reynolds.self_test import test_cases
from squeezefilm.reynolds.terms import terms_of

KERNELS = tuple(test_cases())
# Every branch is reached, and steps in single precision end where devices agree.
TOLERANCE, IN_DOUBLE = 1e-6, 1e-3
# What is made wrong in vectors.cl on demand, to see that it is found.
SCALED = "FOR_EACH(i, count4 / (LANES / 4)) a_lanes[i] *= factor;\n    "
SOUND = f"{SCALED}SYNC;"
FAULTS = {
    "no barrier": SCALED,
    "barrier for some": f"{SCALED}if (get_local_id(0) > 0) {{ SYNC; }}",
}


def means(device: Device, kernel: str) -> list[float]:
    """Mean overpressures in units of p0: of a film on two grids, and another on the first."""
    scene, grid = test_cases()[kernel]
    terms = terms_of(scene)
    tolerance = TOLERANCE if uses_single_precision(terms) else IN_DOUBLE
    shape = grid.fold_x, grid.fold_y
    grids = [grid_on_pad(scene, Grid(points, 4, 8, *shape)) for points in (4, 6)]
    other = replace(scene, hv_m=0.7 * scene.hv_m)
    batches = [
        Batch(
            Scenes.of([each]), np.arange(1), terms, tuple(some), [tolerance] * len(some), many=True
        )
        for each, some in ((scene, grids), (other, grids[:1]))
    ]
    states = launch(batches, device=device).wait_for_states(device)
    return [float(state.mean_pressure_ratio[0]) for of_batch in states for state in of_batch]


def _make_wrong(fault: str) -> None:
    sound, wrong = Path.read_text, FAULTS[fault]

    def read_text(path, *arguments, **options):
        text = sound(path, *arguments, **options)
        assert path.name != "vectors.cl" or SOUND in text
        return text.replace(SOUND, wrong)

    Path.read_text = read_text


def main(device: str, items: str, kernel: str, *fault: str) -> None:
    for each in fault:
        _make_wrong(each)
    print(json.dumps(means(choose_device(device, work_items=int(items)), kernel)))


if __name__ == "__main__":
    main(*sys.argv[1:])
