"""Write the scenes of a plan."""

from squeezefilm.studies.plans import write_scenes
from squeezefilm_workflow.job import Job, Study, run_script


def main(snakemake: Job, config: Study) -> None:
    plan = snakemake.wildcards.plan
    write_scenes(plan, config, sources=snakemake.input.sources, output=snakemake.output[0])


if __name__ == "__main__":
    run_script(main, globals()["snakemake"])
