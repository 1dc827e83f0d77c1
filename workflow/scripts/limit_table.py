"""Write a table of the physics limits over the study's space, or why there is none."""

from scripts.job import begin
from squeezefilm.config.loading import load_config
from squeezefilm.studies.tasks.fits import limit_table_values
from squeezefilm.tables import write_json

snakemake = begin()
config = load_config(snakemake.config["study_file"])
write_json(limit_table_values(config), snakemake.output[0])
