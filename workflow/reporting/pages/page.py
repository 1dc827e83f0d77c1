"""Pages of HTML from our Markdown: one file, no script, nothing from a network."""

import html

STYLE = """
body { font: 15px/1.5 "DejaVu Sans", Verdana, Arial, sans-serif; color: #1a1a1a;
  background: #fff; margin: 1.5rem auto; max-width: 75rem; padding: 0 1rem; }
h1 { font-size: 1.5rem; } h2 { font-size: 1.2rem; margin-top: 2rem; }
.table { overflow-x: auto; }
table { border-collapse: collapse; font-size: 13px; margin: 1rem 0; }
th, td { border: 1px solid #ccc; padding: 0.3rem 0.5rem; text-align: left; vertical-align: top; }
th { background: #eef3f8; position: sticky; top: 0; }
tr:nth-child(even) td { background: #fafafa; }
td.good { background: #e3f3ea !important; } td.bad { background: #fbe3d0 !important; }
"""
GOOD, BAD = ("agrees", "passed", "solved"), ("differs", "failed", "killed")


def body_of(markdown: str) -> str:
    """Markdown as HTML; tables scroll by themselves."""
    from markdown_it import MarkdownIt

    body = str(MarkdownIt("commonmark", {"html": False}).enable("table").render(markdown))
    body = body.replace("<table>", '<div class="table"><table>')
    return body.replace("</table>", "</table></div>")


def to_html(markdown: str, *, title: str) -> str:
    """A page of Markdown as a page of HTML; cells that begin with a verdict are coloured."""
    body = body_of(markdown)
    for colour, words in (("good", GOOD), ("bad", BAD)):
        for word in words:
            body = body.replace(f"<td>{word}", f'<td class="{colour}">{word}')
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{html.escape(title)}</title>\n<style>{STYLE}</style>\n</head>\n"
        f"<body>\n{body}</body>\n</html>\n"
    )
