"""What would explain a difference: found by changing one assumption at a time."""

import math

import numpy as np
import pytest
from physics_facts import CENTRED_N

from squeezefilm.film.scene import Scene
from squeezefilm_workflow.paper.uncertainty import assumptions_table
from squeezefilm_workflow.reporting.pages import readable_table


def film_like(scenes: list[Scene]) -> np.ndarray:
    """Forces that go with pressure and amplitude as the film's do, and less so with slip."""
    relative = [(s.epsilon / 0.44) ** 2.1 * s.gas.ambient_pressure_pa / 101_325 for s in scenes]
    others = [(1 - 0.6 * s.slip_knudsen) * s.gas.polytropic_exponent for s in scenes]
    return CENTRED_N * np.array(relative) * others


@pytest.fixture(scope="module")
def table(paper):
    return assumptions_table(paper, forces=film_like)


@pytest.fixture(scope="module")
def extrapolated(table):
    return table[table["claim_id"] == "simulation_at_2.2"].set_index("assumption")


def test_the_needed_value_gives_the_papers_force(extrapolated):
    needed = extrapolated["needed"]
    assert needed["ambient pressure"] == pytest.approx(101.325 * 0.99 / CENTRED_N, rel=1e-5)
    assert needed["amplitude"] == pytest.approx(2.2 * (0.99 / CENTRED_N) ** (1 / 2.1), rel=1e-5)
    change = extrapolated["needed_change_percent"]["ambient pressure"]
    assert change == pytest.approx(100 * (0.99 / CENTRED_N - 1), rel=1e-3)


def test_only_a_plausible_value_explains(extrapolated):
    verdicts = extrapolated["verdict"]
    assert verdicts["amplitude"] == "explains"  # 2.2 µm may be 2.15 to 2.25 µm
    assert (
        readable_table(extrapolated).loc["amplitude", "plausible upper"] == "2.25"
    )  # not in percent
    assert (verdicts.drop("amplitude") == "cannot explain").all()
    # A pressure would, but not one that is plausible.
    assert np.isfinite(extrapolated["needed"]["ambient pressure"])
    assert extrapolated["force_upper_n"]["ambient pressure"] < 0.985
    # What only lowers the force has no value that would.
    slip = extrapolated.loc["mean free path, by slip"]
    assert math.isnan(slip["needed"])
    assert slip["force_lower_n"] < slip["force_upper_n"] == pytest.approx(CENTRED_N)
