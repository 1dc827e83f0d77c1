"""Films without angle: discs on axisymmetric vibrations are solved along their radius alone."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from films import PISTON, SINC, at_reynolds, film, solved, with_pad
from scipy.special import jn_zeros

from squeezefilm.film.pad import GapShape
from squeezefilm.film.profiles import BesselMode, Formula, Profile
from squeezefilm.film.scene import Scene
from squeezefilm.film.surfaces import Disc
from squeezefilm.quantities.derivatives import with_derivatives
from squeezefilm.quantities.edge_effects import (
    JOINT_LAWS,
    edge_effect_changes,
    edge_pressure_arrays,
)
from squeezefilm.quantities.fields import Fields
from squeezefilm.quantities.outputs import with_outputs
from squeezefilm.quantities.pressure import gauge_pressure_and_change
from squeezefilm.reynolds.device import choose_device
from squeezefilm.reynolds.grid import Grid
from squeezefilm.reynolds.periodic.launch import solve_batch
from squeezefilm.reynolds.plan import solve_plan_of
from squeezefilm.reynolds.spectral import RadialAxis

BOTH = {"inertia": "included", "thermal": "included"}
CROWNED = GapShape(crown_m=1e-6)


def disc(profile: Profile = PISTON, *, gap: GapShape | None = None, **numbers: object) -> Scene:
    """Under a disc of Re 2, unless it has no inertia."""
    scene = film(epsilon=0.3, sigma=100.0, profile=profile, **numbers)  # type: ignore[arg-type]
    return with_pad(at_reynolds(scene, 2), shape="ellipse", gap=gap or scene.pad.gap)


def with_angle(scene: Scene) -> Scene:
    """The same disc as an ellipse, longer by so little that only its coordinates differ."""
    return with_pad(scene, length_y_m=(1 + 1e-12) * scene.pad.length_x_m)


def bessel(nodal_diameters: int) -> BesselMode:
    return BesselMode(
        nodal_diameters,
        wave_number_rad_per_m=300.0,
        edge_share=0.01,
        direction_deg=0.0,
        surface=Disc(0.02),
    )


FILMS = {
    "plain": disc(SINC),
    "flow factor, polytropic": disc(rarefaction="fukui-kaneko", polytropic_exponent=1.2),
    "inertia": disc(bessel(0), inertia="included"),
    "inertia, thermal effects, crowned, slip": disc(gap=CROWNED, rarefaction="slip", **BOTH),
}


@pytest.mark.parametrize("name", FILMS)
def test_the_force_is_that_of_the_whole_disc(name):
    found, expected = (
        solved(scene, tolerance=1e-4) for scene in (FILMS[name], with_angle(FILMS[name]))
    )
    assert (found.domain, found.ny, expected.domain) == ("radius", 1, "quarter")
    assert abs(found.force_n - expected.force_n) <= found.force_error_n + expected.force_error_n


def test_a_third_grid_s_error_counts_as_falling():
    """By the nodes along the radius: else it would take a fourth, finer than the whole disc's."""
    scene = film(epsilon=0.39, sigma=1264.0, profile=PISTON)
    scene = with_pad(scene, shape="ellipse")
    assert solved(scene, tolerance=1e-4).nx <= solved(with_angle(scene), tolerance=1e-5).nx


ANGLED = {
    "off the centre": disc(SINC, x=0.01),
    "tilted": disc(gap=GapShape(tilt_x_m=1e-8)),
    "sliding": disc(bearing=1e-3),
    "ellipse": disc(aspect=1.001),
    "nodal diameter": disc(bessel(1)),
    "spot": disc(Formula("1 - 0.1*exp(-((x-1e-3)**2 + y**2)/4e-8)", surface=Disc(0.02))),
}


@pytest.mark.parametrize("name", ANGLED)
def test_a_film_with_an_angle_keeps_it(name):
    assert solve_plan_of(ANGLED[name]).domain.tolist() != ["radius"]


def test_a_piston_has_no_angle_wherever_the_disc_is():
    assert solve_plan_of([disc(), disc(x=0.3), disc(SINC, x=0.3)]).domain.tolist() == [
        "radius",
        "radius",
        "half in y",
    ]


def test_the_axis_has_the_bessel_modes_and_the_disc_s_mean():
    axis = RadialAxis(24)
    assert axis.eigenmodes[0][:6] == pytest.approx(-((2 * jn_zeros(0, 6)) ** 2), rel=1e-9)
    r = 2 * np.abs(axis.nodes - 0.5)
    for k in range(1, 24):  # zero on the rim, as all that the axis has
        assert axis.quadrature_weights @ (1 - r ** (2 * k)) == pytest.approx(k / (k + 1), rel=1e-13)


def test_errors_fall_along_the_radius():
    scene, device = disc(**BOTH), choose_device()
    grids = (Grid(n, 1, 20, True, True) for n in (4, 8, 12, 24))
    *means, exact = (
        solve_batch([scene], grid, tolerance=1e-9, device=device).mean_pressure_ratio[0]
        for grid in grids
    )
    errors = [abs(mean - exact) for mean in means]
    assert all(fine < coarse / 8 for coarse, fine in pairwise(errors))


def test_a_pressure_that_the_edge_shares_with_the_film_drives_no_flow():
    """What a pressure on the edge adds is the other part of the Laplacian of a constant."""
    grid = Grid(12, 1, 12, True, True)
    films = Fields.of([disc()], grid, np.zeros((1, 1, *grid.space_time_shape)))
    films = replace(
        films, edge_gauge_pressure=0.01 * films.inward_normal_signs[0] + films.edge_gauge_pressure
    )
    rise = 0.01
    viscous = (rise + rise**2 / 2) * films.gap[:, :1] ** 1.5
    second = grid.x.second_derivative.sum(axis=1)[:, None, None]
    inside = films.gap[films.inner] ** 1.5 * viscous * second
    flow = edge_pressure_arrays(films)["edge_flow"]
    assert np.abs(flow + inside).max() < 1e-11 * np.abs(flow).max()


def test_quantities_are_those_of_the_whole_disc():
    """Outputs, derivatives, edge loss and the pressure's field, each within the errors of both."""
    both = disc(SINC, **BOTH), with_angle(disc(SINC, **BOTH))
    how = {"tolerance": 1e-4, "device": choose_device()}
    states = [solved(scene, tolerance=1e-4, keep_states=True) for scene in both]
    outputs = with_outputs(
        both, states, outputs=("moments", "power", "harmonics", "extremes"), **how
    )
    derivatives = with_derivatives(both, states, **how)
    for found in ([each.outputs for each in outputs], [each.derivatives for each in derivatives]):
        one, other = found
        assert one.value.keys() == other.value.keys()
        for name, value in one.value.items():
            off = abs(value - other.value[name])
            assert off <= one.error[name] + other.error[name] or np.isnan(value), name
    changes, errors = edge_effect_changes(both, states, laws=JOINT_LAWS, device=how["device"])
    assert (abs(changes[:, 0] - changes[:, 1]) <= errors.sum(axis=1)).all()
    across = np.linspace(0, 1, 9)
    fields = [
        gauge_pressure_and_change(scene, x=across, y=across, time_points=4, **how)[0]
        for scene in both
    ]
    assert np.nanmax(np.abs(fields[0] - fields[1])) < 2e-4 * np.nanmax(np.abs(fields[1]))
    assert (np.isnan(fields[0]) == np.isnan(fields[1])).all()
