"""What ``simulate --dry-run`` shows is what ``solve`` does."""

from typing import Any

import numpy as np
import pandas as pd
import pytest
from films import PISTON, SINC, film, with_pad

from squeezefilm.cli.main import main
from squeezefilm.film.pad import GapShape
from squeezefilm.film.profiles import Profile, StandingWave
from squeezefilm.film.scene import Scene
from squeezefilm.reynolds import solve
from squeezefilm.reynolds.dry_run import dry_run as dry_run_of
from squeezefilm.reynolds.solver import METHODS
from squeezefilm.studies.space import plan_table
from squeezefilm.table_writer import write_table

PROFILES: tuple[Profile, ...] = (SINC, PISTON, PISTON, StandingWave(0.02, 30.0, 0.001))
# What only solving shows.
FOUND_OUT = ("not converged: tolerance not reached on the finest grid",)


TERMS: tuple[dict[str, Any], ...] = (
    {},
    {},
    {"bearing": 2.0},
    {"bearing": 31.0},
    {"rarefaction": "slip"},
    {"rarefaction": "fukui-kaneko"},
    {"polytropic_exponent": 1.4},
)


def random_scene(random: np.random.Generator) -> Scene:
    """Any pad, gas, motion and profile that a study can say, not too hard to solve."""
    x, y = (float(place) for place in random.choice([0.0, 0.2], 2))
    shaped = random.random() < 0.3
    scene = film(
        epsilon=float(random.choice([0.0, 1e-3, random.uniform(0.05, 0.5)])),
        sigma=float(10 ** random.uniform(0, 1.5 if shaped else 3.5)),
        profile=PROFILES[random.integers(len(PROFILES))],
        x=x,
        y=y,
        aspect=float(random.choice([1.0, 0.5])),
        **TERMS[random.integers(len(TERMS))],
    )
    if not shaped:
        return scene
    shape = str(random.choice(["rectangle", "ellipse"]))
    gap = GapShape(tilt_x_m=float(random.choice([0.0, 1e-6])))
    return with_pad(scene, shape=shape, gap=gap)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("tolerance", [1e-1, 3e-3])
def test_every_method_does_what_is_planned_on_random_scenes(method, tolerance):
    random = np.random.default_rng(20261122)
    scenes = [random_scene(random) for _ in range(24)]
    planned = dry_run_of(scenes, tolerance=tolerance, method=method)
    solutions = solve(scenes, tolerance=tolerance, method=method)
    for row, solution in zip(planned, solutions, strict=True):
        assert row["method"] == solution.method
        assert "; ".join(each.name for each in row["absent"]) == solution.absent_terms
        if solution.status.startswith(FOUND_OUT):
            assert row["status"] == "ok"
        else:
            assert row["status"] == solution.status
        assert (row["domain"] == "") == (solution.nx == 0)
        assert (row["expected_mflop"] == 0) == (row["domain"] == "")
        assert all(each.absence_reason for each in row["absent"])
    assert method in ("auto", "periodic") or {each["status"] for each in planned} != {"ok"}


@pytest.fixture
def dry_run(tmp_path):
    """A function that plans two of the paper's scenes by the command and gives its table."""

    def dry_run(*words: str) -> pd.DataFrame:
        scenes, output = tmp_path / "scenes.csv", tmp_path / "plan.csv"
        factors = {"h0_m": [5e-6, 1e-5], "hv_m": 2e-6, "phi_r_m": [0.0, 1e-3], "phi_deg": 0.0}
        write_table(plan_table(pd.DataFrame(factors)), scenes)
        config = ["--config", "config/paper.yaml", "--output", str(output)]
        assert main(["simulate", str(scenes), *config, "--dry-run", *words]) == 0
        return pd.read_csv(output)

    return dry_run


def test_a_dry_run_writes_a_row_per_scene(dry_run, capsys):
    assert list(dry_run()["domain"]) == ["quarter", "half in y"]
    assert "symmetry               y (half domain)" in capsys.readouterr().out
    statuses = dry_run("--method", "composite")["status"]
    assert all("the composite expansion is accurate to" in each for each in statuses)
    assert "mean force             not available: the composite" in capsys.readouterr().out


def test_a_dry_run_of_one_point_shows_absent_terms_and_why(capsys):
    words = ["--h0", "5um", "--hv", "2um", "--config", "config/paper.yaml", "--dry-run"]
    assert main(["simulate", *words]) == 0
    shown = capsys.readouterr().out
    assert "inertia: gas.inertia does not include it" in shown
