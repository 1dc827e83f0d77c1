"""Make a smooth profile of a study's scan, once for all commands of a run.

    squeezefilm smooth --config config/mine.yaml --output smoothed.npz

Commands that find the file's name in SQUEEZEFILM_SMOOTHED read it; others smooth the scan anew.
"""

import argparse
from pathlib import Path

from squeezefilm.config.loading import load_config
from squeezefilm.film.measured.smooth import write_smoothed
from squeezefilm.io.errors import InputError
from squeezefilm.studies.study import scan_path, smoothed_anew, smoothing_settings


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--config", required=True, metavar="CONFIG.yaml")
    parser.add_argument("--output", required=True, metavar="SMOOTHED.npz")


def run(options: argparse.Namespace) -> None:
    config = load_config(options.config)
    if scan_path(config) is None:
        kind = config["actuator"]["profile"]["kind"]
        raise InputError(f"{options.config}: actuator.profile: {kind} is not measured")
    smoothed = smoothed_anew(config)
    write_smoothed(smoothed, Path(options.output), settings=smoothing_settings(config))
    for warning in smoothed.warnings:
        print(warning)
