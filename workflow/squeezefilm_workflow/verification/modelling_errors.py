"""Modelling errors of random films, compared with films that have all effects."""

import argparse
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from math import pi, sqrt
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from squeezefilm.cli.options import command, flag_option, option
from squeezefilm.errors import RunError
from squeezefilm.film.pad import Pad, PadShape
from squeezefilm.film.profiles import BesselMode, Piston, Profile, Sinc, StandingWave
from squeezefilm.film.scene import Actuator, Film, Gas, Scene
from squeezefilm.film.surfaces import Disc
from squeezefilm.film.validity import validity_text
from squeezefilm.quantities.edge_effects import EDGE_LOSS_COEFFICIENTS
from squeezefilm.quantities.model_error import (
    AUTO_TERM_TOLERANCE,
    ErrorBudget,
    error_budgets,
    resolve_auto_terms,
    unsupported_auto_term_texts,
)
from squeezefilm.solution import MODELLING_ERROR_COLUMNS
from squeezefilm.table_writer import write_table
from squeezefilm_workflow.verification.all_effects import (
    Effects,
    forces_on_grid,
    grid_sizes_of_scene,
    is_axisymmetric,
)
from squeezefilm_workflow.verification.films import waves_steepen
from squeezefilm_workflow.verification.random_films import log_uniform

# Ranges of Re, σ, ε, h0 in m and, of a sliding pad, its speed in m/s.
REYNOLDS_RANGE, SIGMA_RANGE, EPSILON_RANGE = (0.1, 10.0), (5.0, 2500.0), (0.1, 0.6)
H0_RANGE_M, SPEED_RANGE_M_PER_S = (4e-6, 25e-6), (0.02, 0.5)
ASPECT_RANGE, MAX_OFF_CENTRE_FRACTION = (0.6, 1.6), 0.25
SLIDING_PROBABILITY, OFF_CENTRE_PROBABILITY = 0.1, 0.3
SLIP_PROBABILITY, NO_EFFECTS_PROBABILITY = 0.2, 0.15
"""Probabilities: pad slides; is off the centre; gas slips; has neither inertia nor heat."""
SHAPE_PROBABILITIES = {"disc": 0.4, "ellipse": 0.25, "rectangle": 0.35}
PROFILE_PROBABILITIES = {"sinc": 0.35, "bessel": 0.3, "standing-wave": 0.25, "piston": 0.1}
# Where a node lies: over the distance of the edge from the centre along x.
NODE_DISTANCE_RANGES = {"edge": (0.9, 1.1), "within": (0.35, 0.9), "outside": (1.1, 4.0)}
FIRST_BESSEL_J0_ZERO = 2.404825557695773
# Range of Re of the films of which `auto` neglects some effects.
SMALL_REYNOLDS_RANGE = (0.01, 2.0)
# Rows of a budget that the film with all effects does not answer.
EFFECTS_NOT_COMPARED = ("depth_averaged", "sheared_gas", "moving_profile", "ram_pressure")


@command(
    option("--output", "TABLE.csv", "table to write", required=True),
    option("--films", "N", "default 60", type=int, default=60),
    option("--seed", help="of the first film; default 1", type=int, default=1),
    flag_option(
        "--discs", "of these the discs above a gap of the radius alone, which take a second each"
    ),
)
def modelling_errors(options: argparse.Namespace) -> None:
    """Modelling errors of random films, compared with films that have all effects.

      squeezefilm-verification modelling-errors --output TABLE.csv --films 60 [--seed 1] [--discs]

    A film of air is drawn from each seed: pad, vibration, Re, squeeze number, excursion ratio. It
    is solved with the terms that `auto` includes and with inertia, thermal effects, slip, edge loss
    and flow around the edge together, by an independent program. The change of the force, for both
    ends of the edge loss' coefficient, is to lie within the modelling error less its parts of depth
    averaging, of a pad's sliding and of what the factors of flow around the edge may be off. The
    exit status is 1 where it does not.
    """
    seeds = range(options.seed, options.seed + options.films)
    chosen = [seed for seed in seeds if not options.discs or is_axisymmetric(random_scene(seed))]
    outside = write_films_table(modelling_error_row, chosen, output=Path(options.output))
    if outside:
        raise RunError(f"modelling errors of films {outside} do not hold")


@command(
    option("--output", "TABLE.csv", "table to write", required=True),
    option("--films", "N", "default 200", type=int, default=200),
    option("--seed", help="of the first film; default 1", type=int, default=1),
)
def auto_terms(options: argparse.Namespace) -> None:
    """Effects that `auto` neglects in random films, solved for by an independent program.

      squeezefilm-verification auto-terms --output TABLE.csv --films 200 [--seed 1]

    Films are drawn as for `modelling-errors`, with smaller Re, inertia and thermal effects `auto`.
    The force with the terms that `auto` includes is to differ from that with both by at most the
    model tolerance. The exit status is 1 where it differs more.
    """
    seeds = range(options.seed, options.seed + options.films)
    outside = write_films_table(auto_terms_row, seeds, output=Path(options.output))
    if outside:
        raise RunError(f"`auto` neglects too much in films {outside}")


def write_films_table(
    row_of: Callable[[int], dict[str, Any]], seeds: Iterable[int], *, output: Path
) -> str:
    """Write a table film by film, print how many have each outcome, and name those outside."""
    rows = []
    for seed in seeds:
        rows.append(row_of(seed))
        write_table(pd.DataFrame(rows), output)
    table = pd.DataFrame(rows, columns=None if rows else ["seed", "outcome"])
    print(table["outcome"].value_counts().to_string())
    return ", ".join(map(str, table.loc[table["outcome"] == "outside", "seed"]))


def auto_terms_row(seed: int) -> dict[str, Any]:
    """Return the effects that `auto` includes in a seed's film and what the others change."""
    film = random_scene(seed, reynolds=SMALL_REYNOLDS_RANGE).with_gas(
        inertia="auto", thermal="auto"
    )
    (scene,) = resolve_auto_terms([film])
    row = _film_row(seed, film.point_id, scene)
    if unsupported_auto_term_texts(film):
        return row | {"outcome": "not supported"}
    own = Effects.of_scene(scene)
    both = replace(own, inertia=True, thermal=True)
    if both == own:
        return row | {"neglected_by_auto_percent": 0.0, "outcome": "nothing neglected"}
    try:
        ((change, error),) = force_changes_percent(scene, [both])
    except ArithmeticError as reason:
        return row | {"outcome": f"not compared: {reason}"}
    row |= {"neglected_by_auto_percent": change, "solved_error_percent": error}
    tolerance_percent = 100 * AUTO_TERM_TOLERANCE
    if error > 0.05 * tolerance_percent:
        return row | {"outcome": "not compared: grids differ"}
    return row | {"outcome": "inside" if abs(change) <= tolerance_percent + error else "outside"}


def modelling_error_row(seed: int) -> dict[str, Any]:
    """Return the modelling error of a seed's film and what all effects change of its force."""
    drawn = random_scene(seed)
    (scene,) = resolve_auto_terms([drawn])
    (budget,) = error_budgets([scene])
    lower, upper = interval_bounds_percent(budget)
    row = _film_row(seed, drawn.point_id, scene)
    row |= zip(MODELLING_ERROR_COLUMNS, (lower, upper), strict=True)
    effects = [
        Effects(edge_loss_coefficient=coefficient, edge_flow=True)
        for coefficient in EDGE_LOSS_COEFFICIENTS
    ]
    try:
        all_effects = force_changes_percent(scene, effects)
    except ArithmeticError as reason:
        return row | {"outcome": f"not compared: {reason}"}
    (least, least_error), (most, most_error) = sorted(all_effects)
    row |= {"solved_lower_percent": least, "solved_upper_percent": most}
    row["solved_error_percent"] = error = max(least_error, most_error)
    if np.isnan(lower + upper):
        return row | {"outcome": "not known"}
    if error > 0.05 * max(abs(least), abs(most), 0.02):
        return row | {"outcome": "not compared: grids differ"}
    inside = lower - error <= least and most <= upper + error
    return row | {"outcome": "inside" if inside else "outside"}


def _film_row(seed: int, film: str, scene: Scene) -> dict[str, Any]:
    return {
        "seed": seed,
        "film": film,
        "modified_reynolds": scene.modified_reynolds,
        "sigma": scene.sigma,
        "epsilon": scene.epsilon,
        "included_effects": included_effects_text(scene),
    }


def included_effects_text(scene: Scene) -> str:
    """Return the names of the effects that a scene is solved with."""
    gas = scene.gas
    included = {
        "inertia": gas.inertia == "included",
        "thermal": gas.thermal == "included",
        "slip": gas.rarefaction != "none",
    }
    return "; ".join(name for name, has in included.items() if has) or "none"


def interval_bounds_percent(budget: ErrorBudget) -> tuple[float, float]:
    """Return the ends of the neglected effects that are compared."""
    around_percent = budget.effects["edge_flow"].error_percent
    lower, upper = budget.modelling_error_percent
    lower, upper = lower + around_percent, upper - around_percent
    for name in EFFECTS_NOT_COMPARED:
        percent, error_percent, _ = budget.effects[name]
        lower, upper = lower - percent + error_percent, upper - percent - error_percent
    return lower, upper


def force_changes_percent(scene: Scene, effects: Sequence[Effects]) -> list[tuple[float, float]]:
    """Return changes of a scene's force in % by some sets of effects, and their errors."""
    every = [Effects.of_scene(scene), *effects]
    changes = []
    for points, instants in grid_sizes_of_scene(scene):
        forces_n = forces_on_grid(scene, every, points=points, instants=instants)
        changes.append(100 * (np.array(forces_n[1:]) / forces_n[0] - 1))
    return list(zip(changes[0].tolist(), abs(changes[0] - changes[1]).tolist(), strict=True))


def random_scene(seed: int, *, reynolds: tuple[float, float] = REYNOLDS_RANGE) -> Scene:
    """Return the film of a seed, within the limits of validity."""
    random = np.random.default_rng(seed)
    while True:
        scene = _draw_scene(random, reynolds)
        term = "included" if scene.gas.inertia == "auto" else "none"
        if (
            not waves_steepen(scene)
            and validity_text(scene.with_gas(inertia=term, thermal=term)) == "ok"
        ):
            return scene


def _draw_scene(random: np.random.Generator, limits: tuple[float, float]) -> Scene:
    reynolds, sigma, h0_m = (
        log_uniform(random, ends) for ends in (limits, SIGMA_RANGE, H0_RANGE_M)
    )
    gas = Gas(inertia="auto", thermal="auto")
    if random.uniform() < NO_EFFECTS_PROBABILITY:
        gas = replace(gas, inertia="none", thermal="none")
    if random.uniform() < SLIP_PROBABILITY:
        gas = replace(gas, rarefaction="slip")
    omega = reynolds * gas.viscosity_pa_s / (gas.density_kg_per_m3 * h0_m**2)
    pressure_height = gas.ambient_pressure_pa * h0_m**2
    length_m = sqrt(sigma * pressure_height / (12 * gas.viscosity_pa_s * omega))
    shape = str(random.choice(list(SHAPE_PROBABILITIES), p=list(SHAPE_PROBABILITIES.values())))
    aspect = 1.0 if shape == "disc" else log_uniform(random, ASPECT_RANGE)
    sliding = shape != "disc" and random.uniform() < SLIDING_PROBABILITY
    speed_m_per_s = log_uniform(random, SPEED_RANGE_M_PER_S) if sliding else 0.0
    kind = str(random.choice(list(PROFILE_PROBABILITIES), p=list(PROFILE_PROBABILITIES.values())))
    node = str(random.choice(list(NODE_DISTANCE_RANGES)))
    node_m = length_m / 2 * random.uniform(*NODE_DISTANCE_RANGES[node])
    off_m = (
        random.uniform(0, MAX_OFF_CENTRE_FRACTION)
        * length_m
        * (random.uniform() < OFF_CENTRE_PROBABILITY)
    )
    outline: PadShape = "rectangle" if shape == "rectangle" else "ellipse"
    film = Film(
        gas,
        Actuator(
            frequency_hz=omega / (2 * pi),
            surface_radius_m=2 * length_m,
            profile=_profile_with_node(kind, node_m, 2 * length_m),
        ),
        Pad(length_m, aspect * length_m, speed_m_per_s, shape=outline),
    )
    words = (shape, kind, *((f"node {node}",) if kind != "piston" else ()))
    words += ("sliding",) * sliding + ("off centre",) * (off_m > 0)
    epsilon = random.uniform(*EPSILON_RANGE)
    return film.scene(h0_m, epsilon * h0_m, off_m, off_m / 2, point_id=", ".join(words))


def _profile_with_node(kind: str, node_m: float, surface_radius_m: float) -> Profile:
    """Return a vibration with a node, that nearest to the centre, at a distance from the centre."""
    match kind:
        case "sinc":
            return Sinc(wave_number_per_m=1 / node_m)
        case "bessel":
            return BesselMode(0, FIRST_BESSEL_J0_ZERO / node_m, 0.0, 0.0, Disc(surface_radius_m))
        case "standing-wave":
            return StandingWave(4 * node_m, 0.0, crest_m=0.0)
    return Piston()
