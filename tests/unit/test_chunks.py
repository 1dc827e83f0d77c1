"""Jobs last about as long as the study asks, and how plans are divided changes no force."""

import pandas as pd
import pytest
from changed_sections import changed

from squeezefilm.api import forces as simulation
from squeezefilm.config.study import Study
from squeezefilm.studies.plans import chunk_counts, expected_seconds_per_scene


def with_jobs_of(config: Study, seconds: float) -> Study:
    return changed(config, simulation={"seconds_per_job": seconds})


def test_a_plan_has_as_many_jobs_as_its_cost_asks_for(quick):
    scene = expected_seconds_per_scene(quick, centred=True)
    counts = chunk_counts(with_jobs_of(quick, 5.5 * scene))
    assert counts["screen"] == 3  # 12 scenes
    assert counts["error_map"] == 7  # 36 scenes
    large = changed(quick, sweep={"points": 10**6 + 1})
    counts = chunk_counts(with_jobs_of(large, 1e5))
    # At most half a million scenes each.
    assert counts == dict.fromkeys(counts, 1) | {"sweep": 3}
    assert chunk_counts(with_jobs_of(quick, 1e-5))["screen"] == 12  # at least a scene each


@pytest.mark.parametrize("suffix", ["csv", "parquet"])
def test_neither_chunks_nor_pieces_change_a_row(repository, tmp_path, monkeypatch, suffix, script):
    config = str(repository / "config" / "quick.yaml")
    names = ("scenes", "forces", "timings")
    whole = {name: str(tmp_path / f"{name}.{suffix}") for name in names}
    settings = {"params": {"keep_failed": False}, "plan": "sweep"}
    monkeypatch.setattr("squeezefilm.studies.plans.SWEEP_POINTS_PER_PIECE", 8)
    script("simulate", config, input={"sources": []}, output=whole, **settings)
    monkeypatch.setattr(simulation, "ROWS_PER_WRITE", 4)
    parts = [
        {name: str(tmp_path / f"{name}-{part}.{suffix}") for name in names[1:]} for part in (1, 2)
    ]
    for part, output in enumerate(parts, start=1):
        chunk = {"chunk": part, "chunks": 2}
        script("simulate", config, input={"scenes": whole["scenes"]}, output=output, **chunk)
    merged = {name: str(tmp_path / f"merged-{name}.{suffix}") for name in names[1:]}
    given = {name: [part[name] for part in parts] for name in merged} | {"scenes": whole["scenes"]}
    script("merge", config, input=given, output=merged, **settings)
    read = pd.read_csv if suffix == "csv" else pd.read_parquet
    assert len(read(whole["forces"])) == len(read(merged["timings"])) == 30
    assert read(merged["forces"]).equals(read(whole["forces"]))
