"""Write the first page of a study's report: its headline, its pictures, and how to read the rest.

  squeezefilm front SUMMARY.md --pictures overview.png … --output front.rst

Snakemake puts it before everything else; the pictures are within it.
"""

import argparse
from pathlib import Path

from reporting import pages
from reporting.pages.front import add_front_arguments, front_page
from squeezefilm.io.atomic import write_text

GUIDE = Path(pages.__file__).with_name("study_guide.rst")


add_arguments = add_front_arguments


def run(options: argparse.Namespace) -> None:
    page = front_page(options.summary, pictures=options.pictures, guide=GUIDE)
    write_text(page, options.output)
