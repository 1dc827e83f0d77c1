"""A study's results in small, from reference forces and given parameters: nothing is solved."""

import shutil
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from reference_forces import FOUR_FACTOR_THETA, SCREEN_THETA

from paper import uncertainty
from reporting.results import Results
from squeezefilm.cli import main as cli
from squeezefilm.config.loading import load_config
from squeezefilm.models.data import Factors
from squeezefilm.models.force_model import FOUR_FACTOR, TWO_FACTOR, ExpressionModel
from squeezefilm.models.prediction_interval import measured_interval
from squeezefilm.solution import SOLUTION_COLUMNS, Solution
from squeezefilm.tables import (
    DESIGN_COLUMNS,
    FACTOR_COLUMNS,
    FORCE_COLUMNS,
    SCENE_COLUMNS,
    write_json,
    write_table,
)

THETA = {
    "screen": SCREEN_THETA,
    "two_factor_design": (7.8081, 1.83310, -1.000213),
    "four_factor": FOUR_FACTOR_THETA,
    "four_factor_design": (7.8315, 1.82580, -1.000200, 0.0, -74.672),
    "four_factor_design_distinct": (7.8352, 1.90070, -1.000200, -0.039971, -71.747),
}
PATTERNS = {
    "A": [(5e-6, 2e-6), (6.91e-6, 2e-6), (10e-6, 0.2e-6)],
    "B": [(5e-6, 1.45e-6), (5e-6, 2e-6), (10e-6, 0.2e-6)],
}
FOUR_FACTOR_POINTS = [
    (5e-6, 2e-6, 0.0, 0.0),
    (5e-6, 2e-6, 0.0, 45.0),
    (5e-6, 2e-6, 2.9e-3, 45.0),
    (6.9e-6, 2e-6, 0.0, 45.0),
    (10e-6, 0.2e-6, 2.9e-3, 0.0),
]


@dataclass(frozen=True)
class Study:
    """Where the results of a study lie, and its configuration."""

    root: Path
    config: Path

    @property
    def results(self) -> Results:
        return Results.of(self.root, self.config)

    def changed(self, folder: Path, file: str, edit: Callable[[pd.DataFrame], pd.DataFrame]):
        """The results in another folder, with one table changed."""
        shutil.copytree(self.root, folder, dirs_exist_ok=True)
        edit(pd.read_csv(folder / file)).to_csv(folder / file, index=False)
        return Results.of(folder, self.config)


@pytest.fixture(scope="session")
def study(tmp_path_factory, repository, script):
    """A study with every result that figures, tables and claims are made from."""
    root = tmp_path_factory.mktemp("study")
    config = repository / "config" / "paper.yaml"
    _write_simulations(root, repository / "tests" / "reference")
    _write_fits(root)
    _write_designs(root)
    _write_validations(root, config, script)
    _write_extras(root, config)
    scenes = root / "simulations/extrapolation/scenes.csv"
    script("cross_section", config, input={"scenes": scenes}, output=scenes.parent / "film.csv")
    return Study(root, config)


def _write_forces(root: Path, plan: str, forces: pd.DataFrame) -> None:
    solved = Solution(status="ok", method="periodic", nx=24, ny=24, nt=16, krylov_iterations=33)
    force_n = forces["force_n"]
    observed = {name: getattr(solved, name) for name in SOLUTION_COLUMNS}
    observed |= {"force_n": force_n, "force_error_n": 2.4e-7 * force_n}
    table = forces.assign(**observed)
    folder = root / "simulations" / plan
    write_table(table[list(FORCE_COLUMNS)], folder / "forces.csv")
    write_table(table[list(SCENE_COLUMNS)], folder / "scenes.csv")
    write_table(table[["point_id"]].assign(solve_seconds=0.0012), folder / "timings.csv")


def _write_simulations(root: Path, reference: Path) -> None:
    screen = pd.read_csv(reference / "screen_forces.csv", dtype={"point_id": str})
    plan = pd.read_csv(reference / "four_factor_forces.csv", dtype={"point_id": str})
    extrapolation = pd.DataFrame(
        {
            "point_id": ["operating_point", "screen", "two_factor_design"],
            "h0_m": 5e-6,
            "hv_m": [2.2e-6, 2.228e-6, 2.226e-6],
            "phi_r_m": 0.0,
            "phi_deg": 0.0,
            "force_n": [0.962042, 0.9889, 0.9870],
        }
    )
    for name, forces in {
        "screen": screen,
        "error_map": screen,
        "two_factor_design": plan.head(5),
        "four_factor": plan,
        "four_factor_control": plan.tail(20),
        "extrapolation": extrapolation,
    }.items():
        _write_forces(root, name, forces)
    write_json({"device": "Test platform: test device"}, root / "simulations" / "device.json")


def _write_fits(root: Path) -> None:
    for name, theta in THETA.items():
        model: ExpressionModel = TWO_FACTOR if len(theta) == 3 else FOUR_FACTOR
        plan = name if len(theta) == 3 else "four_factor"
        forces = pd.read_csv(root / "simulations" / plan / "forces.csv")
        factors = Factors.of(**{column: forces[column] for column in FACTOR_COLUMNS})
        squares = float(np.sum((model.evaluate(theta, factors) - forces["force_n"]) ** 2))
        fit = {
            "model": model.name,
            "theta": list(theta),
            "points": 5 if "design" in name else len(forces),
            "sum_of_squares": squares,
            "global_error": float(np.sqrt(squares) / np.linalg.norm(forces["force_n"])),
            "ranges": {"h0_m": [5e-6, 10e-6], "hv_m": [0.2e-6, 2e-6]},
            "validation": measured_interval(
                factors,
                model_n=model.evaluate(theta, factors),
                force_n=forces["force_n"],
                force_error_n=forces["force_error_n"],
                scale=(0.0, 1.0),
                ranges={
                    name: (float(forces[name].min()), float(forces[name].max()))
                    for name in FACTOR_COLUMNS
                },
            ).model_dump(mode="json"),
        }
        write_json(fit, root / "fits" / f"{name}.json")
    runs = pd.DataFrame({"bound": [1e6, 1e6, 100.0, 100.0], "sum_of_squares": 8.62e-5})
    write_table(runs, root / "fits" / "screen_runs.csv")


def _write_designs(root: Path) -> None:
    folder = root / "designs"
    searches, scalings = [], {}
    for scaling, counts in {"metre": {"A": 20}, "unit": {"A": 15, "B": 5}}.items():
        names = [name for name, count in counts.items() for _ in range(count)]
        for search, name in enumerate(names, start=1):
            searches += [(scaling, search, name, *point, 1e5) for point in PATTERNS[name]]
        scalings[scaling] = [
            {
                "pattern": name,
                "count": count,
                "objective": 1e5,
                "objective_excess": 0.0 if name == "A" else 0.6,
                "d_efficiency": 1.0,
                "points": [{"h0_m": h0_m, "hv_m": hv_m} for h0_m, hv_m in PATTERNS[name]],
            }
            for name, count in counts.items()
        ]
    columns = ["scaling", "search", "pattern", "h0_m", "hv_m", "objective"]
    write_table(pd.DataFrame(searches, columns=columns), folder / "two_factor_searches.csv")
    write_json(
        {"scaling": "unit", "searches": 20, "scalings": scalings}, folder / "two_factor.json"
    )
    two_factor = {
        "A and B": [PATTERNS["A"][0], PATTERNS["A"][2]],
        "A": [PATTERNS["A"][1]],
        "B": [PATTERNS["B"][0]],
        "augmentation": [(5e-6, 0.2e-6)],
    }
    points = [(*point, 0.0, 0.0, origin) for origin, of in two_factor.items() for point in of]
    _write_design(folder / "two_factor.csv", points)
    four_factor = [(*point, "paper") for point in FOUR_FACTOR_POINTS]
    _write_design(folder / "four_factor.csv", four_factor)
    _write_design(folder / "four_factor_distinct.csv", four_factor)


def _write_extras(root: Path, config: Path) -> None:
    recommended = {
        "space": ["two_factor", "four_factor", "four_factor"],
        "model": ["limit_1", "limit_2", "limit_2"],
        "validation_points": 30,
        "validation_error": 0.003,
        "simulations": 60,
        "worst_error": 0.02,
        "h0_m": 5e-6,
        "x_m": [0.0, 0.0, 2e-3],
        "y_m": 0.0,
        "force_n": 0.3,
        "hv_m": [1.4e-6, 1.4e-6, float("nan")],
        "hv_error_95_m": [1e-8, 1e-8, float("nan")],
        "error_95_percent": [1.0, 2.0, float("nan")],
        "note": ["", "", "no amplitude gives it"],
    }
    write_table(pd.DataFrame(recommended), root / "models" / "recommended.csv")
    """A film over a period, what a force rests on, and what equation it is of."""
    for plan in ("screen", "four_factor", "extrapolation"):
        folder = root / "simulations" / plan
        budget = [f"{folder}/scenes.csv", f"--config={config}", f"--output={folder}/budget.csv"]
        assert cli.main(["budget", *budget]) == 0
    screen = root / "simulations/screen"
    out = [f"--output={screen}/response.csv", f"--gains={screen}/gains.csv"]
    assert cli.main(["response", f"{screen}/scenes.csv", f"--config={config}", *out]) == 0
    out = [f"--like={screen}/forces.csv", f"--output={screen}/levitation.csv", "--tolerance=1e-3"]
    assert cli.main(["levitate", f"--config={config}", *out]) == 0
    table, curves = uncertainty.compare(
        load_config(config),
        force=lambda scene: 4.97 * scene.epsilon**2 * scene.gas.ambient_pressure_pa / 101_325,
    )
    write_table(table, root / "tables/uncertainty.csv")
    write_table(curves, root / "tables/uncertainty_curves.csv")


def _write_design(path: Path, points: list[tuple[Any, ...]]) -> None:
    table = pd.DataFrame(
        [(str(number), *point) for number, point in enumerate(points, start=1)],
        columns=list(DESIGN_COLUMNS),
    )
    write_table(table, path)


def _write_validations(root: Path, config: Path, script: Callable[..., None]) -> None:
    for fit, plans in (
        ("screen", ["screen"]),
        ("two_factor_design", ["screen", "error_map"]),
        ("four_factor_design", ["four_factor"]),
        ("four_factor_design_distinct", ["four_factor", "four_factor_control"]),
    ):
        stems = [f"{root}/validation/{fit}_on_{plan}" for plan in plans]
        forces = [f"{root}/simulations/{plan}/forces.csv" for plan in plans]
        output = {"errors": [f"{stem}.csv" for stem in stems]}
        output["summary"] = [f"{stem}.json" for stem in stems]
        given = {"fit": f"{root}/fits/{fit}.json", "forces": forces}
        script("validate", config, input=given, output=output)
