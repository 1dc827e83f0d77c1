"""Put the parts of a simulated plan together, and see that every point has its force.

  squeezefilm gather SCENES.csv CHUNK.csv … --output FORCES.csv

The rows come out in the order of the plan. Ends with status 1, names the points and writes
nothing when a point has no force.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

import pandas as pd

from squeezefilm.errors import InputError, RunError
from squeezefilm.tables import (
    FACTOR_COLUMNS,
    FORCE_COLUMNS,
    TIMING_COLUMNS,
    read_forces,
    read_scenes,
    read_timings,
    write_table,
)

SECTIONS: tuple[str, ...] = ()


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("scenes", metavar="SCENES.csv", help="the plan")
    parser.add_argument("chunks", nargs="+", metavar="CHUNK.csv", help="forces of its parts")
    parser.add_argument("--output", required=True, metavar="FORCES.csv", help="table to write")
    parser.add_argument(
        "--timings", nargs="*", default=[], metavar="T.csv", help="parts' run times"
    )
    parser.add_argument("--timings-output", metavar="TIMINGS.csv", help="table of them to write")


def run(options: argparse.Namespace) -> None:
    if bool(options.timings) != (options.timings_output is not None):
        raise InputError("give --timings and --timings-output together")
    scenes = read_scenes(options.scenes)
    forces = in_order(scenes, [read_forces(path) for path in options.chunks], of=options.scenes)
    moved = (forces[list(FACTOR_COLUMNS)] != scenes[list(FACTOR_COLUMNS)]).any(axis=1)
    if moved.any():
        raise InputError(
            f"{options.scenes}: point {forces['point_id'][moved].iloc[0]} was simulated with "
            "other factors than the plan has; simulate it anew"
        )
    failed = forces[forces["status"] != "ok"]
    if len(failed):
        names = "; ".join(f"point {row.point_id}: {row.status}" for row in failed.itertuples())
        parts = ", ".join(str(Path(path)) for path in options.chunks)
        raise RunError(f"no force for {names} (of {options.scenes}; their rows are in {parts})")
    if options.timings:
        timings = in_order(
            scenes, [read_timings(path) for path in options.timings], of=options.scenes
        )
        write_table(timings[list(TIMING_COLUMNS)], options.timings_output)
    write_table(forces[list(FORCE_COLUMNS)], options.output)


def in_order(scenes: pd.DataFrame, parts: Sequence[pd.DataFrame], *, of: str) -> pd.DataFrame:
    """The parts' rows in the order of the plan.

    Raises:
        InputError: for a point that is missing, twice there, or not of the plan.
    """
    rows = pd.concat(parts, ignore_index=True)
    twice = rows["point_id"][rows["point_id"].duplicated()]
    if len(twice):
        raise InputError(f"{of}: point {twice.iloc[0]} is in two parts")
    missing = scenes["point_id"][~scenes["point_id"].isin(rows["point_id"])]
    if len(missing):
        raise InputError(f"{of}: point {missing.iloc[0]} is in no part")
    strange = rows["point_id"][~rows["point_id"].isin(scenes["point_id"])]
    if len(strange):
        raise InputError(f"{of}: point {strange.iloc[0]} of the parts is not in the plan")
    return rows.set_index("point_id").loc[scenes["point_id"]].reset_index()
