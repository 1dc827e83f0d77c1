"""Write the best model of each space, and the amplitude that it needs at each position."""

from squeezefilm.table_writer import write_table
from squeezefilm_workflow.finished import results_of_job
from squeezefilm_workflow.job import Job, Study, print_result, run_script
from squeezefilm_workflow.reporting.models import missing_amplitude_text, recommendation_table


def main(snakemake: Job, config: Study) -> None:
    table = recommendation_table(results_of_job(snakemake, config))
    write_table(table, snakemake.output[0])
    if reason := missing_amplitude_text(table):
        print_result(f"note: {reason}")


if __name__ == "__main__":
    run_script(main, globals()["snakemake"])
