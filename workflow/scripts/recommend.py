"""Write the best model of each space, and the amplitude that it needs at each position."""

from pathlib import Path

from reporting.models import recommend
from reporting.results import Results
from scripts.job import begin
from squeezefilm.io.tables import write_table
from squeezefilm.studies.config import load_config

snakemake = begin()
config = load_config(snakemake.config["study_file"])
write_table(recommend(Results(Path(snakemake.params.results), config)), snakemake.output[0])
