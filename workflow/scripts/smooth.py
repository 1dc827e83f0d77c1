"""Make a smooth profile of the study's scan, once for all that read it."""

from pathlib import Path

from squeezefilm.film.measured.smoothed_file import write_smoothed_scan
from squeezefilm_workflow.job import Job, Study, run_script


def main(snakemake: Job, config: Study) -> None:
    smoothed = config.smoothed_scan(again=True)
    assert smoothed is not None
    write_smoothed_scan(smoothed, Path(snakemake.output[0]), **config.smoothing_arguments)
    print(*smoothed.warnings, sep="\n")


if __name__ == "__main__":
    run_script(main, globals()["snakemake"])
