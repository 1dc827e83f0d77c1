"""Mean squeeze-film forces by solving the Reynolds equation, each with an error estimate.

  squeezefilm simulate SCENES.csv --config CONFIG.yaml --output FORCES.csv
  squeezefilm simulate --h0 5um --hv 2.2um

Tolerance means |error| <= tolerance * |force| + round-off floor, the floor being 1e-14 of the
largest overpressure times the finger's area. The exit status is 1 when a scene has no force; all
rows are written nevertheless, each with its status. In a table `force_error_n` is the solver's
error; what the noise of a measured profile adds, `squeezefilm profile` says. `--derivatives` adds
those of the force to h0, hv, the finger's place (x, y) and each number of the gas, the others kept,
with their errors, by one adjoint problem per scene; `derivatives_status` says why there are none.
"""

import argparse
import sys
import time
from collections.abc import Sequence
from contextlib import nullcontext
from functools import partial
from math import isfinite
from pathlib import Path

import pandas as pd

from squeezefilm.film.scene import Scene
from squeezefilm.film.vibration.folds import FOLDED
from squeezefilm.io.errors import InputError, RunError, naming
from squeezefilm.io.progress import progress_bar
from squeezefilm.io.tables import (
    FORCE_COLUMNS,
    ScenePoint,
    all_rows,
    read_scenes,
    scene_points,
    table_writer,
)
from squeezefilm.io.typed_units import quantity, with_error
from squeezefilm.reynolds import Solution, solve
from squeezefilm.reynolds.device import Device
from squeezefilm.reynolds.effects.automatic import decided
from squeezefilm.reynolds.effects.budget import budgets
from squeezefilm.reynolds.effects.derivatives import with_derivatives
from squeezefilm.reynolds.effects.words import budget_text, derivatives_text
from squeezefilm.reynolds.periodic.launch import warm
from squeezefilm.reynolds.terms import notes_of
from squeezefilm.runs import node_cache
from squeezefilm.studies.config import Config, load_config
from squeezefilm.studies.solver_settings import (
    SolverSettings,
    add_solver_arguments,
    device_of,
    solver_settings,
)
from squeezefilm.studies.study import scene_of, smoothed_scan_of

SECTIONS = ("gas", "actuator", "finger", "solver")
PAPER_CONFIG = Path(__file__).parents[4] / "config" / "paper.yaml"
# Scenes whose results are held before they are written.
PIECE = 4096


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("scenes", nargs="?", metavar="SCENES.csv", help="table of scenes")
    parser.add_argument(
        "--config", default=PAPER_CONFIG, help="the study; the paper's if left out", type=Path
    )
    parser.add_argument("--output", metavar="FORCES.csv", help="table of forces to write")
    parser.add_argument("--timings", metavar="TIMINGS.csv", help="table of run times to write")
    add_solver_arguments(parser)
    parser.add_argument(
        "--device", help="instead of SQUEEZEFILM_DEVICE and the config's solver.device"
    )
    parser.add_argument("--chunk", metavar="I/N", help="only the I-th of N parts of the table")
    parser.add_argument(
        "--keep-going", action="store_true", help="exit with 0 although a scene has no force"
    )
    parser.add_argument(
        "--derivatives", action="store_true", help="of the force too, to each number of a scene"
    )
    one = parser.add_argument_group("one scene, without files")
    one.add_argument("--h0", help="mean gap with its unit, e.g. 5um")
    one.add_argument("--hv", help="amplitude at the profile's maximum, e.g. 2.2um")
    one.add_argument("--phi-r", default="0 m", help="finger's distance from the centre, e.g. 2.9mm")
    one.add_argument("--phi", default="0 deg", help="finger's direction, e.g. 45deg")


def run(options: argparse.Namespace) -> None:
    config = load_config(options.config).only(SECTIONS)
    settings = solver_settings(options, config)
    if options.h0 is not None or options.hv is not None:
        _simulate_one(options, config, settings)
    else:
        _simulate_table(options, config, settings)


def _simulate_one(options: argparse.Namespace, config: Config, settings: SolverSettings) -> None:
    if options.scenes is not None:
        raise InputError("give either a table of scenes or --h0 and --hv, not both")
    if options.h0 is None or options.hv is None:
        raise InputError("one scene needs both --h0 and --hv")
    point = ScenePoint(
        point_id="1",
        h0_m=quantity(options.h0, option="--h0", unit="m"),
        hv_m=quantity(options.hv, option="--hv", unit="m"),
        phi_r_m=quantity(options.phi_r, option="--phi-r", unit="m"),
        phi_deg=quantity(options.phi, option="--phi", unit="deg"),
    )
    device = device_of(config, option=options.device)
    (scene,) = decided(
        [scene_of(point, config)],
        model_tolerance=settings.model_tolerance,
        method=settings.method,
        device=device,
    )
    (solution,) = solve(
        [scene], tolerance=settings.tolerance, method=settings.method, device=device
    )
    if not isfinite(solution.force_n):
        raise RunError(solution.status)
    print(_force_text(scene, solution, config=config, device=device))
    print(
        f"h0 {scene.h0_m:g} m, hv {scene.hv_m:g} m, phi_r {scene.phi_r_m:g} m, "
        f"phi {scene.phi_deg:g}°; epsilon {scene.epsilon:.4g}, sigma {scene.sigma:.5g}"
    )
    print(
        f"{solution.method} on {solution.nx} × {solution.ny} × {solution.nt} points, "
        f"{solution.krylov_iterations} Krylov iterations; left out: {solution.left_out}; "
        f"{device.name}"
    )
    (budget,) = budgets([scene], device=device)
    print(f"beyond the equation: {budget_text(budget)}")
    for note in notes_of(scene):
        print(f"note: {note}")
    if options.derivatives:
        (solution,) = with_derivatives(
            [scene], [solution], tolerance=settings.tolerance, device=device
        )
        assert solution.derivatives
        print(derivatives_text(solution.derivatives))
        if solution.derivatives.status != "ok":
            raise RunError(solution.derivatives.status)
    if solution.status != "ok":
        raise RunError(f"{solution.status}, above the tolerance {settings.tolerance:g}")


def _force_text(scene: Scene, solution: Solution, *, config: Config, device: Device) -> str:
    """The force with all that is known of its error; of a scan, its parts and what was dropped."""
    smoothed = smoothed_scan_of(config)
    if smoothed is None:
        return f"force {with_error(solution.force_n, solution.force_error_n)}"
    from squeezefilm.studies.tasks.scan_errors import scan_errors

    errors = scan_errors([scene], smoothed, device=device)
    noise_n, dropped_n = float(errors.noise_n[0]), float(errors.out_of_phase_n[0])
    parts = [f"scan's noise {noise_n:.2g} N at 95 %"]
    if dropped_n > 0.01 * noise_n:
        parts.append(f"motion out of phase, left out, about {dropped_n:.2g} N")
    parts.append(f"solver {solution.force_error_n:.1g} N")
    total_n = noise_n + dropped_n + solution.force_error_n
    text = f"force {with_error(solution.force_n, total_n)} ({', '.join(parts)})"
    return text + f"\nwarning: {FOLDED}" * smoothed.folded


def _simulate_table(options: argparse.Namespace, config: Config, settings: SolverSettings) -> None:
    if options.scenes is None or options.output is None:
        raise InputError("give a table of scenes and --output, or one scene by --h0 and --hv")
    rows = all_rows if options.chunk is None else partial(chunk_rows, options.chunk)
    table = read_scenes(options.scenes, rows=rows)
    pieces = [table.iloc[first : first + PIECE] for first in range(0, len(table), PIECE)]
    for piece in pieces:
        _scenes(piece, config, path=options.scenes)  # refused before anything is solved
    with node_cache.one_build_at_a_time():
        device = device_of(config, option=options.device)
        warm(device, _scenes(pieces[0], config, path=options.scenes)[0])
    failures: list[str] = []
    solved = 0
    seconds = derivative_seconds = 0.0
    timings = table_writer(options.timings) if options.timings else nullcontext(lambda rows: None)
    with (
        progress_bar(len(table), unit="scene", name=str(options.scenes)) as bar,
        table_writer(options.output) as write,
        timings as write_timings,
    ):
        for piece in pieces:
            scenes = _scenes(piece, config, path=options.scenes)
            start = time.perf_counter()
            solutions = solve(
                scenes,
                tolerance=settings.tolerance,
                model_tolerance=settings.model_tolerance,
                method=settings.method,
                device=device,
                report=bar.update,
            )
            wall = time.perf_counter() - start
            seconds += wall
            if options.derivatives:
                solutions = with_derivatives(
                    scenes,
                    solutions,
                    tolerance=settings.tolerance,
                    model_tolerance=settings.model_tolerance,
                    method=settings.method,
                    device=device,
                )
                derivative_seconds += time.perf_counter() - start - wall
            write(_forces(piece, solutions))
            shares = [wall * share for share in _work_shares(solutions)]
            write_timings(piece[["point_id"]].assign(solve_seconds=shares))
            solved += sum(solution.status == "ok" for solution in solutions)
            failures += [
                f"point {scene.point_id}: {reason}"
                for scene, solution in zip(scenes, solutions, strict=True)
                if (reason := _missing(solution))
            ]
    smoothed = smoothed_scan_of(config)
    if smoothed is not None:
        print(
            "force_error_n is the solver's error alone: what the scan's noise adds, "
            "`squeezefilm profile` says" + f"; warning: {FOLDED}" * smoothed.folded,
            file=sys.stderr,
        )
    print(
        f"{solved} of {len(table)} scenes solved in {seconds:.3f} s"
        + f", their derivatives in {derivative_seconds:.3f} s" * options.derivatives,
        file=sys.stderr,
    )
    if failures and options.keep_going:
        print("\n".join(failures), file=sys.stderr)
    elif failures:
        what = "no force or no derivatives" if options.derivatives else "no force"
        raise RunError(f"{what} for " + "; ".join(failures))


def _missing(solution: Solution) -> str:
    """Why there is no force, or none of the derivatives asked for; empty if all is there."""
    asked = (solution.status, solution.derivatives.status if solution.derivatives else "ok")
    return next((status for status in asked if status != "ok"), "")


def _scenes(rows: pd.DataFrame, config: Config, *, path: str) -> list[Scene]:
    with naming(path):
        return [scene_of(point, config) for point in scene_points(rows)]


def _forces(rows: pd.DataFrame, solutions: Sequence[Solution]) -> pd.DataFrame:
    """The rows of a plan with what was solved for them."""
    columns = {
        name: [getattr(solution, name) for solution in solutions]
        for name in FORCE_COLUMNS
        if name not in rows.columns
    }
    derivatives = [each.derivatives.columns() for each in solutions if each.derivatives]
    table = rows.assign(**columns)[list(FORCE_COLUMNS)]
    return table.assign(**pd.DataFrame(derivatives, index=rows.index)) if derivatives else table


def _work_shares(solutions: Sequence[Solution]) -> list[float]:
    """Each scene's share of the run time, by its floating-point operations; sums to 1."""
    total = sum(solution.work for solution in solutions)
    if total == 0:
        return [1 / len(solutions)] * len(solutions)
    return [solution.work / total for solution in solutions]


def chunk_rows(text: str, count: int) -> slice:
    """The rows of part I of N for ``I/N``: contiguous parts that differ by at most one row.

    Raises InputError when the text is not I/N with 1 ≤ I ≤ N ≤ count.
    """
    try:
        part, parts = (int(word) for word in text.split("/"))
    except ValueError:
        raise InputError(f"--chunk {text!r} must be two whole numbers like 2/4") from None
    if not 1 <= part <= parts <= count:
        raise InputError(f"--chunk {text!r}: 1 <= I <= N <= {count} (the rows of the table)")
    return slice(count * (part - 1) // parts, count * part // parts)
