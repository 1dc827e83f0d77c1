"""From a plan to the forces of its scenes."""

from collections.abc import Iterable, Mapping

import pandas as pd

from squeezefilm.io.errors import naming
from squeezefilm.io.positions import as_in
from squeezefilm.io.tables import SCENE_COLUMNS
from squeezefilm.models.fitted import FittedModel
from squeezefilm.models.working_point import amplitude_for_force
from squeezefilm.studies.config import Config
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


def scenes_of(
    name: str, config: Config, *, design: pd.DataFrame | None = None
) -> Iterable[pd.DataFrame]:
    """The scenes of a plan; those of a sweep in pieces.

    Args:
        design: the table of a design, for the plans that are made from one.
    """
    if name == "sweep":
        sweep = config["sweep"]
        return sweep_pieces(
            points=sweep["points"],
            first=sweep["first"],
            seed=sweep["seed"],
            **box_of(config).ranges,
        )
    return [_small_plan(name, config, design=design)]


def _small_plan(name: str, config: Config, *, design: pd.DataFrame | None) -> pd.DataFrame:
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
