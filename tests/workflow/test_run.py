"""The quick study runs from start to end, and then there is nothing left to do."""

import re

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


def test_progress_is_shown_and_every_job_has_its_log(finished):
    assert "Simulate four_factor, part 1 of 2" in finished.log
    steps = re.findall(r"^(\d+) of (\d+) steps \(100%\) done", finished.log, re.MULTILINE)
    assert steps
    assert steps[-1][0] == steps[-1][1]
    logs = {path.parent.name for path in (finished.folder / "logs/quick").rglob("*.log")}
    assert {"fit", "simulate", "error_map"} <= logs
    plans = (finished.folder / "results/quick/simulations").glob("*/scenes.*")
    timed = (finished.folder / "benchmarks/quick/simulate").glob("*")  # a folder for parts
    assert {path.parent.name for path in plans} == {path.name.partition(".")[0] for path in timed}


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


def test_an_edit_is_carried_out_and_undone(finished, tmp_path):
    folder = copy_checkout(finished.folder, tmp_path / "edited", "results", ".snakemake")
    plans = folder / "workflow/squeezefilm/studies/plans.py"
    before = plans.read_text()
    # One amplitude a thousandth larger: a change of behaviour that reaches the forces.
    plans.write_text(before.replace('f"{value:.12g}"', 'f"{value * 1.001:.12g}"'))
    target = "results/quick/simulations/screen/forces.csv"
    original = (folder / target).read_bytes()
    times = {path: path.stat().st_mtime_ns for path in (folder / "results").rglob("*.csv")}
    assert snakemake(folder, target, *QUICK).returncode == 0
    assert (folder / target).read_bytes() != original
    again = {path for path, time in times.items() if path.stat().st_mtime_ns != time}
    assert {str(path.relative_to(folder / "results/quick/simulations")) for path in again} == {
        "screen/scenes.csv",
        "screen/forces.csv",
        "screen/timings.csv",
    }
    plans.write_text(before)
    assert snakemake(folder, target, *QUICK).returncode == 0
    assert (folder / target).read_bytes() == original


def test_a_scene_that_fails_is_named_and_the_others_finish(finished, tmp_path):
    folder = copy_checkout(finished.folder, tmp_path / "failing", "results", ".snakemake")
    chunk = folder / "results/quick/simulations/four_factor/chunks/2-of-2.csv"
    table = read_forces(chunk)
    table.loc[0, ["status", "force_n"]] = ["no convergence in 40 steps", float("nan")]
    table.to_csv(chunk, index=False)
    target = "results/quick/simulations/four_factor/forces.csv"
    done = snakemake(folder, target, *QUICK)
    assert done.returncode != 0
    name = table["point_id"].iloc[0]
    assert f"no force for point {name}: no convergence in 40 steps" in done.stdout
    assert "Traceback" not in done.stdout
    assert len(read_forces(chunk)) == len(table)


def test_a_wrong_study_ends_before_anything_runs(finished, tmp_path):
    """What is wrong, and how it is told: tests/unit/test_config.py."""
    text = (finished.folder / "config/quick.yaml").read_text()
    (tmp_path / "wrong.yaml").write_text(text.replace("viscosity:", "viscosty:"))
    done = snakemake(finished.folder, "--configfile", str(tmp_path / "wrong.yaml"))
    assert done.returncode != 0
    assert "did you mean 'viscosity'" in done.stdout
    assert "Traceback" not in done.stdout
    assert "Building DAG" not in done.stdout
