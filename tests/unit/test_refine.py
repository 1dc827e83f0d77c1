"""The loop on the real film, and the commands around it: what they promise and what they refuse."""

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml

from squeezefilm.cli.main import main
from squeezefilm.io.errors import InputError
from squeezefilm.io.tables import SCENE_COLUMNS, read_forces
from squeezefilm.models.data import factors_of
from squeezefilm.models.fit_file import read_fit
from squeezefilm.studies.config import load_config
from squeezefilm.studies.tasks import refined_model
from squeezefilm.studies.tasks.fits import limits_of


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
    values = dict(load_config(repository / "config/quick.yaml"))
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


def test_the_map_of_errors_is_right_where_nothing_was_simulated(refined):
    """It is the model less the physics limit, and that is close to the model less simulations."""
    verdict, forces = refined.verdict("square"), read_forces(refined.unseen)
    model = read_fit(refined.folder / "square" / "fit.json").force_model
    theta = verdict["theta_of_all_points"]
    limit = pd.read_csv(refined.limits)["limit_n"]
    truth = model.evaluate(theta, factors_of(forces)) - forces["force_n"]
    assert np.linalg.norm(limit - forces["force_n"]) < 0.1 * np.linalg.norm(truth)
    where = pd.read_csv(refined.folder / "square" / "where.csv").tail(20)
    scenes = where.assign(point_id=range(20))[list(SCENE_COLUMNS)]
    limits = limits_of(scenes, load_config(refined.folder / "study.yaml"))
    expected = model.evaluate(theta, factors_of(scenes)) - limits["limit_n"].to_numpy()
    np.testing.assert_allclose(where["error_n"], expected, rtol=1e-6)


def test_the_fits_file_tells_ranges_and_what_they_mean(refined):
    values = json.loads((refined.folder / "limit_2" / "fit.json").read_text())
    assert [each["name"] for each in values["parameter_ranges"]] == ["t0", "t1"]
    for each in values["parameter_ranges"]:
        assert each["lower"] < each["estimate"] < each["upper"]
    assert "conditional on this plan and on the formula" in values["parameter_ranges_note"]
    assert "not noise" in values["parameter_ranges_note"]


def test_the_report_compares_estimates_with_the_truth(refined, tmp_path):
    folders = [str(refined.folder / name) for name in ("square", "limit_2")]
    outputs = [tmp_path / name for name in ("t.csv", "t.md", "f.csv")]
    words = ["--forces", str(refined.unseen), "--limits", str(refined.limits)]
    for option, path in zip(("--output", "--report", "--figure"), outputs, strict=True):
        words += [option, str(path)]
    assert main(["refine-report", *folders, *words]) == 0
    table = pd.read_csv(outputs[0], index_col="model")
    good = table.loc["limit_2"]
    assert good["unseen_global_error"] < 5e-4
    assert good["unseen_global_error"] < good["estimated_global_upper"]
    assert good["share_in_interval"] > 0.8
    assert table.loc["square", "unseen_global_error"] > 100 * good["unseen_global_error"]
    text = outputs[1].read_text(encoding="utf-8")
    assert "limited by the model" in text
    assert "as good as wanted" in text
    assert main(["plot", "refine", str(outputs[2]), "--output", str(tmp_path / "f.svg")]) == 0
    drawn = (tmp_path / "f.svg").read_text(encoding="utf-8")
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
    words = ["--forces", str(refined.unseen), "--limits", str(refined.limits)]
    words += ["--output", f"{tmp_path}/t.csv", "--report", f"{tmp_path}/t.md"]
    for others in ([], [str(refined.folder / "limit_2")]):
        figure = f"{tmp_path}/figure-{len(others)}.csv"
        folders = [str(tmp_path / "limit_1"), *others]
        assert main(["refine-report", *folders, *words, "--figure", figure]) == 0
        table = pd.read_csv(tmp_path / "t.csv", index_col="model")
        assert table.loc["limit_1", "verdict"] == "left out"
        assert set(table.index) == {"limit_1", *(Path(other).name for other in others)}
        page = (tmp_path / "t.md").read_text(encoding="utf-8")
        assert "- **limit_1**, left out: limit_n: unknown at" in page
    drawing = tmp_path / "f.svg"
    assert main(["plot", "refine", f"{tmp_path}/figure-0.csv", "--output", str(drawing)]) == 0
    assert "nothing was simulated: limit_1" in drawing.read_text(encoding="utf-8")
