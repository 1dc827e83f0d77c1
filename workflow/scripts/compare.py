"""Write the candidates of each space side by side, and the best with the amplitudes it needs."""

from squeezefilm.table_writer import write_table
from squeezefilm_workflow.finished import results_of_job
from squeezefilm_workflow.job import Job, Study, print_result, run_script, write_outputs
from squeezefilm_workflow.reporting.models import (
    missing_amplitude_text,
    models_page,
    recommendation_table,
)
from squeezefilm_workflow.reporting.pages import render_template, write_page


def main(snakemake: Job, config: Study) -> None:
    results, output = results_of_job(snakemake, config), snakemake.output
    paths = zip(output.tables, output.errors, output.pages, strict=True)
    for space, (table, errors, path) in zip(snakemake.params.spaces, paths, strict=True):
        page = models_page(results, space=space)
        write_outputs({"table": table, "errors": errors}, **page.file_contents)
        text = render_template("models.md", **page.template_values)
        write_page(text, path, folder=results.folder, beyond=results.validity_note)
    recommended = recommendation_table(results)
    write_table(recommended, output.recommended)
    if reason := missing_amplitude_text(recommended):
        print_result(f"note: {reason}")


if __name__ == "__main__":
    run_script(main, globals()["snakemake"])
