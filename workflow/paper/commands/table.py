"""Make one of the paper's tables from the results: 1, 2 or 3.

  squeezefilm table 2 screen=screen.csv plan=four_factor.csv --output T.csv --markdown T.md

Leave the NAME=PATH out to be told which ones a table needs. The CSV has one row per value, the
Markdown file is for people.
"""

import argparse

from paper.tables import table_module
from squeezefilm.io.atomic import write_text
from squeezefilm.io.sources import parse_sources
from squeezefilm.io.tables import write_table


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("number", metavar="NUMBER", help="1, 2 or 3")
    parser.add_argument("inputs", metavar="NAME=PATH", nargs="*", help="what it is made from")
    parser.add_argument("--output", required=True, metavar="TABLE.csv")
    parser.add_argument("--markdown", required=True, metavar="TABLE.md")


def run(options: argparse.Namespace) -> None:
    module = table_module(options.number)
    inputs = parse_sources(
        options.inputs, names=tuple(module.INPUTS), user=f"table {options.number}"
    )
    table = module.build(inputs)
    write_table(table.data, options.output)
    write_text(table.to_markdown(), options.markdown)
