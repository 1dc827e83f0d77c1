"""Write the errors of fits on sets of simulated forces, point by point and in a summary."""

from itertools import product

from squeezefilm.errors import prefix_errors
from squeezefilm.files import write_json
from squeezefilm.models.fit_file import read_fit
from squeezefilm.studies.tasks.fits import errors_of_fit
from squeezefilm.table_writer import write_table
from squeezefilm.tables import read_ok_forces
from squeezefilm_workflow.job import Job, Study, run_script


def main(snakemake: Job, config: Study) -> None:
    files, output = snakemake.input, snakemake.output
    pairs = product(files.fits, files.forces)
    for (fit, forces), errors, summary in zip(pairs, output.errors, output.summary, strict=True):
        with prefix_errors(f"{fit} on {forces}"):
            table, about = errors_of_fit(read_fit(fit), read_ok_forces(forces), config)
        write_table(table, errors)
        write_json(about, summary)


if __name__ == "__main__":
    run_script(main, globals()["snakemake"])
