"""Write the residuals of a smooth profile of a scan, and the errors of its forces."""

from scripts.job import begin_with_study, write
from squeezefilm.studies.tasks.scan_errors import scan_report

snakemake, config = begin_with_study()
forces, profile, summary, text = scan_report(config)
write(snakemake.output, forces=forces, figure=profile, summary=summary)
print(text)
