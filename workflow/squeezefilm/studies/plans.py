"""Plans of simulations: the screen, the four-factor plan, samples and sweeps; their jobs.

Jobs are counted by what their scenes should cost. Only the configuration is asked: their number is
known before any plan is made.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Mapping, Sequence
from itertools import product
from math import ceil
from pathlib import Path
from typing import Any

import numpy as np

from squeezefilm.config.study import Study
from squeezefilm.errors import InputError, prefix_errors
from squeezefilm.film.positions import columns_in_table_form, find_position_columns
from squeezefilm.lazy import pd
from squeezefilm.models.fit_file import FittedModel, amplitude_for_force, read_fit
from squeezefilm.reynolds.dry_run import dry_run
from squeezefilm.studies.space import (
    CENTRED_FACTOR_COLUMNS,
    pad_positions,
    plan_table,
    round_to_twelve_digits,
    sobol_sampler,
    space_of_study,
    table_of_points,
)
from squeezefilm.studies.study import scenes_of_table
from squeezefilm.table_writer import table_writer
from squeezefilm.tables import FACTOR_COLUMNS, SCENE_COLUMNS, read_design

VALIDATION_SAMPLE_PLANS = ("validation_two_factor", "validation_four_factor")
"""The plans of independent points, uniform over the declared space: pad centred, anywhere."""
LEVEL_GRID_SECTIONS = ("screen", "error_map")
"""The plans of every gap with every amplitude, pad centred: of Fig. 7, and of control points."""
# Points of a sweep that are held at a time, and that a Parquet file keeps together.
SWEEP_POINTS_PER_PIECE = 2**15

# One thread of an AMD EPYC (Zen 5, registers of 64 bytes), 60 and 65 scenes of the paper at 1e-3 to
# 1e-8: processor time, fitted.
MFLOP_PER_SECOND = 42_000.0
# Besides the operations: preparing and collecting, where each scene has a place of its own; where
# scenes share them, as in most small plans, a fifth of it.
OVERHEAD_SECONDS_PER_SCENE = 3e-4
# Outputs ask for states on two grids more, closely solved, and for Python's time.
OUTPUTS_TIME_FACTOR, OUTPUTS_SECONDS_PER_SCENE = 4, 1e-2
COST_SAMPLE_SCENE_COUNT = 32
MAX_CHUNKS_PER_PLAN = 20_000
# Of a job, which holds its scenes and whose forces are merged at a time: 1 kB each.
MAX_SCENES_PER_CHUNK = 500_000


def level_grid(name: str, config: Study) -> pd.DataFrame:
    """Every gap with every amplitude of a section, of LEVEL_GRID_SECTIONS."""
    section = config.screen if name == "screen" else config.error_map
    levels = section.h0_m, section.hv_m
    values = [
        round_to_twelve_digits(np.linspace(each.start, each.stop, each.levels)) for each in levels
    ]
    return pd.DataFrame(product(*values), columns=CENTRED_FACTOR_COLUMNS)


def random_plan(*, points: int, seed: int, **ranges: tuple[float, float]) -> pd.DataFrame:
    """Points drawn uniformly from ranges of the factors, as control points.

    Equal seeds give equal points.
    """
    return _scale_to_ranges(ranges, np.random.default_rng(seed).random((points, 4)))


def sobol_sweep_pieces(
    *, points: int, first: int, seed: int, **ranges: tuple[float, float]
) -> Iterator[pd.DataFrame]:
    """Points of a Sobol' sequence, which fills the ranges of the four factors evenly; in pieces.

    Scrambled by the seed. The sequence is one: sweeps from ``first`` 0 and 1000, of 1000 points
    each, are the sweep of 2000 points in two parts. Points are numbered by their place in it.
    """
    sequence = sobol_sampler(4, seed=seed)
    if first:
        sequence.fast_forward(first)
    for begin in range(first, first + points, SWEEP_POINTS_PER_PIECE):
        end = min(begin + SWEEP_POINTS_PER_PIECE, first + points)
        with warnings.catch_warnings():
            # Of numbers of points that are no power of two: they fill the box less evenly.
            warnings.filterwarnings("ignore", message="The balance", category=UserWarning)
            table = _scale_to_ranges(ranges, sequence.random(end - begin))
        yield table.assign(point_id=np.arange(begin + 1, end + 1).astype(str))


def _scale_to_ranges(ranges: dict[str, tuple[float, float]], unit: np.ndarray) -> pd.DataFrame:
    """The plan of points in [0, 1] over ranges, shape (points, 4)."""
    names = columns_in_table_form(FACTOR_COLUMNS, ranges)
    lower, upper = np.transpose([ranges[name] for name in names])
    return plan_table(pd.DataFrame(lower + (upper - lower) * unit, columns=names))


def write_scenes(
    name: str, config: Study, *, sources: Sequence[Path | str] = (), output: Path | str
) -> None:
    """Write the table of a plan; a sweep is made and written in pieces.

    Args:
        sources: the design that a plan is made from, and of ``extrapolation`` the fits.
    """
    with table_writer(output) as write:
        if name == "sweep":
            sweep: Any = config.sweep.model_dump() | space_of_study(config).limits
            for piece in sobol_sweep_pieces(**sweep):
                write(piece)
        elif name == "extrapolation":
            write(
                _extrapolation_scenes(config, {Path(path).stem: read_fit(path) for path in sources})
            )
        else:
            design = read_design(sources[0]) if sources else None
            write(plan_scenes_table(name, config, design=design))


def plan_scenes_table(
    name: str, config: Study, *, design: pd.DataFrame | None = None
) -> pd.DataFrame:
    """The scenes of a plan that the study or a design gives."""
    position = config.actuator.surface.position_columns
    if name in LEVEL_GRID_SECTIONS:
        return plan_table(level_grid(name, config), position=position)
    if name == "four_factor_control":
        control = config.four_factor_control
        return random_plan(
            points=control.points, seed=control.seed, **space_of_study(config).limits
        )
    if name in VALIDATION_SAMPLE_PLANS:
        sample = config.validation
        space = space_of_study(config, centred=name == "validation_two_factor")
        points = space.independent_sample(sample.points, seed=sample.seed)
        return table_of_points(points, space)
    assert design is not None, f"the plan {name} is made from a design"
    if name == "four_factor":
        positions = pd.DataFrame(pad_positions(config), columns=position)
        return plan_table(positions.merge(design[[*CENTRED_FACTOR_COLUMNS]], how="cross"))
    return design[columns_in_table_form(SCENE_COLUMNS, design)]


def _extrapolation_scenes(config: Study, fits: Mapping[str, FittedModel]) -> pd.DataFrame:
    """The operating point of the section ``extrapolation``, and one scene of each fit.

    Each fit adds the scene at which it expects the target force at that gap, named as the fit is.
    """
    point = config.extrapolation
    amplitudes = {"operating_point": point.hv_m}
    for name, fit in fits.items():
        with prefix_errors(name):
            amplitudes[name] = amplitude_for_force(
                fit.evaluate, force_n=point.force_n, h0_m=point.h0_m
            )
    factors = pd.DataFrame({"h0_m": point.h0_m, "hv_m": list(amplitudes.values())})
    return plan_table(factors, position=fit.position_columns).assign(point_id=list(amplitudes))


def plan_point_counts(config: Study) -> dict[str, int]:
    """The number of points of each plan that is simulated in chunks."""
    positions = config.positions.points or len(pad_positions(config))
    return {
        **{name: len(level_grid(name, config)) for name in LEVEL_GRID_SECTIONS},
        "four_factor": config.design.points * positions,
        "four_factor_control": config.four_factor_control.points,
        "sweep": config.sweep.points,
        **dict.fromkeys(VALIDATION_SAMPLE_PLANS, config.validation.points),
    }


def chunk_counts(config: Study) -> dict[str, int]:
    """The number of jobs for each plan, of at most about ``simulation.seconds_per_job`` each.

    Raises InputError when a plan would need more jobs than a workflow can handle.
    """
    target = config.simulation.seconds_per_job
    counts = {}
    for name, points in plan_point_counts(config).items():
        seconds = points * expected_seconds_per_scene(config, centred=name in LEVEL_GRID_SECTIONS)
        counts[name] = min(points, max(ceil(seconds / target), ceil(points / MAX_SCENES_PER_CHUNK)))
        if counts[name] > MAX_CHUNKS_PER_PLAN:
            raise InputError(
                f"{config.path}: simulation.seconds_per_job: {target:g} s make {counts[name]} jobs "
                f"of the plan {name}; at most {MAX_CHUNKS_PER_PLAN} are possible, so give at least "
                f"{seconds / MAX_CHUNKS_PER_PLAN:.2g}"
            )
    return counts


def expected_seconds_per_scene(config: Study, *, centred: bool) -> float:
    """Mean time of a scene on one thread, from a few random scenes of the study."""
    sample = random_plan(points=COST_SAMPLE_SCENE_COUNT, seed=1, **space_of_study(config).limits)
    if centred:
        sample = sample.assign(**dict.fromkeys(find_position_columns(sample), 0.0))
    scenes = scenes_of_table(sample, config, profile=config.profile_for_planning())
    planned = dry_run(scenes, tolerance=config.solver.tolerance, method=config.solver.method)
    mflop = sum(preview["expected_mflop"] for preview in planned) / COST_SAMPLE_SCENE_COUNT
    seconds = OVERHEAD_SECONDS_PER_SCENE + mflop / MFLOP_PER_SECOND
    return seconds * OUTPUTS_TIME_FACTOR + OUTPUTS_SECONDS_PER_SCENE if config.outputs else seconds
