"""Write the scenes of a plan."""

from scripts.job import begin
from squeezefilm.config.loading import load_config
from squeezefilm.studies.plan_scenes import write_scenes

snakemake = begin()
config = load_config(snakemake.config["study_file"])
plan = snakemake.wildcards.plan
write_scenes(plan, config, sources=snakemake.input.sources, output=snakemake.output[0])
