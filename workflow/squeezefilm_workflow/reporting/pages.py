"""Pages for people: Markdown from ``templates/``, written as HTML.

A page of HTML is one file: no script, nothing from a network.
"""

import base64
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import pandas as pd
from jinja2 import Environment, FileSystemLoader, StrictUndefined, select_autoescape
from markupsafe import Markup

from squeezefilm.errors import InputError
from squeezefilm.files import write_text
from squeezefilm_workflow.reporting.notes import (
    bound_percent_text,
    five_digit_text,
    percent_text,
    rounded_up_text,
)

VERDICT_STARTS_OF_STYLE = {
    "good": ("agrees", "passed", "solved", "explains", "recommended"),
    "bad": ("differs", "failed", "killed"),
}
"""How a cell begins that is coloured as good or bad."""

FRACTION_COLUMN_PATTERN = re.compile(
    r"(\w+_)?(error|relative|global_upper|coverage|fraction)(_min|_all_points|_in_\w+)?"
)
"""Columns of fractions by their names."""
NUMBER_WITH_HYPHEN_PATTERN = re.compile(r"\d[\d.]*e-\d+(?![^<]*>)")
"""A number in a page's text, not in a tag, that a browser would break at its exponent's sign."""


class Page(NamedTuple):
    """Values of a page's template, and the tables and texts that are written with the page."""

    template_values: Mapping[str, Any]
    file_contents: Mapping[str, pd.DataFrame | dict[str, Any] | str]


def readable_table(table: pd.DataFrame) -> pd.DataFrame:
    """A table for people: fractions in percent, other numbers with five digits, names in words."""
    shown = table.astype(object)
    for name in map(str, table.select_dtypes("float")):
        form = percent_text if FRACTION_COLUMN_PATTERN.fullmatch(name) else five_digit_text
        shown[name] = table[name].map(form, na_action="ignore")
    units = {"_n$": " (N)", "_percent$": " (%)", "_": " "}
    return shown.set_axis(table.columns.to_series().replace(units, regex=True), axis="columns")


def markdown_table(table: pd.DataFrame) -> str:
    """The table in Markdown; values are shown as they are, missing ones as a dash."""
    rows = table.astype(object).where(table.notna(), "–").to_numpy().tolist()
    return "".join(
        "| " + " | ".join(str(cell).replace("|", "\\|") for cell in row) + " |\n"
        for row in [list(table.columns), ["---"] * table.shape[1], *rows]
    )


REPORTING_PACKAGE_FOLDER = Path(__file__).parent
TEMPLATE_ENVIRONMENT = Environment(
    loader=FileSystemLoader(
        [REPORTING_PACKAGE_FOLDER / "templates", REPORTING_PACKAGE_FOLDER / "explorer"]
    ),
    # Markdown is escaped where it becomes HTML.
    autoescape=select_autoescape(["html", "rst"]),
    undefined=StrictUndefined,
    trim_blocks=True,
    lstrip_blocks=True,
    keep_trailing_newline=True,
)
TEMPLATE_ENVIRONMENT.filters |= {
    "percent": percent_text,
    "bound_percent": bound_percent_text,
    "rounded_up": rounded_up_text,
    "table": markdown_table,
}


def render_template(template: str, **values: Any) -> str:
    """A template of a page or of the explorer with its values filled in."""
    return TEMPLATE_ENVIRONMENT.get_template(template).render(**values)


def html_of_markdown(markdown: str, *, folder: Path = Path()) -> Markup:
    """Markdown as HTML in which nothing is taken for HTML; tables scroll by themselves.

    Cells that begin with a verdict are coloured, numbers stay on one line, and pictures are within
    the page.

    Args:
        folder: in which the pictures lie.

    Raises InputError for a picture that cannot be read.
    """
    from markdown_it import MarkdownIt

    def scrolling_table(match: re.Match[str]) -> str:
        path = folder / match[1]
        try:
            # In lines: docutils takes no long ones, and a page's data may have breaks.
            data = base64.encodebytes(path.read_bytes()).decode().strip()
        except OSError as error:
            raise InputError(f"{path}: the picture cannot be read: {error}") from None
        return f'<img src="data:image/png;base64,{data}"'

    body = str(MarkdownIt("commonmark", {"html": False}).enable("table").render(markdown))
    body = NUMBER_WITH_HYPHEN_PATTERN.sub(r'<span class="number">\g<0></span>', body)
    for colour, words in VERDICT_STARTS_OF_STYLE.items():
        for word in words:
            body = body.replace(f"<td>{word}", f'<td class="{colour}">{word}')
    body = body.replace("<table>", '<div class="table" tabindex="0"><table>')
    body = body.replace("</table>", "</table></div>")
    body = body.replace("<ul>\n<li><img", '<ul class="pictures">\n<li><img')
    return Markup(re.sub('<img src="(.*?)"', scrolling_table, body))


def write_page(markdown: str, page: Path | str, *, folder: Path = Path(), beyond: str = "") -> None:
    """Write Markdown as a page of HTML, with its first line as the title.

    Args:
        folder: in which the pictures lie.
        beyond: what is said below the title, of a study whose films go beyond their equation.
    """
    title, _, rest = markdown.partition("\n")
    if beyond and beyond not in markdown:
        markdown = f"{title}\n\n**{beyond}**\n{rest}"
    body = html_of_markdown(markdown, folder=folder)
    write_text(render_template("page.html", body=body, title=title.lstrip("# ")), page)
