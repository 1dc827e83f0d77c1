"""Write a verdict for each stiff or extreme film: solved, not supported or failed."""

from squeezefilm.studies.solver_settings import device_of
from squeezefilm.tables import write_table
from squeezefilm_workflow.job import Job, Study, run
from squeezefilm_workflow.verification.films import SAMPLE_OF_CASES, cases
from squeezefilm_workflow.verification.stability import raise_failed_films, stability


def main(snakemake: Job, config: Study) -> None:
    chosen = cases() if config.numerics.extent == "full" else cases()[SAMPLE_OF_CASES]
    table = stability(chosen, device=device_of(config))
    write_table(table, snakemake.output[0])
    raise_failed_films(table)


if __name__ == "__main__":
    run(main, globals()["snakemake"])
