"""Compile the kernels of the study and write which device they are for."""

from squeezefilm.api.forces import compile_kernels
from squeezefilm.files import write_json
from squeezefilm_workflow.job import Job, Study, run_script


def main(snakemake: Job, config: Study) -> None:
    write_json(compile_kernels(config), snakemake.output[0])


if __name__ == "__main__":
    run_script(main, globals()["snakemake"])
