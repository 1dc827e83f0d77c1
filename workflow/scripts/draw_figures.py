"""Draw figures: all that a rule has as its output."""

from collections import defaultdict
from pathlib import Path

from squeezefilm_workflow.finished import results_of_job
from squeezefilm_workflow.job import Job, Study, run_script
from squeezefilm_workflow.paper.figures import FIGURES as OF_THE_PAPER
from squeezefilm_workflow.reporting.figures import FIGURES, draw_and_save


def main(snakemake: Job, config: Study) -> None:
    results = results_of_job(snakemake, config)
    files = defaultdict(list)
    for file in map(Path, snakemake.output):
        files[f"{file.parent.name}/{file.name.partition('.')[0]}"].append(file)
    for figure_path, paths in files.items():
        draw_and_save((FIGURES | OF_THE_PAPER)[figure_path], results, paths)


if __name__ == "__main__":
    run_script(main, globals()["snakemake"])
