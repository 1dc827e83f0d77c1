"""Write the paper's tables and its claims beside ours, each with a page."""

from pathlib import Path

from paper.claims import judge
from paper.tables import TABLES
from reporting.pages import render, write_pages
from reporting.results import Results
from scripts.job import begin_with_study, write
from squeezefilm.tables import write_table

snakemake, config = begin_with_study()
results = Results(Path(snakemake.params.results), config)
for number, build in TABLES.items():
    table = build(results)
    file = results.folder / f"tables/table{number}.csv"
    write({"csv": file}, **table.files)
    page = results.folder / f"report/table{number}.html"
    write_pages(render("table.md", **table.values), file.with_suffix(".md"), page)
claims = judge(results)
write_table(claims, results.folder / "claims.csv")
text = render("claims.md", claims=claims, agreeing=claims["verdict"].str.startswith("agrees").sum())
write_pages(text, results.folder / "claims.md", results.folder / "report/claims.html")
