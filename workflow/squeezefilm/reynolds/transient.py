"""The film in time, marched on the device: start-up from rest, rise time, yardstick (transient.cl).

``march`` follows the film through its periods; ``transient_force`` uses it to find the settled
state and its mean force. Schemes are Butcher tables; explicit ones serve where stability asks for
no more steps than accuracy does, implicit ones where the film is stiff.

The surface starts from rest at T = 0 as ε s sin T: without a jump of the gap, but with one of its
velocity, which the mass as unknown does not see. A ramp, by default none, raises the amplitude over
the first periods.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from math import pi, sqrt

import numpy as np

from squeezefilm.errors import InputError
from squeezefilm.reynolds.device import Device, kernel
from squeezefilm.reynolds.periodic import Grid, Problems, _profile_fields
from squeezefilm.reynolds.resolution import finer_grid

SOURCES = ("linear_algebra.cl", "transient.cl")
STATUS = ("ok", "a step's equations did not converge", "the pressure left the physical range")
MOST_NEWTON = 12
MOST_KRYLOV = 30
MOST_PERIODS = 60
ANDERSON_DEPTH = 10
# Round-off of the force relative to the largest overpressure.
ROUND_OFF = 1e-14
# Share of the tolerance that is left to settling and to the equations of implicit steps.
SETTLING_SHARE = 0.03
# The force is the lowest cosine moment of the mean pressure; three along each side are compared.
MOMENTS = 3
MOMENT_FACTOR = 2.0
LEAST_STEPS = 8
# Steps grow from one grid to the next by enough for their error to show in the difference.
STEP_RATIO = 1.5
# Beyond this many steps per period a scene is refused.
MOST_STEPS = 30_000
# Cost of solving for a stage in units of evaluating one, measured on 16 × 16 nodes.
SOLVE_COST = 20


@dataclass(frozen=True, eq=False)
class Scheme:
    """A Runge–Kutta method with a lower triangular table.

    Attributes:
        name: as asked for by ``scheme=``.
        order: of convergence of the period means in the step.
        error_constant: of the settled force's relative error, see ``steps_for_accuracy``.
        a, b: Butcher's table, shapes (stages, stages) and (stages,).
        real_limit: how far its region of stability reaches along the negative real axis.
    """

    name: str
    order: int
    error_constant: float
    a: np.ndarray
    b: np.ndarray
    real_limit: float = np.inf

    @property
    def c(self) -> np.ndarray:
        """Times of the stages in steps, shape (stages,)."""
        return self.a.sum(axis=1)

    @property
    def stages(self) -> int:
        return len(self.b)

    @property
    def implicit(self) -> bool:
        return bool(np.any(np.diag(self.a)))

    @property
    def step_cost(self) -> int:
        solved = int(np.count_nonzero(np.diag(self.a)))
        return SOLVE_COST * solved if solved else self.stages

    @cached_property
    def table(self) -> np.ndarray:
        return np.concatenate([self.a.ravel(), self.b, self.c])


def _scheme(
    name: str,
    rows: list[list[float]],
    *,
    order: int,
    error_constant: float,
    real_limit: float = np.inf,
) -> Scheme:
    """Scheme from its rows, the last of them the weights b; stiffly accurate ones repeat theirs."""
    stages = len(rows[-1])
    a = np.zeros((stages, stages))
    for i, row in enumerate(rows[:stages]):
        a[i, : len(row)] = row
    return Scheme(
        name=name,
        order=order,
        error_constant=error_constant,
        a=a,
        b=np.array(rows[-1]),
        real_limit=real_limit,
    )


# Classical method: 1 + z + z²/2 + z³/6 + z⁴/24 = 1 at z = −2.78529.
RK4 = _scheme(
    "rk4",
    [[], [1 / 2], [0, 1 / 2], [0, 0, 1], [1 / 6, 1 / 3, 1 / 3, 1 / 6]],
    order=4,
    error_constant=600.0,
    real_limit=2.78529,
)
# Trapezoidal rule and backward differences with one matrix for both stages, L-stable (Bank et al.
# 1985; Hosea and Shampine 1996).
TR_BDF2 = _scheme(
    "tr-bdf2",
    [[], [1 - 1 / sqrt(2)] * 2, [sqrt(2) / 4, sqrt(2) / 4, 1 - 1 / sqrt(2)]],
    order=2,
    error_constant=30.0,
)
# Implicit part of ARK4(3)6L[2]SA, L-stable, stage order two (Kennedy and Carpenter 2003).
ESDIRK4 = _scheme(
    "esdirk4",
    [
        [],
        [1 / 4, 1 / 4],
        [8611 / 62500, -1743 / 31250, 1 / 4],
        [5012029 / 34652500, -654441 / 2922500, 174375 / 388108, 1 / 4],
        [
            15267082809 / 155376265600,
            -71443401 / 120774400,
            730878875 / 902184768,
            2285395 / 8070912,
            1 / 4,
        ],
        [82889 / 524892, 0, 15625 / 83664, 69875 / 102672, -2260 / 8211, 1 / 4],
    ],
    order=4,
    error_constant=25.0,
)
SCHEMES = {scheme.name: scheme for scheme in (RK4, TR_BDF2, ESDIRK4)}


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

    def rise_periods(self, final: np.ndarray | None = None, *, within: float = 0.01) -> np.ndarray:
        """Periods after which the period mean stays within a share of its final value.

        Args:
            final: settled mean force, shape (scenes,); extrapolated from the march if left out.
            within: the share, 1/e for the rise's time constant.

        Returns:
            Periods, shape (scenes,), interpolated within the period in which the share is reached
            (the decay is exponential); NaN where the march is too short to tell.
        """
        if final is None:
            final, uncertainty = extrapolate(self.mean_by_period)
            final = np.where(uncertainty < 0.1 * within * np.abs(final), final, np.nan)
        away = np.abs(self.mean_by_period / np.asarray(final)[:, None] - 1)
        # A mean belongs to the middle of its period; at the start the force is all away.
        away = np.column_stack([np.ones(len(away)), np.maximum(away, 1e-300)])
        times = np.concatenate([[0.0], np.arange(away.shape[1] - 1) + 0.5])
        periods = np.full(len(away), np.nan)
        for scene, distance in enumerate(away):
            last = np.flatnonzero(~(distance <= within))[-1]
            if last + 1 < distance.size:
                before, after = distance[last], distance[last + 1]
                share = np.log(before / within) / np.log(before / after)
                periods[scene] = times[last] + share * (times[last + 1] - times[last])
        return periods

    def settling_radians(self) -> np.ndarray:
        """Time T in which the distance from the settled state falls by e, shape (scenes,).

        From the last three period means, which should be late enough for the slowest mode to be
        left alone; in theory σ / (π² (1 + 1/aspect²)) for a small amplitude.
        """
        change = np.diff(self.mean_by_period[:, -3:], axis=1)
        return 2 * pi / np.log(change[:, 0] / change[:, 1])


def march(
    *,
    problems: Problems,
    grid: Grid,
    periods: int,
    steps_per_period: int | np.ndarray,
    scheme: str,
    device: Device,
    ramp_periods: float = 0.0,
    overpressure: np.ndarray | None = None,
    first_period: int = 0,
    allow_unstable: bool = False,
) -> March:
    """Follow films through ``periods`` periods from rest or from a given state.

    Args:
        problems: the scenes; the film is isothermal and without slip. ``problems.tolerance`` bounds
            what the equations of implicit steps leave, relative to the force.
        grid: collocation points across the film; its ``nt`` has no meaning here.
        steps_per_period: one number, or one per scene.
        scheme: a name of SCHEMES.
        ramp_periods: the amplitude rises as sin² over so many periods.
        overpressure: P − 1 at the beginning of ``first_period``, shape (scenes, nx, ny); zero, the
            film at rest, if left out.
        allow_unstable: march even with fewer steps than an explicit scheme is sure to be stable
            with. A weak instability saturates: the force is then wrong without any other sign.

    Raises:
        InputError: for another scheme's name, scenes with terms that marching does not know, or a
            grid whose numbers of unknowns are no multiples of four; for too few explicit steps.
    """
    import pyopencl as cl

    if scheme not in SCHEMES:
        raise InputError(f"scheme {scheme!r}: unknown; allowed are {', '.join(SCHEMES)}")
    if problems.flow.shape[1] > 1 or np.any(problems.inverse_exponent != 1):
        raise InputError("march: marching in time is for isothermal films without slip only")
    if grid.nx % 4 or grid.ny % 4:
        raise InputError(f"march: {grid.nx} × {grid.ny} unknowns; both must be multiples of 4")
    method = SCHEMES[scheme]
    scenes = len(problems.epsilon)
    moving = bool(np.any(problems.bearing))
    steps = np.broadcast_to(np.asarray(steps_per_period, dtype=float), (scenes,))
    stable = steps_for_stability(problems=problems, grid=grid, scheme=scheme)
    if not allow_unstable and np.any(steps < stable):
        few = int(np.argmax(stable / steps))
        raise InputError(
            f"march: {steps[few]:.0f} steps per period with {scheme} are too few at "
            f"sigma = {problems.sigma[few]:g}; {stable[few]:.0f} are sure to be stable"
        )
    numbers = np.column_stack(
        [
            problems.epsilon,
            problems.sigma,
            problems.bearing,
            steps,
            _stage_tolerance(problems, steps),
        ]
    )
    count = grid.nx * grid.ny
    size = (9 + method.stages) * count
    if method.implicit:
        size += (MOST_KRYLOV + 1) * (count + MOST_KRYLOV + 4)
    size = -(-size // 8) * 8
    groups = min(device.groups, scenes)
    state = np.zeros((scenes, grid.nx, grid.ny))
    if overpressure is not None:
        state[:] = overpressure
    mean = np.empty_like(state)
    results = np.empty((scenes, periods, 3))
    counts = np.empty((scenes, 3), dtype=np.int32)

    flags = cl.mem_flags
    context, queue = device.context, device.queue

    def sent(values: np.ndarray) -> cl.Buffer:
        return cl.Buffer(context, flags.READ_ONLY | flags.COPY_HOST_PTR, hostbuf=values)

    state_buffer = cl.Buffer(context, flags.READ_WRITE | flags.COPY_HOST_PTR, hostbuf=state)
    mean_buffer = cl.Buffer(context, flags.READ_WRITE, state.nbytes)
    results_buffer = cl.Buffer(context, flags.WRITE_ONLY, results.nbytes)
    counts_buffer = cl.Buffer(context, flags.WRITE_ONLY, counts.nbytes)
    taken = np.zeros(1, dtype=np.int32)
    march_films = kernel(device, "march_films", sources=SOURCES, defines=_defines(method, moving))
    march_films(
        queue,
        (groups * device.work_items,),
        (device.work_items,),
        *(np.int32(n) for n in (scenes, grid.nx, grid.ny, periods, first_period)),
        np.float64(ramp_periods),
        np.int32(method.stages),
        sent(method.table),
        sent(_matrices(grid, aspect=problems.aspect, bearing=moving, implicit=method.implicit)),
        sent(numbers),
        sent(_profile_fields(problems, grid, slope=moving)),
        state_buffer,
        mean_buffer,
        results_buffer,
        counts_buffer,
        cl.Buffer(context, flags.READ_WRITE, 8 * size * groups),
        np.uint64(size),
        cl.Buffer(context, flags.READ_WRITE | flags.COPY_HOST_PTR, hostbuf=taken),
        cl.LocalMemory(8 * device.work_items),
    )
    cl.enqueue_copy(queue, state, state_buffer)
    cl.enqueue_copy(queue, mean, mean_buffer)
    cl.enqueue_copy(queue, results, results_buffer)
    cl.enqueue_copy(queue, counts, counts_buffer)
    return March(
        mean_by_period=results[..., 0],
        lowest_by_period=results[..., 1],
        highest_by_period=results[..., 2],
        overpressure=state,
        mean_overpressure=mean,
        scheme=scheme,
        steps_per_period=steps.astype(int),
        newton_steps=counts[:, 1],
        krylov_iterations=counts[:, 2],
        status=counts[:, 0],
    )


def _defines(scheme: Scheme, moving: bool) -> tuple[str, ...]:
    """The terms that the batch needs; the others are not compiled."""
    defines = ["PROFILE_FIELDS=4", "BEARING"] if moving else ["PROFILE_FIELDS=3"]
    if scheme.implicit:
        defines += ["IMPLICIT", f"NEWTON={MOST_NEWTON}", f"KRYLOV={MOST_KRYLOV}"]
    return tuple(defines)


def _matrices(grid: Grid, *, aspect: float, bearing: bool, implicit: bool) -> np.ndarray:
    """The batch's matrices in one array, in the order in which make_grid reads them."""
    values_x, vectors_x, inverse_x = grid.x.modes
    values_y, vectors_y, inverse_y = grid.y.modes
    parts = [
        grid.x.second_derivative,
        grid.y.second_derivative.T / aspect**2,
        np.outer(grid.x.weights, grid.y.weights),
    ]
    if bearing:
        parts.append(grid.x.first_derivative)
    if implicit:
        eigenvalues = np.add.outer(values_x, values_y / aspect**2)
        parts += [vectors_x, inverse_x, vectors_y.T, inverse_y.T, eigenvalues]
    return np.concatenate([np.ascontiguousarray(part).ravel() for part in parts])


def _stage_tolerance(problems: Problems, steps: np.ndarray) -> np.ndarray:
    """Mass error that an implicit stage may leave, shape (scenes,).

    The force is about 0.45 ε² above the cut-off of the film at σ ≈ 22 and falls as σ² below it;
    errors of all steps within a settling time may add up.
    """
    narrow = problems.sigma * min(1.0, problems.aspect) ** 2
    force = 0.45 * problems.epsilon**2 * narrow**2 / (narrow**2 + 22.0**2)
    share = np.minimum(1.0, 2 * pi / steps * pi**2 / narrow)
    return np.maximum(problems.tolerance * force * share, 1e-15 * problems.epsilon)


def extrapolate(mean_by_period: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Settled value of period means that decay towards it, and its uncertainty, both (scenes,).

    Aitken's formula, exact for one exponential. The faster ones that are still left die at least as
    fast as the slowest, which bounds the error by the last change of the extrapolated value.
    """
    if mean_by_period.shape[1] < 4:
        return mean_by_period[:, -1], np.full(len(mean_by_period), np.inf)
    change = np.diff(mean_by_period[:, -4:], axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.clip(np.nan_to_num(change[:, 1:] / change[:, :-1]), 0.0, 0.9999)
    tail = ratio / (1 - ratio)
    settled = mean_by_period[:, -2:] + tail * change[:, 1:]
    return settled[:, 1], np.abs(settled[:, 1] - settled[:, 0]) * np.maximum(tail[:, 1], 1.0)


def steps_for_stability(*, problems: Problems, grid: Grid, scheme: str) -> np.ndarray:
    """Least number of steps per period with which a scheme is stable, shape (scenes,).

    The largest eigenvalue of the collocated Laplacian, times the largest H²P ≤ (1 + ε |s|)², over
    σ must lie within the scheme's limit on the real axis; 1 for implicit schemes. The bearing term
    adds the largest of its own, as the limit holds in about all directions to the left.
    """
    limit = SCHEMES[scheme].real_limit
    steepest = -grid.x.modes[0].min() - grid.y.modes[0].min() / problems.aspect**2
    widest = 1 + problems.epsilon * np.abs(problems.amplitude).max(axis=(1, 2))
    rate = steepest * widest**2
    if np.any(problems.bearing):
        turning = np.abs(np.linalg.eigvals(grid.x.first_derivative)).max()
        rate = rate + problems.bearing * turning
    return np.maximum(1.0, np.ceil(2 * pi * rate / problems.sigma / limit))


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
    scenes = len(problems.epsilon)
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
            problems=_some(problems, active),
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


def _some(problems: Problems, which: np.ndarray) -> Problems:
    """Some of a batch's scenes."""
    return replace(
        problems,
        epsilon=problems.epsilon[which],
        sigma=problems.sigma[which],
        bearing=problems.bearing[which],
        inverse_exponent=problems.inverse_exponent[which],
        flow=problems.flow[which],
        amplitude=problems.amplitude[which],
    )


def steps_for_accuracy(
    *, epsilon: np.ndarray, sigma: np.ndarray, scheme: str, tolerance: float
) -> np.ndarray:
    """Guess of the steps per period that leave a share ``tolerance`` of the force, (scenes,).

    A power law whose constant was fitted to settled films of sinc profile (σ = 1 … 1e5), and for
    large amplitudes as many steps as the harmonics of 1/(1 + ε sin T) need.
    """
    method = SCHEMES[scheme]
    constant = method.error_constant / sigma * (1 + 30 / sigma) ** (method.order / 4)
    law = (constant / tolerance) ** (1 / method.order)
    ratio = epsilon / (1 + np.sqrt(1 - epsilon**2))
    harmonics = np.log(tolerance / 3) / np.log(np.maximum(ratio, 1e-300))
    return np.ceil(np.maximum(np.maximum(law, harmonics), LEAST_STEPS))


@dataclass(frozen=True)
class Choice:
    """How a scene is marched: the scheme, the steps that accuracy asks for, and why."""

    scheme: str
    accurate_steps: int
    left_out: str


def choose(
    *, problems: Problems, grid: Grid, tolerance: float, scheme: str = "auto"
) -> list[Choice]:
    """For each scene the scheme that is cheapest a priori; ``scheme`` may prescribe one.

    A step costs one unit per evaluated stage and SOLVE_COST per solved one; explicit schemes take
    as many steps as stability asks for, implicit ones as many as accuracy.
    """
    if scheme not in ("auto", *SCHEMES):
        raise InputError(f"scheme {scheme!r}: unknown; allowed are auto, {', '.join(SCHEMES)}")
    names = list(SCHEMES) if scheme == "auto" else [scheme]
    accurate = [
        steps_for_accuracy(
            epsilon=problems.epsilon, sigma=problems.sigma, scheme=name, tolerance=tolerance
        )
        for name in names
    ]
    stable = [steps_for_stability(problems=problems, grid=grid, scheme=name) for name in names]
    costs = [
        np.maximum(a, s) * SCHEMES[name].step_cost
        for name, a, s in zip(names, accurate, stable, strict=True)
    ]
    explicit_steps = steps_for_stability(problems=problems, grid=grid, scheme=RK4.name)
    choices = []
    for scene, best in enumerate(np.argmin(costs, axis=0)):
        most = int(explicit_steps[scene])
        if SCHEMES[names[best]].implicit:
            left_out = f"explicit steps, stable only from {most} a period on"
        else:
            left_out = f"implicit steps, as explicit ones are stable from {most} a period on"
        choices.append(Choice(names[best], int(accurate[best][scene]), left_out))
    return choices


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
    scheme: str = "auto",
) -> list[SettledForce]:
    """Settled mean forces by marching in time, to a relative tolerance or with a reason why not.

    Every scene is settled with two or more pairs of grid and step size, each finer in both than the
    one before, until two agree. The error estimate is the largest change of the mean pressure's
    lowest moments, which do not all agree by chance as forces may, and what has not settled.

    Args:
        problems_on: the scenes of a batch on a given grid.
        grid: the first, coarsest grid.
    """
    grid = replace(grid, nt=4)
    problems = problems_on(grid)
    choices = choose(problems=problems, grid=grid, tolerance=tolerance, scheme=scheme)
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
            stable = steps_for_stability(problems=problems, grid=grid, scheme=name)
            accurate = np.array([choice.accurate_steps for choice in choices])
            steps_of_all = np.maximum(np.ceil(accurate * STEP_RATIO**level), stable).astype(int)
            for index in group:
                if steps_of_all[index] > MOST_STEPS:
                    reason = f"it would take {steps_of_all[index]} steps per period"
                    forces[index] = _settled(progress[index], grid, 0, status=reason)
            group = [index for index in group if forces[index] is None]
            if not group:
                continue
            which = np.array(group)
            steps = steps_of_all[which]
            settled = settle(
                problems=_some(problems, which),
                grid=grid,
                steps_per_period=steps,
                scheme=name,
                device=device,
                overpressure=np.stack(
                    [_carried(progress[index].overpressure, before, grid) for index in group]
                ),
            )
            for position, index in enumerate(group):
                forces[index] = _judge(
                    progress[index], settled, position, before, grid, steps[position], tolerance
                )
        finer = finer_grid(grid)
        level += 1
    return [
        force or _settled(one, grid, 0, status="tolerance not reached on the finest grid")
        for one, force in zip(progress, forces, strict=True)
    ]


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
    floor = ROUND_OFF * float(np.abs(overpressure).max())
    error = float(settled.left[position]) + floor
    if one.mean_overpressure is None:
        error = np.inf
    else:
        change = pressure - _carried(one.mean_overpressure, before, grid)
        moments = grid.x.moments(MOMENTS) @ change @ grid.y.moments(MOMENTS).T
        error += MOMENT_FACTOR * float(np.abs(moments).max())
    one.overpressure, one.mean_overpressure = overpressure, pressure
    if error <= tolerance * abs(mean) + floor:
        return _settled(one, grid, steps, mean=mean, error=error)
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
        method=f"march, {one.choice.scheme}",
        left_out=one.choice.left_out,
        grid=grid,
        steps_per_period=int(steps),
        periods=one.periods,
        newton_steps=one.newton_steps,
        krylov_iterations=one.krylov_iterations,
    )
