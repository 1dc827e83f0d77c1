"""A study given by another workflow, or twice on the command line, is used as given or refused."""

import pandas as pd
import pytest
import yaml

from squeezefilm.config.loading import load_config
from squeezefilm.tables import read_scenes

from .conftest import copy_checkout, snakemake

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
    folder = tmp_path / "Ordner mit Umläuten äöü"
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
