"""How the mean force follows a changing amplitude: gain and phase, rise and release.

  squeezefilm response --h0 5um --hv 2.2um [--frequencies 10Hz,100Hz,300Hz]
  squeezefilm response SCENES.csv --config CONFIG.yaml --output RESPONSE.csv [--gains GAINS.csv]
  squeezefilm response SCENES.csv --config CONFIG.yaml --steps STEPS.csv

The gain is the relative change of the force per relative change of the amplitude: twice a little
for slow modulation. Part of the force follows at once, the rest with the gas that comes and goes
through the rim: `prompt_gain` is what is left of the gain above the corner, `corner_hz`; the film
passes modulation at any frequency, with another size. `rise_s` is until the force stays within 5 %
after the surface starts, `release_s` until 5 % is left after it stops, each to about two periods.

By the film equation averaged over a period of the vibration, without inertia and heat of the gas;
films whose averaged settled force is more than 3 % off are not supported. What the averaged
equation neglects is stated as a change in %: first-order slip by the same equation with slip,
inertia and heat by the periodic forces' gain for slow modulation (their effect on corner and
settling times is not known). `validity` is `ok`, or the limits of validity that a scene
exceeds under this equation.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from dataclasses import asdict, replace
from functools import partial
from math import isnan
from typing import Any

import numpy as np
import pandas as pd

from squeezefilm.cli import which_study
from squeezefilm.cli.options import add_point_options, points_in
from squeezefilm.config.loading import Config
from squeezefilm.dynamics.response import (
    CHANGED,
    MOST_MODULATION,
    NEGLECTED,
    Gains,
    gain_changes,
    gains,
    response,
    slip_changes,
    steps_of,
)
from squeezefilm.errors import InputError, RunError, naming
from squeezefilm.film.scene import Scene
from squeezefilm.film.validity import validity
from squeezefilm.parallel import progress_bar
from squeezefilm.reynolds import node_cache
from squeezefilm.reynolds.device import Device, choose_device
from squeezefilm.studies.solver_settings import SolverSettings, solver_settings
from squeezefilm.studies.study import scenes_in
from squeezefilm.tables import read_scenes, write_table
from squeezefilm.units import quantities

CALLED = {
    "gain": "gain for slow modulation",
    "corner": "corner",
    "rise": "settling after start",
    "release": "after stop",
}
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
    parser.add_argument(
        "--device", help="instead of SQUEEZEFILM_DEVICE and the config's solver.device"
    )
    add_point_options(parser, many=False)


def run(options: argparse.Namespace) -> None:
    config = which_study.film_at(options.config)
    settings = solver_settings(config, outputs=())
    points = points_in(options)
    frequency_hz = np.array(quantities(options.frequencies, option="--frequencies", unit="Hz"))
    with node_cache.one_build_at_a_time():
        device = choose_device(config["solver"]["device"], option=options.device)
    if options.scenes is None:
        if len(points) != 1 or not {"h0_m", "hv_m"} <= set(points):
            raise InputError("give a table of scenes, or one scene by --h0 and --hv")
        scene = scenes_in(points, config)[0]
        _show(scene, gains(scene, frequency_hz), _neglected([scene], settings, device)[0])
        print(f"validity  {_validity(scene)}")
        return
    if len(points.columns):
        raise InputError("give either a table of scenes or --h0 and --hv, not both")
    if options.output is options.gains is options.steps is None:
        raise InputError("a table of scenes needs --output, --gains or --steps")
    table, scenes = table_and_scenes(options.scenes, config)
    if options.output is not None:
        write_table(summaries(table, scenes, settings, device), options.output)
    if options.gains is not None:
        write_table(all_gains(table, scenes, frequency_hz), options.gains)
    if options.steps is not None:
        write_table(_all_steps(table, scenes), options.steps)


def table_and_scenes(path: str, config: Config) -> tuple[pd.DataFrame, Sequence[Scene]]:
    """A table of scenes with their validity, and the scenes."""
    table = read_scenes(path)
    with naming(path):
        scenes = scenes_in(table, config)
    return table.assign(validity=list(map(_validity, scenes))), scenes


def _neglected(
    scenes: Sequence[Scene], settings: SolverSettings, device: Device
) -> list[dict[str, float]]:
    """Changes in % of the scenes' responses by what the averaged film neglects, by columns."""
    by_gas = gain_changes(scenes, tolerance=settings.tolerance, device=device)
    return [slip_changes(scene) | row for scene, row in zip(scenes, by_gas, strict=True)]


def _validity(scene: Scene) -> str:
    """That of the response's equation, which has neither inertia nor heat."""
    return validity(replace(scene, gas=replace(scene.gas, inertia="none", heat="none")))


def _show(scene: Scene, found: Gains, neglected: dict[str, float]) -> None:
    one = response(scene)
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
    print(pd.DataFrame(asdict(found)).to_string(index=False, float_format="{:.4g}".format))
    print("error: relative to the gain, without effects that the averaged film neglects:")
    for line in _neglected_lines(scene, neglected):
        print(f"  {line}")


def _neglected_lines(scene: Scene, changes: dict[str, float]) -> list[str]:
    """A line for each effect that the averaged film neglects."""
    by_slip = {what: changes[f"slip_{what}_percent"] for what in CHANGED}
    if scene.gas.rarefaction == "slip":
        slip = "slip: included"
    elif isnan(by_slip["gain"]):
        slip = f"slip: not known, Kn {scene.knudsen:.2g} is above the range of first-order slip"
    else:
        slip = "slip: " + ", ".join(
            f"{CALLED[what]} {change:+.2g} %" for what, change in by_slip.items()
        )
    lines = [slip]
    for name in NEGLECTED:
        change, error = (changes[f"{name}_gain{end}_percent"] for end in ("", "_error"))
        gain = "not known" if isnan(change) else f"{change:+.2g} ± {error:.1g} %"
        lines.append(f"{name}: gain for slow modulation {gain}, corner and settling not known")
    return lines


def summaries(
    table: pd.DataFrame, scenes: Sequence[Scene], settings: SolverSettings, device: Device
) -> pd.DataFrame:
    """The table with the response of each scene, or the reason why there is none."""
    rows: list[dict[Any, Any]] = []
    with progress_bar(len(scenes), unit="scene", name="response") as bar:
        for scene in scenes:
            rows.append(_or_reason(partial(response, scene)))
            bar.update(1)
    known = [k for k, row in enumerate(rows) if row["status"] == "ok"]
    neglected = _neglected([scenes[k] for k in known], settings, device)
    for k, changes in zip(known, neglected, strict=True):
        rows[k] |= changes
    return pd.concat([table, pd.DataFrame(rows)], axis=1)


def _or_reason(find: Callable[[], Any], **unknown: Any) -> dict[Any, Any]:
    """What is found, with status ``ok``; or what is unknown, with the reason as its status."""
    try:
        return {**asdict(find()), "status": "ok"}
    except (InputError, RunError) as error:
        return {**unknown, "status": str(error)}


def all_gains(
    table: pd.DataFrame, scenes: Sequence[Scene], frequency_hz: np.ndarray
) -> pd.DataFrame:
    """The table with a row for each scene and frequency: gain and phase."""
    parts = []
    for row, scene in zip(table.to_dict(orient="records"), scenes, strict=True):
        slow = frequency_hz <= MOST_MODULATION * scene.actuator.frequency_hz
        for some in (frequency_hz[slow], frequency_hz[~slow]):
            if some.size:
                unknown = dict.fromkeys(("gain", "phase_deg", "error"), np.nan)
                found = _or_reason(
                    partial(gains, scene, some),
                    frequency_hz=some,
                    **unknown,
                )
                parts.append(pd.DataFrame(row | found))
    return pd.concat(parts, ignore_index=True)


def _all_steps(table: pd.DataFrame, scenes: Sequence[Scene]) -> pd.DataFrame:
    """A scene whose steps are not known keeps a row, with the reason."""
    unknown = {name: [np.nan] for name in ("time_s", "rising_n", "falling_n")}
    return pd.concat(
        [
            pd.DataFrame(row | _or_reason(partial(steps_of, scene), **unknown))
            for row, scene in zip(table.to_dict(orient="records"), scenes, strict=True)
        ],
        ignore_index=True,
    )
