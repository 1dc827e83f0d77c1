"""Write the paper's tables and its claims beside ours, each with a page."""

from squeezefilm.tables import write_table
from squeezefilm_workflow.finished import results_of
from squeezefilm_workflow.job import Job, Study, run, write
from squeezefilm_workflow.paper.claims import judge
from squeezefilm_workflow.paper.tables import TABLES
from squeezefilm_workflow.reporting.notes import verdicts
from squeezefilm_workflow.reporting.pages import render, write_page


def main(snakemake: Job, config: Study) -> None:
    results = results_of(snakemake, config)
    for number, build in TABLES.items():
        table = build(results)
        file = results.folder / f"tables/table{number}.csv"
        write({"csv": file}, **table.files)
        page = results.folder / f"report/table{number}.html"
        write_page(render("table.md", **table.values), page)
    claims = judge(results)
    write_table(claims, results.folder / "claims.csv")
    text = render("claims.md", claims=claims, **verdicts(claims))
    write_page(text, results.folder / "report/claims.html")


if __name__ == "__main__":
    run(main, globals()["snakemake"])
