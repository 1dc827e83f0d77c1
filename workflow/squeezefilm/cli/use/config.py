"""Show a study as it is computed: every key, its value in SI units, and where that comes from.

    squeezefilm config config/my-actuator.yaml

All that a run would refuse is refused here. What is not marked was written; `default` is the
library's, `derived` follows from what was written. The text is a study itself. A run writes it
beside its results: results/STUDY/study.yaml. `--schema` prints a study's JSON schema, for editors.
"""

import argparse
import json

from squeezefilm.config.loading import load_config
from squeezefilm.config.study import Study
from squeezefilm.config.written import effective_text
from squeezefilm.errors import InputError
from squeezefilm.models.force_model import check_models
from squeezefilm.studies.plans import chunk_counts
from squeezefilm.studies.study import check_study


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("study", nargs="?", metavar="STUDY.yaml")
    parser.add_argument("--schema", action="store_true", help="print the keys' JSON schema instead")


def run(options: argparse.Namespace) -> None:
    if options.schema:
        print(json.dumps(Study.model_json_schema(), ensure_ascii=False, indent=2))
        return
    if options.study is None:
        raise InputError("give a study, STUDY.yaml")
    config = check_study(load_config(options.study))
    check_models(config["models"], config, place=config.path)
    chunk_counts(config)
    print(effective_text(config), end="")
