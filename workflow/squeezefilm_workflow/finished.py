"""What a study found, for scripts that show it."""

from reporting.results import Results
from squeezefilm_workflow.job import Job, Study, folder_of_results


def results_of(snakemake: Job, config: Study) -> Results:
    """The results of the study that a job belongs to."""
    return Results(folder_of_results(snakemake, config), config)
