"""Measure the solver's parts beside the limits of the device: arithmetic and memory.

squeezefilm roofline --config CONFIG.yaml --output ROOFLINE.csv
"""

import argparse

import pandas as pd

from numerics.roofline import measure
from squeezefilm.io.tables import write_table
from squeezefilm.studies.config import load_config
from squeezefilm.studies.solver_settings import device_of


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--config", required=True, metavar="CONFIG.yaml", help="the study")
    parser.add_argument("--output", required=True, metavar="ROOFLINE.csv", help="table to write")


def run(options: argparse.Namespace) -> None:
    config = load_config(options.config)
    device = device_of(config)
    table = pd.DataFrame([vars(rate) for rate in measure(device)]).assign(device=device.name)
    write_table(table, options.output)
    print(table.drop(columns="device").to_string(index=False, float_format="{:.2f}".format))
    print(device.name)
