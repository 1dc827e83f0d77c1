"""The gap under a load against the solver's own forces, and mistakes told."""

import re
from contextlib import suppress
from math import pi

import numpy as np
import pandas as pd
import pytest
import yaml
from films import PISTON, SINC, at_reynolds, film, with_pad
from ring_down import RingDown
from scipy.optimize import newton
from test_slow_film import disc_stiffness

from squeezefilm.api.film import Film
from squeezefilm.cli.main import main
from squeezefilm.dynamics import levitation
from squeezefilm.dynamics.levitation import levitate
from squeezefilm.dynamics.resonance import OVERDAMPED_STATUS, resonance
from squeezefilm.errors import RunError
from squeezefilm.film.pad import GapShape
from squeezefilm.reynolds import solve
from squeezefilm.reynolds.device import choose_device

DEVICE = choose_device()
SETTINGS = {"tolerance": 1e-6, "model_tolerance": 1e-3, "device": DEVICE}


@pytest.mark.parametrize("inertia", ["none", "included"])
def test_the_gap_found_is_the_one_that_the_force_was_simulated_at(inertia):
    scene = film(epsilon=0.4, sigma=1000.0, inertia=inertia)
    settings = SETTINGS | ({"tolerance": 1e-4} if inertia == "included" else {})
    (force,) = solve([scene], tolerance=settings["tolerance"], device=DEVICE)
    found = levitate(scene, load_n=force.force_n, **settings)
    assert found.scene.h0_m == pytest.approx(scene.h0_m, abs=2 * found.h0_error_m)
    assert found.h0_error_m < 1e-4 * scene.h0_m
    assert found.is_stable


def test_stiffness_is_the_slope_of_the_force():
    """For small motion the force goes like (hv/h0)² S(σ(h0)): with σ → ∞, k = 2 F/h0."""
    scene = film(epsilon=0.02, sigma=1e5)
    (force,) = solve([scene], tolerance=1e-7, device=DEVICE)
    found = levitate(scene, load_n=force.force_n, **SETTINGS)
    assert found.stiffness_n_per_m == pytest.approx(2 * force.force_n / scene.h0_m, rel=0.02)


def test_a_heavy_mass_swings_on_the_slow_spring_and_a_light_one_on_gas_that_stays():
    """Between them gas that is pressed out damps the motion, and to fast a motion is no answer."""
    scene = film(epsilon=0.2, sigma=1e4)
    (force,) = solve([scene], tolerance=1e-6, device=DEVICE)
    found = levitate(scene, load_n=force.force_n, **SETTINGS)
    trapped = scene.force_scale_n / found.scene.h0_m
    # Squeeze numbers of the motion: far below that of the film's corner, about 20, and far above.
    vibration = scene.actuator.angular_frequency_rad_per_s
    slow, fast = 1e-2 * vibration / 1e4, 1e3 * vibration / 1e4
    heavy = resonance(found, mass_kg=found.stiffness_n_per_m / slow**2)
    assert heavy.frequency_hz == pytest.approx(slow / (2 * pi), rel=1e-3)
    light = resonance(found, mass_kg=trapped / fast**2)
    assert light.frequency_hz == pytest.approx(fast / (2 * pi), rel=0.06)
    assert 0 < light.damping_ratio < 0.1
    assert "0.3 of" in resonance(found, mass_kg=trapped / vibration**2).reason
    moving = [
        resonance(found, mass_kg=trapped / (rate * vibration / 1e4) ** 2)
        for rate in np.geomspace(1, 1e3, 13)
    ]
    assert max(each.damping_ratio for each in moving if not each.reason) > 0.4
    assert all(each.reason == OVERDAMPED_STATUS for each in moving if np.isnan(each.frequency_hz))


def test_near_critical_damping_it_is_not_known_whether_a_part_oscillates():
    """Errors of the stiffness move the mass from which on nothing oscillates."""
    scene = film(epsilon=0.15, sigma=500.0, inertia="included")
    (force,) = solve([scene], tolerance=1e-3, device=DEVICE)
    found = levitate(scene, load_n=force.force_n, **SETTINGS | {"tolerance": 1e-3})

    swinging, damped = (
        found.stiffness_n_per_m
        / (np.array([0.01, 0.003]) * scene.actuator.angular_frequency_rad_per_s) ** 2
    )
    assert resonance(found, mass_kg=swinging).frequency_hz > 0
    assert resonance(found, mass_kg=damped).reason == OVERDAMPED_STATUS
    for _ in range(10):
        between = (swinging * damped) ** 0.5
        if resonance(found, mass_kg=between).frequency_hz > 0:
            swinging = between
        else:
            damped = between
    assert resonance(found, mass_kg=damped).reason.startswith("resonance not known")


@pytest.mark.parametrize(("inertia", "denser"), [("none", 1), ("included", 6)])
def test_a_levitated_disc_oscillates_as_bessel_functions_say(monkeypatch, inertia, denser):
    """Small vibration: with k the film has the stiffness of the film at rest, exact across the gap.

    Its mobility A and density B by tanh (inertia and heat), of which the film's equation has the
    parabola's inertia and no heat: the error holds the rest. Of a gap whose modelling error is too
    large, so that inertia counts.
    """
    monkeypatch.setattr(levitation, "MAX_RELATIVE_MODELLING_ERROR", 1.0)
    scene = film(epsilon=0.03, sigma=460.0, profile=PISTON, inertia=inertia)
    scene = scene.with_gas(density_kg_per_m3=denser * scene.gas.density_kg_per_m3)
    scene = with_pad(scene, shape="ellipse")
    (force,) = solve([scene], tolerance=1e-4, device=DEVICE)
    found = levitate(scene, load_n=force.force_n, **SETTINGS | {"tolerance": 1e-4})
    scene, trapped = found.scene, found.scene.force_scale_n / found.scene.h0_m
    vibration = scene.actuator.angular_frequency_rad_per_s
    for squeeze in (40.0, 100.0):
        scale = (squeeze / scene.sigma) ** 2
        motion = resonance(found, mass_kg=trapped / (scale * vibration**2))

        def excess(s, with_gas, scale=scale):
            reynolds = scene.modified_reynolds * s * with_gas * (inertia == "included")
            q, warm = np.sqrt(reynolds) / 2, np.sqrt(0.71 * scene.modified_reynolds * s) / 2
            flow = 12 / reynolds * (1 - np.tanh(q) / q) if reynolds else 1.0
            density = 1 - 0.4 / 1.4 * (1 - np.tanh(warm) / warm) * with_gas
            stiffness = disc_stiffness(s * scene.sigma, flow=flow, density=density)
            return s**2 + scale * (found.stiffness_n_per_m / trapped + stiffness)

        start = 1j * squeeze / scene.sigma
        roots = [newton(excess, start, args=(with_gas,), tol=1e-10) for with_gas in (0, 1)]
        simple, exact = ((abs(s.imag), -s.real / abs(s)) for s in roots)
        off_hz = motion.frequency_error_hz / scene.actuator.frequency_hz
        assert motion.frequency_hz / scene.actuator.frequency_hz == pytest.approx(
            exact[0], abs=off_hz
        )
        assert motion.damping_ratio == pytest.approx(exact[1], abs=motion.damping_ratio_error)
        assert off_hz < 0.03 * exact[0]
        constant_ms = float(re.search(r"time constant about ([\d.]+) ms", motion.reason)[1])
        creep = newton(excess, complex(-1e3 / (constant_ms * vibration)), args=(1,), tol=1e-10)
        assert -1e3 / (constant_ms * vibration) == pytest.approx(creep, rel=0.05)
        if inertia == "included":  # without its lag the answer were another one
            off = abs(motion.frequency_hz / scene.actuator.frequency_hz - exact[0])
            assert off < 0.5 * abs(simple[0] - exact[0])


@pytest.mark.parametrize(
    ("epsilon", "sigma", "reynolds", "profile"),
    [(0.5, 300.0, 0.0, SINC), (0.3, 455.0, 4.0, PISTON)],
)
def test_a_levitated_disc_rings_down_as_its_resonance_says(epsilon, sigma, reynolds, profile):
    """Film and mass together, integrated in time from a kick, with inertia of the gas and without.

    The gas without inertia is thin, within the limits of validity.
    """
    scene = film(
        epsilon=epsilon, sigma=sigma, profile=profile, inertia="included" if reynolds else "none"
    )
    scene = with_pad(at_reynolds(scene, reynolds or 1.0), shape="ellipse")
    settings = SETTINGS | {"tolerance": 1e-4 if reynolds else 1e-6}
    (force,) = solve([scene], tolerance=settings["tolerance"], device=DEVICE)
    found = levitate(scene, load_n=force.force_n, **settings)
    scale = 0.1**2  # of gas that stays, to a tenth of the vibration
    vibration = scene.actuator.angular_frequency_rad_per_s
    trapped = scene.force_scale_n / scene.h0_m
    motion = resonance(found, mass_kg=trapped / (scale * vibration**2))

    def amplitude(r):
        return profile.amplitude(x_m=r * scene.pad.length_x_m, y_m=np.zeros_like(r))

    frequency, damping_ratio = RingDown(epsilon, sigma, amplitude, reynolds).decay(scale=scale)
    expected_hz = frequency * scene.actuator.frequency_hz
    assert motion.frequency_hz == pytest.approx(expected_hz, abs=motion.frequency_error_hz)
    assert motion.damping_ratio == pytest.approx(damping_ratio, abs=motion.damping_ratio_error)
    assert motion.frequency_error_hz < (0.05 if reynolds else 0.02) * motion.frequency_hz


def study(tmp_path, **sections) -> str:
    """Nothing but what is used: no screen, and a pad as large as the surface, which cannot move."""
    values = {
        "study": "part",
        "gas": {"inertia": "none", "thermal": "none"},
        "actuator": {
            "frequency": 43e3,
            "surface": {"shape": "rectangle", "length_x": 0.01, "length_y": 0.01},
            "profile": {"kind": "piston"},
        },
        "pad": {"length_x": 0.01, "length_y": 0.01},
    } | sections
    path = tmp_path / "study.yaml"
    path.write_text(yaml.safe_dump({name: each for name, each in values.items() if each}))
    return str(path)


SMALL_DISC = {
    "gas": {},
    "actuator": {"frequency": 20e3, "surface_radius": 0.015, "profile": {"kind": "piston"}},
    "pad": {"shape": "circle", "diameter": 0.02},
}


def levitated(tmp_path, *words: str, **sections) -> pd.DataFrame:
    output = tmp_path / "levitation.csv"
    words = [*words, "--config", study(tmp_path, **sections), "--output", str(output)]
    exit_status = main(["levitate", *words])
    table = pd.read_csv(output, keep_default_na=False, na_values=[""])
    assert exit_status == int((table["status"] != "ok").any())
    return table


def test_a_floating_part_oscillates_at_the_root_of_its_equation_of_motion(tmp_path):
    """43 kHz under a pad of 10 × 10 mm; the static film has 239 Hz, and real frequencies 264 Hz."""
    words = ["--load", "0.5N", "--hv", "2um", "--mass", "50g"]
    row = levitated(tmp_path, *words).iloc[0]
    assert row["h0_m"] == pytest.approx(9.572e-6, rel=1e-4)
    assert row["resonance_hz"] == pytest.approx(217.2, rel=1e-3)
    assert row["damping_ratio"] == pytest.approx(0.604, rel=1e-3)


def test_a_resonance_with_an_error_as_large_as_itself_is_not_known(tmp_path, capsys):
    words = ["--mass", "20g", "--hv", "2.3um", "--config", study(tmp_path, **SMALL_DISC)]
    assert main(["levitate", *words]) == 0
    shown = capsys.readouterr().out
    assert re.search(r"resonance +below about \d+ Hz \(error as large as the value\)", shown)
    assert re.search(r"note +resonance not known: its error is as large as its value", shown)
    assert re.search(r"static stiffness .* kN/m \(without the modelling error\)", shown)


def test_the_modelling_error_of_a_gap_holds_what_neglected_effects_do_to_it(tmp_path):
    """The gap with inertia and thermal effects, against that of the equation without them."""
    words = ["--load", "0.5N", "--hv", "2um"]
    without, with_both = (
        levitated(tmp_path, *words, gas=gas).iloc[0]
        for gas in (
            {"inertia": "none", "thermal": "none"},
            {"inertia": "included", "thermal": "included"},
        )
    )
    moved_m = with_both["h0_m"] - without["h0_m"]
    ends = ["h0_modelling_error_lower_m", "h0_modelling_error_upper_m"]
    assert moved_m > 1000 * without["h0_error_m"]
    # What is neglected still, the rim and slip, is in both.
    lower, upper = without[ends].astype(float) - with_both[ends].astype(float)[::-1].to_numpy()
    assert lower < moved_m < upper
    share = without["modelling_error_upper_percent"] / 100
    stiffness = without["load_n"] / without["stiffness_n_per_m"]
    first_order_m = share * stiffness
    assert first_order_m < without[ends[1]] < 1.2 * first_order_m


DISC = {
    "gas": {},
    "actuator": {"frequency": 20e3, "surface_radius": 0.03, "profile": {"kind": "piston"}},
    "pad": {"shape": "ellipse", "length_x": 0.03, "length_y": 0.03},
}


@pytest.mark.parametrize(
    ("words", "sections", "reasons"),
    [
        (["--mass", "10g", "--hv", "3um"], DISC, ["modified Reynolds number"]),
        (["--load", "0.5N", "--hv", "1nm"], {}, ["Knudsen number Kn = 12.8"]),
    ],
)
def test_a_gap_that_says_nothing_of_a_real_film_is_not_given(
    tmp_path, capsys, words, sections, reasons
):
    row = levitated(tmp_path, *words, **sections).iloc[0]
    assert pd.isna(row["h0_m"])
    assert pd.isna(row["h0_modelling_error_upper_m"])
    assert all(reason in row["status"] for reason in reasons)
    assert main(["levitate", *words, "--config", study(tmp_path, **sections)]) == 1
    said = capsys.readouterr()
    assert "gap 0" not in said.out
    assert all(
        reason in said.err for reason in [*reasons, "limits of validity hold for gaps of about"]
    )


@pytest.mark.parametrize("tilt_m", [0.0, 3e-6])
def test_the_loads_of_the_valid_gaps_are_those_of_forces_at_each_of_them(monkeypatch, tilt_m):
    auto = film(epsilon=0.4, sigma=1000.0).with_gas(inertia="auto", thermal="auto")
    scene = with_pad(auto, gap=GapShape(tilt_x_m=tilt_m))
    text = levitation.valid_range_text(scene, method="auto", **SETTINGS)
    assert "N" in text.split("loads of about")[1]
    monkeypatch.setattr(levitation, "RANGE_GAPS_PER_FORCE", 1)
    assert levitation.valid_range_text(scene, method="auto", **SETTINGS) == text


def test_a_printed_table_names_a_reason_once_below_it(capsys):
    assert main(["levitate", "--load", "0.1000333N,0.4N", "--hv", "2um"]) == 1
    header, without_gap, with_gap, _, reason = capsys.readouterr().out.splitlines()
    assert header.split()[-1] == "status"
    assert without_gap.endswith("see note")
    assert with_gap.endswith("ok")
    start = "note    row 1: no gap is given for 0.1 N: modified Reynolds number"
    assert reason.startswith(start)


@pytest.mark.parametrize(
    ("option", "value", "other"), [("--load", "60g", "--mass"), ("--mass", "2N", "--load")]
)
def test_a_weight_and_a_mass_are_told_apart(refused, option, value, other):
    assert f"; did you mean {other}?" in refused("levitate", option, value, "--hv", "2um")


@pytest.mark.parametrize(
    ("hv_m", "loads_n"), [(2e-6, (0.08, 0.09, 0.13, 0.15, 60.0)), (4e-6, (0.4, 0.6, 2.0))]
)
def test_a_force_at_the_gap_that_is_given_has_its_terms_and_is_within_limits(
    tmp_path, hv_m, loads_n
):
    """Up to Re 10 with thermal effects, which change their sign there, and to Re 20 without."""
    film = Film.read(study(tmp_path, **SMALL_DISC))
    scene, how = film.scene(h0=1e-3, hv=hv_m), SETTINGS | {"tolerance": 1e-4}
    given = []
    for load_n in loads_n:
        with suppress(RunError):
            given.append(levitate(scene, load_n=load_n, **how))
    assert len(given) > 1
    for found in given:
        force = film.force(h0=found.scene.h0_m, hv=hv_m)
        assert force.validity == "ok"
        assert force.scene.gas == found.scene.gas
        error_n = found.h0_error_m * found.stiffness_n_per_m + force.error_n
        assert force.force_n == pytest.approx(found.force_n, abs=error_n)


def test_where_no_gap_has_the_terms_decided_there_the_larger_equation_is_taken(tmp_path):
    """Thermal effects lower the gap to one at which they are just negligible, and back."""
    film = Film.read(study(tmp_path, **SMALL_DISC))
    how = SETTINGS | {"tolerance": 1e-4}
    lower_n, upper_n = 6.0, 10.0  # with and without thermal effects
    for _ in range(14):
        load_n = (lower_n + upper_n) / 2
        found = levitate(film.scene(h0=1e-3, hv=2e-6), load_n=load_n, **how)
        if found.notes:
            break
        if found.scene.gas.thermal == "included":
            lower_n = load_n
        else:
            upper_n = load_n
    assert found.scene.gas.thermal == "included"
    (note,) = found.notes
    assert note.startswith("gas.thermal is auto and included, though")
    force = film.force(h0=found.scene.h0_m, hv=2e-6)
    assert force.scene.gas.thermal == "none"
    assert force.force_n == pytest.approx(found.force_n, rel=how["model_tolerance"])


@pytest.mark.parametrize(
    ("words", "sections"), [(["10g", "3um"], DISC), (["5g", "2um"], SMALL_DISC)]
)
def test_loads_are_levitated_within_the_ranges_named_and_not_beside_them(
    tmp_path, capsys, words, sections
):
    """Rising gaps, and by the limits of the terms that the film has there."""
    mass, hv = words
    command = ["levitate", "--mass", mass, "--hv", hv, "--config", study(tmp_path, **sections)]
    assert main(command) == 1
    named = re.findall(r"loads of about (\S+) to ([^\s,]+) N", capsys.readouterr().err)
    ranges = [(float(low), float(high)) for low, high in named]
    assert ranges
    assert all(low < high for low, high in ranges)
    inside = [load for low, high in ranges for load in (1.01 * low, (low * high) ** 0.5)]
    beside = [0.9 * ranges[-1][0], *(1.05 * high for _, high in ranges[1:])]
    loads = ",".join(f"{load:.5g}N" for load in [*inside, *beside])
    table = levitated(tmp_path, "--load", loads, "--hv", hv, **sections)
    refused = table["status"].str.contains("is above").tolist()
    assert refused == [False] * len(inside) + [True] * len(beside), table["status"].tolist()


def test_a_pad_is_levitated_where_it_would_touch_at_a_gap_that_nobody_asked_for(tmp_path):
    pad = {"length_x": 0.01, "length_y": 0.01, "gap": {"tilt_x": 6e-6}}
    row = levitated(tmp_path, "--load", "0.5N", "--hv", "1um", pad=pad).iloc[0]
    assert row["h0_m"] > 4e-6


def test_a_table_keeps_every_load_with_a_reason_where_it_has_no_gap(tmp_path, capsys):
    """And each is told as soon as it is known."""
    output = tmp_path / "levitation.csv"
    words = ["levitate", "--load", "0.5N,1000N", "--hv", "1.5um", "--output", str(output)]
    assert main(words) == 1
    first, second, last = capsys.readouterr().err.splitlines()
    assert last == "squeezefilm: error: no gap for 1 of 2 rows; `status` has the reason"
    assert first.startswith("load 0.5 N, hv 1.5 µm: gap 4.6430")
    assert second.startswith("load 1000 N, hv 1.5 µm: no gap from 1.546 µm to 1000 µm carries")
    table = pd.read_csv(output)
    assert table.loc[0, "status"] == "ok"
    assert table.loc[0, "h0_m"] == pytest.approx(4.643e-6, rel=1e-3)
    assert "no gap" in table.loc[1, "status"]
    assert pd.isna(table.loc[1, "h0_m"])


def test_rows_with_a_gap_and_without_have_one_and_the_same_amplitude(tmp_path):
    """A figure has a line for each amplitude, and had two for one."""
    table = levitated(tmp_path, "--load", "0.5N,1000N", "--hv", "1.3333333333333333um")
    assert table["h0_m"].notna().tolist() == [True, False]
    assert table["hv_m"].nunique() == 1
    assert table["hv_m"][0] == pytest.approx(4e-6 / 3, rel=1e-14)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["levitate", "--hv", "1um"], "--load and --hv"),
        (["levitate", "--load", "1um", "--hv", "1um"], "with its unit: N"),
        (["levitate", "--load", "0.5N,-1N", "--hv", "1um"], "--load '0.5N,-1N' must be positive"),
        (["levitate", "--load", "1000N", "--hv", "1um"], "carries 1000 N"),
        (["levitate", "--load", "0.5N", "--hv", "1um", "--mass", "0g"], "must be positive"),
    ],
)
def test_mistakes_are_told(words, said, capsys):
    assert main(words) != 0
    assert said in capsys.readouterr().err
