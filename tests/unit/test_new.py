"""A new study is there with one command, runs as it is, and nothing is ever written over."""

import os
import re
import shutil
import subprocess
import sys
from math import cos, pi, sin
from pathlib import Path

import pytest
import yaml

from squeezefilm.cli import main as cli
from squeezefilm.cli.setup import cache_folder_states
from squeezefilm.config.loading import load_config
from squeezefilm.config.notes import study_notes
from squeezefilm.studies.study import check_study


def test_a_new_study_is_valid_and_has_its_scan(tmp_path):
    assert cli.main(["new", "my-actuator", "--folder", str(tmp_path / "config")]) == 0
    path = tmp_path / "config" / "my-actuator.yaml"
    config = check_study(load_config(path))
    assert "vibrometer" not in str(dict(config))
    assert "results/vibrometer" not in path.read_text(encoding="utf-8")
    assert config.study == "my-actuator"
    assert config.scan_path == tmp_path / "config" / "my-actuator.csv"
    smoothed = config.smoothed_scan()
    assert smoothed is not None
    assert smoothed.noise_m / smoothed.peak_m == pytest.approx(0.02, rel=0.1)


def test_a_new_study_may_be_of_a_plate_with_a_standing_wave(tmp_path):
    assert cli.main(["new", "plate-1", "--rectangle", "--folder", str(tmp_path)]) == 0
    (path,) = tmp_path.iterdir()
    assert "vibrometer.csv" not in (text := path.read_text(encoding="utf-8"))
    assert "disc" not in text
    config = check_study(load_config(path))
    assert config.actuator.surface.half_extents_m == (0.03, 0.02)
    assert config.actuator.profile.wavelength_m == 0.012
    assert config.symmetry().position_columns == ("x_m", "y_m")
    assert [*study_notes(config)] == []
    assert "wave" in config.comparison.four_factor
    # The amplitude for a force is largest at a crest, the centre, or on a node line.
    assert config.positions.x_m[0] == config.actuator.profile.wavelength_m / 4


def test_nothing_is_written_over(tmp_path, refused):
    there = tmp_path / "a.yaml"
    there.write_text("mine")
    assert "a.yaml: is there already" in refused("new", "a", "--folder", str(tmp_path))
    assert list(tmp_path.iterdir()) == [there]
    assert there.read_text() == "mine"


@pytest.mark.parametrize(
    ("name", "close"),
    [
        ("", ""),
        ("../mine", "mine"),
        ("a.yaml", "a"),
        ("a" * 61, "a" * 60),
        ("My Plate", "my-plate"),
    ],
)
def test_a_name_is_that_of_a_study(name, close, tmp_path, refused):
    told = refused("new", "--folder", str(tmp_path), "--", name)
    assert f"error: {name!r} is no name of a study" in told
    assert (f"; did you mean {close!r}?" in told) == bool(close)
    assert not list(tmp_path.iterdir())


@pytest.fixture(scope="module")
def walk_through(repository):
    return (repository / "docs/tutorials/your-actuator.md").read_text(encoding="utf-8")


def test_what_the_walk_through_shows_is_valid(walk_through, repository, tmp_path):
    """Its profiles, its pad and its formula, put into the example."""
    example = yaml.safe_load((repository / "config" / "vibrometer.yaml").read_text("utf-8"))
    blocks = re.findall(r"(?:^    .*\n|^\n(?=    ))+", walk_through, re.MULTILINE)
    shown = [block for block in blocks if re.match(r"\s+(profile|pad|models):", block)]
    assert len(shown) == 4
    studies = []
    for block in shown:
        lines = block.split("\n") if "profile:" in block else [block]
        lines = [line for line in lines if line.strip()]
        for text in lines:
            part = yaml.safe_load("\n".join(line[4:] for line in text.splitlines()))
            actuator = {**example["actuator"], **part} if "profile" in part else {}
            studies.append({**example, **({"actuator": actuator} if actuator else part)})
    assert len(studies) == 10
    (tmp_path / "vibrometer.csv").write_bytes((repository / "config/vibrometer.csv").read_bytes())
    turns = [pi * step / 60 for step in range(120)]
    rim = "".join(f"{5.1 * cos(turn)},{4.2 * sin(turn)}\n" for turn in turns)
    (tmp_path / "patch.csv").write_text(f"x_mm,y_mm\n{rim}", encoding="utf-8")
    for study in studies:
        text = yaml.safe_dump(study).replace("e-0", "e-")
        (tmp_path / "study.yaml").write_text(text, encoding="utf-8")
        check_study(load_config(tmp_path / "study.yaml"))


def test_the_forces_of_the_walk_through_are_those_of_its_commands(
    walk_through, tmp_path, monkeypatch, capsys
):
    monkeypatch.chdir(tmp_path)
    assert cli.main(["new", "my-actuator"]) == 0
    capsys.readouterr()
    section = walk_through.partition("## 5. ")[2].partition("## 6. ")[0]
    asked = r"^    squeezefilm (simulate --h0 5um --hv 2um --config.*)"
    commands = re.findall(asked, section, re.MULTILINE)
    forces = re.findall(r"(0\.[78]\d+) N", section)
    assert forces
    for command, force in zip(commands, forces, strict=True):
        assert cli.main(command.split()) == 0
        found = float(re.match(r"mean force +(\S+) ", capsys.readouterr().out).group(1))
        assert f"{found:.{len(force) - 2}f}" == force, command


def test_clean_keeps_the_results_of_a_study_of_ones_own(tmp_path, monkeypatch):
    for name, folder in (("POCL_CACHE_DIR", "/kernels"), ("XDG_CACHE_HOME", "/caches")):
        monkeypatch.setenv(name, folder)
    shutil.copy(Path(__file__).parents[2] / "Makefile", tmp_path)
    for study in ("paper", "mine"):
        (tmp_path / "results" / study).mkdir(parents=True)
    built = ("build", "docs/_build", "docs/reference/_generated", ".snakemake/locks")
    for folder in (*built, ".snakemake/metadata"):
        (tmp_path / folder).mkdir(parents=True)
    done = subprocess.run(
        ["make", "clean"], cwd=tmp_path, capture_output=True, text=True, check=True
    )
    assert [path.name for path in (tmp_path / "results").iterdir()] == ["mine"]
    assert "kept: results/mine" in done.stdout
    assert not [folder for folder in built if (tmp_path / folder).exists()]
    outside = done.stdout.partition("outside this folder, yours to remove: ")[2]
    caches = [state.partition(":")[0] for state in cache_folder_states().values()]
    assert caches == ["/kernels", "/caches/pyopencl", "/caches/pytools"]
    assert [cache for cache in caches if cache not in outside] == []


def test_results_kept_by_clean_are_made_anew_after_an_edit(tmp_path):
    """Without Snakemake's records a kept result would never follow its study again."""
    shutil.copy(Path(__file__).parents[2] / "Makefile", tmp_path)
    rule = (
        "rule force:\n output: 'results/mine/force.txt'\n params: hz={}\n"
        " shell: 'echo {{params.hz}} >{{output}}'\n"
    )
    caches = {name: str(tmp_path / name) for name in ("POCL_CACHE_DIR", "XDG_CACHE_HOME")}
    environment = {**os.environ, **caches}

    def run(*command):
        subprocess.run(command, cwd=tmp_path, env=environment, check=True, capture_output=True)

    snakemake = (sys.executable, "-m", "snakemake", "--cores", "1")
    (tmp_path / "Snakefile").write_text(rule.format(43270), encoding="utf-8")
    run(*snakemake)
    run("make", "clean")
    (tmp_path / "Snakefile").write_text(rule.format(30000), encoding="utf-8")
    run(*snakemake)
    assert (tmp_path / "results/mine/force.txt").read_text(encoding="utf-8") == "30000\n"
