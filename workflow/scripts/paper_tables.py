"""Write the paper's tables and its claims beside ours, each with a page."""

from squeezefilm.tables import write_table
from squeezefilm_workflow.finished import results_of_job
from squeezefilm_workflow.job import Job, Study, run, write
from squeezefilm_workflow.paper.claims import judged_claims
from squeezefilm_workflow.paper.tables import PAPERS_TABLES
from squeezefilm_workflow.reporting.notes import claims_verdict_note
from squeezefilm_workflow.reporting.pages import render, write_page


def main(snakemake: Job, config: Study) -> None:
    results = results_of_job(snakemake, config)
    for number, build in PAPERS_TABLES.items():
        table = build(results)
        file = results.folder / f"tables/table{number}.csv"
        write({"csv": file}, **table.files)
        page = results.folder / f"report/table{number}.html"
        write_page(render("table.md", **table.values), page)
    claims = judged_claims(results)
    write_table(claims, results.folder / "claims.csv")
    text = render("claims.md", claims=claims, **claims_verdict_note(claims))
    write_page(text, results.folder / "report/claims.html")


if __name__ == "__main__":
    run(main, globals()["snakemake"])
