"""Simulate, fit, validate, design, simulate …, until a model meets its targets or cannot."""

from squeezefilm.models.force_model import get_model
from squeezefilm.studies.tasks.fits import profile_uncertainty_fraction
from squeezefilm.studies.tasks.refined_model import refine
from squeezefilm.tables import read_forces
from squeezefilm_workflow.job import Job, Study, run_script, write_outputs


def main(snakemake: Job, config: Study) -> None:
    files = snakemake.input
    tables, fit, verdict = refine(
        get_model(snakemake.wildcards.model, config.models, source=config.path),
        config,
        space=snakemake.wildcards.space,
        sample=read_forces(files.sample),
        uncertainty=profile_uncertainty_fraction(config, summary=files.scan),
    )
    write_outputs(snakemake.output, **tables, fit=fit, verdict=verdict)


if __name__ == "__main__":
    run_script(main, globals()["snakemake"])
