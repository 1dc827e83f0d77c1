"""Write the explorer: one HTML file in which the fitted models can be played with."""

from pathlib import Path

from plotly.offline import get_plotlyjs

from reporting.explorer import explorer_page
from reporting.results import Results
from scripts.job import begin_with_study
from squeezefilm.files import write_text

snakemake, config = begin_with_study()
params = snakemake.params
results = Results(Path(params.results), config)
page = explorer_page(
    results,
    fits=params.fits,
    candidates=params.candidates,
    forces={plan: results.forces(plan) for plan in params.plans},
    drawing_library=get_plotlyjs(),
)
write_text(page, snakemake.output[0])
