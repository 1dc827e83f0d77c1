"""Write the scenes of a plan."""

from scripts.job import begin
from squeezefilm.io.tables import read_design, table_writer
from squeezefilm.studies.config import load_config
from squeezefilm.studies.simulation import scenes_of

snakemake = begin()
config = load_config(snakemake.config["study_file"])
design = read_design(snakemake.input.design) if snakemake.input.design else None
with table_writer(snakemake.output[0]) as write:
    for piece in scenes_of(snakemake.wildcards.plan, config, design=design):
        write(piece)
