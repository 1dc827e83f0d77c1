"""Write a page for people, and the tables and texts that go with it."""

from collections.abc import Callable
from pathlib import Path

from paper.equations import equations_page
from paper.uncertainty import uncertainty_page
from reporting.check import check_page
from reporting.models import models_page, refine_page
from reporting.pages import Page, render, write_pages
from reporting.results import Results
from reporting.summary import summary_page
from scripts.job import begin_with_study, write

PAGES: dict[str, Callable[..., Page]] = {
    "check": check_page,
    "equations": equations_page,
    "models": models_page,
    "refine": refine_page,
    "summary": summary_page,
    "uncertainty": uncertainty_page,
}

snakemake, config = begin_with_study()
params, output = snakemake.params, snakemake.output
results = Results(Path(params.results), config)
page = PAGES[params.page](results, **params.get("about", {}), **snakemake.wildcards)
write(output, **page.files)
text = render(f"{params.page}.md", **page.values)
write_pages(text, output.markdown, output.page, beyond=results.beyond)
