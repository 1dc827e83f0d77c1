"""Results of a study, for scripts that show them."""

from squeezefilm_workflow.job import Job, Study, folder_of_results
from squeezefilm_workflow.reporting.results import Results


def results_of(snakemake: Job, config: Study) -> Results:
    """The results of the study that a job belongs to."""
    return Results(folder_of_results(snakemake, config), config)
