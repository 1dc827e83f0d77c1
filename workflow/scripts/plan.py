"""Write the scenes of a plan."""

from scripts.job import begin_with_study
from squeezefilm.studies.plans import write_scenes

snakemake, config = begin_with_study()
plan = snakemake.wildcards.plan
write_scenes(plan, config, sources=snakemake.input.sources, output=snakemake.output[0])
