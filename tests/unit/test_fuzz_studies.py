"""Studies with anything wrong in them are read, or refused in words: a file's and the library's.

Mutations are drawn with fixed seeds: a failure comes again.
"""

import copy
import random
from pathlib import Path

import pytest
import yaml

from squeezefilm import Film
from squeezefilm.config.loading import parse_config, validated_sections
from squeezefilm.config.study import Study
from squeezefilm.errors import InputError

PROFILES = [
    {"kind": "formula", "expression": "cos(k*x)", "constants": {"k": "100 1/m"}},
    {"kind": "standing-wave", "wavelength": "12 mm"},
    {"kind": "bessel", "wave_number": 100},
    {"kind": "measured", "file": "plate.csv"},
]
NAMES = ["formula", "kind", "sinc", "KIND", "[key]", "lenght_x", "h0_m", "contour", "surface"]
VALUES = [None, True, 0, -1.5, float("nan"), 10**400, "", "x", "5 mm", "\x00", [], [[1]], {}]
VALUES += [{"a": 1}, {"kind": "formula"}, {"kind": None}, {"kind": "sinc", "sinc": 1}]
# What YAML has no word for, or our reader refuses by itself.
OTHER_NAMES = [1, None, 1.5, (1,), b"a"]
OTHER_VALUES = [(1, 2), {1, 2}, b"x", 1j, object(), Path("a"), {1: {"kind": "formula"}}]


def containers(values):
    """The mappings and lists in a value that have something in them."""
    if isinstance(values, dict | list) and values:
        yield values
        for inner in values.values() if isinstance(values, dict) else values:
            yield from containers(inner)


def mutated(study: dict, draw: random.Random, *, from_file: bool) -> dict:
    """A study with up to three things done to it."""
    study = copy.deepcopy(study)
    if draw.random() < 0.3:
        study["actuator"]["profile"] = copy.deepcopy(draw.choice(PROFILES))
    for _ in range(draw.randint(1, 3)):
        section = draw.choice(list(containers(study)) or [study])
        keys = list(section) if isinstance(section, dict) else list(range(len(section)))
        what, value = draw.randrange(4), draw.choice(VALUES + OTHER_VALUES * (not from_file))
        if what == 0 and keys:
            del section[draw.choice(keys)]
        elif what == 1 and isinstance(section, dict):
            section[draw.choice(NAMES + OTHER_NAMES * (not from_file))] = copy.copy(value)
        elif keys:
            section[draw.choice(keys)] = copy.copy(value)
    return study


@pytest.mark.parametrize("source", ["file", "sections", "film"])
def test_a_study_is_read_or_refused(source, repository):
    draw = random.Random(source)
    texts = [path.read_text("utf-8") for path in sorted((repository / "config").glob("*.yaml"))]
    studies = list(map(yaml.safe_load, texts))
    messages = []
    for _ in range(150):
        values = mutated(draw.choice(studies), draw, from_file=source == "file")
        try:
            if source == "file":
                parse_config(yaml.safe_dump(values, allow_unicode=True), path=Path("study.yaml"))
            elif source == "sections":
                validated_sections(values, path=Path("study"), model=Study)
            else:
                named = ("gas", "actuator", "pad", "solver")
                Film.of(**{name: values.get(name) for name in named})
        except InputError as refusal:
            messages.append(f"{refusal}\n")
    assert len(messages) > 50
    assert not [message for message in messages if "allowed are \n" in message]


@pytest.mark.parametrize(
    ("profile", "message"),
    [
        ({"kind": "formula", "formula": "x"}, "profile: missing 'expression' (text): arithmetic"),
        ({"kind": "formula", "formula": "x"}, "unknown key 'formula'; allowed are constants, exp"),
        ({"kind": "piston", "piston": {}}, "profile: unknown key 'piston'; allowed are kind"),
        (
            {"kind": "formula", "expression": "x", "constants": {"a": []}},
            "profile.constants.a: [] should be a valid string; allowed: text or a number",
        ),
        ({"kind": "piston", 1: 2}, "actuator.profile.1: the key 1 is not text"),
    ],
)
def test_a_profile_is_refused_by_its_key(profile, message):
    actuator = {"frequency": 43e3, "surface_radius": 0.01, "profile": profile}
    with pytest.raises(InputError) as refusal:
        Film.of(actuator=actuator, pad={"length_x": 0.01, "length_y": 0.01})
    assert message in str(refusal.value)
