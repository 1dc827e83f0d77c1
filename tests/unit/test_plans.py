"""The plans are those of the paper, and have as many points as the rules expect."""

import numpy as np
import pandas as pd
import pytest

from squeezefilm.config.study import Positions
from squeezefilm.film.symmetry import MirrorAxes
from squeezefilm.studies.plans import (
    plan_point_counts,
    plan_scenes_table,
    random_plan,
    sobol_sweep_pieces,
)
from squeezefilm.studies.space import pad_positions, space_filling_positions


def test_the_screen_has_every_gap_with_every_amplitude_once(paper):
    plan = plan_scenes_table("screen", paper)
    assert len(plan) == 60 == plan_point_counts(paper)["screen"]
    assert plan["h0_m"].nunique() * plan["hv_m"].nunique() == 60
    assert not plan.drop(columns="point_id").duplicated().any()
    assert (plan[["phi_r_m", "phi_deg"]] == 0).all(axis=None)
    assert list(plan["point_id"]) == [str(number) for number in range(1, 61)]


def test_the_four_factor_plan_has_13_positions_with_5_points(paper):
    positions = pad_positions(paper)
    assert len(positions) == len(set(positions)) == 13
    assert positions[0] == (0.0, 0.0)
    design = pd.DataFrame({"h0_m": 5e-6, "hv_m": [1e-6, 1.2e-6, 1.4e-6, 1.6e-6, 2e-6]})
    plan = plan_scenes_table("four_factor", paper, design=design)
    assert len(plan) == 65 == plan_point_counts(paper)["four_factor"]
    assert not plan.drop(columns="point_id").duplicated().any()


@pytest.mark.parametrize("mirrored", [True, False])
def test_positions_of_another_study_fill_the_reachable_space(mirrored):
    """Whatever the wavelength, its phase at the positions is even: they cannot alias with it."""
    symmetry = MirrorAxes(x=mirrored, y=False)
    positions = space_filling_positions(symmetry, Positions(x=[0.01], y=[0.004], points=101))
    x_m, y_m = np.transpose(positions)
    assert positions[0] == (0.0, 0.0)
    assert len(set(positions)) == 101
    assert (-0.01 * (not mirrored) <= x_m).all()
    assert ((np.abs(x_m) <= 0.01) & (np.abs(y_m) <= 0.004)).all()
    assert np.sum(x_m == 0.01) >= 10
    assert {-0.004, 0.004} <= set(y_m)
    inner = (x_m < 0.01) & (np.abs(y_m) < 0.004)
    for wavelength_m in np.geomspace(1.5e-3, 10e-3, 40):  # of s², of modes of 3 to 20 mm
        phase = np.exp(2j * np.pi * x_m[inner] / wavelength_m)
        assert abs(phase.mean()) < 0.35, wavelength_m


BOX = {"h0_m": (5e-6, 1e-5), "hv_m": (2e-7, 2e-6), "phi_r_m": (0, 2.9e-3), "phi_deg": (0, 45)}


def test_a_sweep_fills_its_box_more_evenly_than_chance():
    """Mean of a product of the factors: a smooth function, integrated."""

    def error(plan: pd.DataFrame) -> float:
        units = [(plan[name] - low) / (high - low) for name, (low, high) in BOX.items()]
        assert all(((unit >= 0) & (unit < 1)).all() for unit in units)
        return abs(np.prod(units, axis=0).mean() - 0.5**4)

    even = [error(*sobol_sweep_pieces(points=1000, first=0, seed=seed, **BOX)) for seed in range(5)]
    random = [error(random_plan(points=1000, seed=seed, **BOX)) for seed in range(5)]
    assert np.mean(even) < 0.2 * np.mean(random)
