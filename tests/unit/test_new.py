"""A new study is there with one command, runs as it is, and nothing is ever written over."""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml

from squeezefilm import cli
from squeezefilm.config import load_config
from squeezefilm.study import check_study, scan_path, smoothed_scan_of


def test_a_new_study_is_valid_and_has_its_scan(tmp_path: Path) -> None:
    assert cli.main(["new", "my-actuator", "--folder", str(tmp_path / "config")]) == 0
    config = check_study(load_config(tmp_path / "config" / "my-actuator.yaml"))
    assert config["study"] == "my-actuator"
    assert scan_path(config) == tmp_path / "config" / "my-actuator.csv"
    smoothed = smoothed_scan_of(config)
    assert smoothed is not None
    assert smoothed.noise_m / smoothed.peak_m == pytest.approx(0.02, rel=0.1)


def test_its_texts_are_the_examples(tmp_path: Path, repository: Path) -> None:
    assert cli.main(["new", "vibrometer", "--folder", str(tmp_path)]) == 0
    example, new = repository / "config" / "vibrometer.yaml", tmp_path / "vibrometer.yaml"
    body = example.read_text(encoding="utf-8").split("\nstudy:")[1]
    assert new.read_text(encoding="utf-8").split("\nstudy:")[1] == body
    scan = (repository / "config" / "vibrometer.csv").read_bytes()
    assert (tmp_path / "vibrometer.csv").read_bytes() == scan


def test_no_word_of_the_example_is_left(tmp_path: Path) -> None:
    assert cli.main(["new", "plate", "--folder", str(tmp_path)]) == 0
    text = (tmp_path / "plate.yaml").read_text(encoding="utf-8")
    assert "vibrometer" not in str(yaml.safe_load(text))
    assert "results/vibrometer" not in text


@pytest.mark.parametrize("there", ["a.yaml", "a.csv"])
def test_nothing_is_written_over(
    there: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / there).write_text("mine")
    assert cli.main(["new", "a", "--folder", str(tmp_path)]) == 2
    assert f"{there}: is there already" in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == [there]
    assert (tmp_path / there).read_text() == "mine"


@pytest.mark.parametrize("name", ["", "Mine", "../mine", "a b", "a.yaml", "-a", "a" * 61, "ä"])
def test_a_name_is_that_of_a_study(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.main(["new", "--folder", str(tmp_path), "--", name]) == 2
    assert "is no name of a study" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())
