"""The budget of a force: each effect against a yardstick, a limit, or the solver with it in."""

from __future__ import annotations

from dataclasses import replace
from math import isnan

import numpy as np
import pytest
from films import PISTON, film
from periodic_strip import PeriodicStrip

from squeezefilm.film.profiles import Formula
from squeezefilm.film.scene import Scene
from squeezefilm.film.surfaces import Disc
from squeezefilm.quantities import first_order
from squeezefilm.quantities import model_error as budget_module
from squeezefilm.quantities.adjoint import Fields
from squeezefilm.quantities.model_error import (
    NAMES,
    ErrorBudget,
    edge_loss_remainder,
    error_budgets,
)
from squeezefilm.reynolds import solve
from squeezefilm.reynolds.device import choose_device
from squeezefilm.reynolds.grid import Grid
from squeezefilm.reynolds.periodic.launch import solve_batch
from squeezefilm.reynolds.problems import problems_of


def slipping(scene: Scene, rarefaction: str = "slip") -> Scene:
    return replace(scene, gas=replace(scene.gas, rarefaction=rarefaction))


@pytest.mark.parametrize(
    ("uneven", "epsilon", "sigma"),
    [(0.0, 0.1, 20.0), (1.098, 0.5, 200.0), (1.8, 0.5, 200.0), (0.0, 0.8, 2000.0)],
)
def test_the_rim_misses_less_than_is_said(uneven: float, epsilon: float, sigma: float) -> None:
    """On a strip whose rim has its loss at every order, up to 0.4 of the force.

    Beneath 1.098 it moves half as much as the middle, beneath 1.8 hardly.
    """
    strip = PeriodicStrip(
        epsilon,
        sigma,
        lambda x: np.sinc(uneven * (x - 0.5)),
        instants=33 if epsilon > 0.6 else 21,
    )
    without, small = strip.mean_overpressure(), 1e-6
    per_loss = (1 - strip.mean_overpressure(small) / without) / small
    for share in (0.02, 0.1, 0.4):
        loss = share / per_loss
        missed = 1 - (1 - strip.mean_overpressure(loss) / without) / share
        assert 0.05 < missed / edge_loss_remainder(24 * sigma * loss, epsilon) < 1


def test_the_rims_first_order_is_that_of_a_strip() -> None:
    """Of two long pads, what the longer one has more: that of a strip without ends."""
    forces, changes = [], []
    for aspect in (4.0, 8.0):
        scene = film(epsilon=0.5, sigma=200.0, profile=PISTON, aspect=aspect)
        ((force,), (found,)) = solve([scene], tolerance=1e-6), error_budgets([scene])
        forces.append(force.force_n)
        changes.append(force.force_n * found.effects["edge_loss"].percent / 100)
    small = 1e-2
    loss = small * scene.modified_reynolds / (24 * scene.sigma)
    strip = PeriodicStrip(0.5, 200.0, np.ones_like)
    without, having = strip.mean_overpressure(), strip.mean_overpressure(loss)
    (share,) = np.diff(changes) / np.diff(forces)
    assert share == pytest.approx((having / without - 1) / small, rel=0.02)


@pytest.mark.parametrize(("name", "having"), [("inertia", "included"), ("slip", "fukui-kaneko")])
def test_the_band_holds_the_force_with_the_effect_in_it(name: str, having: str) -> None:
    """Of films of Re 0.09 to 3, most of them far from the middle of their band."""
    random = np.random.default_rng(20261123)
    scenes = [
        film(
            epsilon=random.uniform(0.05, 0.85),
            sigma=np.exp(random.uniform(np.log(300), np.log(1e4))),
            knudsen=random.uniform(0.002, 0.06),
        )
        for _ in range(30)
    ]
    key = "inertia" if name == "inertia" else "rarefaction"
    with_it = [replace(scene, gas=replace(scene.gas, **{key: having})) for scene in scenes]
    without, full = (solve(some, tolerance=1e-4) for some in (scenes, with_it))
    others = dict.fromkeys(NAMES, budget_module.NONE)
    for budget, force, changed in zip(error_budgets(scenes), without, full, strict=True):
        alone = ErrorBudget(others | {name: budget.effects[name]})
        least, most = alone.sums(neglected_only=True)
        change = 100 * (changed.force_n / force.force_n - 1)
        assert least < change < most


def test_slip_is_the_difference_of_two_forces_for_a_dense_gas() -> None:
    """Its ratio to first order goes to one linearly, by what the budget says is missed."""
    for knudsen in (3e-2, 3e-3, 3e-4):
        scene = film(epsilon=0.4, sigma=583.0, knudsen=knudsen)
        without, having = (
            each.force_n for each in solve([scene, slipping(scene, "fukui-kaneko")], tolerance=1e-9)
        )
        true = 100 * (having / without - 1)
        (found,) = error_budgets([scene])
        missed = abs(found.effects["slip"].percent - true)
        assert missed <= found.effects["slip"].remainder_percent + 0.005 * abs(true)
        assert missed >= 0.5 * found.effects["slip"].remainder_percent - 0.005 * abs(true)
        (included,) = error_budgets([slipping(scene, "fukui-kaneko")])
        assert included.effects["slip"].included
        assert included.effects["flow_factor"].percent == found.effects["flow_factor"].percent == 0
        assert not found.effects["slip"].included


def test_what_first_order_slip_lacks_is_the_difference_to_the_flow_factor() -> None:
    """Fukui and Kaneko's factor is 1.1466 times slip where the gas is dense."""
    scene = slipping(film(epsilon=0.4, sigma=583.0, knudsen=3e-4))
    slip, factor = solve([scene, slipping(scene, "fukui-kaneko")], tolerance=1e-9)
    (found,) = error_budgets([scene])
    true = 100 * (factor.force_n / slip.force_n - 1)
    assert found.effects["slip"].included
    assert not found.effects["flow_factor"].included
    assert found.effects["flow_factor"].percent == pytest.approx(true, rel=0.02)
    assert found.effects["flow_factor"].percent == pytest.approx(
        0.1466 * found.effects["slip"].percent, rel=0.01
    )


def test_the_bearing_term_is_what_the_solver_puts_in() -> None:
    scene = film(epsilon=0.4, sigma=583.0, x=0.2, bearing=0.5)
    having, without = solve([scene, first_order.at_rest(scene)], tolerance=1e-8)
    (found,) = error_budgets([scene])
    assert found.effects["bearing"].included
    assert found.effects["bearing"].percent == pytest.approx(
        100 * (1 - without.force_n / having.force_n), rel=0.02
    )


@pytest.mark.parametrize(
    ("place", "odd", "even"), [(0.0, 0.0, 2.20646e-5), (0.25, -1.222163e-4, -1.19817e-5)]
)
def test_a_profile_that_passes_against_a_march_along_it(
    place: float, odd: float, even: float
) -> None:
    """A strip that its profile passes by 2e-3 per T, by the difference of two pads' forces.

    What both ways differ by and have in common, marched by BDF2 (test_budget.py at a1a68f24).
    """
    sigma, ridge = 100.0, Formula("sinc(109.8*x)", surface=Disc(1.0))
    found = []
    for aspect in (4.0, 8.0):
        scene = film(epsilon=0.3, sigma=sigma, x=place, aspect=aspect, profile=ridge)
        grid = Grid(nx=24, ny=40, nt=12, fold_x=False, fold_y=False)
        films = []
        for each in first_order.line(scene):
            problems = problems_of([each], grid)
            states = solve_batch([each], grid, tolerance=1e-9, device=choose_device())
            films.append(Fields(problems, grid, states.overpressure))
        orders = first_order.by_passing(films, np.array([-1e-3 * sigma]))
        found.append(aspect * np.array(orders)[:, 0])
    first, second = (found[1] - found[0]) / 4
    assert first == pytest.approx(odd, rel=0.05, abs=1e-12)
    assert second == pytest.approx(even, rel=0.05)


def test_what_is_not_known_has_no_number(scene: Scene) -> None:
    at_rest = replace(scene, hv_m=0.0)
    adiabatic = replace(scene, gas=replace(scene.gas, polytropic_exponent=1.4))
    still, heated = error_budgets([at_rest, adiabatic])
    assert still.status != "ok"
    assert all(isnan(each.percent) for each in still.effects.values())
    assert isnan(heated.effects["thermal"].percent)
    assert np.isnan(heated.sums(neglected_only=True)).all()
