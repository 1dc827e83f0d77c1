"""The report's own words: a caption for every figure, a line for every category."""

import re

import pytest

from reporting.rooms import described
from squeezefilm.io.errors import InputError
from squeezefilm.provenance import WORKFLOW

FIGURES = [described(path) for path in sorted(WORKFLOW.glob("*/figures/[!_]*.py"))]


@pytest.mark.parametrize("figure", FIGURES, ids=lambda figure: figure.module)
def test_every_figure_has_a_caption(figure):
    number = figure.place.removeprefix("figures/fig")
    if number.isdigit():
        assert figure.title == f"Figure {int(number)}"
    assert len(figure.caption) > len(figure.shows) > 0
    assert figure.caption.endswith(".")


@pytest.mark.parametrize("text", ["", '"""Figure 5: no caption."""', '"""A line.\n\nA text."""'])
def test_a_figure_without_a_caption_is_refused(text, tmp_path):
    path = tmp_path / "fig05.py"
    path.write_text(f"{text}\nINPUTS = {{'table': 'a.csv'}}\n")
    with pytest.raises(InputError, match=r"fig05\.py: a figure's docstring says .* caption"):
        described(path)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "what it is made from in INPUTS"),
        ("INPUTS = dict(a='a.csv')", "INPUTS must be a plain literal"),
        ("INPUTS = {'a': 'a.csv', 'b': 'b.csv'}", "drawn from one table"),
    ],
)
def test_a_figure_says_what_it_is_made_from(text, message, tmp_path):
    path = tmp_path / "fig05.py"
    path.write_text(f'"""Figure 5: a thing.\n\nIts caption.\n"""\n{text}\n')
    with pytest.raises(InputError, match=message):
        described(path)


def test_the_report_s_first_page_names_every_category(repository):
    rules = (path.read_text() for path in (repository / "workflow/rules").glob("*.smk"))
    pattern = re.compile(r'(?:category=|^    "\w+": )"(\d+ [^"]+)"', re.MULTILINE)
    found = {name for text in rules for name in pattern.findall(text)}
    page = (repository / "workflow/paper/paper_guide.rst").read_text(encoding="utf-8")
    named = {
        f"{number} {name}" for number, name in re.findall(r"^(\d+)\. \*\*(.+?)\*\*", page, re.M)
    }
    assert named == found
    own = (repository / "workflow/reporting/pages/study_guide.rst").read_text(encoding="utf-8")
    named_too = {" ".join(each) for each in re.findall(r"^(\d+)\. \*\*(.+?)\*\*", own, re.M)}
    assert named_too == found - {"1 Summary and claims", "2 Tables"} | {"1 Summary"}
