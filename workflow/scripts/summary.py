"""Write the study on one page, and the first page of its report."""

from pathlib import Path

from reporting.pages import front_page, render, write_pages
from reporting.results import Results
from reporting.summary import summary_values
from scripts.job import begin_with_study
from squeezefilm.files import write_text

snakemake, config = begin_with_study()
params = snakemake.params
results = Results(Path(params.results), config)
values = summary_values(results, plans=params.plans, fits=params.fits, pairs=params.pairs)
text = render("summary.md", **values)
write_pages(text, snakemake.output.markdown, snakemake.output.page, beyond=results.beyond)
front = front_page(
    render("in_short.md", **values),
    study=config["study"],
    pictures=[Path(picture) for picture in snakemake.input.pictures],
    guide="paper_guide.rst" if config["paper"] else "study_guide.rst",
)
write_text(front, snakemake.output.front)
