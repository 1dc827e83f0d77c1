"""Compile the kernels, so that jobs that start side by side find them in the caches.

  squeezefilm warm --config config/paper.yaml --output device.json

Writes which device the study's simulations run on.
"""

import argparse

from squeezefilm.config.loading import load_config
from squeezefilm.io.tables import ScenePoint, write_json
from squeezefilm.reynolds import node_cache
from squeezefilm.reynolds.device import describe
from squeezefilm.reynolds.periodic.launch import warm
from squeezefilm.studies.solver_settings import device_of
from squeezefilm.studies.study import scene_of


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--config", required=True, metavar="CONFIG.yaml", help="the study")
    parser.add_argument("--output", required=True, metavar="DEVICE.json", help="file to write")


def run(options: argparse.Namespace) -> None:
    config = load_config(options.config)
    at_rest = ScenePoint("any", h0_m=5e-6, hv_m=0.0)
    # Which terms a film needs does not depend on its gap, so no gap need be one of the study's.
    scene = scene_of(at_rest, config, check=False)
    with node_cache.one_build_at_a_time():
        device = device_of(config)
        warm(device, scene)
    facts = describe(device)
    del facts["global_memory_bytes"]  # PoCL's is what is free at the moment
    write_json(facts, options.output)
