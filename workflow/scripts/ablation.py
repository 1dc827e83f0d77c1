"""Write what leaving things out saves; the estimates of forces must cover their errors."""

import pandas as pd

from squeezefilm.errors import RunError
from squeezefilm.studies.solver_settings import device_of_config, solver_settings
from squeezefilm.studies.study import scenes_of_table
from squeezefilm.table_writer import write_table
from squeezefilm.tables import read_scenes
from squeezefilm_workflow.job import Job, Study, run_script
from squeezefilm_workflow.verification.ablation import ablation_table

FORCE_TOLERANCES = (1e-2, 1e-4, 1e-6)


def main(snakemake: Job, config: Study) -> None:
    device, repeats = device_of_config(config), config.numerics.repeats
    points = pd.concat([read_scenes(path) for path in snakemake.input.scenes])
    settings = solver_settings(config, outputs=())
    scenes = settings.with_auto_terms_decided(scenes_of_table(points, config))
    table = ablation_table(scenes, tolerances=FORCE_TOLERANCES, repeats=repeats, device=device)
    write_table(table.assign(repeats=repeats, device=device.name), snakemake.output[0])
    print(table.to_string(index=False))
    # The promise to a user: no error above the tolerance, and estimates honest in 99 %.
    judged = table[table["coverage"].notna()]
    wrong = judged[(judged["worst_error"] > judged["tolerance"]) | (judged["coverage"] < 0.99)]
    if len(wrong):
        names = ", ".join(f"{row.re_enabled} at {row.tolerance:g}" for row in wrong.itertuples())
        raise RunError(f"error above the tolerance, or estimates that do not cover it: {names}")


if __name__ == "__main__":
    run_script(main, globals()["snakemake"])
