"""Write a table of the asymptotic forces over the study's space, or why there is none."""

from scripts.job import begin_with_study
from squeezefilm.studies.tasks.fits import limit_table_values
from squeezefilm.tables import write_json

snakemake, config = begin_with_study()
write_json(limit_table_values(config), snakemake.output[0])
