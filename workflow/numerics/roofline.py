"""The solver's parts beside the limits of the device they run on (a roofline, as a table).

Arithmetic is set against a multiply-add peak in double precision and memory against a stream triad,
both measured through the same OpenCL queue (Williams, Waterman and Patterson, Comm. ACM 52 (2009),
65–76). A limit is what the device can do at its best: all rates are those of the fastest of some
repeats, and the peak is measured anew beside each grid, for a processor's clock changes.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from numerics.films import Film
from numerics.peers.fixed_grid import problems_on_grid
from squeezefilm.reynolds.device import PADDING, Device, kernel
from squeezefilm.reynolds.grid import Grid, grid_matrices
from squeezefilm.reynolds.layout import Pile, c_struct, rows_of
from squeezefilm.reynolds.periodic.launch import solve_batch
from squeezefilm.reynolds.periodic.sizes import iteration_flops, sizes_of
from squeezefilm.reynolds.periodic.time_modes import steps_of, time_modes

SOURCES = ("linear_algebra.cl", "vectors.cl", "periodic/grid_over_period.cl", "roofline.cl")
REPEATS = 5
PEAK_TURNS = 1_000_000
MATRIX_SIZE = 1000
TRIAD_BYTES = {"in cache": 192 * 2**10, "in memory": 192 * 2**20}
TRIAD_TRAFFIC_BYTES = 4e9
PRODUCT_FLOPS = 1e9
# Quarter and whole finger of the paper's scenes, and a grid for a stiff scene.
GRIDS = {
    "quarter": Grid(nx=12, ny=12, nt=16, fold_x=True, fold_y=True),
    "whole": Grid(nx=24, ny=24, nt=16, fold_x=False, fold_y=False),
    "fine": Grid(nx=48, ny=48, nt=24, fold_x=False, fold_y=False),
}


@dataclass(frozen=True)
class Rate:
    """One part's speed; a share is relative to the limit that binds it."""

    part: str
    grid: str
    gflop_per_s: float
    gbyte_per_s: float
    binding: str
    share: float


def measure(device: Device) -> list[Rate]:
    """Rates of all compute units together, by the wall clock."""

    def seconds(name: str, *arguments: Any) -> float:
        row_type = c_struct("Row", _row(GRIDS["quarter"])[0].dtype)
        header = f"#define FLOW_TERMS 1\n#define UNKNOWN_FIELDS 1\n#define ROW_PARTS 0\n{row_type}"
        handle = kernel(device, name, sources=SOURCES, header=header)
        shape = (device.groups * device.work_items,), (device.work_items,)

        def run() -> None:
            handle(device.queue, *shape, *arguments)
            device.queue.finish()

        return _fastest_seconds(run)

    def peak() -> float:
        items = device.groups * device.work_items
        values = device.sent(np.zeros(items + PADDING))
        time_s = seconds("multiply_add_peak", PEAK_TURNS, values)
        return 2 * 12 * device.lanes(8) * PEAK_TURNS * items / time_s / 1e9

    peaks = [peak()]
    if device.processor:  # a peak that a library's matrix product surpasses is none
        peaks.append(_matrix_product_rate())
    streams = []
    for name, size in TRIAD_BYTES.items():
        count4 = size // (3 * 32)
        turns = max(1, int(TRIAD_TRAFFIC_BYTES / (96 * count4 * device.groups)))
        fields = [device.sent(np.ones(4 * count4 * device.groups)) for _ in range(3)]
        time_s = seconds("stream_triad", count4, turns, *fields)
        stream = 96 * count4 * turns * device.groups / time_s / 1e9
        streams.append(Rate(f"stream triad {name}", "", 0.0, stream, "memory", 1.0))
    parts: list[tuple[str, str, float]] = []
    for name, grid in GRIDS.items():
        row, matrices = (device.sent(values) for values in _row(grid))
        nx, ny, nt = grid.shape
        workspace = device.sent(np.zeros(2 * nx * ny * nt * device.groups + PADDING))
        inner_x, inner_y = grid.space_products
        inner_of = (("along x", inner_x), ("along y", inner_y), ("along t", nt))
        for which, (part, inner) in enumerate(inner_of):
            flops = 2.0 * nx * ny * nt * inner
            turns = int(PRODUCT_FLOPS / flops)
            time_s = seconds("panel_products", which, turns, row, matrices, workspace)
            rate = flops * turns * device.groups / time_s / 1e9
            parts.append((f"product {part}", name, rate))
        parts.append(("whole solve", name, _solve_rate(grid, device)))
        peaks.append(peak())
    limit = max(peaks)
    return [
        Rate("multiply-add peak", "", limit, 0.0, "arithmetic", 1.0),
        *streams,
        *(Rate(part, name, rate, 0.0, "arithmetic", rate / limit) for part, name, rate in parts),
    ]


def _matrix_product_rate() -> float:
    """GFLOP/s of NumPy's product of two large matrices."""
    matrix = np.random.default_rng(1).random((MATRIX_SIZE, MATRIX_SIZE))
    return 2 * MATRIX_SIZE**3 / _fastest_seconds(lambda: matrix @ matrix) / 1e9


def _solve_rate(grid: Grid, device: Device) -> float:
    """GFLOP/s of a batch's whole Newton–Krylov solve, counting its products alone."""
    scenes = 8 * device.groups
    films = [Film("", 0.4, sigma) for sigma in np.linspace(583.0, 2331.0, scenes)]
    problems = problems_on_grid(films, grid=grid, tolerance=1e-8)
    states = solve_batch(problems=problems, grid=grid, device=device)
    iterations = states.krylov_iterations.sum() + states.newton_steps.sum()

    def run() -> None:
        solve_batch(problems=problems, grid=grid, device=device)

    return float(iterations * iteration_flops(grid) / _fastest_seconds(run) / 1e9)


def _row(grid: Grid) -> tuple[np.ndarray, np.ndarray]:
    """The grid as kernels take it: a row of sizes and places, and the matrices."""
    pile = Pile()
    rest = np.zeros(1)
    (steps,) = steps_of(variation=rest, lagging=rest, lag=rest, slow=rest + 1)
    row = rows_of(
        [
            sizes_of(grid, ()),
            pile.add(grid_matrices(grid, aspect=1.0, terms=())),
            pile.add(time_modes(grid.nt, steps).parts),
        ],
        numbers=np.empty(1, dtype=[]),
    )
    return row, pile.values


def _fastest_seconds(run: Callable[[], object]) -> float:
    """Wall seconds of a call, after one that warms it."""
    run()
    spans = []
    for _ in range(REPEATS):
        start = time.perf_counter()
        run()
        spans.append(time.perf_counter() - start)
    return min(spans)
