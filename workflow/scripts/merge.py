"""Put the parts of a simulated plan together: every point of the plan has its force."""

from scripts.job import begin
from squeezefilm.tables import merge_forces, merge_timings

snakemake = begin()
merge_forces(
    snakemake.input.scenes,
    snakemake.input.forces,
    output=snakemake.output.forces,
    keep_failed=snakemake.params.keep_failed,
)
merge_timings(snakemake.input.timings, output=snakemake.output.timings)
