"""Put the parts of a simulated plan together, and see that every point has its force.

  squeezefilm gather SCENES.csv CHUNK.csv … --output FORCES.csv

The rows come out in the order of the plan. Ends with status 1, names the points and writes
nothing when a point has no force; with --keep-failed such rows stay, with their reason as `status`.
"""

import argparse
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path

import numpy as np
import pandas as pd

from squeezefilm.io.errors import InputError, RunError
from squeezefilm.io.positions import as_in
from squeezefilm.io.tables import (
    FACTOR_COLUMNS,
    TIMING_COLUMNS,
    read_forces,
    read_scenes,
    read_timings,
    table_writer,
)

# With what was asked for beside the forces.
read_whole = partial(read_forces, whole=True)
NAMED = 100  # failed points, at most, in a message


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("scenes", metavar="SCENES.csv", help="the plan")
    parser.add_argument("chunks", nargs="+", metavar="CHUNK.csv", help="forces of its parts")
    parser.add_argument("--output", required=True, metavar="FORCES.csv", help="table to write")
    parser.add_argument(
        "--timings", nargs="*", default=[], metavar="T.csv", help="parts' run times"
    )
    parser.add_argument("--timings-output", metavar="TIMINGS.csv", help="table of them to write")
    parser.add_argument("--keep-failed", action="store_true", help="keep points without a force")


def run(options: argparse.Namespace) -> None:
    if bool(options.timings) != (options.timings_output is not None):
        raise InputError("give --timings and --timings-output together")
    scenes = read_scenes(options.scenes)
    _gather_forces(scenes, options)
    if options.timings:
        parts = in_order(scenes, options.timings, read=read_timings, of=options.scenes)
        with table_writer(options.timings_output) as write:
            for part in parts:
                write(part[list(TIMING_COLUMNS)])


def _gather_forces(scenes: pd.DataFrame, options: argparse.Namespace) -> None:
    failures: list[str] = []
    first = 0
    with table_writer(options.output) as write:
        for part in in_order(scenes, options.chunks, read=read_whole, of=options.scenes):
            factors = as_in(FACTOR_COLUMNS, scenes)
            if as_in(FACTOR_COLUMNS, part) != factors:
                raise InputError(
                    f"{options.scenes}: positions are {factors[2]}, {factors[3]}, and in the parts "
                    "they are not; simulate them anew"
                )
            planned = scenes[factors].iloc[first : first + len(part)]
            moved = (part[factors].to_numpy() != planned.to_numpy()).any(axis=1)
            if moved.any():
                raise InputError(
                    f"{options.scenes}: point {part['point_id'][moved].iloc[0]} was simulated with "
                    "other factors than the plan has; simulate it anew"
                )
            first += len(part)
            failed = part[part["status"] != "ok"]
            failures += [f"point {row.point_id}: {row.status}" for row in failed.itertuples()]
            write(part)
        if failures and not options.keep_failed:
            named = "; ".join(failures[:NAMED])
            more = f" and {len(failures) - NAMED} more" if len(failures) > NAMED else ""
            parts = ", ".join(str(Path(path)) for path in options.chunks[:NAMED])
            raise RunError(
                f"no force for {named}{more} (of {options.scenes}; their rows are in {parts})"
            )


def in_order(
    scenes: pd.DataFrame, parts: Sequence[str], *, read: Callable[[str], pd.DataFrame], of: str
) -> Iterator[pd.DataFrame]:
    """The parts' tables in the order of the plan, their rows too.

    Each is read twice, so that no more than one is held at a time.
    Raises InputError for a point that is missing, twice there, or not of the plan, and for parts
    that are not each a run of the plan's rows.
    """
    plan = pd.Index(scenes["point_id"])
    rows = {}
    seen = np.zeros(len(plan), dtype=bool)
    for part in parts:
        ids = read(part)["point_id"]
        rows[part] = plan.get_indexer(ids)
        strange = ids[rows[part] < 0]
        if len(strange):
            raise InputError(f"{of}: point {strange.iloc[0]} of the parts is not in the plan")
        twice = ids[seen[rows[part]]]
        if len(twice):
            raise InputError(f"{of}: point {twice.iloc[0]} is in two parts")
        seen[rows[part]] = True
    if not seen.all():
        raise InputError(f"{of}: point {plan[~seen][0]} is in no part")
    first = 0
    for part in sorted(rows, key=lambda part: rows[part].min()):
        if rows[part].max() != first + len(rows[part]) - 1:
            raise InputError(f"{of}: {part} is not a run of the plan's rows")
        first += len(rows[part])
        yield read(part).iloc[np.argsort(rows[part])]
