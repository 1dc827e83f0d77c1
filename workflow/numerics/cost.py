"""Run time and memory against the size of the problem, each size in a process of its own."""

import json
import math
import os
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from numerics.timing import run_python
from squeezefilm.io.progress import say

# Random operating points of the paper's experimental space, as a user's plan has them.
PRELUDE = """
import json, resource, time
import numpy as np
from numerics.films import Film
from numerics.peers.fixed_grid import solve_on_grid
from squeezefilm.reynolds import solve
from squeezefilm.reynolds.device import choose_device
from squeezefilm.reynolds.grid import Grid
device = choose_device({device!r})
random = np.random.default_rng(1)
def films(count):
    return [
        Film("", random.uniform(0.02, 0.4), random.uniform(583, 2331)) for _ in range(count)
    ]
def run():
{body}
{prepare}
runs = []
while len(runs) <= {repeats} and sum(wall for _, wall in runs) < 3:
    wall, cpu = time.perf_counter(), time.process_time()
    run()
    runs.append((time.process_time() - cpu, time.perf_counter() - wall))
runs = runs[1:] or runs
cpu, wall = (float(np.median(values)) for values in zip(*runs))
peak = 1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
print(json.dumps([cpu, wall, peak]))
"""


@dataclass(frozen=True)
class Size:
    """One point on an axis: what is timed (`body`, after `prepare`), with how many threads."""

    axis: str
    method: str
    size: int
    scenes: int
    body: str
    prepare: str
    threads: int | None = None


def sizes(*, full: bool) -> list[Size]:
    """Scenes, points across the finger, instants, cores, and scenes a call."""
    found = []
    for method in ("auto", "periodic") if full else ("periodic",):
        most = {"auto": 100_000, "periodic": 10_000}[method] if full else 100
        counts = [10**k for k in range(6) if 10**k <= most]
        found += [
            Size(
                "scenes",
                method,
                count,
                count,
                f"    solve(scenes, tolerance=1e-3, method={method!r}, device=device)",
                f"scenes = [film.scene for film in films({count})]",
            )
            for count in counts
        ]
    given = "    solve_on_grid(some, grid=grid, tolerance=1e-6, device=device)"
    for axis, values in (
        ("points", (8, 16, 24, 32, 48, 64, 96)),
        ("instants", (8, 16, 32, 64, 128)),
    ):
        for value in values if full else values[:2]:
            n, nt = (value, 16) if axis == "points" else (24, value)
            grid = f"Grid(nx={n // 2}, ny={n // 2}, nt={nt}, fold_x=True, fold_y=True)"
            prepare = f"some, grid = films(4), {grid}"
            found.append(Size(axis, "periodic", value, 4, given, prepare))
    many = 1000 if full else 50
    scenes = f"scenes = [film.scene for film in films({many})]"
    whole = "    solve(scenes, tolerance=1e-6, method='periodic', device=device)"
    cores = (os.cpu_count() or 1) if full else 1
    for threads in sorted({min(2**k, cores) for k in range(7)}):
        found.append(Size("cores", "periodic", threads, many, whole, scenes, threads))
    for chunk in [1, 10, 100, 1000] if full else [1, 10]:
        body = (
            f"    for first in range(0, len(scenes), {chunk}):\n"
            f"        solve(scenes[first:first + {chunk}], tolerance=1e-6, method='periodic', "
            "device=device)"
        )
        found.append(Size("chunk", "periodic", chunk, many, body, scenes))
    return found


def cost(
    chosen: list[Size],
    *,
    repeats: int,
    device: str,
    device_name: str,
) -> pd.DataFrame:
    """A row per size; seconds and bytes of the whole run, exponents of the processor
    time, or of the wall time along the axis of cores.

    Raises RunError when a process fails.
    """
    rows = []
    for size in chosen:
        say(f"{size.axis}, {size.method}: {size.size}")
        cpu, wall, peak = _run(size, repeats=repeats, device=device)
        rows.append(
            {
                "axis": size.axis,
                "method": size.method,
                "size": size.size,
                "scenes": size.scenes,
                "cpu_seconds": cpu,
                "wall_seconds": wall,
                "peak_bytes": peak,
                "device": device_name,
            }
        )
    table = pd.DataFrame(rows)
    for (axis, _), line in table.groupby(["axis", "method"]):
        seconds = "wall_seconds" if axis == "cores" else "cpu_seconds"
        start, exponent = _exponent(line["size"], line[seconds])
        table.loc[line.index, "exponent"] = exponent
        table.loc[line.index, "exponent_from"] = start
    return table


def _run(size: Size, *, repeats: int, device: str) -> tuple[float, float, int]:
    code = PRELUDE.format(device=device, body=size.body, prepare=size.prepare, repeats=repeats)
    threads = {} if size.threads is None else {"POCL_MAX_PTHREAD_COUNT": str(size.threads)}
    said = run_python(code, what=f"{size.axis}, {size.size}", environment=threads)
    cpu, wall, peak = json.loads(said.splitlines()[-1])
    return cpu, wall, peak


def _exponent(size: Any, seconds: Any) -> tuple[float, float]:
    """Least-squares slope of log seconds over log size for the larger half, and where it starts."""
    size, seconds = np.asarray(size, dtype=float), np.asarray(seconds, dtype=float)
    larger = size >= size[len(size) // 2] if len(size) > 3 else size > 0
    if larger.sum() < 2:
        return math.nan, math.nan
    slope = np.polyfit(np.log(size[larger]), np.log(seconds[larger]), 1)[0]
    return float(size[larger].min()), float(slope)
