"""Derivatives of the force: those of forces simulated anew, with errors that hold, or a reason."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from films import PISTON, at_reynolds, film, with_pad
from random_scenes import random_films, shares

from squeezefilm.cli.main import main
from squeezefilm.film.pad import GapShape
from squeezefilm.film.profiles import QuadratureProfile, Sinc, StandingWave
from squeezefilm.film.scene import Scene
from squeezefilm.quantities import derivatives as module
from squeezefilm.quantities.derivatives import scene_with_quantity_changed, with_derivatives
from squeezefilm.reynolds import solve
from squeezefilm.solution import Derivatives
from squeezefilm.table_writer import write_table
from squeezefilm.tables import read_forces
from squeezefilm_workflow.verification.random_films import random_film


def derivatives(scene: Scene, *, tolerance: float) -> Derivatives:
    (solution,) = with_derivatives(
        [scene], solve([scene], tolerance=tolerance), tolerance=tolerance
    )
    assert solution.derivatives is not None
    return solution.derivatives


def changed(scene: Scene, number: str, by: float) -> Scene:
    """As ``module.moved`` does, along the actuator's axes."""
    if hasattr(scene, number):
        return replace(scene, **{number: getattr(scene, number) + by})
    return scene.with_gas(**{number: getattr(scene.gas, number) + by})


def step_of(scene: Scene, number: str) -> float:
    unit = {"h0_m": scene.h0_m, "hv_m": scene.h0_m, "x_m": 0.01, "y_m": 0.01}
    return 2e-3 * unit.get(number, getattr(scene.gas, number, 0.0))


def rounded(scene: Scene, number: str) -> float:
    """What 1e-9 of each force makes of the quotient."""
    (solution,) = solve([scene], tolerance=1e-3)
    return 1.5e-9 * solution.force_n / step_of(scene, number)


def quotient(scene: Scene, number: str) -> float:
    """Of forces simulated anew, of fourth order."""
    step = step_of(scene, number)
    with_number_changed = [changed(scene, number, k * step) for k in (-2, -1, 1, 2)]
    a, b, c, d = (
        each.force_n for each in solve(with_number_changed, tolerance=1e-9, method="periodic")
    )
    return (a - 8 * b + 8 * c - d) / (12 * step)


def under_ellipse(scene: Scene) -> Scene:
    return with_pad(scene, shape="ellipse")


WAVE = StandingWave(wavelength_m=0.02, direction_deg=0.0, crest_m=0.001)
OTHER = StandingWave(wavelength_m=0.014, direction_deg=60.0, crest_m=0.004)
TWO_PHASES = film(
    epsilon=0.3,
    sigma=300.0,
    x=0.1,
    y=0.05,
    profile=QuadratureProfile(WAVE, OTHER, component_factors=(0.7, 0.7)),
)
FILMS = {
    "off the centre": film(epsilon=0.44, sigma=2331.0, x=0.2, y=0.1),
    "thick": film(epsilon=0.5, sigma=0.5, profile=PISTON),
    "slip, small motion": film(epsilon=0.02, sigma=300.0, x=0.2, rarefaction="slip"),
    "fukui-kaneko, polytropic": film(
        epsilon=0.4, sigma=583.0, y=0.1, rarefaction="fukui-kaneko", polytropic_exponent=1.4
    ),
    "sliding": film(epsilon=0.4, sigma=300.0, x=0.1, bearing=3.0, aspect=1.5),
    "sliding ellipse": under_ellipse(
        film(epsilon=0.4, sigma=300.0, x=0.1, bearing=3.0, aspect=1.5)
    ),
    "disc": under_ellipse(film(epsilon=0.4, sigma=300.0, y=0.2, rarefaction="slip")),
    "tilted, two phases": replace(
        TWO_PHASES, pad=replace(TWO_PHASES.pad, gap=GapShape(2e-6, -1e-6, 0.5e-6))
    ),
}


@pytest.mark.parametrize("name", FILMS)
def test_derivatives_are_quotients_of_forces_simulated_anew(name: str) -> None:
    scene = FILMS[name]
    found = derivatives(scene, tolerance=1e-5)
    assert found.status == "ok"
    for number, value in found.value.items():
        expected = quotient(scene, number)
        assert abs(value - expected) <= found.error[number] + rounded(scene, number), number
        assert value == pytest.approx(expected, rel=2e-3, abs=rounded(scene, number)), number


def test_places_are_along_the_actuator_s_axes_however_the_pad_is_turned() -> None:
    plain = FILMS["off the centre"]
    turned = with_pad(plain, length_y_m=0.006, rotation_deg=30.0)
    found = derivatives(turned, tolerance=1e-5)
    for number in ("x_m", "y_m"):
        assert found.value[number] == pytest.approx(quotient(turned, number), rel=1e-3)


def test_the_static_stiffness_of_a_piston_film_is_that_of_a_gas_that_cannot_escape() -> None:
    """F = p0 A (√((1 + 3ε²/2)/(1 − ε²)) − 1) at large σ (Langlois 1962), ε = hv/h0."""
    epsilon = 0.3
    scene = film(epsilon=epsilon, sigma=1e6, profile=PISTON)
    found = derivatives(scene, tolerance=1e-3)
    square = (1 + 1.5 * epsilon**2) / (1 - epsilon**2)
    slope = -2.5 * epsilon**2 / (1 - epsilon**2) ** 2 / np.sqrt(square) / scene.h0_m
    # What the rim's layers add is of order σ^(−1/2).
    assert found.value["h0_m"] == pytest.approx(scene.force_scale_n * slope, rel=5e-3)


def test_numbers_that_the_equation_does_not_have_change_nothing() -> None:
    found = derivatives(film(epsilon=0.3, sigma=100.0), tolerance=1e-4)
    absent = ("density_kg_per_m3", "mean_free_path_m", "prandtl", "heat_capacity_ratio")
    for number in (*absent, "viscosity_exponent"):
        assert (found.value[number], found.error[number]) == (0.0, 0.0)
    at_the_centre = [found.value[number] for number in ("x_m", "y_m")]
    assert at_the_centre == [0.0, 0.0]


@pytest.mark.parametrize("tolerance", [1e-2, 1e-3])
def test_errors_hold(tolerance: float) -> None:
    """Beside derivatives a hundred times as good, of films of all kinds drawn at random."""
    scenes = random_films(6, seed=3)
    solutions = solve(scenes, tolerance=tolerance)
    some, closer = (
        [each.derivatives for each in with_derivatives(scenes, solutions, tolerance=t)]
        for t in (tolerance, 1e-2 * tolerance)
    )
    assert {each.status for each in (*some, *closer) if each} == {"ok"}
    found = [share for each in shares(some, closer).values() for share in each]
    assert len(found) > 30
    assert max(found) <= 1


def test_derivatives_to_the_place_over_a_spot_that_grids_do_not_resolve() -> None:
    """Two grids agree by chance on a wrong one."""
    film_of_spot = random_film(0, seed=77)
    assert film_of_spot.group == "ellipse"
    some, closer = (derivatives(film_of_spot.scene, tolerance=each) for each in (1e-2, 1e-4))
    assert max(shares([some], [closer])["x_m"]) < 1
    assert abs(some.value["x_m"] - closer.value["x_m"]) > 0.5 * abs(closer.value["x_m"])


def test_a_derivative_that_agrees_by_chance_has_the_error_of_others(monkeypatch) -> None:
    """Of a film whose stiffness changes less from grid to grid than it is off."""
    scene = random_film(33, seed=77).scene
    ratios = []
    closer = derivatives(scene, tolerance=3e-4)
    for fraction in (module.MIN_GRID_CHANGE_FRACTION, 0.0):
        monkeypatch.setattr(module, "MIN_GRID_CHANGE_FRACTION", fraction)
        ratios.append(max(shares([derivatives(scene, tolerance=1e-2)], [closer])["h0_m"]))
    assert ratios[0] < 1 < ratios[1]


def test_a_gas_with_inertia_and_thermal_effects_has_derivatives() -> None:
    """Against quotients of forces solved anew, for each number that such a gas has."""
    terms = {"inertia": "included", "thermal": "included", "rarefaction": "slip"}
    scene = film(epsilon=0.3, sigma=300.0, **terms)
    found = derivatives(scene, tolerance=1e-6)
    assert found.status == "ok"
    for name in ("h0_m", "hv_m", "density_kg_per_m3", "prandtl", "viscosity_exponent"):
        unit = scene.h0_m if name.endswith("_m") else getattr(scene.gas, name)
        beside = [scene_with_quantity_changed(scene, name, sign * 2e-3 * unit) for sign in (1, -1)]
        ahead, behind = (each.force_n for each in solve(beside, tolerance=1e-6))
        quotient = (ahead - behind) / (4e-3 * unit)
        assert abs(found.value[name] - quotient) <= found.error[name] + 2e-3 * abs(quotient)
    # Another exponent would stand for thermal effects, which this gas has.
    assert np.isnan(found.value["polytropic_exponent"])


@pytest.mark.parametrize("reynolds", [1.0, 3.0])
def test_derivatives_with_thermal_effects_are_those_of_a_tight_tolerance(reynolds: float) -> None:
    """A film beside another is a short step away, which one linear system does not take whole."""
    scene = film(epsilon=0.13, sigma=100.0, profile=PISTON, inertia="included", thermal="included")
    heavy = with_pad(at_reynolds(scene, reynolds), shape="ellipse")
    some, closer = (derivatives(heavy, tolerance=tolerance) for tolerance in (1e-3, 1e-6))
    for number, ratios in shares([some], [closer]).items():
        assert max(ratios) < 0.3, number


@pytest.mark.parametrize(
    ("guard", "value"), [("DIFFERENCE_STEP", 3e-4), ("DIFFERENCE_STEP_ERROR", 0.0)]
)
def test_step_of_a_difference_is_in_the_error(guard: str, value: float, monkeypatch) -> None:
    """Of a film that all but touches, at a tight tolerance; with another guard it is not."""
    scene = film(epsilon=0.9, sigma=5.0, profile=PISTON)
    scene = with_pad(scene, shape="ellipse")
    how = {"tolerance": 1e-7}
    solutions = solve([scene], tolerance=1e-7, method="periodic", keep_states=True)

    def value_and_error() -> tuple[float, float]:
        (solution,) = with_derivatives([scene], solutions, **how)
        return solution.derivatives.value["h0_m"], solution.derivatives.error["h0_m"]

    value_of_film, error = value_and_error()
    with monkeypatch.context() as patched:
        patched.setattr(module, guard, value)
        value_without, error_without = value_and_error()
    monkeypatch.setattr(module, "DIFFERENCE_STEP", 3e-6)
    right, _ = value_and_error()
    assert abs(value_of_film - right) <= error
    assert abs(value_without - right) > error_without


def test_what_has_no_derivatives_says_why() -> None:
    scene = film(epsilon=0.4, sigma=100.0, profile=Sinc(wave_number_per_m=1e6))
    found = derivatives(scene, tolerance=1e-3)
    assert "no force" in found.status
    assert np.isnan([*found.value.values(), *found.error.values()]).all()


def test_a_table_of_forces_takes_them_and_stages_that_need_none_read_it(
    tmp_path: Path, edited, refused
) -> None:
    plan, output = tmp_path / "plan.csv", tmp_path / "forces.csv"
    rows = {"h0_m": 5e-6, "hv_m": [2e-6, 1e-6], "phi_r_m": [0.0, 2e-3], "phi_deg": 0.0}
    write_table(pd.DataFrame({"point_id": ["1", "2"], **rows}), plan)
    command = ["simulate", str(plan), "--tolerance=1e-4", f"--output={output}", "--derivatives"]
    assert main(command) == 0
    table, forces = pd.read_csv(output), read_forces(output)
    assert list(table)[len(forces.columns) :] == list(Derivatives(status="").columns())
    assert (table["dforce_dh0_n_per_m"] < 0).all()
    assert main([*command, "--config", str(edited("paper", gas={"inertia": "included"}))]) == 0
    with_inertia = pd.read_csv(output)
    assert (with_inertia["derivatives_status"] == "ok").all()
    assert (with_inertia["dforce_ddensity_n_m3_per_kg"] > 0).all()
