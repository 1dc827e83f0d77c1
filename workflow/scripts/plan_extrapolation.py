"""Write the scenes that check an extrapolation beyond the points of the fits."""

from pathlib import Path

from scripts.job import begin
from squeezefilm.io.tables import write_table
from squeezefilm.models.fitted import read_fit
from squeezefilm.studies.config import load_config
from squeezefilm.studies.simulation import extrapolation_scenes

snakemake = begin()
config = load_config(snakemake.config["study_file"])
fits = {Path(path).stem: read_fit(path) for path in snakemake.input.fits}
write_table(extrapolation_scenes(config, fits), snakemake.output[0])
