"""Write the explorer: one HTML file in which the fitted models can be played with."""

from plotly.offline import get_plotlyjs

from squeezefilm.files import write_text
from squeezefilm_workflow.finished import results_of_job
from squeezefilm_workflow.job import Job, Study, run_script
from squeezefilm_workflow.reporting.explorer import explorer_page


def main(snakemake: Job, config: Study) -> None:
    results = results_of_job(snakemake, config)
    params = snakemake.params
    page = explorer_page(
        results,
        fits=params.fits,
        candidates=params.candidates,
        forces={plan: results.forces(plan) for plan in params.plans},
        drawing_library=get_plotlyjs(),
    )
    write_text(page, snakemake.output[0])


if __name__ == "__main__":
    run_script(main, globals()["snakemake"])
