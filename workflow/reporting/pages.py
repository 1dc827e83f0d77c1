"""Pages for people: Markdown from templates in ``report/``, and the same as HTML.

A page of HTML is one file: no script, nothing from a network.
"""

import base64
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined, select_autoescape
from markupsafe import Markup

from reporting.markdown import markdown_table
from reporting.notes import percent, rounded_up
from squeezefilm.errors import InputError
from squeezefilm.files import write_text

VERDICTS = {
    "good": ("agrees", "passed", "solved"),
    "bad": ("differs", "failed", "killed"),
}
"""How a cell begins that is coloured as good or bad."""

TEMPLATES = Environment(
    loader=FileSystemLoader(Path(__file__).resolve().parents[1] / "report"),
    # Markdown is escaped where it becomes HTML.
    autoescape=select_autoescape(["html", "rst"]),
    undefined=StrictUndefined,
    trim_blocks=True,
    lstrip_blocks=True,
    keep_trailing_newline=True,
)
TEMPLATES.filters |= {"percent": percent, "rounded_up": rounded_up, "table": markdown_table}


def render(template: str, **values: Any) -> str:
    """A template of ``report/`` with its values filled in."""
    return TEMPLATES.get_template(template).render(**values)


def body_of(markdown: str) -> Markup:
    """Markdown as HTML in which nothing is taken for HTML; tables scroll by themselves."""
    from markdown_it import MarkdownIt

    body = str(MarkdownIt("commonmark", {"html": False}).enable("table").render(markdown))
    for colour, words in VERDICTS.items():
        for word in words:
            body = body.replace(f"<td>{word}", f'<td class="{colour}">{word}')
    body = body.replace("<table>", '<div class="table"><table>')
    return Markup(body.replace("</table>", "</table></div>"))


def to_html(markdown: str, *, title: str) -> str:
    """A page of Markdown as a page of HTML; cells that begin with a verdict are coloured."""
    return render("page.html", body=body_of(markdown), title=title)


def write_pages(markdown: str, text: Path | str, page: Path | str, *, beyond: str = "") -> None:
    """Write a page as Markdown and as HTML.

    Args:
        beyond: what is said below the title, of a study whose films go beyond their equation.
    """
    if beyond and beyond not in markdown:
        title, _, rest = markdown.partition("\n")
        markdown = f"{title}\n\n**{beyond}**\n{rest}"
    write_text(markdown, text)
    write_text(to_html(markdown, title=Path(page).stem), page)


def front_page(headline: str, *, study: str, pictures: Sequence[Path], guide: str) -> str:
    """The first page of a study's report, as reStructuredText with the pictures within it.

    Args:
        headline: what the study found, as Markdown.
        guide: the template of what comes behind.

    Raises InputError for a picture that cannot be read.
    """
    shown = {path.stem.replace("_", " "): _data(path) for path in pictures}
    return render("front.rst", study=study, body=body_of(headline), pictures=shown, guide=guide)


def _data(path: Path) -> str:
    try:
        # In lines: docutils takes no long ones, and a page's data may have breaks.
        return base64.encodebytes(path.read_bytes()).decode().strip()
    except OSError as error:
        raise InputError(f"{path}: the picture cannot be read: {error}") from None
