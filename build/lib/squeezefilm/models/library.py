"""The models of a study: those of the library, and its own."""

from collections.abc import Mapping
from itertools import product
from typing import Any

from squeezefilm.io.errors import InputError, naming
from squeezefilm.models.force_model import ExpressionModel, library, make_model

SPACES = ("two_factor", "four_factor")
"""Where models are compared: the finger centred, or anywhere."""
NAMING = ("comparison", "refine")
"""The sections of a study that name models for each space."""


def model_named(name: str, own: Mapping[str, Any], *, place: object) -> ExpressionModel:
    """A model by its name; ``two-factor`` is ``two_factor``.

    ``own`` is the section ``models`` of a study's configuration, ``place`` the file for messages.
    Raises InputError for an unknown name, and where one of the study's own is refused.
    """
    name = name.replace("-", "_")
    if name in own:
        return make_model(name, own[name], place=f"{place}: models.{name}")
    if name in library():
        return library()[name]
    known = ", ".join((*own, *library()))
    raise InputError(f"model {name!r} is unknown; known are {known}")


def check_models(own: Mapping[str, Any], named: Mapping[str, Any], *, place: object) -> None:
    """Read every model of a configuration: its own, and those that ``named`` has by section.

    Raises InputError naming the place of a formula that is refused, of a name that is the
    library's, or of a candidate that is unknown.
    """
    for name in own:
        if name in library():
            raise InputError(
                f"{place}: models.{name}: the library has a model of this name; take another"
            )
        model_named(name, own, place=place)
    for section, space in product(NAMING, SPACES):
        for name in named[section][space]:
            with naming(f"{place}: {section}.{space}"):
                model_named(name, own, place=place)
