"""Random studies: what commands state as valid holds against direct solutions."""

from dataclasses import replace

import numpy as np
import pytest

from squeezefilm_workflow.verification import comparisons
from squeezefilm_workflow.verification.comparisons import Comparison, compare_study
from squeezefilm_workflow.verification.random_studies import (
    compare_coverages,
    compare_statements,
    outcome_counts,
)
from squeezefilm_workflow.verification.study_generator import (
    PROBABILITIES_OF_KIND,
    random_study,
    random_study_values,
)

# Of those that take a second or two: plates, discs, pistons, small pads, every flow model.
SEEDS = (2, 3, 11, 22, 24, 29, 36, 38, 43, 46, 57)


def test_nothing_stated_of_random_studies_is_sure_and_wrong():
    table = compare_statements(SEEDS, points=1)
    wrong = table[table["outcome"] == "sure and wrong"]
    assert wrong.empty, wrong[["seed", "command", "quantity", "note"]].to_string()
    counts = outcome_counts(table).set_index("quantity")["within"]
    assert counts["force / N"] >= 8
    assert counts["gap / m"] >= 5
    assert counts["stiffness / (N/m)"] >= 5
    assert counts["inertia / N"] >= 3
    assert counts["rarefaction / N"] >= 1
    assert counts["static gain"] >= 1
    assert counts["force by elements / N"] >= 2


def test_an_error_that_is_stated_too_small_is_found(monkeypatch, tmp_path):
    """A force off by ten times its stated error, and one that is stated as not valid."""
    honest = comparisons.solve_forces

    def wrong(scenes, **how):
        for force in honest(scenes, **how):
            moved = force.force_n + 10 * force.error_n
            solution = replace(force.solution, force_n=moved)
            yield replace(force, solution=solution)

    study = random_study(2, folder=tmp_path)
    first = next(
        each for each in compare_study(study, points=1, seed=2) if each.quantity == "force / N"
    )
    assert first.outcome == "within"
    monkeypatch.setattr(comparisons, "solve_forces", lambda *some, **how: list(wrong(*some, **how)))
    first = next(
        each for each in compare_study(study, points=1, seed=2) if each.quantity == "force / N"
    )
    assert first.outcome == "sure and wrong"
    reserved = replace(first, valid=False)
    assert reserved.outcome == "outside, not stated as valid"


def test_what_has_no_direct_solution_is_not_counted_as_right():
    assert Comparison("simulate", "force / N", 0.0, 1.0, np.nan).outcome == "no direct solution"


def test_prediction_intervals_of_random_studies_hold_their_share_of_fresh_points():
    table = compare_coverages(
        (46, 38), models=("polynomial_3", "limit_1", "polynomial_5"), fresh=200, sample=200
    )
    assert table["seed"].nunique() == 2
    assert len(table) >= 8
    assert set(table["outcome"]) == {"within"}, table[table["outcome"] != "within"].to_string()


def test_a_seed_draws_the_same_study_and_seeds_draw_all_kinds(tmp_path):
    assert random_study_values(7) == random_study_values(7)
    studies = [random_study_values(seed) for seed in range(60)]
    kinds = {each["actuator"]["profile"]["kind"] for each in studies}
    assert kinds == {"bessel", "standing-wave", "travelling-wave", "piston"}
    assert {each["pad"]["shape"] for each in studies} == {"rectangle", "ellipse"}
    assert {each["gas"]["rarefaction"] for each in studies} == {"none", "slip", "fukui-kaneko"}


@pytest.mark.parametrize("kind", PROBABILITIES_OF_KIND)
def test_every_kind_of_study_is_a_configuration(kind, tmp_path):
    assert random_study(3, folder=tmp_path, kind=kind).name == "random-3"
