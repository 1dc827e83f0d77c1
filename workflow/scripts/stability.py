"""Write a verdict for each stiff or extreme film: solved, not supported or failed."""

from squeezefilm.studies.solver_settings import device_of_config
from squeezefilm.table_writer import write_table
from squeezefilm_workflow.job import Job, Study, run_script
from squeezefilm_workflow.verification.films import CASE_SAMPLE_SLICE, cases_with_groups
from squeezefilm_workflow.verification.stability import raise_if_film_failed, stability_table


def main(snakemake: Job, config: Study) -> None:
    chosen = (
        cases_with_groups()
        if config.numerics.extent == "full"
        else cases_with_groups()[CASE_SAMPLE_SLICE]
    )
    table = stability_table(chosen, device=device_of_config(config))
    write_table(table, snakemake.output[0])
    raise_if_film_failed(table)


if __name__ == "__main__":
    run_script(main, globals()["snakemake"])
