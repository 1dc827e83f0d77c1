"""Rarefaction and heating: each term against an exact identity or limit."""

from dataclasses import replace

import numpy as np
import pytest
from films import PISTON, at_reynolds, film, mean_overpressure, periodic_state, spring_and_damping
from host_film import fields_of, residual
from scipy.optimize import brentq

from squeezefilm.film.scene import Scene, Scenes
from squeezefilm.quantities.model_error import error_budgets
from squeezefilm.reynolds import solve
from squeezefilm.reynolds.device import choose_device
from squeezefilm.reynolds.grid import Grid
from squeezefilm.reynolds.packing import equation_numbers_table
from squeezefilm.reynolds.periodic.launch import solve_batch
from squeezefilm.reynolds.periodic.refinement import are_many
from squeezefilm.reynolds.terms import compiled_terms, terms_of
from squeezefilm.reynolds.terms.rarefaction import (
    FLOW_TABLE_PATH,
    SLIP_FLOW_LIMIT,
    flow_to_viscous_ratio,
    slip_flow,
    slip_flow_derivatives,
)
from squeezefilm_workflow.verification.rarefied_flow import poiseuille_flow

KINETIC, NARROW = {"rarefaction": "fukui-kaneko"}, 67 / 60
"""The flow factor, and the Knudsen number of air in a gap of 60 nm."""


def test_films_with_neglected_effects_share_a_program():
    """A force and its budget load no other, 30 ms; many films without effects have their own."""
    scene = film(epsilon=0.4, sigma=100.0, profile=PISTON)
    effects = (
        *({"rarefaction": "slip"}, KINETIC, {"inertia": "included"}, {"thermal": "included"}),
        {"rarefaction": "slip", "inertia": "included", "thermal": "included"},
    )
    shared = {compiled_terms(terms_of(scene.with_gas(**gas)), many=True) for gas in effects}
    assert shared == {compiled_terms(terms_of(scene), many=False)}
    assert compiled_terms(terms_of(scene), many=True) not in shared


def test_few_films_have_the_forces_of_many():
    few = [film(epsilon=0.4, sigma=sigma, profile=PISTON) for sigma in (3.0, 30.0, 300.0)]
    many = few * 50
    assert (are_many(few), are_many(many)) == (False, True)
    forces = [solve(scenes, tolerance=1e-5, method="periodic").force_n for scenes in (few, many)]
    assert forces[0] == pytest.approx(forces[1][:3], rel=1e-12)


@pytest.mark.parametrize("inverse", [0.0113, 0.087, 0.42, 1.7, 5.3, 37.0, 300.0])
def test_the_flow_factor_is_the_integral_equations(inverse):
    flow = poiseuille_flow(inverse, points=40, half_rule=40)
    assert inverse / 6 + slip_flow(inverse) == pytest.approx(flow, rel=1e-6)


def test_the_table_is_the_integral_equations():
    for inverse, stored in np.loadtxt(FLOW_TABLE_PATH, delimiter=",", skiprows=1)[::10]:
        assert stored == pytest.approx(poiseuille_flow(inverse), rel=4e-9)


def test_beyond_the_table_gas_slips_or_its_molecules_fly_freely():
    """Slip of the BGK equation, 1.1466 Kn, and ln(1/D)/√π, which is approached slowly."""
    for inverse in (1e4, 1e6):
        assert slip_flow(inverse) == pytest.approx(SLIP_FLOW_LIMIT, rel=3 / inverse**0.5)
    assert 2 * SLIP_FLOW_LIMIT / np.pi**0.5 == pytest.approx(1.1466, rel=1e-4)
    direct, other = (poiseuille_flow(each, points=40, half_rule=40) for each in (1e-4, 1e-5))
    assert slip_flow(1e-5) - slip_flow(1e-4) == pytest.approx(other - direct, rel=2e-3)
    assert slip_flow(1e-5) == pytest.approx(other, rel=1e-3)
    assert other - direct == pytest.approx(np.log(10) / np.pi**0.5, rel=3e-3)


def test_the_flow_factors_derivatives_are_difference_quotients():
    inverse, step = np.geomspace(1e-3, 3e3, 30), 1e-4
    low, high = (inverse * np.exp(s) for s in (-step, step))
    first, second = slip_flow_derivatives(inverse)
    assert first == pytest.approx((slip_flow(high) - slip_flow(low)) / (2 * step), rel=1e-6)
    rise = slip_flow_derivatives(high)[0] - slip_flow_derivatives(low)[0]
    assert second == pytest.approx(rise / (2 * step), rel=1e-6)


@pytest.mark.parametrize("exponent", [1.0, 1.4])
@pytest.mark.parametrize("knudsen", [0.05, NARROW])
def test_a_film_with_the_flow_factor_solves_the_equation_as_it_is_written(knudsen, exponent):
    """∇·(W H³ρ ∇P) = σ ∂(Hρ)/∂T, which the solver has as two terms with other derivatives."""
    scene = film(
        epsilon=0.3, sigma=40.0, x=0.1, knudsen=knudsen, polytropic_exponent=exponent, **KINETIC
    )
    (solution,) = solve([scene], tolerance=1e-9, method="periodic", keep_states=True)
    films = fields_of([scene], [solution])
    left = films.mean(films.on_all_nodes(np.abs(residual(films))))
    assert left < 1e-6 * films.mean(films.sigma * np.abs(films.gap_rate))


@pytest.mark.parametrize(
    ("rarefaction", "knudsen"),
    [("none", 0.05), ("slip", 0.05), ("fukui-kaneko", 0.05), ("fukui-kaneko", NARROW)],
)
@pytest.mark.parametrize("exponent", [1.0, 1.4])
def test_mean_flow_potential_of_a_piston_is_that_of_ambient_pressure(
    rarefaction, knudsen, exponent
):
    """⟨∫ W H³ρ dP⟩ = 0 at every point: mass flows nowhere in the mean.

    The integral is that from ambient pressure, by quadrature here.
    """
    scene = film(
        epsilon=0.5,
        sigma=150.0,
        profile=PISTON,
        rarefaction=rarefaction,
        knudsen=knudsen,
        polytropic_exponent=exponent,
    )
    grid, states = periodic_state(scene, points=32, instants=40)
    assert states.status_indices[0] == 0
    gap = 1 + scene.epsilon * np.sin(grid.t.nodes)
    pressure = 1 + states.gauge_pressure_ratio[0]
    nodes, weights = np.polynomial.legendre.leggauss(20)
    path = 1 + (pressure[..., None] - 1) * (nodes + 1) / 2
    density = path ** (1 / exponent)
    numbers = equation_numbers_table(Scenes.of([scene]), terms_of(scene))
    (factor,) = flow_to_viscous_ratio(numbers, (gap[:, None] * density)[None])
    flow = gap**3 * (factor * density * weights).sum(axis=-1) * (pressure - 1) / 2
    assert np.abs(flow.mean(axis=-1)).max() < 1e-9
    assert np.abs(flow).max() > 0.1


@pytest.mark.parametrize(
    ("rarefaction", "knudsen"), [("slip", 0.01), ("slip", 0.1), ("fukui-kaneko", NARROW)]
)
def test_rarefied_films_at_infinite_squeeze_number(rarefaction, knudsen):
    """HP → ψ, approached like 1/√σ, with ⟨H ∫ W(m) m dm from H to ψ⟩ = 0.

    With slip that is ψ²/2 + 6Kψ = (1 + 3ε²/2)/2 + 6K(1 + ε²/2).
    """
    epsilon, inverse = 0.4, np.sqrt(np.pi) / (2 * knudsen)

    def potential(mass):
        """From 1, of the flow m W: 6 Q/D at D m without first-order slip."""
        if rarefaction == "slip":
            return (mass**2 - 1) / 2 + 6 * knudsen * (mass - 1)
        nodes, weights = np.polynomial.legendre.leggauss(5)
        flows = [poiseuille_flow(inverse * m, points=20) for m in 1 + (mass - 1) * (nodes + 1) / 2]
        return 6 / inverse * (weights @ flows) * (mass - 1) / 2

    gaps = 1 + epsilon * np.sin(2 * np.pi * np.arange(16) / 16)
    wall = np.mean([gap * potential(gap) for gap in gaps])
    psi = brentq(lambda mass: potential(mass) - wall, 0.5, 2)
    limit = psi / np.sqrt(1 - epsilon**2) - 1
    forces = [
        mean_overpressure(
            film(
                epsilon=epsilon,
                sigma=sigma,
                profile=PISTON,
                rarefaction=rarefaction,
                knudsen=knudsen,
            ),
            points=96,
            instants=16,
            fold=True,
        )
        for sigma in (4e4, 16e4)
    ]
    assert 2 * forces[1] - forces[0] == pytest.approx(limit, rel=2e-4)
    assert abs(forces[1] - limit) > 10 * abs(2 * forces[1] - forces[0] - limit)


def test_flow_factors_agree_for_a_dense_gas():
    """The flow factor is slip with coefficient 1.1466 to first order in Kn."""
    factor = film(epsilon=0.3, sigma=100.0, knudsen=1e-4, **KINETIC)
    slip = film(epsilon=0.3, sigma=100.0, rarefaction="slip", knudsen=1.1466e-4)
    forces = [solve([scene], tolerance=1e-8)[0].force_n for scene in (factor, slip)]
    assert forces[0] == pytest.approx(forces[1], rel=1e-6)


def test_fast_adiabatic_compression_is_stiffer_by_the_exponent():
    """At large σ the linear spring number is n times the isothermal one."""
    (stiff, _), (soft, _) = (
        spring_and_damping(
            film(epsilon=1e-4, sigma=1e6, profile=PISTON, polytropic_exponent=exponent), points=80
        )
        for exponent in (1.4, 1.0)
    )
    assert stiff / soft == pytest.approx(1.4, rel=2e-3)


@pytest.mark.parametrize("more", [{}, {"inertia": "included"}, {"bearing": 3.0}])
def test_slip_is_by_a_length_whatever_makes_it(more):
    """A coefficient c at a path λ is the coefficient 1 at c λ: the force and its budget."""
    short = film(epsilon=0.4, sigma=300.0, rarefaction="slip", knudsen=0.02, **more)
    kinetic = short.with_gas(slip_coefficient=1.147)
    long = film(epsilon=0.4, sigma=300.0, rarefaction="slip", knudsen=1.147 * 0.02, **more)
    plain, one, other = (
        solve([each], tolerance=1e-4)[0].force_n for each in (short, kinetic, long)
    )
    assert one == pytest.approx(other, rel=1e-9)
    assert abs(one / plain - 1) > 1e-3
    first, second = (each.effects["slip"].percent for each in error_budgets([kinetic, long]))
    assert first == pytest.approx(second, rel=1e-5)


@pytest.mark.parametrize(
    "terms",
    [
        {"rarefaction": "slip"},
        {"rarefaction": "fukui-kaneko"},
        {"polytropic_exponent": 1.4},
        {"inertia": "included"},
        {"inertia": "included", "rarefaction": "slip"},
        {"bearing": 5.0},
    ],
    ids=lambda terms: " ".join(map(str, terms.values())),
)
def test_a_term_s_response_is_the_difference_quotient_of_its_residual(terms):
    """One step of Newton's method from a neighbour's state leaves the square of the residual.

    A response that lacks a twentieth of a term's part leaves more; that of thermal effects does.
    """
    scene = film(epsilon=0.4, sigma=100.0, x=0.2, **terms)
    neighbour = replace(scene, hv_m=1.01 * scene.hv_m)
    grid = Grid(nx=16, ny=16, nt=12, fold_x=False, fold_y=False)
    device = choose_device()
    guess = solve_batch([neighbour], grid, tolerance=1e-12, device=device).unknowns
    residuals = []
    for steps in (0, 1):
        how = {"tolerance": 0.0, "device": device, "guess": guess, "most_newton": steps}
        states = solve_batch([scene], grid, **how)
        residuals.append(float(states.result_rows["residual"][0]))
    before, after = residuals
    assert 1e-3 < before < 1e-2
    assert after < 4 * before**2


WARM_FILMS = [{"thermal": "included"}, {"thermal": "included", "inertia": "included"}]


def warm_film(reynolds: float, *, epsilon: float, sigma: float = 490.0, **gas: str) -> Scene:
    return at_reynolds(film(epsilon=epsilon, sigma=sigma, profile=PISTON, **gas), reynolds)


@pytest.mark.parametrize("terms", WARM_FILMS)
def test_an_iteration_with_thermal_effects_says_what_it_leaves(terms):
    """Where a step lacks a part of the equation, no less is said than the force is off by."""
    scene, grid = warm_film(5.0, epsilon=0.3, **terms), Grid(12, 12, 12, True, True)
    device = choose_device()
    tolerances = 1e-12, 1e-6, 1e-7, 1e-8
    exact, *others = (
        solve_batch([scene], grid, tolerance=tolerance, device=device).result_rows[0]
        for tolerance in tolerances
    )
    for result in others:
        assert abs(result["mean"] - exact["mean"]) <= result["residual"]


@pytest.mark.parametrize("reynolds", [5.0, 10.0])
def test_of_a_small_amplitude_the_modes_in_time_know_inertia_and_heat(reynolds):
    """No more is left to an iteration than what the steps are apart in which lags are told."""
    scene = warm_film(reynolds, epsilon=1e-4, sigma=300.0, **WARM_FILMS[1])
    states = solve_batch(
        [scene], Grid(16, 16, 8, True, True), tolerance=1e-6, device=choose_device()
    )
    assert states.result_rows["krylov_iterations"][0] <= 8


def test_steps_with_inertia_and_heat_take_the_flow_as_warm_as_it_is():
    """By what it lacks of warm gas' flow Newton's method crept, or failed where waves are steep."""
    scene = warm_film(8.0, epsilon=0.3, **WARM_FILMS[1])
    neighbour = replace(scene, hv_m=1.03 * scene.hv_m)
    grid, device = Grid(12, 12, 16, True, True), choose_device()
    guess = solve_batch([neighbour], grid, tolerance=1e-11, device=device).unknowns
    before, after = (
        solve_batch(
            [scene], grid, tolerance=0.0, device=device, guess=guess, most_newton=steps
        ).result_rows["residual"][0]
        for steps in (2, 3)
    )
    assert after < before / 20
