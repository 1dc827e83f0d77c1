"""Work-groups of a graphics processor's size, on the processor at hand: the stored forces."""

import pandas as pd
import pytest

from squeezefilm.reynolds import self_test
from squeezefilm.reynolds.device import choose_device


@pytest.mark.parametrize("items", [64, 128, 256])
def test_large_work_groups_give_the_stored_forces(items: int, monkeypatch) -> None:
    """Every term but inertia, whose kernel PoCL compiles for more than five minutes then."""
    monkeypatch.setenv("PYOPENCL_BUILD_OPTIONS", "-cl-opt-disable")
    films = {name: film for name, film in self_test.films().items() if "inertia" not in name}
    monkeypatch.setattr(self_test, "films", lambda: films)
    stored = pd.read_csv(self_test.TABLE, index_col="film")["mean_overpressure"][list(films)]
    found = self_test.forces(choose_device(work_items=items))
    assert found == pytest.approx(stored.to_dict(), rel=self_test.CLOSENESS)
