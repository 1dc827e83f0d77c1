"""The budget of a force: each effect against a strip, a limit, or the solver with it in."""

from __future__ import annotations

from contextlib import nullcontext
from dataclasses import replace
from math import isnan, nan
from unittest.mock import Mock

import numpy as np
import pytest
from films import PISTON, at_reynolds, film, with_pad
from periodic_strip import PeriodicStrip

from squeezefilm.film.scene import Scene
from squeezefilm.lazy import cl
from squeezefilm.quantities import model_error, states
from squeezefilm.quantities.edge_effects import SEPARATE_LAWS, edge_effect_changes
from squeezefilm.quantities.model_error import (
    EFFECT_NAMES,
    Effect,
    ErrorBudget,
    budget_row,
    error_budgets,
)
from squeezefilm.reynolds import device as devices
from squeezefilm.reynolds import solve
from squeezefilm.reynolds.device import choose_device
from squeezefilm.reynolds.periodic import like_films


@pytest.mark.parametrize(("epsilon", "sigma", "reynolds"), [(0.5, 200.0, 1.0), (0.8, 60.0, 4.0)])
def test_the_edge_loss_is_that_of_a_strip_at_every_order(
    epsilon: float, sigma: float, reynolds: float
) -> None:
    """Of two long pads, what the longer one has more: that of a strip without ends.

    The strip has the loss in its equation for the whole state, by other collocation.
    """
    lossless, losses = [], []
    for aspect in (4.0, 8.0):
        scene = film(epsilon=epsilon, sigma=sigma, profile=PISTON, aspect=aspect)
        scene = at_reynolds(scene, reynolds)
        (solution,) = solve([scene], tolerance=1e-4, method="periodic", keep_states=True)
        changes, _ = edge_effect_changes(
            [scene], [solution], laws=SEPARATE_LAWS, device=choose_device()
        )
        lossless.append(solution.force_n)
        losses.append(solution.force_n * changes[:2, 0])
    strip = PeriodicStrip(epsilon, sigma, np.ones_like, instant_count=33)
    without = strip.mean_overpressure()
    for coefficient, change in zip((1.0, 1.54), np.diff(losses, axis=0)[0], strict=True):
        loss = coefficient * scene.modified_reynolds / (24 * scene.sigma)
        of_strip = strip.mean_overpressure(loss) / without - 1
        assert change / np.diff(lossless)[0] == pytest.approx(of_strip, rel=5e-3)
        assert abs(of_strip) > 0.005


@pytest.mark.parametrize("part", [slice(None), 1])
def test_an_edge_loss_of_which_one_end_or_error_is_unknown_is_unknown(
    scene: Scene, monkeypatch: pytest.MonkeyPatch, part: slice | int
) -> None:
    """The iteration of one coefficient may not settle, or on the finer grid alone."""

    def changes_without_one(*args, laws, **options):
        changes = edge_effect_changes(*args, laws=laws, **options)
        if laws == SEPARATE_LAWS:
            changes[part, 1] = nan
        return changes

    (budget,) = error_budgets([scene])
    assert "edge_loss" not in budget.unknown_effect_names
    monkeypatch.setattr(model_error.edge_effects, "edge_effect_changes", changes_without_one)
    (budget,) = error_budgets([scene])
    assert "edge_loss" in budget.unknown_effect_names


@pytest.mark.filterwarnings("error")
def test_an_edge_pressure_below_vacuum_is_no_warning() -> None:
    """Of a polytropic film whose iteration oversteps: it settles on the finer grid alone."""
    scene = film(epsilon=0.9, sigma=44.9, profile=PISTON, aspect=0.3)
    scene = at_reynolds(scene, 11.3).with_gas(inertia="none", polytropic_exponent=1.3)
    (budget,) = error_budgets([scene])
    assert {"edge_loss", "edge_flow"} <= {*budget.unknown_effect_names}


def test_the_known_effects_contain_the_edge_loss_of_either_coefficient() -> None:
    effects = dict.fromkeys(EFFECT_NAMES, Effect(0.0, 0.0))
    effects |= {"thermal": Effect(nan), "slip": Effect(-1.0, 0.1), "edge_loss": Effect(-8.0, 0.2)}
    budget = ErrorBudget(effects, edge_loss_upper_percent=-12.0)
    assert budget.known_error_percent == pytest.approx(13.3)


def test_effects_together_are_one_solve_more(scene: Scene) -> None:
    """Inertia, slip and thermal effects interact: the total is no sum of the rows."""
    scene = scene.with_gas(inertia="none", thermal="none", rarefaction="none")
    scene = replace(scene, h0_m=2 * scene.h0_m)
    every = {"inertia": "included", "thermal": "included"}
    own, both = solve([scene, scene.with_gas(**every)], tolerance=1e-6)
    (budget,) = error_budgets([scene])
    inertia, thermal = budget.effects["inertia"], budget.effects["thermal"]
    together = 100 * (both.force_n / own.force_n - 1)
    assert abs(together - inertia.percent - thermal.percent) > 0.05
    (with_both,) = error_budgets([scene.with_gas(**every)])
    # The rows of included effects are about the film that has them.
    alone = {name: with_both.effects[name].percent * both.force_n / own.force_n for name in every}
    assert alone["inertia"] + thermal.percent == pytest.approx(together, abs=0.02)
    assert alone["thermal"] + inertia.percent == pytest.approx(together, abs=0.02)
    assert with_both.effects["inertia"].included
    assert "inertia" not in with_both.neglected_effects


def test_effects_hold_their_errors_on_few_points(scene: Scene) -> None:
    """Of a film whose layers at the edge are thin, beside forces good to a hundredth of these."""
    dense = scene.with_gas(density_kg_per_m3=3 * scene.gas.density_kg_per_m3)
    viscous = dense.with_gas(inertia="none", thermal="none")
    terms = {"inertia": "included", "thermal": "included"}
    films = [viscous, *(viscous.with_gas(**{name: having}) for name, having in terms.items())]
    without_n, *having_n = (each.force_n for each in solve(films, tolerance=1e-7))
    (budget,) = error_budgets([viscous])
    for name, force_n in zip(terms, having_n, strict=True):
        true_percent = 100 * (force_n / without_n - 1)
        effect = budget.effects[name]
        assert abs(effect.percent - true_percent) <= effect.error_percent
        assert effect.error_percent < 0.1 * abs(true_percent)
    assert budget.numerical_error_percent < 0.05


@pytest.mark.parametrize("every", ["none", "included"])
def test_a_force_with_its_budget_waits_for_one_program(scene: Scene, every: str) -> None:
    """With neglected effects, and with none: each takes seconds to compile."""
    device = choose_device()
    unused = replace(device, queue=cl.CommandQueue(device.context))
    built = devices._cached_program.cache_info().misses
    scene = scene.with_gas(inertia=every, thermal=every)
    solve([scene], tolerance=1e-3, method="periodic", device=unused)
    (found,) = error_budgets([scene], device=unused)
    assert not found.unknown_effect_names
    assert devices._cached_program.cache_info().misses - built == 1


def test_a_force_with_its_budget_takes_few_launches(
    scene: Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Each costs the host two milliseconds, ten times what the device takes for a film."""
    launch = Mock(side_effect=like_films.launch)
    solve_batch = Mock(side_effect=states.solve_batch)
    monkeypatch.setattr(like_films, "launch", launch)
    monkeypatch.setattr(states, "solve_batch", solve_batch)
    (found,) = error_budgets([scene])
    assert not found.unknown_effect_names
    assert 0 < launch.call_count + solve_batch.call_count <= 15


def test_no_finer_grids_are_solved_on_where_an_effect_stays_unknown(
    scene: Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Far outside the limits of validity these took a minute, for a total that is unknown."""
    solve_films = Mock(side_effect=like_films.films_on_grids_of)
    monkeypatch.setattr(model_error, "films_on_grids_of", solve_films)
    (found,) = error_budgets([replace(scene, h0_m=36e-6, hv_m=2e-6)])
    assert found.unknown_effect_names
    assert [call.kwargs["grid_count"] for call in solve_films.call_args_list] == [2]


def test_slip_with_the_flow_factor_is_the_difference_of_two_forces() -> None:
    for knudsen in (3e-2, 3e-3, 3e-4):
        scene = film(epsilon=0.4, sigma=583.0, knudsen=knudsen)
        without, having = (
            each.force_n
            for each in solve([scene, scene.with_gas(rarefaction="fukui-kaneko")], tolerance=1e-9)
        )
        true = 100 * (having / without - 1)
        (found,) = error_budgets([scene])
        slip, factor = found.effects["slip"], found.effects["flow_factor"]
        assert slip.percent + factor.percent == pytest.approx(true, abs=4e-3)
        # First-order slip with the flow of a gap at rest leaves little.
        assert abs(factor.percent) < 0.05 * abs(slip.percent) + factor.error_percent
        (included,) = error_budgets([scene.with_gas(rarefaction="fukui-kaneko")])
        assert included.effects["slip"].included
        assert included.effects["flow_factor"].percent == 0
        assert not slip.included


def test_what_first_order_slip_lacks_is_the_difference_to_the_flow_factor() -> None:
    """Fukui and Kaneko's factor is 1.1466 times slip where the gas is dense."""
    scene = film(epsilon=0.4, sigma=583.0, knudsen=3e-3, rarefaction="slip")
    (found,) = error_budgets([scene])
    slip, factor = found.effects["slip"], found.effects["flow_factor"]
    assert slip.included
    assert not factor.included
    assert factor.percent == pytest.approx(0.1466 * slip.percent, rel=0.05)


def test_an_effect_beside_the_flow_factor_holds_its_part_of_a_slipping_film() -> None:
    """Inertia is solved with first-order slip there, and its change over that force counts too."""
    scene = film(epsilon=0.3, sigma=1000.0, knudsen=2e-2, rarefaction="fukui-kaneko")
    (budget,) = error_budgets([scene])
    inertia = budget.effects["inertia"]
    before, after = (
        each.force_n
        for each in solve(
            [
                scene.with_gas(rarefaction="slip"),
                scene.with_gas(rarefaction="slip", inertia="included"),
            ],
            tolerance=1e-7,
        )
    )
    part = 100 * (after / before - 1)
    assert abs(inertia.percent - part) > 1e-3 * abs(part)
    assert abs(inertia.percent - part) < inertia.error_percent < 0.2 * abs(part)


def test_the_bearing_term_is_what_the_solver_puts_in() -> None:
    scene = film(epsilon=0.4, sigma=583.0, x=0.2, bearing=0.5)
    at_rest = with_pad(scene, speed_x_m_per_s=0.0)
    having, without = solve([scene, at_rest], tolerance=1e-8)
    (found,) = error_budgets([scene])
    assert found.effects["bearing"].included
    true = 100 * (1 - without.force_n / having.force_n)
    bearing = found.effects["bearing"]
    assert abs(bearing.percent - true) <= bearing.error_percent


def test_what_is_not_known_has_no_number(scene: Scene) -> None:
    at_rest = replace(scene, hv_m=0.0)
    adiabatic = scene.with_gas(polytropic_exponent=1.4)
    still, heated = error_budgets([at_rest, adiabatic])
    assert still.status != "ok"
    assert all(isnan(each.percent) for each in still.effects.values())
    assert heated.unknown_effect_names == ["thermal"]
    assert np.isnan(heated.modelling_error_percent).all()


def test_a_total_that_is_unknown_has_a_reason() -> None:
    """Each effect alone is known here, all of them together are not."""
    known = dict.fromkeys(EFFECT_NAMES, Effect(1.0, 0.0))
    assert ErrorBudget(known, 1.5, (0.8, 1.2)).unknown_effect_names == []
    assert budget_row(ErrorBudget(known, 1.5))["unknown_effects"] == "all effects together"
    without_inertia = ErrorBudget(known | {"inertia": Effect(float("nan"))}, 1.5)
    assert without_inertia.unknown_effect_names == ["inertia"]


@pytest.mark.parametrize(("error", "raised"), [(AttributeError, True), (MemoryError, False)])
def test_a_fault_of_the_code_is_no_unknown_effect(
    scene: Scene, monkeypatch: pytest.MonkeyPatch, error: type[Exception], raised: bool
) -> None:
    monkeypatch.setattr(like_films, "_films_of_batch", Mock(side_effect=error))
    with pytest.raises(error) if raised else nullcontext():
        (found,) = error_budgets([scene])
        assert found.status != "ok" or found.unknown_effect_names
