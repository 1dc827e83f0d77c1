"""A study is read as it is written, or refused with a message that names what is wrong."""

import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import yaml

from squeezefilm.io.errors import InputError
from squeezefilm.studies.config import Config, load_config
from squeezefilm.studies.plan_scenes import scenes_of
from squeezefilm.studies.schema import SCHEMA_PATH
from squeezefilm.studies.study import check_study


@pytest.fixture(scope="module")
def paper(repository):
    return (repository / "config" / "paper.yaml").read_text(encoding="utf-8")


@pytest.fixture
def study(tmp_path):
    def write(text: str) -> Path:
        path = tmp_path / "study.yaml"
        path.write_text(text, encoding="utf-8")
        return path

    return write


def load(path: Path) -> Config:
    """What the rules do before anything runs."""
    return check_study(load_config(path))


@pytest.mark.parametrize("name", ["paper", "quick", "sweep", "vibrometer"])
def test_the_studies_that_come_with_the_workflow_are_valid(repository, name):
    config = load(repository / "config" / f"{name}.yaml")
    assert config["study"] == name
    assert config["gas"]["viscosity_pa_s"] == 1.81e-5


@pytest.mark.parametrize("name", ["paper", "quick", "sweep", "vibrometer"])
def test_every_plan_lies_in_the_screens_ranges_however_they_are_moved(repository, name, tmp_path):
    """Who changes the screen and the wanted point changes them all, the template's user too."""
    text = (repository / "config" / f"{name}.yaml").read_text(encoding="utf-8")
    if name == "vibrometer":
        text = replaced("{start: 5 µm, stop: 10 µm}", "{start: 15 µm, stop: 30 µm}")(text)
        text = replaced("{start: 0.2 µm, stop: 2 µm}", "{start: 0.5 µm, stop: 6 µm}")(text)
    else:
        text = replaced("{start: 5e-6, stop: 10e-6,", "{start: 15e-6, stop: 30e-6,")(text)
        text = replaced("{start: 0.2e-6, stop: 2e-6,", "{start: 0.5e-6, stop: 6e-6,")(text)
        text = replaced("h0_m: 5e-6\n  hv_m: 2.2e-6", "h0_m: 20e-6\n  hv_m: 5e-6")(text)
    (tmp_path / "study.yaml").write_text(text, encoding="utf-8")
    shutil.copy(repository / "config" / "vibrometer.csv", tmp_path)
    config = load_config(tmp_path / "study.yaml")
    for kind in ("screen", "error_map", "four_factor_control", "validation_four_factor"):
        table = scenes_of(kind, config)
        for factor, (low, high) in {"h0_m": (15e-6, 30e-6), "hv_m": (0.5e-6, 6e-6)}.items():
            values = table[factor]
            assert values.min() >= low * (1 - 1e-9), (kind, factor)
            assert values.max() <= high * (1 + 1e-9), (kind, factor)
    assert config["error_map"]["h0_m"]["stop"] == 30e-6


def replaced(old: str, new: str) -> Callable[[str], str]:
    def edit(text: str) -> str:
        assert old in text
        return text.replace(old, new, 1)

    return edit


def added(line: str) -> Callable[[str], str]:
    return lambda text: f"{line}\n{text}"


TOLERANCE = "tolerance: 1e-6"
WRONG = {
    "misspelled key": (
        replaced("viscosity_pa_s", "viscosity_pas"),
        "did you mean 'viscosity_pa_s'",
    ),
    "unknown section": (added("slip: 1"), "top level: unknown key 'slip'"),
    "missing key": (replaced("  frequency_hz: 43270\n", ""), "missing 'frequency_hz' (0.001 …"),
    "missing section": (replaced("study: paper\n", ""), "missing 'study'"),
    "text for a number": (replaced("43270", "fast"), "actuator.frequency_hz: 'fast'"),
    "a gap as long as sound": (
        replaced("43270", "43.27e6"),
        "sound in this gas is 7.9e-06 m long, and over a gap of 1e-05 m",
    ),
    "another unit": (
        replaced("0.010", "10 kHz"),
        "surface_radius_m: '10 kHz' is not of type 'number'; allowed: 1e-6 … 10 m, as a number or "
        "with its unit",
    ),
    "a key without its unit": (
        replaced("frequency_hz: 43270", "frequency: 43270"),
        "is no number with a unit of Hz; or write 'frequency_hz', a number in Hz",
    ),
    "a key with its unit and without": (
        replaced("frequency_hz: 43270", "frequency_hz: 43270\n  frequency: 43.27 kHz"),
        "'frequency' and 'frequency_hz' are one key; write one of them",
    ),
    "not a number": (replaced(TOLERANCE, "tolerance: .nan"), "solver.tolerance: nan"),
    "infinite": (replaced("101325", ".inf"), "ambient_pressure_pa: inf"),
    "an integer beyond a float": (replaced("101325", "9" * 400), "too many digits"),
    "an integer beyond all reading": (replaced("101325", "9" * 5000), "study.yaml"),
    "true for a number": (replaced("43270", "true"), "actuator.frequency_hz: True"),
    "octal": (replaced("43270", "010"), "'010' is not of type 'number'"),
    "underscore": (replaced("43270", "43_270"), "'43_270' is not of type 'number'"),
    "a date": (replaced("43270", "2020-13-45"), "'2020-13-45' is not of type 'number'"),
    "negative": (replaced("43270", "-43270"), "frequency_hz: -43270 is less than the minimum"),
    "a gap without gas": (replaced("{start: 5e-6", "{start: 5e-200"), "screen.h0_m.start"),
    "an empty value": (replaced("frequency_hz: 43270", "frequency_hz:"), "frequency_hz: None"),
    "a list for a section": (
        replaced("solver:\n", "solver: [1, 2]\nsolvers:\n"),
        "solver: [1, 2] is not of type 'object'",
    ),
    "key twice": (added("study: other"), "the key 'study' stands twice"),
    "a key that is a number": (added("1: 2"), "the key 1 is not text"),
    "a key that is a mapping": (added("? {a: 1}\n: 3"), "is not text"),
    "a merge key": (added("<<: {study: other}"), "merge keys are not allowed"),
    "an alias": (added("a: &x [1]\nb: *x"), "aliases are not allowed"),
    "a tag": (added("a: !!python/object:os.system {}"), "not valid YAML"),
    "a broken bracket": (added("a: ["), "not valid YAML"),
    "nesting without end": (added("a: " + "[" * 2000), "study.yaml"),
    "two documents": (added("a: 1\n---"), "not valid YAML"),
    "contact on the screen": (replaced("stop: 2e-6", "stop: 5e-6"), "surface and finger touch"),
    "contact beyond it": (replaced("hv_m: 2.2e-6", "hv_m: 5e-6"), "extrapolation: hv_m must stay"),
    "an error map above the screen": (
        replaced("h0_m: {levels: 41}", "h0_m: {start: 7e-6, stop: 12e-6, levels: 41}"),
        "error_map.h0_m.stop: 1.2e-05 does not suit screen.h0_m, 5e-06 … 1e-05",
    ),
    "a screen that was moved alone": (
        replaced("h0_m: {start: 5e-6, stop: 10e-6,", "h0_m: {start: 15e-6, stop: 30e-6,"),
        "extrapolation.h0_m: 5e-06 does not suit screen.h0_m, 1.5e-05 … 3e-05",
    ),
    "an extrapolation far beyond the screen": (
        replaced("hv_m: 2.2e-6", "hv_m: 3.1e-6"),
        "extrapolation.hv_m: 3.1e-06 does not suit screen.hv_m, 2e-07 … 2e-06, where the models "
        "are fitted; it must lie from 2e-07 to 3e-06",
    ),
    "start above stop": (replaced("start: 0.2e-6", "start: 3e-6"), "start must be below stop"),
    "one level": (replaced("levels: 6}", "levels: 1}"), "1 is less than the minimum of 2"),
    "a position twice": (replaced("[0, 15, 30, 45]", "[0, 15, 15]"), "a value stands twice"),
    "finger off the actuator": (replaced("0.0029]", "0.0031]"), "off the actuator's 10.00 mm disc"),
    "finger larger than it": (replaced("length_x_m: 0.010", "length_x_m: 0.020"), "screen: point"),
    "a gap that closes": (replaced("bulge_m: 0}", "bulge_m: -4e-6}"), "finger touches the surface"),
    "a formula that is a program": (
        replaced("kind: sinc, wave_number_per_m: 109.8", "kind: formula, expression: open('x')"),
        "actuator.profile.expression: column 1",
    ),
    "a formula without a value": (
        replaced("kind: sinc, wave_number_per_m: 109.8", "kind: formula, expression: 1/x"),
        "has no finite value everywhere",
    ),
    "a mode beyond numbers": (
        replaced(
            "kind: sinc, wave_number_per_m: 109.8",
            "kind: bessel, nodal_diameters: 0, wave_number_rad_per_m: 1e6, edge_share: 1, "
            "direction_deg: 0",
        ),
        "has no finite value everywhere",
    ),
    "a scan that is not there": (
        replaced(
            "kind: sinc, wave_number_per_m: 109.8",
            "kind: measured, file: none.csv, axisymmetric: true",
        ),
        "none.csv: there is no such scan",
    ),
    "half a point": (replaced("points: 10000", "points: 0.5"), "0.5 is not of type 'integer'"),
    "a sweep beyond its sequence": (
        replaced("first: 0", "first: 2000000000"),
        "sweep.first: 2000000000 is greater than",
    ),
    "an unknown profile": (replaced("kind: sinc", "kind: wave"), "'wave' is not one of"),
    "a piston with a wave number": (replaced("kind: sinc", "kind: piston"), "wave_number_per_m"),
    "a study that is a path": (replaced("study: paper", "study: ../paper"), "study: '../paper'"),
}


@pytest.mark.parametrize("case", WRONG)
def test_a_wrong_study_is_refused(case, paper, study):
    edit, message = WRONG[case]
    with pytest.raises(InputError) as refusal:
        load(study(edit(paper)))
    assert message in str(refusal.value)
    assert "study.yaml" in str(refusal.value)


@pytest.mark.parametrize("text", ["", "paper", "- a\n- b", "3"])
def test_a_study_is_a_mapping(text, study):
    with pytest.raises(InputError, match="mapping of keys to values"):
        load(study(text))


def test_all_errors_are_told_at_once(paper, study):
    text = replaced("43270", "fast")(replaced(TOLERANCE, "tolerance: 7")(paper))
    with pytest.raises(InputError) as refusal:
        load(study(text))
    assert "frequency_hz" in str(refusal.value)
    assert "solver.tolerance" in str(refusal.value)


def test_a_file_that_cannot_be_read_is_named(tmp_path):
    with pytest.raises(InputError, match="no such configuration file"):
        load(tmp_path / "none.yaml")
    with pytest.raises(InputError, match="cannot be read"):
        load(tmp_path)
    (tmp_path / "latin.yaml").write_bytes("# a\nstudy: für".encode("latin-1"))
    with pytest.raises(
        InputError, match=r"latin\.yaml: line 2: the configuration file must be text"
    ):
        load(tmp_path / "latin.yaml")


def test_line_ends_and_byte_order_mark_do_not_matter(paper, tmp_path):
    path = tmp_path / "study.yaml"
    path.write_bytes(b"\xef\xbb\xbf" + paper.replace("\n", "\r\n").encode())
    plain = tmp_path / "plain.yaml"
    plain.write_text(paper, encoding="utf-8")
    assert dict(load(path)) == dict(load(plain))


@pytest.mark.parametrize(("text", "value"), [("1e-6", 1e-6), ("1.E-6", 1e-6), (".5e-6", 5e-7)])
def test_a_number_may_be_written_with_an_exponent(text, value, paper, study):
    config = load(study(replaced(TOLERANCE, f"tolerance: {text}")(paper)))
    assert config["solver"]["tolerance"] == value


def test_every_mapping_of_the_schema_rejects_unknown_keys():
    schema = yaml.safe_load(SCHEMA_PATH.read_text(encoding="utf-8"))
    assert "$schema" in schema

    def check(part: Any, place: str) -> None:
        if isinstance(part, dict):
            # A section with an `if`, or several in an `allOf`, has its keys listed there.
            choices = {"if", "allOf"} & set(part)
            if "properties" in part and not choices and not place.endswith(".if"):
                assert part["additionalProperties"] is False, place
            for key, value in part.items():
                check(value, f"{place}.{key}")

    check(schema, "schema")
