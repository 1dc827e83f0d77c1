"""Write how far each assumption would have to move to explain the differences from the paper."""

from paper.uncertainty import compare, shown
from reporting.pages import render, write_pages
from scripts.job import begin_with_study
from squeezefilm.film.scene import Scene
from squeezefilm.reynolds import solve
from squeezefilm.studies.solver_settings import device_of, solver_settings
from squeezefilm.tables import write_table

snakemake, config = begin_with_study()
settings, device = solver_settings(config, outputs=()), device_of(config)


def force(scene: Scene) -> float:
    """The force of a scene."""
    [solution] = solve(settings.resolved([scene], device), **settings.how(device))
    return solution.force_n


table, curves = compare(config, force=force)
explaining = (table["verdict"] == "explains").groupby(table["claim"], sort=False).sum()
write_table(table, snakemake.output.csv)
write_table(curves, snakemake.output.curves)
text = render("uncertainty.md", explaining=explaining, shown=shown(table))
write_pages(text, snakemake.output.markdown, snakemake.output.page)
