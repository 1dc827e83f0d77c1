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
from math import isnan

import numpy as np

from squeezefilm.api.simulation import scenes_of_table
from squeezefilm.cli.options import add_options, add_point_options, film_at, points_in
from squeezefilm.dynamics.response import (
    CHANGED,
    NEGLECTED,
    all_gains,
    all_steps,
    gains,
    neglected,
    response,
    responses,
)
from squeezefilm.errors import InputError
from squeezefilm.film.scene import Scene
from squeezefilm.film.validity import validity
from squeezefilm.reynolds.device import one_build_at_a_time
from squeezefilm.studies.solver_settings import device_of, solver_settings
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
    add_options(parser, "config", "device")
    add_point_options(parser, many=False)


def run(options: argparse.Namespace) -> None:
    film = film_at(options.config)
    points = points_in(options)
    frequency_hz = np.array(quantities(options.frequencies, option="--frequencies", unit="Hz"))
    with one_build_at_a_time():
        device = device_of(film.config, option=options.device)
    tolerance = solver_settings(film.config, outputs=()).tolerance
    if options.scenes is None:
        if len(points) != 1 or not {"h0_m", "hv_m"} <= set(points):
            raise InputError("give a table of scenes, or one scene by --h0 and --hv")
        (scene,) = film.scenes(points)
        _show(scene, frequency_hz)
        (changes,) = neglected([scene], tolerance=tolerance, device=device)
        what = "error: relative to the gain, without effects that the averaged film neglects:"
        print(what, *_neglected_lines(scene, changes), sep="\n  ")
        print(f"validity  {validity(scene.viscous())}")
        return
    if len(points.columns):
        raise InputError("give either a table of scenes or --h0 and --hv, not both")
    if options.output is options.gains is options.steps is None:
        raise InputError("a table of scenes needs --output, --gains or --steps")
    table = read_scenes(options.scenes)
    scenes = scenes_of_table(table, config=film.config, path=options.scenes)
    if options.output is not None:
        found = responses(table, scenes, tolerance=tolerance, device=device)
        write_table(found, options.output)
    if options.gains is not None:
        write_table(all_gains(table, scenes, frequency_hz), options.gains)
    if options.steps is not None:
        write_table(all_steps(table, scenes), options.steps)


def _show(scene: Scene, frequency_hz: np.ndarray) -> None:
    found = gains(scene, frequency_hz)
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
    print(found.to_string(index=False, float_format="{:.4g}".format))


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
