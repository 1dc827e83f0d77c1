"""The space holds what can be simulated, and nothing else."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from squeezefilm.designs.space import Space, coordinate_function
from squeezefilm.studies.space import space_of_study
from squeezefilm.studies.study import scenes_of_table


@pytest.fixture(scope="module")
def space(paper):
    return space_of_study(paper)


def wide(space: Space) -> Space:
    """The same with amplitudes up to the gap and positions off the surface."""
    wider = {"h0_m": (2e-6, 10e-6), "hv_m": (0.2e-6, 4e-6), "phi_r_m": (0.0, 4e-3)}
    return replace(space, limits=space.limits | wider)


@pytest.mark.parametrize("kind", ["grid", "sample"])
def test_points_that_cannot_be_simulated_are_left_out(space, paper, kind):
    larger = wide(space)
    points = larger.grid(500, distinct=True) if kind == "grid" else larger.sample(300, seed=1)
    assert np.all(points[:, 1] < points[:, 0])
    scenes_of_table(pd.DataFrame(points, columns=larger.names), paper)
    corner = np.array([[9e-6, 2e-6, 3.5e-3, 0.0], [9e-6, 2e-6, 3.5e-3, 45.0]])
    assert list(larger.allowed_mask(corner)) == [True, False]


def test_a_sample_is_fair_and_repeatable(space):
    points = space.sample(400, seed=3)
    unit = space.to_unit(points)
    np.testing.assert_allclose(unit.mean(axis=0), 0.5, atol=0.02)
    np.testing.assert_allclose(unit.var(axis=0), 1 / 12, atol=0.01)
    np.testing.assert_array_equal(points, space.sample(400, seed=3))
    assert not np.array_equal(points, space.sample(400, seed=4))


def test_a_grid_has_its_limits_and_each_scene_once(space):
    points = space.grid(1500, distinct=True)
    unit = space.to_unit(points)
    assert unit.min() == 0
    assert unit.max() == 1
    places = np.round(coordinate_function("scene", space)(points), 12)
    assert len(np.unique(places, axis=0)) == len(points)
    assert len(space.grid(1500, distinct=False)) == 6**4
    # The first direction of a full circle is its last one.
    around = replace(space, limits=space.limits | {"phi_deg": (0.0, 360.0)})
    points = around.grid(3000, distinct=True)
    assert len(np.unique(np.round(coordinate_function("scene", around)(points), 9), axis=0)) == len(
        points
    )
