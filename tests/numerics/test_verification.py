"""The reference and the checks of verification/ are right, and the checks catch faults."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd
import pytest
from physics_facts import SINC_CONVERGED, SPRING_AT_20

from squeezefilm.film.scene import PadPositions
from squeezefilm.reynolds import packing, solve
from squeezefilm.reynolds.device import choose_device
from squeezefilm.reynolds.terms.inertia import Inertia
from squeezefilm.reynolds.terms.term import Term
from squeezefilm.reynolds.terms.thermal import Thermal
from squeezefilm_workflow.verification import run_times
from squeezefilm_workflow.verification.films import (
    CASE_SAMPLE_SLICE,
    PISTON_PROFILE,
    cases_with_groups,
    film_scene,
    outside_region_reason,
)
from squeezefilm_workflow.verification.reference import reference_force
from squeezefilm_workflow.verification.stability import (
    stability_table,
    state_deviations,
    verdict_summary,
)
from squeezefilm_workflow.verification.work_precision import (
    BATCH_SOLVER_NAME,
    OTHER_METHODS,
    OTHER_METHODS_WITH_EFFECTS,
    SOLVER_NAME,
    TIMED_FILMS,
    with_speedup,
    work_precision_table,
)

Fields = dict[str, np.ndarray]
DISC = "disc, thermal effects, Re = 1, σ = 30, ε = 0.5"


@pytest.mark.parametrize(
    ("scene", "force", "rel"),
    [
        *((film_scene("", 0.44, sigma), force, 1e-9) for sigma, force in SINC_CONVERGED.items()),
        (film_scene("", 1e-3, 20.0, profile=PISTON_PROFILE), 1.25e-6 * SPRING_AT_20, 1e-5),
    ],
)
def test_the_reference_gives_known_forces_within_its_uncertainty(scene, force, rel):
    found = reference_force(scene)
    assert found.force == pytest.approx(force, rel=rel)
    assert 0 < found.uncertainty < 1e-11


@pytest.mark.parametrize("kind", ["travelling wave, σ = 20", "tilted, σ = 20", "bulging, σ = 20"])
def test_the_reference_has_the_solver_s_forces_of_any_gap(kind):
    """Elements and the weak form beside collocation: nothing is shared but the equation."""
    (scene,) = (scene for _, scene in cases_with_groups() if scene.point_id == kind)
    found = reference_force(scene, degree=14)
    (solution,) = solve([scene], tolerance=1e-8, method="periodic")
    assert solution.force_n / scene.force_scale_n == pytest.approx(found.force, rel=1e-8)


def test_a_solved_film_passes_the_state_checks_and_a_spoilt_one_does_not():
    scene = film_scene("", 0.4, 20.0, profile=PISTON_PROFILE)
    (found,) = solve([scene], tolerance=1e-6, method="periodic", keep_states=True)
    state = found.states[-1]
    good = state_deviations(scene, state)
    assert good["residual"] < 1e-6
    spoilt = state_deviations(scene, replace(state, unknowns=state.unknowns * 1.01))
    assert min(spoilt.values()) > 2e-3


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
    chosen = [case for case in cases_with_groups() if case[1].point_id in CASES.values()]
    table = stability_table(chosen, device=choose_device())
    failed = set(table.loc[table["verdict"] == "failed", "case"])
    return {name for name, case in CASES.items() if case in failed}


def test_a_sound_solver_fails_no_case():
    assert red() == set()


def spoil_fields(change: Callable[[Fields], None]) -> Callable[..., Fields]:
    """The profile's fields by name, changed before the kernel sees them."""
    sound = packing.profile_fields

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
    monkeypatch.setattr(packing, "profile_fields", spoil_fields(change))
    monkeypatch.setattr(
        PadPositions, "compute_cached", lambda self, find, *of: find(self, *of)
    )  # not kept
    assert red() == expected


def test_what_is_refused_must_be_documented():
    assert outside_region_reason(film_scene("", 0.4, 583.0)) == ""
    assert "contact" in outside_region_reason(film_scene("", 1.0, 583.0))
    assert "bearing" in outside_region_reason(film_scene("", 0.4, 583.0, bearing=1e4))
    touching = ("contact", "tilted until it touches")
    chosen = [case for case in cases_with_groups() if case[1].point_id in touching]
    table = stability_table(chosen, device=choose_device())
    assert set(table["verdict"]) == {"not supported"}
    assert table["reason"].str.startswith("contact: ").all()


def test_a_sample_of_the_cases_has_some_of_every_group():
    assert {group for group, _ in cases_with_groups()} == {
        group for group, _ in cases_with_groups()[CASE_SAMPLE_SLICE]
    }


@pytest.mark.parametrize(
    ("scene", "others"),
    [(TIMED_FILMS[1], OTHER_METHODS), (TIMED_FILMS[4], OTHER_METHODS_WITH_EFFECTS)],
)
def test_every_method_comes_near_the_reference(scene, others):
    table = work_precision_table(
        (scene,), repeats=1, batch=2, longest_seconds=0.1, rungs=2, device=choose_device()
    )
    assert set(table["method"]) == {SOLVER_NAME, BATCH_SOLVER_NAME, *others}
    assert set(table["status"]) == {"ok"}
    assert table.groupby("method")["relative_error"].min().max() < 0.05
    claimed = table[np.isfinite(table["estimated_error"])]
    assert set(claimed["method"]) == {SOLVER_NAME, BATCH_SOLVER_NAME}
    assert (claimed["relative_error"] <= claimed["estimated_error"]).all()
    assert (table["reference_uncertainty"] < 1e-9).all()
    assert (table["cpu_s"] > 0).all()


def test_at_equal_error_the_cheapest_run_that_is_no_worse_counts():
    def row(method: str, error: float, seconds: float, status: str = "ok") -> dict[str, object]:
        numbers = {"relative_error": error, "cpu_s": seconds, "reference_uncertainty": 1e-12}
        return {"case": "film", "method": method, "status": status, **numbers}

    table = pd.DataFrame(
        [
            row(SOLVER_NAME, 1e-3, 0.001),
            row(SOLVER_NAME, 1e-5, 0.004),
            row(SOLVER_NAME, 1e-7, 0.002),
            row(SOLVER_NAME, 1e-8, 0.001, status="refused"),  # does not count
            row("other", 2e-5, 1.0),
            row("other", 1e-9, 9.0),  # nothing of ours is as good
        ]
    )
    found = with_speedup(table)
    assert found["speedup"].to_list() == pytest.approx([np.nan] * 4 + [500, np.nan], nan_ok=True)
    assert found["speedup_in_batch"].isna().all()


@pytest.mark.parametrize(("term", "number"), [(Thermal, "heating"), (Inertia, "lag")])
def test_a_wrong_number_of_the_gas_turns_films_red(term, number, monkeypatch):
    """The solver alone, at a tenth of the tolerance, has the same fault."""
    chosen = [case for case in cases_with_groups() if case[1].point_id == DISC]
    sound = term.equation_numbers

    def wrong(self: Term, scene: Any) -> Any:
        numbers = sound(self, scene)
        return numbers | {number: 1.05 * numbers[number]}

    monkeypatch.setattr(term, "equation_numbers", wrong)
    (row,) = stability_table(chosen, device=choose_device()).itertuples()
    assert row.verdict == "failed"
    assert row.reason.startswith("independent_difference")


def test_a_film_that_steepens_keeps_its_row_and_its_reason():
    steep = film_scene("disc", 0.9, 30.0, reynolds=20.0, thermal=True, shape="ellipse")
    (row,) = stability_table([("", steep)], device=choose_device()).itertuples()
    assert row.verdict == "not supported"
    assert row.reason.startswith("waves that steepen")
    assert "not converged" in row.reason


def test_run_times_are_written_to_the_tables_of_the_pages(repository):
    shown = {path.stem for path in (repository / "docs/data").glob("*.csv")}
    assert set(run_times.TABLE_FUNCTIONS) <= shown


def test_run_times_of_terms_have_every_scene_solved(monkeypatch):
    monkeypatch.setattr(run_times, "TERM_SCENE_COUNT", 2)
    monkeypatch.setattr(run_times, "TERM_PAD_LENGTHS_M", {"disc": 0.04})
    table = run_times.times_by_term()
    assert len(table) == 3
    assert set(table["solved"]) == {2}


def test_a_campaign_s_summary_counts_every_film_once():
    films = pd.DataFrame(
        {
            "case": ["disc, a", "disc, b", "square, a"],
            "modified_reynolds": [1.0, 1.0, 20.0],
            "verdict": ["solved", "not supported", "failed"],
            "finer_difference": [1e-6, np.nan, np.inf],
            "independent_difference": [2e-6, np.nan, np.nan],
        }
    )
    table = verdict_summary(films).set_index("pad")
    assert table[["failed", "not supported", "solved"]].sum(axis=1).to_dict() == {
        "disc": 2,
        "square": 1,
    }
    assert table["compared"].to_dict() == {"disc": 1, "square": 0}
    assert table.loc["disc", "largest independent difference"] == "2.0e-06"
    assert table.loc["square", "largest finer difference"] == "–"
