"""A study with a measured profile is made anew where its table changes."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from .conftest import copy_checkout, snakemake

SCAN = "vibrometer.csv"


@pytest.fixture(scope="module")
def bases(repository: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[str, set[str]]:
    """What the jobs of each rule have as their basis."""
    folder = copy_checkout(repository, tmp_path_factory.mktemp("measured") / "checkout")
    targets = ("profile", "fig05", "fig08", "--configfile", "config/vibrometer.yaml")
    done = snakemake(folder, *targets, "--filegraph", "--quiet", "all")
    assert done.returncode == 0, done.stdout[-2000:]
    nodes = done.stdout.split('<font point-size="18">')[1:]
    listed: dict[str, set[str]] = {}
    for node in nodes:
        rule = node[: node.index("<")]
        for name in re.findall(r'<font face="monospace">([^<]+/basis/[^<]+)<', node):
            lines = (folder / name).read_text(encoding="utf-8").splitlines()
            listed.setdefault(rule, set()).update(line.split(" ")[0] for line in lines)
    return listed


def test_jobs_that_read_the_actuator_rest_on_the_scan(bases: dict[str, set[str]]) -> None:
    with_scan = {rule for rule, listed in bases.items() if SCAN in listed}
    assert {"smooth_profile", "simulate", "figure_data"} <= with_scan
    assert {"plan", "gather", "draw_profile"} <= set(bases)
    assert {"plan", "gather", "plot", "draw_profile"} & with_scan == set()
