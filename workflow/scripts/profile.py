"""Write the residuals of a smooth profile of a scan, and the errors of its forces."""

from squeezefilm.studies.tasks.scan_errors import scan_report
from squeezefilm_workflow.job import (
    Job,
    Study,
    print_result,
    run_script,
    show_progress_on_terminal,
    write_outputs,
)


def main(snakemake: Job, config: Study) -> None:
    with show_progress_on_terminal("profile"):
        forces, profile, summary, text = scan_report(config)
    write_outputs(snakemake.output, forces=forces, figure=profile, summary=summary)
    print_result(text)


if __name__ == "__main__":
    run_script(main, globals()["snakemake"])
