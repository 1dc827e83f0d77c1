"""The scenes of each plan, as a table to simulate."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import pandas as pd

from squeezefilm.config.loading import Config
from squeezefilm.errors import naming
from squeezefilm.models.amplitude_for_force import amplitude_for_force
from squeezefilm.models.fit_file import FittedModel, read_fit
from squeezefilm.solution import as_in
from squeezefilm.studies.plans import (
    VALIDATION_SAMPLES,
    box_of,
    centred_grid,
    finger_positions,
    four_factor_plan,
    level_values,
    plan,
    random_plan,
    sweep_pieces,
)
from squeezefilm.studies.space import Space
from squeezefilm.studies.study import surface_of
from squeezefilm.tables import SCENE_COLUMNS, read_design, table_writer


def write_scenes(
    name: str, config: Config, *, sources: Sequence[Path | str] = (), output: Path | str
) -> None:
    """Write the table of a plan; a sweep is made and written in pieces.

    Args:
        sources: the design that a plan is made from, and of ``extrapolation`` the fits.
    """
    with table_writer(output) as write:
        if name == "sweep":
            points, first, seed = (config["sweep"][key] for key in ("points", "first", "seed"))
            ranges = box_of(config).ranges
            for piece in sweep_pieces(points=points, first=first, seed=seed, **ranges):
                write(piece)
        elif name == "extrapolation":
            fits = {Path(path).stem: read_fit(path) for path in sources}
            write(extrapolation_scenes(config, fits))
        else:
            design = read_design(sources[0]) if sources else None
            write(scenes_of(name, config, design=design))


def scenes_of(name: str, config: Config, *, design: pd.DataFrame | None = None) -> pd.DataFrame:
    """The scenes of a plan that the study or a design gives."""
    position = surface_of(config).position
    if name in ("screen", "error_map"):
        levels = config[name]
        return centred_grid(
            h0_m=level_values(levels["h0_m"]),
            hv_m=level_values(levels["hv_m"]),
            position=position,
        )
    if name == "four_factor_control":
        points, seed = config[name]["points"], config[name]["seed"]
        return random_plan(points=points, seed=seed, **box_of(config).ranges)
    if name in VALIDATION_SAMPLES:
        points, seed = config["validation"]["points"], config["validation"]["seed"]
        space = Space.of(config, centred=name == "validation_two_factor")
        return space.table(space.independent_sample(points, seed=seed))
    assert design is not None, f"the plan {name} is made from a design"
    if name == "four_factor":
        return four_factor_plan(
            positions=finger_positions(config),
            h0_m=design["h0_m"].to_numpy(),
            hv_m=design["hv_m"].to_numpy(),
            position=position,
        )
    return design[as_in(SCENE_COLUMNS, design)]


def extrapolation_scenes(config: Config, fits: Mapping[str, FittedModel]) -> pd.DataFrame:
    """The operating point of the section ``extrapolation``, and one scene of each fit.

    Each fit adds the scene at which it expects the wanted force at that gap, named as the fit is.
    """
    point = config["extrapolation"]
    amplitudes = {"operating_point": point["hv_m"]}
    for name, fit in fits.items():
        with naming(name):
            amplitudes[name] = amplitude_for_force(
                fit.force_model, fit.theta, force_n=point["force_n"], h0_m=point["h0_m"]
            )
    scenes = plan(
        h0_m=[point["h0_m"]] * len(amplitudes),
        hv_m=list(amplitudes.values()),
        position=fit.position,
    )
    return scenes.assign(point_id=list(amplitudes))
