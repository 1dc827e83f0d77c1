"""A study with a measured profile is made anew where its table changes."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from squeezefilm.runs.code import may_read

from .conftest import copy_checkout, snakemake

SCAN = "config/vibrometer.csv"


@pytest.fixture(scope="module")
def inputs(repository: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[str, set[str]]:
    """The files of one job of each rule, inputs and outputs."""
    folder = copy_checkout(repository, tmp_path_factory.mktemp("measured") / "checkout")
    targets = ("profile", "fig08", "--configfile", "config/vibrometer.yaml")
    done = snakemake(folder, *targets, "--filegraph", "--quiet", "all")
    assert done.returncode == 0, done.stdout[-2000:]
    nodes = done.stdout.split('<font point-size="18">')[1:]
    files: dict[str, set[str]] = {}
    for node in nodes:
        rule = node[: node.index("<")]
        found = re.findall(r'<font face="monospace">([^<]+)<', node)
        files.setdefault(rule, set()).update(found)
    return files


def test_rules_that_read_the_actuator_have_the_scan_as_input(inputs: dict[str, set[str]]) -> None:
    with_scan = {rule for rule, files in inputs.items() if SCAN in files}
    assert {"smooth_profile", "simulate"} <= with_scan
    assert {"plan", "gather", "fit", "figure", "plot"} & with_scan == set()
    assert {"plan", "gather", "fit", "figure", "plot"} <= set(inputs)


def test_a_figure_reads_the_actuator_or_not() -> None:
    assert may_read("actuator", "reporting.commands.figure", "paper.figures.fig05")
    assert not may_read("actuator", "reporting.commands.figure", "paper.figures.fig08")
    assert may_read("screen", "commands.plan")  # whose sections go by the kind of plan
