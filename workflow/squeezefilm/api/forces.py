"""Forces of scenes with all that is known of their errors, and how they would be solved."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from squeezefilm.errors import point_text, prefix_errors
from squeezefilm.film.positions import (
    CARTESIAN_COLUMNS,
    columns_in_table_form,
    fill_missing_coordinate,
)
from squeezefilm.film.scene import Scene, Scenes
from squeezefilm.film.validity import validity_text
from squeezefilm.formatting import DIMENSIONLESS_COLUMNS, result_lines_text, scene_row
from squeezefilm.lazy import pd
from squeezefilm.parallel import track_progress
from squeezefilm.quantities.model_error import (
    ErrorBudget,
    budget_row,
    error_budgets,
    unsupported_auto_term_texts,
)
from squeezefilm.reynolds import Solution, solve
from squeezefilm.reynolds.device import Device, device_properties
from squeezefilm.reynolds.dry_run import dry_run
from squeezefilm.reynolds.kernel_cache import build_lock
from squeezefilm.reynolds.periodic.launch import build_kernels_for_scene
from squeezefilm.reynolds.periodic.refinement import are_many
from squeezefilm.reynolds.terms import validity_notes
from squeezefilm.solution import MODELLING_ERROR_COLUMNS, SOLUTION_COLUMNS, Solutions
from squeezefilm.studies.solver_settings import SolverSettings, device_of_config
from squeezefilm.table_writer import table_writer
from squeezefilm.tables import SCENE_COLUMNS, read_scenes

if TYPE_CHECKING:
    from squeezefilm.api.film import Film
    from squeezefilm.config.study import Study
    from squeezefilm.film.measured.smooth import SmoothedScan

# Scenes solved together, whose states may be held.
SCENES_PER_BATCH_WITH_STATES = 256
NOT_REQUESTED_STATUS = "not asked for"
SOLVER_CHOICE_COLUMNS = ["method", "domain", "terms", "status", "validity", "notes"]
SCAN_ERROR_COLUMNS = ("misfit_n", "quadrature_n")
"""Parts of a force's uncertainty by a scan."""


@dataclass(frozen=True)
class Force:
    """The mean force of one scene, its error, and the effects that its equation neglects.

    ``print(force)`` prints all of it, ``float(force)`` is the force in newtons.

    Attributes:
        scene: what was solved.
        solution: the force and how it was obtained; its error is the solver's alone.
        budget: the effects that the film equation neglects, one by one; its
            status says where it was not asked for.
        scan: uncertainty by a measured profile: ``measurement_noise_n``, half of the interval that
            holds the noise's part in 95 % of all scans, and the same of each other quantity;
            ``misfit_n``, by modes that the points do not determine; ``quadrature_n``, by what the
            force is low without the motion out of phase; ``scan_error_n``, all. None without a
            scan.
        device: the name of the OpenCL device.
        tolerance: the required relative error.
        notes: which terms ``auto`` could not include and why, and what was seen of the scan.

    Requested output quantities are ``solution.outputs``.
    """

    scene: Scene
    solution: Solution
    budget: ErrorBudget
    scan: Mapping[Any, float] | None
    device: str
    tolerance: float
    notes: tuple[str, ...] = ()

    @property
    def force_n(self) -> float:
        """The mean force in newtons."""
        return self.solution.force_n

    @property
    def error_n(self) -> float:
        """The solver's estimate of the numerical error in newtons, ``force_error_n`` of tables.

        It contains neither the noise of a scan, ``scan``, nor ``modelling_error_percent``.
        """
        return self.solution.force_error_n

    @property
    def modelling_error_percent(self) -> tuple[float, float]:
        """Return the bounds of the modelling error in per cent of the force.

        NaN where an effect is unknown or the budget was not asked for.
        """
        return self.budget.modelling_error_percent

    @property
    def status(self) -> str:
        """``ok``, or by what the error misses the tolerance."""
        return self.solution.status

    @property
    def validity(self) -> str:
        """``ok``, or the limits of validity of the film equation that the scene exceeds."""
        return self.solution.validity

    def __float__(self) -> float:
        return self.force_n

    @property
    def scan_columns(self) -> dict[str, float]:
        """The errors by the scan, by the names of columns; none without a scan."""
        scan = self.scan or {}
        kept = [name for name in scan if "measurement_noise" in name or name in SCAN_ERROR_COLUMNS]
        return {name: scan[name] for name in kept}

    @property
    def row(self) -> dict[str, Any]:
        """Return the force, its errors and its scene as a row, by the names of columns."""
        budget = budget_row(self.budget)
        return {
            **scene_row(self.scene),
            **{name: getattr(self.solution, name) for name in SOLUTION_COLUMNS},
            **self.scan_columns,
            **(budget | {"budget_status": budget["status"], "status": self.status}),
            **self.solution.requested_row,
            "tolerance": self.tolerance,
            "device": self.device,
            "notes": [
                warning.removeprefix("note: ")
                for warning in (*self.notes, *validity_notes(self.scene))
            ],
        }

    def __str__(self) -> str:
        return result_lines_text(self.row)

    __repr__ = __str__


def solve_forces(
    scenes: Scenes | Sequence[Scene],
    *,
    settings: SolverSettings,
    smoothed: SmoothedScan | None,
    derivatives: bool = False,
    budget: bool = False,
) -> list[Force]:
    """The force of each scene, NaN with its reason as ``status`` where there is none.

    Args:
        smoothed: the scan that their profile was measured in.
        budget: whether to estimate the modelling error too, from separate states.
    """
    notes = [tuple(unsupported_auto_term_texts(scene, method=settings.method)) for scene in scenes]
    scenes, device = settings.with_auto_terms_decided(scenes), settings.device
    solutions = solve_with_settings(scenes, settings=settings, derivatives=derivatives)
    known = np.flatnonzero(np.isfinite(solutions.force_n)).tolist()
    with_force = [scenes[k] for k in known]
    reason = "no force to compare with" if budget else NOT_REQUESTED_STATUS
    beyond = dict.fromkeys(range(len(scenes)), ErrorBudget(status=reason))
    if budget:
        beyond |= dict(zip(known, error_budgets(with_force, device=device), strict=True))

    def solve_scenes(scenes: Sequence[Scene], **how: Any) -> Solutions:
        return solve_with_settings(
            scenes, settings=replace(settings, **how), derivatives=derivatives
        )

    errors = _scan_errors(with_force, smoothed, device=device, solved=solve_scenes)
    scans = dict(zip(known, errors, strict=False))
    warnings = smoothed.warnings if smoothed and errors else ()
    known_of_device = device.name, settings.tolerance
    return [
        Force(scene, solution, beyond[k], scans.get(k), *known_of_device, (*warnings, *notes[k]))
        for k, (scene, solution) in enumerate(zip(scenes, solutions, strict=True))
    ]


def solve_with_settings(
    scenes: Scenes | Sequence[Scene],
    *,
    settings: SolverSettings,
    derivatives: bool = False,
    report: Callable[[int], object] = lambda solved: None,
) -> Solutions:
    """Solve scenes whose terms are decided, with the requested derivatives and outputs."""
    if not (derivatives or settings.outputs):
        return solve(scenes, **settings.solve_arguments, report=report)
    from squeezefilm.quantities.derivatives import with_derivatives
    from squeezefilm.quantities.outputs import with_outputs

    results = Solutions.unsolved_of_method(settings.method, len(scenes))
    how: dict[str, Any] = {"tolerance": settings.tolerance, "device": settings.device}
    for first in range(0, len(scenes), SCENES_PER_BATCH_WITH_STATES):
        batch = scenes[first : first + SCENES_PER_BATCH_WITH_STATES]
        solved = solve(batch, **settings.solve_arguments, keep_states=True, report=report)
        if derivatives:
            solved = with_derivatives(batch, solved, **how)
        solved = with_outputs(batch, solved, outputs=settings.outputs, **how)
        rows = first + np.arange(len(batch))
        results = results.with_replaced_rows(
            rows, solved.with_replaced_column("states", [()] * len(batch))
        )
    return results


def scan_error_function(
    smoothed: SmoothedScan | None, *, device: Device
) -> Callable[[Scene], float]:
    """Return the function that gives the error of a scene's force by the scan, in newtons."""
    return lambda scene: sum(
        row["scan_error_n"] for row in _scan_errors([scene], smoothed, device=device)
    )


def _scan_errors(
    scenes: Sequence[Scene], smoothed: SmoothedScan | None, **how: Any
) -> Sequence[Mapping[Any, float]]:
    """The rows of ``scan_errors_table``; none without a scan."""
    if smoothed is None or not scenes:
        return []
    from squeezefilm.studies.tasks.scan_errors import scan_errors_table

    return scan_errors_table(scenes, smoothed, **how).to_dict("records")


def forces_table(
    points: pd.DataFrame, forces: Sequence[Force], *, whole: bool = False
) -> pd.DataFrame:
    """Forces of some points as a table, a row for each.

    ``force_error_n`` is the numerical error; a scan adds ``measurement_noise_n`` and
    ``quadrature_n``, and to each quantity with an error its noise. ``status`` is ``ok``, or why
    there is no force; ``validity`` is ``ok``, or the limits of validity that the scene exceeds.
    What was asked for stands behind: derivatives, outputs and, with a budget,
    ``modelling_error_lower_percent`` and ``…_upper_percent``, the bounds of the effects that the
    film equation neglects, all together. With ``whole`` it has all columns of a table of scenes
    and their forces.
    """
    rows, names = [], ["force_n", "force_error_n", "method", "status", "validity"]
    if whole:
        names, points = [*SOLUTION_COLUMNS], fill_missing_coordinate(points)
        points.insert(0, "point_id", [force.scene.point_id for force in forces])
    for force in forces:
        row = {name: getattr(force.solution, name) for name in names}
        row |= {**force.scan_columns, **force.solution.requested_row}
        if force.budget.status != NOT_REQUESTED_STATUS:
            row |= zip(MODELLING_ERROR_COLUMNS, force.modelling_error_percent, strict=True)
        rows.append(row)
    return points.assign(**pd.DataFrame(rows, index=points.index))


def budget_table(table: pd.DataFrame, film: Film) -> pd.DataFrame:
    """Return a table of scenes with the modelling error of each force."""
    scenes = film.solver().with_auto_terms_decided(film.scenes(table))
    budgets = error_budgets(scenes, device=film.device)
    rows = pd.DataFrame(list(map(budget_row, budgets)))
    return pd.concat([table, rows.assign(validity=list(map(validity_text, scenes)))], axis=1)


def preview_table(
    scenes: Sequence[Scene], film: Film
) -> tuple[pd.DataFrame, Iterator[dict[str, Any]]]:
    """A table of how scenes would be solved, and rows to be shown of it.

    A row has a scene's numbers, method, domain, terms and first grid.
    """
    settings = film.solver()
    scenes = settings.with_auto_terms_decided(scenes)
    rows = []
    expected = dry_run(scenes, tolerance=settings.tolerance, method=settings.method)
    for scene, row in zip(scenes, expected, strict=True):
        factors = ("point_id", "h0_m", "hv_m", *CARTESIAN_COLUMNS)
        row = {name: getattr(scene, name) for name in (*factors, *DIMENSIONLESS_COLUMNS)} | row
        absent = row.pop("absent")
        row |= {
            "validity": validity_text(scene),
            "absent_terms": "; ".join(term.name for term in absent),
            "absent_term_reasons": "; ".join(
                f"{term.name}: {term.absence_reason}" for term in absent
            ),
            "notes": "; ".join(validity_notes(scene)),
        }
        if settings.outputs:
            from squeezefilm.quantities.outputs import missing_output_reasons

            refused = missing_output_reasons(scene, tolerance=settings.tolerance)
            lacking = [f"{name}: {refused[name]}" for name in settings.outputs if name in refused]
            row["outputs_not_supported"] = "; ".join(lacking)
        rows.append(row)
    table = pd.DataFrame(rows)
    return table, _preview_rows(scenes, table, tolerance=settings.tolerance)


def _preview_rows(
    scenes: Sequence[Scene], table: pd.DataFrame, *, tolerance: float
) -> Iterator[dict[str, Any]]:
    """Rows to be shown of a table of previews: one for all scenes that are treated alike."""
    for rows in table.groupby(SOLVER_CHOICE_COLUMNS, sort=False).indices.values():
        first, mflop = rows[0], table["expected_mflop"].iloc[rows].sum()
        count = (
            {"scenes": f"{len(rows)} of {len(table)}, the first of them:"} if len(table) > 1 else {}
        )
        row = count | scene_row(scenes[first]) | {"tolerance": tolerance}
        row |= table.iloc[first].to_dict() | {"expected_mflop": mflop}
        yield row | {"absent_term_reasons": row["absent_term_reasons"].split("; ")}


ROWS_PER_WRITE = 4096
"""Scenes whose results are held before they are written."""


def compile_kernels(config: Study) -> dict[str, Any]:
    """Compile the kernels of a study, so that jobs find them in the caches; name its device."""
    device = device_of_config(config)
    with build_lock():
        # Which terms a film needs does not depend on its gap, so no gap need be one of the study's.
        for many in (True, False):
            build_kernels_for_scene(
                device, config.read_film().scene(h0_m=5e-6, hv_m=0.0), many=many
            )
    facts = device_properties(device)
    del facts["global_memory_bytes"]  # PoCL's is what is free at the moment
    return facts


def simulate_table(
    scenes: Path | str,
    film: Film,
    *,
    output: Path | str,
    timings: Path | str | None = None,
    chunk: tuple[int, int] = (1, 1),
    derivatives: bool = False,
) -> tuple[list[str], list[str]]:
    """Solve the scenes of a table and write a row for each, whatever became of it.

    Args:
        timings: where to write each scene's share of the run time.
        chunk: which of how many parts of the table.
        derivatives: of the force too.

    Returns:
        the points without a force, each with its reason, and those that have a force but not all
        that was asked for beside it.

    Raises InputError, before anything is solved, for a scene that cannot be.
    """
    table = read_scenes(scenes, chunk=chunk)
    with prefix_errors(scenes):
        planned = film.scenes(table)
    settings = film.solver()
    with build_lock():
        build_kernels_for_scene(settings.device, planned[0], many=are_many(planned))
    failures: list[str] = []
    incomplete: list[str] = []
    seconds = 0.0
    times = table_writer(timings) if timings else nullcontext(lambda rows: None)
    with (
        track_progress(len(table), unit="scene", name=str(scenes)) as bar,
        table_writer(output) as write,
        times as write_times,
    ):
        for first in range(0, len(table), ROWS_PER_WRITE):
            rows = table.iloc[first : first + ROWS_PER_WRITE]
            batch = planned[first : first + ROWS_PER_WRITE]
            start = time.perf_counter()
            how: dict[str, Any] = {"derivatives": derivatives, "report": bar.update}
            decided = settings.with_auto_terms_decided(batch)
            solutions = solve_with_settings(decided, settings=settings, **how)
            wall = time.perf_counter() - start
            columns = rows[columns_in_table_form(SCENE_COLUMNS, rows)]
            write(pd.concat([columns, solutions.to_frame(rows.index)], axis=1))
            # By floating-point operations, of which closed forms need none worth counting.
            work = solutions.operation_count
            time_fractions = work / work.sum() if work.any() else np.full(len(work), 1 / len(work))
            write_times(rows[["point_id"]].assign(solve_s=wall * time_fractions))
            seconds += wall
            may_miss = (solutions.status != "ok") | solutions.have_requested_quantities
            ids = rows["point_id"][may_miss]
            for point_id, solution in zip(ids, solutions[may_miss], strict=True):
                if reason := missing_quantity_reason(solution):
                    missing = incomplete if solution.status == "ok" else failures
                    missing.append(f"{point_text(point_id)}: {reason}")
    for note in unsupported_auto_term_texts(planned[0], method=settings.method):
        print(note, file=sys.stderr)
    count = len(table) - len(failures)
    print(f"{count} of {len(table)} scenes solved in {seconds:.3f} s", file=sys.stderr)
    return failures, incomplete


def missing_quantity_reason(solution: Solution) -> str:
    """Return the reason for a missing force or a missing quantity beside it, or an empty text."""
    asked = (solution, solution.derivatives, solution.outputs)
    return next((result.status for result in asked if result and result.status != "ok"), "")
