"""The loop on the real film, and the commands around it: what they promise and what they refuse."""

import json
import shutil
from dataclasses import dataclass
from pathlib import Path

import pandas as pd
import pytest
import yaml

from reporting.figures import FIGURES, save
from reporting.pages import render
from reporting.refinement import refinement_table
from reporting.results import Results
from squeezefilm.cli.main import main
from squeezefilm.config.loading import load_config
from squeezefilm.errors import InputError
from squeezefilm.studies.tasks import refined_model
from squeezefilm.tables import read_forces


@dataclass(frozen=True)
class Refined:
    """What a refinement wrote, and unseen points to compare it with."""

    folder: Path
    unseen: Path
    limits: Path

    @property
    def sample(self) -> dict[str, str]:
        return {"sample": str(self.unseen), "sample_limits": str(self.limits)}

    def verdict(self, model: str) -> dict:
        return json.loads((self.folder / model / "verdict.json").read_text())


def study(repository: Path, path: Path, **more: dict) -> Path:
    """The quick study with other settings of some sections."""
    values = yaml.safe_load((repository / "config/quick.yaml").read_text(encoding="utf-8"))
    values["models"] = {"square": {"expression": "t0*(hv/h0)**2"}}
    values["comparison"] = {"two_factor": ["limit_1"], "four_factor": ["limit_1"]}
    for section, settings in ({"validation": {"points": 60}} | more).items():
        values[section] = values[section] | settings
    path.write_text(yaml.safe_dump(values), encoding="utf-8")
    return path


def refine(script, model: str, folder: Path, config: Path, sample: dict[str, str]) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    names = ("rounds.csv", "forces.csv", "limits.csv", "fit.json", "where.csv", "verdict.json")
    output = {name.partition(".")[0]: str(folder / name) for name in names}
    given = sample | {"scan": []}
    script("refine", config, input=given, output=output, model=model, space="four_factor")


@pytest.fixture(scope="module")
def refined(repository, tmp_path_factory, script):
    folder = tmp_path_factory.mktemp("refined")
    config = study(repository, folder / "study.yaml", refine={"worst_error": 0.01})
    scenes, forces, limits = (folder / f"{name}.csv" for name in ("scenes", "forces", "limits"))
    end = ["--config", str(config), "--output"]
    script("plan", config, input={"sources": []}, output=scenes, plan="validation_four_factor")
    assert main(["simulate", str(scenes), *end, str(forces)]) == 0
    script("limits", config, input={"scenes": scenes}, output=limits)
    made = Refined(folder, forces, limits)
    for model in ("limit_2", "square"):
        refine(script, model, folder / model, config, made.sample)
    return made


def test_physics_with_two_parameters_is_good_enough_with_few_simulations(refined):
    verdict = refined.verdict("limit_2")
    assert verdict["verdict"] == "reached"
    assert verdict["simulations"] <= 20
    forces = read_forces(refined.folder / "limit_2" / "forces.csv")
    assert len(forces) == verdict["simulations"]
    assert forces["point_id"].str.startswith("verification").sum() == 8
    assert not forces.duplicated(["h0_m", "hv_m", "phi_r_m", "phi_deg"]).any()


def test_a_model_that_lacks_terms_is_limited_by_the_model_and_told_where(refined):
    verdict = refined.verdict("square")
    assert verdict["verdict"] == "model"
    assert verdict["errors_mapped_by"] == "physics limit"
    assert "high third of the ratio hv/h0" in verdict["error_by_region_text"]
    where = pd.read_csv(refined.folder / "square" / "where.csv")
    epsilon = where["hv_m"] / where["h0_m"]
    assert where["error_n"].abs().groupby(epsilon > 0.2).mean().is_monotonic_increasing


def reported(refined, folder: Path, *models: Path) -> tuple[pd.DataFrame, str, str]:
    """The table of a report on refined models, its page, and its figure's drawing."""
    for model in models:
        shutil.copytree(model, folder / "refine/two_factor" / model.name)
    plan = folder / "simulations/validation_two_factor"
    plan.mkdir(parents=True)
    shutil.copy(refined.unseen, plan / "forces.csv")
    shutil.copy(refined.limits, plan / "limits.csv")
    config = load_config(refined.folder / "study.yaml")
    names = [model.name for model in models]
    results = Results(folder, {**config, "refine": {"two_factor": names}})
    table, values = refinement_table(results, "two_factor")
    table.to_csv(folder / "refine/two_factor.csv", index=False)
    save(FIGURES["refine/two_factor_figure"], results, [folder / "f.svg"])
    drawn = (folder / "f.svg").read_text(encoding="utf-8")
    return table.set_index("model"), render("refine.md", **values), drawn


def test_the_report_compares_estimates_with_the_truth(refined, tmp_path):
    folders = [refined.folder / name for name in ("square", "limit_2")]
    table, text, drawn = reported(refined, tmp_path, *folders)
    good = table.loc["limit_2"]
    assert good["unseen_global_error"] < 5e-4
    assert good["unseen_global_error"] < good["estimated_global_upper"]
    assert good["share_in_interval"] > 0.8
    assert table.loc["square", "unseen_global_error"] > 100 * good["unseen_global_error"]
    assert "limited by the model" in text
    assert "as good as wanted" in text
    assert "square: limited by the model" in drawn


@pytest.mark.parametrize(
    ("model", "settings", "message"),
    [
        ("none_such", {}, "model 'none_such' is unknown"),
        ("polynomial_5", {"simulations": 10}, "more than the 10 allowed"),
    ],
)
def test_what_cannot_be_refined_is_refused(
    model, settings, message, repository, refined, tmp_path, script
):
    config = study(repository, tmp_path / "study.yaml", refine=settings)
    with pytest.raises(InputError, match=message):
        refine(script, model, tmp_path, config, refined.sample)


def test_a_model_whose_physics_does_not_hold_is_left_out_before_anything_is_simulated(
    repository, refined, tmp_path, monkeypatch, script
):
    def no_simulation(*arguments: object, **settings: object) -> None:
        raise AssertionError("a scene is simulated")

    monkeypatch.setattr(refined_model, "solve", no_simulation)
    config = study(repository, tmp_path / "study.yaml", finger={"shape": "ellipse"})
    refine(script, "limit_1", tmp_path / "limit_1", config, refined.sample)
    for others in ([], [refined.folder / "limit_2"]):
        folder = tmp_path / f"results-{len(others)}"
        table, page, drawn = reported(refined, folder, tmp_path / "limit_1", *others)
        assert table.loc["limit_1", "verdict"] == "left out"
        assert set(table.index) == {"limit_1", *(other.name for other in others)}
        assert "- **limit_1**, left out: limit_n: unknown at" in page
        assert ("no model of this space was refined" in drawn) == (not others)
