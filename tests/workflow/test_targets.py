"""Every target can be planned, from nothing, and makes its own part alone."""

import re
import shutil
import subprocess
import sys
import time
from pathlib import Path

import pytest
import yaml

from .conftest import QUICK, copy_checkout, planned, snakemake


@pytest.fixture(scope="module")
def fresh(repository, tmp_path_factory):
    """A checkout without results, with the references of the repository's studies."""
    folder = tmp_path_factory.mktemp("fresh") / "checkout"
    return copy_checkout(repository, folder, "tests/reference")


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
    names = targets(fresh)
    assert {"study", "paper", "all", "two_factor", "four_factor", "figures", "paper_tables"} <= set(
        names
    )
    assert {f"fig{number:02}" for number in range(5, 17)} <= set(names)
    rows = planned(fresh, *names)  # one name that cannot be planned, and none is
    assert len(rows) > len(planned(fresh, "paper"))


@pytest.mark.parametrize(
    ("target", "plans"),
    [
        ("paper", TWO_FACTOR | FOUR_FACTOR),
        ("fig08", TWO_FACTOR),  # all figures of its page
        ("fig15", {"screen", "four_factor", "validation_two_factor", "validation_four_factor"}),
    ],
)
def test_a_target_needs_its_own_simulations_alone(target, plans, fresh):
    assert plans_of(planned(fresh, target)) == plans


def test_a_run_without_a_target_makes_a_study_whoever_s_it_is(fresh):
    """The job was called `paper` in a study of one's own too."""
    told = snakemake(fresh, "--dry-run", *QUICK).stdout
    assert re.search(r"^study +1$", told, re.MULTILINE)
    assert not re.search(r"^paper +1$", told, re.MULTILINE)
    assert planned(fresh, "paper") == planned(fresh, "study")


@pytest.mark.parametrize("study", ["plate", "levitation"])
def test_a_study_that_is_not_the_papers_makes_nothing_of_the_paper(fresh, study):
    done = snakemake(fresh, "all", "--summary", "--configfile", f"config/{study}.yaml")
    assert done.returncode == 0, done.stdout[-2000:]
    assert f"results/{study}/report/summary.html" in done.stdout
    assert (f"results/{study}/figures/profile.png" in done.stdout) == (study == "plate")
    assert not re.search(r"claims|fig\d\d|tables/table", done.stdout)


@pytest.fixture
def make(repository):
    """A function that runs make in a folder with this Makefile, its .venv this environment."""

    def run(folder: Path, *words: str) -> subprocess.CompletedProcess[str]:
        (folder / ".venv").mkdir(parents=True)
        (folder / ".venv/bin").symlink_to(Path(sys.executable).parent)
        for name in ("Makefile", "requirements.lock", "pyproject.toml"):
            shutil.copy(repository / name, folder / name)
        (folder / ".venv/.run").touch()
        words = ("make", "--no-print-directory", *words)
        return subprocess.run(words, cwd=folder, capture_output=True, text=True, check=False)

    return run


@pytest.mark.skipif(not shutil.which("make"), reason="no make")
@pytest.mark.parametrize("name", ["mit Leerzeichen", "it's one", "a & b", "x(1)"])
def test_make_says_at_once_in_which_folders_it_cannot_work(name, make, tmp_path):
    started_s = time.monotonic()
    done = make(tmp_path / name, "quick", "--dry-run")
    assert time.monotonic() - started_s < 1
    assert done.returncode != 0
    assert f"{name}, has " in done.stderr
    assert make(tmp_path / "Umläute", "quick", "--dry-run").returncode == 0


@pytest.mark.skipif(not shutil.which("make"), reason="no make")
@pytest.mark.parametrize("target", ["report", "resume"])
def test_make_reads_the_study_before_snakemake_does(target, make, tmp_path):
    """Snakemake ends in a traceback where a file is not UTF-8 or is not there."""
    done = make(tmp_path / "folder", target, "CONFIG=none.yaml")
    assert done.returncode != 0
    assert "squeezefilm: error: none.yaml: there is no such configuration file" in done.stderr
    assert "Traceback" not in done.stderr


def test_a_sweep_without_pyarrow_ends_before_any_job(repository, tmp_path):
    """The kernels were compiled and the plan made first."""
    folder = copy_checkout(repository, tmp_path / "checkout")
    (folder / "none/pyarrow.py").parent.mkdir()
    (folder / "none/pyarrow.py").write_text("raise ModuleNotFoundError(name='pyarrow')\n")
    without = {"PYTHONPATH": str(folder / "none")}
    done = snakemake(folder, "sweep", *QUICK, environment=without)
    assert done.returncode == 2, done.stdout
    assert "squeezefilm: error: a table in Parquet needs pyarrow: pip install" in done.stdout
    assert "Compile" not in done.stdout


ENDED_TWICE = """
rule all:
    output: "done"
    shell:
        "echo {resources.runtime} {resources.mem_mb} >> limits;"
        "test $(wc -l < limits) = 3 && touch {output}"
"""


def test_profiles_are_as_quiet_and_as_careful_as_the_default(repository):
    read = {
        name: yaml.safe_load((repository / f"profiles/{name}/config.yaml").read_text("utf-8"))
        for name in ("default", "generic", "slurm")
    }
    kept = ("quiet", "show-failed-logs", "rerun-incomplete", "keep-going", "rerun-triggers")
    for name in ("generic", "slurm"):
        assert {key: read[name].get(key) for key in kept} == {
            key: read["default"][key] for key in kept
        }


@pytest.mark.parametrize("profile", ["generic", "slurm"])
def test_limits_of_a_job_grow_with_each_attempt(profile, repository, tmp_path):
    """A job that its time limit ended was submitted again with the same limit, and ended again."""
    text = (repository / f"profiles/{profile}/config.yaml").read_text(encoding="utf-8")
    values = yaml.safe_load(text)
    kept = {key: values[key] for key in ("default-resources", "retries", "cores")}
    (tmp_path / "profile").mkdir()
    (tmp_path / "profile/config.yaml").write_text(yaml.safe_dump(kept), encoding="utf-8")
    (tmp_path / "Snakefile").write_text(ENDED_TWICE, encoding="utf-8")
    done = snakemake(tmp_path, "--workflow-profile", "profile")
    assert done.returncode == 0, done.stdout
    assert (tmp_path / "limits").read_text().split() == ["10", "1000", "20", "2000", "30", "3000"]
    rules = "".join(path.read_text("utf-8") for path in repository.glob("workflow/rules/*.smk"))
    limits = re.findall(r"(?:runtime|mem_mb)=(\w+)", rules)
    assert {*limits} == {"growing"}


def test_a_check_without_a_reference_is_invalid_before_anything_is_made(fresh):
    """A study of one's own was simulated for 94 s, and `make reference` made the repository's."""
    study = ("--configfile", "config/plate.yaml")
    done = snakemake(fresh, "check", *study, "--dry-run")
    assert done.returncode != 0
    assert "no reference; `make reference STUDIES=plate` makes one" in done.stdout


def test_a_compared_file_that_was_deleted_is_made_again_by_the_check(repository, tmp_path):
    """Of a study in which every file is there; what is in the files does not matter here."""
    folder = copy_checkout(repository, tmp_path / "checkout", "tests/reference")
    for row in planned(folder, "check"):
        path = folder / row["output_file"]
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("made\n", encoding="utf-8")
    assert snakemake(folder, "check", *QUICK, "--touch").returncode == 0
    (folder / "results/quick/simulations/screen/forces.csv").unlink()
    told = snakemake(folder, "check", *QUICK, "--dry-run").stdout
    assert "Simulate screen" in told
    assert "Results beside the stored reference" in told
