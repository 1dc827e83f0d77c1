"""A study given by another workflow, or twice on the command line, is used as given or refused."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pandas as pd
import pytest
import yaml

from squeezefilm.config.loading import load_config
from squeezefilm.tables import read_scenes

from .conftest import copy_checkout, snakemake

SCENES = "results/mine/simulations/screen/scenes.csv"
OUTER = """
configfile: "mine.yaml"

module film:
    snakefile: "{snakefile}"
    config: {config}
{more}

use rule * from film as film_*
"""
Edit = Callable[[dict[str, Any]], object]


@pytest.fixture
def outer(repository, tmp_path):
    """A folder with a workflow of its own that uses this one as a module."""

    def write(
        edit: Edit = lambda study: None,
        *,
        config: str = "config",
        more: str = "",
        folder: Path = tmp_path,
        snakefile: Path = repository / "workflow/Snakefile",
    ) -> Path:
        text = (repository / "config/quick.yaml").read_text(encoding="utf-8")
        study = yaml.safe_load(text)
        study["study"] = "mine"
        edit(study)
        (folder / "mine.yaml").write_text(yaml.safe_dump(study), encoding="utf-8")
        (folder / "Snakefile").write_text(
            OUTER.format(snakefile=snakefile, config=config, more=more), encoding="utf-8"
        )
        return folder

    return write


def other_gaps(study: dict[str, Any]) -> None:
    study["screen"]["h0"] = {"start": 5e-6, "stop": 7e-6, "levels": 3}


def test_a_module_makes_the_study_that_it_is_given(outer):
    folder = outer(other_gaps)
    done = snakemake(folder, SCENES, "--cores", "1")
    assert done.returncode == 0, done.stdout
    h0_m = pd.Series(read_scenes(folder / SCENES)["h0_m"].unique())
    assert h0_m.tolist() == pytest.approx([5e-6, 6e-6, 7e-6])
    # What the commands read is the study, whole, and nothing of another one.
    assert dict(load_config(folder / "results/mine/study.yaml")) == dict(
        load_config(folder / "mine.yaml")
    )
    assert [path.name for path in (folder / "results").iterdir()] == ["mine"]
    again = snakemake(folder, SCENES, "--cores", "1")
    assert "Nothing to be done" in again.stdout


def test_a_module_works_in_a_folder_with_spaces_and_umlauts(repository, tmp_path, outer):
    """The clone lies there too, and the results get a prefix of that kind."""
    folder = tmp_path / "Ordner mit Umläuten äöü"
    clone = copy_checkout(repository, folder / "squeezefilm, Kopie")
    outer(more='    prefix: "große Läufe"', folder=folder, snakefile=clone / "workflow/Snakefile")
    files = [f"große Läufe/{name}" for name in ("results/mine/figures/fig07.png", SCENES)]
    done = snakemake(folder, *files, "--cores", "1")
    assert done.returncode == 0, done.stdout
    assert all((folder / file).is_file() for file in files)
    assert "Nothing to be done" in snakemake(folder, *files, "--cores", "1").stdout


def test_a_module_plans_as_much_as_the_workflow_alone(outer):
    done = snakemake(outer(), "film_everything", "--dry-run", "--quiet", "progress")
    assert done.returncode == 0, done.stdout
    assert "results/mine/models/two_factor" in done.stdout
    assert "results/paper" not in done.stdout


def test_a_module_s_prefix_is_for_its_results(outer):
    folder = outer(more='    prefix: "sub"')
    done = snakemake(folder, f"sub/{SCENES}", "--dry-run")
    assert done.returncode == 0, done.stdout


def test_a_module_s_study_is_checked_as_a_file_is(outer):
    folder = outer(lambda study: study["solver"].update(tolerance=7))
    refused(snakemake(folder, SCENES, "--dry-run").stdout, "solver.tolerance: 7")


def test_a_module_without_a_study_is_not_the_paper(outer):
    folder = outer(config="dict()")
    refused(snakemake(folder, "film_all", "--dry-run").stdout, "the module's config: there is none")


def refused(output: str, *messages: str) -> None:
    assert "squeezefilm: error:" in output
    for message in messages:
        assert message in output
    assert "Traceback" not in output
    assert "Building DAG" not in output


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--configfile", "{quick}", "{paper}"), "--configfile names {quick} and {paper}"),
        (("--configfile", "{quick}", "--configfile", "{paper}"), "{quick} and {paper}"),
        (("--config", "study=mine"), "squeezefilm: error:"),
    ],
)
def test_a_mixture_of_studies_is_refused(repository, tmp_path, words, message):
    files = {name: repository / f"config/{name}.yaml" for name in ("quick", "paper")}
    start = ("--snakefile", str(repository / "Snakefile"), "--dry-run")
    done = snakemake(tmp_path, *start, *(word.format(**files) for word in words))
    assert done.returncode != 0
    refused(done.stdout, message.format(**files))
