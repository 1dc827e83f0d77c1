"""Write a page for people, and the tables and texts that go with it."""

from importlib import import_module

from squeezefilm_workflow.finished import results_of_job
from squeezefilm_workflow.job import Job, Study, run_script, write_outputs
from squeezefilm_workflow.reporting.pages import render_template, write_page

# Each has a function PAGE_page; what one needs takes others long to import.
MODULE_OF_PAGE = {
    "check": "squeezefilm_workflow.reporting.check",
    "equations": "squeezefilm_workflow.paper.equations",
    "refine": "squeezefilm_workflow.reporting.models",
    "summary": "squeezefilm_workflow.reporting.summary",
    "uncertainty": "squeezefilm_workflow.paper.uncertainty",
}


def main(snakemake: Job, config: Study) -> None:
    results = results_of_job(snakemake, config)
    params, output = snakemake.params, snakemake.output
    build = getattr(import_module(MODULE_OF_PAGE[params.page]), f"{params.page}_page")
    page = build(results, **params.get("about", {}), **snakemake.wildcards)
    write_outputs(output, **page.file_contents)
    text = render_template(f"{params.page}.md", **page.template_values)
    write_page(text, output.page, folder=results.folder, beyond=results.validity_note)


if __name__ == "__main__":
    run_script(main, globals()["snakemake"])
