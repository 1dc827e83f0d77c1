"""A study says what differs; all else has a default, and nothing of it is hidden."""

import copy
from math import hypot
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from jsonschema import Draft202012Validator

from squeezefilm.api.film import Film
from squeezefilm.cli.main import main
from squeezefilm.io.errors import InputError
from squeezefilm.units import in_unit
from squeezefilm.config.loading import Config, load_config, parse_config
from squeezefilm.config.written import effective_text, write_effective
from squeezefilm.studies.plans import finger_positions, plan_sizes
from squeezefilm.studies.schema import SUFFIXES, filled, schema
from squeezefilm.studies.study import check_study

SHORT = """
study: mine
actuator: {frequency: 20 kHz, surface_radius: 30 mm, profile: {kind: piston}}
finger: {shape: ellipse, length_x: 12 mm, length_y: 16 mm}
screen:
  h0: {start: 20 µm, stop: 35 um}
  hv: {start: 2 µm, stop: 18.5 µm, levels: 5}
extrapolation: {force: 500 mN}
"""
SOUND = yaml.safe_load(SHORT)


def study(text: str = SHORT, **sections: Any) -> Config:
    values = yaml.safe_load(text)
    for name, keys in sections.items():
        values[name] = {**values.get(name, {}), **keys}
    return parse_config(yaml.safe_dump(values, allow_unicode=True), path=Path("mine.yaml"))


def leaves(part: dict[str, Any], place: str = "") -> Any:
    """Every key that is no section, with the part of the schema it is in."""
    for name, key in part.get("properties", {}).items():
        if isinstance(key, dict) and "properties" in key:
            yield from leaves(key, f"{place}{name}.")
        elif isinstance(key, dict):
            yield f"{place}{name}", key, name in part.get("required", ())
    for choice in part.get("allOf", ()):
        yield from leaves(choice["then"], f"{place}{choice['if']['properties']}.")


@pytest.mark.parametrize("levels", [(5, 5), (3, 3), (2, 5)])
def test_an_error_map_on_points_of_the_screen_is_refused(levels):
    """Found only when a model was to be judged, after all simulations."""
    screen = {"h0": {"start": "20 um", "stop": "35 um", "levels": 5}}
    h0, hv = ({"levels": each} for each in levels)
    with pytest.raises(InputError, match="error_map: all its points are the screen's"):
        study(screen=screen, error_map={"h0": h0, "hv": hv})


@pytest.mark.parametrize("levels", [2, 5, 17])
def test_an_error_map_that_is_not_written_has_points_of_its_own(levels):
    screen = {"h0": {"start": "20 um", "stop": "35 um", "levels": levels}}
    section = study(screen=screen)
    (own, fitted) = (
        {tuple(point) for point in np.stack(np.meshgrid(*_levels(each)), -1).reshape(-1, 2)}
        for each in (section["error_map"], section["screen"])
    )
    assert len(own - fitted) >= len(fitted)


def _levels(plan: dict[str, Any]) -> list[np.ndarray]:
    ends = (plan["h0_m"], plan["hv_m"])
    return [np.linspace(each["start"], each["stop"], each["levels"]) for each in ends]


def test_every_key_is_required_or_has_a_default_that_is_allowed():
    for place, key, required in leaves(schema()):
        # One of two: the study is refused with neither, or with both.
        if place.endswith("profile.kind") or place == "actuator.surface_radius_m":
            continue
        assert required + ("default" in key) + ("derived" in key) == 1, place
        if "default" in key:
            assert not [*Draft202012Validator(key).iter_errors(key["default"])], place
        assert key.get("unit", "s") in {*SUFFIXES, "s"}, place


def test_a_short_study_is_whole(repository):
    short = study()
    check_study(short)
    assert short.keys() == load_config(repository / "config" / "paper.yaml").keys()
    assert short["gas"]["inertia"] == "auto"
    assert short["gas"]["viscosity_pa_s"] == 1.81e-5
    assert short["screen"]["h0_m"] == {"start": 20e-6, "stop": 35e-6, "levels": 8}
    assert short["extrapolation"] == {"force_n": 0.5, "h0_m": 20e-6, "hv_m": 18.5e-6}
    assert short["error_map"]["hv_m"] == {"start": 2e-6, "stop": 18.5e-6, "levels": 10}
    # An ellipse has no physics limit: no model may rest on it.
    assert "limit" not in str(short["comparison"]) + str(short["refine"])
    assert "limit_1" in study(finger={"shape": "rectangle"})["comparison"]["two_factor"]


@pytest.mark.parametrize("shape", ["rectangle", "ellipse"])
def test_positions_use_the_room_that_the_pad_has(shape):
    """The farthest is on the surface in every direction, and nearly at its rim."""
    pad = {"finger": {"shape": shape}}
    config = study(**pad)
    check_study(config)
    reach = hypot(0.006, 0.008) if shape == "rectangle" else 0.008
    half, farthest = config["positions"]["phi_r_m"]
    assert 0.9 * (0.03 - reach) < farthest <= 0.03 - reach
    assert half == pytest.approx(farthest / 2, rel=0.1)
    with pytest.raises(InputError, match="there is no room to move the pad"):
        study(actuator={"surface_radius": f"{reach * 1e3} mm"}, **pad)
    small = {"actuator": {"surface_radius": f"{reach * 1e3} mm"}}
    written = study(**small, **pad, positions={"phi_r_m": [1e-3]})
    assert written["positions"]["phi_r_m"] == [1e-3]
    assert config["positions"]["points"] == 25
    assert "points" not in written["positions"]
    counted = study(positions={"points": 7})
    assert (len(finger_positions(counted)), plan_sizes(counted)["four_factor"]) == (7, 35)


def test_what_is_written_goes_before_what_follows():
    config = study(error_map={"h0_m": {"levels": 3, "stop": 30e-6}}, extrapolation={"hv_m": 3e-6})
    assert config["error_map"]["h0_m"] == {"start": 20e-6, "stop": 30e-6, "levels": 3}
    assert config["extrapolation"]["hv_m"] == 3e-6
    assert "extrapolation.hv_m" not in config.origins
    assert config.origins["extrapolation.h0_m"] == "derived"
    assert config.origins["error_map.h0_m.start"] == "derived"
    assert config.origins["gas.inertia"] == "default"
    assert "screen.h0_m.start" not in config.origins
    assert set(config.origins.values()) == {"default", "derived"}


def test_defaults_are_not_shared_between_studies():
    first = study()
    first["fit"]["bounds"].append(3)
    first["comparison"]["two_factor"].append("mine")
    assert study()["fit"]["bounds"] == [100]
    assert "mine" not in study()["comparison"]["two_factor"]
    values = {"study": "a"}
    assert filled(copy.deepcopy(values), schema())["study"] == "a"
    assert values == {"study": "a"}


def test_no_default_is_put_into_a_study_that_writes_everything(repository):
    for name in ("paper", "paper-inertia", "quick"):
        config = load_config(repository / "config" / f"{name}.yaml")
        ends = {f"error_map.{f}.{end}" for f in ("h0_m", "hv_m") for end in ("start", "stop")}
        assert config.origins.keys() == ends


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("15 mm", "m", 0.015),
        ("2.2um", "m", 2.2e-6),
        ("43.27 kHz", "Hz", 43270.0),
        ("18.1 µPa s", "Pa s", 1.81e-5),
        ("1.204e-3 g/cm³", "kg/m³", 1.204),
        ("1.01325 bar", "Pa", 101325.0),
        ("0.1098 1/mm", "1/m", 109.8),
        ("100 mm/s", "m/s", 0.1),
        ("0.5 rad", "°", 28.6478897565412),
        ("15 kHz", "m", None),
        ("15", "m", None),
        ("15 mm mm", "m", None),
        ("15 mm/", "m", None),
        ("1_5 mm", "m", None),
        ("1e999 mm", "m", None),
        ("mm", "m", None),
    ],
)
def test_a_number_may_have_its_unit(text, unit, value):
    assert in_unit(text, unit) == value


def test_each_mistake_is_said_once():
    text = """
        study: Mine
        actuator: {frequency_hz: 15 mm, surface_radius: 30 mm, profile: {wave_number: 3}}
        finger: {lenght_x_m: 0.012, length_y: 16 mm, shape: elipse}
        screen: {h0: {start: 20 um}, hv: {start: 2 um, stop: 4 um, levels: 1}}
        solver: {tolerance: 7}
        extrapolation: 3
    """
    with pytest.raises(InputError) as refusal:
        study(text)
    told = str(refusal.value).splitlines()
    places = [line.split(": ")[1] for line in told]
    assert places == [
        "actuator.frequency_hz",
        "actuator.profile",
        "extrapolation",
        "finger",
        "finger.shape",
        "screen.h0_m",
        "screen.hv_m.levels",
        "solver.tolerance",
        "study",
    ]
    said = dict(zip(places, told, strict=True))
    assert "allowed: 0.001 … 1e9 Hz, as a number or with its unit" in said["actuator.frequency_hz"]
    assert "missing 'kind' (`sinc`, `piston`" in said["actuator.profile"]
    assert "did you mean 'length_x_m'?" in said["finger"]
    assert "did you mean 'ellipse'?" in said["finger.shape"]
    assert "missing 'stop' (1e-9 … 0.001 m)" in said["screen.h0_m"]


def test_the_effective_study_is_a_study(repository, tmp_path, capsys):
    """It reads as the same, wherever it lies, and marks what was not written."""
    for name in ("vibrometer", "paper"):
        path = repository / "config" / f"{name}.yaml"
        config = load_config(path)
        assert main(["config", str(path)]) == 0
        shown = capsys.readouterr().out
        assert shown == effective_text(config)
        written = load_config(write_effective(config, tmp_path / "results" / name))
        check_study(written)
        if name == "vibrometer":
            profile = written["actuator"]["profile"]
            assert (written.path.parent / profile["file"]).samefile(path.with_suffix(".csv"))
            profile["file"] = "vibrometer.csv"
            assert "  inertia: auto # default\n" in shown
            assert "    levels: 16 # derived: twice the screen's\n" in shown
            assert "  frequency_hz: 43270.0\n" in shown
        assert written.sections == config.sections
        assert not written.origins


@pytest.mark.parametrize(
    ("written", "said"),
    [
        ("frequency: 43.27 mm", "actuator.frequency: '43.27 mm' is no number with a unit of Hz"),
        ("frequency: 43.27", "actuator.frequency: 43.27 is no number with a unit of Hz"),
        ("frequency: 40 kHz, frequency_hz: 4e4", "'frequency' and 'frequency_hz' are one key"),
    ],
)
def test_a_key_without_its_unit_is_told_what_its_value_lacks(tmp_path, written, said):
    path = tmp_path / "mine.yaml"
    path.write_text(
        f"study: mine\nactuator: {{{written}, surface_radius: 10 mm, profile: {{kind: piston}}}}\n"
        "finger: {length_x: 10 mm, length_y: 10 mm}\nextrapolation: {force: 1 N}\n"
        "screen: {h0: {start: 5 µm, stop: 10 µm}, hv: {start: 0.2 µm, stop: 2 µm}}\n"
    )
    with pytest.raises(InputError) as error:
        load_config(path)
    assert said in str(error.value)
    assert "unknown key" not in str(error.value)


def test_units_may_be_written_in_lists_and_zero_needs_none():
    text = SHORT + "positions: {phi_r: [5 mm, 1 cm], phi: [0, 30 deg]}\n"
    assert study(text)["positions"] == {"phi_r_m": [0.005, 0.01], "phi_deg": [0, 30]}
    with pytest.raises(InputError, match="each number there needs a unit that fits"):
        study(SHORT + "positions: {phi_r: [5, 1 cm]}\n")


def test_thin_air_is_thin_in_every_number():
    """At a tenth of the pressure slip is ten times what it is; it was that of dense air."""
    gas = study(gas={"ambient_pressure_pa": 10132.5})["gas"]
    assert gas["density_kg_per_m3"] == pytest.approx(0.1204)
    assert gas["mean_free_path_m"] == pytest.approx(6.7e-7)
    written = study(gas={"ambient_pressure_pa": 10132.5, "mean_free_path_m": 5e-7})["gas"]
    assert (written["mean_free_path_m"], written["density_kg_per_m3"]) == (
        5e-7,
        gas["density_kg_per_m3"],
    )


def test_another_gas_is_written_whole():
    helium = {"viscosity_pa_s": 1.96e-5, "density_kg_per_m3": 0.166, "mean_free_path_m": 1.9e-7}
    with pytest.raises(
        InputError, match=r"mine.yaml: gas: viscosity_pa_s 1.96e-05 is not that of air"
    ):
        study(gas=helium)
    rest = {"prandtl": 0.68, "heat_capacity_ratio": 1.667, "viscosity_exponent": 0.65}
    assert study(gas=helium | rest)["gas"]["prandtl"] == 0.68
    film = {"actuator": SOUND["actuator"], "finger": SOUND["finger"]}
    with pytest.raises(InputError, match="give mean_free_path_m, prandtl"):
        Film.of(**film, gas={"viscosity_pa_s": 1.5e-5, "density_kg_per_m3": 1.8})


def test_a_coefficient_of_slip_is_refused_where_nothing_slips():
    assert study(gas={"rarefaction": "slip", "slip_coefficient": 1.147})["gas"]["slip_coefficient"]
    with pytest.raises(InputError, match=r"slip_coefficient 1\.147 is read with rarefaction: slip"):
        study(gas={"slip_coefficient": 1.147})
