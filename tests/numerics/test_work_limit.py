"""A scene has a limit of operations, after which it ends with a reason and what to do."""

from dataclasses import replace

import pytest
from films import at_reynolds, film

from squeezefilm.reynolds import solve
from squeezefilm.reynolds.periodic import launch, refinement

LIMIT = 3e7


@pytest.fixture
def limit(monkeypatch: pytest.MonkeyPatch) -> None:
    """A limit of work that a hard film exceeds within a second."""
    for module in (launch, refinement):
        monkeypatch.setattr(module, "MAX_OPERATIONS", LIMIT)
    launch._grid_size_columns.cache_clear()
    yield
    launch._grid_size_columns.cache_clear()


@pytest.mark.parametrize("terms", ["none", "included"])
def test_a_film_that_takes_too_much_work_ends_with_a_remedy(limit, terms):
    scene = film(epsilon=0.9, sigma=2e3, x=0.1, inertia=terms)
    (solution,) = solve([scene], tolerance=1e-9, method="periodic")
    assert "not converged" in solution.status
    assert "operations" in solution.status
    assert "take a larger tolerance" in solution.status
    assert ("or no inertia" in solution.status) == (terms == "included")
    assert solution.operation_count <= 2 * LIMIT


def test_an_iteration_that_does_not_end_is_stopped(limit):
    """On one grid as well, where there is no finer one to be refused."""
    scene = film(epsilon=0.5, sigma=20.0, inertia="included")
    (solution,) = solve([at_reynolds(scene, 50)], tolerance=1e-9, method="periodic")
    assert solution.status != "ok"
    assert solution.operation_count <= 2 * LIMIT


@pytest.mark.parametrize("frequency_hz", [1e3, 1e7, 1e8, 1e9])
@pytest.mark.parametrize("h0_m", [1e-8, 1e-5, 1e-3])
def test_every_frequency_and_gap_has_a_force_or_a_reason(limit, frequency_hz, h0_m):
    scene = film(epsilon=0.3, sigma=20.0, inertia="included", thermal="included")
    scene = replace(scene.with_gas(viscosity_pa_s=1.81e-5), h0_m=h0_m, hv_m=0.3 * h0_m)
    scene = replace(scene, actuator=replace(scene.actuator, frequency_hz=frequency_hz))
    (solution,) = solve([scene], tolerance=1e-2)
    assert "unexpected" not in solution.status
    assert solution.operation_count <= 2 * LIMIT
