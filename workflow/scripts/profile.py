"""Write what a smooth profile leaves open of its scan, and of forces simulated with it."""

from scripts.job import begin_with_study
from squeezefilm.studies.tasks.scan_errors import scan_report
from squeezefilm.tables import write_json, write_table

snakemake, config = begin_with_study()
output = snakemake.output
forces, profile, summary, text = scan_report(config)
write_table(forces, output.forces)
write_table(profile, output.figure)
write_json(summary, output.summary)
print(text)
