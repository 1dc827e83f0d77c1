"""Simulate, fit, judge, design, simulate …, until a model is good enough or cannot be."""

from scripts.job import begin_with_study
from squeezefilm.models.force_model import model_named
from squeezefilm.studies.tasks.fits import profile_uncertainty
from squeezefilm.studies.tasks.refined_model import refine
from squeezefilm.tables import read_forces, write_json, write_table

snakemake, config = begin_with_study()
files, output = snakemake.input, snakemake.output
tables, fit, verdict = refine(
    model_named(snakemake.wildcards.model, config["models"], place=config.path),
    config,
    space=snakemake.wildcards.space,
    sample=read_forces(files.sample),
    sample_limits=files.sample_limits,
    uncertainty=profile_uncertainty(config, summary=files.scan),
)
for name, table in tables.items():
    write_table(table, getattr(output, name))
write_json(fit, output.fit)
write_json(verdict, output.verdict)
