"""The start of a script that shows what a study found."""

from pathlib import Path
from typing import Any

from reporting.results import Results
from scripts.job import begin_with_study


def begin_with_results() -> tuple[Any, Results]:
    """Begin a script; the job, and the results of the study that it belongs to."""
    job, config = begin_with_study()
    return job, Results(Path(job.params.results), config)
