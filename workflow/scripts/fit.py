"""Fit a model to the forces of a plan; why a candidate cannot be fitted is written in its place."""

from pathlib import Path

from scripts.job import begin_with_study, write
from squeezefilm.errors import InputError
from squeezefilm.files import digest
from squeezefilm.models.force_model import get_model
from squeezefilm.studies.tasks.fits import fit_to_forces, profile_uncertainty
from squeezefilm.tables import read_forces, read_json, read_ok_forces

snakemake, config = begin_with_study()
files, output, params = snakemake.input, snakemake.output, snakemake.params
model = get_model(params.model, config["models"], place=config.path)
# Only candidates may use what physics says of the points.
limits = {name: files[name] for name in ("limits", "sample_limits") if files.get(name)}
if limits:
    limits["limit_table"] = read_json(files.limit_table)
try:
    fit, runs = fit_to_forces(
        model,
        config,
        forces=read_ok_forces(files.forces),
        sample=read_forces(files.sample),
        uncertainty=profile_uncertainty(config, summary=files.scan),
        seeds=params.seeds,
        processes=snakemake.threads,
        source={"forces_sha256": digest(Path(files.forces))},
        **limits,
    )
except InputError as error:
    if not limits:
        raise InputError(f"{files.forces}: {error}") from None
    write(output, fit={"model": model.name, "refused": str(error)})
    print(error)
else:
    write(output, fit=fit.to_dict(), **({} if limits else {"runs": runs}))
    print(fit.statement)
