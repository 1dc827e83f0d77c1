"""What is said to decide no result does not: without it, a simulation writes the same table."""

import contextlib
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from squeezefilm.cli.main import main
from squeezefilm.io import job, progress
from squeezefilm.reynolds import node_cache, provenance

SCENES = "point_id,h0_m,hv_m,phi_r_m,phi_deg\n1,5e-6,2e-6,0,0\n2,6e-6,2e-6,2e-3,45\n"


def simulated(scenes: Path, config: Path, output: Path) -> bytes:
    arguments = ["simulate", str(scenes), "--config", str(config), "--output", str(output)]
    assert main(arguments, packages=("squeezefilm.cli.use",)) == 0
    return output.read_bytes()


@contextlib.contextmanager
def nothing(*_: Any, **__: Any) -> Any:
    """In place of anything, also of what is closed by ``with`` and moved on by ``update``."""
    yield SimpleNamespace(update=lambda count: None)


def test_a_simulation_without_what_decides_nothing_is_the_same(repository, tmp_path, monkeypatch):
    scenes, config = tmp_path / "scenes.csv", repository / "config" / "quick.yaml"
    scenes.write_text(SCENES)
    before = simulated(scenes, config, tmp_path / "before.csv")
    for module, name in (
        (job, "check_wanted"),
        (job, "note"),
        (job, "note_file"),
        (progress, "progress_bar"),
        (node_cache, "one_build_at_a_time"),
        (provenance, "finish"),
    ):
        monkeypatch.setattr(module, name, nothing)
    monkeypatch.setattr("squeezefilm.cli.use.simulate.progress_bar", nothing)
    assert simulated(scenes, config, tmp_path / "after.csv") == before
