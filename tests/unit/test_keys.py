"""Each key of a study has a row in the documentation, and its schema takes what a study may."""

import re

import numpy as np
import pytest
from jsonschema import Draft202012Validator

from squeezefilm.config.film import FilmSections
from squeezefilm.config.keys import key_table, schema_of_key, study_schema, unit_of_schema
from squeezefilm.config.loading import STUDY_SECTION_NAMES, load_config
from squeezefilm.config.notes import USUAL_RANGE_AND_INPUT_UNIT, units_of_numbers
from squeezefilm.config.study import Study
from squeezefilm.film.pad import GapShape


def test_every_key_has_a_row():
    for key in ("| **`actuator`** |", "| `profile.wave_number` | 1/m |", "| `gap.tilt_x` | m |"):
        assert key in key_table(study_schema())


def test_the_keys_of_a_study_beside_its_film_are_named():
    assert {*STUDY_SECTION_NAMES} == Study.model_fields.keys() - FilmSections.model_fields.keys()


@pytest.mark.parametrize("name", ["paper", "plate", "levitation"])
def test_names_of_lengths_and_frequencies_have_their_units(repository, name):
    sections = load_config(repository / "config" / f"{name}.yaml").sections_as_dict()
    units = dict(units_of_numbers(sections))
    assert units["actuator", "frequency"] == "Hz"
    assert units["screen", "h0", "start"] == "m"
    for key_path, unit in units.items():
        known = unit_of_schema(schema_of_key(key_path, sections))
        assert unit == known or not {unit, known} & USUAL_RANGE_AND_INPUT_UNIT.keys(), key_path


def test_a_circle_has_a_diameter_instead_of_lengths():
    pad, circle = Draft202012Validator(study_schema()["properties"]["pad"]), {"shape": "circle"}
    assert [pad.is_valid(circle | more) for more in ({"diameter": "30 mm"}, {})] == [True, False]


def test_a_crowned_gap_is_as_its_key_says():
    """On pads that are not square too, where it is no function of the distance."""
    (about,) = re.findall(r"`gap\.crown`.* grows by crown (\(.*?\));", key_table(study_schema()))
    formula = about.replace("²", "**2").replace("2x", "2*x").replace("2y", "2*y")
    sides = {"length_x": 8e-3, "length_y": 2e-3}
    for x, y in ((4e-3, 0.0), (0.0, 1e-3), (1e-3, -1e-3)):
        expected_m = 3e-6 * eval(formula, sides | {"x": x, "y": y})
        rise_m = GapShape(crown_m=3e-6).rise_m(*np.array([0.5 + x / 8e-3, 0.5 + y / 2e-3]))
        assert rise_m == pytest.approx(expected_m)


def test_a_pair_and_an_empty_choice_have_unit_and_values_in_the_table():
    table = key_table(study_schema())
    assert "| `profile.origin` | m | a list: −10 … 10 |" in table
    assert "| `profile.along` |  | `''`, `x`, `y` | `''` |" in table
    assert "| `profile.constants` |  |  | `{}` |" in table
