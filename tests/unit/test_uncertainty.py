"""What would explain a difference: found by changing one assumption at a time."""

import math

import numpy as np
import pandas as pd
import pytest
from physics_facts import CENTRED_N

from paper import uncertainty
from paper.claims import CLAIMS
from paper.uncertainty import ASSUMPTIONS, compare, differences, shown
from squeezefilm.config.loading import Config
from squeezefilm.errors import RunError
from squeezefilm.film.scene import Scene
from squeezefilm.reynolds.terms.rarefaction import flow_coefficients


def film_like(scene: Scene) -> float:
    """A force that goes with pressure and amplitude as the film's does, and less so with slip."""
    relative = (scene.epsilon / 0.44) ** 2.1 * scene.gas.ambient_pressure_pa / 101_325
    slip = sum(flow_coefficients(scene)[1:])
    return CENTRED_N * relative * (1 - 0.1 * slip) * scene.gas.polytropic_exponent


@pytest.fixture(scope="module")
def tables(paper):
    return compare(paper, force=film_like)


@pytest.fixture(scope="module")
def extrapolated(tables):
    table = tables[0]
    return table[table["claim_id"] == "simulation_at_2.2"].set_index("assumption")


def test_every_assumption_is_tried_on_every_difference(paper, tables):
    assert {each.claim_id for each in differences(paper)} <= set(CLAIMS.index)
    assert len(tables[0]) == len(ASSUMPTIONS) * len(differences(paper))
    assert tables[0]["because"].str.len().min() > 10


def test_the_needed_value_gives_the_papers_force(extrapolated):
    needed = extrapolated["needed"]
    assert needed["ambient pressure"] == pytest.approx(101.325 * 0.99 / CENTRED_N, rel=1e-5)
    assert needed["amplitude"] == pytest.approx(2.2 * (0.99 / CENTRED_N) ** (1 / 2.1), rel=1e-5)
    change = extrapolated["needed_change_percent"]["ambient pressure"]
    assert change == pytest.approx(100 * (0.99 / CENTRED_N - 1), rel=1e-3)


def test_only_a_plausible_value_explains(extrapolated):
    verdicts = extrapolated["verdict"]
    assert verdicts["amplitude"] == "explains"  # 2.2 µm may be 2.15 to 2.25 µm
    assert (verdicts.drop("amplitude") == "cannot explain").all()
    # A pressure would, but not one that is plausible.
    assert np.isfinite(extrapolated["needed"]["ambient pressure"])
    assert extrapolated["force_high_n"]["ambient pressure"] < 0.985
    # What only lowers the force has no value that would.
    slip = extrapolated.loc["mean free path, by slip"]
    assert math.isnan(slip["needed"])
    assert slip["force_low_n"] < slip["force_high_n"] == pytest.approx(CENTRED_N)


def test_curves_pass_through_our_force(tables):
    curves = tables[1]
    ours = curves[(curves["claim_id"] == "simulation_at_2.2")]
    middle = ours[ours["change_percent"].abs() < 1e-9]
    assert len(middle) == ours["assumption"].nunique() == 6
    np.testing.assert_allclose(middle["force_n"], CENTRED_N, rtol=1e-5)


def test_a_film_that_cannot_be_is_passed_over(paper):
    def refusing(scene: Scene) -> float:
        return math.nan if scene.hv_m > 2.3e-6 else film_like(scene)

    table, _ = compare(paper, force=refusing)
    needed = table.set_index(["claim_id", "assumption"])["needed"]
    assert needed["simulation_at_2.2", "ambient pressure"] == pytest.approx(104.27, rel=1e-3)
    assert table["force_low_n"].notna().all()


def test_a_film_that_cannot_be_simulated_at_all_is_named(paper):
    with pytest.raises(RunError, match=r"simulation_at_2\.2: "):
        compare(paper, force=lambda scene: math.nan)


def test_a_study_without_the_assumption_does_without_its_row(paper):
    sections = paper.sections | {"actuator": paper["actuator"] | {"profile": {"kind": "piston"}}}
    table, _ = compare(Config(path=paper.path, sections=sections), force=film_like)
    assert "wave number of the profile" not in set(table["assumption"])
    assert len(table) == 2 * (len(ASSUMPTIONS) - 1)


def test_a_value_that_is_needed_or_none_is_shown(tables):
    needed = shown(tables[0])["needed for the paper's"]
    assert "104.27 kPa (+2.9 %)" in set(needed)
    assert needed.str.contains("no value").any()
    assert not needed.str.contains("nan").any()


def test_every_force_of_the_script_is_the_solver_s(repository, script, tmp_path, monkeypatch):
    """With few values, to be quick."""
    monkeypatch.setattr(uncertainty, "ASSUMPTIONS", ASSUMPTIONS[:1])
    monkeypatch.setattr(uncertainty, "SEARCH_POINTS", 3)
    monkeypatch.setattr(uncertainty, "CURVE_POINTS", 3)
    names = {"csv": "u.csv", "curves": "c.csv", "markdown": "u.md", "page": "u.html"}
    output = {key: tmp_path / name for key, name in names.items()}
    script("uncertainty", repository / "config/quick.yaml", input={}, output=output)
    row = pd.read_csv(output["csv"]).iloc[0]
    assert row["ours_n"] == pytest.approx(CENTRED_N, rel=1e-4)
    assert row["needed"] == pytest.approx(2.2292, rel=1e-3)
    assert row["verdict"] == "explains"
    assert "hv = 2.2 µm: 1; smallest force" in output["markdown"].read_text(encoding="utf-8")
