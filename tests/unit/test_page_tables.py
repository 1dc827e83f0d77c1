"""Tables on pages for people have their verdict first and their columns in words."""

from itertools import pairwise
from types import SimpleNamespace

import pandas as pd
import pytest

from squeezefilm.cli import main as cli
from squeezefilm_workflow.paper import uncertainty
from squeezefilm_workflow.reporting import models, summary
from squeezefilm_workflow.reporting.notes import claim_verdict_counts
from squeezefilm_workflow.reporting.pages import html_of_markdown, render_template


def heads(markdown):
    """Return the columns of a page's tables."""
    lines = markdown.splitlines()
    return [
        line.strip("| ").split(" | ")
        for line, below in pairwise(lines)
        if below.startswith("| ---")
    ]


def test_the_claims_have_their_verdict_beside_them():
    claim = {"claim_id": "a", "claim": "force", "paper": "1", "ours": "2", "unit": "N"}
    claim |= {"kind": "result", "verdict": "differs because", "explanation": "long"}
    claims = pd.DataFrame([claim, claim | {"kind": "setting", "verdict": "agrees exactly"}])
    counts = claim_verdict_counts(claims)
    page = render_template("claims.md", claims=claims, variant="", **counts)
    assert [head[:2] for head in heads(page)] == 2 * [["claim", "verdict"]]
    assert '<td class="bad">differs' in html_of_markdown(page)
    assert "0 of 1 results of the paper agree; 1 of 1 settings" in page
    assert "variant" not in page
    assert "variant" in render_template("claims.md", claims=claims, variant="another pad", **counts)
    assert page.index("differs because") < page.index("## Settings") < page.index("agrees exactly")


def test_assumptions_are_told_by_difference_with_their_verdict_first(monkeypatch):
    row = {"claim_id": "a", "claim": "force at rest", "paper_n": 0.99, "ours_n": 0.96}
    row |= {"assumption": "amplitude", "unit": "µm", "assumed": 2.2, "plausible_lower": 2.15}
    row |= {"plausible_upper": 2.25, "force_lower_n": 0.9, "force_upper_n": 1.0}
    row |= {"needed": float("nan"), "reached_lower_n": 0.1, "reached_upper_n": 5.0}
    rows = [row | {"verdict": verdict, "because": "digits"} for verdict in ("explains", "cannot")]
    monkeypatch.setattr(uncertainty, "assumptions_table", lambda config, forces: pd.DataFrame(rows))
    monkeypatch.setattr(uncertainty, "solver_settings", lambda config, outputs: None)
    page = render_template(
        "uncertainty.md",
        **uncertainty.uncertainty_page(SimpleNamespace(config=None)).template_values,
    )
    (columns,) = heads(page)
    assert columns[:2] == ["assumption", "verdict"]
    assert "## Force at rest" in page
    assert "1 of 2 assumptions explains" in page
    assert "| amplitude (µm) | explains | 2.2 | 2.15 to 2.25 | 0.9 to 1 | – |" in page


@pytest.mark.parametrize(
    ("error", "order"), [(0.0204, ["short", "long", "worse"]), (0.03, ["long", "short", "worse"])]
)
def test_a_model_with_fewer_parameters_is_recommended_within_five_percent(error, order):
    """`limit_2` was for 1.02 times less error, with a parameter of 114 in −29 … 258."""
    rows = [("worse", 5, 0.04), ("long", 2, 0.02), ("short", 1, error)]
    table = pd.DataFrame(rows, columns=["model", "parameters", "validation_error"])
    assert list(models.ranked_models(table)["model"]) == order


def test_models_have_their_verdict_first_and_columns_in_words():
    row = {"parameters": 3, "fit_points": 9, "fit_error": 0.01, "cv_error": float("nan")}
    row |= {"validation_points": 50, "validation_failed": 0, "validation_worst_relative": 0.3}
    row |= {"validation_worst_n": 0.1, "error_95_percent": 2.0, "coverage": 0.95}
    row |= {"error_95_without_scan_percent": 0.4}
    row |= {"coverage_min": 0.9, "coverage_min_region": "high third of the gap h0"}
    errors = {"worse": 0.04, "long": 0.02, "short": 0.02, "unknown": float("nan")}
    table = pd.DataFrame(
        [row | {"model": name, "validation_error": error} for name, error in errors.items()]
    )
    table.loc[table["model"] == "short", "parameters"] = 1
    shown = models.shown_models_table(models.ranked_models(table))
    assert list(shown.columns[:3]) == ["model", "verdict", "global error"]
    assert list(shown["model"]) == ["short", "long", "worse"]
    assert list(shown["verdict"]) == ["recommended", "1 times the error", "2 times the error"]
    assert not any("_" in name for name in shown.columns)
    assert shown["95 % error, median"].iloc[0] == "2.0 %, 0.40 % without the scan"
    assert shown["global error"].iloc[0] == "2 %"
    assert shown["least coverage"].iloc[0] == "90 %, high third of the gap h0"
    none_validated = table[table["model"] == "unknown"]
    assert list(models.shown_models_table(models.ranked_models(none_validated)).columns) == list(
        shown.columns
    )


def test_the_summary_names_the_plans_and_points_of_a_recommended_model(tmp_path):
    """`recommended: limit_1 on two_factor` named a space among plans, and `worst` had no plan."""
    (tmp_path / "models").mkdir()
    (tmp_path / "models/recommended.csv").write_text(
        "space,model,fit_points,validation_points,validation_error,simulations,worst_error\n"
        "two_factor,limit_1,64,500,0.0015,2125,0.031\n"
    )
    results = models.Results(tmp_path, SimpleNamespace(paper=False))
    (row,) = summary._recommended_model_rows(results)
    assert row["model fitted on"] == "screen (64 points), recommended: limit_1"
    assert row["compared on"] == "validation_two_factor (500 points)"
    assert row["worst"].endswith("_four_factor, four_factor: 2125 points)")


@pytest.mark.parametrize("word", ["recommended", "explains"])
def test_a_verdict_that_is_good_is_coloured(word):
    assert f'<td class="good">{word}' in html_of_markdown(f"| a |\n| --- |\n| {word} |\n")


def test_of_results_that_are_not_there_those_that_are_have_their_names(tmp_path, refused):
    """It was a configuration file that is missing."""
    for name in ("my-actuator", "paper"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "study.yaml").touch()
    error = refused("recommend", tmp_path / "my_actuator")
    assert f"there are no such results; there are {tmp_path}/my-actuator, {tmp_path}/paper" in error


@pytest.fixture
def recommend(monkeypatch, tmp_path):
    """The exit status of `recommend` where a table has the models that are recommended."""

    def command(table: pd.DataFrame) -> int:
        results = models.Results(tmp_path, None)
        monkeypatch.setattr(models.Results, "of_folder", lambda *_: results)
        monkeypatch.setattr(models, "recommendation_table", lambda _: table)
        return cli.main(["recommend", str(tmp_path)])

    return command


def test_recommended_errors_are_shown_in_percent_as_on_the_pages(recommend, tmp_path, capsys):
    """0.06174 stood beside a page's 5.13 %, of fewer points."""
    row = {"space": "two_factor", "model": "bump", "validation_error": 0.0076, "simulations": 48}
    row |= {"worst_error": 0.06174, "h0_m": 5e-6, "hv_m": 1e-6, "force_n": 0.3}
    assert recommend(pd.DataFrame([row, row])) == 0
    told = capsys.readouterr().out.splitlines()
    assert told.pop() == f"fit of two_factor: {tmp_path}/models/two_factor/bump.json"
    header, values, *_ = map(str.split, told)
    shown = dict(zip(header, values, strict=True))
    assert float(shown["worst_error_percent"]) == pytest.approx(6.174)
    assert float(shown["validation_error_percent"]) == pytest.approx(0.76)
    assert shown["simulations"] == "48"
    assert not {"worst_error", "validation_error"} & set(header)


def test_recommended_amplitudes_stand_by_space_and_then_by_size(recommend, capsys):
    """The centre's amplitude lay between the least and the largest of the pad anywhere."""
    rows = [("two_factor", 2e-6), *[("four_factor", hv_m) for hv_m in (3e-6, 1.5e-6, 1e-6)]]
    table = pd.DataFrame(rows, columns=["space", "hv_m"]).assign(model="bump", h0_m=5e-6)
    table = table.assign(validation_error=0.01, worst_error=0.02)
    assert recommend(table) == 0
    header, *shown = map(str.split, capsys.readouterr().out.splitlines()[:-2])
    amplitudes = [(row[0], float(row[header.index("hv_m")])) for row in shown]
    assert amplitudes == [("two_factor", 2e-6), ("four_factor", 1e-6), ("four_factor", 3e-6)]


def test_a_target_force_that_no_model_gives_is_an_error_after_the_table(recommend, capsys):
    rows = [{"space": space, "model": "bump"} for space in ("two_factor", "four_factor")]
    table = pd.DataFrame(rows).assign(h0_m=5e-6, hv_m=float("nan"), force_n=30.0, note="too large")
    table = table.assign(validation_error=0.01, worst_error=0.02)
    assert recommend(table) == 1
    told = capsys.readouterr()
    assert told.out.count("bump") == 4
    assert "no recommended model gives 30 N at h0 = 5 µm" in told.err
    # One position out of reach is a note of its row.
    assert models.missing_amplitude_text(table.assign(hv_m=[float("nan"), 2e-6])) == ""
