"""How the mean force follows a changing amplitude: gain and phase, rise and release.

  squeezefilm response --h0 5um --hv 2.2um [--frequencies 10Hz,100Hz,300Hz]
  squeezefilm response SCENES.csv --config CONFIG.yaml --output RESPONSE.csv [--gains GAINS.csv]
  squeezefilm response SCENES.csv --config CONFIG.yaml --steps STEPS.csv

The gain is the relative change of the force per relative change of the amplitude: twice a little
for slow modulation. Part of the force follows at once, the rest with the gas that comes and goes
through the rim: `prompt_gain` is what is left of the gain above the corner, `corner_hz`; the film
passes modulation at any frequency, with another size. `rise_s` is until the force stays within 5 %
after the surface starts, `release_s` until 5 % is left after it stops, each to about two periods.

By the slow film equation where its error is at most 3 %, else by marching through every period;
without inertia and heat of the gas. Where `gas: auto` would have them in the force, what they do to
the gain of slow modulation is said for one scene; `squeezefilm budget` says what they are for the
force.
"""

from __future__ import annotations

import argparse
from dataclasses import asdict, replace
from math import isfinite

import numpy as np
import pandas as pd

from squeezefilm.api.points import scene_points_of
from squeezefilm.cli import which_study
from squeezefilm.cli.points import add_point_options, points_in
from squeezefilm.film.scene import Scene
from squeezefilm.io.errors import InputError, RunError, naming
from squeezefilm.io.progress import progress_bar
from squeezefilm.io.tables import read_scenes, scene_points, write_table
from squeezefilm.io.typed_units import quantities
from squeezefilm.reynolds import node_cache
from squeezefilm.reynolds.device import Device, choose_device
from squeezefilm.reynolds.dynamics.response import (
    METHODS,
    MOST_MODULATION,
    Gains,
    gains,
    not_slow,
    response,
    steps_of,
)
from squeezefilm.reynolds.dynamics.scenes import refused
from squeezefilm.reynolds.dynamics.slow_gain import slow_gain
from squeezefilm.reynolds.effects.automatic import decided
from squeezefilm.studies.solver_settings import SolverSettings, solver_settings
from squeezefilm.studies.study import scene_of

FREQUENCIES = "10Hz,30Hz,100Hz,300Hz,1000Hz"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("scenes", nargs="?", metavar="SCENES.csv", help="table of scenes")
    parser.add_argument("--config", metavar="CONFIG.yaml", help=which_study.HELP)
    parser.add_argument("--output", metavar="RESPONSE.csv", help="table to write, a row per scene")
    parser.add_argument(
        "--gains", metavar="GAINS.csv", help="table to write, a row per scene and frequency"
    )
    parser.add_argument(
        "--steps",
        metavar="STEPS.csv",
        help="table to write of the mean force after start and stop, a row per scene and time",
    )
    parser.add_argument(
        "--frequencies",
        default=FREQUENCIES,
        metavar="QUANTITY",
        help=f"of the modulation: several with commas, or first:last:count; {FREQUENCIES}",
    )
    parser.add_argument("--method", choices=METHODS, default="auto", help="of gain and phase")
    parser.add_argument(
        "--device", help="instead of SQUEEZEFILM_DEVICE and the config's solver.device"
    )
    add_point_options(parser, many=False)


def run(options: argparse.Namespace) -> None:
    config = which_study.study_at(options.config)
    settings = solver_settings(config, outputs=())
    points = points_in(options)
    frequency_hz = np.array(quantities(options.frequencies, option="--frequencies", unit="Hz"))
    with node_cache.one_build_at_a_time():
        device = choose_device(config["solver"]["device"], option=options.device)
    if options.scenes is None:
        if len(points) != 1 or not {"h0_m", "hv_m"} <= set(points):
            raise InputError("give a table of scenes, or one scene by --h0 and --hv")
        scene = scene_of(scene_points_of(points)[0], config)
        _show(scene, gains(scene, frequency_hz, device=device, method=options.method))
        (chosen,) = decided(
            [scene], model_tolerance=config["solver"]["model_tolerance"], device=device
        )
        if lacking := [each for each in ("inertia", "heat") if _included(chosen, each)]:
            print(
                f"note: {' and '.join(lacking)} would be in this force (gas: auto): "
                + _slow_gains(chosen, settings, device)
                + "; how much they change the rest of the response is not known"
            )
        return
    if len(points.columns):
        raise InputError("give either a table of scenes or --h0 and --hv, not both")
    if options.output is options.gains is options.steps is None:
        raise InputError("a table of scenes needs --output, --gains or --steps")
    table = read_scenes(options.scenes)
    with naming(options.scenes):
        scenes = [scene_of(point, config) for point in scene_points(table)]
    if options.output is not None:
        write_table(_summaries(table, scenes), options.output)
    if options.gains is not None:
        rows = _all_gains(table, scenes, frequency_hz, device=device, method=options.method)
        write_table(rows, options.gains)
    if options.steps is not None:
        write_table(_all_steps(table, scenes), options.steps)


def _slow_gains(included: Scene, settings: SolverSettings, device: Device) -> str:
    """What terms do to the gain of slow modulation, in words."""
    without = replace(included, gas=replace(included.gas, inertia="none", heat="none"))
    try:
        gain, other = (
            slow_gain(scene, tolerance=settings.tolerance, method=settings.method, device=device)
            for scene in (included, without)
        )
    except RunError as error:
        return f"their part in the gain for slow modulation is not known ({error})"
    return f"with them the gain for slow modulation is {gain} instead of {other}"


def _included(scene: Scene, term: str) -> bool:
    return getattr(scene.gas, term) == "included"


def _show(scene: Scene, found: Gains) -> None:
    one = response(scene)
    if isfinite(one.rise_s):
        # The phase in which a vibration starts moved the rise by up to 1.6 periods.
        start_s = 2 / scene.actuator.frequency_hz
        corner_hz = float(f"{one.corner_hz:.2g}")
        print(
            f"gain {one.static_gain:.3f} ± {100 * one.error:.2g} % for slow modulation, about "
            f"{one.prompt_gain:.2f} far above the corner at about {corner_hz:g} Hz"
        )
        for what, share, seconds in (
            ("start", one.prompt_share, one.rise_s),
            ("stop", one.lasting_share, one.release_s),
        ):
            print(
                f"{what}: {share:.0%} of the force {'at once' if what == 'start' else 'is left'}, "
                f"settled to 5 % after {1e3 * seconds:.2g} ms ± {1e3 * start_s:.1g} ms"
            )
    else:
        print("rise, release and corner: not known, the film is not slow against its vibration")
    rows = pd.DataFrame(asdict(found)).drop(columns="method")
    print(rows.to_string(index=False, float_format=lambda value: f"{value:.4g}"))
    print(f"by {found.method}; error is relative; without inertia and heat of the gas")


def _summaries(table: pd.DataFrame, scenes: list[Scene]) -> pd.DataFrame:
    rows = []
    with progress_bar(len(scenes), unit="scene", name="response") as bar:
        for scene in scenes:
            found = {} if (reason := refused(scene)) else asdict(response(scene))
            if found and not isfinite(found["static_gain"]):
                reason = not_slow(found["error"])
            rows.append({**found, "status": reason or "ok"})
            bar.update(1)
    return pd.concat([table, pd.DataFrame(rows)], axis=1)


def _all_gains(
    table: pd.DataFrame,
    scenes: list[Scene],
    frequency_hz: np.ndarray,
    *,
    device: Device,
    method: str,
) -> pd.DataFrame:
    parts = []
    for row, scene in zip(table.to_dict(orient="records"), scenes, strict=True):
        slow = frequency_hz <= MOST_MODULATION * scene.actuator.frequency_hz
        for some in (frequency_hz[slow], frequency_hz[~slow]):
            if not some.size:
                continue
            try:
                found = asdict(gains(scene, some, device=device, method=method))
                status = "ok"
            except InputError as error:
                unknown = dict.fromkeys(("gain", "phase_deg", "error"), np.nan)
                found = {"frequency_hz": some, **unknown, "method": ""}
                status = _reason(error, scene)
            parts.append(pd.DataFrame(row | found | {"status": status}))
    return pd.concat(parts, ignore_index=True)


def _all_steps(table: pd.DataFrame, scenes: list[Scene]) -> pd.DataFrame:
    """A scene whose steps are not known keeps a row, with the reason."""
    parts = []
    for row, scene in zip(table.to_dict(orient="records"), scenes, strict=True):
        try:
            found = {**asdict(steps_of(scene)), "status": "ok"}
        except InputError as error:
            unknown = {name: [np.nan] for name in ("time_s", "rising_n", "falling_n")}
            found = {**unknown, "status": _reason(error, scene)}
        parts.append(pd.DataFrame(row | found))
    return pd.concat(parts, ignore_index=True)


def _reason(error: InputError, scene: Scene) -> str:
    return str(error).removeprefix(f"point {scene.point_id}: ")
