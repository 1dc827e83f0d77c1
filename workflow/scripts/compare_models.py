"""Write the candidates for the force model of a space side by side."""

from pathlib import Path

from reporting.models import compare, comparison_values
from reporting.pages import render, write_pages
from reporting.results import Results
from scripts.job import begin_with_study
from squeezefilm.tables import write_table

snakemake, config = begin_with_study()
space = snakemake.wildcards.space
results = Results(Path(snakemake.params.results), config)
table, errors = compare(results, space)
write_table(table, snakemake.output.table)
write_table(errors, snakemake.output.errors)
text = render("models.md", **comparison_values(results, space, table))
write_pages(text, snakemake.output.text, snakemake.output.page, beyond=results.beyond)
