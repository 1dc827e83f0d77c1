"""Write what the film equation leaves out of the forces of a plan."""

from scripts.job import begin_with_study
from squeezefilm.api.forces import budget_table
from squeezefilm.tables import read_scenes, write_table

snakemake, config = begin_with_study()
write_table(budget_table(read_scenes(snakemake.input.scenes), config), snakemake.output[0])
