"""Write published numbers beside exact solutions and the solver."""

from squeezefilm.studies.solver_settings import device_of_config
from squeezefilm.table_writer import write_table
from squeezefilm_workflow.job import Job, Study, run_script
from squeezefilm_workflow.verification.published.comparison import comparison_table


def main(snakemake: Job, config: Study) -> None:
    sample = config.numerics.extent != "full"
    write_table(
        comparison_table(sample=sample, device=device_of_config(config)), snakemake.output[0]
    )


if __name__ == "__main__":
    run_script(main, globals()["snakemake"])
