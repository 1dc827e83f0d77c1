"""The table of keys in config/README.md says what the schema says."""

import copy
import re

import pytest

from squeezefilm.io.errors import InputError
from squeezefilm.studies import schema as schemas
from squeezefilm.config.loading import load_config
from squeezefilm.studies.keys import key_table, with_key_table

UNITS = {"pa_s": "Pa s", "pa": "Pa", "hz": "Hz", "deg": "°", "n": "N", "m": "m"}
"""What the end of a key's name says, and the unit that goes with it."""


@pytest.fixture
def schema():
    return copy.deepcopy(schemas.schema())


def rows(table: str) -> list[list[str]]:
    return [re.split(r" (?<!\\)\| ", line.strip("| ")) for line in table.splitlines()[2:]]


def test_the_table_is_what_the_schema_makes_it(repository, schema):
    text = (repository / "config" / "README.md").read_text(encoding="utf-8")
    assert with_key_table(text, schema) == text, "config/README.md: `make keys` makes it anew"


def test_every_key_of_a_study_has_one_row_of_its_section(repository, schema):
    explained: dict[str, list[str]] = {}
    for row in rows(key_table(schema)):
        if row[0].startswith("**"):
            section = explained.setdefault(row[0].strip("*`"), [])
        else:
            section.append(row[0].strip("`"))
    for section, values in load_config(repository / "config" / "paper.yaml").items():
        keys = values if isinstance(values, dict) else {}
        assert section in explained
        assert [explained[section].count(key) for key in keys] == [1] * len(keys), section


def test_a_key_without_a_description_and_a_text_without_the_marks_are_refused(schema):
    with pytest.raises(InputError, match="between the lines"):
        with_key_table("# Studies\n", schema)
    del schema["properties"]["gas"]["properties"]["viscosity_pa_s"]["description"]
    with pytest.raises(InputError, match=r"gas\.viscosity_pa_s has no description"):
        key_table(schema)


def test_a_key_s_unit_is_that_of_its_name(schema):
    for key, unit, *_ in rows(key_table(schema)):
        for end, expected in UNITS.items():
            if re.search(rf"(?<!per)_{end}`", key) and not re.search(r"_per_m", key):
                assert unit == expected, key
                break
