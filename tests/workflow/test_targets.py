"""Every target can be planned, from nothing, and makes its own part alone."""

import re
from pathlib import Path

import pytest

from .conftest import Planner, copy_checkout, snakemake


@pytest.fixture(scope="module")
def fresh(repository, tmp_path_factory):
    """A checkout without results."""
    planner = Planner(copy_checkout(repository, tmp_path_factory.mktemp("fresh") / "checkout"))
    yield planner
    planner.close()


def targets(folder: Path) -> list[str]:
    done = snakemake(folder, "--list-target-rules", "--quiet", "all")
    lines = (line.strip() for line in done.stdout.splitlines())
    return [line for line in lines if line and " " not in line]


def plans_of(rows: list[dict[str, str]]) -> set[str]:
    """The plans that a target simulates."""
    simulate = ("simulate", "simulate_plan")
    return {Path(row["output_file"]).parts[3] for row in rows if row["rule"] in simulate}


TWO_FACTOR = {"screen", "error_map", "two_factor_design", "extrapolation", "validation_two_factor"}
FOUR_FACTOR = {
    "four_factor",
    "four_factor_design",
    "four_factor_design_distinct",
    "four_factor_control",
    "validation_four_factor",
}


def test_every_target_can_be_planned(fresh):
    names = targets(fresh.folder)
    assert {"paper", "all", "two_factor", "four_factor", "figures", "paper_tables"} <= set(names)
    assert {f"fig{number:02}" for number in range(5, 17)} <= set(names)
    planned = fresh.rows(*names)  # one name that cannot be planned, and none is
    assert len(planned) > len(fresh.rows("paper"))


@pytest.mark.parametrize(
    ("target", "plans"),
    [
        ("paper", TWO_FACTOR | FOUR_FACTOR),
        ("fig08", TWO_FACTOR),  # all figures of its page
        ("fig15", {"screen", "four_factor", "validation_two_factor", "validation_four_factor"}),
    ],
)
def test_a_target_needs_its_own_simulations_alone(target, plans, fresh):
    assert plans_of(fresh.rows(target)) == plans


@pytest.mark.parametrize("study", ["plate", "levitation"])
def test_a_study_that_is_not_the_papers_makes_nothing_of_the_paper(fresh, study):
    done = snakemake(fresh.folder, "all", "--summary", "--configfile", f"config/{study}.yaml")
    assert done.returncode == 0, done.stdout[-2000:]
    assert f"results/{study}/report/summary.html" in done.stdout
    assert (f"results/{study}/figures/profile.png" in done.stdout) == (study == "plate")
    assert not re.search(r"claims|fig\d\d|tables/table", done.stdout)
