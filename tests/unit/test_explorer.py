"""The explorer's page holds what it was given, whole, and names nothing outside of itself."""

import json
import re

import pandas as pd
import pytest
from reference_forces import FOUR_FACTOR_THETA

from reporting.explorer import Study, explorer_page
from reporting.explorer.modulation import modulation
from reporting.pages.notes import Inertia
from squeezefilm.cli import main as cli
from squeezefilm.io.errors import InputError
from squeezefilm.models.fit_file import read_fit

LIBRARY = "/* the drawing library */"


@pytest.fixture(scope="module")
def page(study):
    return explorer_page(_study(study), drawing_library=LIBRARY)


def _study(study, **changes) -> Study:
    names = ("two_factor_design", "four_factor")
    values = {
        "name": "test",
        "fits": {name: read_fit(study.root / f"fits/{name}.json") for name in names},
        "plans": {name: name for name in names},
        "forces": {
            name: pd.read_csv(study.root / f"simulations/{name}/forces.csv")
            for name in ("screen", "four_factor")
        },
        "force_n": 1.0,
        "h0_m": 5e-6,
        "hv_m": 2.2e-6,
        "inertia": Inertia(1e10, "inertia neglected"),
    }
    return Study(**(values | changes))


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
        assert fit["interval"] == json.loads(json.dumps(interval.to_dict()))
        assert fit["statement"] == interval.statement
    assert two["interval"]["ranges"]["phi_r_m"] == [0.0, 0.0]


def test_nothing_is_left_to_fill_in_and_nothing_comes_from_elsewhere(page):
    assert LIBRARY in page
    assert not re.search(r"\{\{\w+\}\}", page)
    assert not re.search(r"<(script|img|iframe|link)\b[^>]*(src|href)=\"(?!data:)", page)
    assert not re.search(r"\b(fetch|XMLHttpRequest|import)\s*\(|url\(|@import", page)
    assert "default-src 'none'" in page


def test_a_text_cannot_end_the_data(study):
    forces = pd.read_csv(study.root / "simulations/screen/forces.csv")
    page = explorer_page(_study(study, forces={"</script>": forces}), drawing_library="")
    assert _data(page)["plans"] == ["</script>"]


def test_a_fit_that_the_page_cannot_compute_with_is_refused(study):
    fit = read_fit(study.root / "fits/four_factor.json")
    plans = {"mine": "four_factor"}
    short = type(fit)(**(vars(fit) | {"theta": (1.0, 2.0)}))
    with pytest.raises(InputError, match="theta"):
        explorer_page(_study(study, fits={"mine": short}, plans=plans), drawing_library="")
    strange = type(fit)(**(vars(fit) | {"model": 'x"]; evil()'}))
    with pytest.raises(InputError, match="is unknown; known are"):
        explorer_page(_study(study, fits={"mine": strange}, plans=plans), drawing_library="")
    with pytest.raises(InputError, match="at least one fit"):
        explorer_page(_study(study, fits={}), drawing_library="")


def test_the_command_writes_the_page(study, tmp_path, refused):
    fit = f"{study.root}/fits/screen.json"
    forces = f"screen={study.root}/simulations/screen/forces.csv"
    target = tmp_path / "explorer.html"
    words = ["--config", str(study.config), "--output", str(target)]
    refusal = tmp_path / "limit_9.json"
    refusal.write_text('{"model": "limit_9", "refused": "t0, t1 cannot be told apart"}')
    assert cli.main(["explorer", fit, str(refusal), "--forces", forces, *words]) == 0
    text = target.read_text(encoding="utf-8")
    assert "two factors, 60 simulations (screen)" in text
    assert "Plotly" in text
    assert _data(text)["left_out"] == {"limit_9": "t0, t1 cannot be told apart"}
    assert "two fits bear the same name" in refused(
        "explorer", fit, fit, "--forces", forces, *words
    )
    assert "is not NAME=PATH" in refused(
        "explorer", fit, "--forces", forces.partition("=")[2], *words
    )


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
    assert modulation(films, pd.concat([gains, fast]))["films"][0]["gain"] == [1.9, None]
    known, thick, refused = modulation(films, gains)["films"]
    assert (known["corner_hz"], known["gain"], known["error"]) == (400.0, [1.9], 0.01)
    assert thick["why"] == "the film is not slow"
    assert refused["why"] == "an ellipse"
    without_any = gains.assign(gain=float("nan"), status="two phases")
    assert modulation(films, without_any)["films"][0]["why"] == "two phases"
    with pytest.raises(InputError, match="different films"):
        modulation(films, gains.iloc[:2])
