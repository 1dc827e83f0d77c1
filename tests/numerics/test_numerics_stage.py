"""The numerics stage: its reference and its checks are right, and the checks catch faults."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from films import saying
from physics_facts import (
    CUT_OFF_SIGMA,
    SINC_CONVERGED,
    SLOW_SPRING,
    SPRING_AT_20,
    SPRING_AT_CUT_OFF,
    strip_spring,
)

from numerics import analytic, stability
from numerics.films import PISTON, Film
from numerics.peers.explicit_march import step_limit
from numerics.peers.numpy_periodic import periodic_state
from numerics.reference import reference_force
from numerics.state_checks import check_state
from numerics.work_precision import FILMS, work_precision
from squeezefilm.reynolds import solve
from squeezefilm.reynolds.device import choose_device
from squeezefilm.reynolds.grid import Grid
from squeezefilm.reynolds.layout import Joined
from squeezefilm.reynolds.periodic import launch as periodic
from squeezefilm.reynolds.periodic import profiles
from squeezefilm.reynolds.periodic.states import States
from squeezefilm.reynolds.terms import Terms

Fields = dict[str, np.ndarray]


@pytest.mark.parametrize(
    ("film", "force"),
    [
        *((Film("", 0.44, sigma), force) for sigma, force in SINC_CONVERGED.items()),
        (Film("", 1e-3, 20.0, profile=PISTON), 1.25e-6 * SPRING_AT_20),
    ],
)
def test_the_reference_gives_known_forces_within_its_uncertainty(film, force):
    found = reference_force(
        epsilon=film.epsilon, sigma=film.sigma, gap=film.scene.gap, fold=film.fold
    )
    assert found.force == pytest.approx(force, rel=1e-5 if film.profile is PISTON else 1e-9)
    assert 0 < found.uncertainty < 1e-11


@pytest.mark.parametrize("kind", ["travelling", "tilted", "bulging"])
def test_the_reference_has_the_solver_s_forces_of_any_gap(kind):
    """Elements and the weak form beside collocation: nothing is shared but the equation."""
    film = next(film for film in FILMS if film.name.startswith(kind))
    scene = film.scene
    found = reference_force(
        epsilon=scene.closure(), sigma=film.sigma, gap=scene.gap, fold=film.fold, degree=14
    )
    (solution,) = solve([scene], tolerance=1e-8, method="periodic")
    assert solution.force_n / scene.force_scale_n == pytest.approx(found.force, rel=1e-8)


@pytest.mark.parametrize(
    ("sigma", "stiffness"),
    [(20.0, SPRING_AT_20), (CUT_OFF_SIGMA, SPRING_AT_CUT_OFF), (1e-3, 1e-6 * SLOW_SPRING)],
)
def test_blech_s_stiffness_of_the_square(sigma, stiffness):
    assert analytic.blech_stiffness(sigma=sigma) == pytest.approx(stiffness, rel=3e-7)


def test_a_very_long_rectangle_is_langlois_strip():
    long = analytic.blech_stiffness(sigma=20.0, aspect=1e5)
    assert long == pytest.approx(strip_spring(20.0), rel=1e-5)


def test_the_explicit_march_is_stable_up_to_its_theory():
    found = step_limit(sigma=20.0, points=8)
    assert found.experiment == pytest.approx(found.theory, rel=0.02)


def test_a_solved_film_passes_the_state_checks_and_a_spoilt_one_does_not():
    film = Film("", 0.4, 20.0, profile=PISTON)
    state = periodic_state(epsilon=film.epsilon, sigma=film.sigma, amplitude=film.amplitude, nt=24)
    overpressure = np.moveaxis(state.pressure - 1, 0, -1)
    good = check_state(film, overpressure)
    assert good.force == pytest.approx(state.force, rel=1e-12)
    assert max(good.defect, good.piston_identity) < 1e-6
    assert good.mass_balance < 1e-5
    spoilt = check_state(film, overpressure * 1.01)
    assert min(spoilt.defect, spoilt.state_defect, spoilt.piston_identity) > 2e-3


# Faults are put into the solver, and the cases that they touch must turn red, no others.

CASES = {
    "sinc": "sinc, σ = 2331, ε = 0.1",
    "piston": "piston, σ = 20, ε = 0.5",
    "sliding": "sliding, Λ = 100, σ = 583",
    "small": "sinc, σ = 1, ε = 0.001",
    "tilted": "tilted, σ = 20",
    "two phases": "travelling wave, σ = 20",
}


def red() -> set[str]:
    chosen = [case for case in stability.cases() if case.film.name in CASES.values()]
    table = stability.stability(chosen, device=choose_device())
    failed = set(table.loc[table["verdict"] == "failed", "case"])
    return {name for name, case in CASES.items() if case in failed}


def test_a_sound_solver_fails_no_case():
    assert red() == set()


def spoil_fields(change: Callable[[Fields], None]) -> Callable[..., Fields]:
    """The profile's fields by name, changed before the kernel sees them."""
    sound = profiles.profile_fields

    def spoilt(*args: Any, **options: Any) -> Fields:
        fields = sound(*args, **options)
        change(fields)
        return fields

    return spoilt


def drop_curvature(fields: Fields) -> None:
    fields["laplacian"] = 0 * fields["laplacian"]


def drop_quadrature(fields: Fields) -> None:
    for parts in fields.values():
        parts[:, 1:2] *= 0


def level_rest(fields: Fields) -> None:
    for parts in fields.values():
        parts[:, 2:] *= 0


def turn_slope(fields: Fields) -> None:
    if "slope_x" in fields:
        fields["slope_x"] = -fields["slope_x"]


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        (drop_curvature, {"sinc", "sliding", "small", "tilted", "two phases"}),
        (turn_slope, {"sliding"}),
        (drop_quadrature, {"two phases"}),
        (level_rest, {"tilted"}),
    ],
    ids=["dropped term", "wrong sign", "one phase", "even gap"],
)
def test_a_fault_in_a_term_turns_the_films_red_that_have_it(change, expected, monkeypatch):
    monkeypatch.setattr(profiles, "profile_fields", spoil_fields(change))
    monkeypatch.setattr(profiles, "_kept", {})
    assert red() == expected


def test_a_wrong_sign_of_the_squeeze_turns_every_film_red(monkeypatch):
    sound = periodic.grid_matrices

    def spoilt(grid: Grid, *, aspect: float, terms: Terms) -> Joined:
        matrices = sound(grid, aspect=aspect, terms=terms)
        values, at = matrices.values.copy(), matrices.starts[matrices.names.index("sine")]
        values[at : at + grid.nt] *= -1
        return replace(matrices, values=values)

    monkeypatch.setattr(periodic, "grid_matrices", spoilt)
    monkeypatch.setattr(periodic, "_of_grids", periodic._of_grids.__wrapped__)  # kept no longer
    assert red() == set(CASES)


def test_single_precision_turns_the_small_film_red(monkeypatch):
    """The state kept in float32, as a kernel with `float` for `double` would."""

    sound = periodic.Launch.states

    def rounded(states: States, grid: Grid) -> States:
        pressure = (1 + states.overpressure).astype(np.float32).astype(float) - 1
        weights = np.outer(grid.x.weights, grid.y.weights)
        mean = np.einsum("bxyt,xy->b", pressure, weights) / grid.nt
        means = pressure.mean(axis=-1)
        rough = replace(states, kept=pressure[:, None], mean_in_time=means)
        return saying(rough, mean=mean)

    def spoilt(landing: periodic.Launch) -> list[list[States]]:
        return [
            [rounded(states, grid) for states, grid in zip(stages, batch.grids, strict=True)]
            for stages, batch in zip(sound(landing), landing.batches, strict=True)
        ]

    monkeypatch.setattr(periodic.Batch, "returns", lambda batch, stage: True)
    monkeypatch.setattr(periodic.Launch, "states", spoilt)
    assert red() == {"small"}


def test_what_is_refused_must_be_documented():
    assert stability.beyond(Film("", 0.4, 583.0)) == ""
    assert "contact" in stability.beyond(Film("", 1.0, 583.0))
    assert "bearing" in stability.beyond(Film("", 0.4, 583.0, bearing=1e4))


def test_a_film_with_inertia_has_its_lines_beside_those_without():
    film = next(film for film in FILMS if film.reynolds)
    table = work_precision(
        (film,),
        repeats=1,
        batch=2,
        longest_seconds=0.1,
        rungs=3,
        model_error=0.01,
        device=choose_device(),
    )
    forces = table.groupby("method")["force"].last()
    assert set(forces.index) == {"periodic", "without_inertia"}
    assert forces["periodic"] / forces["without_inertia"] == pytest.approx(1.019, abs=2e-3)
    assert (table["relative_error"] <= table["estimated_error"]).all()
    assert (table["reference_uncertainty"] < 1e-8).all()


@pytest.mark.parametrize("kind", ["tilted", "ellipse"])
def test_a_shaped_gap_and_an_ellipse_have_their_lines(kind):
    film = next(film for film in FILMS if film.name.startswith(kind))
    table = work_precision(
        (film,),
        repeats=1,
        batch=2,
        longest_seconds=0.1,
        rungs=2,
        model_error=0.01,
        device=choose_device(),
    )
    limits = {"fast-limit", "boundary-layer"} if kind == "tilted" else set()
    assert set(table["method"]) == {"auto", "periodic", *limits}
    claimed = table[np.isfinite(table["estimated_error"])]
    assert (claimed["relative_error"] <= claimed["estimated_error"]).all()


def test_every_method_comes_near_the_reference():
    table = work_precision(
        (FILMS[3],),
        repeats=1,
        batch=2,
        longest_seconds=0.1,
        rungs=2,
        model_error=0.01,
        device=choose_device(),
    )
    settled = table[~table["method"].str.contains("limit|small-amplitude|boundary")]
    assert set(settled["status"]) == {"ok"}
    assert settled.groupby("method")["relative_error"].min().max() < 0.05
    claimed = settled[np.isfinite(settled["estimated_error"])]
    assert (claimed["relative_error"] <= claimed["estimated_error"]).all()
    assert (table["reference_uncertainty"] < 1e-9).all()
    assert (table["cpu_seconds"] > 0).all()
