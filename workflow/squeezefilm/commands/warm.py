"""Compile the kernels, so that jobs that start side by side find them in the caches.

  squeezefilm warm --config config/paper.yaml --output device.json

Writes which device the study's simulations run on.
"""

from __future__ import annotations

import argparse

from squeezefilm.config import load_config
from squeezefilm.reynolds import device
from squeezefilm.reynolds.periodic import warm
from squeezefilm.tables import write_json

SECTIONS = ("finger", "solver")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--config", required=True, metavar="CONFIG.yaml", help="the study")
    parser.add_argument("--output", required=True, metavar="DEVICE.json", help="file to write")


def run(options: argparse.Namespace) -> None:
    config = load_config(options.config).only(SECTIONS)
    wanted = config["solver"]["device"]
    warm(device.choose_device(wanted), bearing=config["finger"]["speed_x_m_per_s"] != 0)
    write_json(device.describe(wanted), options.output)
