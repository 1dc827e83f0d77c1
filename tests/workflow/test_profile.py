"""A study with a measured profile is made anew where its table changes, and smooths it once."""

import re

import pytest

from .conftest import copy_checkout, snakemake

SCAN = "vibrometer.csv"


@pytest.fixture(scope="module")
def planned(repository, tmp_path_factory):
    """The checkout, and the rules with those whose output they read."""
    folder = copy_checkout(repository, tmp_path_factory.mktemp("measured") / "checkout")
    with (folder / "config/vibrometer.yaml").open("a", encoding="utf-8") as study:
        study.write("\npaper: true\n")  # or it has no Figure 5
    targets = ("profile", "fig05", "fig08", "--configfile", "config/vibrometer.yaml")
    done = snakemake(folder, *targets, "--rulegraph", "dot")
    assert done.returncode == 0, done.stdout[-2000:]
    names = dict(re.findall(r"(\d+)\[label = \"(\w+)\"", done.stdout))
    edges = re.findall(r"(\d+) -> (\d+)", done.stdout)
    return folder, {(names[source], names[target]) for source, target in edges}


@pytest.fixture(scope="module")
def bases(planned):
    """What the results of each command rest on: files and sections."""
    folder, _ = planned
    return {
        path.stem.rpartition("-")[0]: {line.split(" ")[0] for line in path.read_text().splitlines()}
        for path in (folder / "results/vibrometer/basis").iterdir()
    }


def test_commands_that_read_the_actuator_rest_on_the_scan(bases):
    with_scan = {command for command, listed in bases.items() if SCAN in listed}
    with_actuator = {command for command, listed in bases.items() if "actuator" in listed}
    assert with_scan == with_actuator
    assert {"smooth", "profile", "simulate", "figure-paper.figures.fig05"} <= with_scan
    others = {"plan-screen", "gather", "claims"}
    assert others <= bases.keys() - with_scan


def test_a_scan_is_smoothed_by_one_rule_that_all_who_need_it_read(planned):
    _, edges = planned
    readers = {target for source, target in edges if source == "smooth"}
    assert {"smooth_profile", "simulate", "compile_kernels", "figure"} <= readers
    assert readers.isdisjoint({"gather", "plan"})
    assert not [source for source, target in edges if target == "smooth"]
