"""A study is read as it is written, or refused with a message that names what is wrong."""

import shutil
from pathlib import Path

import pytest

from squeezefilm.config.loading import Config, load_config
from squeezefilm.errors import InputError
from squeezefilm.studies.plan_scenes import scenes_of
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


@pytest.mark.parametrize("name", ["paper", "paper-inertia", "quick", "sweep", "vibrometer"])
def test_the_studies_that_come_with_the_workflow_are_valid(repository, name):
    config = load(repository / "config" / f"{name}.yaml")
    assert config["study"] == name
    assert config["gas"]["viscosity_pa_s"] == 1.81e-5
    assert config["actuator"]["frequency_hz"] == 43270


@pytest.mark.parametrize("name", ["paper", "vibrometer"])
def test_every_plan_lies_in_the_screens_ranges_however_they_are_moved(repository, name, tmp_path):
    """Who changes the screen and the wanted point changes them all, the template's user too."""
    text = (repository / "config" / f"{name}.yaml").read_text(encoding="utf-8")
    for old, new in {
        "{start: 5 µm, stop: 10 µm": "{start: 15 µm, stop: 30 µm",
        "{start: 0.2 µm, stop: 2 µm": "{start: 0.5 µm, stop: 6 µm",
        "h0: 5 µm\n  hv: 2.2 µm": "h0: 20 µm\n  hv: 5 µm",
    }.items():
        text = text.replace(old, new)
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


HZ, SINC = "43.27 kHz", "kind: sinc, wave_number: 109.8 1/m"
LIKE = "allowed: 0.001 … 1e9 Hz, as a number or with its unit, like 1 Hz or 1 kHz"
WRONG = [  # what is replaced, or begins the file; by what; and what is said
    ("viscosity:", "viscosty:", "gas: unknown key 'viscosty'; did you mean 'viscosity'?"),
    ("frequency:", "frequency_hz:", "line 20: actuator: unknown key 'frequency_hz'; did you mean"),
    ("", "slip: 1\n", "line 1: top level: unknown key 'slip'; allowed are"),
    (f"  frequency: {HZ}\n", "", "line 19: actuator: missing 'frequency' (0.001 … 1e9 Hz): freq"),
    ("screen:", "sweep_:", "missing 'screen' (a section with h0, hv): The first plan"),
    (HZ, "fast", f"line 20: actuator.frequency: 'fast' should be a valid number; {LIKE}"),
    ("10 mm", "10 kHz", "surface_radius: '10 kHz' should be a valid number; allowed: 1e-6 … 10 m"),
    (HZ, "-3", "frequency: -3 should be greater than or equal to 0.001; allowed"),
    ("101325 Pa", ".inf", "ambient_pressure: inf should be a finite number"),
    ("101325 Pa", "9" * 400, "ambient_pressure: inf should be"),
    (HZ, "true", "actuator.frequency: True should be"),
    (HZ, "010", "'010' should be a valid number"),
    (HZ, "12:30", "'12:30' should be a valid number"),
    (HZ, "", "frequency: None should"),
    ("points: 10000", "points: 0.5", "points: 0.5 should be a valid integer"),
    ("solver:\n", "solver: [1]\nsolvers:\n", "solver: [1] is no section; its keys are method"),
    ("kind: sinc", "kind: bassel", "kind: 'bassel' is none of `sinc`, `piston`"),
    ("kind: sinc", "kind: bassel", "; did you mean 'bessel'?"),
    ("kind: sinc", "kind: piston", "profile: unknown key 'wave_number'"),
    ("study: paper", "study: ../paper", "study: '../paper' should match pattern"),
    ("models: {}", "models: {A: {expression: t0}}", "models.A: 'A'"),
    ("30, 45]", "15]", "positions.phi: a value stands twice"),
    ("", "study: other\n", "line 3: the key 'study' stands twice"),
    ("", "1: 2\n", "line 1: the key 1 is not text"),
    ("", "<<: {study: other}\n", "merge keys are not allowed"),
    ("", "a: &x [1]\nb: *x\n", "line 1: an alias is not allowed"),
    ("", "a: !!python/object:os.system {}\n", "the tag tag:yaml.org,2002:python"),
    ("", "a: [\n", "not valid YAML"),
    ("", "a: " + "[" * 2000, "study.yaml"),
    (
        HZ,
        "43.27 MHz",
        "line 20: actuator.frequency: at 4.327e+07 Hz sound in this gas is 7.9e-06 m",
    ),
    ("stop: 2 µm", "stop: 5 µm", "screen: the largest hv must stay below the smallest h0"),
    ("hv: 2.2 µm", "hv: 5 µm", "extrapolation: hv must stay below h0"),
    (
        "hv: 2.2 µm",
        "hv: 3.1 µm",
        "extrapolation.hv: 3.1e-06 does not suit screen.hv, 2e-07 … 2e-06",
    ),
    ("start: 0.2 µm", "start: 3 µm", "screen.hv: start must be below"),
    ("h0: {levels: 41}", "h0: {stop: 12 µm}", "error_map.h0.stop: 1.2e-05 does not suit screen.h0"),
    ("2.9 mm]", "3.1 mm]", "off the actuator's 10.00 mm disc"),
    ("bulge: 0}", "bulge: -4 µm}", "finger touches the surface"),
    (SINC, "kind: formula, expression: open('x')", "actuator.profile.expression: column 1"),
    (SINC, "kind: formula, expression: 1/x", "has no finite value everywhere"),
    (SINC, "kind: measured, file: none.csv", "none.csv: there is no such scan"),
]


@pytest.mark.parametrize(("old", "new", "message"), WRONG)
def test_a_wrong_study_is_refused(old, new, message, paper, study):
    assert old in paper
    with pytest.raises(InputError) as refusal:
        load(study(paper.replace(old, new, 1)))
    assert message in str(refusal.value)
    assert "study.yaml" in str(refusal.value)


def test_each_mistake_is_said_once_in_the_order_of_the_file(study):
    text = """
study: Mine
actuator: {frequency: 15 mm, surface_radius: 30 mm, profile: {wave_number: 3}}
finger: {lenght_x: 0.012, length_y: 16 mm, shape: elipse}
screen: {h0: {start: 20 um}, hv: {start: 2 um, stop: 4 um, levels: 1}}
solver: {tolerance: 7}
extrapolation: 3
models: {own: {expression: t0, parameters: 3}}
"""
    with pytest.raises(InputError) as refusal:
        load(study(text))
    told = [line.split(": ", 3)[1:] for line in str(refusal.value).splitlines()]
    assert [(line, place) for line, place, _ in told] == [
        ("line 2", "study"),
        ("line 3", "actuator.frequency"),
        ("line 3", "actuator.profile"),
        ("line 4", "finger"),
        ("line 4", "finger.shape"),
        ("line 5", "screen.h0"),
        ("line 5", "screen.hv.levels"),
        ("line 6", "solver.tolerance"),
        ("line 7", "extrapolation"),
        ("line 8", "models.own.parameters"),
    ]
    said = {place: text for _, place, text in told}
    assert said["actuator.profile"].startswith("missing 'kind' (`sinc`, `piston`")
    assert "did you mean 'length_x'?" in said["finger"]
    assert "did you mean 'ellipse'?" in said["finger.shape"]
    assert said["screen.h0"] == "missing 'stop' (1e-9 … 0.001 m)"
    assert said["solver.tolerance"].endswith("; allowed: 1e-10 … 0.1")


@pytest.mark.parametrize("text", ["", "paper", "- a\n- b", "3"])
def test_a_study_is_a_mapping(text, study):
    with pytest.raises(InputError, match="mapping of keys to values"):
        load(study(text))


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


@pytest.mark.parametrize("text", ["1e-6", "1.E-6", "0.001e-3", "'1e-6'"])
def test_a_number_may_be_written_with_an_exponent(text, paper, study):
    config = load(study(paper.replace("tolerance: 1e-6", f"tolerance: {text}")))
    assert config["solver"]["tolerance"] == 1e-6
