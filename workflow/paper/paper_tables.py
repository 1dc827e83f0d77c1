"""Tables I to III of the paper, with our values: the paper's own are not legible to us."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from reporting.pages.notes import simulations_note
from squeezefilm.io.errors import InputError
from squeezefilm.io.markdown import markdown_table
from squeezefilm.io.tables import read_json, read_ok_forces, read_scenes
from squeezefilm.models.fitted import FittedModel, number, read_fit

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


def table_1(inputs: Inputs) -> PaperTable:
    """Table I: the two-factor model's parameters from the screen and from the optimal design."""
    first, design = read_fit(inputs["first_fit"]), read_fit(inputs["design_fit"])
    design_error = _global_error(inputs["design_on_first"])
    data = _parameters(
        {"screen": (first, first.global_error), "optimal design": (design, design_error)},
        control=f"{first.points} points of the screen",
    )
    return PaperTable(
        title="Table I. Parameters of the two-factor model",
        data=data,
        shown=_side_by_side(data),
        note=_note(inputs),
    )


def table_2(inputs: Inputs) -> PaperTable:
    """Table II: the ranges of the four factors."""
    screen, plan = read_scenes(inputs["screen"]), read_scenes(inputs["plan"])
    assumed = "our assumption: the paper's table is not legible to us"
    data = pd.DataFrame(
        [
            ("mean gap", "h0", "µm", *_range(screen["h0_m"], scale=1e6), "paper"),
            ("amplitude at the centre", "hv", "µm", *_range(screen["hv_m"], scale=1e6), "paper"),
            ("radial position", "φr", "mm", *_range(plan["phi_r_m"], scale=1e3), assumed),
            ("angular position", "φφ", "°", *_range(plan["phi_deg"], scale=1), assumed),
        ],
        columns=["factor", "symbol", "unit", "minimum", "maximum", "source"],
    )
    positions = len(plan[["phi_r_m", "phi_deg"]].drop_duplicates())
    return PaperTable(
        title="Table II. Space of the experiment with four factors",
        data=data,
        shown=data.assign(
            **{name: data[name].map("{:g}".format) for name in ("minimum", "maximum")}
        ),
        note=(
            f"{len(plan)} simulations at {positions} positions of the finger's centre; the finger "
            "stays on the actuator at each of them."
        ),
    )


def table_3(inputs: Inputs) -> PaperTable:
    """Table III: the four-factor model's parameters from the plan and from optimal designs."""
    first = read_fit(inputs["first_fit"])
    fits = {
        "plan": (first, first.global_error),
        "optimal design, the paper's form": (
            read_fit(inputs["design_fit"]),
            _global_error(inputs["design_on_first"]),
        ),
        "optimal design, distinct scenes": (
            read_fit(inputs["distinct_fit"]),
            _global_error(inputs["distinct_on_first"]),
        ),
    }
    data = _parameters(fits, control=f"{first.points} points of the plan")
    return PaperTable(
        title="Table III. Parameters of the four-factor model",
        data=data,
        shown=_side_by_side(data),
        note=(
            f"{_note(inputs)} φφ in degrees and φr in metres. The paper's criterion takes "
            "one scene, a centred finger at two angles, for two points; the other design does not."
        ),
    )


@dataclass(frozen=True)
class TableRecipe:
    """What a table is built from, and how."""

    inputs: tuple[str, ...]
    build: Callable[[Inputs], PaperTable]


TABLES = {
    "1": TableRecipe(("first_fit", "design_fit", "design_on_first", "forces", "device"), table_1),
    "2": TableRecipe(("screen", "plan"), table_2),
    "3": TableRecipe(
        (
            "first_fit",
            "design_fit",
            "distinct_fit",
            "design_on_first",
            "distinct_on_first",
            "forces",
            "device",
        ),
        table_3,
    ),
}


def table_recipe(number: str) -> TableRecipe:
    """The recipe of a table.

    Raises:
        InputError: for a number that no table has.
    """
    if number not in TABLES:
        raise InputError(f"there is no table {number!r}; the tables are {', '.join(TABLES)}")
    return TABLES[number]


def _parameters(fits: dict[str, tuple[FittedModel, float]], *, control: str) -> pd.DataFrame:
    rows = []
    for name, (fit, error) in fits.items():
        for index, value in enumerate(fit.theta):
            key = f"theta{index}"
            rows.append((name, fit.points, SYMBOLS[key], UNITS.get(key, "–"), value))
        rows.append((name, fit.points, f"global error on the {control}", "%", 100 * error))
    return pd.DataFrame(rows, columns=["fit", "points", "quantity", "unit", "value"])


def _side_by_side(data: pd.DataFrame) -> pd.DataFrame:
    """A row per quantity, a column per fit, five digits."""
    quantities = data[["quantity", "unit"]].drop_duplicates()
    columns = {
        f"{fit} ({rows['points'].iloc[0]} points)": rows.set_index("quantity")["value"]
        .reindex(quantities["quantity"])
        .map(_five_digits)
        .to_numpy()
        for fit, rows in data.groupby("fit", sort=False)
    }
    return pd.DataFrame({"quantity": quantities["quantity"], "unit": quantities["unit"], **columns})


def _five_digits(value: float) -> str:
    """Five digits; what is zero but for rounding, beside parameters of order 1 to 100, reads 0."""
    return "0" if abs(value) < 1e-12 else f"{value:.5g}".replace("-", "−")


def _range(column: pd.Series, *, scale: float) -> tuple[float, float]:
    return round(float(column.min()) * scale, 9), round(float(column.max()) * scale, 9)


def _global_error(path: Path) -> float:
    return number(read_json(path), "global_error", path)


def _note(inputs: Inputs) -> str:
    return simulations_note(inputs["device"], read_ok_forces(inputs["forces"]))
