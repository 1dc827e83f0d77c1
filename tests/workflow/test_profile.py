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


def test_a_scan_is_smoothed_anew_where_it_changes(planned):
    folder, _ = planned
    words = ("results/vibrometer/profile/smoothed.npz", "--configfile", "config/vibrometer.yaml")
    assert snakemake(folder, *words).returncode == 0
    assert "Nothing to be done" in snakemake(folder, *words).stdout
    scan = folder / "config" / SCAN
    scan.write_text(scan.read_text(encoding="utf-8") + "\n", encoding="utf-8")
    assert "Make a smooth profile of the scan" in snakemake(folder, *words, "--dry-run").stdout


def test_a_scan_is_smoothed_by_one_rule_that_all_who_need_it_read(planned):
    _, edges = planned
    readers = {target for source, target in edges if source == "smooth"}
    assert {"compile_kernels", "figure"} <= readers
    # Whatever simulates has the device.
    assert {("compile_kernels", "simulate_plan"), ("compile_kernels", "smooth_profile")} <= edges
    assert not [source for source, target in edges if target == "smooth"]
