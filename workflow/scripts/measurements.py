"""Write measured forces beside computed ones, and what the differences are worth."""

from scripts.job import begin_with_study
from squeezefilm.api.measurements import compare_measurements, summary_of
from squeezefilm.tables import write_json, write_table

snakemake, config = begin_with_study()
table = compare_measurements(config)
write_table(table, snakemake.output[0])
write_json(summary_of(table), snakemake.output[1])
