"""Write a plan: the scenes to simulate, as a table that `squeezefilm simulate` reads.

  squeezefilm plan screen --config config/paper.yaml --output scenes.csv
  squeezefilm plan four_factor --config config/paper.yaml --design DESIGN.csv --output scenes.csv

Plans from the configuration alone: screen, error_map, four_factor_control, the validation samples
validation_two_factor and validation_four_factor (independent points, uniform over the declared
space), sweep (write it to a .parquet file when it is large). Plans from a design:
four_factor (each of its points at each finger position), and two_factor_design,
four_factor_design, four_factor_design_distinct (its points as they are).
"""

import argparse
from collections.abc import Iterable

import pandas as pd

from squeezefilm.config.loading import Config, load_config
from squeezefilm.io.errors import InputError
from squeezefilm.io.positions import CARTESIAN, POLAR, as_in
from squeezefilm.io.tables import SCENE_COLUMNS, read_design, table_writer
from squeezefilm.studies.plans import (
    VALIDATION_SAMPLES,
    box_of,
    centred_grid,
    finger_positions,
    four_factor_plan,
    level_values,
    random_plan,
    sweep_pieces,
)
from squeezefilm.studies.space import Space
from squeezefilm.studies.study import surface_of

FORMS = {"polar": POLAR, "cartesian": CARTESIAN}
OF_A_DESIGN = (
    "four_factor",
    "two_factor_design",
    "four_factor_design",
    "four_factor_design_distinct",
)
OF_THE_STUDY = ("screen", "error_map", "four_factor_control", "sweep", *VALIDATION_SAMPLES)
PLANS = (*OF_THE_STUDY, *OF_A_DESIGN)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("kind", choices=PLANS, metavar="KIND", help=", ".join(PLANS))
    parser.add_argument("--config", required=True, metavar="CONFIG.yaml", help="the study")
    parser.add_argument("--design", metavar="DESIGN.csv", help="the design a plan is made from")
    parser.add_argument(
        "--position",
        choices=FORMS,
        default="polar",
        help="form of positions, of screen and error_map: polar, or cartesian on a rectangle",
    )
    parser.add_argument("--output", required=True, metavar="SCENES.csv", help="table to write")


def run(options: argparse.Namespace) -> None:
    config = load_config(options.config)
    if (options.design is not None) != (options.kind in OF_A_DESIGN):
        takes = "needs a --design" if options.kind in OF_A_DESIGN else "takes no --design"
        raise InputError(f"the plan {options.kind} {takes}")
    design = None if options.design is None else read_design(options.design)
    with table_writer(options.output) as write:
        form = FORMS[options.position]
        for piece in make_plan(options.kind, config, design=design, position=form):
            write(piece)


def make_plan(
    kind: str, config: Config, *, design: pd.DataFrame | None, position: tuple[str, str] = POLAR
) -> Iterable[pd.DataFrame]:
    """The scenes of one kind of plan; those of a sweep in pieces."""
    if kind == "sweep":
        points, first, seed = (config[kind][key] for key in ("points", "first", "seed"))
        return sweep_pieces(points=points, first=first, seed=seed, **box_of(config).ranges)
    return [_small_plan(kind, config, design=design, position=position)]


def _small_plan(
    kind: str, config: Config, *, design: pd.DataFrame | None, position: tuple[str, str]
) -> pd.DataFrame:
    if kind in ("screen", "error_map"):
        levels = config[kind]
        return centred_grid(
            h0_m=level_values(levels["h0_m"]),
            hv_m=level_values(levels["hv_m"]),
            position=position,
        )
    if kind == "four_factor_control":
        points, seed = config[kind]["points"], config[kind]["seed"]
        return random_plan(points=points, seed=seed, **box_of(config).ranges)
    if kind in VALIDATION_SAMPLES:
        points, seed = config["validation"]["points"], config["validation"]["seed"]
        space = Space.of(config, centred=kind == "validation_two_factor")
        return space.table(space.independent_sample(points, seed=seed))
    assert design is not None
    if kind == "four_factor":
        return four_factor_plan(
            positions=finger_positions(config),
            h0_m=design["h0_m"].to_numpy(),
            hv_m=design["hv_m"].to_numpy(),
            position=surface_of(config).position,
        )
    return design[as_in(SCENE_COLUMNS, design)]
