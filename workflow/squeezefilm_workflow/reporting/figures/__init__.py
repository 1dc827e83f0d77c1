"""The figures: each a function of a study's results, from which it draws, by its place there.

A function returns the figure and, where that is a product too, the table that is drawn;
column names carry the unit that the axis shows. A page of figures is drawn by one job.
"""

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

import pandas as pd
from matplotlib.figure import Figure

from squeezefilm.errors import InputError
from squeezefilm.table_writer import write_table
from squeezefilm_workflow.reporting.figures import style
from squeezefilm_workflow.reporting.figures.film import error_budget, levitation, response
from squeezefilm_workflow.reporting.figures.maps import (
    amplitudes,
    error_map,
    forces,
    profile,
    vibration,
)
from squeezefilm_workflow.reporting.figures.measurements import measurements
from squeezefilm_workflow.reporting.figures.models import (
    design,
    fitted_model,
    model_errors_figure,
    refinement_figure,
    sensitivity_figure,
)
from squeezefilm_workflow.reporting.figures.overview import overview
from squeezefilm_workflow.reporting.figures.verification import published, stability, work_precision
from squeezefilm_workflow.reporting.results import Results

DrawFunction = Callable[[Results], Figure | tuple[Figure, pd.DataFrame]]

FIGURES: dict[str, DrawFunction] = {
    f"figures/{function.__name__}": function
    for function in (
        *(overview, vibration, profile, forces, fitted_model, design, error_map, amplitudes),
        *(error_budget, response, levitation, measurements),
    )
}
FIGURES |= {
    f"numerics/{function.__name__}": function for function in (work_precision, stability, published)
}
for _space in ("two_factor", "four_factor"):
    FIGURES[f"models/{_space}_errors"] = partial(model_errors_figure, space=_space)
    FIGURES[f"designs/optimal_{_space}_sensitivity"] = partial(sensitivity_figure, space=_space)
    FIGURES[f"refine/{_space}_figure"] = partial(refinement_figure, space=_space)


def draw_and_save(function: DrawFunction, results: Results, paths: Sequence[Path]) -> None:
    """Draw a figure and save it under each name.

    ``.csv`` is the table that it draws, ``.plain.png`` a small picture without texts, for the
    check; all others are the figure in the format that the name ends in.

    Raises InputError naming the result that is missing or lacks what it must have, or a table that
    the figure has not.
    """
    plain = [path for path in paths if path.name.endswith(style.PLAIN_PICTURE_SUFFIX)]
    tables = [path for path in paths if path.suffix == ".csv"]
    own = results.config.figures.style
    with style.figure_style(file=results.config.path.parent / own if own else None):
        figure, table = _drawn_figure(function, results)
        style.save_figure(figure, [path for path in paths if path not in (*plain, *tables)])
    for path in tables:
        if table is None:
            raise InputError(f"{path}: a table is drawn by the paper's numbered figures alone")
        write_table(table, path)
    if plain:
        with style.figure_style(notes=False):
            style.save_without_text(_drawn_figure(function, results)[0], plain)


def _drawn_figure(function: DrawFunction, results: Results) -> tuple[Figure, pd.DataFrame | None]:
    drawn = function(results)
    return drawn if isinstance(drawn, tuple) else (drawn, None)
