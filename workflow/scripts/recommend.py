"""Write the best model of each space, and the amplitude that it needs at each position."""

from reporting.models import recommend
from scripts.finished import begin_with_results
from squeezefilm.tables import write_table

snakemake, results = begin_with_results()
write_table(recommend(results), snakemake.output[0])
