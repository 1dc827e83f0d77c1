"""The report's own words: a caption for every figure, a line for every category."""

from __future__ import annotations

import re
from pathlib import Path
from types import SimpleNamespace

import pytest
from jinja2 import Template

from reporting.figures import FIGURES


def caption(repository: Path, figure: str) -> str:
    """What the report shows below a figure."""
    text = (repository / "workflow/report/figure.rst").read_text(encoding="utf-8")
    wildcards = SimpleNamespace(figure=figure)
    return Template(text).render(snakemake=SimpleNamespace(wildcards=wildcards)).strip()


@pytest.mark.parametrize("figure", FIGURES)
def test_every_figure_has_a_caption(repository: Path, figure: str) -> None:
    number = figure.removeprefix("fig")
    title = f"Figure {int(number)}" if number.isdigit() else figure.replace("_", " ").capitalize()
    assert caption(repository, figure).startswith(f"**{title}.** ")


def test_a_figure_without_a_caption_says_so(repository: Path) -> None:
    assert caption(repository, "fig99").startswith("**fig99.** No caption is written")


def test_the_report_s_first_page_names_every_category(repository: Path) -> None:
    rules = (path.read_text() for path in (repository / "workflow/rules").glob("*.smk"))
    found = {name for text in rules for name in re.findall(r'category="(\d+ [^"]+)"', text)}
    page = (repository / "workflow/report/workflow.rst").read_text(encoding="utf-8")
    named = {
        f"{number} {name}" for number, name in re.findall(r"^(\d+)\. \*\*(.+?)\*\*", page, re.M)
    }
    assert named == found
    own = (repository / "workflow/report/study.rst").read_text(encoding="utf-8")
    named_too = {" ".join(each) for each in re.findall(r"^(\d+)\. \*\*(.+?)\*\*", own, re.M)}
    assert named_too == found - {"1 Summary and claims", "2 Tables"} | {"1 Summary"}
