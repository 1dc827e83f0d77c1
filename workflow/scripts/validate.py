"""Write the errors of a fit on sets of simulated forces, point by point and in all."""

from scripts.job import begin_with_study
from squeezefilm.errors import naming
from squeezefilm.models.fit_file import read_fit
from squeezefilm.studies.tasks.fits import errors_on
from squeezefilm.tables import read_ok_forces, write_json, write_table

snakemake, config = begin_with_study()
files, output = snakemake.input, snakemake.output
fit, band = read_fit(files.fit), config["validation"]["relative_error_band"]
for forces, errors, summary in zip(files.forces, output.errors, output.summary, strict=True):
    with naming(f"{files.fit} on {forces}"):
        table, about = errors_on(fit, read_ok_forces(forces), band=band)
    write_table(table, errors)
    write_json(about, summary)
