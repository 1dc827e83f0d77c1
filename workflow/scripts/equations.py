"""Write the paper's study beside the same one with inertia: parameters, errors and designs."""

from pathlib import Path

from paper.equations import compare, conditions, survives
from paper.tables import five_digits
from reporting.pages import render, write_pages
from reporting.results import Results
from scripts.job import begin_with_study
from squeezefilm.tables import write_table

snakemake, config = begin_with_study()
table = compare(*(Results(Path(folder), config) for folder in snakemake.params.sides))
write_table(table, snakemake.output.csv)
heads = {"paper_equation": "the paper's equation", "with_inertia": "with inertia"}
text = render(
    "equations.md",
    survives=survives(table, column="with_inertia"),
    conditions=conditions(table),
    parts={
        part: rows.assign(**{name: rows[name].map(five_digits) for name in heads})
        .drop(columns="part")
        .rename(columns=heads)
        for part, rows in table.groupby("part", sort=False)
    },
)
beyond = Results(Path(), config).beyond
write_pages(text, snakemake.output.markdown, snakemake.output.page, beyond=beyond)
