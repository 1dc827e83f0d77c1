"""What the film equation leaves out of each force: inertia, heat, slip, rim, sliding, in per cent.

  squeezefilm budget SCENES.csv --config CONFIG.yaml --output BUDGET.csv

A row for each scene. `inertia_percent`, `heat_percent`, `slip_percent`, `rim_percent` (for the
entrance coefficient C = 1; `rim_most_percent` for 1.54), `bearing_percent` and `passing_percent`
(the profile that moves past a sliding finger) are changes of the mean force at first order,
`…_missed_percent` the size of what higher orders add. `sum_…` adds all of them up, `left_out_…`
those that the force does not have (`in_force` names the others): from `…_least` to `…_most`, with C
from 1 to 1.54 and all that higher orders and coarse grids may make. `above_range` names effects too
large for a first order, `basis` what pad the numbers are of, `status` why there are none.
`depth_averaged_percent` is the estimated error of inertia and heat that a force has, as averages
over the gap; `validity` is `ok`, or the limits of validity that a scene exceeds.
"""

from __future__ import annotations

import argparse

import pandas as pd

from squeezefilm.config.loading import Config, load_config
from squeezefilm.film.validity import validity
from squeezefilm.quantities.model_error import budget_row, error_budgets
from squeezefilm.reynolds.device import choose_device
from squeezefilm.studies.solver_settings import solver_settings
from squeezefilm.studies.study import scenes_in
from squeezefilm.tables import read_scenes, write_table


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("scenes", metavar="SCENES.csv", help="table of scenes")
    parser.add_argument("--config", required=True, metavar="CONFIG.yaml", help="the study")
    parser.add_argument("--output", required=True, metavar="BUDGET.csv", help="table to write")
    parser.add_argument(
        "--device", help="instead of SQUEEZEFILM_DEVICE and the config's solver.device"
    )


def run(options: argparse.Namespace) -> None:
    config = load_config(options.config)
    table = budget_table(read_scenes(options.scenes), config, device_name=options.device)
    write_table(table, options.output)


def budget_table(
    table: pd.DataFrame, config: Config, *, device_name: str | None = None
) -> pd.DataFrame:
    """A table of scenes with the budget of each."""
    device = choose_device(config["solver"]["device"], option=device_name)
    scenes = solver_settings(config, outputs=()).resolved(scenes_in(table, config), device)
    rows = [
        budget_row(budget) | {"validity": validity(scene)}
        for scene, budget in zip(scenes, error_budgets(scenes, device=device), strict=True)
    ]
    return pd.concat([table, pd.DataFrame(rows)], axis=1)
