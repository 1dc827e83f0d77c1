"""The film in time, marched on the device: start-up from rest, rise time (transient.cl).

The surface starts from rest at T = 0 as ε s sin T: without a jump of the gap, but with one of its
velocity, which the mass as unknown does not see.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import pi

import numpy as np

from squeezefilm.io.errors import InputError
from squeezefilm.reynolds.device import Device, aligned, kernel
from squeezefilm.reynolds.grid import Grid, instant_matrices
from squeezefilm.reynolds.layout import Columns, Pile, c_enum, c_struct, c_terms, rows_of
from squeezefilm.reynolds.march.schemes import SCHEMES, Scheme, steps_for_stability
from squeezefilm.reynolds.problems import Problems, profile_fields
from squeezefilm.reynolds.terms import Terms

# How a march ends: the kernel's names, and what is said of it.
ENDINGS = {
    "MARCHED": "ok",
    "STALLED": "a step's equations did not converge",
    "NOT_PHYSICAL": "the pressure left the physical range",
}
STATUS = tuple(ENDINGS.values())
MOST_NEWTON = 12
MOST_KRYLOV = 30
# What the kernel says of a period and of a scene's march.
PERIOD = np.dtype([(name, np.float64) for name in ("mean", "lowest", "highest")])
ENDING = np.dtype([(name, np.int64) for name in ("status", "newton_steps", "krylov_iterations")])


@dataclass(frozen=True)
class Modulation:
    """The amplitude ε (1 + depth sin(modulations T)), the same for all films of a march.

    Attributes:
        depth: relative to the mean amplitude.
        modulations: cycles per period of the vibration.
    """

    depth: float = 0.0
    modulations: float = 0.0


@dataclass(frozen=True)
class March:
    """Films followed through some periods; forces in units of p0 × area.

    Attributes:
        mean_by_period: force averaged over each period, shape (scenes, periods); NaN from the
            period on in which a scene failed.
        lowest_by_period, highest_by_period: extremes of the force at the steps of each period.
        overpressure: p = P − 1 after the last period, shape (scenes, nx, ny).
        mean_overpressure: p averaged over the last period, shape (scenes, nx, ny).
        scheme, steps_per_period: how it was marched; steps of shape (scenes,).
        newton_steps, krylov_iterations: work of the implicit steps, shape (scenes,).
        status: index into STATUS, shape (scenes,).
    """

    mean_by_period: np.ndarray
    lowest_by_period: np.ndarray
    highest_by_period: np.ndarray
    overpressure: np.ndarray
    mean_overpressure: np.ndarray
    scheme: str
    steps_per_period: np.ndarray
    newton_steps: np.ndarray
    krylov_iterations: np.ndarray
    status: np.ndarray


def march(
    *,
    problems: Problems,
    grid: Grid,
    periods: int,
    steps_per_period: int | np.ndarray,
    scheme: str,
    device: Device,
    overpressure: np.ndarray | None = None,
    modulation: Modulation = Modulation(),
) -> March:
    """Follow films through ``periods`` periods from rest or from a given state.

    Args:
        problems: the scenes; the film is isothermal and without slip. ``problems.tolerance`` bounds
            what the equations of implicit steps leave, relative to the force.
        grid: collocation points across the film; its ``nt`` has no meaning here.
        steps_per_period: one number, or one per scene.
        scheme: a name of SCHEMES.
        overpressure: P − 1 at the beginning, shape (scenes, nx, ny); zero, the film at rest, if
            left out.
        modulation: how the amplitude changes meanwhile; not at all if left out.

    Raises:
        InputError: for another scheme's name, scenes with terms that marching does not know, or a
            grid whose numbers of unknowns are no multiples of four; for fewer explicit steps than
            are sure to be stable: a weak instability saturates, and no sign tells of it.
    """
    import pyopencl as cl

    if scheme not in SCHEMES:
        raise InputError(f"scheme {scheme!r}: unknown; allowed are {', '.join(SCHEMES)}")
    unknown = [term.label for term in problems.terms if not term.AT_INSTANT]
    if unknown:
        raise InputError(f"march: marching in time does not know {', '.join(unknown)}")
    if grid.nx % 4 or grid.ny % 4:
        raise InputError(f"march: {grid.nx} × {grid.ny} unknowns; both must be multiples of 4")
    method = SCHEMES[scheme]
    scenes = len(problems)
    steps = np.broadcast_to(np.asarray(steps_per_period, dtype=float), (scenes,))
    loudest = problems.numbers.copy()
    loudest["epsilon"] = np.abs(problems.epsilon) * (1 + abs(modulation.depth))
    stable = steps_for_stability(
        problems=replace(problems, numbers=loudest), grid=grid, scheme=scheme
    )
    if np.any(steps < stable):
        few = int(np.argmax(stable / steps))
        raise InputError(
            f"march: {steps[few]:.0f} steps per period with {scheme} are too few at "
            f"sigma = {problems.sigma[few]:g}; {stable[few]:.0f} are sure to be stable"
        )
    count = grid.nx * grid.ny
    size = (9 + method.stages) * count
    if method.implicit:
        size += (MOST_KRYLOV + 1) * (count + MOST_KRYLOV + 4)
    size = -(-size // 8) * 8
    groups = device.groups_for(scenes, workspace_bytes=8 * size)
    shape = (scenes, grid.nx, grid.ny)
    state, mean = (aligned(scenes * count).reshape(shape) for _ in range(2))
    state[:] = 0.0 if overpressure is None else overpressure
    results = np.empty((scenes, periods), dtype=PERIOD)
    endings = np.empty(scenes, dtype=ENDING)
    pile = Pile()
    rows = rows_of(
        [
            Columns(("nx", "ny"), np.array([grid.nx, grid.ny])),
            Columns(("steps",), steps.astype(int)[:, None, None]),
            pile.add(instant_matrices(grid, aspect=problems.aspect, terms=problems.terms)),
            pile.add_each(profile_fields(problems, grid), problems.places),
        ],
        numbers=problems.numbers,
        tolerance=_stage_tolerance(problems, steps),
        depth=np.full(scenes, modulation.depth),
        modulations=np.full(scenes, modulation.modulations),
    )
    march_films = kernel(
        device,
        "march_films",
        sources=_sources(method, problems.terms),
        header="\n".join(
            [
                c_struct("Row", rows.dtype),
                c_struct("Period", PERIOD),
                c_struct("Ending", ENDING),
                c_enum(ENDINGS),
                c_terms(problems.terms),
            ]
        ),
        defines=_defines(method),
    )
    returned: tuple[np.ndarray, ...] = state, mean, results, endings
    shared = [device.shared(values) for values in returned]
    done = march_films(
        device.queue,
        (groups * device.work_items,),
        (device.work_items,),
        scenes,
        periods,
        method.stages,
        device.sent(method.table),
        device.sent(rows),
        device.sent(pile.values),
        *shared,
        device.room(size * groups),
        size,
        device.sent(np.zeros(1, dtype=np.int32)),
        cl.LocalMemory(8 * device.work_items),
    )
    for values, buffer in zip(returned, shared, strict=True):
        device.fetch(values, buffer, after=done)
    return March(
        **{f"{name}_by_period": results[name] for name in PERIOD.names or ()},
        overpressure=state,
        mean_overpressure=mean,
        scheme=scheme,
        steps_per_period=steps.astype(int),
        **{name: endings[name] for name in ENDING.names or ()},
    )


def _sources(scheme: Scheme, terms: Terms) -> tuple[str, ...]:
    own = [term.AT_INSTANT for term in terms]
    krylov = ["krylov.cl"] if scheme.implicit else []
    grid = ["linear_algebra.cl", "vectors.cl", "march/grid_at_instant.cl"]
    return (*grid, *own, "march/film_at_instant.cl", *krylov, "march/transient.cl")


def _defines(scheme: Scheme) -> tuple[str, ...]:
    if not scheme.implicit:
        return ()
    return ("IMPLICIT", f"NEWTON={MOST_NEWTON}", f"KRYLOV={MOST_KRYLOV}")


def _stage_tolerance(problems: Problems, steps: np.ndarray) -> np.ndarray:
    """Mass error that an implicit stage may leave, shape (scenes,).

    The force is about 0.45 ε² above the cut-off of the film at σ ≈ 22 and falls as σ² below it;
    errors of all steps within a settling time may add up.
    """
    narrow = problems.sigma * min(1.0, problems.aspect) ** 2
    force = 0.45 * problems.epsilon**2 * narrow**2 / (narrow**2 + 22.0**2)
    share = np.minimum(1.0, 2 * pi / steps * pi**2 / narrow)
    return np.maximum(problems.tolerance * force * share, 1e-15 * problems.epsilon)
