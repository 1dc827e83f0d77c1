"""Compare a finished study with its stored reference; the rule `check` fails where it failed."""

from pathlib import Path

from reporting.check.compare import compare, on_screen, read_reference, summary
from reporting.check.quantities import study_quantities
from reporting.pages import render, write_pages
from reporting.results import Results
from scripts.job import begin_with_study
from squeezefilm.files import write_text
from squeezefilm.tables import write_table

snakemake, config = begin_with_study()
results, reference = (
    Results(Path(snakemake.params.results), config),
    Path(snakemake.params.reference),
)
table = compare(study_quantities(results, reference), read_reference(reference))
write_table(table, snakemake.output.csv)
shown = table.assign(of_tolerance=table["of_tolerance"].map("{:.2g}".format))
text = render("check.md", summary=summary(table), table=shown)
write_text(on_screen(table) + "\n", snakemake.output.text)
write_pages(text, snakemake.output.markdown, snakemake.output.page, beyond=results.beyond)
