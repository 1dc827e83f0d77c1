"""The explorer's page holds what it was given, whole, and names nothing outside of itself."""

import json
import re

import pandas as pd
import pytest
from reference_forces import FOUR_FACTOR_THETA

from reporting.explorer import Models, explorer_page, models_of, modulation_of
from squeezefilm.errors import InputError
from squeezefilm.models.fit_file import read_fit

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


def test_a_models_error_on_the_page_is_that_of_its_file(page, study):
    two, four = _data(page)["fits"]
    for fit, name in ((two, "two_factor_design"), (four, "four_factor")):
        interval = read_fit(study.root / f"fits/{name}.json").interval
        assert fit["interval"] == interval.model_dump(mode="json")
        assert fit["statement"] == interval.statement
    assert two["interval"]["ranges"]["phi_r_m"] == [0.0, 0.0]


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


def test_a_fit_that_the_page_cannot_compute_with_is_refused(study):
    fit = read_fit(study.root / "fits/four_factor.json")
    plans = {"mine": "four_factor"}
    short = type(fit)(**(vars(fit) | {"theta": (1.0, 2.0)}))
    with pytest.raises(InputError, match="theta"):
        made(study, Models({"mine": short}, plans))
    strange = type(fit)(**(vars(fit) | {"model": 'x"]; evil()'}))
    with pytest.raises(InputError, match="is unknown; known are"):
        made(study, Models({"mine": strange}, plans))
    with pytest.raises(InputError, match="at least one fit"):
        made(study, Models())


def test_a_candidate_that_was_refused_is_named_with_the_reason(study, tmp_path):
    results = study.changed(tmp_path, "designs/two_factor.csv", lambda table: table)
    (tmp_path / "models/four_factor").mkdir(parents=True)
    refusal = '{"model": "limit_9", "refused": "t0, t1 cannot be told apart"}'
    (tmp_path / "models/four_factor/limit_9.json").write_text(refusal)
    page = made(study, models_of(results, fits=["screen"], candidates=["limit_9"]))
    assert "two factors, 60 simulations (screen)" in page
    assert _data(page)["left_out"] == {"limit_9": "t0, t1 cannot be told apart"}


def test_films_whose_response_is_not_known_say_why():
    films = pd.DataFrame(
        {
            "h0_m": [5e-6, 6e-6, 7e-6],
            "hv_m": 1e-6,
            "status": ["ok", "the film is not slow", "an ellipse"],
            "corner_hz": [400.0, None, None],
            "static_gain": 2.0,
            "prompt_gain": 1.1,
        }
    )
    gains = films[["h0_m", "hv_m"]].assign(
        frequency_hz=10.0, gain=1.9, phase_deg=-1.0, error=[0.01, 0.2, None]
    )
    fast = gains.assign(frequency_hz=4e3, gain=float("nan"), error=float("nan"))
    assert modulation_of(films, pd.concat([gains, fast]))["films"][0]["gain"] == [1.9, None]
    known, thick, refused = modulation_of(films, gains)["films"]
    assert (known["corner_hz"], known["gain"], known["error"]) == (400.0, [1.9], 0.01)
    assert thick["why"] == "the film is not slow"
    assert refused["why"] == "an ellipse"
    without_any = gains.assign(gain=float("nan"), status="two phases")
    assert modulation_of(films, without_any)["films"][0]["why"] == "two phases"
    with pytest.raises(InputError, match="different films"):
        modulation_of(films, gains.iloc[:2])
