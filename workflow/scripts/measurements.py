"""Write measured forces beside computed ones, and what the differences are worth."""

from squeezefilm.api.measurements import compare_measurements, summary_of
from squeezefilm_workflow.job import Job, Study, run, write


def main(snakemake: Job, config: Study) -> None:
    table = compare_measurements(config)
    write(snakemake.output, comparison=table, summary=summary_of(table))


if __name__ == "__main__":
    run(main, globals()["snakemake"])
