"""The library from its wheel, in an environment of its own; the network is needed."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

CODE = """
import json, sys
import squeezefilm as sf
study = sf.load("paper.yaml")
force = study.force(h0="5 um", hv="2.2 um")
field = study.pressure(h0="5 um", hv="2.2 um", places=5, instants=4, tolerance=1e-2)
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


@pytest.fixture(scope="module")
def alone(repository, library_source, tmp_path_factory):
    """A folder with an environment in it that has the wheel and the extras of the library."""
    folder = tmp_path_factory.mktemp("elsewhere")
    uv = [sys.executable, "-m", "uv", "--quiet"]
    run(*uv, "build", "--wheel", "--out-dir", folder, library_source, folder=folder)
    run(*uv, "venv", "--python", sys.executable, folder / "alone", folder=folder)
    (wheel,) = folder.glob("*.whl")
    python = folder / "alone/bin/python"
    run(*uv, "pip", "install", "--python", python, f"{wheel}[fields]", folder=folder)
    (folder / "paper.yaml").write_bytes((repository / "config" / "paper.yaml").read_bytes())
    return folder


def test_the_door_opens_without_a_checkout(alone):
    found = json.loads(run(alone / "alone/bin/python", "-c", CODE, folder=alone))
    assert Path(found["place"]).is_relative_to(alone)
    assert found["force_n"] == pytest.approx(0.9620420, abs=2e-6)
    assert found["units"] == "Pa"
    assert found["theta"] == pytest.approx([7.624, 1.917, -1.001], abs=1e-3)
    assert not found["snakemake"]
    point = ("--h0", "5um", "--hv", "2.2um", "--config", "paper.yaml")
    assert "0.96204" in run(alone / "alone/bin/squeezefilm", "simulate", *point, folder=alone)
