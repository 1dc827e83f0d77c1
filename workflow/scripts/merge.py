"""Put the parts of a simulated plan together: every point of the plan has its force."""

from squeezefilm.table_writer import concatenate_force_parts, merge_timings
from squeezefilm_workflow.job import Job, Study, run_script


def main(snakemake: Job, config: Study) -> None:
    concatenate_force_parts(
        snakemake.input.scenes,
        snakemake.input.forces,
        output=snakemake.output.forces,
        keep_failed=snakemake.params.keep_failed,
    )
    merge_timings(snakemake.input.timings, output=snakemake.output.timings)


if __name__ == "__main__":
    run_script(main, globals()["snakemake"])
