"""A study says what differs; all else has a default, and nothing of it is hidden."""

from math import hypot, pi, sqrt
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import yaml

import squeezefilm as sf
from squeezefilm.cli.main import main
from squeezefilm.config.loading import load_config, parse_config, with_changed_keys
from squeezefilm.config.study import Study
from squeezefilm.config.writing import effective_yaml, value_origin, write_effective_study
from squeezefilm.errors import InputError
from squeezefilm.film.gas import Gas
from squeezefilm.studies.plans import plan_point_counts
from squeezefilm.studies.space import pad_positions
from squeezefilm.studies.study import check_study
from squeezefilm.units import number_in_unit

SHORT = """
study: mine
actuator: {frequency: 20 kHz, surface_radius: 30 mm, profile: {kind: piston}}
pad: {shape: ellipse, length_x: 12 mm, length_y: 16 mm}
screen:
  h0: {start: 20 µm, stop: 35 um}
  hv: {start: 2 µm, stop: 18.5 µm, levels: 5}
extrapolation: {force: 500 mN}
"""


def study(text: str = SHORT, **sections: Any) -> Study:
    values = yaml.safe_load(text)
    for name, keys in sections.items():
        values[name] = {**values.get(name, {}), **keys}
    return parse_config(yaml.safe_dump(values, allow_unicode=True), path=Path("mine.yaml"))


@pytest.mark.parametrize("levels", [(5, 5), (2, 5)])
def test_an_error_map_on_points_of_the_screen_is_refused(levels):
    """Found only when a model was to be judged, after all simulations."""
    screen = {"h0": {"start": "20 um", "stop": "35 um", "levels": 5}}
    h0, hv = ({"levels": each} for each in levels)
    with pytest.raises(InputError, match="error_map: all its points are the screen's"):
        study(screen=screen, error_map={"h0": h0, "hv": hv})


def test_a_short_study_is_whole(repository):
    short = study()
    check_study(short)
    paper = load_config(repository / "config" / "paper.yaml")
    assert short.sections_as_dict().keys() == paper.sections_as_dict().keys()
    assert short.gas.inertia == "auto"
    assert short.gas.viscosity_pa_s == 1.81e-5
    assert short.screen.h0_m.model_dump() == {"start": 20e-6, "stop": 35e-6, "levels": 8}
    assert short.extrapolation.model_dump() == {"force_n": 0.5, "h0_m": 20e-6, "hv_m": 18.5e-6}
    assert short.error_map.hv_m.model_dump() == {"start": 2e-6, "stop": 18.5e-6, "levels": 10}
    # An ellipse has no asymptotic expansion: no model may rest on it.
    assert "limit" not in str(short.comparison) + str(short.refine)
    assert "limit_1" in study(pad={"shape": "rectangle"}).comparison.two_factor


@pytest.mark.parametrize(("gas", "gap"), [({"thermal": "included"}, {}), ({}, {"tilt_x": "1 um"})])
def test_no_model_rests_on_a_limit_that_is_not_derived_for_its_film(gas, gap):
    """All points of such a study have no limit, so its comparison would lack these models."""
    config = study(gas=gas, pad={"shape": "rectangle", "gap": gap})
    assert "limit" not in str(config.comparison) + str(config.refine)


@pytest.mark.parametrize("shape", ["rectangle", "ellipse"])
def test_positions_use_the_room_that_the_pad_has(shape):
    """The farthest is on the surface in every direction, and nearly at its rim."""
    pad = {"pad": {"shape": shape}}
    config = study(**pad)
    check_study(config)
    reach = hypot(0.006, 0.008) if shape == "rectangle" else 0.008
    half, farthest = config.positions.phi_r_m
    assert 0.9 * (0.03 - reach) < farthest <= 0.03 - reach
    assert half == pytest.approx(farthest / 2, rel=0.1)
    with pytest.raises(InputError, match="there is no room to move the pad"):
        study(actuator={"surface_radius": f"{reach * 1e3} mm"}, **pad)
    small = {"actuator": {"surface_radius": f"{reach * 1e3} mm"}}
    written = study(**small, **pad, positions={"phi_r": [1e-3]})
    assert written.positions.phi_r_m == [1e-3]
    assert config.positions.points == 25
    assert written.positions.points is None
    counted = study(positions={"points": 7})
    assert (len(pad_positions(counted)), plan_point_counts(counted)["four_factor"]) == (7, 35)


def test_what_is_written_goes_before_what_follows():
    config = study(error_map={"h0": {"levels": 3, "stop": 30e-6}}, extrapolation={"hv": 3e-6})
    assert config.error_map.h0_m.model_dump() == {"start": 20e-6, "stop": 30e-6, "levels": 3}
    assert config.extrapolation.hv_m == 3e-6
    assert value_origin(config, ("extrapolation", "hv")) == ""
    assert value_origin(config, ("extrapolation", "h0")) == "derived: the screen's smallest gap"
    assert value_origin(config, ("error_map", "h0", "start")) == "derived: the screen's"
    assert value_origin(config, ("gas", "inertia")) == "default"


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("15 mm", "m", 0.015),
        ("43.27 kHz", "Hz", 43270.0),
        ("1.204e-3 g/cm³", "kg/m³", 1.204),
        ("0.5 rad", "°", 28.6478897565412),
        ("15 kHz", "m", None),
        ("15", "m", 15.0),
        ("500 mbar", "Pa", 5e4),
        ("20 mg", "kg", 2e-5),
        ("1e999 mm", "m", None),
    ],
)
def test_a_number_may_have_its_unit(text, unit, value):
    assert number_in_unit(text, unit) == value


def test_the_effective_study_is_a_study(repository, tmp_path, capsys):
    """It reads as the same, wherever it lies, and marks what was not written."""
    (tmp_path / "disk/of/others").mkdir(parents=True)
    (tmp_path / "results").symlink_to("disk/of/others")
    for name in ("vibrometer", "paper"):
        path = repository / "config" / f"{name}.yaml"
        config = load_config(path)
        assert main(["config", str(path)]) == 0
        shown = capsys.readouterr().out
        assert shown == effective_yaml(config)
        written = load_config(write_effective_study(config, tmp_path / "results" / name))
        check_study(written)
        if name == "vibrometer":
            assert written.scan_path.samefile(path.with_suffix(".csv"))
            assert "  inertia: auto # default\n" in shown
            assert "    levels: 16 # derived: twice the screen's\n" in shown
            assert "  frequency: 43270.0 # Hz\n" in shown
        moved = {}
        if name == "vibrometer":
            moved = {"actuator.profile.file": config.actuator.profile.file}
        assert with_changed_keys(written, moved).sections_as_dict() == config.sections_as_dict()
        assert "default" not in effective_yaml(written)


def test_numbers_that_may_lack_their_unit_are_noted(tmp_path, capsys):
    """20 is 20 Hz, and 8 is 8 m: allowed, but hardly meant; a written unit is."""
    text = SHORT.replace("20 kHz", "20").replace("30 mm", "9 m").replace("12 mm", "8")
    (path := tmp_path / "mine.yaml").write_text(text, encoding="utf-8")
    assert main(["config", str(path)]) == 0
    assert capsys.readouterr().err.splitlines() == [
        "note: actuator.frequency is read as 20 Hz; for 20 kHz write the unit",
        "note: pad.length_x is read as 8 m; for 8 mm write the unit",
    ]


def test_a_pad_that_does_not_fit_for_want_of_a_unit_is_told_so(tmp_path, refused):
    (path := tmp_path / "mine.yaml").write_text(SHORT.replace("12 mm", "10"), encoding="utf-8")
    error = refused("config", path)
    assert "no room to move the pad" in error
    assert error.count("pad.length_x is read as 10 m; for 10 mm write the unit") == 1
    path.write_text(SHORT.replace("12 mm", "80 mm"), encoding="utf-8")
    assert "is read as" not in refused("config", path)


def test_a_study_with_the_name_of_another_file_is_noted(tmp_path, capsys):
    """A copy of config/paper.yaml with a new formula wrote its results into results/paper."""
    (tmp_path / "mine.yaml").write_text(SHORT, encoding="utf-8")
    (tmp_path / "copy.yaml").write_text(SHORT, encoding="utf-8")
    note = f"note: study: mine is the study of {tmp_path}/mine.yaml: results/mine would hold"
    for name, count in (("mine", 0), ("copy", 1)):
        assert main(["config", f"{tmp_path}/{name}.yaml"]) == 0
        assert capsys.readouterr().err.count(note) == count


def test_a_model_with_positions_among_those_of_the_centred_pad_is_noted(tmp_path, capsys):
    text = f"""{SHORT}
models: {{mine: {{expression: t0*(hv/h0)**2 + t1*x**2}}}}
comparison: {{two_factor: [mine, limit], four_factor: [mine]}}
"""
    (path := tmp_path / "mine.yaml").write_text(text, encoding="utf-8")
    assert main(["config", str(path)]) == 0
    assert capsys.readouterr().err.splitlines() == [
        "note: comparison.two_factor: mine has the pad's position, which is 0 at all these points: "
        "name it in comparison.four_factor"
    ]


def test_a_variant_of_the_paper_is_named_by_what_differs(repository, tmp_path, capsys):
    """Claims of the paper were compared with another film's numbers, without a word."""
    text = (repository / "config/paper.yaml").read_text(encoding="utf-8")
    (path := tmp_path / "mine.yaml").write_text(text, encoding="utf-8")
    assert main(["config", str(path)]) == 0
    assert capsys.readouterr().err == ""
    text = text.replace("43.27 kHz", "30 kHz").replace("inertia: none", "inertia: auto")
    path.write_text(text, encoding="utf-8")
    assert main(["config", str(path)]) == 0
    note = "note: paper: true, but another actuator, gas.inertia auto: its pages name a variant"
    assert note in capsys.readouterr().err


def test_a_film_alone_is_shown_and_read_and_is_no_study(tmp_path, capsys):
    """It was told to lack three sections, which no command for forces needs."""
    (path := tmp_path / "film.yaml").write_text(SHORT.partition("screen:")[0], encoding="utf-8")
    assert main(["config", str(path)]) == 0
    shown, told = capsys.readouterr()
    assert "length_y: 0.016 # m\n" in shown
    assert "screen:" not in shown
    assert told.startswith(f"note: {path}: a film without a study: `squeezefilm simulate`")
    assert sf.Film.read(path).config.pad.length_y_m == 0.016
    with pytest.raises(InputError, match=r"`sf\.Film\.read` take it"):
        sf.load(path)


def test_a_film_alone_whose_pad_does_not_fit_is_invalid(tmp_path, refused):
    """It was shown as if it could be simulated."""
    film = SHORT.partition("screen:")[0].replace("12 mm", "80 mm")
    (path := tmp_path / "film.yaml").write_text(film, encoding="utf-8")
    assert f"{path}: pad: it reaches" in refused("config", path)


def test_the_origin_of_a_scan_is_a_place_in_its_file(tmp_path):
    measured = "{kind: measured, file: scan.csv, origin: [100 mm, 0]}"
    written = parse_config(SHORT.replace("{kind: piston}", measured), path=tmp_path / "mine.yaml")
    assert written.smoothing_arguments["settings"].origin_m == (0.1, 0.0)


def test_constants_of_a_formula_have_units_and_stay_in_the_whole_study(tmp_path):
    """`12 mm` is 0.012 in metres; an angle is in radians, as in the formula's functions."""
    formula = (
        "{kind: formula, expression: cos(4*pi*x/w + turn), constants: {w: 12 mm, turn: 30 deg}}"
    )
    text = SHORT.replace("{kind: piston}", formula)
    written = parse_config(text, path=tmp_path / "mine.yaml")
    again = parse_config(effective_yaml(written), path=tmp_path / "mine.yaml")
    assert again.actuator == written.actuator
    x_m = np.linspace(-0.02, 0.02, 9)
    exact = np.cos(4 * pi * x_m / 0.012 + pi / 6)
    assert again.read_profile().amplitude(x_m=x_m, y_m=0 * x_m) == pytest.approx(exact, abs=1e-6)
    with pytest.raises(InputError, match=r"constants\.w: '12 mn' is no number with a unit"):
        check_study(parse_config(text.replace("w: 12 mm", "w: 12 mn"), path=tmp_path / "mine.yaml"))


def test_thin_air_is_thin_in_every_number():
    """At a tenth of the pressure slip is ten times what it is; it was that of dense air."""
    gas = study(gas={"ambient_pressure": 10132.5}).gas
    assert gas.density_kg_per_m3 == pytest.approx(0.1204)
    dense = study().gas.mean_free_path_m
    assert gas.mean_free_path_m == pytest.approx(10 * dense)
    written = study(gas={"ambient_pressure": 10132.5, "mean_free_path": 5e-7}).gas
    assert written.mean_free_path_m == 5e-7
    assert written.density_kg_per_m3 == gas.density_kg_per_m3


# Viscosities of the CRC Handbook (Huber and Harvey) at 300 and 400 K, in a file for its length.
HANDBOOK = pd.read_csv(Path(__file__).with_name("handbook_gases.csv"), index_col="gas")


@pytest.mark.parametrize("kelvin", [300, 400])
@pytest.mark.parametrize("name", HANDBOOK.index)
def test_a_gas_has_the_numbers_of_handbooks_by_its_name_and_temperature(name, kelvin):
    written, keys = HANDBOOK.loc[name], {"name": name, "ambient_pressure": "2 bar"}
    gas = study(gas=keys | {"ambient_temperature": f"{kelvin - 273.15} °C"}).gas
    assert gas.viscosity_pa_s == pytest.approx(1e-6 * written[f"upa_s_{kelvin}_k"], rel=0.01)
    ideal = 2e5 * 1e-3 * written.g_per_mol / (8.314 * kelvin)
    assert gas.density_kg_per_m3 == pytest.approx(ideal, rel=0.01)
    kinetic = gas.viscosity_pa_s * sqrt(pi / 2 / 2e5 / ideal)
    assert gas.mean_free_path_m == pytest.approx(kinetic, rel=0.01)


@pytest.mark.parametrize("gas", [{}, {"name": "helium"}, {"viscosity": 1.8e-5, "density": 1.3}])
def test_the_mean_free_path_is_that_of_the_gas_s_own_viscosity_pressure_and_density(gas):
    """Maxwell's μ √(π/(2 p ρ)), for air too; air had 67 nm beside 64.95 nm of its own numbers."""
    own = study(gas=gas).gas
    kinetic = sqrt(pi / 2 / own.ambient_pressure_pa / own.density_kg_per_m3)
    assert own.mean_free_path_m == pytest.approx(own.viscosity_pa_s * kinetic, rel=5e-5)
    assert Gas().mean_free_path_m == study().gas.mean_free_path_m


def test_a_circle_has_a_diameter():
    bare = SHORT.replace("{shape: ellipse, length_x: 12 mm, length_y: 16 mm}", "{}")
    circle, ellipse = {"shape": "circle", "diameter": "9 mm"}, {"length_x": 9e-3, "length_y": 9e-3}
    assert study(bare, pad=circle).pad == study(bare, pad=ellipse | {"shape": "ellipse"}).pad
    circles = [circle | {"length_x": 1}, {"shape": "circle"}, {"shape": "circle", "diametre": 1}]
    told = [r"pad\.diameter: ", r"pad\.length_x: ", "missing 'diameter'", "mean 'diameter'"]
    for wrong, text in zip([ellipse | {"diameter": 1e-3}, *circles], told, strict=True):
        with pytest.raises(InputError, match=text):
            study(bare, pad=wrong)
