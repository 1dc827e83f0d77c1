"""Write the paper's tables and its claims beside ours, each with a page."""

from paper.claims import judge
from paper.tables import TABLES
from reporting.notes import verdicts
from reporting.pages import render, write_page
from squeezefilm.tables import write_table
from squeezefilm_workflow.finished import results_of
from squeezefilm_workflow.job import Job, Study, run, write


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
