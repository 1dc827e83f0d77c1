"""Results of a study, for scripts that show them."""

from squeezefilm_workflow.job import Job, Study, results_folder
from squeezefilm_workflow.reporting.results import Results


def results_of_job(snakemake: Job, config: Study) -> Results:
    """The results of the study that a job belongs to."""
    return Results(results_folder(snakemake, config), config)
