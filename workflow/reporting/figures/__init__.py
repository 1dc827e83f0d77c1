"""The figures: each module draws one from its one tidy table, and knows nothing else.

A module of this package that is named in FIGURES has

- ``COLUMNS``: the columns that its table must have;
- ``draw(data)``: the table drawn as a matplotlib Figure.

Column names carry the unit that the axis shows, so nothing is converted while drawing. ``layer``
says what a row is (a mesh of the model, simulated points, …); ``note`` is the text below.
"""

from __future__ import annotations

import importlib
import importlib.metadata
import importlib.util
from types import ModuleType

from squeezefilm.io.errors import InputError

ENTRY_POINTS = "squeezefilm.figures"

# Those of any study, the others are the paper's.
OWN = ("error_map", "overview")
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
    if name.rpartition(".")[2] not in known:
        raise InputError(f"there is no figure {name!r}; the figures are {', '.join(known)}")
    return room("figures", name)


def room(kind: str, name: str) -> ModuleType:
    """The module ``name`` of the packages that have figures: ours, and those above by entry point.

    ``kind`` is ``figures`` or ``figure_data``. Rules give the whole name, ``paper.figures.fig08``,
    so that they need no installation.

    Raises:
        InputError: for a name that no package has.
    """
    if "." in name:
        return importlib.import_module(name)
    above = sorted(point.value for point in importlib.metadata.entry_points(group=ENTRY_POINTS))
    for package in ("reporting", *above):
        if importlib.util.find_spec(f"{package}.{kind}.{name}"):
            return importlib.import_module(f"{package}.{kind}.{name}")
    raise InputError(f"no package that is installed here has a figure {name!r}")
