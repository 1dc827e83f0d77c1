"""How force errors move the fit and the design, and how often the fit's search succeeds.

  squeezefilm conditioning SCREEN.csv DESIGN.csv FIT.json SEARCHES.csv --config CONFIG.yaml \\
      --output TABLE.csv

The inputs are the forces of the screen and of the five-point design, the fit on the screen, and
the searches for D-optimal triplets.
"""

import argparse
from pathlib import Path

import numpy as np

from numerics.conditioning import conditioning
from squeezefilm.io.errors import InputError
from squeezefilm.io.sources import read_columns
from squeezefilm.io.tables import read_ok_forces, write_table
from squeezefilm.models.experiments import factors_of
from squeezefilm.models.fitted import read_fit
from squeezefilm.models.force_model import Factors
from squeezefilm.studies.config import load_config
from squeezefilm.studies.plans import box_of

NOTE = (
    "Independent relative errors of the forces, drawn from a normal distribution; root mean square "
    "moves, of the design the median of its largest move in factors scaled to 1."
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("screen", metavar="SCREEN.csv", help="forces of the screen")
    parser.add_argument("design", metavar="DESIGN.csv", help="forces of the five-point design")
    parser.add_argument("fit", metavar="FIT.json", help="the fit on the screen")
    parser.add_argument("searches", metavar="SEARCHES.csv", help="searches for triplets")
    parser.add_argument("--config", required=True, metavar="CONFIG.yaml", help="the study")
    parser.add_argument("--output", required=True, metavar="TABLE.csv")


def run(options: argparse.Namespace) -> None:
    config = load_config(options.config)
    screen, screen_force = _forces(options.screen)
    design, design_force = _forces(options.design)
    table = conditioning(
        screen=screen,
        screen_force_n=screen_force,
        design=design,
        design_force_n=design_force,
        theta=np.array(read_fit(options.fit).theta),
        triplets=_best_triplets(options.searches, scaling=config["design"]["scaling"]),
        box=box_of(config, centred=True),
        scaling=config["design"]["scaling"],
        bounds=config["fit"]["bounds"],
        seeds=config["numerics"]["seeds"],
    )
    write_table(table.assign(note=NOTE), options.output)


def _forces(path: Path | str) -> tuple[Factors, np.ndarray]:
    table = read_ok_forces(path)
    return factors_of(table), table["force_n"].to_numpy(dtype=float)


def _best_triplets(path: Path | str, *, scaling: str) -> list[np.ndarray]:
    """The best design of each pattern of a scaling, shape (3, 2), in metres."""
    table = read_columns(
        path, columns=("scaling", "search", "pattern", "h0_m", "hv_m", "objective")
    )
    table = table[table["scaling"] == scaling]
    if not len(table):
        raise InputError(f"{path}: there are no searches with the scaling {scaling!r}")
    triplets = []
    for _, pattern in table.groupby("pattern"):
        best = pattern["search"].to_numpy()[np.argmin(pattern["objective"])]
        triplets.append(pattern.loc[pattern["search"] == best, ["h0_m", "hv_m"]].to_numpy(float))
    return triplets
