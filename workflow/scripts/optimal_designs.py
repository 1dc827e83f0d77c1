"""Write certified D-optimal designs of a fit, and the efficiency of other plans beside them."""

from pathlib import Path

from squeezefilm.errors import prefix_errors
from squeezefilm.files import read_json
from squeezefilm.models.fit_file import read_fit
from squeezefilm.studies.tasks.optimal_designs import designs_of_fit
from squeezefilm.tables import read_ok_forces, read_scenes
from squeezefilm_workflow.job import (
    Job,
    Study,
    run_script,
    show_progress_on_terminal,
    write_outputs,
)


def main(snakemake: Job, config: Study) -> None:
    files = snakemake.input
    with prefix_errors(files.fit), show_progress_on_terminal("optimal designs"):
        designs = designs_of_fit(
            read_fit(files.fit),
            config,
            forces=read_ok_forces(files.forces),
            existing=read_scenes(files.existing),
            plans={Path(path).parent.name: read_scenes(path) for path in files.plans},
            patterns=read_json(files.patterns),
        )
    write_outputs(snakemake.output, **designs)


if __name__ == "__main__":
    run_script(main, globals()["snakemake"])
