"""The explorer's page holds what it was given, whole, and names nothing outside of itself."""

import json
import re

import pandas as pd
import pytest
from reference_forces import FOUR_FACTOR_THETA

from reporting.explorer import Models, explorer_page, models_of

LIBRARY = "/* the drawing library */"


@pytest.fixture(scope="module")
def page(study):
    return made(study)


def made(study, models: Models | None = None, plans=("screen", "four_factor")) -> str:
    results = study.results
    models = models or models_of(results, fits=["two_factor_design", "four_factor"], candidates=[])
    forces = {plan: results.forces(plan) for plan in plans}
    return explorer_page(results.config, models, forces, drawing_library=LIBRARY)


def _data(page: str):
    return json.loads(re.search(r'id="data">(.*?)</script>', page)[1])


def test_models_and_forces_are_on_the_page_to_the_last_digit(page, study):
    data = _data(page)
    two, four = data["fits"]
    assert two["factors"] == ["h0_m", "hv_m"]
    assert not two["moves"]
    assert four["factors"] == ["h0_m", "hv_m", "phi_r_m", "phi_deg"]
    assert four["moves"]
    for theta in ((7.8081, 1.83310, -1.000213), FOUR_FACTOR_THETA):
        numbers = " ".join(f"({each!r})," if each < 0 else f"{each!r}," for each in theta)
        assert numbers in " ".join(page.split())
    screen = pd.read_csv(study.root / "simulations/screen/forces.csv")
    plan = [row for row in data["simulations"] if data["plans"][row[0]] == "screen"]
    assert [row[5] for row in plan] == list(screen["force_n"])
    assert [row[1:3] for row in plan] == screen[["h0_m", "hv_m"]].to_numpy().tolist()


def test_nothing_is_left_to_fill_in_and_nothing_comes_from_elsewhere(page):
    assert LIBRARY in page
    assert not re.search(r"\{\{\w+\}\}", page)
    assert not re.search(r"<(script|img|iframe|link)\b[^>]*(src|href)=\"(?!data:)", page)
    assert not re.search(r"\b(fetch|XMLHttpRequest|import)\s*\(|url\(|@import", page)
    assert "default-src 'none'" in page


def test_a_text_cannot_end_the_data(study):
    results = study.results
    models = models_of(results, fits=["screen"], candidates=[])
    forces = {"</script>": results.forces("screen")}
    page = explorer_page(results.config, models, forces, drawing_library="")
    assert _data(page)["plans"] == ["</script>"]


def test_a_candidate_that_was_refused_is_named_with_the_reason(study, tmp_path):
    results = study.changed(tmp_path, "designs/two_factor.csv", lambda table: table)
    (tmp_path / "models/four_factor").mkdir(parents=True)
    refusal = '{"model": "limit_9", "refused": "t0, t1 cannot be told apart"}'
    (tmp_path / "models/four_factor/limit_9.json").write_text(refusal)
    page = made(study, models_of(results, fits=["screen"], candidates=["limit_9"]))
    assert "two factors, 60 simulations (screen)" in page
    assert _data(page)["left_out"] == {"limit_9": "t0, t1 cannot be told apart"}
