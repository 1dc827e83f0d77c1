"""The settled state by marching in time, and its mean force with an error: method ``march``.

It knows nothing of the periodic solver's time collocation, which makes it that one's yardstick.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from math import pi

import numpy as np

from squeezefilm.reynolds.device import Device
from squeezefilm.reynolds.error_estimate import (
    ROUND_OFF,
    UNKNOWN_FALL,
    change_between,
    estimate,
)
from squeezefilm.reynolds.grid import Grid
from squeezefilm.reynolds.march.schemes import SCHEMES, Choice, choose, steps_for_stability
from squeezefilm.reynolds.march.transient import STATUS, march
from squeezefilm.reynolds.needs import Needs
from squeezefilm.reynolds.periodic.resolution import finer_grid, profile_fall
from squeezefilm.reynolds.problems import Problems

MOST_PERIODS = 60
ANDERSON_DEPTH = 10
# Share of the tolerance that is left to settling and to the equations of implicit steps.
SETTLING_SHARE = 0.03
# Steps grow from one grid to the next by enough for their error to show in the difference.
STEP_RATIO = 1.5
# Beyond this many steps per period a scene is refused.
MOST_STEPS = 30_000
NO_FINER_GRID = "tolerance not reached on the finest grid"


@dataclass(frozen=True)
class Settlement:
    """Films followed until a period repeats the one before; one entry per scene.

    Attributes:
        mean: mean force over the last period, in units of p0 × area.
        left: estimate of the mean force's error from what had not settled.
        overpressure: P − 1 at the beginning of that period, shape (scenes, nx, ny).
        mean_overpressure: P − 1 averaged over it, shape (scenes, nx, ny).
        periods: periods marched.
        newton_steps, krylov_iterations: work of the implicit steps.
        status: index into STATUS, −1 where a film had not settled.
    """

    mean: np.ndarray
    left: np.ndarray
    overpressure: np.ndarray
    mean_overpressure: np.ndarray
    periods: np.ndarray
    newton_steps: np.ndarray
    krylov_iterations: np.ndarray
    status: np.ndarray


def settle(
    *,
    problems: Problems,
    grid: Grid,
    steps_per_period: np.ndarray,
    scheme: str,
    device: Device,
    overpressure: np.ndarray | None = None,
) -> Settlement:
    """March until the state repeats itself, to ``problems.tolerance`` of the mean force.

    Plain marching would take σ / (2π²) radians for every factor of e, hundreds of periods. The slow
    modes are known: over a period a mode of the Laplacian with eigenvalue −k decays by about
    exp(−2πk/σ), so that its settled value is its change divided by 1 − exp(−2πk/σ). The next period
    starts from there, improved by Anderson's mixing with the periods before (J. ACM 12, 1965; as in
    Walker and Ni, SIAM J. Numer. Anal. 49, 2011). The same number is the estimate of what is left.
    """
    scenes = len(problems)
    values_x, vectors_x, inverse_x = grid.x.modes
    values_y, vectors_y, inverse_y = grid.y.modes
    rate = np.add.outer(values_x, values_y / problems.aspect**2)
    start = np.zeros((scenes, grid.nx, grid.ny))
    if overpressure is not None:
        start[:] = overpressure
    pressure = np.zeros_like(start)
    mean, left = np.full(scenes, np.nan), np.full(scenes, np.inf)
    periods, newton, krylov = (np.zeros(scenes, dtype=int) for _ in range(3))
    status = np.full(scenes, -1)
    history: list[list[tuple[np.ndarray, np.ndarray]]] = [[] for _ in range(scenes)]
    active = np.arange(scenes)
    while active.size and periods.max() < MOST_PERIODS:
        run = march(
            problems=problems.some(active),
            grid=grid,
            periods=1,
            steps_per_period=steps_per_period[active],
            scheme=scheme,
            device=device,
            overpressure=start[active],
        )
        periods[active] += 1
        newton[active] += run.newton_steps
        krylov[active] += run.krylov_iterations
        mean[active] = run.mean_by_period[:, 0]
        pressure[active] = run.mean_overpressure
        status[active] = np.where(run.status == 0, -1, run.status)
        slow = -np.expm1(2 * pi * rate / problems.sigma[active, None, None])
        change = inverse_x @ (run.overpressure - start[active]) @ inverse_y.T
        away = vectors_x @ (change / slow) @ vectors_y.T
        left[active] = np.einsum("i,bij,j->b", grid.x.weights, np.abs(away), grid.y.weights)
        for scene, correction in zip(active, away, strict=True):
            floor = ROUND_OFF * np.abs(start[scene]).max()
            if status[scene] == -1 and left[scene] <= problems.tolerance * abs(mean[scene]) + floor:
                status[scene] = 0
            elif status[scene] == -1:
                history[scene].append((start[scene].copy(), correction))
                start[scene] = _mixed(history[scene][-ANDERSON_DEPTH - 1 :])
        active = active[status[active] == -1]
    return Settlement(
        mean=mean,
        left=left,
        overpressure=start,
        mean_overpressure=pressure,
        periods=periods,
        newton_steps=newton,
        krylov_iterations=krylov,
        status=status,
    )


def _mixed(history: list[tuple[np.ndarray, np.ndarray]]) -> np.ndarray:
    """Next start of a period by Anderson's mixing of the (start, correction) of earlier ones."""
    starts = np.array([start.ravel() for start, _ in history])
    corrections = np.array([correction.ravel() for _, correction in history])
    step = corrections[-1].copy()
    if len(history) > 1:
        bends = np.diff(corrections, axis=0)
        weights = np.linalg.lstsq(bends.T, corrections[-1], rcond=None)[0]
        step -= weights @ (np.diff(starts, axis=0) + bends)
    # A pressure must not be taken below a tenth of what it was.
    steepest = np.max(-step / (1 + starts[-1]))
    share = 0.9 / steepest if steepest > 0.9 else 1.0
    return (starts[-1] + share * step).reshape(history[-1][0].shape)


@dataclass(frozen=True)
class SettledForce:
    """The settled mean force of one scene by marching, in units of p0 × area.

    Attributes:
        mean, error: force and the estimate of its error; NaN unless ``status`` is ``ok``.
        status: ``ok``, or what went wrong.
        method: scheme and steps per period.
        left_out: what the scene did not need.
        grid: the finest grid used (its ``nt`` has no meaning).
        steps_per_period: on that grid.
        periods: periods marched on all grids.
        newton_steps, krylov_iterations: on all grids.
    """

    mean: float
    error: float
    status: str
    method: str
    left_out: str
    grid: Grid
    steps_per_period: int
    periods: int
    newton_steps: int
    krylov_iterations: int


@dataclass
class _Progress:
    """A scene on its way through the grids and step sizes."""

    choice: Choice
    overpressure: np.ndarray | None = None
    mean_overpressure: np.ndarray | None = None
    periods: int = 0
    newton_steps: int = 0
    krylov_iterations: int = 0


def transient_force(
    *,
    problems_on: Callable[[Grid], Problems],
    grid: Grid,
    tolerance: float,
    device: Device,
    needs: Sequence[Needs] = (),
) -> list[SettledForce]:
    """Settled mean forces by marching in time, to a relative tolerance or with a reason why not.

    Every scene is settled with two or more pairs of grid and step size, each finer in both than the
    one before, until two agree. The error estimate is the largest change of the mean pressure's
    lowest moments, which do not all agree by chance as forces may, and what has not settled.

    Args:
        problems_on: the scenes of a batch on a given grid.
        grid: the first, coarsest grid.
        needs: of the scenes, whose profiles may be of finite smoothness; smooth if left out.
    """
    grid = replace(grid, nt=4)
    problems = problems_on(grid)
    choices = choose(problems=problems, grid=grid, tolerance=tolerance)
    progress = [_Progress(choice=choice) for choice in choices]
    forces: list[SettledForce | None] = [None] * len(choices)
    finer: Grid | None = grid
    level = 0
    while finer is not None and None in forces:
        before, grid = grid, finer
        problems = replace(problems_on(grid), tolerance=SETTLING_SHARE * tolerance)
        for name in SCHEMES:
            group = [
                index
                for index, force in enumerate(forces)
                if force is None and choices[index].scheme == name
            ]
            steps_of_all = steps_on(grid, level, choices, problems=problems, scheme=name)
            for index in group:
                if reason := too_many_steps(steps_of_all[index]):
                    forces[index] = _settled(progress[index], grid, 0, status=reason)
            group = [index for index in group if forces[index] is None]
            if not group:
                continue
            which = np.array(group)
            steps = steps_of_all[which]
            settled = settle(
                problems=problems.some(which),
                grid=grid,
                steps_per_period=steps,
                scheme=name,
                device=device,
                overpressure=np.stack(
                    [_carried(progress[index].overpressure, before, grid) for index in group]
                ),
            )
            for position, index in enumerate(group):
                smooth = not needs or level == 0
                forces[index] = _judge(
                    progress[index],
                    settled,
                    position,
                    before,
                    grid,
                    steps[position],
                    tolerance,
                    fall=0.0
                    if smooth
                    else profile_fall(
                        needs[index], before.across, grid.across, tolerance=tolerance
                    ),
                )
        finer = finer_grid(grid)
        level += 1
    return [
        force or _settled(one, grid, 0, status=NO_FINER_GRID)
        for one, force in zip(progress, forces, strict=True)
    ]


def steps_on(
    grid: Grid, level: int, choices: Sequence[Choice], *, problems: Problems, scheme: str
) -> np.ndarray:
    """Steps per period of each scene on a grid, the ``level``-th after the first."""
    stable = steps_for_stability(problems=problems, grid=grid, scheme=scheme)
    accurate = np.array([choice.accurate_steps for choice in choices])
    return np.maximum(np.ceil(accurate * STEP_RATIO**level), stable).astype(int)


def method_name(choice: Choice) -> str:
    return f"march, {choice.scheme}"


def too_many_steps(steps: int) -> str:
    """Why a scene that would take so many steps is refused; empty where it is not."""
    return f"it would take {steps} steps per period" if steps > MOST_STEPS else ""


def _carried(overpressure: np.ndarray | None, coarse: Grid, fine: Grid) -> np.ndarray:
    """The state on a finer grid; the film at rest where there is none yet."""
    if overpressure is None:
        return np.zeros((fine.nx, fine.ny))
    return np.asarray(
        coarse.x.interpolation_to(fine.x) @ overpressure @ coarse.y.interpolation_to(fine.y).T
    )


def _judge(
    one: _Progress,
    settled: Settlement,
    position: int,
    before: Grid,
    grid: Grid,
    steps: int,
    tolerance: float,
    *,
    fall: float,
) -> SettledForce | None:
    """The scene's force if its error is known to be small enough or will not be; else None."""
    one.periods += int(settled.periods[position])
    one.newton_steps += int(settled.newton_steps[position])
    one.krylov_iterations += int(settled.krylov_iterations[position])
    status = int(settled.status[position])
    if status != 0:
        reason = STATUS[status] if status > 0 else f"not settled after {MOST_PERIODS} periods"
        return _settled(one, grid, steps, status=reason)
    mean, overpressure = float(settled.mean[position]), settled.overpressure[position]
    pressure = settled.mean_overpressure[position]
    known = one.mean_overpressure
    found = estimate(
        change=None
        if known is None
        else change_between(known, before, pressure, grid).telling(fall),
        left=settled.left[position],
        largest=np.abs(overpressure).max(),
        narrowest=1.0,
        mean=mean,
        tolerance=tolerance,
        fall=max(fall, UNKNOWN_FALL),
    )
    one.overpressure, one.mean_overpressure = overpressure, pressure
    if found.holds:
        return _settled(one, grid, steps, mean=mean, error=float(found.error))
    return None


def _settled(
    one: _Progress,
    grid: Grid,
    steps: int,
    *,
    mean: float = np.nan,
    error: float = np.nan,
    status: str = "ok",
) -> SettledForce:
    return SettledForce(
        mean=mean,
        error=error,
        status=status,
        method=method_name(one.choice),
        left_out=one.choice.left_out,
        grid=grid,
        steps_per_period=int(steps),
        periods=one.periods,
        newton_steps=one.newton_steps,
        krylov_iterations=one.krylov_iterations,
    )
