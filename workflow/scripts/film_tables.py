"""Write tables of what the films of a plan do besides giving a force."""

from pathlib import Path

import numpy as np
import pandas as pd

from squeezefilm.api.dynamics import levitations
from squeezefilm.api.film import Film
from squeezefilm.api.forces import budget_table
from squeezefilm.dynamics.levitation_tables import (
    Load,
    levitation_table,
    loads_and_amplitudes_of_table,
)
from squeezefilm.dynamics.response import gain_table, response_table
from squeezefilm.film.scene import Scenes
from squeezefilm.film.validity import GAP_RANGE_M
from squeezefilm.studies.solver_settings import SolverSettings
from squeezefilm.table_writer import write_table
from squeezefilm.tables import read_scenes
from squeezefilm_workflow.job import Job, Study, run_script

MODULATION_FREQUENCIES_HZ = np.geomspace(3, 4000, 60).round(1)


def levitation_table_of_forces(study: Film, forces_file: str) -> pd.DataFrame:
    """The gaps that carry loads like the plan's forces."""
    loads_n, amplitudes_m = loads_and_amplitudes_of_table(forces_file)
    moved = study.scenes(pd.DataFrame({"hv_m": amplitudes_m, "h0_m": GAP_RANGE_M[1]}))
    return levitation_table(levitations(study, moved, [Load(load_n) for load_n in loads_n]))


def cross_section_table(settings: SolverSettings, scenes: Scenes) -> pd.DataFrame:
    """Gap and pressure along the middle of the pad over a period."""
    from squeezefilm_workflow.reporting.cross_section import cross_section

    resolved = settings.with_auto_terms_decided(scenes)
    films = [cross_section(scene, device=settings.device) for scene in resolved]
    return pd.concat(films, ignore_index=True)


def at_largest_amplitude_ratio(points: pd.DataFrame) -> pd.DataFrame:
    """The points of the largest hv/h0, where the position matters most."""
    ratio = points["hv_m"] / points["h0_m"]
    return points[ratio >= ratio.max() * (1 - 1e-9)].reset_index(drop=True)


def main(snakemake: Job, config: Study) -> None:
    study = Film(config, {"outputs": ()})
    settings = study.solver()
    device, points = settings.device, read_scenes(snakemake.input.scenes)
    if snakemake.params.largest_amplitude_ratio:
        points = at_largest_amplitude_ratio(points)
    scenes = study.scenes(points)
    tables = {
        "error_budget": lambda: budget_table(points, study),
        "film": lambda: cross_section_table(settings, scenes),
        "gains": lambda: gain_table(points, scenes, MODULATION_FREQUENCIES_HZ),
        "levitation": lambda: levitation_table_of_forces(study, snakemake.input.forces),
        "response": lambda: response_table(
            points, scenes, tolerance=settings.tolerance, device=device
        ),
    }
    for path in snakemake.output:
        write_table(tables[Path(path).stem](), path)


if __name__ == "__main__":
    run_script(main, globals()["snakemake"])
