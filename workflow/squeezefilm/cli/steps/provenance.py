"""Write down what makes a study's results: commit, packages, device and configuration.

squeezefilm provenance DEVICE.json --config CONFIG.yaml --output PROVENANCE.json
"""

import argparse

from squeezefilm.config.loading import load_config
from squeezefilm.io.tables import read_json, write_json
from squeezefilm.provenance import provenance


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("device", metavar="DEVICE.json", help="what the simulations run on")
    parser.add_argument("--config", required=True, metavar="CONFIG.yaml", help="the study")
    parser.add_argument("--output", required=True, metavar="PROVENANCE.json")


def run(options: argparse.Namespace) -> None:
    facts = provenance(load_config(options.config), device=read_json(options.device))
    write_json(facts, options.output)
