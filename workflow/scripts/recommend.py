"""Write the best model of each space, and the amplitude that it needs at each position."""

from squeezefilm.tables import write_table
from squeezefilm_workflow.finished import results_of_job
from squeezefilm_workflow.job import Job, Study, run_script
from squeezefilm_workflow.reporting.models import recommendation_table


def main(snakemake: Job, config: Study) -> None:
    results = results_of_job(snakemake, config)
    write_table(recommendation_table(results), snakemake.output[0])


if __name__ == "__main__":
    run_script(main, globals()["snakemake"])
