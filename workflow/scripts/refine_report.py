"""Write what refinements of a space's models estimated, beside points that they have not seen."""

from pathlib import Path

from reporting.pages import render, write_pages
from reporting.refinement import refinement_table
from reporting.results import Results
from scripts.job import begin_with_study
from squeezefilm.tables import write_table

snakemake, config = begin_with_study()
results = Results(Path(snakemake.params.results), config)
table, values = refinement_table(results, snakemake.wildcards.space)
write_table(table, snakemake.output.table)
text = render("refine.md", **values)
write_pages(text, snakemake.output.text, snakemake.output.page, beyond=results.beyond)
