"""Write the first page of the paper's report: its headline, its pictures, and how to read the rest.

squeezefilm paper-front SUMMARY.md --pictures overview.png … --output front.rst
"""

import argparse
from pathlib import Path

import paper
from reporting.pages.front import add_front_arguments, front_page
from squeezefilm.io.atomic import write_text

GUIDE = Path(paper.__file__).with_name("paper_guide.rst")


add_arguments = add_front_arguments


def run(options: argparse.Namespace) -> None:
    page = front_page(options.summary, pictures=options.pictures, guide=GUIDE)
    write_text(page, options.output)
