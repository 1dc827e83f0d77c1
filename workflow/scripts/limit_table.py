"""Write a table of the physics limits over the study's space, or why there is none."""

from scripts.job import begin
from squeezefilm.config.loading import load_config
from squeezefilm.io.tables import write_json
from squeezefilm.studies.tasks.fits import limit_table_values

snakemake = begin()
config = load_config(snakemake.config["study_file"])
write_json(limit_table_values(config), snakemake.output[0])
