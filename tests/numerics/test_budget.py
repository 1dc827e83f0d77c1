"""The budget of a force: each effect against a yardstick, a limit, or the solver with it in."""

from __future__ import annotations

from dataclasses import replace
from math import isnan
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from effects_yardstick import Numbers, effects
from films import PISTON, SINC, film
from numpy.linalg import solve as solve_linear
from periodic_strip import PeriodicStrip

from squeezefilm.cli.main import main
from squeezefilm.film.profiles import Profile
from squeezefilm.film.scene import Scene
from squeezefilm.quantities import adjoint as sensitivity_module
from squeezefilm.quantities import first_order
from squeezefilm.quantities import model_error as budget_module
from squeezefilm.quantities.adjoint import Fields, response, sensitivity
from squeezefilm.quantities.model_error import (
    BASIS,
    NAMES,
    Effect,
    ErrorBudget,
    budget_row,
    budget_text,
    error_budgets,
    rim_missed,
)
from squeezefilm.reynolds import Solution, solve
from squeezefilm.reynolds.device import choose_device
from squeezefilm.reynolds.grid import Grid
from squeezefilm.reynolds.periodic.launch import solve_batch
from squeezefilm.reynolds.periodic.states import State
from squeezefilm.reynolds.problems import problems_of
from squeezefilm.reynolds.spectral import axis
from squeezefilm.tables import write_table


def slipping(scene: Scene, rarefaction: str = "slip") -> Scene:
    return replace(scene, gas=replace(scene.gas, rarefaction=rarefaction))


def on_grid(scenes: list[Scene], grid: Grid) -> list[ErrorBudget]:
    """Budgets by a grid that is not theirs."""
    device = choose_device()
    found = solve_batch(scenes, grid, tolerance=1e-4, device=device).unknowns
    states = [
        Solution(status="ok", method="periodic", states=(State(grid, each),)) for each in found
    ]
    shares = budget_module._shares(scenes, states, device)
    return [
        budget_module._budget(scene, {name: 100 * share[k] for name, share in shares.items()})
        for k, scene in enumerate(scenes)
    ]


@pytest.mark.parametrize(
    ("epsilon", "sigma", "profile", "x", "y"),
    [(0.4, 2331.0, SINC, 0.0, 0.0), (0.3, 583.0, SINC, 0.2, 0.1), (0.5, 40.0, PISTON, 0.0, 0.0)],
)
def test_effects_are_those_of_the_yardstick(
    epsilon: float, sigma: float, profile: Profile, x: float, y: float
) -> None:
    scene = film(epsilon=epsilon, sigma=sigma, profile=profile, x=x, y=y)
    with_slip = film(epsilon=epsilon, sigma=sigma, profile=profile, x=x, y=y, knudsen=1e-9)
    numbers = Numbers(epsilon, sigma, scene.modified_reynolds, knudsen=scene.knudsen)
    expected = effects(numbers, scene.amplitude, points=32, instants=20)
    (found,) = error_budgets([scene])
    for name in ("inertia", "heat", "rim"):
        assert found.effects[name].percent == pytest.approx(expected[name], rel=0.02), name
    # The flow factor's first coefficient is 1.1466 times that of slip; without the others.
    (dilute,) = error_budgets([with_slip])
    share = 1.1466 * with_slip.knudsen / scene.knudsen
    assert dilute.effects["slip"].percent == pytest.approx(share * expected["slip"], rel=0.01)


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
        assert 0.05 < missed / rim_missed(24 * sigma * loss, epsilon) < 1


def test_the_rims_first_order_is_that_of_a_strip() -> None:
    """Of two long fingers, what the longer one has more: that of a strip without ends."""
    forces, changes = [], []
    for aspect in (4.0, 8.0):
        scene = film(epsilon=0.5, sigma=200.0, profile=PISTON, aspect=aspect)
        ((force,), (found,)) = solve([scene], tolerance=1e-6), error_budgets([scene])
        forces.append(force.force_n)
        changes.append(force.force_n * found.effects["rim"].percent / 100)
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


def test_a_rim_that_takes_too_much_for_a_first_order_says_so() -> None:
    (few,) = error_budgets([film(epsilon=0.6, sigma=1000.0)])
    assert few.effects["rim"].missed_percent < abs(few.effects["rim"].percent) / 2
    others = dict.fromkeys(NAMES, budget_module.NONE)
    thick = ErrorBudget(others | {"rim": Effect(-40.0, 24.0)})
    assert "above its range" in budget_text(thick)
    assert budget_row(thick)["above_range"] == "rim"


def test_the_whole_finger_gives_what_a_quarter_gives() -> None:
    scene = film(epsilon=0.4, sigma=583.0)
    by_fold = []
    for fold, points in ((True, 12), (False, 24)):
        grid = Grid(nx=points, ny=points, nt=12, fold_x=fold, fold_y=fold)
        (found,) = on_grid([scene], grid)
        by_fold.append([found.effects[name].percent for name in NAMES])
    assert by_fold[0] == pytest.approx(by_fold[1], rel=2e-3)


@pytest.mark.parametrize(("rarefaction", "exponent"), [("none", 1.0), ("fukui-kaneko", 1.4)])
def test_the_adjoint_answers_as_the_equation_itself(rarefaction: str, exponent: float) -> None:
    scene = film(
        epsilon=0.5,
        sigma=300.0,
        x=0.2,
        bearing=3.0,
        aspect=1.5,
        rarefaction=rarefaction,
        polytropic_exponent=exponent,
    )
    grid = Grid(nx=16, ny=16, nt=12, fold_x=False, fold_y=True)
    states = solve_batch([scene], grid, tolerance=1e-8, device=choose_device())
    films = Fields(problems_of([scene], grid, tolerance=1e-8), grid, states.overpressure)
    source = np.random.default_rng(1).normal(size=(1, *grid.shape))
    change = response(films, source, tolerance=1e-12)
    rise = films.on_all_nodes(change) / (films.gap * films.density_slope)
    sensitive = sensitivity(films, tolerance=1e-12)
    by_adjoint = films.mean(films.on_all_nodes(sensitive * source))
    assert by_adjoint == pytest.approx(films.mean(rise), rel=1e-8)


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
        assert missed <= found.effects["slip"].missed_percent + 0.005 * abs(true)
        assert missed >= 0.5 * found.effects["slip"].missed_percent - 0.005 * abs(true)
        (included,) = error_budgets([slipping(scene, "fukui-kaneko")])
        assert included.effects["slip"].included
        assert included.effects["kinetic"].percent == found.effects["kinetic"].percent == 0
        assert not found.effects["slip"].included


def test_what_first_order_slip_lacks_is_the_difference_to_the_flow_factor() -> None:
    """Fukui and Kaneko's factor is 1.1466 times slip where the gas is dense."""
    scene = slipping(film(epsilon=0.4, sigma=583.0, knudsen=3e-4))
    slip, factor = solve([scene, slipping(scene, "fukui-kaneko")], tolerance=1e-9)
    (found,) = error_budgets([scene])
    true = 100 * (factor.force_n / slip.force_n - 1)
    assert found.effects["slip"].included
    assert not found.effects["kinetic"].included
    assert found.effects["kinetic"].percent == pytest.approx(true, rel=0.02)
    assert found.effects["kinetic"].percent == pytest.approx(
        0.1466 * found.effects["slip"].percent, rel=0.01
    )


def test_sliding_either_way_is_the_same_at_the_middle_and_opposite_beside() -> None:
    for x, sign in ((0.0, 1.0), (0.2, -1.0)):
        to_and_fro = [film(epsilon=0.4, sigma=583.0, x=x, bearing=speed) for speed in (1e-2, -1e-2)]
        first, second = error_budgets(to_and_fro)
        for name in ("bearing", "passing"):
            to, fro = (each.effects[name].percent for each in (first, second))
            assert to == pytest.approx(sign * fro, rel=0.15), name
            assert abs(to) > 1e-6


def test_the_bearing_term_is_what_the_solver_puts_in() -> None:
    scene = film(epsilon=0.4, sigma=583.0, x=0.2, bearing=0.5)
    having, without = solve([scene, first_order.at_rest(scene)], tolerance=1e-8)
    (found,) = error_budgets([scene])
    assert found.effects["bearing"].included
    assert found.effects["bearing"].percent == pytest.approx(
        100 * (1 - without.force_n / having.force_n), rel=0.02
    )


class Ridge:
    """The paper's profile along x, the same all along y."""

    largest = 1.0
    is_complex = False

    def amplitude(self, *, x_m: np.ndarray, y_m: np.ndarray) -> np.ndarray:
        return np.asarray(np.sinc(109.8 * x_m) + 0 * y_m)


def marched_past(*, epsilon: float, sigma: float, place: float, rate: float) -> float:
    """Mean overpressure of a strip at ``place`` as it passes there, by ``rate`` per T.

    BDF2 and Newton, from ambient pressure; a mean of means over the period, thrice, which a signal
    that changes slowly beside its oscillation passes through but for its curvature.
    """
    periods, steps, line = 16, 128, axis(24, False)
    step, derivative, inner = 2 * np.pi / steps, line.derivative, slice(1, -1)
    pressure, x = np.ones(len(line.all_nodes)), line.all_nodes - 0.5
    begin = (3 * steps - 3) / 2 * step - 2 * np.pi * periods

    def gap_at(time: float) -> np.ndarray:
        s = np.sinc(1.098 * (x + place + rate * time))
        return np.asarray(1 + epsilon * s * np.sin(time))

    last = before = gap_at(begin)[inner]
    means = []
    for k in range(1, periods * steps + 1):
        gap = gap_at(begin + k * step)
        lead, tail = (1.0, last) if k == 1 else (1.5, 2 * last - before / 2)
        change = np.ones(1)
        while np.abs(change).max() > 1e-11:
            slope = derivative @ pressure
            left = (derivative @ (gap**3 * pressure * slope))[inner] - sigma / step * (
                lead * (gap * pressure)[inner] - tail
            )
            jacobian = derivative @ ((gap**3 * pressure)[:, None] * derivative)
            jacobian += derivative * (gap**3 * slope)
            square = jacobian[inner, inner] - np.diag(sigma / step * lead * gap[inner])
            change = -solve_linear(square, left)
            pressure[inner] += change
        before, last = last, (gap * pressure)[inner]
        means.append(line.weights @ (pressure[inner] - 1))
    box = np.ones(steps) / steps
    window = np.convolve(np.convolve(box, box), box)
    return float(window @ np.array(means)[-len(window) :])


@pytest.mark.parametrize("place", [0.0, 0.25])
def test_a_profile_that_passes_against_a_march_along_it(place: float) -> None:
    """On a strip, both orders, by the difference of two fingers of which one is longer."""
    epsilon, sigma, rate, apart = 0.3, 100.0, 2e-3, 0.02
    back, rest, forth = (
        marched_past(epsilon=epsilon, sigma=sigma, place=place, rate=each)
        for each in (-rate, 0.0, rate)
    )
    beside = [
        marched_past(epsilon=epsilon, sigma=sigma, place=place + each, rate=0.0)
        for each in (-apart, apart)
    ]
    bend = (beside[0] - 2 * rest + beside[1]) / apart**2
    curvature = bend * rate**2 / 2 * (2 * np.pi) ** 2 / 4  # of the window over a bent F(c)
    found = []
    for aspect in (4.0, 8.0):
        scene = film(epsilon=epsilon, sigma=sigma, x=place, aspect=aspect, profile=Ridge())
        grid = Grid(nx=24, ny=40, nt=12, fold_x=False, fold_y=False)
        films = []
        for each in first_order.line(scene):
            problems = problems_of([each], grid, tolerance=1e-9)
            states = solve_batch([each], grid, tolerance=1e-9, device=choose_device())
            films.append(Fields(problems, grid, states.overpressure))
        orders = first_order.by_passing(films, np.array([-rate * sigma / 2]))
        found.append(aspect * np.array(orders)[:, 0])
    first, second = (found[1] - found[0]) / 4
    assert first == pytest.approx((forth - back) / 2, rel=0.05, abs=1e-12)
    assert second == pytest.approx((forth + back) / 2 - rest - curvature, rel=0.05)


def test_what_is_not_known_has_no_number(scene: Scene) -> None:
    still = replace(scene, hv_m=0.0)
    adiabatic = replace(scene, gas=replace(scene.gas, polytropic_exponent=1.4))
    round_pad = replace(scene, finger=replace(scene.finger, shape="ellipse"))
    found = dict(
        zip(
            ("still", "adiabatic", "round", "flat"),
            error_budgets([still, adiabatic, round_pad, scene]),
            strict=True,
        )
    )
    assert found["still"].status != "ok"
    assert all(isnan(each.percent) for each in found["still"].effects.values())
    assert isnan(found["adiabatic"].effects["heat"].percent)
    assert isnan(found["adiabatic"].sums(neglected_only=True)[0])
    assert found["round"].basis == BASIS
    assert np.isnan(found["round"].sums(neglected_only=True)).all()
    assert found["round"].effects["inertia"] != found["flat"].effects["inertia"]
    for budget in found.values():
        assert BASIS in budget_text(budget) or not budget.basis


def test_a_scene_that_fails_does_not_touch_the_others(
    scene: Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    hard = film(epsilon=0.9, sigma=3.0)
    (alone,) = error_budgets([film(epsilon=0.4, sigma=583.0)])
    monkeypatch.setattr(sensitivity_module, "MOST_ITERATIONS", 12)
    grid = Grid(nx=8, ny=8, nt=12, fold_x=True, fold_y=True)
    easy = film(epsilon=0.1, sigma=583.0)
    first, second = on_grid([hard, easy], grid)
    assert "did not converge" in first.status
    assert second.status == "ok"
    assert second.effects["inertia"].percent == pytest.approx(
        alone.effects["inertia"].percent, rel=0.05
    )


def test_notes_name_what_is_large_and_what_is_above_its_range(scene: Scene) -> None:
    thin, thick, slow = error_budgets(
        [
            replace(scene, hv_m=2e-6),
            replace(scene, h0_m=20e-6, hv_m=2e-6),
            replace(slipping(scene), actuator=replace(scene.actuator, frequency_hz=1e3), hv_m=2e-6),
        ]
    )
    assert "inertia +2.1 %" in budget_text(thin)
    assert "slip -1.3 %" in budget_text(thin)
    assert "rim's entrance loss -0.32 to -0.5 %" in budget_text(thin)
    assert "inertia" in str(budget_row(thick)["above_range"])
    assert "what first-order slip lacks -" in budget_text(slow)  # as `simulate` shows it
    assert "slip" in budget_row(slow)["in_force"]  # type: ignore[operator]
    assert budget_row(thick)["above_range"] == "inertia; heat"


def test_the_command_writes_a_row_for_each_scene(
    tmp_path: Path, repository: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    columns = ("point_id", "h0_m", "hv_m", "phi_r_m", "phi_deg")
    rows = [("a", 5e-6, 2e-6, 0.0, 0.0), ("b", 5e-6, 0.0, 0.0, 0.0)]
    write_table(pd.DataFrame(rows, columns=columns), "scenes.csv")
    config = str(repository / "config" / "paper.yaml")
    assert main(["budget", "scenes.csv", "--config", config, "--output", "budget.csv"]) == 0
    table = pd.read_csv("budget.csv")
    assert list(table["point_id"]) == ["a", "b"]
    assert table["status"][0] == "ok"
    assert table["status"][1] != "ok"
    effects_of = table[[f"{name}_percent" for name in NAMES]]
    assert np.isfinite(effects_of.iloc[0]).all()
    assert effects_of.iloc[1].isna().all()
