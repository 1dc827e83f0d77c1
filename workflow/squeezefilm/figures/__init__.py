"""The figures: each module draws one from its one tidy table, and knows nothing else.

A module of this package that is named in FIGURES has

- ``COLUMNS``: the columns that its table must have;
- ``draw(data)``: the table drawn as a matplotlib Figure.

Column names carry the unit that the axis shows, so nothing is converted while drawing. ``layer``
says what a row is (a mesh of the model, simulated points, …); ``note`` is the text below.
"""

from __future__ import annotations

import importlib
from types import ModuleType

from squeezefilm.errors import InputError

FIGURES = (
    "fig05",
    "fig06",
    "fig07",
    "fig08",
    "fig09",
    "fig10",
    "fig11",
    "fig12",
    "fig13",
    "fig14",
    "fig15",
    "fig16",
    "error_map",
    "uncertainty",
    "overview",
)
# Those of the numerics stage, drawn from the tables that it makes.
NUMERICS = (
    "work_precision",
    "stability",
    "cost",
    "conditioning",
    "paper_signature",
    "left_out",
)
MODELS = ("model_errors",)
# Drawn by studies with a measured profile.
PROFILES = ("profile",)
# Those of designs and of the loop that refines a model.
DESIGNS = ("sensitivity", "refine")


def figure_module(name: str) -> ModuleType:
    """The module that draws a figure.

    Raises:
        InputError: for a name that is no figure.
    """
    known = (*FIGURES, *NUMERICS, *PROFILES, *MODELS, *DESIGNS)
    if name not in known:
        raise InputError(f"there is no figure {name!r}; the figures are {', '.join(known)}")
    return importlib.import_module(f"squeezefilm.figures.{name}")
