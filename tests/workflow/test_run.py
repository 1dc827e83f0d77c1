"""The quick study runs from start to end, and then there is nothing left to do."""

import numpy

from squeezefilm.tables import read_forces, read_json, read_scenes

from .conftest import EVERYTHING, QUICK, copy_checkout, snakemake

NOTHING = "Nothing to be done"


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


def test_a_copy_of_the_checkout_with_its_results_has_nothing_to_do(finished, tmp_path):
    copy = copy_checkout(finished.folder, tmp_path / "elsewhere", "results", ".snakemake")
    done = snakemake(copy, *EVERYTHING, *QUICK)
    assert done.returncode == 0
    assert NOTHING in done.stdout


def test_a_wrong_study_ends_before_anything_runs(finished, tmp_path):
    """What is wrong, and how it is told: tests/unit/test_config.py."""
    text = (finished.folder / "config/quick.yaml").read_text()
    (tmp_path / "wrong.yaml").write_text(text.replace("viscosity:", "viscosty:"))
    done = snakemake(finished.folder, "--configfile", str(tmp_path / "wrong.yaml"))
    assert done.returncode != 0
    assert "did you mean 'viscosity'" in done.stdout
    assert "Traceback" not in done.stdout
    assert "Building DAG" not in done.stdout
