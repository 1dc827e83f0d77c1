"""Make a smooth profile of the study's scan, once for all that read it."""

from pathlib import Path

from scripts.job import begin_with_study
from squeezefilm.film.measured.smooth import write_smoothed

snakemake, config = begin_with_study()
smoothed = config.smoothed_scan(again=True)
assert smoothed is not None
write_smoothed(smoothed, Path(snakemake.output[0]), **config.smoothing)
print(*smoothed.warnings, sep="\n")
