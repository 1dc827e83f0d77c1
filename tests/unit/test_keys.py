"""The table of keys in config/README.md says what the models say."""

import re

import pytest

from squeezefilm.config.keys import key_table, schema, with_key_table
from squeezefilm.config.loading import load_config
from squeezefilm.errors import InputError


def rows() -> list[list[str]]:
    table = key_table(schema())
    return [re.split(r" (?<!\\)\| ", line.strip("| ")) for line in table.splitlines()[2:]]


def test_the_table_is_what_the_models_make_it(repository):
    text = (repository / "config" / "README.md").read_text(encoding="utf-8")
    assert with_key_table(text) == text, "config/README.md: `make keys` makes it anew"


def test_every_key_of_a_study_has_one_row_of_its_section(repository):
    explained: dict[str, list[str]] = {}
    for row in rows():
        if row[0].startswith("**"):
            section = explained.setdefault(row[0].strip("*`"), [])
        else:
            section.append(row[0].strip("`"))
    model = load_config(repository / "config" / "paper.yaml").model
    assert model is not None
    for section, values in model.model_dump(by_alias=True, exclude_none=True).items():
        keys = values if isinstance(values, dict) else {}
        assert section in explained
        assert [explained[section].count(key) for key in keys] == [1] * len(keys), section


def test_a_key_without_a_description_and_a_text_without_the_marks_are_refused():
    with pytest.raises(InputError, match="between the lines"):
        with_key_table("# Studies\n")
    gas = {"properties": {"viscosity": {"type": "number"}}, "description": "The gas."}
    with pytest.raises(InputError, match=r"gas\.viscosity has no description"):
        key_table({"properties": {"gas": gas}})
