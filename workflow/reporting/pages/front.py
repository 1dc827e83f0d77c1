"""The first page of a study's report: its headline, its pictures, and how to read the rest."""

import argparse
import base64
import html
import textwrap
from collections.abc import Sequence
from pathlib import Path

from reporting.pages.headline import IN_SHORT
from reporting.pages.page import body_of
from squeezefilm.io.errors import InputError


def add_front_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("summary", type=Path, metavar="SUMMARY.md", help="the study on one page")
    parser.add_argument("--pictures", nargs="*", default=[], type=Path, metavar="PICTURE.png")
    parser.add_argument("--output", required=True, metavar="FRONT.rst")


def front_page(summary: Path, *, pictures: Sequence[Path], guide: Path) -> str:
    """The page as reStructuredText with the pictures within it.

    Args:
        summary: the study on one page, as Markdown.
        guide: what comes behind, as reStructuredText.

    Raises InputError for a summary without a headline, or a picture that cannot be read.
    """
    title, _, rest = summary.read_text(encoding="utf-8").partition("\n")
    _, found, lines = rest.partition(IN_SHORT)
    if not found:
        raise InputError(f"{summary}: it has no part {IN_SHORT!r}")
    lines = lines.partition("\n## ")[0]
    study = title.removeprefix("# ").removesuffix(" on one page")
    parts = [f"<h1>{html.escape(study)}</h1>", body_of(lines), *map(_picture, pictures)]
    # Raw for docutils, and for the templates that captions are.
    page = textwrap.indent("\n".join(parts), "    ")
    behind = guide.read_text(encoding="utf-8")
    return f"{{% raw %}}\n.. raw:: html\n\n{page}\n\n{{% endraw %}}\n\n{behind}"


def _picture(path: Path) -> str:
    try:
        # In lines: docutils takes no long ones, and a page's data may have breaks.
        data = base64.encodebytes(path.read_bytes()).decode()
    except OSError as error:
        raise InputError(f"{path}: the picture cannot be read: {error}") from None
    name = html.escape(path.stem.replace("_", " "))
    return f'<img class="headline" alt="{name}" src="data:image/png;base64,{data}">'
