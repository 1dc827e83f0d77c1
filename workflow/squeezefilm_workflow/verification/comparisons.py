"""Statements of commands about a random study, compared with direct solutions.

A comparison is an interval that a command states and a value of the same quantity that is solved
for directly: at a tolerance that is a hundredth of the study's or less, in another discretisation,
with the terms that the film's equation neglects, or by differences of such forces. *Sure and wrong*
is a statement that is given as valid and whose interval does not hold the direct value.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache, partial
from math import inf, isfinite, nan, sqrt
from operator import itemgetter
from typing import Any

import numpy as np
import pandas as pd
from scipy.optimize import newton
from scipy.stats import betabinom

from squeezefilm.api.forces import Force, solve_forces
from squeezefilm.api.models import Study
from squeezefilm.dynamics.levitation import levitate
from squeezefilm.dynamics.response import force_response
from squeezefilm.errors import InputError, RunError
from squeezefilm.film.scene import Scene
from squeezefilm.models.prediction_interval import NORMAL_QUANTILES, PROFILE_UNCERTAINTY_LEVEL
from squeezefilm.quantities.model_error import ErrorBudget
from squeezefilm.studies.space import space_of_study, table_of_points
from squeezefilm_workflow.verification.reference import reference_force

# Tolerances of direct solutions; the second with inertia or thermal effects, and under ellipses.
DIRECT_SOLVE_TOLERANCE, DIRECT_TOLERANCE_WITH_EFFECTS = 1e-7, 1e-5
# What the flow factor adds to first-order slip, relative to the flow, for each unit of Kn.
FLOW_CHANGE_PER_KNUDSEN = 1.5
# Of films that the spectral elements resolve in seconds.
MAX_REFERENCE_EPSILON, REFERENCE_SIGMA_RANGE = 0.6, (1.0, 2e4)
# Relative distance of the forces in difference quotients of fourth order.
RELATIVE_DIFFERENCE_STEP = 0.004
# Gaps beyond one that levitates, at which the force must stay below the load.
MAX_GAP_RATIO, WIDER_GAP_COUNT = 4.0, 12
# Points outside the declared space, which no prediction interval may claim.
OUTSIDE_POINT_COUNT = 20
# Of the fresh points of the study of seed 0.
FRESH_POINTS_SEED = 10_000
COMPARISON_OUTCOMES = (
    "within",
    "sure and wrong",
    "outside, not stated as valid",
    "no direct solution",
)


def _ratios_to_validity_limits(scene: Scene) -> dict[str, float]:
    """Numbers of a scene over values beyond which a force is not to be given without reserve.

    Flow around the edge is of the order of the gap over the pad; gas neither slips nor flows as a
    viscous fluid from Kn 0.18 on, and the flow factor ends at Kn 89; inertia changes forces
    severalfold at Re 10, and its depth-averaged term is unchecked above Re 20; pressure differs
    across a gap by a fifth at a tenth of the sound's wavelength.
    """
    gas, pad = scene.gas, scene.pad
    sound_m_per_s = sqrt(gas.heat_capacity_ratio * gas.ambient_pressure_pa / gas.density_kg_per_m3)
    wavelength_m = sound_m_per_s / scene.actuator.frequency_hz
    return {
        "gap over pad": scene.h0_m / min(pad.length_x_m, pad.length_y_m) / 0.1,
        "Knudsen number": scene.knudsen / (89.0 if gas.rarefaction == "fukui-kaneko" else 0.178),
        "Reynolds number": scene.modified_reynolds / (20.0 if gas.inertia == "included" else 10.0),
        "gap over sound's wavelength": scene.h0_m / wavelength_m / 0.1,
        "excursion over gap": scene.closure() / 0.95,
    }


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
        """One of COMPARISON_OUTCOMES."""
        if not isfinite(self.direct):
            return COMPARISON_OUTCOMES[3]
        low, high = self.lower - self.direct_error, self.upper + self.direct_error
        if low <= self.direct <= high:
            return COMPARISON_OUTCOMES[0]
        return COMPARISON_OUTCOMES[1] if self.valid else COMPARISON_OUTCOMES[2]


def _interval_around(value: float, off: float) -> tuple[float, float]:
    """The interval of a value and by how much it may be off."""
    return value - off, value + off


def compare_study(study: Study, *, points: int, seed: int) -> Iterator[Comparison]:
    """All comparisons of a study but those of its models.

    Args:
        points: scenes of the study's space that are simulated.
        seed: of their draw.
    """
    settings = study.solver(outputs=())
    space = space_of_study(study.config, centred=False)
    scenes = study.scenes(table_of_points(space.independent_sample(points, seed=seed), space))
    forces = solve_forces(scenes, settings=settings, smoothed=None, budget=True)
    for force in forces:
        yield from _compare_force(force, study, valid=force.status == force.validity == "ok")
    for scene, force in zip(scenes, forces, strict=True):
        if force.status == "ok" and force.force_n > 0:
            yield from _compare_spectral_elements(force.scene, study)
            yield from _compare_levitation(scene, force.force_n, study)
            yield from _compare_response(force.scene, study)
            break


def _scene_text(scene: Scene) -> str:
    return (
        f"h0 {1e6 * scene.h0_m:.5g} µm, hv {1e6 * scene.hv_m:.5g} µm, x {1e3 * scene.x_m:.5g} mm, "
        f"y {1e3 * scene.y_m:.5g} mm; Re {scene.modified_reynolds:.2g}, Kn {scene.knudsen:.2g}"
    )


def forces_and_errors(
    scenes: Sequence[Scene], study: Study, *, tolerance: float | None = None
) -> np.ndarray:
    """Forces and their errors, NaN where there is none, shape (2, n)."""
    solutions = study.solver(tolerance=tolerance, outputs=()).solve(scenes)
    return np.array([solutions.force_n, solutions.force_error_n])


def _direct_forces_and_errors(scenes: Sequence[Scene], study: Study) -> np.ndarray:
    """Forces and errors by direct solutions with a tolerance far below the stated errors."""
    gas = scenes[0].gas
    plain = gas.inertia == gas.thermal == "none" and scenes[0].pad.shape == "rectangle"
    forces = forces_and_errors(
        scenes, study, tolerance=DIRECT_SOLVE_TOLERANCE if plain else DIRECT_TOLERANCE_WITH_EFFECTS
    )
    if plain and not np.isfinite(forces).all():
        return forces_and_errors(scenes, study, tolerance=DIRECT_TOLERANCE_WITH_EFFECTS)
    return forces


def _direct_force_and_derivative(scene: Scene, name: str, study: Study) -> np.ndarray:
    """The direct force, its error, its derivative to a number of the scene, and that one's error.

    By five values, of fourth order.
    """
    unit = getattr(scene, name)
    around: list[dict[str, Any]] = [
        {name: unit * (1 + RELATIVE_DIFFERENCE_STEP * k)} for k in range(-2, 3)
    ]
    values, errors = _direct_forces_and_errors(
        [replace(scene, **change) for change in around], study
    )
    narrow, wide = (values[3] - values[1]) / 2, (values[4] - values[0]) / 4
    noise = (8 * (errors[1] + errors[3]) + errors[0] + errors[4]) / 12
    slope = (4 * narrow - wide) / 3
    off = noise + (4 * RELATIVE_DIFFERENCE_STEP) ** 2 * abs(wide - narrow)
    return np.array(
        [
            values[2],
            errors[2],
            slope / (RELATIVE_DIFFERENCE_STEP * unit),
            off / (RELATIVE_DIFFERENCE_STEP * unit),
        ]
    )


def _compare_force(force: Force, study: Study, *, valid: bool) -> Iterator[Comparison]:
    """The force and its numerical error, then what the equation neglects."""
    scene, stated = force.scene, force.force_n
    worst, number = max(_ratios_to_validity_limits(scene).items(), key=itemgetter(1))
    simulate = partial(Comparison, "simulate", note=_scene_text(scene))
    what, note = "numbers over limits of validity", f"{worst}; {_scene_text(scene)}"
    yield simulate(what, -inf, 1.0, number, valid=valid, note=note)
    if not isfinite(stated):
        return
    ((direct,), (error,)) = _direct_forces_and_errors([scene], study)
    yield simulate("force / N", *_interval_around(stated, force.error_n), direct, error, valid)
    for name, with_them, change, off, usable in _neglected_effects(scene, force.budget):
        if with_them.gas.rarefaction != "none" and with_them.gas.inertia == "included":
            # Inertia is derived for first-order slip: its relative part is taken from there.
            full, error = _force_change_with_slip(scene, with_them, stated, study)
        else:
            ((full,), (error,)) = _direct_forces_and_errors([with_them], study)
        ends = _interval_around(change * stated, off * abs(stated) + 2 * force.error_n)
        yield simulate(f"{name} / N", *ends, full - stated, error, valid and usable)


def _force_change_with_slip(
    scene: Scene, with_them: Scene, stated: float, study: Study
) -> tuple[float, float]:
    """Force scaled by the relative change that terms make with first-order slip, and its error."""
    slipping = [each.with_gas(rarefaction="slip") for each in (scene, with_them)]
    ((before,), (error,)), ((after,), (other,)) = (
        _direct_forces_and_errors([each], study) for each in slipping
    )
    part = after / before - 1
    kinetic = 0.0 if scene.gas.rarefaction == "slip" else FLOW_CHANGE_PER_KNUDSEN * scene.knudsen
    off = abs(stated) * (abs(part) * kinetic + (error + other) / abs(before))
    return float(stated * (1 + part)), float(off)


def _compare_spectral_elements(scene: Scene, study: Study) -> Iterator[Comparison]:
    """The isothermal film without inertia, against spectral elements of other equations."""
    scene = scene.viscous().with_gas(rarefaction="none")
    low, high = REFERENCE_SIGMA_RANGE
    square = scene.pad.shape == "rectangle" and scene.aspect == 1
    if not (square and scene.epsilon <= MAX_REFERENCE_EPSILON and low <= scene.sigma <= high):
        return
    ((stated,), (error,)) = forces_and_errors([scene], study)
    reference = reference_force(scene, degree=14)
    direct_n = scene.force_scale_n * reference.force
    off_n = scene.force_scale_n * reference.uncertainty
    simulate = partial(Comparison, "simulate", valid=isfinite(stated), note=_scene_text(scene))
    yield simulate("force by elements / N", *_interval_around(stated, error), direct_n, off_n)


def _neglected_effects(
    scene: Scene, budget: ErrorBudget
) -> Iterator[tuple[str, Scene, float, float, bool]]:
    """Effects that a force does not have and the solver knows: the scene that has one, what it
    changes of the force, by how much that may be off, and whether it is known.

    The loss of pressure where gas flows in, of no equation here, is not among them.
    """
    gas = scene.gas
    slips = gas.rarefaction == "none" and gas.inertia == gas.thermal == "none"
    choices = {"inertia": {"inertia": "included"}, "thermal": {"thermal": "included"}}
    rarefied = {"rarefaction": "fukui-kaneko"}
    for name, effects, having in (
        *((name, (name,), choices[name]) for name in choices),
        ("rarefaction", ("slip", "flow_factor") if slips else (), rarefied),
    ):
        lacking = {
            effect_name: budget.neglected_effects[effect_name]
            for effect_name in effects
            if effect_name in budget.neglected_effects
        }
        if lacking:
            change = sum(effect.percent for effect in lacking.values()) / 100
            off = sum(effect.error_percent for effect in lacking.values()) / 100
            known = budget.status == "ok" and not {*budget.unknown_effect_names} & lacking.keys()
            yield name, scene.with_gas(**having), change, off, known


def _compare_levitation(scene: Scene, load_n: float, study: Study) -> Iterator[Comparison]:
    """Gap, stiffness and modelling error under a load."""
    try:
        levitation = levitate(scene, load_n=load_n, **study.solver().levitation_arguments)
    except (InputError, RunError):
        return
    scene, h0_m, stiffness = levitation.scene, levitation.scene.h0_m, levitation.stiffness_n_per_m
    stated = partial(Comparison, "levitate", note=f"load {load_n:.5g} N; {_scene_text(scene)}")
    direct_n, error_n, slope, slope_error = _direct_force_and_derivative(scene, "h0_m", study)
    gap_m = h0_m - (direct_n - load_n) / slope
    ends = _interval_around(h0_m, levitation.h0_error_m)
    yield stated("gap / m", *ends, gap_m, error_n / abs(slope))
    ends = _interval_around(stiffness, levitation.stiffness_error_n_per_m)
    yield stated("stiffness / (N/m)", *ends, -slope, slope_error)
    wider = np.geomspace(1.02 * h0_m, min(MAX_GAP_RATIO * h0_m, 1e-3), WIDER_GAP_COUNT)
    there = [replace(scene, h0_m=float(gap)) for gap in wider]
    most = float(np.nanmax(forces_and_errors(there, study, tolerance=1e-3)[0], initial=-inf))
    yield stated("force at wider gaps / N", -inf, load_n, most)
    for name, with_them, change, off, usable in _neglected_effects(scene, levitation.budget):
        change_m = load_n / stiffness * change
        off_m = load_n / abs(stiffness) * off + levitation.second_order_error_m(change_m)
        ends = _interval_around(h0_m + change_m, off_m + 2 * levitation.h0_error_m)
        numbers = (
            *ends,
            _direct_gap_under_load(with_them, load_n, study),
            2 * DIRECT_TOLERANCE_WITH_EFFECTS * h0_m,
        )
        yield stated(f"gap with {name} / m", *numbers, usable)


def _direct_gap_under_load(scene: Scene, load_n: float, study: Study) -> float:
    """The gap near a scene's at which the force is the load; NaN where it is not found."""

    def excess_force_n(gap_m: float) -> float:
        force_n = float(_direct_forces_and_errors([replace(scene, h0_m=float(gap_m))], study)[0, 0])
        if not isfinite(force_n):
            raise RunError("no force")
        return force_n - load_n

    try:
        near_m = scene.h0_m
        return float(
            newton(
                excess_force_n,
                near_m,
                x1=1.02 * near_m,
                tol=DIRECT_TOLERANCE_WITH_EFFECTS * near_m,
                maxiter=12,
            )
        )
    except (RunError, InputError, RuntimeError):
        return nan


def _compare_response(scene: Scene, study: Study) -> Iterator[Comparison]:
    """The gain of slow modulation against d ln F / d ln hv of direct forces."""
    scene = scene.viscous()
    try:
        stated = force_response(scene)
    except (InputError, RunError):
        return
    force_n, error_n, slope, slope_error = _direct_force_and_derivative(scene, "hv_m", study)
    gain = slope * scene.hv_m / force_n
    error = abs(gain) * (abs(slope_error / slope) + error_n / abs(force_n))
    ends = _interval_around(stated.static_gain, stated.error * abs(stated.static_gain))
    yield Comparison("response", "static gain", *ends, gain, error, note=_scene_text(scene))


def compare_coverage(
    study: Study, *, models: Sequence[str], fresh: int, seed: int, level_of_test: float
) -> Iterator[Comparison]:
    """Compare the number of new points inside the models' prediction intervals with theory.

    Args:
        fresh: independent points, uniform over the declared space, for each model.
        seed: of the study; their draw has another.
        level_of_test: probability that the number of points inside lies outside the stated
            interval, if the prediction interval is what it says.
    """

    @cache
    def simulated_forces(centred: bool) -> tuple[pd.DataFrame, np.ndarray]:
        space = space_of_study(study.config, centred=centred)
        points = table_of_points(
            space.independent_sample(fresh, seed=FRESH_POINTS_SEED + seed), space
        )
        return points, forces_and_errors(study.scenes(points), study)

    for name in models:
        try:
            fit = study.fit(name)
            interval = fit.model.prediction_interval
            centred = fit.model.force_model.is_for_centred_pad
            if interval is None or interval.error_95 is None:
                continue
            points, (force_n, error_n) = simulated_forces(centred)
            stated = fit.predict_at(points)
        except (InputError, RunError):
            continue  # not a model of this study, or its physics does not hold all over the space
        off = np.abs(stated["force_n"] - force_n) + error_n
        beyond = points.head(OUTSIDE_POINT_COUNT).assign(h0_m=1.5 * points["h0_m"].max())
        claimed = float(fit.predict_at(beyond)["error_95_n"].notna().sum())
        what = "points outside the space that have an error"
        yield Comparison("predict", what, 0.0, 0.0, claimed, note=fit.name)
        for level, quantile in NORMAL_QUANTILES.items():
            half = stated[f"error_{100 * level:.0f}_n"].to_numpy()
            # A scan's part comes on top of what the sample measures.
            scan = (
                interval.profile_uncertainty
                * quantile
                / NORMAL_QUANTILES[PROFILE_UNCERTAINTY_LEVEL]
            )
            inside = int(np.sum(off <= half - scan * np.abs(stated["force_n"])))
            count = interval.calibration_points
            rank = int(np.ceil((count + 1) * level))
            if rank > count or np.isnan(half).all():
                continue  # such an interval is not stated
            law = betabinom(fresh, rank, count + 1 - rank)
            ends = float(law.ppf(level_of_test / 2)), float(law.isf(level_of_test / 2))
            what = f"points of {fresh} within {100 * level:.0f} %"
            note = f"{fit.name}, {'centred' if centred else 'all factors'}"
            yield Comparison("predict", what, *ends, inside, note=note)
