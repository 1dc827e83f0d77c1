"""Write a table of what the films of a plan do besides giving a force."""

import numpy as np
import pandas as pd

from scripts.job import begin_with_study
from squeezefilm.api.film import Film
from squeezefilm.api.forces import budget_table, scan_error_of
from squeezefilm.dynamics.levitation import levitations, loads_like
from squeezefilm.dynamics.response import all_gains, responses
from squeezefilm.film.validity import GAPS_M
from squeezefilm.studies.solver_settings import device_of, solver_settings
from squeezefilm.studies.study import scenes_in
from squeezefilm.tables import read_scenes, write_table

FREQUENCY_HZ = np.array([3, 10, 30, 60, 100, 150, 200, 300, 500, 700, 1e3, 2e3, 4e3])


def levitation() -> pd.DataFrame:
    """The gaps that carry loads like the plan's forces."""
    film = Film(config)
    loads_n, amplitudes_m = loads_like(path)
    scenes = film.scenes(pd.DataFrame({"hv_m": amplitudes_m, "h0_m": GAPS_M[1]}))
    how = settings.how(film.device) | {"model_tolerance": settings.model_tolerance}
    scan_error_n = scan_error_of(film.scan, device=film.device)
    return levitations(scenes, loads_n, how=how, scan_error_n=scan_error_n)


def response() -> pd.DataFrame:
    """How the plan's forces follow a changing amplitude."""
    points, tolerance = read_scenes(path), settings.tolerance
    scenes = scenes_in(points, config)
    return responses(points, scenes, tolerance=tolerance, device=device_of(config))


def gains() -> pd.DataFrame:
    """How much of a modulation of the amplitude the plan's forces follow."""
    points = read_scenes(path)
    return all_gains(points, scenes_in(points, config), FREQUENCY_HZ)


def budget() -> pd.DataFrame:
    """What the film equation leaves out of the plan's forces."""
    return budget_table(read_scenes(path), config)


snakemake, config = begin_with_study()
path, settings = snakemake.input.points, solver_settings(config, outputs=())
tables = {"budget": budget, "gains": gains, "levitation": levitation, "response": response}
write_table(tables[snakemake.wildcards.table](), snakemake.output[0])
