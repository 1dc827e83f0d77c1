"""Answers beside the force: closed forms, identities of physics and quotients; or a reason."""

from __future__ import annotations

from dataclasses import replace
from math import pi
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from films import H0_M, LENGTH_M, PISTON, PRESSURE_PA, at_reynolds, film, with_pad
from host_film import Fields
from numpy.polynomial.chebyshev import chebvander
from physics_facts import piston_response
from random_scenes import random_films, shares

from squeezefilm.cli.main import main
from squeezefilm.film.pad import GapShape
from squeezefilm.film.profiles import Formula, StandingWave
from squeezefilm.film.scene import Scene
from squeezefilm.film.surfaces import Disc
from squeezefilm.quantities.fields import dot
from squeezefilm.quantities.outputs import (
    STATE_OUTPUT_NAMES,
    missing_output_reasons,
    momentum_outflow_n,
    with_outputs,
)
from squeezefilm.quantities.pressure import gauge_pressure_and_change
from squeezefilm.reynolds import solve
from squeezefilm.reynolds.device import choose_device
from squeezefilm.reynolds.grid import Grid
from squeezefilm.reynolds.periodic.launch import solve_batch
from squeezefilm.reynolds.spectral import Axis, FluxPoints
from squeezefilm.solution import OUTPUT_COLUMNS, Outputs
from squeezefilm.table_writer import concatenate_force_parts, write_table
from squeezefilm.tables import read_forces

ASKED = tuple(name for name in OUTPUT_COLUMNS if name in STATE_OUTPUT_NAMES)
AREA_M2 = LENGTH_M**2
FORCE_N = PRESSURE_PA * AREA_M2


def outputs(scene: Scene, *names: str, tolerance: float = 1e-6) -> Outputs:
    solutions = solve([scene], tolerance=1e-2)
    asked = names or ASKED
    (solution,) = with_outputs([scene], solutions, outputs=asked, tolerance=tolerance)
    assert solution.outputs is not None
    return solution.outputs


def wave(crest: float, *, direction_deg: float = 0.0) -> StandingWave:
    """Crests 1.5 sides apart, the first so many wavelengths from the pad's centre."""
    length_m = 1.5 * LENGTH_M
    return StandingWave(length_m, direction_deg, crest_m=crest * length_m)


def on_nodes(scene: Scene, *, points: int, instants: int) -> Fields:
    """The film's own fields on one grid, whole."""
    grid = Grid(nx=points, ny=points, nt=instants, fold_x=False, fold_y=False)
    state = solve_batch([scene], grid, tolerance=1e-10, device=choose_device())
    assert state.status_indices[0] == 0
    return Fields.of([scene], grid, state.unknowns)


@pytest.mark.parametrize("sigma", [2.0, 20.0, 300.0])
def test_first_harmonics_of_a_small_piston_are_those_of_the_linear_series(sigma: float) -> None:
    scene = film(epsilon=1e-3, sigma=sigma, profile=PISTON)
    found = outputs(scene, "harmonics")
    spring, damping = piston_response(sigma)
    speed = scene.actuator.angular_frequency_rad_per_s
    assert found.value["force_in_phase"] == pytest.approx(-1e-3 * spring * FORCE_N, rel=1e-5)
    assert found.value["force_quadrature"] == pytest.approx(-1e-3 * damping * FORCE_N, rel=1e-5)
    assert found.value["film_stiffness"] == pytest.approx(spring * FORCE_N / H0_M, rel=1e-5)
    assert found.value["film_damping"] == pytest.approx(damping * FORCE_N / H0_M / speed, rel=1e-5)


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
    loss = -float(fields.mean(fields.gap * dot(fields.gap_mean_velocity, fields.slope))[0])
    found = outputs(scene, "power")
    unit = FORCE_N * H0_M * scene.actuator.angular_frequency_rad_per_s
    assert found.value["power"] == pytest.approx(unit * loss, rel=1e-5)
    assert abs(found.value["power"] - unit * loss) <= found.error["power"] + 1e-6 * unit * loss


@pytest.mark.parametrize("name", FILMS)
def test_thrust_is_the_shear_at_the_pad_s_wall(name: str) -> None:
    """−⟨∫(h/2) ∇p⟩, here by the pressure's own slope."""
    scene = FILMS[name]
    fields = on_nodes(scene, points=40, instants=24)
    slope = fields.gradient((1 + fields.gauge_pressure_ratio) - 1)
    unit = FORCE_N * H0_M / LENGTH_M
    found = outputs(scene, "thrust")
    for thrust, along in (("thrust_x", slope[0]), ("thrust_y", slope[1])):
        shear = -unit * float(fields.mean(fields.gap * along)[0]) / 2
        assert found.value[thrust] == pytest.approx(shear, rel=1e-5, abs=1e-8 * unit)


def interpolatory(nodes: np.ndarray) -> np.ndarray:
    """Weights on some nodes in [0, 1] by which their polynomial is integrated."""
    n = np.arange(len(nodes))
    integrals = np.where(n % 2, 0.0, 1 / (1.0 - n**2 + (n % 2)))
    return np.linalg.solve(chebvander(2 * nodes - 1, len(n) - 1).T, integrals)


def momentum_from_inside(scene: Scene, grid: Grid, unknowns: np.ndarray) -> np.ndarray:
    """Momentum that leaves over the rim by what happens inside, in newtons along x and y.

    ∇·(ρHūū) = ρH (ū·∇)ū − ū ∂(ρH)/∂T, and the momentum equation (terms/inertia.py) has (ū·∇)ū:
    in the mean over pad and period 70/(9 Re) b/H − (1/9) ū ∂(ρH)/∂T, without any value at the rim.
    With slip b is larger by 1 + 4 Kn/(ρH); the profile is a parabola's all the same.
    """
    assert isinstance(grid.x, Axis)
    slip = scene.slip_knudsen if scene.gas.rarefaction == "slip" else 0.0
    lengths, per_area = grid.axis_lengths(scene.aspect), scene.gas.density_kg_per_m3 * scene.h0_m
    per_area *= (scene.actuator.angular_frequency_rad_per_s) ** 2 * scene.pad.length_x_m
    parts: list[complex] = []
    for which in (0, 1):
        to_values: list[np.ndarray] = [np.eye(grid.nx), np.eye(len(grid.y.nodes))]
        to_slope, nodes = list(to_values), [grid.x.nodes, grid.y.nodes]
        along = (grid.x, grid.y)[which]
        if isinstance(along, Axis):
            nodes[which] = FluxPoints(along).all_points
            to_points = along.matrix_to_points(nodes[which])
            to_values[which] = to_points[:, 1:-1]
            to_slope[which] = (to_points @ along.derivative_matrix)[:, 1:-1]
        else:
            to_slope[which] = along.derivative_at_unknowns(odd=False)
        pressure, slope = (
            np.einsum("pa,abi,qb->pqi", *(each[0], unknowns[0], each[1]))
            for each in (to_values, to_slope)
        )
        places = np.meshgrid(*nodes, indexing="ij")
        gap = scene.gap(
            *(grid.outline.side_fractions(*places) if grid.outline else places), grid.t.nodes
        )
        deficit = unknowns[1 + which]
        mass = (1 + pressure) * gap
        mobility = gap**2 * (1 + 6 * slip / mass) / scene.sigma
        velocity = -mobility * slope / lengths[which] - deficit
        filling = mass @ grid.t.derivative_matrix.T
        inert = 70 / 9 / scene.modified_reynolds * deficit / (gap * (1 + 4 * slip / mass))
        field = inert - velocity * filling / 9
        turn = np.ones(field.shape[:2], dtype=complex)
        around = grid.y.quadrature_weights
        if grid.outline:  # over the conjugate of z′, in a mean with the area behind each point
            mu = grid.outline.edge_mu * (2 * places[0] - 1)
            turn = (
                grid.outline.conformal_map_slope(mu, places[1])
                * grid.outline.mean_edge_jacobian**0.5
            )
            turn = turn / grid.outline.mean_map_jacobian
        else:
            around = interpolatory(nodes[1])
        mean = interpolatory(nodes[0]) @ (field.mean(axis=-1) * turn) @ around
        parts.append(complex(mean) * (1j if which else 1))
    total = 6 / 5 * per_area * scene.pad.area_m2 * sum(parts)
    return np.array([total.real, total.imag])


@pytest.mark.parametrize(("rarefaction", "rel"), [("none", 3e-5), ("slip", 1e-3)])
def test_thrust_of_a_gas_with_inertia_lacks_half_of_what_leaves_over_the_rim(
    rarefaction: str, rel: float
) -> None:
    """With slip a profile's mean square is smaller, by the gap at the rim: here by that at rest."""
    scene = film(epsilon=0.4, sigma=300.0, x=0.2, inertia="included", rarefaction=rarefaction)
    fields = on_nodes(scene, points=32, instants=16)
    # In units of p0 h0/l0 times the area.
    unit = FORCE_N * H0_M / LENGTH_M
    out = momentum_from_inside(scene, fields.grid, fields.unknowns[0])[0] / unit
    if rarefaction == "slip":
        slip = scene.slip_knudsen
        out *= (1 + 10 * slip + 30 * slip**2) / (1 + 6 * slip) ** 2
    slope = fields.gradient((1 + fields.gauge_pressure_ratio) - 1)[0]
    shear = -float(fields.mean(fields.gap * slope)[0]) / 2
    found = outputs(scene, "thrust", tolerance=1e-5).value["thrust_x"]
    assert found == pytest.approx((shear - out / 2) * unit, rel=rel)
    assert abs(out) > 0.1 * abs(shear)


@pytest.mark.parametrize("shape", ["rectangle", "ellipse"])
def test_gas_that_flows_out_carries_its_velocity_along_the_rim(shape: str) -> None:
    """What leaves over the rim is what the balance of momentum inside says."""
    rotating = Formula("1 + 100*x", Disc(0.7 * LENGTH_M), "120*y")
    scene = film(epsilon=0.4, sigma=60.0, profile=rotating, inertia="included")
    scene = with_pad(at_reynolds(scene, 4), shape=shape)
    grid = Grid(32, 32, 24, fold_x=False, fold_y=False, outline=scene.pad.smooth_outline)
    state = solve_batch([scene], grid, tolerance=1e-10, device=choose_device())
    unknowns = state.unknowns[0]
    leaving = momentum_outflow_n(Fields.of([scene], grid, state.unknowns))
    expected = momentum_from_inside(scene, grid, unknowns)
    assert leaving == pytest.approx(expected, rel=2e-4)


def test_a_tilted_pad_over_a_piston_is_pushed_by_half_its_slope() -> None:
    """∇h is the pad's own slope, so that −F₀/2 of it is left: towards where the gap closes."""
    scene = film(epsilon=0.4, sigma=100.0, profile=PISTON)
    scene = with_pad(scene, gap=GapShape(tilt_x_m=0.2 * H0_M))
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


def test_a_turned_pad_has_its_answers_along_the_actuator_s_axes() -> None:
    """A square turned by a quarter is the same square."""
    scene = film(epsilon=0.4, sigma=300.0, x=0.2, y=0.1)
    turned = with_pad(scene, rotation_deg=90.0)
    plain, other = (outputs(each, tolerance=1e-5) for each in (scene, turned))
    for name, value in plain.value.items():
        doubt = plain.error[name] + other.error[name]
        assert abs(other.value[name] - value) <= doubt, name
    assert plain.value["centre_x"] < 0  # towards the crest, which is at −x of the pad
    assert plain.value["moment_y"] > 0  # that lifts the pad's side at −x


def test_centre_and_moments_are_those_of_the_pressure_field() -> None:
    scene = film(epsilon=0.4, sigma=300.0, x=0.2, y=0.1, aspect=1.3)
    nodes, shares = np.polynomial.legendre.leggauss(40)
    across = (1 + nodes) / 2
    field = gauge_pressure_and_change(
        scene, x=across, y=across, time_points=16, tolerance=1e-5, device=choose_device()
    )[0]
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
    field = gauge_pressure_and_change(
        scene,
        x=np.linspace(0, 1, 101),
        y=np.linspace(0, 1, 101),
        time_points=96,
        tolerance=1e-5,
        device=choose_device(),
    )[0]
    for name, there in (("max", field.max()), ("min", field.min())):
        value = found.value[f"gauge_pressure_{name}"]
        doubt = found.error[f"gauge_pressure_{name}"]
        assert doubt < 5e-4 * abs(value)
        assert value == pytest.approx(PRESSURE_PA * there, rel=3e-4)
        assert abs(value) >= PRESSURE_PA * abs(there) - doubt


@pytest.mark.parametrize("rarefaction", ["none", "slip"])
def test_friction_of_a_surface_that_slides_is_couette_s(rarefaction: str) -> None:
    """A film that hardly vibrates: μ U A/(h0 + 2λ) towards where the surface moves."""
    scene = film(epsilon=1e-4, sigma=50.0, bearing=2.0, rarefaction=rarefaction)
    turned = with_pad(scene, rotation_deg=30.0)
    path_m = scene.gas.mean_free_path_m if rarefaction == "slip" else 0.0
    drag = scene.gas.viscosity_pa_s * scene.pad.speed_x_m_per_s * AREA_M2 / (H0_M + 2 * path_m)
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


def largest_shares(scenes: list[Scene], *, tolerance: float) -> dict[str, float]:
    """How far answers are off those a hundred times as good, over the errors of both, at most."""
    solutions = solve(scenes, tolerance=1e-2)
    some, closer = (
        [each.outputs for each in with_outputs(scenes, solutions, outputs=ASKED, tolerance=t)]
        for t in (tolerance, 1e-2 * tolerance)
    )
    return {name: max(each) for name, each in shares(some, closer).items()}


def test_errors_hold() -> None:
    """Of films of all kinds drawn at random."""
    scenes = [*random_films(5, seed=11), film(epsilon=0.2, sigma=900.0, inertia="included", x=0.1)]
    for name, share in largest_shares(scenes, tolerance=1e-3).items():
        assert share < 1, name


@pytest.mark.parametrize(
    ("shape", "epsilon", "sigma"),
    [("1 - 60*abs(x - 0.001)", 0.385, 72.0), ("1 - 40*abs(0.8*x + 0.6*y - 0.001)", 0.633, 3410.0)],
)
def test_errors_hold_over_kinks_of_the_profile(shape: str, epsilon: float, sigma: float) -> None:
    kinked = Formula(shape, Disc(0.01))
    scene = film(epsilon=epsilon, sigma=sigma, profile=kinked)
    for name, share in largest_shares([scene], tolerance=1e-2).items():
        assert share < 1, name


@pytest.mark.parametrize(
    ("numbers", "output", "reason"),
    [
        ({"bearing": 1.0, "rarefaction": "fukui-kaneko"}, "thrust", "not derived with fukui"),
        ({"epsilon": 0.0}, "harmonics", "at rest"),
        ({"sigma": 200.0, "bearing": 3.0, "inertia": "included"}, "thrust", "higher orders"),
        ({"inertia": "included", "rarefaction": "fukui-kaneko"}, "power", "no force"),
    ],
)
def test_what_is_not_known_says_why(numbers: dict[str, object], output: str, reason: str) -> None:
    scene = film(**{"epsilon": 0.3, "sigma": 300.0} | numbers)
    found = outputs(scene, tolerance=1e-3)
    assert reason in found.missing[output]
    missing = [name for name in OUTPUT_COLUMNS[output] if name not in found.value]
    assert missing
    assert f"{output}: " in found.status
    if reason != "no force":
        assert missing_output_reasons(scene, tolerance=1e-3)[output] == found.missing[output]


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
    assert (
        set(list(table)[len(forces) :])
        <= Outputs(requested_names=tuple(OUTPUT_COLUMNS)).columns().keys()
    )
    concatenate_force_parts(plan, [output], output=whole, keep_failed=False)
    pd.testing.assert_frame_equal(pd.read_csv(whole), table)
    assert "'lift' is none of" in refused(*command, "--outputs", "lift", status=2)
