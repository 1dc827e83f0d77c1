"""Write what a smooth profile leaves open of its scan, and of forces simulated with it."""

from scripts.job import begin_with_study, write
from squeezefilm.studies.tasks.scan_errors import scan_report

snakemake, config = begin_with_study()
forces, profile, summary, text = scan_report(config)
write(snakemake.output, forces=forces, figure=profile, summary=summary)
print(text)
