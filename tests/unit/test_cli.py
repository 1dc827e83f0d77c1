"""The command line speaks to its user: help, messages, exit statuses; never a traceback."""

import json
from pathlib import Path

import pandas as pd
import pytest

from squeezefilm.api.simulation import merge_forces
from squeezefilm.cli.main import commands_of, main, summary_of, with_negative_values
from squeezefilm.config.loading import load_config
from squeezefilm.errors import InputError, RunError
from squeezefilm.studies.plan_scenes import write_scenes
from squeezefilm.tables import FORCE_COLUMNS, read_forces, read_scenes, write_table

COMMANDS = commands_of()


@pytest.fixture(scope="module")
def config(repository):
    return str(repository / "config" / "quick.yaml")


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_explains_itself(command, capsys):
    with pytest.raises(SystemExit) as end:
        main([command, "--help"])
    assert end.value.code == 0
    text = capsys.readouterr().out
    assert f"usage: squeezefilm {command}" in text
    assert len(text.splitlines()) > 8


def test_help_lists_every_command(capsys):
    with pytest.raises(SystemExit):
        main(["--help"])
    text = capsys.readouterr().out
    for command, module in COMMANDS.items():
        assert command in text
        assert " ".join(summary_of(module).split()) in " ".join(text.split())


def test_help_shows_groups_in_the_order_of_use(capsys):
    with pytest.raises(SystemExit):
        main(["--help"])
    text = capsys.readouterr().out
    heads = ["Use: ", "A study of your own"]
    places = [text.index(f"\n{head}") for head in heads]
    assert places == sorted(places)
    assert places[0] < text.index("\n  simulate ") < places[1] < text.index("\n  new ")


@pytest.mark.parametrize(
    ("word", "hint"),
    [
        ("simulat", "did you mean 'simulate'?"),
        ("workingpoint", "did you mean 'working-point'?"),
        ("zzzz", ""),
    ],
)
def test_a_typo_is_answered_with_the_nearest_command_alone(word, hint, capsys):
    with pytest.raises(SystemExit) as end:
        main([word])
    assert end.value.code == 2
    told = capsys.readouterr().err
    assert f"there is no command {word!r}; {hint}" in told
    others = [name for name in COMMANDS if f"'{name}'" in told]
    assert len(others) == (1 if hint else 0)
    assert len(told.splitlines()) == 2


@pytest.mark.parametrize(("option", "hint"), [("--hvv", "did you mean '--hv'? "), ("--zzzz", "")])
def test_a_typo_in_an_option_is_answered_with_the_nearest(option, hint, capsys):
    with pytest.raises(SystemExit) as end:
        main(["simulate", option, "1um"])
    assert end.value.code == 2
    told = capsys.readouterr().err
    assert f"squeezefilm simulate takes no {option!r}; {hint}`squeezefilm simulate --help`" in told


def test_a_negative_value_is_no_option():
    words = ["simulate", "--x", "-2mm", "--y", "-.5,1mm", "--keep-going", "-1", "a", "-2"]
    joined = ["simulate", "--x=-2mm", "--y=-.5,1mm", "--keep-going=-1", "a", "-2"]
    assert with_negative_values(words) == joined


@pytest.mark.parametrize("words", [[], ["simulat"], ["predict"], ["--nonsense"]])
def test_a_wrong_call_ends_with_status_2(words, capsys):
    with pytest.raises(SystemExit) as end:
        main(words)
    assert end.value.code == 2
    assert "usage:" in capsys.readouterr().err


def test_a_wrong_study_is_told_by_the_command_line_too(config, tmp_path, refused):
    study = tmp_path / "study.yaml"
    study.write_text(Path(config).read_text().replace("gas:", "gass:"))
    text = refused("simulate", "scenes.csv", "--config", study, "--output", tmp_path / "s.csv")
    assert "unknown key 'gass'; did you mean 'gas'?" in text
    assert not (tmp_path / "s.csv").exists()


def part(path: Path, *ids: str, status: str = "ok") -> Path:
    rows = [
        dict.fromkeys(FORCE_COLUMNS, 1) | {"point_id": name, "status": status, "force_n": 0.5}
        for name in ids
    ]
    write_table(pd.DataFrame(rows), path)
    return path


@pytest.fixture
def plan(tmp_path):
    path = tmp_path / "scenes.csv"
    rows = [
        {"point_id": str(n), "h0_m": 1, "hv_m": 1, "phi_r_m": 1, "phi_deg": 1} for n in (1, 2, 3)
    ]
    write_table(pd.DataFrame(rows), path)
    return path


def merged(plan: Path, *parts: Path, output: Path) -> Path:
    merge_forces(plan, parts, output=output, keep_failed=False)
    return output


def test_parts_come_together_in_the_order_of_the_plan(plan, tmp_path):
    parts = [part(tmp_path / "a.csv", "1", "2"), part(tmp_path / "b.csv", "3")]
    output = merged(plan, *parts, output=tmp_path / "forces.csv")
    assert list(read_forces(output)["point_id"]) == ["1", "2", "3"]


def test_a_failed_scene_is_named_and_nothing_written(plan, tmp_path):
    parts = [part(tmp_path / "a.csv", "1", "2"), part(tmp_path / "b.csv", "3", status="no end")]
    output = tmp_path / "forces.csv"
    with pytest.raises(RunError, match=r"point 3: no end \(.*b\.csv\)"):
        merged(plan, *parts, output=output)
    assert not output.exists()
    merge_forces(plan, parts, output=output, keep_failed=True)
    assert list(read_forces(output)["status"]) == ["ok", "ok", "no end"]


@pytest.mark.parametrize(
    ("ids", "message"),
    [
        ((["1", "2"], ["2", "3"]), "b.csv: its points are not those .* from row 3 on"),
        ((["1"], ["2"]), "point 3 is in no part"),
        ((["1", "2"], ["3", "4"]), "b.csv: its points are not those"),
        ((["3"], ["1", "2"]), "a.csv: its points are not those .* from row 1 on"),
    ],
)
def test_parts_that_do_not_make_the_plan_are_refused(ids, message, plan, tmp_path):
    parts = [
        part(tmp_path / name, *each) for name, each in zip(("a.csv", "b.csv"), ids, strict=True)
    ]
    with pytest.raises(InputError, match=message):
        merged(plan, *parts, output=tmp_path / "forces.csv")


def test_a_part_with_other_factors_is_refused(plan, tmp_path):
    table = read_forces(part(tmp_path / "a.csv", "1", "2", "3")).assign(hv_m=[1, 2, 1])
    write_table(table, tmp_path / "a.csv")
    with pytest.raises(InputError, match="its points are not those"):
        merged(plan, tmp_path / "a.csv", output=tmp_path / "f.csv")


def fit_file(path: Path, **changes: object) -> Path:
    fit = {"model": "two_factor", "theta": [7.6, 1.9, -1.0], "points": 60, "global_error": 0.005}
    path.write_text(json.dumps(fit | {"sum_of_squares": 1e-4} | changes))
    return path


def test_an_extrapolation_asks_every_fit(config, tmp_path, script):
    fits = [str(fit_file(tmp_path / name)) for name in ("screen.json", "other.json")]
    output = tmp_path / "scenes.csv"
    script("plan", config, input={"sources": fits}, output=output, plan="extrapolation")
    scenes = read_scenes(output)
    assert list(scenes["point_id"]) == ["operating_point", "screen", "other"]
    assert scenes["hv_m"].between(1.5e-6, 3e-6).all()


def test_a_force_out_of_reach_is_told(config, tmp_path):
    fit = fit_file(tmp_path / "screen.json", theta=[0.1, 0.1, -1.0])
    with pytest.raises(InputError, match="screen"):
        write_scenes("extrapolation", load_config(config), sources=[fit], output=tmp_path / "s.csv")


def test_doctor_finds_the_device_and_says_where_things_lie(tmp_path, capsys):
    assert main(["doctor"]) == 0
    text = capsys.readouterr().out
    for word in ("double precision", "compute_units", "PoCL", "snakemake: 9"):
        assert word in text


def test_doctor_fails_without_a_device_and_says_how_to_mend_it(tmp_path, refused, monkeypatch):
    monkeypatch.setenv("SQUEEZEFILM_DEVICE", "no such device")
    text = refused("doctor", status=1)
    assert "pip install" in text
    assert "SQUEEZEFILM_DEVICE" in text
