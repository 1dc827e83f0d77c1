"""Write measured forces beside computed ones, and what the differences are worth."""

from squeezefilm.api.measurements import chi_square_summary, compare_measurements
from squeezefilm_workflow.job import Job, Study, run_script, write_outputs


def main(snakemake: Job, config: Study) -> None:
    table = compare_measurements(config)
    write_outputs(snakemake.output, comparison=table, summary=chi_square_summary(table))


if __name__ == "__main__":
    run_script(main, globals()["snakemake"])
