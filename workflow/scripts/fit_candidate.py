"""Fit a candidate for the force model, or write why it cannot be fitted."""

from pathlib import Path

from scripts.job import begin_with_study
from squeezefilm.errors import InputError
from squeezefilm.files import digest
from squeezefilm.models.force_model import get_model
from squeezefilm.studies.tasks.fits import fit_to_forces, profile_uncertainty
from squeezefilm.tables import read_forces, read_json, read_ok_forces, write_json

snakemake, config = begin_with_study()
files = snakemake.input
model = get_model(snakemake.wildcards.model, config["models"], place=config.path)
uncertainty = profile_uncertainty(config, summary=files.scan)
try:
    fit, _ = fit_to_forces(
        model,
        config,
        forces=read_ok_forces(files.forces),
        limits=files.limits,
        limit_table=read_json(files.limit_table),
        sample=read_forces(files.sample),
        sample_limits=files.sample_limits,
        uncertainty=uncertainty,
        seeds=1,
        source={"forces_sha256": digest(Path(files.forces))},
    )
    values = fit.to_dict()
except InputError as error:
    values = {"model": model.name, "refused": str(error)}
    print(error)
write_json(values, snakemake.output[0])
