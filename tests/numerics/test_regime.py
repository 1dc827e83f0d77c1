"""Notes of regime speak in per cent of the force, and the per cent are about right."""

from dataclasses import replace

import pytest
from films import PISTON, SINC, film

from squeezefilm.reynolds import solve
from squeezefilm.reynolds.regime import regime_notes
from squeezefilm.reynolds.terms.rarefaction import slip_share


def test_inertia_is_named_before_slip_where_it_is_twice_as_large(scene):
    """physics.md: +2.0 % and −1.0 % at 5 µm, +8 % and −0.6 % at 10 µm."""
    assert regime_notes(scene) == [
        "inertia, left out, adds about 2.1% of the force (modified Reynolds number 0.45)",
        "slip, left out, takes about 1.1% of the force (Kn 0.013)",
    ]
    assert regime_notes(replace(scene, h0_m=10e-6)) == [
        "inertia, left out, adds about 8.5% of the force (modified Reynolds number 1.8)",
        "slip, left out, takes about 0.6% of the force (Kn 0.0067)",
    ]


def test_no_number_is_given_where_none_is_known(scene):
    assert "about 10% or more" in regime_notes(replace(scene, h0_m=20e-6))[0]
    assert "unknown share" in regime_notes(replace(scene, h0_m=30e-6))[0]


def test_what_moves_the_force_by_less_than_half_a_per_cent_is_not_named(scene):
    slow = replace(scene, actuator=replace(scene.actuator, frequency_hz=5e3))
    dense = replace(slow, gas=replace(scene.gas, mean_free_path_m=1e-9))
    assert regime_notes(dense) == []


@pytest.mark.parametrize("profile", [SINC, PISTON])
@pytest.mark.parametrize(
    ("epsilon", "sigma", "knudsen", "aspect"),
    [(0.05, 2331.0, 0.0134, 1.0), (0.4, 583.0, 0.0067, 0.6), (0.3, 20.0, 0.05, 1.0)],
)
def test_slip_s_share_is_that_of_the_solver(epsilon, sigma, knudsen, aspect, profile):
    numbers = {"epsilon": epsilon, "sigma": sigma, "knudsen": knudsen, "aspect": aspect}
    without, with_slip = (
        film(**numbers, profile=profile, rarefaction=flow)  # type: ignore[arg-type]
        for flow in ("none", "slip")
    )
    forces = [each.force_n for each in solve([without, with_slip], tolerance=1e-5)]
    assert slip_share(without) == pytest.approx(forces[1] / forces[0] - 1, rel=0.25)


def test_slip_beyond_its_range_is_named():
    slipping = film(epsilon=0.3, sigma=583.0, rarefaction="slip", knudsen=0.33)
    (note,) = [note for note in regime_notes(slipping) if "slip" in note]
    assert "meant for Kn up to 0.1" in note
    assert "(Kn 0.33)" in note
    left_out = film(epsilon=0.3, sigma=583.0, knudsen=0.33)
    assert any("or more of the force (Kn 0.33)" in note for note in regime_notes(left_out))
    fine = film(epsilon=0.3, sigma=583.0, rarefaction="slip", knudsen=0.05)
    assert not any("slip" in note for note in regime_notes(fine))


def test_a_film_at_rest_says_nothing_of_slip():
    class Still:
        def amplitude(self, *, x_m, y_m):  # type: ignore[no-untyped-def]
            return 0 * (x_m + y_m)

    assert not any(
        "slip" in note for note in regime_notes(film(epsilon=0.3, sigma=583.0, profile=Still()))
    )
