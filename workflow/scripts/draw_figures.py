"""Draw figures: all that a rule has as its output."""

from collections import defaultdict
from pathlib import Path

from paper.figures import FIGURES as OF_THE_PAPER
from reporting.figures import FIGURES, save
from scripts.finished import begin_with_results

snakemake, results = begin_with_results()
files = defaultdict(list)
for file in map(Path, snakemake.output):
    files[f"{file.parent.name}/{file.name.partition('.')[0]}"].append(file)
for place, paths in files.items():
    save((FIGURES | OF_THE_PAPER)[place], results, paths)
