"""The paper's study beside the one with inertia: what is compared, when its conclusion holds."""

import numpy as np
import pandas as pd
import pytest

from paper.equations import CONDITIONS, FITS, compare, survives
from reporting.results import Results
from squeezefilm.config.loading import load_config
from squeezefilm.errors import InputError

MORE = 1.02
"""Forces of the other study, over those of the first."""


@pytest.fixture(scope="module")
def other(study, tmp_path_factory):
    """The same study with every force of the screen and the plan larger by one factor."""
    root = tmp_path_factory.mktemp("other")
    results = study.changed(root, "designs/two_factor.csv", lambda table: table)
    for plan in ("screen", "four_factor", "extrapolation"):
        file = f"simulations/{plan}/forces.csv"
        table = pd.read_csv(root / file)
        table.assign(force_n=MORE * table["force_n"]).to_csv(root / file, index=False)
    return results


@pytest.fixture
def table(study, other):
    return compare(study.results, other)


def value(table: pd.DataFrame, part: str, quantity: str, column: str = "with_inertia") -> float:
    rows = table[(table["part"] == part) & (table["quantity"] == quantity)]
    assert len(rows) == 1
    return float(rows[column].iloc[0])


def test_the_study_with_inertia_is_the_papers_but_for_that(repository):
    paper, inertia = (
        load_config(repository / "config" / f"{name}.yaml") for name in ("paper", "paper-inertia")
    )
    assert inertia["study"] == "paper-inertia"
    assert inertia["gas"] == {**paper["gas"], "inertia": "included"}
    for section in set(paper) | set(inertia):
        if section not in ("study", "gas"):
            assert inertia[section] == paper[section], section


def test_every_parameter_stands_beside_the_other_once(table, study):
    assert not table.duplicated(["part", "quantity"]).any()
    for name, part in FITS.items():
        for index, theta in enumerate(study.results.fit(name).theta):
            assert value(table, part, f"θ{index}") == theta
    assert (table["unit"] != "").all()


def test_a_fit_to_one_equation_is_judged_by_the_forces_of_the_other(table):
    part = "the paper's equation judged by forces with inertia"
    largest = value(table, part, "worst relative error of the forces themselves, screen")
    assert largest == pytest.approx(100 * (1 - 1 / MORE), rel=1e-9)
    for which in ("least", "largest"):
        change = value(table, part, f"{which} change of a force, screen")
        assert change == pytest.approx(100 * (MORE - 1), rel=1e-9)
    judged = f"global error, fit to {FITS['screen']}"
    assert value(table, part, judged, "paper_equation") == pytest.approx(0.533, abs=1e-3)
    assert value(table, part, judged) > 1.7


def test_points_of_one_gap_but_for_rounding_keep_their_order(study, other):
    path = other.folder / "designs/two_factor.csv"
    points = pd.read_csv(path)
    middle = np.isclose(points["hv_m"], 1.45e-6)
    assert middle.sum() == 1
    points.assign(h0_m=points["h0_m"] + 4e-17 * middle).to_csv(path, index=False)
    again = compare(study.results, other)
    amplitudes = again["quantity"].str.fullmatch(r"point \d hv")
    mine, theirs = (again.loc[amplitudes, name] for name in ("paper_equation", "with_inertia"))
    assert np.allclose(mine, theirs)
    assert len(mine) == 15


def test_the_conclusion_falls_with_any_of_its_conditions(table):
    assert survives(table, column="with_inertia")
    assert [largest for *_, largest in CONDITIONS] == [4.6, 15, 4.5]
    for part, quantity, largest in CONDITIONS:
        worse = table.copy()
        row = (worse["part"] == part) & (worse["quantity"] == quantity)
        worse.loc[row, "with_inertia"] = 1.01 * largest
        assert not survives(worse, column="with_inertia")


def test_the_script_writes_table_and_pages(study, other, script, tmp_path):
    names = {"csv": "t.csv", "markdown": "t.md", "page": "t.html"}
    output = {key: tmp_path / name for key, name in names.items()}
    sides = {"sides": [study.root, other.folder]}
    script("equations", study.config, input={}, output=output, params=sides)
    table, text = pd.read_csv(output["csv"]), output["markdown"].read_text(encoding="utf-8")
    assert "**survives**" in text
    assert text.count("\n| ") == len(table) + 2 * (table["part"].nunique() + 1) + 3
    assert output["page"].read_text(encoding="utf-8").count("<tr>") == text.count("\n| ") - (
        table["part"].nunique() + 1
    )


def test_a_study_that_is_not_made_is_named(study, tmp_path):
    with pytest.raises(InputError, match=r"forces\.csv"):
        compare(study.results, Results(tmp_path, study.results.config))
