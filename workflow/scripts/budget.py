"""Write what the film equation leaves out of the forces of a plan."""

from scripts.job import begin
from squeezefilm.cli.use.budget import budget_table
from squeezefilm.config.loading import load_config
from squeezefilm.tables import read_scenes, write_table

snakemake = begin()
config = load_config(snakemake.config["study_file"])
write_table(budget_table(read_scenes(snakemake.input.scenes), config), snakemake.output[0])
