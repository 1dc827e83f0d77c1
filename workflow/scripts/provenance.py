"""Write what made the results of the study: code, packages, device, configuration."""

from scripts.job import begin
from squeezefilm.config.loading import load_config
from squeezefilm.provenance import provenance
from squeezefilm.tables import read_json, write_json

snakemake = begin()
config = load_config(snakemake.config["study_file"])
facts = provenance(config, device=read_json(snakemake.input[0]))
write_json(facts, snakemake.output[0])
