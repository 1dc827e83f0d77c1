"""Simulate a plan, whose scenes are written first, or a part of one; every scene keeps its row."""

from squeezefilm.api.film import Film
from squeezefilm.api.forces import simulate_table
from squeezefilm.errors import RunError
from squeezefilm.studies.plans import write_scenes
from squeezefilm.tables import no_force_message
from squeezefilm_workflow.job import Job, Study, run_script


def main(snakemake: Job, config: Study) -> None:
    wildcards, output = snakemake.wildcards, snakemake.output
    scenes = output.get("scenes")
    if scenes:
        write_scenes(wildcards.plan, config, sources=snakemake.input.sources, output=scenes)
    failures, _ = simulate_table(
        scenes or snakemake.input.scenes,
        Film(config),
        output=output.forces,
        timings=output.timings,
        chunk=(int(wildcards.get("chunk", 1)), int(wildcards.get("chunks", 1))),
    )
    if scenes and failures and not snakemake.params.keep_failed:
        raise RunError(no_force_message(failures, wildcards.plan))
    print(*failures, sep="\n")


if __name__ == "__main__":
    run_script(main, globals()["snakemake"])
