"""Response of the mean force to the amplitude: gain and phase, rise and release.

By the averaged film (averaged_film.py), where its settled force is good enough. Part of the force
follows at once, as ⟨1/H⟩ does; the rest comes and goes with the gas, through the edge.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache, partial
from math import inf, nan
from typing import Any, NamedTuple

import numpy as np

from squeezefilm.dynamics.averaged_film import (
    GRID_POINT_COUNTS,
    PeriodAveragedFilm,
    averaged_film_on_grid,
    best_averaged_film,
    unsupported_reason,
)
from squeezefilm.errors import InputError, RunError
from squeezefilm.film.scene import Scene
from squeezefilm.film.validity import exceeded_limit_texts, validity_text
from squeezefilm.lazy import pd
from squeezefilm.parallel import track_progress
from squeezefilm.quantities.outputs import forces_and_negative_slopes
from squeezefilm.reynolds.device import Device

# Relative error of the settled force up to which the slow film's numbers are given.
MAX_AVERAGED_FORCE_ERROR = 0.03
# Error of a gain by the period-averaged equation, per square of the frequencies' ratio: about
# twice what the worst of 19 random films needed (ε 0.05–0.85, σ 130–8000, aspects 0.6–2.5).
GAIN_AVERAGING_ERROR_FACTOR = 2.0
# The same by the edge's layer, which does not follow at once, per ratio of the frequencies,
# thickness of the layer and motion of the edge: 1.2 times what the worst of strips and discs under
# pistons and sincs needed (ε 0.05–0.8, σ 60–3000).
GAIN_LAYER_LAG_ERROR_FACTOR = 1.5
# Modulations are slow up to this share of the vibration's frequency.
MAX_MODULATION_FREQUENCY_RATIO = 0.1
# Error of the fractions by the edge's layer, which a start or stop forms in a period, per thickness
# of the layer: 1.4 times what the worst of 24 discs needed, marched from four phases (ε 0.1–0.8,
# σ 200–3000).
FRACTION_LAYER_ERROR_FACTOR = 0.1
# By its phase a start or stop moves up to ε |s|/σ of gas along the edge, as settling does in the
# time 4/(3 ε |s|), in units of 1/ω.
PHASE_SETTLING_TIME = 4 / 3
# What is left of the way when a film counts as settled.
SETTLED_FRACTION = 0.05
STEP_RESPONSE_TIME_COUNT = 240
# Tolerance of the forces whose quotients are gains: their errors count fifty times in one.
GAIN_FORCE_TOLERANCE = 1e-4
# Terms of the gas that the averaged film neglects.
NEGLECTED_GAS_TERMS = ("inertia", "thermal")
# Numbers of a response whose change by a neglected effect is said, by what their columns call them.
SLIP_CHANGE_COLUMNS = {
    "gain": "static_gain",
    "corner": "corner_hz",
    "settling_start": "settling_start_s",
    "settling_stop": "settling_stop_s",
}


class ForceResponse(NamedTuple):
    """Response of one film, by the period-averaged equation.

    Attributes:
        static_gain: for a modulation of no frequency.
        instantaneous_gain: for one too fast for the gas to leave; its error is that of the gain at
            the corner.
        corner_hz: where what lies between them has fallen by 3 dB, as f⁻¹ᐟ² does: its relative
            error is twice that of the gain there.
        instantaneous_fraction: of the settled force, that is there when the surface starts, in the
            mean over the phases in which it may start.
        settling_start_s: until the force stays within 5 % of the settled one; its error and that of
            ``settling_stop_s`` contain the phase in which the vibration starts or stops.
        lasting_fraction: of the settled force, that is left when the surface stops, in the mean
            over the phases.
        settling_stop_s: until 5 % of the settled force is left.
        error: relative, of the static gain, which is that of the settled force.
    """

    static_gain: float
    instantaneous_gain: float
    instantaneous_gain_error: float
    corner_hz: float
    corner_error_hz: float
    instantaneous_fraction: float
    instantaneous_fraction_error: float
    settling_start_s: float
    settling_start_error_s: float
    lasting_fraction: float
    lasting_fraction_error: float
    settling_stop_s: float
    settling_stop_error_s: float
    error: float


def modulation_gains(scene: Scene, frequency_hz: np.ndarray) -> pd.DataFrame:
    """Relative change of a scene's force per small relative change of the amplitude.

    Returns:
        A row for each ``frequency_hz`` of the modulation: the size ``gain``, 2 or a little more
        where it is slow enough, ``phase_deg`` of the force behind the amplitude where negative, and
        ``error``, of the gain, relative, and of the phase in radians. NaN where a modulation is not
        slow against the vibration, as its ``status`` says, which is ``ok`` elsewhere.

    Raises RunError saying why the scene is not supported.
    """
    film, error = _accurate_averaged_film(scene)
    modulations = np.asarray(frequency_hz, dtype=float) / scene.actuator.frequency_hz
    slow = (modulations > 0) & (modulations <= MAX_MODULATION_FREQUENCY_RATIO)
    gain = np.full(len(modulations), complex(nan, nan))
    gain[slow] = film.force_gain(modulations[slow])
    fast = (
        f"a modulation's frequency must lie above 0 and up to "
        f"{MAX_MODULATION_FREQUENCY_RATIO * scene.actuator.frequency_hz:g} Hz, a tenth of the "
        f"vibration's"
    )
    return pd.DataFrame(
        {
            "frequency_hz": frequency_hz,
            "gain": np.abs(gain),
            "phase_deg": np.degrees(np.angle(gain)),
            "error": np.where(slow, error + gain_averaging_error(film, modulations), nan),
            "status": np.where(slow, "ok", fast),
        }
    )


def gain_averaging_error(film: PeriodAveragedFilm, modulation: Any) -> Any:
    """Relative error of a gain, beside that of the settled force, at modulations in units of ω."""
    lag = film.layer_thickness * film.grid.edge_mean_square_ratio
    by_layer = GAIN_LAYER_LAG_ERROR_FACTOR * modulation * lag
    return by_layer + GAIN_AVERAGING_ERROR_FACTOR * modulation**2


def start_and_stop_forces(scene: Scene) -> pd.DataFrame:
    """The mean force at times after start from rest and after stop of a scene's vibration.

    By the slow film: what lies within two periods of the vibration is no more than a direction.
    Raises RunError saying why the scene is not supported.
    """
    time, rising, falling = _start_and_stop_pressures(_accurate_averaged_film(scene)[0])
    return pd.DataFrame(
        {
            "time_s": time / scene.actuator.angular_frequency_rad_per_s,
            "rising_n": rising * scene.force_scale_n,
            "falling_n": falling * scene.force_scale_n,
        }
    )


def force_response(scene: Scene) -> ForceResponse:
    """A scene's response in a few numbers.

    Raises RunError saying why the scene is not supported.
    """
    film, _ = _accurate_averaged_film(scene)
    return _response_on_grid(scene, film.grid.points)


def _accurate_averaged_film(scene: Scene) -> tuple[PeriodAveragedFilm, float]:
    if reason := unsupported_reason(scene):
        raise RunError(f"not supported: {reason}")
    film, error = best_averaged_film(scene)
    if error > MAX_AVERAGED_FORCE_ERROR:
        raise RunError(
            "not supported: the period-averaged equation is not accurate enough (error of its "
            f"settled force: {100 * error:.2g} %, at most {100 * MAX_AVERAGED_FORCE_ERROR:g} % "
            f"is allowed)"
        )
    return film, error


@lru_cache(maxsize=10_000)
def _response_on_grid(scene: Scene, points: int) -> ForceResponse:
    """Response by the film on one grid; cached, for the effect of slip mostly needs it too."""
    film, error = averaged_film_on_grid(scene, points)
    static, prompt = film.force_gain(np.array([0.0, inf])).real
    rate = scene.actuator.angular_frequency_rad_per_s
    time, rising, falling = _start_and_stop_pressures(film)
    settled = film.mean_gauge_pressure(
        film.density(film.steady_flow_potential(film.epsilon)), film.epsilon
    )
    corner = corner_frequency_ratio(film, static, prompt)
    corner_hz = corner * scene.actuator.frequency_hz
    gain_error = error + gain_averaging_error(film, corner)
    fractions = rising[0] / settled, falling[0] / settled
    by_layer = FRACTION_LAYER_ERROR_FACTOR * film.layer_thickness
    start = _settling_time(time, np.abs(rising / settled - 1))
    stop = _settling_time(time, np.abs(falling / settled))
    return ForceResponse(
        static_gain=float(static),
        instantaneous_gain=float(prompt),
        instantaneous_gain_error=float(prompt) * gain_error,
        corner_hz=corner_hz,
        corner_error_hz=2 * gain_error * corner_hz,
        instantaneous_fraction=float(fractions[0]),
        instantaneous_fraction_error=float(error * fractions[0] + by_layer),
        settling_start_s=start / rate,
        settling_start_error_s=settling_error(film, start) / rate,
        lasting_fraction=float(fractions[1]),
        lasting_fraction_error=float(error * fractions[1] + by_layer),
        settling_stop_s=stop / rate,
        settling_stop_error_s=settling_error(film, stop) / rate,
        error=error,
    )


def settling_error(film: PeriodAveragedFilm, settling: float) -> float:
    """Error of a settling time by the phase of the start or stop, both in units of 1/ω.

    Gas that the phase moved falls off as the slowest part of the rest does: it moves that part's
    end, at most to the beginning, and two periods are never resolved.
    """
    grid = film.grid
    edge, weights = np.abs(grid.edge_s), grid.edge_weights
    slowest = film.sigma / grid.slowest_decay_rate
    moved = PHASE_SETTLING_TIME * (weights @ edge) / (film.epsilon * weights @ edge**2) / slowest
    earlier = settling if moved >= 1 else min(settling, -slowest * np.log1p(-moved))
    return float(max(earlier, slowest * np.log1p(moved))) + 4 * np.pi


def corner_frequency_ratio(film: PeriodAveragedFilm, static: float, prompt: float) -> float:
    """Modulation, in units of ω, at which |gain − prompt| has fallen by 3 dB."""
    from scipy.optimize import brentq  # slow to import, and only needed here

    def gain_above_corner(exponent: float) -> float:
        (gain,) = film.force_gain(np.array([np.exp(exponent)]))
        return float(abs(gain - prompt) - abs(static - prompt) / np.sqrt(2))

    guess = np.log(film.grid.slowest_decay_rate / film.sigma)
    return float(np.exp(brentq(gain_above_corner, guess - 6, guess + 6, rtol=1e-6)))


def _start_and_stop_pressures(
    film: PeriodAveragedFilm,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Times T and the mean gauge pressure in p0 after start and stop, each (n,).

    From a thousandth of the slowest mode's decay time to twenty times that.
    """
    slowest = film.sigma / film.grid.slowest_decay_rate
    time = np.append(0.0, np.geomspace(1e-3 * slowest, 20 * slowest, STEP_RESPONSE_TIME_COUNT))
    settled = film.density(film.steady_flow_potential(film.epsilon))
    rising = film.pressure_after_amplitude_jump(np.ones_like(settled), film.epsilon, time)
    return time, rising, film.pressure_after_amplitude_jump(settled, 0.0, time)


def _settling_time(time: np.ndarray, left: np.ndarray) -> float:
    """Return the last time at which the fraction SETTLED_FRACTION is crossed, by interpolation of
    its logarithm.
    """
    outside = np.flatnonzero(left > SETTLED_FRACTION)
    if not outside.size:
        return 0.0
    last = outside[-1]
    if last + 1 == len(time):
        return float("nan")
    ends = np.log(np.maximum(left[last : last + 2], 1e-300) / SETTLED_FRACTION)
    fraction = ends[0] / (ends[0] - ends[1])
    return float(time[last] + fraction * (time[last + 1] - time[last]))


def quasi_static_gains(scenes: Sequence[Scene], *, tolerance: float, device: Device) -> np.ndarray:
    """Relative change of the force per relative change of the amplitude, and its error: (n, 2).

    By difference quotients of forces; the scenes' terms must be decided. NaN where an amplitude
    within 2 % has no force.
    """
    within = min(tolerance, GAIN_FORCE_TOLERANCE)
    (force, error, fall, off), _ = forces_and_negative_slopes(
        scenes, "hv_m", tolerance=within, device=device
    )
    hv_m = np.array([scene.hv_m for scene in scenes])
    gain = -fall * hv_m / force
    return np.stack([gain, np.abs(gain) * error / np.abs(force) + off * hv_m / force], axis=-1)


def neglected_changes_percent(
    scenes: Sequence[Scene], *, tolerance: float, device: Device
) -> list[dict[str, float]]:
    """Changes in % of the scenes' responses by what the averaged film neglects, by columns.

    Of the gain of slow modulation with each of NEGLECTED_GAS_TERMS, NaN where a force is not found.
    Of SLIP_CHANGE_COLUMNS with first-order slip, from the slow equation with and without it on the
    coarsest grid: 0 where the scene has slip, NaN above the Knudsen numbers that it is meant for.
    """
    choices: list[dict[str, Any]] = [{}, *({name: "included"} for name in NEGLECTED_GAS_TERMS)]
    with_choices = [scene.viscous().with_gas(**choice) for scene in scenes for choice in choices]
    gains_and_errors = quasi_static_gains(with_choices, tolerance=tolerance, device=device)
    gain, error = gains_and_errors.reshape(len(scenes), len(choices), 2).T
    rows = []
    for k, scene in enumerate(scenes):
        row = _slip_changes_percent(scene)
        for name, with_it, off in zip(NEGLECTED_GAS_TERMS, gain[1:, k], error[1:, k], strict=True):
            row[f"{name}_gain_percent"] = 100 * (with_it / gain[0, k] - 1)
            row[f"{name}_gain_error_percent"] = 100 * (off + error[0, k]) / gain[0, k]
        rows.append(row)
    return rows


def _slip_changes_percent(scene: Scene) -> dict[str, float]:
    slipping = scene.with_gas(rarefaction="slip")
    if exceeded_limit_texts(slipping, symbols=("Kn",)):
        return {f"slip_{what}_percent": nan for what in SLIP_CHANGE_COLUMNS}
    before, after = (
        _response_on_grid(film_scene, GRID_POINT_COUNTS[0]) for film_scene in (scene, slipping)
    )
    return {
        f"slip_{what}_percent": 100 * (getattr(after, name) / getattr(before, name) - 1)
        for what, name in SLIP_CHANGE_COLUMNS.items()
    }


def response_table(
    table: pd.DataFrame, scenes: Sequence[Scene], *, tolerance: float, device: Device
) -> pd.DataFrame:
    """The table with the response of each scene."""
    unknown = {name: [nan] for name in ForceResponse._fields}
    found = _join_found_rows(
        table, scenes, lambda scene: pd.DataFrame([force_response(scene)]), unknown
    )
    known = np.flatnonzero(found["status"] == "ok").tolist()
    changes = neglected_changes_percent(
        [scenes[k] for k in known], tolerance=tolerance, device=device
    )
    return pd.concat([found, pd.DataFrame(changes, index=known)], axis=1)


def gain_table(
    table: pd.DataFrame, scenes: Sequence[Scene], frequency_hz: np.ndarray
) -> pd.DataFrame:
    """The table with a row for each scene and frequency: gain and phase."""
    unknown = {"frequency_hz": frequency_hz, "gain": nan, "phase_deg": nan, "error": nan}
    return _join_found_rows(
        table, scenes, partial(modulation_gains, frequency_hz=frequency_hz), unknown
    )


def with_gain_errors(table: pd.DataFrame) -> pd.DataFrame:
    """Return a table of gains with the absolute errors of gain and phase."""
    gain_error, phase_error_deg = table["error"] * table["gain"], np.degrees(table["error"])
    return table.assign(gain_error=gain_error, phase_error_deg=phase_error_deg)


def start_and_stop_table(table: pd.DataFrame, scenes: Sequence[Scene]) -> pd.DataFrame:
    """The table with a row for each scene and time: the mean force after start and stop."""
    unknown = {name: [nan] for name in ("time_s", "rising_n", "falling_n")}
    return _join_found_rows(table, scenes, start_and_stop_forces, unknown)


def _join_found_rows(
    table: pd.DataFrame,
    scenes: Sequence[Scene],
    find: Callable[[Scene], pd.DataFrame],
    unknown: dict[str, Any],
) -> pd.DataFrame:
    """Join each row of a table, and its validity, with the rows that ``find`` gives for its scene.

    What is unknown stands there with the reason as its ``status`` where nothing is found.
    """
    rows = []
    with track_progress(len(scenes), unit="scene", name="response") as bar:
        for row, scene in zip(table.to_dict(orient="records"), scenes, strict=True):
            row["validity"] = validity_text(scene.viscous())
            try:
                result = find(scene)
                result["status"] = result.get("status", "ok")
            except (InputError, RunError) as error:
                result = pd.DataFrame(unknown).assign(status=str(error))
            rows += [row | record for record in result.to_dict(orient="records")]
            bar.update(1)
    return pd.DataFrame(rows)
