"""The library from its wheel, in an environment of its own; the network is needed."""

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from squeezefilm.tables import read_ok_forces

CODE = """
import json, sys
import squeezefilm as sf
study = sf.load("paper.yaml")
force = study.force(h0="5 um", hv="2.2 um")
field = study.pressure(h0="5 um", hv="2.2 um", points_per_side=5, time_points=4, tolerance=1e-2)
fit = study.fit("two_factor")
print(json.dumps({
    "place": sf.__file__, "force_n": force.force_n, "units": field.gauge_pressure.attrs["units"],
    "theta": list(fit.theta.values()), "snakemake": "snakemake" in sys.modules,
}))
"""


def run(*words: object, folder: Path) -> str:
    """Run a command with nothing of the checkout in its environment; what it prints."""
    kept = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
    done = subprocess.run(
        [str(word) for word in words],
        cwd=folder,
        env=kept,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr[-3000:]
    return done.stdout


UV = (sys.executable, "-m", "uv", "--quiet")


def environment(folder: Path, *packages: object) -> Path:
    """The programs of a new environment in a folder, with packages as they are named today."""
    run(*UV, "venv", "--python", sys.executable, "environment", folder=folder)
    run(*UV, "pip", "install", "--python", "environment/bin/python", *packages, folder=folder)
    return folder / "environment/bin"


@pytest.fixture(scope="module")
def wheel(library_source, tmp_path_factory):
    folder = tmp_path_factory.mktemp("wheel")
    run(*UV, "build", "--wheel", "--out-dir", folder, library_source, folder=folder)
    (wheel,) = folder.glob("*.whl")
    return wheel


OLDEST = "the oldest that is allowed"


@pytest.mark.parametrize("version", [OLDEST, "the newest"])
def test_rules_run_with_the_packages_of_the_wheel(repository, wheel, tmp_path, version):
    """A simulation, and a plan of everything; the rules lie alone, without the packages."""
    project = (repository / "pyproject.toml").read_text(encoding="utf-8")
    oldest = re.findall(r'"snakemake>=([\d.]+)"', project)[0]
    snakemake = f"snakemake=={oldest}.*" if version == OLDEST else "snakemake"
    programs = environment(tmp_path, f"{wheel}[workflow]", snakemake)
    shutil.copytree(
        repository / "workflow",
        tmp_path / "workflow",
        ignore=shutil.ignore_patterns("squeezefilm*", "__pycache__"),
    )
    for name in ("config", "envs"):
        shutil.copytree(repository / name, tmp_path / name)
    command = (programs / "snakemake", "--configfile", "config/quick.yaml", "--cores", "2")
    run(*command, "results/quick/simulations/screen/forces.csv", folder=tmp_path)
    forces = read_ok_forces(tmp_path / "results/quick/simulations/screen/forces.csv")
    assert (forces["force_n"] > 0).all()
    plan = run(*command, "everything", "--dry-run", "--quiet", "rules", folder=tmp_path)
    assert "Traceback" not in plan


@pytest.fixture(scope="module")
def alone(repository, wheel, tmp_path_factory):
    """A folder with an environment in it that has the wheel and the extras of the library."""
    folder = tmp_path_factory.mktemp("elsewhere")
    environment(folder, f"{wheel}[fields]")
    (folder / "paper.yaml").write_bytes((repository / "config" / "paper.yaml").read_bytes())
    return folder


def test_the_door_opens_without_a_checkout(alone):
    found = json.loads(run(alone / "environment/bin/python", "-c", CODE, folder=alone))
    assert Path(found["place"]).is_relative_to(alone)
    assert found["force_n"] == pytest.approx(0.9620420, abs=2e-6)
    assert found["units"] == "Pa"
    assert found["theta"] == pytest.approx([7.624, 1.917, -1.001], abs=1e-3)
    assert not found["snakemake"]
    point = ("--h0", "5um", "--hv", "2.2um", "--config", "paper.yaml")
    assert "0.96204" in run(alone / "environment/bin/squeezefilm", "simulate", *point, folder=alone)
