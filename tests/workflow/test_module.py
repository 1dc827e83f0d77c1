"""The rules in other workflows and folders; a study given twice or wrong is refused."""

import json
import re
import shutil
import subprocess
from textwrap import dedent

import pandas as pd
import pytest
import yaml
from example_outline import STUDY as WITH_OUTLINE
from example_outline import write_outline

from squeezefilm.config.loading import load_config
from squeezefilm.tables import read_scenes

from .conftest import PARTS, copy_checkout, snakemake

PREFIX = "große Läufe"
SCENES = f"{PREFIX}/results/mine/simulations/screen/scenes.csv"
OUTER = """
configfile: "mine.yaml"

module film:
    snakefile: "{snakefile}"
    config: config
    prefix: "{prefix}"

use rule * from film as film_*
"""


def test_a_module_makes_the_study_that_it_is_given(repository, tmp_path):
    """In a folder with spaces and umlauts, where the clone lies too, under a prefix with them."""
    folder = tmp_path / "Ordner mit Umläuten äöü, it's one"
    clone = copy_checkout(repository, folder / "squeezefilm, Kopie")
    study = yaml.safe_load((repository / "config/quick.yaml").read_text(encoding="utf-8"))
    study["study"] = "mine"
    study["screen"]["h0"] = {"start": 5e-6, "stop": 7e-6, "levels": 3}
    (folder / "mine.yaml").write_text(yaml.safe_dump(study), encoding="utf-8")
    text = OUTER.format(snakefile=clone / "workflow/Snakefile", prefix=PREFIX)
    (folder / "Snakefile").write_text(text, encoding="utf-8")
    done = snakemake(folder, SCENES, "--cores", "1")
    assert done.returncode == 0, done.stdout
    h0_m = pd.Series(read_scenes(folder / SCENES)["h0_m"].unique())
    assert h0_m.tolist() == pytest.approx([5e-6, 6e-6, 7e-6])
    # What the commands read is the study, whole, and nothing of another one.
    written = load_config(folder / "results/mine/study.yaml")
    assert dict(written) == dict(load_config(folder / "mine.yaml"))
    for place in (folder, folder / PREFIX):
        assert [path.name for path in (place / "results").iterdir()] == ["mine"]
    again = snakemake(folder, SCENES, "--cores", "1")
    assert "Nothing to be done" in again.stdout


TWO = """
import json

module one:
    snakefile: "{snakefile}"
    config: json.loads('{one}')

module two:
    snakefile: "{snakefile}"
    config: json.loads('{two}')

use rule * from one as one_*
use rule * from two as two_*

rule both:
    default_target: True
    input: rules.one_all.input, rules.two_all.input
    message: "Two studies"
"""


def test_jobs_of_two_studies_name_their_own(repository, mine, tmp_path):
    """Both had the same words, such as \"Simulate screen\"."""
    clone = copy_checkout(repository, tmp_path / "clone")
    studies = {name: json.dumps(mine | {"study": f"study-{name}"}) for name in ("one", "two")}
    text = TWO.format(snakefile=clone / "workflow/Snakefile", **studies)
    (tmp_path / "Snakefile").write_text(text, encoding="utf-8")
    done = snakemake(tmp_path, "--dry-run", "--quiet", "host", "reason")
    assert done.returncode == 0, done.stdout
    jobs = [
        line.partition(": ")[2]
        for line in done.stdout.splitlines()
        if line[:4] == "Job " and line[4].isdigit()
    ]
    of_each = {name: [job for job in jobs if job.startswith(f"study-{name}: ")] for name in studies}
    assert "study-one: Simulate screen" in of_each["one"]
    assert len(of_each["one"]) == len(of_each["two"]) > 30
    assert len(jobs) == 2 * len(of_each["one"]) + 1


DEVICE = "results/mine/simulations/device.json"
DEPLOYED = """
configfile: "config/config.yaml"

module squeezefilm:
    snakefile:
        gitfile("{repository}", path="workflow/Snakefile", commit="{commit}")
    config:
        config

use rule * from squeezefilm
"""
FORCES = "h0_m,hv_m,force_n,force_uncertainty_n\n2e-5,1e-6,1e-3,1e-4\n"
NOT_INSTALLED = "raise ModuleNotFoundError(name='squeezefilm')"


@pytest.fixture
def mine(repository):
    """The quick study as another workflow gives it."""
    study = yaml.safe_load((repository / "config/quick.yaml").read_text(encoding="utf-8"))
    return {**study, "study": "mine"}


@pytest.mark.skipif(not shutil.which("git"), reason="no git")
def test_rules_come_from_a_git_repository(repository, installed, mine, tmp_path):
    """As `snakedeploy deploy-workflow` writes it; the packages are those of the wheel."""
    source, folder = tmp_path / "repository", tmp_path / "deployed"
    source.mkdir()
    git = ("git", "-C", str(source), "-c", "user.name=A", "-c", "user.email=a@b.c")
    shutil.copytree(
        repository,
        source,
        dirs_exist_ok=True,
        ignore=lambda place, names: [
            name for name in names if place == str(repository) and name not in PARTS
        ],
    )
    for words in (("init", "-q"), ("add", "-A"), ("commit", "-qm", "rules")):
        subprocess.run([*git, *words], check=True)
    words = [*git, "rev-parse", "HEAD"]
    commit = subprocess.run(words, capture_output=True, text=True, check=True).stdout.strip()
    (folder / "config").mkdir(parents=True)
    (folder / "config/config.yaml").write_text(yaml.safe_dump(mine), encoding="utf-8")
    text = DEPLOYED.format(repository=source, commit=commit)
    (folder / "Snakefile").write_text(text, encoding="utf-8")
    done = snakemake(folder, DEVICE, "--cores", "1", environment={"PYTHONPATH": str(installed)})
    assert done.returncode == 0, done.stdout
    assert (folder / DEVICE).exists()
    (tmp_path / "none").mkdir()
    (tmp_path / "none/squeezefilm.py").write_text(NOT_INSTALLED, encoding="utf-8")
    without = {"PYTHONPATH": str(tmp_path / "none")}
    refused = snakemake(folder, "--dry-run", environment=without)
    assert refused.returncode != 0
    assert "squeezefilm is not installed here; install" in refused.stdout
    assert "Traceback" not in refused.stdout


def test_two_studies_are_two_modules(repository, tmp_path):
    """As the page shows them: each in its own folder; an edit of one leaves the other as it is."""
    study = yaml.safe_load((repository / "config/synthetic.yaml").read_text(encoding="utf-8"))
    study["measurements"] = {"file": "forces.csv"}
    (tmp_path / "forces.csv").write_text(FORCES, encoding="utf-8")
    (tmp_path / "config").mkdir()
    for name in ("mine", "second"):
        text = yaml.safe_dump({**study, "study": name})
        (tmp_path / f"config/{name}.yaml").write_text(text, encoding="utf-8")
    (tmp_path / "squeezefilm").symlink_to(repository)
    page = (repository / "docs/how-to/modules.md").read_text(encoding="utf-8")
    (shown,) = re.findall(r"^    import yaml\n(?:(?:    .*)?\n)*", page, re.MULTILINE)
    (tmp_path / "Snakefile").write_text(dedent(shown), encoding="utf-8")
    figure = "results/mine/figures/measurements.svg"
    done = snakemake(tmp_path, figure, "--cores", "1")
    assert done.returncode == 0, done.stdout
    assert [path.name for path in (tmp_path / "results/second").iterdir()] == ["study.yaml"]
    edited = yaml.safe_dump({**study, "study": "second", "solver": {"tolerance": 1e-5}})
    (tmp_path / "config/second.yaml").write_text(edited, encoding="utf-8")
    assert "Nothing to be done" in snakemake(tmp_path, figure, "--dry-run").stdout


def test_a_clone_is_reached_through_a_link(repository, tmp_path):
    (tmp_path / "link").symlink_to(repository)
    words = ("--snakefile", "link/Snakefile", "--configfile", "link/config/quick.yaml")
    device = "results/quick/simulations/device.json"
    done = snakemake(tmp_path, device, *words)
    assert done.returncode == 0, done.stdout
    assert (tmp_path / "logs/quick/compile_kernels.log").exists()


def test_results_are_a_link_and_a_finished_study_is_moved(repository, tmp_path):
    """A study with an outline and measured forces, in another workflow, with a prefix."""
    folder = tmp_path / "before"
    (folder / "disk/of/results").mkdir(parents=True)
    (folder / "results").symlink_to("disk/of/results")
    write_outline(folder)
    (folder / "forces.csv").write_text(FORCES, encoding="utf-8")
    still = "gas: {inertia: none, thermal: none}\nmeasurements: {file: forces.csv}\n"
    (folder / "mine.yaml").write_text(WITH_OUTLINE + still, encoding="utf-8")
    text = OUTER.format(snakefile=repository / "workflow/Snakefile", prefix="under")
    (folder / "Snakefile").write_text(text, encoding="utf-8")
    target = "under/results/patch/measurements/summary.json"
    done = snakemake(folder, target, "--cores", "1")
    assert done.returncode == 0, done.stdout
    moved = folder.rename(tmp_path / "after")
    assert "Nothing to be done" in snakemake(moved, target, "--dry-run").stdout
    copied = shutil.copytree(moved, tmp_path / "copy", symlinks=True)
    assert "Nothing to be done" in snakemake(copied, target, "--dry-run").stdout


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--configfile", "{quick}", "{paper}"), "--configfile names {quick} and {paper}"),
        (("--config", "study=mine"), "--config sets single keys past the file's checks"),
        (("--configfile", "{wrong}"), "did you mean 'viscosity'"),
    ],
)
def test_a_wrong_study_or_a_mixture_is_refused_before_anything_runs(
    repository, tmp_path, words, message
):
    files = {name: repository / f"config/{name}.yaml" for name in ("quick", "paper")}
    files["wrong"] = tmp_path / "wrong.yaml"
    text = files["quick"].read_text(encoding="utf-8")
    files["wrong"].write_text(text.replace("viscosity:", "viscosty:"), encoding="utf-8")
    start = ("--snakefile", str(repository / "Snakefile"), "--dry-run")
    done = snakemake(tmp_path, *start, *(word.format(**files) for word in words))
    assert done.returncode != 0
    assert "squeezefilm: error:" in done.stdout
    assert message.format(**files) in done.stdout
    assert "Traceback" not in done.stdout
    assert "Building DAG" not in done.stdout
