"""A device proves itself: a handful of stored films, with every term, to 1e-9.

A driver that compiles a kernel wrongly gives wrong numbers that look right. The films are solved on
one small grid each, by the kernel that solves all others, and compared with self_test.csv, which
``python -m squeezefilm.reynolds.self_test`` rebuilds where the equation or the grid changes.
"""

import os
import signal
import subprocess
import sys
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

from squeezefilm.errors import InputError, RunError
from squeezefilm.files import write_text
from squeezefilm.film.pad import GapShape, Pad
from squeezefilm.film.profiles import QuadratureProfile, Sinc, StandingWave
from squeezefilm.film.scene import Actuator, Film, Gas, Scene
from squeezefilm.lazy import pd
from squeezefilm.reynolds.device import DEVICE_ENV_VARIABLE, Device, choose_device
from squeezefilm.reynolds.grid import Grid
from squeezefilm.reynolds.kernel_cache import kernel_cache_folder
from squeezefilm.reynolds.periodic.launch import grid_on_pad, solve_batch

STORED_FORCES_PATH = Path(__file__).with_name("self_test.csv")
FORCE_TOLERANCE = 1e-9
ITERATION_TOLERANCE = 1e-11
TEST_PROFILE = Sinc(wave_number_per_m=100.0)
TEST_PAD = Pad(1e-2, 1e-2, 0.0)
TEST_GAS = Gas(1.8e-5, 1e5, 1.2, 7e-8, inertia="none", thermal="none")


def test_cases() -> dict[str, tuple[Scene, Grid]]:
    """Films that have every term among them, and the points of their grids (``grid_on_pad``)."""
    whole = Grid(12, 12, 12, fold_x=False, fold_y=False)
    half = Grid(12, 8, 12, fold_x=False, fold_y=True)
    quarter = Grid(8, 8, 12, fold_x=True, fold_y=True)
    disc = replace(TEST_PAD, shape="ellipse")
    slender = Pad(1e-2, 6e-3, 20.0, shape="ellipse")
    return {
        "squeeze": (_test_scene(), quarter),
        "off the centre": (_test_scene(x_m=2e-3, y_m=1e-3), whole),
        "sliding": (_test_scene(pad=replace(TEST_PAD, speed_x_m_per_s=20.0)), half),
        "slip": (_test_scene(rarefaction="slip"), quarter),
        "fukui-kaneko, polytropic": (
            _test_scene(rarefaction="fukui-kaneko", polytropic_exponent=1.4),
            quarter,
        ),
        "inertia": (_test_scene(inertia="included"), quarter),
        "inertia and slip, off the centre": (
            _test_scene(inertia="included", rarefaction="slip", x_m=2e-3),
            half,
        ),
        "inertia, slip and thermal effects": (
            _test_scene(inertia="included", rarefaction="slip", thermal="included"),
            quarter,
        ),
        "any gap": (_with_nonuniform_gap(_test_scene(x_m=2e-3)), half),
        "any gap, wide and narrow": (
            _with_nonuniform_gap(_test_scene(hv_m=1.2e-6), tilt_x_m=6.4e-6),
            half,
        ),
        "any gap, inertia": (_with_nonuniform_gap(_test_scene(x_m=2e-3, inertia="included")), half),
        "ellipse, sliding": (_test_scene(pad=slender), half),
        "disc, any gap": (_with_nonuniform_gap(_test_scene(x_m=2e-3, pad=disc)), half),
        "disc, inertia and thermal effects": (
            _test_scene(pad=disc, inertia="included", thermal="included"),
            quarter,
        ),
        "disc off the centre, inertia and thermal effects": (
            _test_scene(pad=disc, x_m=2e-3, inertia="included", thermal="included"),
            half,
        ),
    }


def _with_nonuniform_gap(scene: Scene, *, tilt_x_m: float = 1e-6) -> Scene:
    """Tilted and crowned, over two modes of which one lags."""
    crests = StandingWave(wavelength_m=0.02, direction_deg=0.0, crest_m=0.0)
    modes = QuadratureProfile(TEST_PROFILE, crests, component_factors=(0.8, 0.6))
    gap = GapShape(tilt_x_m=tilt_x_m, crown_m=5e-7)
    return replace(
        scene, actuator=replace(scene.actuator, profile=modes), pad=replace(scene.pad, gap=gap)
    )


def _test_scene(
    *,
    hv_m: float = 2.4e-6,
    x_m: float = 0.0,
    y_m: float = 0.0,
    pad: Pad = TEST_PAD,
    **gas: str | float,
) -> Scene:
    film = Film(replace(TEST_GAS, **gas), Actuator(4e4, 1e-2, profile=TEST_PROFILE), pad)  # type: ignore[arg-type]
    return film.scene(6e-6, hv_m, x_m, y_m, point_id="self-test")


def forces_of_test_cases(device: Device) -> dict[str, float]:
    """The films' mean gauge pressures in units of p0, as the device finds them."""
    force_of_film = {}
    for name, (scene, points) in test_cases().items():
        grid = grid_on_pad(scene, points)
        how: dict[str, Any] = {"tolerance": ITERATION_TOLERANCE, "device": device}
        states = solve_batch([scene], grid, **how, many=True)
        force_of_film[name] = (
            float(states.mean_pressure_ratio[0]) if states.status_indices[0] == 0 else float("nan")
        )
    return force_of_film


def check_device(device: Device) -> None:
    """Reject a device that does not give the stored forces.

    Raises:
        InputError: naming the films that it gives otherwise, and by how much.
    """
    if wrong := _failed_cases_text(device):
        raise InputError(
            f"{device.name} fails its self-test: forces of stored films differ by more than "
            f"{FORCE_TOLERANCE:g}, relative ({wrong}). Its driver compiles the solver's kernel "
            "wrongly; "
            "take another device"
        )


FORCE_SCRIPT = """
from squeezefilm.reynolds import self_test, solve
from squeezefilm.reynolds.device import choose_device
device = choose_device()
self_test.forces_of_test_cases(device)
scene, _ = self_test.test_cases()["squeeze"]
solution = solve([scene], tolerance=1e-4, device=device)[0]
raise SystemExit(0 if solution.status == "ok" else solution.status)
"""


def check_force_in_new_process(option: str | None) -> None:
    """Solve films and a force in another process, as each command is one.

    Args:
        option: part of the wanted device's name, as in ``choose_device``.

    Raises:
        RunError: where the process does not end by itself, or gives no force.
    """
    named = {DEVICE_ENV_VARIABLE: option} if option else {}
    words = [sys.executable, "-c", FORCE_SCRIPT]
    environment = {**os.environ, **named}
    done = subprocess.run(
        words, env=environment, capture_output=True, text=True, errors="replace", check=False
    )
    if done.returncode < 0:
        raise RunError(
            f"the self-test was ended by {signal.Signals(-done.returncode).name}. A compiled "
            f"kernel may be damaged: remove {kernel_cache_folder()} and run the command again. "
            "If that does not help, the driver is at fault: take another device"
        )
    if done.returncode:
        last = done.stderr.strip().rpartition("\n")[2]
        raise RunError(f"the self-test gives no force: {last}")


@cache
def _failed_cases_text(device: Device) -> str:
    """The films that a device gives otherwise."""
    stored = pd.read_csv(STORED_FORCES_PATH, index_col="film")["mean_overpressure"]
    difference = (pd.Series(forces_of_test_cases(device))[stored.index] / stored - 1).abs()
    wrong = difference[~(difference <= FORCE_TOLERANCE)]
    return "; ".join(f"{name}: {value:.1e}" for name, value in wrong.items())


def main() -> None:
    """Write the table again."""
    table = pd.Series(forces_of_test_cases(choose_device()), name="mean_overpressure")
    write_text(table.to_csv(index_label="film", float_format="%.15g"), STORED_FORCES_PATH)


if __name__ == "__main__":
    main()
