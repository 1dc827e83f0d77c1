"""Compile the kernels of the study and write which device they are for."""

from scripts.job import begin_with_study
from squeezefilm.api.forces import compile_kernels
from squeezefilm.tables import write_json

snakemake, config = begin_with_study()
write_json(compile_kernels(config), snakemake.output[0])
