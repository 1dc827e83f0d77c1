"""Show a study as it is computed: every key, its value in SI units, and where that comes from.

    squeezefilm config config/my-actuator.yaml

What is not marked was written; `default` is the library's, `derived` follows from what was written.
The text is a study itself. A run writes it beside its results: results/STUDY/study.yaml.
"""

import argparse

from squeezefilm.config.loading import load_config
from squeezefilm.config.written import effective_text
from squeezefilm.studies.study import check_study


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("study", metavar="STUDY.yaml")


def run(options: argparse.Namespace) -> None:
    print(effective_text(check_study(load_config(options.study))), end="")
