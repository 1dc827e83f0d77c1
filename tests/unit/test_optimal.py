"""The command that certifies designs and judges plans beside them."""

import json

import numpy as np
import pandas as pd
import pytest

from squeezefilm.cli.main import main
from squeezefilm.designs.paper_design import d_efficiency
from squeezefilm.errors import InputError
from squeezefilm.models.data import Factors
from squeezefilm.models.fit_file import read_fit
from squeezefilm.models.force_model import FOUR_FACTOR, TWO_FACTOR
from squeezefilm.models.parameter_intervals import RANGES_NOTE
from squeezefilm.studies.tasks.optimal_designs import designs_of_fit
from squeezefilm.tables import read_ok_forces, read_scenes


@pytest.fixture(scope="module", params=["two_factor", "four_factor"])
def made(request, study, repository, tmp_path_factory, script):
    folder = tmp_path_factory.mktemp("optimal")
    fit = {"two_factor": "screen", "four_factor": "four_factor"}[request.param]
    points = study.root / "simulations" / fit
    none = folder / "none.json"
    none.write_text("{}")
    files = {
        "fit": study.root / "fits" / f"{fit}.json",
        "forces": points / "forces.csv",
        "existing": study.root / "simulations/two_factor_design/scenes.csv",
        "patterns": study.root / "designs/two_factor.json" if fit == "screen" else none,
    }
    given = {name: str(path) for name, path in files.items()}
    script(
        "optimal_designs",
        repository / "config/quick.yaml",
        input=given | {"plans": [str(points / "scenes.csv")]},
        output={
            "designs": f"{folder}/d.csv",
            "efficiencies": f"{folder}/p.csv",
            "sensitivity": f"{folder}/m.csv",
            "summary": f"{folder}/s.json",
        },
    )
    return request.param, folder


def test_the_local_design_is_certified(made):
    _, folder = made
    summary = json.loads((folder / "s.json").read_text())
    assert summary["parameter_ranges_note"] == RANGES_NOTE
    for name in ("local", "bayesian", "maximin"):
        assert summary["certificates"][name] > 1 - 1e-4, name
    data = pd.read_csv(folder / "m.csv")
    assert data["sensitivity"].max() <= 1 + 1e-6
    at_points = data[data["layer"] == "design"]["sensitivity"]
    np.testing.assert_allclose(at_points, 1, atol=1e-4)


def test_efficiencies_are_true_and_their_bounds_below_them(made):
    name, folder = made
    table = pd.read_csv(folder / "p.csv", index_col="plan")
    assert (table["lower_bound"] <= table["d_efficiency"]).all()
    assert (table["least_over_ranges"] <= table["mean_over_ranges"]).all()
    assert table.loc["local", "d_efficiency"] == pytest.approx(1)
    for exact in ("exact-5", "exact-8"):  # without replicates
        assert table.loc[exact, "scenes"] == table.loc[exact, "points"]
    if name == "two_factor":
        assert (table.loc[["pattern A (unit)", "pattern B (unit)"], "d_efficiency"] > 0.999).all()
    model = {"two_factor": TWO_FACTOR, "four_factor": FOUR_FACTOR}[name]
    theta = json.loads((folder / "s.json").read_text())["theta"]
    designs = pd.read_csv(folder / "d.csv")

    def derivatives(design: str) -> np.ndarray:
        rows = designs[designs["design"] == design]
        columns = ("h0_m", "hv_m", "phi_r_m", "phi_deg")
        return model.gradient(theta, Factors.of(**{each: rows[each] for each in columns}))

    # By the definition that the paper's designs are judged by, between two exact designs.
    ratio = d_efficiency(derivatives("exact-8"), derivatives("exact-5"))
    listed = table["d_efficiency"]
    assert ratio == pytest.approx(listed["exact-8"] / listed["exact-5"], rel=1e-6)


def test_designs_for_a_table_of_ones_own(study, repository, tmp_path, capsys):
    words = ["optimal", f"{study.root}/fits/screen.json", f"--output={tmp_path}/d.csv"]
    words += [f"--forces={study.root}/simulations/screen/forces.csv"]
    assert main([*words, f"--config={repository}/config/quick.yaml"]) == 0
    assert {"local", "bayesian", "maximin"} < set(pd.read_csv(tmp_path / "d.csv")["design"])
    assert "d_efficiency" in capsys.readouterr().out


def test_a_plan_off_the_centre_is_refused_for_a_centred_model(study, quick):
    folder = study.root / "simulations"
    with pytest.raises(InputError, match="the finger is moved"):
        designs_of_fit(
            read_fit(study.root / "fits/screen.json"),
            quick,
            forces=read_ok_forces(folder / "screen/forces.csv"),
            plans={"plan": read_scenes(folder / "four_factor/scenes.csv")},
        )
