"""Write a table of the asymptotic forces over the study's space, or why there is none."""

from squeezefilm.files import write_json
from squeezefilm.studies.tasks.fits import limit_table_values
from squeezefilm_workflow.job import Job, Study, run_script


def main(snakemake: Job, config: Study) -> None:
    write_json(limit_table_values(config), snakemake.output[0])


if __name__ == "__main__":
    run_script(main, globals()["snakemake"])
