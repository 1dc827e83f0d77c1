"""Plan the check of an extrapolation beyond the points that a model was fitted on.

  squeezefilm extrapolate FIT.json … --config config/paper.yaml --output scenes.csv

One scene is the operating point of the study's section `extrapolation`, named `operating_point`.
Each fit adds the scene at which it expects the wanted force at that gap, named after its file.
"""

import argparse
from pathlib import Path

from squeezefilm.config.loading import load_config
from squeezefilm.io.errors import InputError, naming
from squeezefilm.io.tables import write_table
from squeezefilm.models.fitted import read_fit
from squeezefilm.models.working_point import amplitude_for_force
from squeezefilm.studies.plans import plan


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("fits", nargs="+", metavar="FIT.json", help="fitted models")
    parser.add_argument("--config", required=True, metavar="CONFIG.yaml", help="the study")
    parser.add_argument("--output", required=True, metavar="SCENES.csv", help="table to write")


def run(options: argparse.Namespace) -> None:
    point = load_config(options.config)["extrapolation"]
    amplitudes = {"operating_point": point["hv_m"]}
    for path in options.fits:
        fit = read_fit(path)
        if Path(path).stem in amplitudes:
            raise InputError(f"{path}: two fits bear the name {Path(path).stem}")
        with naming(path):
            amplitudes[Path(path).stem] = amplitude_for_force(
                fit.force_model, fit.theta, force_n=point["force_n"], h0_m=point["h0_m"]
            )
    scenes = plan(
        h0_m=[point["h0_m"]] * len(amplitudes),
        hv_m=list(amplitudes.values()),
        position=fit.position,
    )
    write_table(scenes.assign(point_id=list(amplitudes)), options.output)
