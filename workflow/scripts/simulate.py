"""Simulate one of the parts of a plan; every scene keeps its row."""

from scripts.job import begin_with_study
from squeezefilm.api.forces import simulate_table
from squeezefilm.studies.solver_settings import solver_settings

snakemake, config = begin_with_study()
failures, _ = simulate_table(
    snakemake.input.scenes,
    config,
    settings=solver_settings(config),
    output=snakemake.output.forces,
    timings=snakemake.output.timings,
    chunk=(int(snakemake.wildcards.chunk), int(snakemake.wildcards.chunks)),
)
print(*failures, sep="\n")
