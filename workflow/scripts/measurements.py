"""Write measured forces beside computed ones, and what the differences are worth."""

from scripts.job import begin_with_study, write
from squeezefilm.api.measurements import compare_measurements, summary_of

snakemake, config = begin_with_study()
table = compare_measurements(config)
write(snakemake.output, comparison=table, summary=summary_of(table))
