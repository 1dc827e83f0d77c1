"""`squeezefilm response`: what a user gets, and what is said of a mistake."""

import json
import re

import pandas as pd
import pytest

from squeezefilm.cli.main import main
from squeezefilm.formatting import result_lines_text

ONE = ["response", "--h0", "5um", "--hv", "2.2um"]


def test_one_scene_is_told_in_words_and_a_table(capsys):
    assert main([*ONE, "--frequencies", "100Hz,1kHz"]) == 0
    told = dict(re.split("  +", line) for line in capsys.readouterr().out.splitlines())
    assert [told[f"{k} gain"] for k in ("static", "instantaneous")] == [
        "2.1668 ± 0.0032",
        "1.3199 ± 0.0030",
    ]
    assert told["gains"].startswith("frequency 100 Hz, gain 2.1339 ± 0.0035, phase -4.093 ± ")


def test_steps_start_and_end_where_the_settled_force_says(tmp_path, repository):
    scenes, output, steps = (tmp_path / name for name in ("scenes.csv", "out.csv", "steps.csv"))
    scenes.write_text("point_id,h0_m,hv_m,phi_r_m,phi_deg\na,5e-6,2e-6,0,0\nthick,5e-5,2e-6,0,0\n")
    config = str(repository / "config" / "paper.yaml")
    words = ["response", str(scenes), "--config", config, "--output", str(output)]
    assert main([*words, "--steps", str(steps)]) == 1
    summary = pd.read_csv(output, index_col="point_id").loc["a"]
    rows = pd.read_csv(steps, index_col="point_id")
    assert rows.loc["thick", "status"].startswith("not supported: the period-averaged equation")
    thick = pd.read_csv(output, index_col="point_id").loc["thick"]
    assert thick["status"] == rows.loc["thick", "status"]
    assert pd.isna(thick["static_gain"])
    film = rows.loc["a"]
    settled = film["rising_n"].iloc[-1]
    assert film["rising_n"].iloc[0] / settled == pytest.approx(
        summary["instantaneous_fraction"], rel=1e-3
    )
    assert film["falling_n"].iloc[0] / settled == pytest.approx(
        summary["lasting_fraction"], rel=1e-3
    )
    late = film["time_s"] > summary["settling_start_s"]
    assert (abs(film["rising_n"][late] / settled - 1) < 0.05).all()


def test_a_change_within_its_own_error_is_shown_as_a_bound(capsys):
    assert main([*ONE, "--frequencies", "100Hz", "--json"]) == 0
    row = json.loads(capsys.readouterr().out)
    names = "thermal_gain_percent", "thermal_gain_error_percent"
    bound = sum(abs(row[name]) for name in names)
    assert abs(row[names[0]]) < row[names[1]]
    (line,) = [
        each for each in result_lines_text(row).splitlines() if "gain by thermal effects" in each
    ]
    shown = float(re.search(r"  within ± ([\d.]+) %$", line)[1])
    assert bound <= shown <= 1.1 * bound


def test_what_the_averaged_film_neglects_is_said_with_numbers(capsys):
    """Forces at amplitudes 1 % apart: a gain of 2.16455 with inertia and 2.16695 without."""
    assert main([*ONE, "--frequencies", "100Hz", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    slip = [
        told[f"slip_{what}_percent"]
        for what in ("gain", "corner", "settling_start", "settling_stop")
    ]
    assert slip == pytest.approx([0.12, 7.6, -7.8, -8.0], rel=0.03)
    changes = [told[f"{effect}_gain_percent"] for effect in ("inertia", "thermal")]
    assert changes == pytest.approx([-0.11, 0.01], abs=0.01)


def test_a_scene_outside_the_limits_is_shown_with_exit_status_1(capsys, repository):
    words = ["response", "--h0", "20um", "--hv", "3um"]
    assert main([*words, "--config", str(repository / "config" / "levitation.yaml")]) == 1
    told = capsys.readouterr()
    assert "Re = 3.34 is above 3" in told.out
    assert "outside the limits of validity" in told.err


@pytest.mark.parametrize("frequencies", ["10kHz", "0Hz,100Hz"])
def test_a_modulation_that_is_not_slow_ends_with_a_message(frequencies, refused):
    assert "must lie above 0 and up to 4327 Hz" in refused(*ONE, "--frequencies", frequencies)
