"""Work-groups of a graphics processor's size, on the processor at hand: the stored forces."""

from collections.abc import Iterator

import pandas as pd
import pytest
from films import SINC, film

from squeezefilm.film.scene import Scene
from squeezefilm.reynolds import self_test, terms
from squeezefilm.reynolds.device import choose_device
from squeezefilm.reynolds.grid import Grid
from squeezefilm.reynolds.periodic.launch import solve_batch

# Films that have every term among them but inertia and thermal effects: PoCL compiles a kernel of
# so many items half a minute, theirs more than five.
COMPILED = ("slip", "fukui-kaneko, polytropic", "any gap, wide and narrow", "ellipse, sliding")


@pytest.fixture
def terms_compiled_alone(monkeypatch) -> Iterator[None]:
    """A film's program without the terms that share it, whichever was asked for before."""
    monkeypatch.setattr(terms, "COMPILED_TOGETHER_TERMS", ())
    terms.compiled_terms.cache_clear()
    yield
    terms.compiled_terms.cache_clear()


@pytest.mark.usefixtures("terms_compiled_alone")
def test_large_work_groups_give_the_stored_forces(monkeypatch) -> None:
    """Of as many items as a graphics processor is given."""
    monkeypatch.setenv("PYOPENCL_BUILD_OPTIONS", "-cl-opt-disable")
    films = {name: self_test.test_cases()[name] for name in COMPILED}
    monkeypatch.setattr(self_test, "test_cases", lambda: films)
    stored = pd.read_csv(self_test.STORED_FORCES_PATH, index_col="film")["mean_overpressure"][
        list(films)
    ]
    found = self_test.forces_of_test_cases(choose_device(work_items=128))
    assert found == pytest.approx(stored.to_dict(), rel=self_test.FORCE_TOLERANCE)


@pytest.mark.parametrize("items", [1, 4])
def test_grids_of_all_even_sizes_have_the_same_state(items: int, monkeypatch) -> None:
    """Rows in fours, with two left, and halves of odd length; twelve instants fill no register."""
    if items > 1:
        monkeypatch.setenv("PYOPENCL_BUILD_OPTIONS", "-cl-opt-disable")
    device = choose_device(work_items=items)

    def force(scene: Scene, grid: Grid) -> float:
        states = solve_batch([scene], grid, tolerance=1e-9, device=device, many=True)
        assert states.status_indices[0] == 0
        return float(states.mean_pressure_ratio[0])

    whole = film(epsilon=0.3, sigma=20.0, profile=SINC, x=0.05, y=0.1)
    quarter = film(epsilon=0.3, sigma=20.0, profile=SINC)
    for nt in (8, 12):
        exact = force(whole, Grid(32, 32, nt, False, False))
        for nx, ny in ((18, 20), (20, 22), (22, 24), (26, 18), (28, 30), (30, 34), (34, 26)):
            grid = Grid(nx, ny, nt, False, False)
            assert force(whole, grid) == pytest.approx(exact, rel=3e-7), grid
        exact = force(quarter, Grid(16, 16, nt, True, True))
        for nx, ny in ((10, 10), (10, 12), (14, 10), (12, 18), (18, 14), (14, 14)):
            grid = Grid(nx, ny, nt, True, True)
            assert force(quarter, grid) == pytest.approx(exact, rel=3e-7), grid
