"""From the results to the one tidy table that a figure is drawn from: a module per figure.

A module of this package that is named after a figure has

- ``INPUTS``: the names of the tables it is built from;
- ``SECTIONS``: the sections of the configuration it reads;
- ``build(inputs, config)``: the table, given the paths by name and the configuration.
"""

from __future__ import annotations

from types import ModuleType

from reporting.figures import FIGURES, room
from squeezefilm.io.errors import InputError


def figure_data_module(name: str) -> ModuleType:
    """The module that builds a figure's table.

    Raises:
        InputError: for a name that is no figure.
    """
    if name.rpartition(".")[2] not in FIGURES:
        raise InputError(f"there is no figure {name!r}; the figures are {', '.join(FIGURES)}")
    return room("figure_data", name)
