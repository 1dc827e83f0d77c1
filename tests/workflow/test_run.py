"""The quick study runs from start to end, and what made it is written down."""

import numpy
import pytest

from squeezefilm.files import read_json
from squeezefilm.tables import read_forces, read_scenes

from .conftest import QUICK, copy_checkout, snakemake


def test_every_plan_has_a_force_for_every_point(finished):
    plans = sorted((finished.folder / "results/quick/simulations").glob("*/scenes.csv"))
    assert {"screen", "error_map", "four_factor"} <= {path.parent.name for path in plans}
    for path in plans:
        scenes, forces = read_scenes(path), read_forces(path.with_name("forces.csv"))
        assert list(scenes["point_id"]) == list(forces["point_id"])
        assert (forces["status"] == "ok").all()
        assert (forces["force_error_n"] <= 2e-4 * forces["force_n"]).all()


def test_what_made_the_results_is_written_down(finished):
    facts = read_json(finished.folder / "results/quick/provenance.json")
    assert facts["device"]["driver"]
    assert facts["packages"]["numpy"] == numpy.__version__
    assert facts["configuration"]["screen"]["h0_m"]["start"] == 5e-6
    assert {"date", "commit", "changed_since_commit"} < facts.keys()


def test_the_report_is_made_without_warnings(finished, tmp_path):
    page = tmp_path / "report.html"
    done = snakemake(finished.folder, "paper", *QUICK, "--report", str(page))
    assert done.returncode == 0, done.stdout
    assert page.exists()
    assert "Warning" not in done.stdout


@pytest.mark.parametrize("profile", ["slurm", "generic"])
def test_a_dry_run_tells_which_jobs_go_to_the_cluster(profile, repository, tmp_path):
    folder = copy_checkout(repository, tmp_path / "checkout")
    options = ("--dry-run", "--workflow-profile", f"profiles/{profile}")
    told = snakemake(folder, *QUICK, *options).stdout
    (line,) = [line for line in told.splitlines() if line.startswith("Cluster jobs: ")]
    names = {*line.removeprefix("Cluster jobs: ").partition(".")[0].split(", ")}
    assert {"simulate", "simulate_plan"} <= names
    assert not {"plan", "merge", "fit", "all"} & names
