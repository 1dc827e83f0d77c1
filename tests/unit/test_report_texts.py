"""The report's own words: a caption for every figure, a line for every category."""

import re

from paper.figures import FIGURES as OF_THE_PAPER
from reporting.figures import FIGURES


def test_every_figure_has_a_caption_and_a_place_in_a_rule(repository):
    rules = (repository / "workflow/rules/figures.smk").read_text(encoding="utf-8")
    captions = repository / "workflow/report/captions"
    for place in FIGURES | OF_THE_PAPER:
        folder, name = place.split("/")
        if folder in ("figures", "numerics"):
            assert f'"{place}": ' in rules
            text = (captions / f"{name}.rst").read_text(encoding="utf-8")
            assert re.fullmatch(r"\*\*.+\.\*\* [^\n]+(\n[^\n]+)?\.\n", text), name
    paths = (repository / "workflow/rules").glob("*.smk")
    used = {name for path in paths for name in re.findall(r'caption="(\w+)"', path.read_text())}
    assert used
    assert all((captions / f"{name}.rst").exists() for name in used)


def test_the_report_s_first_page_names_every_category(repository):
    rules = (path.read_text() for path in (repository / "workflow/rules").glob("*.smk"))
    pattern = re.compile(r'"(\d+ [A-Z][A-Za-z ]+)"')
    found = {name for text in rules for name in pattern.findall(text)}
    named = {}
    for guide in ("paper", "study"):
        page = (repository / f"workflow/report/{guide}_guide.rst").read_text(encoding="utf-8")
        named[guide] = {
            " ".join(each) for each in re.findall(r"^(\d+)\. \*\*(.+?)\*\*", page, re.M)
        }
    assert named["paper"] == found - {"1 Summary"}
    assert named["study"] == found - {"1 Summary and claims", "2 Tables"}
