"""Search the paper's D-optimal points of a fitted model, for two factors or for four."""

from squeezefilm.errors import prefix_errors
from squeezefilm.models.fit_file import read_fit
from squeezefilm.studies.tasks.paper_designs import four_factor_designs, two_factor_designs
from squeezefilm_workflow.job import Job, Study, run_script, write_outputs


def main(snakemake: Job, config: Study) -> None:
    fit = read_fit(snakemake.input.fit)
    designs_of = {"two_factor": two_factor_designs, "four_factor": four_factor_designs}[fit.model]
    with prefix_errors(snakemake.input.fit):
        write_outputs(snakemake.output, **designs_of(fit, config, processes=snakemake.threads))


if __name__ == "__main__":
    run_script(main, globals()["snakemake"])
