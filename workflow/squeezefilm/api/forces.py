"""Forces of scenes with all that is known of their errors, for people."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from math import isfinite

import pandas as pd

from squeezefilm.errors import RunError
from squeezefilm.film.measured.smooth import SmoothedScan
from squeezefilm.film.scene import Scene
from squeezefilm.film.validity import OK
from squeezefilm.quantities.derivatives import derivatives_text, with_derivatives
from squeezefilm.quantities.model_error import (
    ErrorBudget,
    budget_text,
    error_budgets,
    excluded_terms,
)
from squeezefilm.quantities.outputs import outputs_text, with_outputs
from squeezefilm.reynolds import Solution, solve
from squeezefilm.reynolds.device import Device
from squeezefilm.reynolds.terms import notes_of
from squeezefilm.studies.solver_settings import SolverSettings
from squeezefilm.studies.tasks.scan_errors import scan_errors
from squeezefilm.units import with_error

# Motion out of phase is spoken of where it is more than this share of the noise.
LEAST_OUT_OF_PHASE = 0.01
# Scenes solved together, whose states may be held.
WITH_STATES = 256
NOT_ASKED = "not asked for"


@dataclass(frozen=True)
class ScanPart:
    """What the scan of a measured profile leaves open in one force, in newtons.

    Attributes:
        noise_n: half of the interval that holds the noise's part in 95 % of all scans.
        out_of_phase_n: by what the force is low without the motion out of phase, an estimate.
        warnings: what was seen of the scan that these do not hold, a line each.
    """

    noise_n: float
    out_of_phase_n: float
    warnings: tuple[str, ...] = ()

    @property
    def total_n(self) -> float:
        """All that the scan leaves open."""
        return self.noise_n + self.out_of_phase_n


@dataclass(frozen=True)
class Force:
    """The mean force of one scene, its error, and what its equation leaves out.

    ``print(force)`` says all of it in words, ``float(force)`` is the force in newtons.

    Attributes:
        scene: what was solved.
        solution: the force and how it was obtained; its error is the solver's alone.
        budget: what the film equation leaves out of the force, effect by effect; its
            status says where it was not asked for.
        scan: what the scan of a measured profile leaves open; None without one.
        device: the name of the OpenCL device.
        kept_out: which terms ``auto`` could not include, and why.

    Answers beside the force that were asked for are ``solution.outputs``.
    """

    scene: Scene
    solution: Solution
    budget: ErrorBudget
    scan: ScanPart | None
    device: str
    kept_out: tuple[str, ...] = ()

    @property
    def force_n(self) -> float:
        """The mean force in newtons."""
        return self.solution.force_n

    @property
    def error_n(self) -> float:
        """The solver's error estimate and what a scan leaves open, in newtons.

        What the film equation itself leaves out is not in it: see ``left_out_percent``.
        """
        scan = self.scan
        return self.solution.force_error_n + (scan.total_n if scan else 0.0)

    @property
    def left_out_percent(self) -> tuple[float, float]:
        """What the equation leaves out of the force, least and most, in per cent.

        First orders, and what higher ones may add. NaN where an effect is not known or the budget
        was not asked for; ``print(force)`` says where a first order is not enough.
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

    def __str__(self) -> str:
        return "\n".join([*self._force(), self._scene(), self._way(), *self._beyond()])

    __repr__ = __str__

    def _force(self) -> list[str]:
        text = f"force {with_error(self.force_n, self.error_n)}"
        if self.scan is None:
            return [text]
        parts = [f"scan's noise {self.scan.noise_n:.1g} N at 95 %"]
        if self.scan.out_of_phase_n > LEAST_OUT_OF_PHASE * self.scan.noise_n:
            parts.append(f"motion out of phase, left out, about {self.scan.out_of_phase_n:.2g} N")
        parts.append(f"solver {self.solution.force_error_n:.1g} N")
        return [f"{text} ({', '.join(parts)})", *self.scan.warnings]

    def _scene(self) -> str:
        scene = self.scene
        return (
            f"h0 {1e6 * scene.h0_m:g} µm, hv {1e6 * scene.hv_m:g} µm, "
            f"x {_tidy(1e3 * scene.x_m)} mm, y {_tidy(1e3 * scene.y_m)} mm; "
            f"epsilon {scene.epsilon:.4g}, sigma {scene.sigma:.5g}"
        )

    def _way(self) -> str:
        found = self.solution
        return (
            f"{found.method} on {found.nx} × {found.ny} × {found.nt} points, "
            f"{found.krylov_iterations} Krylov iterations, on {self.device}; "
            f"left out: {found.left_out}"
        )

    def _beyond(self) -> list[str]:
        lines = [f"validity  {self.validity}", f"beyond the equation: {budget_text(self.budget)}"]
        if self.solution.derivatives:
            lines.append(derivatives_text(self.solution.derivatives))
        if self.solution.outputs:
            lines += outputs_text(self.solution.outputs)
            lines += ["note: errors of these are without the scan's noise"] * (
                self.scan is not None
            )
        lines += [f"note: {note}" for note in (*self.kept_out, *notes_of(self.scene))]
        return lines + [f"note: {self.status}"] * (self.status != "ok")


def force_of(
    scene: Scene,
    *,
    settings: SolverSettings,
    device: Device,
    smoothed: SmoothedScan | None,
    derivatives: bool = False,
) -> Force:
    """One scene's force; ``smoothed`` is the scan that its profile was measured in.

    Raises RunError saying why there is none.
    """
    (force,) = forces_of(
        [scene],
        settings=settings,
        device=device,
        smoothed=smoothed,
        derivatives=derivatives,
        budget=True,
    )
    if not isfinite(force.force_n):
        beyond = f"; validity: {force.validity}" * (force.validity != OK)
        raise RunError(force.status + beyond)
    return force


def forces_of(
    scenes: Sequence[Scene],
    *,
    settings: SolverSettings,
    device: Device,
    smoothed: SmoothedScan | None,
    derivatives: bool = False,
    budget: bool = False,
) -> list[Force]:
    """The force of each scene, NaN with its reason as ``status`` where there is none.

    Args:
        budget: whether what the film equation leaves out is asked for too: states of their own.
    """
    not_decided = [excluded_terms(scene, method=settings.method) for scene in scenes]
    scenes = settings.resolved(scenes, device)
    solutions = [
        solution
        for first in range(0, len(scenes), WITH_STATES)
        for solution in solved_with(
            scenes[first : first + WITH_STATES],
            settings=settings,
            device=device,
            derivatives=derivatives,
        )
    ]
    known = [k for k, solution in enumerate(solutions) if isfinite(solution.force_n)]
    with_force = [scenes[k] for k in known]
    reason = "no force to compare with" if budget else NOT_ASKED
    beyond = dict.fromkeys(range(len(scenes)), ErrorBudget(status=reason))
    if budget:
        beyond |= dict(zip(known, error_budgets(with_force, device=device), strict=True))
    scans: dict[int, ScanPart] = {}
    if smoothed is not None and known:
        scans = dict(zip(known, scan_parts(with_force, smoothed, device=device), strict=True))
    return [
        Force(
            scene,
            solution,
            beyond[k],
            scans.get(k),
            device.name,
            tuple(not_decided[k]),
        )
        for k, (scene, solution) in enumerate(zip(scenes, solutions, strict=True))
    ]


def solved_with(
    scenes: Sequence[Scene],
    *,
    settings: SolverSettings,
    device: Device,
    derivatives: bool,
    report: Callable[[int], object] = lambda solved: None,
) -> Sequence[Solution]:
    """Forces of scenes whose terms are decided, with the derivatives and outputs asked for."""
    keep = derivatives or bool(settings.outputs)
    solutions: Sequence[Solution] = solve(
        scenes,
        **settings.how(device),
        keep_states=keep,
        report=report,
    )
    within = settings.tolerance
    if derivatives:
        solutions = with_derivatives(scenes, solutions, tolerance=within, device=device)
    solutions = with_outputs(
        scenes, solutions, outputs=settings.outputs, tolerance=within, device=device
    )
    if keep:
        solutions = [replace(solution, states=()) for solution in solutions]
    return solutions


def scan_parts(
    scenes: Sequence[Scene], smoothed: SmoothedScan, *, device: Device
) -> list[ScanPart]:
    """What the scan leaves open in the force of each scene.

    Raises RunError naming a scene that has no force with a profile of other noise.
    """
    errors = scan_errors(scenes, smoothed, device=device)
    return [
        ScanPart(float(noise), float(dropped), smoothed.warnings)
        for noise, dropped in zip(errors.noise_n, errors.out_of_phase_n, strict=True)
    ]


def forces_table(points: pd.DataFrame, forces: Sequence[Force]) -> pd.DataFrame:
    """Forces of some points as a table, a row for each.

    ``force_error_n`` is all that is known of the numbers' error, a scan's part too;
    ``status`` is ``ok``, or why there is no force; ``validity`` is ``ok``, or the limits of
    validity that the scene exceeds. What was asked for stands behind: derivatives, outputs and,
    with a budget, ``left_out_least_percent`` and ``…_most_percent``, what the film equation leaves
    out, first orders and what higher ones may add.
    """
    more = pd.DataFrame([_asked_columns(force) for force in forces], index=points.index)
    return points.assign(
        force_n=[force.force_n for force in forces],
        force_error_n=[force.error_n for force in forces],
        method=[force.solution.method for force in forces],
        status=[force.status for force in forces],
        validity=[force.validity for force in forces],
        **{name: more[name] for name in map(str, more)},
    )


def _asked_columns(force: Force) -> dict[str, float | str]:
    columns = force.solution.asked_columns
    if force.budget.status != NOT_ASKED:
        least, most = force.left_out_percent
        columns |= {"left_out_least_percent": least, "left_out_most_percent": most}
    return columns


def _tidy(value: float) -> str:
    """A coordinate without what its way through polar ones has added."""
    return f"{round(value, 9) + 0.0:g}"
