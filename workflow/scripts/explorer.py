"""Write the explorer: one HTML file in which the fitted models can be played with."""

from plotly.offline import get_plotlyjs

from reporting.explorer import explorer_page
from scripts.finished import begin_with_results
from squeezefilm.files import write_text

snakemake, results = begin_with_results()
params = snakemake.params
page = explorer_page(
    results,
    fits=params.fits,
    candidates=params.candidates,
    forces={plan: results.forces(plan) for plan in params.plans},
    drawing_library=get_plotlyjs(),
)
write_text(page, snakemake.output[0])
