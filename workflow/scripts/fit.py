"""Fit models to the forces of a plan; why a candidate cannot be fitted is written in its place."""

from pathlib import Path
from typing import Any

from squeezefilm.errors import InputError
from squeezefilm.files import file_digest, read_json, write_json
from squeezefilm.models.data import PHYSICS_COLUMN_OF_NAME
from squeezefilm.models.force_model import get_model
from squeezefilm.studies.tasks.fits import (
    asymptotic_forces_of_table,
    fit_to_forces,
    profile_uncertainty_fraction,
)
from squeezefilm.table_writer import write_table
from squeezefilm.tables import read_forces, read_ok_forces
from squeezefilm_workflow.job import Job, Study, run_script


def main(snakemake: Job, config: Study) -> None:
    files, output, params = snakemake.input, snakemake.output, snakemake.params
    given: dict[str, Any] = {
        "forces": read_ok_forces(files.forces),
        "sample": read_forces(files.sample),
    }
    # Only candidates may use what physics says of the points.
    candidates = output.get("limits")
    if candidates:
        for (name, points), path in zip([*given.items()], candidates, strict=True):
            limits = asymptotic_forces_of_table(points, config)
            write_table(limits, path)
            known = [*PHYSICS_COLUMN_OF_NAME.values()]
            # Every force here has the status `ok`: a missing limit has a reason to be named.
            known += ["status"] if name == "forces" else []
            given[name] = points.assign(**limits[known])
        given |= {"limit_table": read_json(files.limit_table)}
    uncertainty = profile_uncertainty_fraction(config, summary=files.scan)
    source = {"forces_sha256": file_digest(Path(files.forces))}
    for name, path in zip(params.models, output.fits, strict=True):
        model = get_model(name, config.models, source=config.path)
        try:
            fit, runs = fit_to_forces(
                model,
                config,
                **given,
                uncertainty=uncertainty,
                seeds=params.seeds,
                processes=snakemake.threads,
                source=source,
            )
        except InputError as error:
            if not candidates:
                raise InputError(f"{files.forces}: {error}") from None
            write_json({"model": name, "not_supported": str(error)}, path)
            print(f"{name}: {error}")
        else:
            write_json(fit.to_dict(), path)
            print(f"{name}: {fit.statement}")
            if not candidates:
                write_table(runs, output.runs)


if __name__ == "__main__":
    run_script(main, globals()["snakemake"])
