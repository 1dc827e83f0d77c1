"""Write what made the results of the study: code, packages, device, configuration."""

from scripts.job import begin_with_study
from squeezefilm.provenance import provenance
from squeezefilm.tables import read_json, write_json

snakemake, config = begin_with_study()
facts = provenance(config, device=read_json(snakemake.input[0]))
write_json(facts, snakemake.output[0])
