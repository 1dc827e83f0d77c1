"""Write error against run time of the solver and of other methods."""

import numpy as np

from squeezefilm.models.fit_file import read_fit
from squeezefilm.studies.solver_settings import device_of_config
from squeezefilm.table_writer import write_table
from squeezefilm_workflow.job import Job, Study, run_script
from squeezefilm_workflow.verification.work_precision import TIMED_FILMS, work_precision_table

SCENES_PER_BATCH = 100


def main(snakemake: Job, config: Study) -> None:
    settings, device = config.numerics, device_of_config(config)
    full = settings.extent == "full"
    table = work_precision_table(
        TIMED_FILMS if full else (TIMED_FILMS[1], TIMED_FILMS[4]),
        repeats=settings.repeats,
        batch=SCENES_PER_BATCH,
        longest_seconds=settings.longest_seconds,
        rungs=10 if full else 3,
        device=device,
    )
    # Where a solver's error no longer matters: the model is fitted to films without effects.
    model_error = read_fit(snakemake.input.fit).global_error
    plain = table["terms"] == table["terms"].iloc[0]
    table = table.assign(model_error=np.where(plain, model_error, np.nan), device=device.name)
    write_table(table, snakemake.output[0])


if __name__ == "__main__":
    run_script(main, globals()["snakemake"])
