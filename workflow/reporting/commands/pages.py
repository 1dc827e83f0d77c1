"""Turn Markdown into pages of HTML, each one file that needs nothing from a network.

squeezefilm pages claims.md table1.md --output claims.html table1.html

With --config a page about a study whose films go beyond Re 10 says so below its title.
"""

import argparse
from pathlib import Path

from reporting.pages.notes import Inertia
from reporting.pages.page import to_html
from squeezefilm.config.loading import load_config
from squeezefilm.io.atomic import read_text, write_text
from squeezefilm.io.errors import InputError


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("markdown", nargs="+", type=Path, metavar="PAGE.md")
    parser.add_argument("--config", metavar="CONFIG.yaml", help="the study")
    parser.add_argument("--output", nargs="+", required=True, type=Path, metavar="PAGE.html")


def run(options: argparse.Namespace) -> None:
    if len(options.markdown) != len(options.output):
        raise InputError("--output: give one name for every page of Markdown")
    note = ""
    if options.config:
        config = load_config(options.config)
        note = Inertia.of(config).note(config["screen"]["h0_m"]["stop"])
    for source, target in zip(options.markdown, options.output, strict=True):
        text = read_text(source, what="page")
        if note and note not in text:
            title, _, rest = text.partition("\n")
            text = f"{title}\n\n**{note}**\n{rest}"
        write_text(to_html(text, title=source.stem), target)
