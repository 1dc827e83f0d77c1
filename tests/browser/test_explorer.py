"""The explorer shows what the library computes."""

import json
import re
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.support.ui import Select

from squeezefilm.config.loading import load_config
from squeezefilm.dynamics.response import force_response, modulation_gains
from squeezefilm.errors import InputError
from squeezefilm.models.data import Factors
from squeezefilm.models.fit_file import FittedModel, amplitude_for_force, read_fit
from squeezefilm.studies.study import scene_of_study
from squeezefilm.tables import FACTOR_COLUMNS, read_ok_forces
from squeezefilm.units import value_and_error_texts

from .conftest import Browser

EXACT = 1e-9
SHOWN_UNIT = {"h0": 1e-6, "hv": 1e-6, "phi-r": 1e-3, "phi-phi": 1.0, "target": 1.0}
FACTOR = dict(zip(("h0", "hv", "phi-r", "phi-phi"), FACTOR_COLUMNS, strict=True))
# A value and its error, in the page's units.
RESULT_ROW = [(0.962042, 6e-7), (0.9613, 0.0031), (-3.26, 0.4), (42.4, 3.0), (1234.0, 20.0)]
FITS = (
    "two_factor_design",
    "screen",
    "four_factor",
    "four_factor_design",
    "four_factor_design_distinct",
)
CANDIDATES = ("polynomial_5 on four_factor", "limit_2 on four_factor")


class Explorer:
    """The page, by what a reader does with it."""

    def __init__(self, browser: Browser, results: Path) -> None:
        self.browser, self.results = browser, results

    def element(self, name: str):
        return self.browser.driver.find_element(By.ID, name)

    def text(self, name: str) -> str:
        return self.element(name).text.replace("−", "-").replace("\N{NO-BREAK SPACE}", " ")

    def choose(self, fit: str) -> None:
        Select(self.element("fit")).select_by_value(fit)

    def type(self, **values: float) -> None:
        """Type values, in the shown units, into the boxes beside the sliders."""
        for name, value in values.items():
            box = self.element(f"{name.replace('_', '-')}-number")
            box.send_keys(Keys.CONTROL, "a")
            box.send_keys(repr(value), Keys.TAB)

    def factors(self) -> dict[str, float]:
        """Where the sliders stand, in SI units."""
        return {
            factor: float(self.element(f"{name}-number").get_attribute("value")) * SHOWN_UNIT[name]
            for name, factor in FACTOR.items()
        }

    @property
    def force_n(self) -> float:
        """The number behind what a reader sees, which has the digits that its error leaves."""
        number = float(self.element("force").get_attribute("data-newtons"))
        shown = re.match(
            r"(-?\d+\.?(\d*)) N( ± [\de.-]+ N| \(error not known\))$", self.text("force")
        )
        assert shown, self.text("force")
        assert float(shown[1]) == pytest.approx(number, rel=0, abs=0.501 * 10 ** -len(shown[2]))
        return number

    def fit(self, name: str) -> FittedModel:
        model, _, plan = name.partition(" on ")
        place = f"models/{plan}/{model}" if plan else f"fits/{name}"
        return read_fit(self.results / f"{place}.json")

    def library_n(self, name: str) -> float:
        fit = self.fit(name)
        factors = fit.with_asymptotic_forces(Factors.of(**self.factors()))
        return float(fit.force_model.evaluate(fit.theta, factors)[0])


START = {"h0": 5.0, "hv": 2.0, "phi-r": 0.0, "phi-phi": 0.0, "target": 1.0}


@pytest.fixture
def explorer(browser, results):
    """The page as it looks when it is opened; it stays open from test to test."""
    page = results / "explorer.html"
    if browser.in_shown_unit != page:
        browser.open(page)
    browser.run(
        "const say = (e, kind) => e.dispatchEvent(new Event(kind, {bubbles: true}));"
        "const fit = document.getElementById('fit');"
        "fit.selectedIndex = 0; say(fit, 'change');"
        "for (const [name, value] of Object.entries(arguments[0])) {"
        "  const bar = document.getElementById(name); bar.value = value; say(bar, 'input'); }",
        START,
    )
    yield Explorer(browser, results)
    assert browser.complaints() == []
    assert browser.requests() == []


@pytest.mark.parametrize("name", [*FITS, *CANDIDATES])
def test_the_number_shown_is_the_librarys(name, explorer):
    explorer.choose(name)
    random = np.random.default_rng(1)

    def some(low: float, high: float) -> float:
        return round(random.uniform(low, high), 3)

    moved = not explorer.fit(name).force_model.is_for_centred_pad
    for _ in range(3):
        explorer.type(h0=some(5, 10), hv=some(0.2, 2.2))
        if moved:
            explorer.type(phi_r=some(0, 2.9), phi_phi=some(0, 45))
        assert explorer.force_n == pytest.approx(explorer.library_n(name), rel=0, abs=EXACT)


@pytest.mark.parametrize("name", CANDIDATES)
def test_a_region_of_low_coverage_is_stated_where_the_library_states_it(name, explorer):
    explorer.choose(name)
    interval, noted = explorer.fit(name).prediction_interval, []
    for h0, hv in ((5.5, 0.4), (7.5, 1.1), (9.5, 1.9)):
        explorer.type(h0=h0, hv=hv, phi_r=1.2, phi_phi=30.0)
        (notes,) = interval.coverage_notes(Factors.of(**explorer.factors()))
        noted += [notes] * bool(notes)
        for note in filter(None, notes.split("; ")):
            assert note in explorer.text("validation")
        assert ("third of the" in explorer.text("validation")) == bool(notes)
    assert noted or not interval.low_coverage_regions()


@pytest.mark.parametrize("name", [*FITS, *CANDIDATES])
def test_the_gap_and_the_amplitude_under_a_load_are_the_librarys(name, explorer):
    explorer.choose(name)
    fit = explorer.fit(name)
    if not fit.force_model.is_for_centred_pad:
        explorer.type(phi_r=1.2, phi_phi=30.0)
    for hv, load_n in ((1.2, 0.1), (1.9, 0.4)):
        explorer.type(h0=6.0, hv=hv, target=load_n)
        place = {n: v for n, v in explorer.factors().items() if n in ("phi_r_m", "phi_deg")}
        shown = explorer.element("amplitude").get_attribute("data-metres")
        try:
            amplitude_m = amplitude_for_force(fit.evaluate, force_n=load_n, h0_m=6e-6, **place)
        except InputError:
            assert shown == ""
        else:
            assert float(shown) == pytest.approx(amplitude_m, rel=1e-6)
        shown = explorer.element("gap").get_attribute("data-metres")
        gaps_m = np.linspace(*_data(explorer, "fits", name)["gaps_m"], 400)
        wide = gaps_m[gaps_m > (float(shown) * (1 + 1e-6) if shown else 0)]
        excess = fit.evaluate(Factors.of(h0_m=wide, hv_m=1e-6 * hv, **place)) - load_n
        assert (excess < 0).all() or (excess > 0).all()  # the widest such gap, or none
        if shown:
            at = Factors.of(h0_m=float(shown), hv_m=1e-6 * hv, **place)
            assert fit.evaluate(at) == pytest.approx([load_n], rel=1e-6)


def test_the_result_names_its_model_and_what_its_error_is_of(explorer):
    said = explorer.browser.run("return document.querySelector('.answer').innerText").lower()
    assert "mean force by the model two factors (5 design points)" in said
    assert "the error is that of the model against the film equation; the neglected effects" in said


def test_the_page_gives_a_value_the_digits_of_its_error_as_the_library_does(explorer):
    told = explorer.browser.run(
        "return arguments[0].map((each) => toItsError(...each))", RESULT_ROW
    )
    for (value, error), shown in zip(RESULT_ROW, told, strict=True):
        ours = [float(text) for text in value_and_error_texts(value, error)]
        assert [float(text.replace("−", "-")) for text in shown] == ours


def _data(explorer, section, name):
    data = json.loads(explorer.element("data").get_attribute("textContent"))
    return next(each for each in data[section] if each["name"] == name)


def test_modulation_is_that_of_the_films_around_the_point(explorer, results):
    screen = read_ok_forces(results / "simulations/screen/forces.csv")
    config = load_config(results / "study.yaml")
    films = (
        "const data = JSON.parse(document.getElementById('data').textContent).modulation;"
        "return modulationAt(data, {h0_m: arguments[0], hv_m: arguments[1]})"
    )
    row = screen.iloc[len(screen) // 2]
    (shown,) = explorer.browser.run(films, row.h0_m, row.hv_m)["films"]
    scene = scene_of_study(config, row.h0_m, row.hv_m)
    library = force_response(scene)
    for name in ("corner_hz", "static_gain", "instantaneous_gain"):
        assert shown[name] == pytest.approx(getattr(library, name), rel=1e-6)
    frequency_hz = pd.read_csv(results / "simulations/screen/gains.csv")["frequency_hz"].unique()
    found = modulation_gains(scene, frequency_hz)
    assert shown["gain"] == pytest.approx(found.gain, rel=1e-6)
    assert shown["phase_deg"] == pytest.approx(found.phase_deg, rel=1e-6)
    levels = [np.unique(screen[name]) for name in ("h0_m", "hv_m")]
    inside = [0.4 * each[0] + 0.6 * each[1] for each in levels]
    around = explorer.browser.run(films, *inside)["films"]
    assert {(f["h0_m"], f["hv_m"]) for f in around} == {
        (h0_m, hv_m) for h0_m in levels[0][:2] for hv_m in levels[1][:2]
    }
    outside = explorer.browser.run(films, 1.1 * levels[0][-1], inside[1])
    assert outside["films"] == []
    assert outside["why"].startswith("outside")
