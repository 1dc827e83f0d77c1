"""The strip resolved across the gap, and the equations averaged over it, by limits and balances."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from physics_facts import strip_spring

from numerics.strip import newton, table
from numerics.strip.averaged import AveragedFilm
from numerics.strip.energy import power_balance
from numerics.strip.film import HeatedGas, StripFilm
from numerics.strip.force import StripForce, strip_force
from numerics.strip.grid import half_grid, strip_grid
from numerics.strip.resolved import ResolvedFilm
from squeezefilm.io.errors import InputError, RunError

AIR = HeatedGas()
MIDDLING = StripFilm(epsilon=0.4, sigma=583.0, reynolds=1.81)


def piston(distance: np.ndarray) -> np.ndarray:
    return np.ones_like(distance)


def resolved_state(
    film: StripFilm, *, nx: int = 14, nz: int = 5, nt: int = 21, **given: Any
) -> tuple[ResolvedFilm, np.ndarray]:
    grid = strip_grid(nx=nx, nz=nz, nt=nt)
    averaged = AveragedFilm(film, grid, inertia=False)
    rest = averaged.solve(tolerance=1e-9).state
    equation = ResolvedFilm(film, grid, **given)
    start = equation.from_averaged(*averaged.unpacked(rest))
    return equation, equation.solve(start, tolerance=1e-11).state


def resolved_force(film: StripFilm, **given: Any) -> float:
    equation, state = resolved_state(film, **given)
    return equation.force(state)


def forces(epsilon: float, reynolds: float, sigma: float, **given: Any) -> dict[str, StripForce]:
    film = {"epsilon": epsilon, "reynolds": reynolds, "sigma": sigma}
    return {
        inertia: strip_force(**film, inertia=inertia, **given)
        for inertia in ("none", "first-order", "one-mode", "resolved")
    }


# Known forces: the paper's profile, by a march and by a harmonic balance written apart


@pytest.mark.parametrize(
    ("epsilon", "sigma", "reynolds", "still", "one_mode", "resolved"),
    [
        (0.2, 583.0, 0.45, 0.025566, 0.026096, 0.026096),
        (0.2, 583.0, 1.81, 0.025566, 0.027352, 0.027343),
        (0.4, 2331.0, 0.45, 0.107624, 0.109656, 0.109655),
        (0.2, 146.0, 7.23, 0.025967, 0.028855, 0.028739),
    ],
)
def test_known_forces_with_inertia(
    epsilon: float,
    sigma: float,
    reynolds: float,
    still: float,
    one_mode: float,
    resolved: float,
) -> None:
    found = forces(epsilon, reynolds, sigma, entrance="open")
    last_digit = 1.5e-6  # one in it and its rounding
    assert found["none"].force == pytest.approx(still, abs=last_digit)
    assert found["one-mode"].force == pytest.approx(one_mode, abs=last_digit)
    assert found["resolved"].force == pytest.approx(resolved, abs=last_digit)
    assert all(each.relative_error < 1e-6 for each in found.values())


def test_known_force_with_inertia_and_heat() -> None:
    found = strip_force(
        epsilon=0.2,
        sigma=146.0,
        reynolds=7.23,
        inertia="resolved",
        heat="resolved",
        entrance="open",
    )
    assert found.force == pytest.approx(0.029747, abs=1.5e-6)


@pytest.mark.parametrize(
    ("epsilon", "sigma", "reynolds", "percent"),
    [
        (0.2, 583.0, 0.2, -0.079),
        (0.2, 583.0, 0.45, -0.177),
        (0.2, 583.0, 1.81, -0.713),
        (0.4, 2331.0, 0.45, -0.158),
    ],
)
def test_known_effects_of_heat_to_first_order(
    epsilon: float, sigma: float, reynolds: float, percent: float
) -> None:
    film = {"epsilon": epsilon, "sigma": sigma, "reynolds": reynolds}
    without = strip_force(**film).force
    found = strip_force(**film, heat="first-order").force
    assert 100 * (found / without - 1) == pytest.approx(percent, abs=5.1e-4)


# Limits


def test_the_strip_s_spring_at_small_amplitude() -> None:
    found = strip_force(epsilon=1e-3, sigma=200.0, reynolds=1.0, profile=piston)
    assert found.force == pytest.approx(1.25e-6 * strip_spring(200.0), rel=1e-5)


@pytest.mark.parametrize("reynolds", [0.5, 5.0, 50.0])
def test_linear_mobility_is_the_exact_one(reynolds: float) -> None:
    """sigma^-1 M d2p/dx2 = i (p + s), M = (3/q^2) (1 - tanh(q)/q), q^2 = i Re/4."""
    epsilon, sigma = 1e-4, 200.0
    film = StripFilm(epsilon=epsilon, sigma=sigma, reynolds=reynolds, profile=piston)
    equation, state = resolved_state(film, nz=8)
    q = np.sqrt(0.25j * reynolds)
    wave = np.sqrt(1j * sigma / (3 / q**2 * (1 - np.tanh(q) / q)))
    x = equation.grid.x.x
    exact = np.cosh(wave * (0.5 - x)) / np.cosh(wave / 2) - 1
    pressure = (equation.fields(state).mass / equation.height)[..., 0]
    # of sin T, so that a first harmonic a exp(iT) has the coefficient Im
    first = 2j * np.fft.fft(pressure, axis=0)[1] / equation.grid.instants / epsilon
    assert first == pytest.approx(exact, abs=2e-4)


def test_the_first_order_in_re_is_that_of_the_resolved_film() -> None:
    def left(reynolds: float) -> float:
        found = forces(0.4, reynolds, 200.0, entrance="open")
        assert abs(found["first-order"].force / found["none"].force - 1) > 1e-3
        return found["resolved"].force - found["first-order"].force

    assert left(0.2) / left(0.1) == pytest.approx(4, abs=0.2)


def test_the_first_order_of_heat_is_that_of_the_resolved_film() -> None:
    def left(reynolds: float) -> float:
        film = {"epsilon": 0.3, "sigma": 200.0, "reynolds": reynolds, "entrance": "open"}
        first = strip_force(**film, heat="first-order").force - strip_force(**film).force
        resolved = [
            strip_force(**film, inertia="resolved", heat=heat).force
            for heat in ("none", "resolved")
        ]
        assert abs(first) > 1e-4 * resolved[0]
        return resolved[1] - resolved[0] - first

    assert left(0.2) / left(0.1) == pytest.approx(4, abs=0.3)


def test_one_mode_differs_from_the_resolved_film_in_the_second_order() -> None:
    def left(reynolds: float) -> float:
        found = forces(0.4, reynolds, 200.0, entrance="open")
        return found["one-mode"].force - found["resolved"].force

    assert left(0.4) / left(0.2) == pytest.approx(4, abs=0.4)


@pytest.mark.parametrize(
    ("epsilon", "reynolds", "most"), [(0.05, 2.0, 2e-3), (0.4, 2.0, 2e-3), (0.4, 10.0, 1e-2)]
)
def test_one_mode_is_near_the_resolved_film(epsilon: float, reynolds: float, most: float) -> None:
    found = forces(epsilon, reynolds, table.SIGMA_REYNOLDS / reynolds)
    assert found["one-mode"].force == pytest.approx(found["resolved"].force, rel=most)
    assert found["none"].force != pytest.approx(found["resolved"].force, rel=3 * most)


# Accuracy


def test_the_half_grid_is_exact_for_polynomials() -> None:
    grid = half_grid(4)
    y = 1 - 2 * grid.x
    even, odd = 3 + y**2 - y**8, y**7 - y
    assert grid.even @ even == pytest.approx(-2 * (2 * y - 8 * y**7), abs=1e-11)
    assert grid.odd @ odd == pytest.approx(-2 * (7 * y**6 - 1), abs=1e-11)
    assert grid.weights @ even == pytest.approx(3 + 1 / 3 - 1 / 9)
    excess = -(y / 6 * (y**2 - 1) - y / 18 * (y**8 - 1))
    assert grid.excess @ even == pytest.approx(excess, abs=1e-12)


def test_the_rate_is_exact_for_harmonics() -> None:
    grid = strip_grid(nx=3, nz=3, nt=9)
    assert grid.rate @ np.sin(4 * grid.phase) == pytest.approx(4 * np.cos(4 * grid.phase))
    with pytest.raises(ValueError, match="odd"):
        strip_grid(nx=3, nz=3, nt=8)


@pytest.mark.parametrize(
    "sizes",
    [
        [{"nx": 4}, {"nx": 6}, {"nx": 12}],
        [{"nz": 2}, {"nz": 3}, {"nz": 4}],
        [{"nt": 5}, {"nt": 9}, {"nt": 13}],
    ],
    ids=["across the strip", "across the gap", "in time"],
)
@pytest.mark.parametrize("gas", [None, AIR], ids=["isothermal", "with heat"])
def test_an_open_rim_converges_spectrally(
    sizes: list[dict[str, int]], gas: HeatedGas | None
) -> None:
    given: dict[str, Any] = {"gas": gas, "entrance": "open"}
    exact = resolved_force(MIDDLING, nx=20, nz=7, nt=31, **given)
    fine = {"nx": 20, "nz": 7, "nt": 31}
    errors = [abs(resolved_force(MIDDLING, **fine | size, **given) - exact) for size in sizes]
    assert errors[1] < errors[0] / 6
    assert errors[2] < errors[1] / 6


def test_a_local_rim_converges_in_the_second_order() -> None:
    exact, *found = (resolved_force(MIDDLING, nx=nx, nt=31) for nx in (32, 6, 12))
    errors = np.abs(np.array(found) - exact)
    assert errors[1] < errors[0] / 3.5


@pytest.mark.parametrize("reynolds", [1.8, 10.0])
@pytest.mark.parametrize("heat", ["none", "resolved"])
def test_estimates_cover_the_change_on_a_much_finer_grid(reynolds: float, heat: Any) -> None:
    film = {"epsilon": 0.4, "sigma": table.SIGMA_REYNOLDS / reynolds, "reynolds": reynolds}
    found, finer = (
        strip_force(**film, inertia="resolved", heat=heat, refinement=each) for each in (1, 1.5)
    )
    assert abs(found.force - finer.force) < found.error
    assert found.relative_error < 1e-4


def test_how_gas_enters_matters_little_while_advection_is_weak() -> None:
    apart = []
    for reynolds in (0.45, 1.81):
        film = {"epsilon": 0.2, "sigma": 583.0, "reynolds": reynolds, "inertia": "resolved"}
        local, open_ = (strip_force(**film, entrance=each).force for each in ("local", "open"))
        apart.append(abs(local / open_ - 1))
    assert apart[0] < apart[1] < 3e-6


# Power


@pytest.mark.parametrize(
    ("gas", "most"), [(None, 1e-8), (AIR, 1e-6)], ids=["isothermal", "with heat"]
)
def test_the_surface_s_power_is_found_again(gas: HeatedGas | None, most: float) -> None:
    equation, state = resolved_state(MIDDLING, nx=18, nz=6, nt=31, gas=gas, entrance="open")
    balance = power_balance(equation, state)
    assert balance.defect == pytest.approx(0, abs=most)
    assert balance.put_in > 0
    assert abs(balance.kinetic) > 1e-4 * balance.put_in  # so that its term is seen
    spoilt = power_balance(equation, state * (1 + 1e-3 * np.cos(np.arange(len(state)))))
    assert abs(spoilt.defect) > 1e-5


def test_with_heat_the_walls_take_the_power_and_not_the_friction() -> None:
    equation, state = resolved_state(MIDDLING, nt=31, gas=AIR, entrance="open")
    balance = power_balance(equation, state)
    assert balance.walls == pytest.approx(balance.put_in, rel=0.02)
    assert balance.enthalpy != 0


# What is refused, what fails, and the table


def test_what_makes_no_sense_is_refused() -> None:
    with pytest.raises(InputError, match="together"):
        strip_force(epsilon=0.2, sigma=583.0, reynolds=1.0, heat="resolved")
    with pytest.raises(InputError, match="amplitude"):
        strip_force(epsilon=1.0, sigma=583.0, reynolds=1.0)


def test_every_row_has_a_force_or_a_reason(monkeypatch: pytest.MonkeyPatch) -> None:
    scenes: dict[str, Any] = {"epsilon": (0.3,), "reynolds": (0.5, 5.0), "log": lambda text: None}
    found = table.strip_table(**scenes)
    assert list(found["equation"]) == 2 * list(table.EQUATIONS)
    assert set(found["status"]) == {"ok"}
    assert found.notna().all().all()
    sound = newton.newton

    def stops(residual: Any, start: Any, *given: Any, **named: Any) -> newton.Root:
        if isinstance(residual.__self__, ResolvedFilm) and residual.__self__.film.reynolds > 1:
            raise RunError("no convergence")
        return sound(residual, start, *given, **named)

    monkeypatch.setattr("numerics.strip.resolved.newton", stops)
    found = table.strip_table(**scenes).set_index(["reynolds", "equation"])
    assert found.loc[(5.0, "resolved"), "status"] == "failed: no convergence"
    assert np.isnan(found.loc[(5.0, "resolved"), "force"])
    assert found.loc[(5.0, "one_mode"), "status"] == "ok"
    assert np.isnan(found.loc[(5.0, "one_mode"), "from_resolved"])
    assert (found.loc[0.5, "status"] == "ok").all()


@pytest.mark.parametrize(
    ("bound", "expected"),
    [(1e-3, (10**0.5, "reached")), (1e-5, (0.1, "below")), (2.0, (100.0, "beyond"))],
)
def test_where_an_error_passes_a_bound(bound: float, expected: tuple[float, str]) -> None:
    reynolds, error = np.array([1.0, 10.0, 100.0]), np.array([1e-4, 1e-2, 1.0])
    for sign in (1, -1):
        found, verdict = table._crossing(reynolds, sign * error, bound=bound)
        assert (found, verdict) == (pytest.approx(expected[0]), expected[1])


def test_where_an_error_passes_a_bound_after_a_change_of_sign() -> None:
    found = table._crossing(np.array([1.0, 10.0]), np.array([0.5e-3, -1.5e-3]), bound=1e-3)
    assert found == (pytest.approx(10**0.75), "reached")
