"""Write the paper's tables and its claims beside ours, each with a page."""

from squeezefilm.config.notes import differences_from_paper
from squeezefilm.table_writer import write_table
from squeezefilm_workflow.finished import results_of_job
from squeezefilm_workflow.job import Job, Study, run_script, write_outputs
from squeezefilm_workflow.paper.claims import claims_with_verdicts
from squeezefilm_workflow.paper.tables import PAPER_TABLE_FUNCTIONS
from squeezefilm_workflow.reporting.notes import claim_verdict_counts
from squeezefilm_workflow.reporting.pages import render_template, write_page


def main(snakemake: Job, config: Study) -> None:
    results = results_of_job(snakemake, config)
    for number, build in PAPER_TABLE_FUNCTIONS.items():
        table = build(results)
        file = results.folder / f"tables/table{number}.csv"
        write_outputs({"csv": file}, **table.file_contents)
        page = results.folder / f"report/table{number}.html"
        write_page(render_template("table.md", **table.template_values), page)
    claims = claims_with_verdicts(results)
    write_table(claims, results.folder / "claims.csv")
    variant = ", ".join(differences_from_paper(config))
    counts = claim_verdict_counts(claims)
    text = render_template("claims.md", claims=claims, variant=variant, **counts)
    write_page(text, results.folder / "report/claims.html")


if __name__ == "__main__":
    run_script(main, globals()["snakemake"])
