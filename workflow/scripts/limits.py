"""Write the physics limit of each scene of a plan: no solving in time, nothing fitted."""

from scripts.job import begin
from squeezefilm.config.loading import load_config
from squeezefilm.studies.tasks.fits import limits_of
from squeezefilm.tables import read_scenes, write_table

snakemake = begin()
config = load_config(snakemake.config["study_file"])
write_table(limits_of(read_scenes(snakemake.input.scenes), config), snakemake.output[0])
