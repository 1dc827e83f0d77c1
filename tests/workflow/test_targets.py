"""Every target can be planned, from nothing, and makes its own part alone."""

import re
import shutil
from pathlib import Path

import pytest

from paper.equations import DESIGNS, FITS, VALIDATIONS

from .conftest import Planner, copy_checkout, snakemake

KINDS = ("csv", "json")


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


def test_the_default_target_is_everything(fresh):
    everything = fresh.made_anew()
    assert everything == fresh.made_anew("paper")
    for name in ("two_factor", "paper_tables"):
        assert fresh.made_anew(name) < everything


@pytest.mark.parametrize(
    ("target", "plans"),
    [
        ("paper", TWO_FACTOR | FOUR_FACTOR),
        ("two_factor", TWO_FACTOR),
        ("fig08", TWO_FACTOR),  # all figures of its page
        ("fig15", {"screen", "four_factor", "validation_two_factor", "validation_four_factor"}),
    ],
)
def test_a_target_needs_its_own_simulations_alone(target, plans, fresh):
    assert plans_of(fresh.rows(target)) == plans


def test_the_paper_is_the_default_study(fresh):
    done = snakemake(fresh.folder, "fig08", "--dry-run", "--quiet", "all")
    assert "Simulate screen" in done.stdout
    assert done.returncode == 0


def test_a_sweep_is_simulated_in_chunks(fresh):
    done = snakemake(fresh.folder, "sweep", "--summary", "--configfile", "config/sweep.yaml")
    assert re.search(r"sweep/chunks/2-of-[2-9]\.parquet", done.stdout)


def test_a_study_without_a_reference_can_be_reported(fresh):
    (fresh.folder / "tests/reference/quick").mkdir(parents=True)
    done = snakemake(fresh.folder, "everything", "--summary", "--configfile", "config/quick.yaml")
    assert done.returncode == 0, done.stdout[-2000:]
    assert "results/quick/report/check.html" in done.stdout
    config = Path("config/quick.yaml")
    text = (
        (fresh.folder / config).read_text(encoding="utf-8").replace("study: quick", "study: mine")
    )
    planned = fresh.made_anew("everything", edits={config: text})
    assert "results/mine/report/summary.html" in planned
    assert "results/mine/report/check.html" not in planned


@pytest.mark.parametrize("study", ["plate", "levitation"])
def test_a_study_that_is_not_the_papers_makes_nothing_of_the_paper(fresh, study):
    done = snakemake(fresh.folder, "all", "--summary", "--configfile", f"config/{study}.yaml")
    assert done.returncode == 0, done.stdout[-2000:]
    assert f"results/{study}/report/summary.html" in done.stdout
    assert (f"results/{study}/figures/profile.png" in done.stdout) == (study == "plate")
    assert not re.search(r"claims|fig\d\d|tables/table", done.stdout)


def test_two_equations_stand_side_by_side_where_the_other_one_is_made(fresh):
    words = ("--summary", "--configfile", "config/paper-inertia.yaml")
    page = "results/paper-inertia/report/equations.html"
    assert page not in snakemake(fresh.folder, *words).stdout
    other = fresh.folder / "results/paper"
    for file in (
        *(f"simulations/{plan}/forces.csv" for plan in ("screen", "four_factor", "extrapolation")),
        *(f"fits/{fit}.json" for fit in FITS),
        *(f"designs/{design}.csv" for design in DESIGNS),
        *(f"validation/{fit}_on_{plan}.{kind}" for fit, plan in VALIDATIONS for kind in KINDS),
    ):
        (other / file).parent.mkdir(parents=True, exist_ok=True)
        (other / file).touch()
    done = snakemake(fresh.folder, *words)
    shutil.rmtree(other)
    assert page in done.stdout, done.stdout
