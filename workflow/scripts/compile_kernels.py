"""Compile the kernels of the study and write which device they are for."""

from scripts.job import begin
from squeezefilm.api.simulation import compile_kernels
from squeezefilm.config.loading import load_config
from squeezefilm.tables import write_json

snakemake = begin()
config = load_config(snakemake.config["study_file"])
write_json(compile_kernels(config), snakemake.output[0])
