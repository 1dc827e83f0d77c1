"""Write published numbers beside exact solutions and the solver."""

from scripts.job import begin_with_study
from squeezefilm.studies.solver_settings import device_of
from squeezefilm.tables import write_table
from verification.published.comparison import published

snakemake, config = begin_with_study()
sample = config.numerics.extent != "full"
write_table(published(sample=sample, device=device_of(config)), snakemake.output[0])
