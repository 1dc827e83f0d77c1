"""Positions that symmetry makes equal have equal forces, and all others are in the space."""

from typing import Any

import numpy as np
import pandas as pd
import pytest
from changed_sections import changed

from squeezefilm.config.study import Study
from squeezefilm.film.symmetry import DirectionSector
from squeezefilm.reynolds import solve
from squeezefilm.studies.plans import plan_point_counts
from squeezefilm.studies.space import pad_positions, space_of_study
from squeezefilm.studies.study import scenes_of_table

RECTANGLE = {"length_x_m": 0.0098, "length_y_m": 0.007}
SMALL = {"length_x_m": 0.009, "length_y_m": 0.009}
CIRCLE = {"shape": "ellipse", **SMALL}
WAVE = {"kind": "standing-wave", "wavelength_m": 0.03, "direction_deg": 0.0, "crest_m": 0.0}
ASKEW = {**WAVE, "direction_deg": 20.0}
SCAN = {"kind": "measured", "file": "vibrometer.csv"}


def tilted(x_m: float, y_m: float) -> dict[str, Any]:
    return {"gap": {"tilt_x_m": x_m, "tilt_y_m": y_m, "crown_m": 5e-7}}


def bessel(nodal_diameters: int) -> dict[str, Any]:
    mode = {"wave_number_rad_per_m": 400.0, "edge_share": 0.01, "direction_deg": 0.0}
    return {"kind": "bessel", "nodal_diameters": nodal_diameters, **mode}


# The pad, the profile (none: the paper's sinc), and where the sector begins and ends.
CASES: dict[str, tuple[dict[str, Any], dict[str, Any] | None, tuple[float, float]]] = {
    "square": ({}, None, (0, 45)),
    "circle": (CIRCLE, None, (0, 45)),
    "rectangle": (RECTANGLE, None, (0, 90)),
    "turned rectangle": ({**RECTANGLE, "rotation_deg": 20}, None, (20, 110)),
        "tilted square": (tilted(1e-6, 0), None, (0, 180)),
            "tilted circle": ({**CIRCLE, **tilted(1e-6, 1e-6)}, None, (45, 225)),
    "wave": ({}, WAVE, (0, 90)),
            "wave off its crest at an angle": ({}, {**ASKEW, "crest_m": 1e-3}, (0, 360)),
    "two nodal diameters": ({}, bessel(2), (0, 45)),
        "scan": ({}, {**SCAN, "axisymmetric": False}, (0, 360)),
    "formula without symmetry": ({}, {"kind": "formula", "expression": "1 + 20*x + 9*y"}, (0, 360)),
}  # fmt: skip


def study(quick: Study, pad: dict[str, Any], profile: dict[str, Any] | None = None) -> Study:
    return changed(quick, pad=pad, actuator={"profile": profile} if profile else {})


@pytest.mark.parametrize("case", CASES)
def test_the_sector_of_positions_is_that_of_pad_and_vibration(case, quick):
    pad, profile, (start, stop) = CASES[case]
    directions = study(quick, pad, profile).symmetry()
    assert (directions.start_deg, directions.stop_deg) == pytest.approx((start, stop))


@pytest.mark.parametrize("case", [case for case, (*_, sector) in CASES.items() if sector[1] < 360])
def test_a_direction_and_its_fold_have_one_force(case, quick):
    """At its images by both edges of the sector, or by a turn of its width: they make all."""
    config = study(quick, *CASES[case][:2])
    directions = config.symmetry()
    width = directions.width_deg
    images = (11, -11, 2 * width - 11) if directions.mirror else (11, 11 + width)
    angles = [directions.start_deg + image for image in images]
    assert directions.fold_directions(angles) == pytest.approx(directions.start_deg + 11)
    at = {"h0_m": 9e-6, "hv_m": 2e-6, "phi_r_m": 0.0007}
    scenes = scenes_of_table(pd.DataFrame({"phi_deg": angles}).assign(**at), config)
    solutions = solve(scenes, tolerance=1e-3)
    assert {solution.status for solution in solutions} == {"ok"}
    force = [solution.force_n for solution in solutions]
    error = max(solution.force_error_n for solution in solutions)
    np.testing.assert_allclose(force, force[0], atol=2 * error, rtol=0)


def test_the_template_s_directions_stand_for_all_that_differ(quick):
    assert DirectionSector(0, 45, mirror=True).equivalent_directions_deg([0, 15, 30, 45]) == [
        0,
        15,
        30,
        45,
    ]
    assert DirectionSector(0, 180, mirror=True).equivalent_directions_deg([0, 45]) == [
        0,
        45,
        90,
        135,
        180,
    ]
    assert DirectionSector(0, 180, mirror=False).equivalent_directions_deg([0, 45]) == [
        0,
        45,
        90,
        135,
    ]
    rectangle = study(quick, RECTANGLE)
    places = pad_positions(rectangle)
    assert {angle for _, angle in places} == {0, 45, 90}
    assert plan_point_counts(rectangle)["four_factor"] == len(places) * quick.design.points
    assert space_of_study(rectangle).limits["phi_deg"] == (0, 90)
    assert space_of_study(rectangle).limits["phi_deg"] == (0, 90)
