"""Write the best model of each space, and the amplitude that it needs at each position."""

from pathlib import Path

from reporting.models import recommend
from reporting.results import Results
from scripts.job import begin_with_study
from squeezefilm.tables import write_table

snakemake, config = begin_with_study()
write_table(recommend(Results(Path(snakemake.params.results), config)), snakemake.output[0])
