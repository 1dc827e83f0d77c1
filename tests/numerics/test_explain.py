"""What ``explain`` says is what ``solve`` does."""

from __future__ import annotations

from pathlib import Path

import pandas as pd
import pytest
from films import PISTON, film

from squeezefilm.cli import main
from squeezefilm.reynolds import solve
from squeezefilm.reynolds.explain import explain
from squeezefilm.studies.plans import plan
from squeezefilm.tables import write_table

SCENES = [
    film(epsilon=0.4, sigma=583.0),
    film(epsilon=0.4, sigma=2331.0, x=0.2),
    film(epsilon=0.3, sigma=1000.0, x=0.1, y=0.1, bearing=0.5),
    film(epsilon=0.2, sigma=1e6, profile=PISTON),
    film(epsilon=0.001, sigma=10.0, y=0.2),
    film(epsilon=0.4, sigma=800.0, rarefaction="slip"),
    film(epsilon=0.4, sigma=800.0, polytropic_exponent=1.4),
]


@pytest.mark.parametrize("tolerance", [1e-2, 1e-6])
def test_method_domain_and_what_is_left_out_are_those_of_the_solution(tolerance: float) -> None:
    explanations = explain(SCENES, tolerance=tolerance)
    solutions = solve(SCENES, tolerance=tolerance)
    for explanation, solution in zip(explanations, solutions, strict=True):
        assert solution.status == "ok"
        assert explanation.method == solution.method
        assert "; ".join(part.what for part in explanation.left_out) == solution.left_out
        assert all(part.why for part in explanation.left_out)
        assert explanation.expected_error <= tolerance
        assert explanation.nx <= 2 * solution.nx


def test_expected_cost_is_right_to_a_factor_of_three() -> None:
    scenes = [film(epsilon=epsilon, sigma=1500.0) for epsilon in (0.05, 0.2, 0.44, 0.8)]
    expected = [each.expected_mflop for each in explain(scenes, tolerance=1e-6)]
    spent = [each.work / 1e6 for each in solve(scenes, tolerance=1e-6)]
    for guess, truth in zip(expected, spent, strict=True):
        assert truth / 3 < guess < 3 * truth


def test_terms_are_named_only_where_a_scene_has_them() -> None:
    terms = [explanation.terms for explanation in explain(SCENES, tolerance=1e-6)]
    assert terms[0] == ("squeeze",)
    assert terms[2] == ("squeeze", "bearing")
    assert terms[5] == ("squeeze", "slip")
    assert terms[6] == ("squeeze", "polytropic gas")


def test_command_writes_a_row_per_scene_with_the_notes(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    scenes, output = tmp_path / "scenes.csv", tmp_path / "explained.csv"
    write_table(plan(h0_m=[5e-6, 10e-6], hv_m=[2e-6, 2e-6], phi_r_m=[0.0, 1e-3]), scenes)
    arguments = ["explain", str(scenes), "--config", "config/paper.yaml", "--output", str(output)]
    assert main(arguments) == 0
    table = pd.read_csv(output)
    assert list(table["domain"]) == ["quarter", "half"]
    assert "inertia" in table["notes"][1]
    assert "slip" in table["notes"][0]
    assert "2 scenes at tolerance 1e-06" in capsys.readouterr().out
