"""The figures: a module each, found by being here or in ``figures`` of a package above.

A figure is one room. Its module says in plain literals, which the workflow reads without importing
matplotlib or anything else (``reporting.rooms``):

- its docstring: a line ``Name: what it shows.``, and below it the caption for the report;
- ``INPUTS``: the files it is made from, by name, each with its place among a study's results.
  ``{space}`` in a place stands for a space of factors: there is such a figure for each;

and has

- ``build(inputs, config)``: the one tidy table that it is drawn from. A figure without it is drawn
  from its one input as it stands, the table of another stage;
- ``draw(data)``: the table drawn as a matplotlib Figure, from nothing else.

Column names carry the unit that the axis shows, so nothing is converted while drawing. ``layer``
says what a row is (a mesh of the model, simulated points, …); ``note`` is the text below. What
several figures share lies in ``parts``.
"""

import importlib
import importlib.metadata
from collections.abc import Sequence
from pathlib import Path
from types import ModuleType

from squeezefilm.io.errors import InputError
from squeezefilm.io.found import modules_in
from squeezefilm.io.sources import read_columns

ENTRY_POINTS = "squeezefilm.figures"
PLAIN = ".plain.png"
FORMATS = (".png", ".svg", ".pdf")
HELP = "fig05, overview, …; an unknown name is answered with all that there are"


def installed() -> dict[str, str]:
    """The dotted name of every figure's module by its own: ours, and those above by entry point."""
    above = sorted(point.value for point in importlib.metadata.entry_points(group=ENTRY_POINTS))
    packages = (modules_in(f"{package}.figures") for package in ("reporting", *above))
    return {name: module for found in packages for name, module in found.items()}


def figure_module(name: str) -> ModuleType:
    """The module of a figure, by its name or by the whole dotted one, ``paper.figures.fig08``.

    Rules give the whole name, so that they need no installation.
    Raises InputError for a name that is no figure's, or a module that cannot be loaded.
    """
    known = {} if "." in name else installed()
    if "." not in name and name not in known:
        raise InputError(f"there is no figure {name!r}; the figures are {', '.join(known)}")
    try:
        return importlib.import_module(known.get(name, name))
    except ModuleNotFoundError as error:
        raise InputError(f"the figure {name!r} cannot be loaded: {error}") from None


def check_formats(paths: Sequence[str]) -> None:
    """Refuse a file name that no drawing has."""
    for path in paths:
        if Path(path).suffix not in FORMATS:
            raise InputError(f"{path}: a figure's name ends in {', '.join(FORMATS)}")


def draw(module: ModuleType, table: Path | str, paths: Sequence[str], *, beyond: str = "") -> None:
    """Draw a figure's table as read back from its file, in the formats that the names ask for.

    ``beyond`` is added to its note. A name that ends in PLAIN is a small picture without texts,
    which a check compares.

    Raises InputError naming the table and what it lacks.
    """
    from reporting.figures.parts import style  # matplotlib: only when something is drawn

    data = read_columns(table, columns=("note",))
    if beyond:
        data = data.assign(note=data["note"].fillna("").astype(str) + f" {beyond}")
    without_text = [path for path in paths if path.endswith(PLAIN)]
    with style.settings():
        try:
            figure = module.draw(data)
            plain = module.draw(data.assign(note="")) if without_text else None
        except KeyError as error:
            raise InputError(f"{table}: not a table of this figure: no {error}") from None
        style.save(figure, [path for path in paths if path not in without_text])
        if plain:
            style.save_without_text(plain, without_text)
