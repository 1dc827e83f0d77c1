"""Write the scenes of a plan and simulate all of them."""

from scripts.job import begin_with_study
from squeezefilm.api.forces import no_force, simulate_table
from squeezefilm.errors import RunError
from squeezefilm.studies.plan_scenes import write_scenes
from squeezefilm.studies.solver_settings import solver_settings

snakemake, config = begin_with_study()
plan, output = snakemake.wildcards.plan, snakemake.output
write_scenes(plan, config, sources=snakemake.input.sources, output=output.scenes)
failures, _ = simulate_table(
    output.scenes,
    config,
    settings=solver_settings(config),
    output=output.forces,
    timings=output.timings,
)
if failures and not snakemake.params.keep_failed:
    raise RunError(no_force(failures, plan))
print(*failures, sep="\n")
