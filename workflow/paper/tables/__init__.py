"""Tables I to III of the paper, with our values: the paper's own are not legible to us.

A module each, found by being here. Like a figure's it says in its docstring and in ``INPUTS`` what
it shows and what it is made from (``reporting.rooms``); ``build(inputs)`` makes it.
"""

import importlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType

import pandas as pd

from reporting.pages.notes import simulations_note
from squeezefilm.io.errors import InputError
from squeezefilm.io.found import modules_in
from squeezefilm.io.markdown import markdown_table
from squeezefilm.io.tables import read_json, read_ok_forces
from squeezefilm.models.fit_file import FittedModel, number, read_fit

Inputs = Mapping[str, Path]

SYMBOLS = {"theta0": "θ0", "theta1": "θ1", "theta2": "θ2", "theta3": "θ3", "theta4": "θ4"}
UNITS = {"theta2": "N", "theta4": "1/m"}


@dataclass(frozen=True)
class PaperTable:
    """A table: its title, one row per value (tidy), the same for people, and a note below."""

    title: str
    data: pd.DataFrame
    shown: pd.DataFrame
    note: str

    def to_markdown(self) -> str:
        return f"**{self.title}**\n\n{markdown_table(self.shown)}\n{self.note}\n"


def table_module(number: str) -> ModuleType:
    """The module of a table.

    Raises InputError for a number that no table has.
    """
    known = {name.removeprefix("table"): module for name, module in modules_in(__name__).items()}
    if number not in known:
        raise InputError(f"there is no table {number!r}; the tables are {', '.join(known)}")
    return importlib.import_module(known[number])


def parameters_table(
    inputs: Inputs, fits: Mapping[str, tuple[str, str]], *, title: str, control: str, more: str = ""
) -> PaperTable:
    """The parameters of a fit to a whole plan, ``first_fit``, and of others beside it.

    fits: by what the table calls them, the names among the inputs of the others and of their
    validations on that plan, which is called ``control``.
    """
    first = read_fit(inputs["first_fit"])
    judged = {control: (first, first.global_error)} | {
        name: (read_fit(inputs[fit]), global_error(inputs[validation]))
        for name, (fit, validation) in fits.items()
    }
    data = _parameters(judged, control=f"{first.points} points of the {control}")
    forces = simulations_note(inputs["device"], read_ok_forces(inputs["forces"]))
    return PaperTable(title, data, side_by_side(data), forces + more)


def _parameters(fits: Mapping[str, tuple[FittedModel, float]], *, control: str) -> pd.DataFrame:
    """A row for each parameter of each fit, and one for its error on the control points."""
    rows = []
    for name, (fit, error) in fits.items():
        for index, value in enumerate(fit.theta):
            key = f"theta{index}"
            rows.append((name, fit.points, SYMBOLS[key], UNITS.get(key, "–"), value))
        rows.append((name, fit.points, f"global error on the {control}", "%", 100 * error))
    return pd.DataFrame(rows, columns=["fit", "points", "quantity", "unit", "value"])


def side_by_side(data: pd.DataFrame) -> pd.DataFrame:
    """A row per quantity, a column per fit, five digits."""
    quantities = data[["quantity", "unit"]].drop_duplicates()
    columns = {
        f"{fit} ({rows['points'].iloc[0]} points)": rows.set_index("quantity")["value"]
        .reindex(quantities["quantity"])
        .map(five_digits)
        .to_numpy()
        for fit, rows in data.groupby("fit", sort=False)
    }
    return pd.DataFrame({"quantity": quantities["quantity"], "unit": quantities["unit"], **columns})


def five_digits(value: float) -> str:
    """Five digits; what is zero but for rounding, beside parameters of order 1 to 100, reads 0."""
    return "0" if abs(value) < 1e-12 else f"{value:.5g}".replace("-", "−")


def global_error(path: Path) -> float:
    """That of a fit on the points of a validation, as a share."""
    return number(read_json(path), "global_error", path)
