"""Positions that symmetry makes equal have equal forces, and all others are in the space."""

from typing import Any

import numpy as np
import pandas as pd
import pytest

from squeezefilm.cli import main as cli
from squeezefilm.config.loading import Config, load_config
from squeezefilm.errors import InputError
from squeezefilm.film.symmetry import Directions, symmetry_from_dict
from squeezefilm.reynolds import solve
from squeezefilm.studies.plans import box_of, finger_positions, plan_sizes
from squeezefilm.studies.space import Space
from squeezefilm.studies.study import check_study, scene_of, scenes_in, symmetry_of

RECTANGLE = {"length_x_m": 0.0098, "length_y_m": 0.007}
SMALL = {"length_x_m": 0.009, "length_y_m": 0.009}
CIRCLE = {"shape": "ellipse", **SMALL}
WAVE = {"kind": "standing-wave", "wavelength_m": 0.03, "direction_deg": 0.0, "crest_m": 0.0}
ASKEW = {**WAVE, "direction_deg": 20.0}
SCAN = {"kind": "measured", "file": "vibrometer.csv"}


def tilted(x_m: float, y_m: float) -> dict[str, Any]:
    return {"gap": {"tilt_x_m": x_m, "tilt_y_m": y_m, "bulge_m": 5e-7}}


def bessel(nodal_diameters: int) -> dict[str, Any]:
    mode = {"wave_number_rad_per_m": 400.0, "edge_share": 0.01, "direction_deg": 0.0}
    return {"kind": "bessel", "nodal_diameters": nodal_diameters, **mode}


# The finger, the profile (none: the paper's sinc), and where the sector begins and ends.
CASES: dict[str, tuple[dict[str, Any], dict[str, Any] | None, tuple[float, float]]] = {
    "square": ({}, None, (0, 45)),
    "circle": (CIRCLE, None, (0, 45)),
    "rectangle": (RECTANGLE, None, (0, 90)),
    "turned rectangle": ({**RECTANGLE, "rotation_deg": 20}, None, (20, 110)),
    "sliding square": ({"speed_x_m_per_s": 2.0}, None, (0, 180)),
    "tilted square": (tilted(1e-6, 0), None, (0, 180)),
    "tilted along the diagonal": (tilted(1e-6, 1e-6), None, (45, 225)),
    "tilted otherwise": (tilted(1e-6, 5e-7), None, (0, 360)),
    "tilted circle": ({**CIRCLE, **tilted(1e-6, 1e-6)}, None, (45, 225)),
    "wave": ({}, WAVE, (0, 90)),
    "wave off its crest": ({}, {**WAVE, "crest_m": 0.001}, (0, 180)),
    "wave at an angle, circle": (CIRCLE, ASKEW, (20, 110)),
    "wave off its crest at an angle": ({}, {**ASKEW, "crest_m": 1e-3}, (0, 360)),
    "two nodal diameters": ({}, bessel(2), (0, 45)),
    "axisymmetric scan": ({}, {**SCAN, "axisymmetric": True}, (0, 45)),
    "scan": ({}, {**SCAN, "axisymmetric": False}, (0, 360)),
    "formula without symmetry": ({}, {"kind": "formula", "expression": "1 + 20*x + 9*y"}, (0, 360)),
}  # fmt: skip


def study(quick: Config, finger: dict[str, Any], profile: dict[str, Any] | None = None) -> Config:
    sections = {**quick, "finger": quick["finger"] | finger}
    if profile:
        sections["actuator"] = quick["actuator"] | {"profile": profile}
    return Config(path=quick.path, sections=sections)


@pytest.mark.parametrize("case", CASES)
def test_the_sector_of_positions_is_that_of_pad_and_vibration(case, quick):
    finger, profile, (start, stop) = CASES[case]
    directions = symmetry_of(study(quick, finger, profile))
    assert (directions.start_deg, directions.stop_deg) == pytest.approx((start, stop))


@pytest.mark.parametrize("case", [case for case, (*_, sector) in CASES.items() if sector[1] < 360])
def test_a_direction_and_its_fold_have_one_force(case, quick):
    """At its images by both edges of the sector, or by a turn of its width: they make all."""
    config = study(quick, *CASES[case][:2])
    directions = symmetry_of(config)
    width = directions.width_deg
    images = (11, -11, 2 * width - 11) if directions.mirror else (11, 11 + width)
    angles = [directions.start_deg + image for image in images]
    assert directions.fold(angles) == pytest.approx(directions.start_deg + 11)
    at = {"h0_m": 9e-6, "hv_m": 2e-6, "phi_r_m": 0.0007}
    scenes = scenes_in(pd.DataFrame({"phi_deg": angles}).assign(**at), config)
    solutions = solve(scenes, tolerance=1e-3)
    assert {solution.status for solution in solutions} == {"ok"}
    force = [solution.force_n for solution in solutions]
    error = max(solution.force_error_n for solution in solutions)
    np.testing.assert_allclose(force, force[0], atol=2 * error, rtol=0)


def test_the_template_s_directions_stand_for_all_that_differ(quick):
    given = [0, 15, 30, 45]
    assert Directions(0, 45, mirror=True).images(given) == given
    assert Directions(0, 90, mirror=True).images(given) == [0, 15, 30, 45, 60, 75, 90]
    assert Directions(0, 180, mirror=True).images([0, 45]) == [0, 45, 90, 135, 180]
    assert Directions(0, 180, mirror=False).images([0, 45]) == [0, 45, 90, 135]
    assert Directions(0, 360, mirror=False).images([90]) == [0, 90, 180, 270]
    rectangle = study(quick, RECTANGLE)
    places = finger_positions(rectangle)
    assert {angle for _, angle in places} == {0, 45, 90}
    assert plan_sizes(rectangle)["four_factor"] == len(places) * quick["design"]["points"]
    assert box_of(rectangle).ranges["phi_deg"] == (0, 90)
    assert Space.of(rectangle, centred=False).box.upper[3] == 90


@pytest.mark.parametrize("phi_deg", [[0, 90], [180, 270]])
def test_any_direction_may_be_given(phi_deg, quick, tmp_path):
    sections = {**study(quick, RECTANGLE), "positions": {"phi_r_m": [0.001], "phi_deg": phi_deg}}
    config = check_study(Config(path=tmp_path / "study.yaml", sections=sections))
    assert {0.0, 90.0} <= {angle for _, angle in finger_positions(config)}


def test_a_pad_that_leaves_the_disc_between_the_directions_given_is_refused(quick):
    pad = study(quick, {"length_x_m": 0.014, "length_y_m": 0.009})
    sections = {**pad, "positions": {"phi_r_m": [0.0017], "phi_deg": [0, 90]}}
    with pytest.raises(
        InputError, match=r"positions: point \(phi_r_m = 0\.0017, phi_deg = 32\.7\d*\).* off the"
    ):
        check_study(Config(path=quick.path, sections=sections))


@pytest.fixture(scope="module")
def rectangle(repository, tmp_path_factory, script):
    """A folder with a 14 × 9 mm pad's study, and a model fitted to simulations of its space."""
    folder = tmp_path_factory.mktemp("rectangle")
    text = (repository / "config" / "quick.yaml").read_text(encoding="utf-8")
    for old, new in (
        ("length_x: 10 mm", "length_x: 14 mm"),
        ("length_y: 10 mm", "length_y: 9 mm"),
        ("surface_radius: 10 mm", "surface_radius: 12 mm"),
        ("tolerance: 1e-4", "tolerance: 1e-3"),
    ):
        assert old in text
        text = text.replace(old, new)
    config = folder / "study.yaml"
    config.write_text(text, encoding="utf-8")
    design = "point_id,h0_m,hv_m,phi_r_m,phi_deg,origin\n1,5e-6,2e-6,0,0,A\n2,8e-6,1e-6,0,0,A\n"
    (folder / "design.csv").write_text(design, encoding="utf-8")
    names = {name: f"{folder}/{name}.csv" for name in ("design", "scenes", "forces")}
    sample = {name: f"{folder}/sample_{name}.csv" for name in ("scenes", "forces")}
    study = f"--config={config}"
    design_of_plan = {"four_factor": [names["design"]], "validation_four_factor": []}
    for plan, files in (("four_factor", names), ("validation_four_factor", sample)):
        sources = design_of_plan[plan]
        script("plan", config, input={"sources": sources}, output=files["scenes"], plan=plan)
    for words in (
        ["simulate", names["scenes"], f"--output={names['forces']}"],
        ["simulate", sample["scenes"], f"--output={sample['forces']}"],
        [
            *("fit", names["forces"], "--model=limit_1"),
            *(f"--sample={sample['forces']}", f"--output={folder}/fit.json"),
        ],
    ):
        assert cli.main([*words, study]) == 0
    return folder


def test_a_prediction_is_the_simulation_wherever_the_finger_is(rectangle):
    config, out = load_config(rectangle / "study.yaml"), rectangle / "out.csv"
    words = ["predict", f"{rectangle}/fit.json", "--h0=6um", "--hv=2um", f"--output={out}"]
    assert cli.main([*words, "--x=-1.5mm,0mm,2mm", "--y=-1mm,0mm,2mm"]) == 0
    table = pd.read_csv(out)
    scenes = [
        scene_of(config, 6e-6, 2e-6, x_m=x, y_m=y)
        for x, y in zip(table["x_m"], table["y_m"], strict=True)
    ]
    simulated = [solution.force_n for solution in solve(scenes, tolerance=1e-4)]
    np.testing.assert_allclose(table["force_n"], simulated, rtol=3e-3)
    assert table["note"].isna().all()
    assert np.ptp(simulated) > 0.03 * np.max(simulated)


@pytest.mark.parametrize("damage", [{"width_deg": 60}, {"start_deg": float("nan")}])
def test_damaged_directions_are_refused(damage):
    plain = Directions(30.0, 45.0, mirror=True).to_dict()
    assert symmetry_from_dict(plain, place="here") == Directions(30.0, 45.0, mirror=True)
    with pytest.raises(InputError, match="here: must have"):
        symmetry_from_dict(plain | damage, place="here")
