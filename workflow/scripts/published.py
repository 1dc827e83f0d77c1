"""Write published numbers beside exact solutions and the solver."""

from squeezefilm.studies.solver_settings import device_of
from squeezefilm.tables import write_table
from squeezefilm_workflow.job import Job, Study, run
from squeezefilm_workflow.verification.published.comparison import published


def main(snakemake: Job, config: Study) -> None:
    sample = config.numerics.extent != "full"
    write_table(published(sample=sample, device=device_of(config)), snakemake.output[0])


if __name__ == "__main__":
    run(main, globals()["snakemake"])
