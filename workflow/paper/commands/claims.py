"""Compare the paper's claims with our results: value beside value, with a verdict and a reason.

  squeezefilm claims NAME=PATH ... --output claims.csv --markdown claims.md

Leave the NAME=PATH out to be told which results are needed.
"""

import argparse

from paper.claims import INPUTS, judge, read_results, to_markdown
from squeezefilm.io.atomic import write_text
from squeezefilm.io.sources import parse_sources
from squeezefilm.io.tables import write_table


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("inputs", metavar="NAME=PATH", nargs="*", help="the results")
    parser.add_argument("--output", required=True, metavar="CLAIMS.csv")
    parser.add_argument("--markdown", required=True, metavar="CLAIMS.md")


def run(options: argparse.Namespace) -> None:
    claims = judge(read_results(parse_sources(options.inputs, names=tuple(INPUTS), user="claims")))
    write_table(claims, options.output)
    write_text(to_markdown(claims), options.markdown)
