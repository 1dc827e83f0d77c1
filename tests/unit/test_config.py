"""A study is read as it is written, or refused with a message that names what is wrong."""

import re
import shutil
from pathlib import Path

import pytest

from squeezefilm.api.film import Film
from squeezefilm.cli import main as cli
from squeezefilm.config.loading import load_config
from squeezefilm.config.notes import study_notes
from squeezefilm.config.study import Study
from squeezefilm.errors import InputError
from squeezefilm.studies.plans import plan_scenes_table
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


def load(path: Path) -> Study:
    """What the rules do before anything runs."""
    return check_study(load_config(path))


@pytest.mark.parametrize("name", ["paper", "paper-inertia", "quick", "sweep", "vibrometer"])
def test_the_studies_that_come_with_the_workflow_are_valid(repository, name):
    config = load(repository / "config" / f"{name}.yaml")
    assert config.study == name
    assert config.gas.viscosity_pa_s == 1.81e-5
    assert config.actuator.frequency_hz == 43270


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
        table = plan_scenes_table(kind, config)
        for factor, (low, high) in {"h0_m": (15e-6, 30e-6), "hv_m": (0.5e-6, 6e-6)}.items():
            values = table[factor]
            assert values.min() >= low * (1 - 1e-9), (kind, factor)
            assert values.max() <= high * (1 + 1e-9), (kind, factor)
    assert config.error_map.h0_m.stop == 30e-6


HZ, SINC = "43.27 kHz", "kind: sinc, wave_number: 109.8 1/m"
WAVE = "kind: standing-wave, wavelength: 1 cm"
LIKE = "allowed: 0.001 … 1e9 Hz, as a number or with its unit, like 1 Hz or 1 kHz"
WRONG = [  # what is replaced, or begins the file; by what; and what is said
    ("frequency:", "frequency_hz:", "line 20: actuator: unknown key 'frequency_hz'; did you mean"),
    (f"  frequency: {HZ}\n", "", "line 19: actuator: missing 'frequency' (0.001 … 1e9 Hz): freq"),
    (HZ, "fast", f"line 20: actuator.frequency: 'fast' should be a valid number; {LIKE}"),
    (
        HZ,
        "43,27 kHz",
        "actuator.frequency: '43,27 kHz' should be a valid number; write '43.27 kHz'",
    ),
    (
        HZ,
        "43.27 khz",
        "actuator.frequency: '43.27 khz' should be a valid number; write '43.27 kHz'",
    ),
    (SINC, f"{SINC}, crest: 1,5 mm", "unknown key '5 mm'; write a decimal point"),
    ("  frequency:", "\tfrequency:", "indent by spaces: YAML allows no tab there"),
    (HZ, "28 mm", f"actuator.frequency: '28 mm' is a length; a frequency is wanted; {LIKE}"),
    (HZ, "-3", "frequency: -3 should be greater than or equal to 0.001; allowed"),
    ("kind: sinc", "kind: bassel", "kind: 'bassel' is none of `sinc`, `piston`"),
    (SINC, f"{WAVE}, surface: 1", "unknown key 'surface'; allowed are crest, direction, kind"),
    (
        "  surface_radius: 10 mm",
        "  surface: {shape: disc, length_x: 4 cm, length_y: 4 cm}",
        "'disc' is not `rectangle`; its outline; a disc has `actuator.surface_radius` in place of",
    ),
    ("length_x: 10 mm", "length: 10 mm", "unknown key 'length'; did you mean 'length_x'?"),
    ("  length_x: ", "  contour: 1\n  length_x: ", "pad: unknown key 'contour'"),
    ("shape: rectangle", "shape: disc", "`curve`; did you mean 'circle'?"),
    ("kind: sinc", "kind: bassel", "; did you mean 'bessel'?"),
    ("inertia: none", "inertia: on", "'on' is none of `none`, `included`, `auto`\n"),
    (
        SINC,
        "kind: bessel, nodal_diameters: 0, wave_number: 0.38 1/mm",
        "write '380 rad/m', or '2387",
    ),
    ("study: paper", "study: ../paper", "study: '../paper' should match pattern"),
    ("", "study: other\n", "line 3: the key 'study' stands twice"),
    ("", "a: &b [c]\nd: *b\n", "line 1: an alias of this value is not allowed"),
    ("", "<<: {a: 1}\n", "line 1: top level: unknown key '<<'"),
    ("", "a: [\n", "not valid YAML: while parsing a flow sequence in line 1, column 4"),
    ("inertia: none", "name: neon", "gas.name: 'neon' is none of `air`, `nitrogen`, `helium`"),
    ("inertia: none", "ambient_temperature: 20 °F", "allowed: 223.15 … 473.15 K"),
    ("density: 1.204 kg/m³", "name: argon", "argon at 293.15 K, 2.231e-05; of another gas give d"),
    ("stop: 2 µm", "stop: 5 µm", "hv = 5 µm reaches h0 = 5 µm: surface and pad touch"),
    ("h0: {levels: 41}", "h0: {stop: 12 µm}", "error_map.h0.stop: 1.2e-05 does not suit screen.h0"),
    ("2.9 mm]", "3.1 mm]", "off the actuator's disc of radius 10 mm"),
    (SINC, "kind: formula, expression: open('x')", "actuator.profile.expression: column 1"),
]


@pytest.mark.parametrize(("old", "new", "message"), WRONG)
def test_a_wrong_study_is_refused(old, new, message, paper, study):
    assert old in paper
    with pytest.raises(InputError) as refusal:
        load(study(paper.replace(old, new, 1)))
    assert message in f"{refusal.value}\n"
    assert "study.yaml" in str(refusal.value)


def test_each_mistake_is_said_once_in_the_order_of_the_file(study):
    text = """
study: Mine
actuator: {frequency: 15 mm, surface_radius: 30 mm, profile: {wave_number: 3}}
pad: {lenght_x: 0.012, length_y: 16 mm, shape: elipse}
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
        ("line 4", "pad"),
        ("line 4", "pad.shape"),
        ("line 5", "screen.h0"),
        ("line 5", "screen.hv.levels"),
        ("line 6", "solver.tolerance"),
        ("line 7", "extrapolation"),
        ("line 8", "models.own.parameters"),
    ]
    said = {place: text for _, place, text in told}
    assert said["actuator.profile"].startswith("missing 'kind' (`sinc`, `piston`")
    assert "did you mean 'length_x'?" in said["pad"]
    assert "did you mean 'ellipse'?" in said["pad.shape"]
    assert said["screen.h0"] == "missing 'stop' (1e-9 … 0.001 m): the last"
    assert said["solver.tolerance"].endswith("; allowed: 1e-10 … 0.1")


def test_a_file_that_is_not_there_is_named(tmp_path):
    with pytest.raises(InputError, match="no such configuration file"):
        load(tmp_path / "none.yaml")


def test_line_ends_and_byte_order_mark_do_not_matter(paper, tmp_path):
    path = tmp_path / "study.yaml"
    path.write_bytes(b"\xef\xbb\xbf" + paper.replace("\n", "\r\n").encode())
    plain = tmp_path / "plain.yaml"
    plain.write_text(paper, encoding="utf-8")
    assert dict(load(path)) == dict(load(plain))


@pytest.mark.parametrize(("force", "noted"), [("2 N", False), ("3 N", True), ("30 N", True)])
def test_a_target_force_beyond_the_screen_is_noted(force, noted, study):
    """It took a whole run to end with empty amplitudes."""
    path = study(
        "study: mine\ngas: {inertia: none, thermal: none}\nsolver: {tolerance: 1e-3}\n"
        "actuator: {frequency: 43.27 kHz, surface_radius: 10 mm, profile: {kind: piston}}\n"
        "pad: {length_x: 10 mm, length_y: 10 mm}\n"
        "screen: {h0: {start: 5 µm, stop: 10 µm}, hv: {start: 0.2 µm, stop: 2 µm}}\n"
        f"extrapolation: {{force: {force}}}\n"
    )
    notes = [note for note in study_notes(load_config(path)) if "beyond the screen" in note]
    assert len(notes) == noted
    for note in notes:
        (limit_n,) = map(float, re.findall(r"about ([\d.]+) N", note))
        assert 0.9 * limit_n < float(Film.read(path).force("5 um", "2 um").force_n) < limit_n


@pytest.mark.parametrize(
    ("profile", "models", "count"),
    [
        ("{kind: standing-wave, wavelength: 12 mm}", "{}", 1),
        ("{kind: standing-wave, wavelength: 12 mm}", "{mine: {expression: t0*cos(500*x)}}", 0),
        ("{kind: piston}", "{}", 0),
    ],
)
def test_a_standing_wave_without_a_model_that_repeats_is_noted(profile, models, count, study):
    path = study(
        f"study: mine\nactuator: {{frequency: 40 kHz, surface_radius: 10 mm, profile: {profile}}}\n"
        "pad: {length_x: 4 mm, length_y: 4 mm}\n"
        "screen: {h0: {start: 5 µm, stop: 10 µm}, hv: {start: 0.2 µm, stop: 2 µm}}\n"
        f"extrapolation: {{force: 0.1 N}}\nmodels: {models}\n"
    )
    notes = [note for note in study_notes(load_config(path)) if "standing wave" in note]
    assert len(notes) == count


def test_a_frequency_that_lacks_its_unit_is_noted_beside_every_result(paper, study, capsys):
    """43.27 Hz, of kHz forgotten, gave a force without a word."""
    path = study(paper.replace(HZ, "43.27"))
    note = "note: actuator.frequency is read as 43.27 Hz; for 43.27 kHz write the unit"
    for command in (["simulate", "--dry-run"], ["simulate"], ["error-budget"]):
        assert cli.main([*command, "--h0=5um", "--hv=1um", f"--config={path}"]) == 0
        assert capsys.readouterr().err.count(note) == 1
