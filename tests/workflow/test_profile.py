"""A study with a measured profile is made anew where its table changes."""

from __future__ import annotations

from pathlib import Path

import pytest

from .conftest import copy_checkout, snakemake

MEASURED = ("--configfile", "config/vibrometer.yaml")
READS_NO_ACTUATOR = {"plan", "gather", "fit", "validate", "plot"}


@pytest.fixture(scope="module")
def rows(repository: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[str, list[str]]:
    """The input files of each rule, as planned."""
    folder = copy_checkout(repository, tmp_path_factory.mktemp("measured") / "checkout")
    done = snakemake(folder, "profile", "fig05", "fig08", "--detailed-summary", *MEASURED)
    assert done.returncode == 0, done.stdout
    lines = [line.split("\t") for line in done.stdout.splitlines() if line.count("\t") > 4]
    header, *cells = lines
    rule, inputs = header.index("rule"), header.index("input-file(s)")
    return {row[rule]: row[inputs].split(",") for row in cells}


def test_rules_that_read_the_actuator_have_the_scan_as_input(rows: dict[str, list[str]]) -> None:
    assert {"simulate", "smooth_profile", "figure_data"} <= set(rows)
    for rule, inputs in rows.items():
        if rule in ("simulate", "smooth_profile"):
            assert "config/vibrometer.csv" in inputs
        if rule in READS_NO_ACTUATOR:
            assert "config/vibrometer.csv" not in inputs
