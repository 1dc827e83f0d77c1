"""D-optimal designs: known optima, the paper's two patterns, distinct scenes."""

import numpy as np
import pytest
from reference_forces import FOUR_FACTOR, FOUR_FACTOR_THETA, SCREEN_THETA, TWO_FACTOR

from squeezefilm.designs.optimal import exact_design_by_exchange, optimal_design_in_space
from squeezefilm.designs.paper_design import (
    Criterion,
    add_corner_points,
    d_efficiency,
    distinct_support_points,
    find_design_patterns,
    local_descent,
    search_design,
)
from squeezefilm.designs.space import Space, coordinate_function, pair_distances
from squeezefilm.models.data import Factors

FILM = Space({"h0_m": (5e-6, 10e-6), "hv_m": (0.2e-6, 2e-6)})
PLACED = Space(FILM.limits | {"phi_r_m": (0.0, 2.9e-3), "phi_deg": (0.0, 45.0)})
# Criterion (11) of the best five points with a scene that occurs twice.
TAKEN_TWICE = 3.927e11


def film_gradient(points):
    return TWO_FACTOR.gradient(SCREEN_THETA, Factors.of(h0_m=points[:, 0], hv_m=points[:, 1]))


def placed_gradient(points):
    factors = Factors.of(**dict(zip(PLACED.names, points.T, strict=True)))
    return FOUR_FACTOR.gradient(FOUR_FACTOR_THETA, factors)


def test_two_angles_at_the_centre_are_one_scene():
    centre = np.array([[5e-6, 2e-6, 0.0, 0.0], [5e-6, 2e-6, 0.0, 45.0]])
    rim = np.array([[5e-6, 2e-6, 2.9e-3, 0.0], [5e-6, 2e-6, 2.9e-3, 45.0]])
    scene = coordinate_function("scene", PLACED)
    assert pair_distances(scene(centre)) == pytest.approx([0.0], abs=1e-12)
    assert pair_distances(scene(rim)) == pytest.approx([2 * np.sin(np.pi / 8)])


@pytest.fixture(scope="module")
def patterns():
    criterion = Criterion(film_gradient, FILM, coordinate_function("unit", FILM))
    # Every run of a few seeds meets both patterns; which is the rarer depends on the search.
    return find_design_patterns([search_design(criterion, 3, seed=s) for s in range(6)], FILM)


def test_the_searches_end_in_two_patterns(patterns):
    assert [pattern.name for pattern in patterns] == ["A", "B"]
    first, second = (pattern.design.points * 1e6 for pattern in patterns)
    np.testing.assert_allclose(first, [[5, 2], [6.91, 2], [10, 0.2]], atol=0.01)
    np.testing.assert_allclose(second, [[5, 1.45], [5, 2], [10, 0.2]], atol=0.01)
    assert sum(len(pattern.design_indices) for pattern in patterns) == 6
    # They differ by 5e-6 of the criterion: which of them is met more often means little.
    excess = patterns[1].design.value - patterns[0].design.value
    assert excess == pytest.approx(0.61, abs=0.05)


def test_both_patterns_are_d_optimal(patterns):
    best = optimal_design_in_space(film_gradient, FILM, FILM.levels(15))
    for pattern in patterns:
        efficiency = d_efficiency(film_gradient(pattern.design.points), film_gradient(best.points))
        assert 0.99999 < efficiency < 1.0001


def test_regions_and_the_fifth_point(patterns):
    criterion = Criterion(film_gradient, FILM, coordinate_function("unit", FILM))
    regions = distinct_support_points(patterns, FILM)
    origins = {tuple(np.round(region.point * 1e6, 2)): region.pattern_names for region in regions}
    assert origins == {
        (5.0, 2.0): ["A", "B"],
        (6.91, 2.0): ["A"],
        (10.0, 0.2): ["A", "B"],
        (5.0, 1.45): ["B"],
    }
    extended = add_corner_points(criterion, regions, 5)
    assert extended[-1].pattern_names == ["augmentation"]
    np.testing.assert_allclose(extended[-1].point, [5e-6, 0.2e-6])


def test_the_determinant_alone_takes_one_scene_twice():
    paper = search_design(Criterion(placed_gradient, PLACED), 5, seed=0)
    centred = paper.points[(paper.points[:, 2] < 1e-5) & (paper.points[:, 1] > 1.99e-6)]
    scenes = coordinate_function("scene", PLACED)
    assert pair_distances(scenes(paper.points)).min() < 1e-3
    assert len(centred) >= 2
    assert paper.value == pytest.approx(TAKEN_TWICE, rel=1e-3)


def test_distinct_scenes_cost_little_information():
    scenes = coordinate_function("scene", PLACED)
    criterion = Criterion(placed_gradient, PLACED, separation_coordinates=scenes, separation=0.25)
    found = search_design(criterion, 5, seed=0)
    assert pair_distances(scenes(found.points)).min() > 0.25 - 1e-8
    places = PLACED.levels(7)
    apart = {"coordinates": scenes(places), "separation": 0.25}
    best = local_descent(
        criterion, places[exact_design_by_exchange(placed_gradient(places), 5, **apart)]
    )
    assert (best.value / found.value) ** (1 / 5) >= 0.999
    assert 0.97 < (TAKEN_TWICE / found.value) ** (1 / 5) < 0.999
