"""What commands state about a random study, compared with direct solutions.

A comparison is an interval that a command states and a value of the same quantity that is solved
for directly: at a tolerance that is a hundredth of the study's or less, in another discretisation,
with the terms that the film's equation neglects, or by differences of such forces. *Sure and wrong*
is a statement that is given as valid and whose interval does not hold the direct value.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from math import inf, isfinite, nan, sqrt
from typing import Any

import numpy as np
import pandas as pd
from scipy.optimize import brentq

from squeezefilm.api.forces import Force, forces_of, forces_table
from squeezefilm.api.models import Study
from squeezefilm.dynamics.averaged_film import averaged_film_of
from squeezefilm.dynamics.levitation import levitate, resonance
from squeezefilm.dynamics.response import response
from squeezefilm.errors import InputError, RunError
from squeezefilm.film.scene import Scene
from squeezefilm.quantities.model_error import ErrorBudget, error_budgets
from squeezefilm.reynolds import solve
from squeezefilm.studies.solver_settings import SolverSettings, solver_settings
from squeezefilm.studies.space import Space
from verification.reference import reference_force

TIGHT, LESS_TIGHT = 1e-7, 1e-5
"""Tolerances of direct solutions; the second with inertia or heat, and under ellipses."""
KINETIC = 1.5
"""What the flow factor adds to first-order slip, relative to the flow, for each unit of Kn."""
REFERENCE_EPSILON, REFERENCE_SIGMA = 0.6, (1.0, 2e4)
"""Of films that the spectral elements resolve in seconds."""
STEP = 0.004
"""Relative distance of the forces in difference quotients of fourth order."""
WIDER, WIDER_GAPS = 4.0, 12
"""Gaps beyond one that levitates, at which the force must stay below the load."""
ABOUT = 0.05
"""Relative error of what commands print in two digits without an error."""
GRAVITY_M_PER_S2 = 9.81
OUTCOMES = ("within", "sure and wrong", "outside, not stated as valid", "no direct solution")


def _wavelength_m(scene: Scene) -> float:
    """Of sound in the free gas."""
    gas = scene.gas
    speed = sqrt(gas.heat_capacity_ratio * gas.ambient_pressure_pa / gas.density_kg_per_m3)
    return speed / scene.actuator.frequency_hz


LARGEST: dict[str, Callable[[Scene], float]] = {
    "gap over pad": lambda scene: (
        scene.h0_m / min(scene.finger.length_x_m, scene.finger.length_y_m) / 0.1
    ),
    "Knudsen number": lambda scene: scene.knudsen / 0.178,
    "Reynolds number": lambda scene: (
        scene.modified_reynolds / (20.0 if scene.gas.inertia == "included" else 10.0)
    ),
    "gap over sound's wavelength": lambda scene: scene.h0_m / _wavelength_m(scene) / 0.1,
    "excursion over gap": lambda scene: scene.closure() / 0.95,
}
"""Numbers of a scene over values beyond which a force is not to be given without reserve.

Flow around the edge is of the order of the gap over the pad; gas neither slips nor flows as a
viscous fluid from Kn 0.18 on (Fukui and Kaneko's D = 5); inertia changes forces severalfold at Re
10, and its depth-averaged term is unchecked above Re 20; pressure differs across a gap by a fifth
at a tenth of the sound's wavelength.
"""


@dataclass(frozen=True)
class Comparison:
    """A stated interval and the direct value of the same quantity.

    Attributes:
        command: that states it.
        quantity: what it is, with its unit.
        lower, upper: the stated interval.
        direct, direct_error: the value solved for directly; NaN where there is none.
        valid: the command states the interval without reserve.
        note: what is stated beside it, or of which scene it is.
    """

    command: str
    quantity: str
    lower: float
    upper: float
    direct: float
    direct_error: float = 0.0
    valid: bool = True
    note: str = ""

    @property
    def outcome(self) -> str:
        """One of OUTCOMES."""
        if not isfinite(self.direct):
            return OUTCOMES[3]
        low, high = self.lower - self.direct_error, self.upper + self.direct_error
        if low <= self.direct <= high:
            return OUTCOMES[0]
        return OUTCOMES[1] if self.valid else OUTCOMES[2]


def compared(study: Study, *, points: int, seed: int) -> Iterator[Comparison]:
    """All comparisons of a study but those of its models.

    Args:
        points: scenes of the study's space that are simulated.
        seed: of their draw.
    """
    settings = solver_settings(study.config, outputs=())
    space = Space.of(study.config, centred=False)
    drawn = space.table(space.independent_sample(points, seed=seed))
    forces = forces_of(
        study.scenes(drawn), settings=settings, device=study.device, smoothed=None, budget=True
    )
    table = forces_table(drawn, forces)
    stated = table.get("validity", pd.Series("ok", index=table.index))
    for force, validity in zip(forces, stated, strict=True):
        yield from _of_force(force, study, valid=force.status == validity == "ok")
    known = next((each for each in forces if each.status == "ok" and each.force_n > 0), None)
    if known is not None:
        yield from _of_elements(known.scene, study)
        yield from _of_levitation(known, study, settings)
        yield from _of_response(known.scene, study)


def _where(scene: Scene) -> str:
    return (
        f"h0 {1e6 * scene.h0_m:.5g} µm, hv {1e6 * scene.hv_m:.5g} µm, x {1e3 * scene.x_m:.5g} mm, "
        f"y {1e3 * scene.y_m:.5g} mm; Re {scene.modified_reynolds:.2g}, Kn {scene.knudsen:.2g}"
    )


def forces_and_errors(
    scenes: Sequence[Scene], study: Study, *, tolerance: float | None = None
) -> np.ndarray:
    """Forces and their errors, NaN where there is none, shape (2, n)."""
    settings = solver_settings(study.config, tolerance=tolerance, outputs=())
    found = solve(settings.resolved(scenes, study.device), **settings.how(study.device))
    return np.array([(each.force_n, each.force_error_n) for each in found]).T


def _direct(scenes: Sequence[Scene], study: Study) -> np.ndarray:
    """The same far within what is stated of them, as far as that can be had."""
    gas = scenes[0].gas
    plain = gas.inertia == gas.heat == "none" and scenes[0].finger.shape == "rectangle"
    if plain:
        found = forces_and_errors(scenes, study, tolerance=TIGHT)
        if np.isfinite(found).all():
            return found
    return forces_and_errors(scenes, study, tolerance=LESS_TIGHT)


def _gas(scene: Scene, **changes: Any) -> Scene:
    return replace(scene, gas=replace(scene.gas, **changes))


def _of_force(force: Force, study: Study, *, valid: bool) -> Iterator[Comparison]:
    """The force and its numerical error, then what the equation neglects."""
    scene, stated = force.scene, force.force_n
    where = _where(scene)
    numbers = {name: of(scene) for name, of in LARGEST.items()}
    worst = max(numbers, key=numbers.__getitem__)
    yield Comparison(
        "simulate",
        "numbers over limits of validity",
        -inf,
        1.0,
        numbers[worst],
        0.0,
        valid,
        f"{worst}; {where}",
    )
    if not isfinite(stated):
        return
    ((direct,), (error,)) = _direct([scene], study)
    ends = stated - force.error_n, stated + force.error_n
    yield Comparison("simulate", "force / N", *ends, direct, error, valid, where)
    for name, (effects, with_them) in _neglected(scene, force.budget).items():
        first = [force.budget.effects[each] for each in effects]
        change = sum(each.percent for each in first) / 100 * stated
        off = sum(each.off_percent for each in first) / 100 * abs(stated) + 2 * force.error_n
        # Effects of another pad are a guide; their sum is stated as not known.
        usable = not (force.budget.basis or set(effects) & set(force.budget.above_range))
        if with_them.gas.rarefaction != "none" and with_them.gas.inertia == "included":
            # Inertia is derived for first-order slip: its relative part is taken from there.
            full, error = _change_with_slip(scene, with_them, stated, study)
        else:
            ((full,), (error,)) = _direct([with_them], study)
        yield Comparison(
            "simulate",
            f"{name} / N",
            change - off,
            change + off,
            full - stated,
            error,
            valid and usable and force.budget.status == "ok",
            where,
        )


def _change_with_slip(
    scene: Scene, with_them: Scene, stated: float, study: Study
) -> tuple[float, float]:
    """A force times what terms do to it in a film of first-order slip, and the error."""
    slipping = [_gas(each, rarefaction="slip") for each in (scene, with_them)]
    ((before,), (error,)), ((after,), (other,)) = (_direct([each], study) for each in slipping)
    part = after / before - 1
    kinetic = 0.0 if scene.gas.rarefaction == "slip" else KINETIC * scene.knudsen
    off = abs(stated) * (abs(part) * kinetic + (error + other) / abs(before))
    return float(stated * (1 + part)), float(off)


def _of_elements(scene: Scene, study: Study) -> Iterator[Comparison]:
    """The viscous film without inertia and heat, against spectral elements of other equations."""
    scene = _gas(scene, rarefaction="none", inertia="none", heat="none")
    low, high = REFERENCE_SIGMA
    square = scene.finger.shape == "rectangle" and scene.aspect == 1
    if not (square and scene.epsilon <= REFERENCE_EPSILON and low <= scene.sigma <= high):
        return
    ((stated,), (error,)) = forces_and_errors([scene], study)
    found = reference_force(epsilon=scene.epsilon, sigma=scene.sigma, gap=scene.gap, degree=14)
    yield Comparison(
        "simulate",
        "force by elements / N",
        stated - error,
        stated + error,
        scene.force_scale_n * found.force,
        scene.force_scale_n * found.uncertainty,
        isfinite(stated),
        _where(scene),
    )


def _neglected(scene: Scene, budget: ErrorBudget) -> dict[str, tuple[tuple[str, ...], Scene]]:
    """Effects that a force does not have and the solver knows, and the scene that has them.

    The loss of pressure where gas flows in, of no equation here, is not among them.
    """
    lacking = [name for name in ("inertia", "heat") if not budget.effects[name].included]
    found: dict[str, tuple[tuple[str, ...], Scene]] = {}
    if lacking:
        included = {name: "included" for name in ("inertia", "heat")}
        found["inertia, heat"] = (tuple(lacking), _gas(scene, **included))
    if scene.gas.rarefaction != "fukui-kaneko" and scene.gas.inertia == scene.gas.heat == "none":
        effects = ("kinetic",) if budget.effects["slip"].included else ("slip", "kinetic")
        found["rarefaction"] = (effects, _gas(scene, rarefaction="fukui-kaneko"))
    return found


def _of_levitation(force: Force, study: Study, settings: SolverSettings) -> Iterator[Comparison]:
    """Gap, stiffness, modelling error and resonance under the load that a force carries."""
    load_n = force.force_n
    scene = force.scene
    try:
        found = levitate(
            study.scenes(pd.DataFrame([_point(scene)]))[0],
            load_n=load_n,
            tolerance=settings.tolerance,
            model_tolerance=settings.model_tolerance,
            device=study.device,
        )
    except (InputError, RunError):
        return
    h0_m, scene = found.scene.h0_m, found.scene
    where = f"load {load_n:.5g} N; {_where(scene)}"
    valid = getattr(found, "validity", "ok") == "ok"
    around = h0_m * (1 + STEP * np.arange(-2, 3))
    direct, errors = _direct([replace(scene, h0_m=float(gap)) for gap in around], study)
    slope, slope_error = _slope(direct, errors, STEP * h0_m)
    gap_m = h0_m - (direct[2] - load_n) / slope
    ends = h0_m - found.h0_error_m, h0_m + found.h0_error_m
    numbers = gap_m, errors[2] / abs(slope)
    yield Comparison("levitate", "gap / m", *ends, *numbers, valid, where)
    ends = (
        found.stiffness_n_per_m - found.stiffness_error_n_per_m,
        found.stiffness_n_per_m + found.stiffness_error_n_per_m,
    )
    yield Comparison("levitate", "stiffness / (N/m)", *ends, -slope, slope_error, valid, where)
    wider = np.geomspace(1.02 * h0_m, min(WIDER * h0_m, 1e-3), WIDER_GAPS)
    there = [replace(scene, h0_m=float(gap)) for gap in wider]
    most = float(np.nanmax(forces_and_errors(there, study, tolerance=1e-3)[0], initial=-inf))
    yield Comparison("levitate", "force at wider gaps / N", -inf, load_n, most, 0.0, valid, where)
    budget = getattr(found, "budget", None) or error_budgets([scene], device=study.device)[0]
    for name, (effects, with_them) in _neglected(scene, budget).items():
        first = [budget.effects[each] for each in effects]
        per_percent = load_n / found.stiffness_n_per_m / 100
        change = sum(each.percent for each in first) * per_percent
        off = sum(each.off_percent for each in first) * abs(per_percent) + 2 * found.h0_error_m
        another = budget.status != "ok" or budget.basis
        usable = not (another or set(effects) & set(budget.above_range))
        gap = _gap_under(with_them, load_n, study)
        yield Comparison(
            "levitate",
            f"gap with {name} / m",
            h0_m + change - off,
            h0_m + change + off,
            gap,
            2 * LESS_TIGHT * h0_m,
            valid and usable,
            where,
        )
    yield from _of_resonance(found, load_n / GRAVITY_M_PER_S2, valid=valid, where=where)


def _point(scene: Scene) -> dict[str, float]:
    return {name: getattr(scene, name) for name in ("h0_m", "hv_m", "x_m", "y_m")}


def _slope(values: np.ndarray, errors: np.ndarray, step: float) -> tuple[float, float]:
    """Derivative by five values, of fourth order, and its error."""
    narrow, wide = (values[3] - values[1]) / 2, (values[4] - values[0]) / 4
    noise = (8 * (errors[1] + errors[3]) + errors[0] + errors[4]) / 12
    return (4 * narrow - wide) / 3 / step, (noise + (4 * STEP) ** 2 * abs(wide - narrow)) / step


def _gap_under(scene: Scene, load_n: float, study: Study) -> float:
    """The gap near a scene's at which the force is the load; NaN where it is not found."""

    def excess(gap_m: float) -> float:
        force_n = float(_direct([replace(scene, h0_m=gap_m)], study)[0, 0])
        if not isfinite(force_n):
            raise RunError("no force")
        return force_n - load_n

    low = high = scene.h0_m
    try:
        for _ in range(12):
            low, high = max(low / 1.04, 1.001 * scene.hv_m), high * 1.04
            if excess(low) > 0 > excess(high):
                return float(brentq(excess, low, high, xtol=1e-16, rtol=LESS_TIGHT))
    except (RunError, InputError):
        pass
    return nan


def _of_resonance(found: Any, mass_kg: float, *, valid: bool, where: str) -> Iterator[Comparison]:
    """Frequency and damping against the root of the equation of motion.

    mass·s² + K(s) = 0, s complex, K the film's dynamic stiffness: that of slow motion, and what the
    averaged film adds at s.
    """
    moving = resonance(found, mass_kg=mass_kg)
    if not isfinite(moving.frequency_hz):
        return
    scene = _gas(found.scene, inertia="none", heat="none")
    film, _ = averaged_film_of(scene)
    rate = scene.actuator.angular_frequency_rad_per_s
    unit = scene.force_scale_n / scene.h0_m
    at_rest = film.stiffness(np.array([0.0]))[0].real
    ratio = moving.damping_ratio
    s = 2 * np.pi * moving.frequency_hz * complex(-ratio / sqrt(max(1 - ratio**2, 1e-12)), 1.0)

    def motion(s: complex) -> complex:
        added = film.stiffness(np.array([s / (1j * rate)]))[0] - at_rest
        return complex(mass_kg * s**2 + found.stiffness_n_per_m + unit * added)

    for _ in range(30):  # the secant method
        step = 1e-5 * abs(s)
        s -= motion(s) * step / (motion(s + step) - motion(s))
    if abs(motion(s)) > 1e-6 * mass_kg * abs(s) ** 2:
        s = complex(nan, nan)
    for quantity, stated, direct in (
        ("resonance / Hz", moving.frequency_hz, s.imag / (2 * np.pi)),
        ("damping ratio", moving.damping_ratio, -s.real / abs(s)),
    ):
        off = ABOUT * stated
        yield Comparison(
            "levitate", quantity, stated - off, stated + off, direct, 0.0, valid, where
        )


def _of_response(scene: Scene, study: Study) -> Iterator[Comparison]:
    """The gain of slow modulation against d ln F / d ln hv of direct forces."""
    scene = _gas(scene, inertia="none", heat="none")
    try:
        stated = response(scene)
    except (InputError, RunError):
        return
    if not isfinite(stated.static_gain):
        return
    around = scene.hv_m * (1 + STEP * np.arange(-2, 3))
    direct, errors = _direct([replace(scene, hv_m=float(hv_m)) for hv_m in around], study)
    slope, slope_error = _slope(direct, errors, STEP * scene.hv_m)
    gain = slope * scene.hv_m / direct[2]
    error = abs(gain) * (abs(slope_error / slope) + errors[2] / abs(direct[2]))
    off = stated.error * abs(stated.static_gain)
    ends = stated.static_gain - off, stated.static_gain + off
    yield Comparison("response", "static gain", *ends, gain, error, True, _where(scene))
