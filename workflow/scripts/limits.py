"""Write the physics limit of each scene of a plan: no solving in time, nothing fitted."""

from scripts.job import begin_with_study
from squeezefilm.studies.tasks.fits import limits_of
from squeezefilm.tables import read_scenes, write_table

snakemake, config = begin_with_study()
write_table(limits_of(read_scenes(snakemake.input.scenes), config), snakemake.output[0])
