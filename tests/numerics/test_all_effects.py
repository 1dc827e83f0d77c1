"""Modelling errors hold what all neglected effects, solved for together, change of a force."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from films import PISTON, at_reynolds, film, solved, with_pad

from squeezefilm.film.pad import Pad
from squeezefilm.film.profiles import BesselMode
from squeezefilm.film.scene import Actuator, Film, Gas, Scene
from squeezefilm.film.surfaces import Disc
from squeezefilm.quantities.edge_effects import JOINT_LAWS, SEPARATE_LAWS, edge_effect_changes
from squeezefilm.quantities.model_error import (
    AUTO_TERM_TOLERANCE,
    error_budgets,
    resolve_auto_terms,
)
from squeezefilm.reynolds.device import choose_device
from squeezefilm.reynolds.solver import solve
from squeezefilm_workflow.verification.all_effects import Effects, force_on_grid, forces_on_grid
from squeezefilm_workflow.verification.modelling_errors import (
    included_effects_text,
    interval_bounds_percent,
    random_scene,
)

# The command is in the file.
STORED = pd.read_csv(Path(__file__).parent / "data" / "all_effects.csv", comment="#")


@pytest.mark.parametrize("seed", STORED["seed"])
def test_a_modelling_error_holds_all_effects_together(seed: int) -> None:
    (row,) = STORED[STORED["seed"] == seed].itertuples()
    (scene,) = resolve_auto_terms([random_scene(seed)])
    assert included_effects_text(scene) == row.included_effects
    (budget,) = error_budgets([scene])
    lower, upper = interval_bounds_percent(budget)
    assert lower - row.solved_error_percent <= row.solved_lower_percent
    assert row.solved_upper_percent <= upper + row.solved_error_percent


@pytest.mark.parametrize(
    ("aspect", "shape", "x"),
    [(0.7, "rectangle", 0.1), (1.4, "rectangle", 0.0), (0.7, "ellipse", 0.1)],
)
def test_the_solver_has_the_forces_of_an_independent_program(aspect, shape, x):
    terms = {"inertia": "included", "thermal": "included", "rarefaction": "slip"}
    scene = at_reynolds(film(epsilon=0.4, sigma=60.0, x=x, aspect=aspect, **terms), 3.0)
    scene = with_pad(scene, shape=shape)
    (solution,) = solve([scene], tolerance=1e-4)
    force_n = force_on_grid(scene, Effects(slip="first-order"), points=20, instants=17)
    assert solution.force_n == pytest.approx(force_n, rel=2e-4)


def edge_changes(
    scene: Scene, laws: Sequence[tuple[float, float, float]], *, tolerance: float
) -> np.ndarray:
    """A force's changes by laws of the edge, and their errors."""
    states = [solved(scene, tolerance=tolerance, keep_states=True)]
    return edge_effect_changes([scene], states, laws=laws, device=choose_device())[..., 0]


@pytest.mark.parametrize("shape", ["rectangle", "ellipse"])
def test_a_small_edge_loss_is_that_of_first_order(shape):
    scene = at_reynolds(film(epsilon=0.4, sigma=60.0, profile=PISTON, aspect=0.7), 0.02)
    scene = with_pad(scene, shape=shape)
    plain = Effects(inertia=False, thermal=False, slip="none")
    both = [plain, replace(plain, edge_loss_coefficient=1.0)]
    without_n, having_n = forces_on_grid(scene, both, points=24, instants=17)
    changes, _ = edge_changes(scene, SEPARATE_LAWS, tolerance=1e-3)
    assert changes[0] == pytest.approx(having_n / without_n - 1, rel=0.02)


def test_the_edge_loss_of_a_film_that_newton_follows_in_shorter_steps_alone():
    """A disc with a node at its rim: from no loss to the whole one Newton's method diverges."""
    terms = {"inertia": "included", "thermal": "included", "rarefaction": "slip"}
    scene = random_scene(31).with_gas(**terms)
    changes, errors = edge_changes(scene, SEPARATE_LAWS, tolerance=1e-3)
    both = [Effects(slip="first-order", edge_loss_coefficient=each) for each in (0.0, 1.0)]
    without_n, having_n = forces_on_grid(scene, both, points=64, instants=21)
    assert changes[0] == pytest.approx(having_n / without_n - 1, abs=errors[0])


@pytest.mark.parametrize("inertia", ["none", "included"])
@pytest.mark.parametrize("shape", ["rectangle", "ellipse"])
def test_flow_around_the_edge_is_that_of_an_independent_program(shape, inertia):
    """Alone, and together with the edge loss."""
    scene = at_reynolds(film(epsilon=0.5, sigma=200.0, profile=PISTON, inertia=inertia), 2.0)
    scene = with_pad(scene, shape=shape)
    plain = Effects(inertia=inertia == "included", thermal=False, slip="none")
    around = replace(plain, edge_flow=True)
    films = [plain, around, replace(around, edge_loss_coefficient=1.0)]
    without_n, around_n, both_n = forces_on_grid(scene, films, points=28, instants=21)
    (*_, alone), _ = edge_changes(scene, SEPARATE_LAWS, tolerance=1e-4)
    (together, _, *parts), errors = edge_changes(scene, JOINT_LAWS, tolerance=1e-4)
    error = errors.sum()
    assert alone == pytest.approx(around_n / without_n - 1, abs=error)
    assert sum(parts) == pytest.approx(alone, abs=error)
    assert together == pytest.approx(both_n / without_n - 1, abs=error)
    assert alone > 5 * error


def test_auto_neglects_no_effect_whose_parts_cancel():
    """A disc near whose rim a node circle of the vibration lies."""
    disc = Disc(3.05115e-3)
    mode = BesselMode(0, 1890.62, 0.0, 0.0, disc)
    vibration = Actuator(47852.2, disc.radius_m, profile=mode)
    gas = Gas(inertia="auto", thermal="included")
    pad = Pad(3.05115e-3, 3.05115e-3, 0.0, shape="ellipse")
    (scene,) = resolve_auto_terms([Film(gas, vibration, pad).scene(10e-6, 5e-6)])
    own = Effects(inertia=scene.gas.inertia == "included", slip="none")
    every = [own, replace(own, inertia=True)]
    force_n, with_inertia_n = forces_on_grid(scene, every, points=64, instants=21)
    assert force_n == pytest.approx(with_inertia_n, rel=AUTO_TERM_TOLERANCE)
