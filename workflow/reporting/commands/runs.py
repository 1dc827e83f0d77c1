"""Put the runs that made a study's present results on one page.

squeezefilm runs results/paper/run_cards --output results/paper/runs.md
"""

import argparse
from pathlib import Path

from reporting.pages.history import to_markdown
from squeezefilm.io.atomic import write_text


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("cards", type=Path, metavar="RUN_CARDS", help="the study's run cards")
    parser.add_argument("--output", required=True, metavar="RUNS.md")


def run(options: argparse.Namespace) -> None:
    write_text(to_markdown(options.cards), options.output)
