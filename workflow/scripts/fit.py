"""Fit one of the paper's models to the forces of a plan."""

from pathlib import Path

from scripts.job import begin_with_study
from squeezefilm.errors import naming
from squeezefilm.files import digest
from squeezefilm.models.force_model import get_model
from squeezefilm.studies.tasks.fits import fit_to_forces, profile_uncertainty
from squeezefilm.tables import read_forces, read_ok_forces, write_json, write_table

snakemake, config = begin_with_study()
files = snakemake.input
with naming(files.forces):
    fit, runs = fit_to_forces(
        get_model(snakemake.params.model, config["models"], place=config.path),
        config,
        forces=read_ok_forces(files.forces),
        sample=read_forces(files.sample),
        uncertainty=profile_uncertainty(config, summary=files.scan),
        processes=snakemake.threads,
        source={"forces_sha256": digest(Path(files.forces))},
    )
write_json(fit.to_dict(), snakemake.output.fit)
write_table(runs, snakemake.output.runs)
print(fit.statement)
