"""Answers beside the force: closed forms, identities of physics and quotients; or a reason."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from math import pi
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from derivative_errors import drawn
from films import H0_M, LENGTH_M, PISTON, PRESSURE_PA, film
from output_errors import ASKED, shares, with_inertia
from physics_facts import piston_response

from squeezefilm.api.simulation import merge_forces
from squeezefilm.cli.main import main
from squeezefilm.film.finger import GapShape
from squeezefilm.film.profiles import StandingWave, make_profile
from squeezefilm.film.scene import Scene
from squeezefilm.film.surfaces import Disc
from squeezefilm.quantities import outputs as module
from squeezefilm.quantities.adjoint import Fields, dot
from squeezefilm.quantities.outputs import AROUND, STEP, at_ends, quotient, refusals, with_outputs
from squeezefilm.quantities.pressure import pressure
from squeezefilm.reynolds import solve
from squeezefilm.reynolds.device import choose_device
from squeezefilm.reynolds.grid import Grid
from squeezefilm.reynolds.periodic.launch import solve_batch
from squeezefilm.reynolds.problems import problems_of
from squeezefilm.solution import OUTPUTS, Outputs
from squeezefilm.tables import OUTPUT_COLUMNS, read_forces, write_table

AREA_M2 = LENGTH_M**2
FORCE_N = PRESSURE_PA * AREA_M2


def outputs(scene: Scene, *names: str, tolerance: float = 1e-6) -> Outputs:
    solutions = solve([scene], tolerance=1e-2)
    asked = names or ASKED
    (solution,) = with_outputs([scene], solutions, outputs=asked, tolerance=tolerance)
    assert solution.outputs is not None
    return solution.outputs


def wave(crest: float, *, direction_deg: float = 0.0) -> StandingWave:
    """Crests 1.5 sides apart, the first so many wavelengths from the finger's centre."""
    length_m = 1.5 * LENGTH_M
    return StandingWave(length_m, direction_deg, crest_m=crest * length_m)


class WithUnknowns(Fields):
    """A film's fields and the state that they are of."""

    unknowns: np.ndarray


def on_nodes(scene: Scene, *, points: int, instants: int) -> WithUnknowns:
    """The film's own fields on one grid, whole."""
    grid = Grid(nx=points, ny=points, nt=instants, fold_x=False, fold_y=False)
    state = solve_batch([scene], grid, tolerance=1e-10, device=choose_device())
    assert state.status[0] == 0
    problems = problems_of([scene], grid, tolerance=1e-10)
    fields = WithUnknowns(problems, grid, state.overpressure)
    fields.unknowns = state.unknowns[0]
    return fields


@pytest.mark.parametrize("sigma", [2.0, 20.0, 300.0])
def test_first_harmonics_of_a_small_piston_are_those_of_the_linear_series(sigma: float) -> None:
    scene = film(epsilon=1e-3, sigma=sigma, profile=PISTON)
    found = outputs(scene, "harmonics")
    spring, damping = piston_response(sigma)
    speed = scene.actuator.angular_frequency_rad_per_s
    assert found.value["force_sin"] == pytest.approx(-1e-3 * spring * FORCE_N, rel=1e-5)
    assert found.value["force_cos"] == pytest.approx(-1e-3 * damping * FORCE_N, rel=1e-5)
    assert found.value["film_stiffness"] == pytest.approx(spring * FORCE_N / H0_M, rel=1e-5)
    assert found.value["film_damping"] == pytest.approx(damping * FORCE_N / H0_M / speed, rel=1e-5)


def test_a_piston_puts_in_what_its_damping_takes_at_any_amplitude() -> None:
    """Power is ½ c (ω hv)², as the whole surface moves alike."""
    scene = film(epsilon=0.6, sigma=40.0, profile=PISTON)
    found = outputs(scene, "power", "harmonics").value
    speed = scene.hv_m * scene.actuator.angular_frequency_rad_per_s
    assert found["power"] == pytest.approx(found["film_damping"] * speed**2 / 2, rel=1e-9)


FILMS = {
    "off the centre": film(epsilon=0.44, sigma=583.0, x=0.2, y=0.1),
    "thick": film(epsilon=0.5, sigma=2.0, x=0.1),
    "slip": film(epsilon=0.3, sigma=200.0, x=0.2, rarefaction="slip"),
    "polytropic": film(
        epsilon=0.4, sigma=200.0, y=0.1, rarefaction="slip", polytropic_exponent=1.4
    ),
}


@pytest.mark.parametrize("name", FILMS)
def test_the_power_put_in_is_what_friction_takes(name: str) -> None:
    """−⟨∫P ∂H/∂T⟩ = (1/σ) ⟨∫Σ c_k H^(3−k) ρ^(−k) |∇P|²⟩ at rest, whatever the gas."""
    scene = FILMS[name]
    fields = on_nodes(scene, points=40, instants=24)
    loss = -float(fields.mean(fields.gap * dot(fields.velocity, fields.slope))[0])
    found = outputs(scene, "power")
    unit = FORCE_N * H0_M * scene.actuator.angular_frequency_rad_per_s
    assert found.value["power"] == pytest.approx(unit * loss, rel=1e-5)
    assert abs(found.value["power"] - unit * loss) <= found.error["power"] + 1e-6 * unit * loss


@pytest.mark.parametrize("name", FILMS)
def test_thrust_is_the_shear_at_the_finger_s_wall(name: str) -> None:
    """−⟨∫(h/2) ∇p⟩, here by the pressure's own slope."""
    scene = FILMS[name]
    fields = on_nodes(scene, points=40, instants=24)
    slope = fields.gradient(fields.pressure - 1)
    unit = FORCE_N * H0_M / LENGTH_M
    found = outputs(scene, "thrust")
    for thrust, along in (("thrust_x", slope[0]), ("thrust_y", slope[1])):
        shear = -unit * float(fields.mean(fields.gap * along)[0]) / 2
        assert found.value[thrust] == pytest.approx(shear, rel=1e-5, abs=1e-8 * unit)


@pytest.mark.parametrize("rarefaction", ["none", "slip"])
def test_what_flows_over_the_rim_with_inertia_is_what_the_film_loses(rarefaction: str) -> None:
    scene = film(
        epsilon=0.3, sigma=300.0, x=0.2, y=0.1, inertia="included", rarefaction=rarefaction
    )
    fields = on_nodes(scene, points=32, instants=16)
    grid, unknowns = fields.grid, fields.unknowns
    over_rim = 0.0
    for which, along in ((0, grid.y), (1, grid.x)):
        gap, velocity = at_ends(scene, grid, unknowns, which=which)
        ends = np.einsum("ent,n->et", gap * velocity, along.weights)
        over_rim = over_rim + ends[1] - ends[0]
    weights = fields.along_x.weights, fields.along_y.weights
    inside = np.einsum("xyt,x,y->t", fields.mass[0], *weights)
    loss = -grid.t.derivative @ inside
    assert over_rim == pytest.approx(loss, abs=5e-5 * np.abs(loss).max())


def test_thrust_of_a_gas_with_inertia_lacks_half_of_what_leaves_over_the_rim() -> None:
    scene = film(epsilon=0.4, sigma=300.0, x=0.2, inertia="included")
    fields = on_nodes(scene, points=32, instants=16)
    gap, velocity = at_ends(scene, fields.grid, fields.unknowns, which=0)
    left, right = (6 / 5 * gap * velocity**2).mean(axis=-1) @ fields.grid.y.weights
    # In units of p0 h0/l0: 12 μ ω l0²/(p0 h0²) times ρ0 ω h0²/μ is 12 ρ0 (ω l0)²/p0.
    out = scene.sigma * scene.modified_reynolds / 12 * (right - left)
    slope = fields.gradient(fields.pressure - 1)[0]
    shear = -float(fields.mean(fields.gap * slope)[0]) / 2
    found = outputs(scene, "thrust", tolerance=1e-5).value["thrust_x"]
    assert found == pytest.approx((shear - out / 2) * FORCE_N * H0_M / LENGTH_M, rel=1e-4)
    assert abs(out) > 0.1 * abs(shear)


def test_a_tilted_pad_over_a_piston_is_pushed_by_half_its_slope() -> None:
    """∇h is the pad's own slope, so that −F₀/2 of it is left: towards where the gap closes."""
    scene = film(epsilon=0.4, sigma=100.0, profile=PISTON)
    scene = replace(scene, finger=replace(scene.finger, gap=GapShape(tilt_x_m=0.2 * H0_M)))
    (solution,) = solve([scene], tolerance=1e-4)
    found = outputs(scene, "thrust", tolerance=1e-4)
    expected = -0.2 * H0_M / LENGTH_M * solution.force_n / 2
    assert found.value["thrust_x"] == pytest.approx(expected, rel=1e-3)
    assert abs(found.value["thrust_x"] - expected) <= found.error["thrust_x"] + 1e-4 * -expected


@pytest.mark.parametrize("inertia", ["none", "included"])
@pytest.mark.parametrize("crest", [0.0, 0.25], ids=["crest", "node"])
def test_no_thrust_on_a_crest_or_a_node_of_a_standing_wave(crest: float, inertia: str) -> None:
    scene = film(epsilon=0.4, sigma=300.0, profile=wave(crest), inertia=inertia)
    found = outputs(scene, "thrust", tolerance=1e-5)
    beside = outputs(film(epsilon=0.4, sigma=300.0, profile=wave(0.1)), "thrust")
    size = abs(beside.value["thrust_x"])
    assert size > 1e-6 * FORCE_N * H0_M / LENGTH_M
    if crest == 0:  # seen in the symmetry
        assert found.value["thrust_x"] == found.error["thrust_x"] == 0
    for name in ("thrust_x", "thrust_y"):
        assert abs(found.value[name]) <= min(found.error[name], 1e-4 * size) + 1e-12 * size


def test_thrust_and_centre_turn_with_the_wave_and_mirror_with_it() -> None:
    along_x, along_y, mirrored = (
        outputs(film(epsilon=0.4, sigma=300.0, profile=profile), tolerance=1e-5)
        for profile in (wave(0.1), wave(0.1, direction_deg=90.0), wave(-0.1))
    )
    for name in ("thrust", "centre"):
        value = along_x.value[f"{name}_x"]
        allowed = 1e-4 * abs(value)
        assert abs(value) > 0
        assert along_y.value[f"{name}_y"] == pytest.approx(value, abs=allowed)
        assert mirrored.value[f"{name}_x"] == pytest.approx(-value, abs=allowed)
        assert abs(along_x.value[f"{name}_y"]) <= allowed


def test_a_turned_finger_has_its_answers_along_the_actuator_s_axes() -> None:
    """A square turned by a quarter is the same square."""
    scene = film(epsilon=0.4, sigma=300.0, x=0.2, y=0.1)
    turned = replace(scene, finger=replace(scene.finger, rotation_deg=90.0))
    plain, other = (outputs(each, tolerance=1e-5) for each in (scene, turned))
    for name, value in plain.value.items():
        doubt = plain.error[name] + other.error[name]
        assert abs(other.value[name] - value) <= doubt, name
    assert plain.value["centre_x"] < 0  # towards the crest, which is at −x of the finger
    assert plain.value["moment_y"] > 0  # that lifts the finger's side at −x


def test_centre_and_moments_are_those_of_the_pressure_field() -> None:
    scene = film(epsilon=0.4, sigma=300.0, x=0.2, y=0.1, aspect=1.3)
    nodes, shares = np.polynomial.legendre.leggauss(40)
    across = (1 + nodes) / 2
    field = pressure(
        scene, x=across, y=across, instants=16, tolerance=1e-5, device=choose_device()
    ).values
    mean = np.einsum("tyx,y,x->yx", field, shares / 2, shares / 2) / len(field)
    x_m, y_m = LENGTH_M * (across - 0.5), 1.3 * LENGTH_M * (across - 0.5)
    force_n, about_x, about_y = (
        1.3 * FORCE_N * each for each in (mean.sum(), (y_m @ mean).sum(), -(mean @ x_m).sum())
    )
    found = outputs(scene, "centre", "moments").value
    assert found["moment_x"] == pytest.approx(about_x, rel=1e-4)
    assert found["moment_y"] == pytest.approx(about_y, rel=1e-4)
    assert found["centre_x"] == pytest.approx(-about_y / force_n, rel=1e-4)
    assert found["centre_y"] == pytest.approx(about_x / force_n, rel=1e-4)


def test_extremes_lie_between_the_nodes_too() -> None:
    """Beside a field at many places."""
    scene = FILMS["off the centre"]
    found = outputs(scene, "extremes")
    field = pressure(
        scene,
        x=np.linspace(0, 1, 101),
        y=np.linspace(0, 1, 101),
        instants=96,
        tolerance=1e-5,
        device=choose_device(),
    ).values
    for name, there in (("largest", field.max()), ("least", field.min())):
        value = found.value[f"{name}_overpressure"]
        doubt = found.error[f"{name}_overpressure"]
        assert doubt < 5e-4 * abs(value)
        assert value == pytest.approx(PRESSURE_PA * there, rel=3e-4)
        assert abs(value) >= PRESSURE_PA * abs(there) - doubt


@pytest.mark.parametrize("rarefaction", ["none", "slip"])
def test_friction_of_a_surface_that_slides_is_couette_s(rarefaction: str) -> None:
    """A film that hardly vibrates: μ U A/(h0 + 2λ) towards where the surface moves."""
    scene = film(epsilon=1e-4, sigma=50.0, bearing=2.0, rarefaction=rarefaction)
    turned = replace(scene, finger=replace(scene.finger, rotation_deg=30.0))
    path_m = scene.gas.mean_free_path_m if rarefaction == "slip" else 0.0
    drag = scene.gas.viscosity_pa_s * scene.finger.speed_x_m_per_s * AREA_M2 / (H0_M + 2 * path_m)
    found = outputs(turned, "thrust").value
    assert found["sliding_friction"] == pytest.approx(drag, rel=1e-6)
    along = found["thrust_x"], found["thrust_y"]
    assert along == pytest.approx((drag * np.cos(pi / 6), drag / 2), rel=1e-5)


def test_static_stiffness_is_a_quotient_of_forces_simulated_anew() -> None:
    """With inertia by a quotient of its own."""
    light = film(epsilon=0.44, sigma=583.0, x=0.2)
    heavy = film(epsilon=0.44, sigma=583.0, inertia="included")
    for scene, tolerance, step, rel in ((light, 1e-7, 2e-3, 1e-5), (heavy, 1e-4, 5e-3, 5e-3)):
        found = outputs(scene, "static_stiffness", tolerance=tolerance)
        gaps = [scene.h0_m * (1 + k * step) for k in (-2, -1, 1, 2)]
        moved = [replace(scene, h0_m=gap) for gap in gaps]
        forces = solve(moved, tolerance=tolerance / 10, method="periodic")
        a, b, c, d = (each.force_n for each in forces)
        expected = -(a - 8 * b + 8 * c - d) / (12 * step * scene.h0_m)
        value = found.value["static_stiffness"]
        assert value == pytest.approx(expected, rel=rel)
        assert abs(value - expected) <= found.error["static_stiffness"] + rel * value / 10


def test_a_quotient_of_forces_is_exact_for_a_cubic() -> None:
    forces = [1 + x - 3 * x**2 + 50 * x**3 for x in (STEP * k for k in AROUND)]
    value, error = quotient(forces, [0.0] * len(AROUND), 1.0)
    assert value == pytest.approx(-1.0, rel=1e-12)
    assert error == pytest.approx(50 * STEP**2)
    assert quotient(forces, [0.0, 0.1, 0.1, 0.0], 1.0)[1] >= 0.1 / STEP


def test_errors_hold() -> None:
    """Beside answers a hundred times as good, of films of all kinds drawn at random."""
    for name, found in shares(with_inertia(drawn(6, seed=11)), tolerance=1e-3, judge=1e-5).items():
        assert max(found) < 1, name


def test_an_answer_that_agrees_by_chance_has_no_less_doubt_than_those_alike() -> None:
    """Two grids agree in the force's cosine part at ε 0.05 by chance: its sine part does not."""
    (scene,) = drawn(20, seed=15)[13:14]
    scene = replace(scene, hv_m=0.05 * scene.h0_m)
    for name in ("force_cos", "power"):
        (share,) = shares([scene], tolerance=1e-2, judge=1e-6)[name]
        assert share < 1, name


def test_errors_of_extremes_hold_where_grids_agree() -> None:
    """A film whose iteration left more at one place than in the mean."""
    found = shares(drawn(20, seed=28)[17:18], tolerance=1e-2, judge=1e-5)
    for name in ("largest_overpressure", "least_overpressure"):
        assert max(found[name]) < 1, name


@pytest.mark.parametrize(
    ("shape", "epsilon", "sigma"),
    [("1 - 60*abs(x - 0.001)", 0.385, 72.0), ("1 - 40*abs(0.8*x + 0.6*y - 0.001)", 0.633, 3410.0)],
)
def test_errors_hold_over_kinks_of_the_profile(shape: str, epsilon: float, sigma: float) -> None:
    kinked = make_profile(kind="formula", surface=Disc(0.01), expression=shape)
    scene = film(epsilon=epsilon, sigma=sigma, profile=kinked)
    for name, found in shares([scene], tolerance=1e-2, judge=1e-5).items():
        assert max(found) < 1, name


def test_a_shaped_gap_and_an_ellipse_have_the_answers_of_their_states() -> None:
    """A gap that is all but flat has those of a flat one; an ellipse those of symmetry."""
    flat = film(epsilon=0.4, sigma=100.0, x=0.2)
    shaped = replace(flat, finger=replace(flat.finger, gap=GapShape(bulge_m=1e-12)))
    one, other = (outputs(each, tolerance=1e-4) for each in (flat, shaped))
    for name, value in one.value.items():
        doubt = one.error[name] + other.error[name]
        assert abs(other.value[name] - value) <= doubt, name
        assert doubt <= 0.02 * abs(value) or value == 0 or "least" in name, name
    round_pad = replace(flat, x_m=0.0, finger=replace(flat.finger, shape="ellipse"))
    found = outputs(round_pad, tolerance=1e-3)
    assert abs(found.value["centre_x"]) <= found.error["centre_x"] < 1e-2 * LENGTH_M
    assert found.value["power"] > 3 * found.error["power"]


@pytest.mark.parametrize(
    ("scene", "output", "reason"),
    [
        (
            film(epsilon=0.3, sigma=300.0, bearing=1.0, rarefaction="fukui-kaneko"),
            "thrust",
            "not derived with fukui-kaneko",
        ),
        (film(epsilon=0.0, sigma=300.0), "harmonics", "at rest"),
        (
            film(epsilon=0.3, sigma=300.0, bearing=1.0, inertia="included"),
            "power",
            "no force",
        ),
    ],
)
def test_what_is_not_known_says_why(scene: Scene, output: str, reason: str) -> None:
    found = outputs(scene, tolerance=1e-3)
    assert reason in found.refused[output]
    missing = [name for name in OUTPUTS[output] if name not in found.value]
    assert missing
    assert f"{output}: " in found.status
    if reason != "no force":
        assert refusals(scene, tolerance=1e-3)[output] == found.refused[output]


def test_a_table_of_forces_has_what_its_study_asks_for_and_gathering_keeps_it(
    tmp_path: Path, repository, refused
) -> None:
    plan, output, whole = (tmp_path / name for name in ("plan.csv", "forces.csv", "all.csv"))
    rows = {"h0_m": 5e-6, "hv_m": [2e-6, 1e-6], "phi_r_m": [0.0, 2e-3], "phi_deg": 0.0}
    write_table(pd.DataFrame({"point_id": ["1", "2"], **rows}), plan)
    study = tmp_path / "study.yaml"
    quick = (repository / "config" / "quick.yaml").read_text(encoding="utf-8")
    asks = quick.replace("outputs: []", "outputs: [thrust, power]")
    study.write_text(asks, encoding="utf-8")
    command = ["simulate", str(plan), "--output", str(output), "--config", str(study)]
    assert main(command) == 0
    table = pd.read_csv(output)
    forces = list(read_forces(output))
    assert list(table)[len(forces) :] == [
        *("power_w", "power_error_w", "thrust_x_n", "thrust_x_error_n", "thrust_y_n"),
        *("thrust_y_error_n", "sliding_friction_n", "sliding_friction_error_n", "outputs_status"),
    ]
    assert set(list(table)[len(forces) :]) <= set(OUTPUT_COLUMNS)
    merge_forces(plan, [output], output=whole, keep_failed=False)
    pd.testing.assert_frame_equal(pd.read_csv(whole), table)
    assert "'lift' is none of" in refused(*command, "--outputs", "lift", status=2)


def test_a_dry_run_shows_which_outputs_a_study_asks_for_in_vain(
    tmp_path: Path, edited, capsys
) -> None:
    plan, output = tmp_path / "plan.csv", tmp_path / "previews.csv"
    rows = {"h0_m": 5e-6, "hv_m": [2e-6], "phi_r_m": [0.0], "phi_deg": 0.0}
    write_table(pd.DataFrame({"point_id": ["1"], **rows}), plan)
    slides = edited(gas={"rarefaction": "fukui-kaneko"}, finger={"speed_x_m_per_s": 0.1})
    study = json.loads(slides.read_text(encoding="utf-8")) | {"outputs": ["power", "thrust"]}
    slides.write_text(json.dumps(study), encoding="utf-8")
    assert (
        main(["simulate", str(plan), "--dry-run", f"--config={slides}", f"--output={output}"]) == 0
    )
    reason = "thrust: the shear of a sliding wall is not derived with fukui-kaneko"
    assert f"outputs_refused    {reason}" in capsys.readouterr().out
    assert list(pd.read_csv(output)["outputs_refused"]) == [reason]


def test_the_page_shows_what_comes_out(repository: Path, capsys) -> None:
    page = (repository / "docs" / "outputs.md").read_text(encoding="utf-8")
    command = next(line for line in page.splitlines() if line.endswith(" --outputs all"))
    assert main(command.split()[2:]) == 0
    shown, printed = (
        dict(re.findall(r"^ *(\w+): (\S+ ± \S+ .*)$", text, re.MULTILINE))
        for text in (capsys.readouterr().out, page)
    )
    names = [name for numbers in OUTPUTS.values() for name in numbers]
    assert list(shown) == list(printed) == names
    for name, line in shown.items():
        value, _, error, unit = line.split(maxsplit=3)
        documented, *_, documented_unit = printed[name].split(maxsplit=3)
        assert abs(float(value) - float(documented)) <= float(error), name
        assert unit == documented_unit


def test_a_scene_that_ends_in_an_unexpected_error_leaves_the_others_theirs(monkeypatch) -> None:
    """A film that the state cannot be read of."""
    scenes = [FILMS["thick"], replace(FILMS["thick"], point_id="bad")]
    read = module.sample_of

    def fail(scene: Scene, *state: object) -> object:
        if scene.point_id == "bad":
            raise ArithmeticError("no film")
        return read(scene, *state)

    monkeypatch.setattr(module, "sample_of", fail)
    solutions = solve(scenes, tolerance=1e-2)
    good, bad = (
        each.outputs for each in with_outputs(scenes, solutions, outputs=("power",), tolerance=1e-2)
    )
    assert good is not None
    assert bad is not None
    assert good.status == "ok"
    assert bad.status == "power: unexpected error: ArithmeticError: no film"
