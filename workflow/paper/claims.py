"""The paper's claims beside ours, each with a verdict by a rule that is written down.

papers_claims.csv says what the paper claims, and of which interval our value agrees with it. The
intervals were set from what the paper states and with how many digits, and reviewed; nothing was
tuned to make a claim agree. The reasons in ``because`` are what we know; a guess is called a guess.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import pandas as pd

from paper.findings import BUDGET_COLUMNS, FINDINGS, Results
from squeezefilm.io.errors import InputError
from squeezefilm.io.markdown import markdown_table
from squeezefilm.io.sources import read_columns
from squeezefilm.io.tables import (
    FACTOR_COLUMNS,
    read_design,
    read_json,
    read_ok_forces,
    read_timings,
)
from squeezefilm.models.fit_file import number, read_fit

COLUMNS = ("claim_id", "claim", "paper", "ours", "unit", "verdict", "explanation")


@dataclass(frozen=True)
class Claim:
    """What the paper says; which values agree with it; why ours may not.

    least and largest are the ends of the closed interval of values that agree, within says what it
    is in words.
    """

    claim_id: str
    claim: str
    paper: str
    unit: str
    least: float
    largest: float
    within: str
    because: str


_TABLE = pd.read_csv(Path(__file__).with_name("papers_claims.csv"), dtype={"paper": str})
CLAIMS = tuple(Claim(*row) for row in _TABLE.itertuples(index=False))


def judge(results: Results) -> pd.DataFrame:
    """Every claim with our value and the verdict, as strings; columns COLUMNS."""
    return pd.DataFrame([_row(claim, results) for claim in CLAIMS], columns=COLUMNS)


def to_markdown(claims: pd.DataFrame) -> str:
    """The claims for people."""
    agreeing = int(claims["verdict"].str.startswith("agrees").sum())
    shown = claims.drop(columns="claim_id")
    return f"{agreeing} of {len(claims)} claims agree.\n\n{markdown_table(shown)}"


def _row(claim: Claim, results: Results) -> tuple[str, ...]:
    found = FINDINGS[claim.claim_id](results)
    agrees = claim.least <= found.value <= claim.largest
    verdict = f"agrees {claim.within}" if agrees else f"differs because {claim.because}"
    about = (claim.claim_id, claim.claim, claim.paper)
    return (*about, found.ours, claim.unit, verdict, found.explanation)


INPUTS = {
    "screen": "simulations/screen/forces.csv",
    "screen_timings": "simulations/screen/timings.csv",
    "screen_fit": "fits/screen.json",
    "screen_runs": "fits/screen_runs.csv",
    "design": "designs/two_factor.csv",
    "design_summary": "designs/two_factor.json",
    "design_fit": "fits/two_factor_design.json",
    "screen_on_screen": "validation/screen_on_screen.json",
    "design_on_screen": "validation/two_factor_design_on_screen.json",
    "design_errors": "validation/two_factor_design_on_screen.csv",
    "extrapolation": "simulations/extrapolation/forces.csv",
    "extrapolation_budget": "simulations/extrapolation/budget.csv",
    "four_factor": "simulations/four_factor/forces.csv",
    "four_factor_design": "designs/four_factor.csv",
    "four_factor_design_on_plan": "validation/four_factor_design_on_four_factor.json",
    "four_factor_distinct_on_plan": ("validation/four_factor_design_distinct_on_four_factor.json"),
    "four_factor_distinct_on_control": (
        "validation/four_factor_design_distinct_on_four_factor_control.json"
    ),
}
"""The files that claims rest on, by name, each with its place among a study's results."""


def _read_summary(path: Path) -> dict[str, Any]:
    summary = read_json(path)
    for key in ("points", "global_error", "sum_of_squares"):
        number(summary, key, path)
    return summary


def _read_searches(path: Path) -> dict[str, Any]:
    summary = read_json(path)
    for key in ("scaling", "searches", "scalings"):
        if key not in summary:
            raise InputError(f"{path}: {key!r} is missing")
    return summary


def _read_extrapolation(path: Path) -> pd.DataFrame:
    table = read_ok_forces(path)
    for point_id in ("operating_point", "two_factor_design"):
        if point_id not in set(table["point_id"]):
            raise InputError(f"{path}: there is no point {point_id!r}")
    return table


READERS: dict[str, Callable[[Path], Any]] = {
    "screen": read_ok_forces,
    "screen_timings": read_timings,
    "screen_fit": read_fit,
    "screen_runs": partial(read_columns, columns=("bound", "sum_of_squares")),
    "design": read_design,
    "design_summary": _read_searches,
    "design_fit": read_fit,
    "screen_on_screen": _read_summary,
    "design_on_screen": _read_summary,
    "design_errors": partial(read_columns, columns=(*FACTOR_COLUMNS, "relative_error")),
    "extrapolation": _read_extrapolation,
    "extrapolation_budget": partial(read_columns, columns=BUDGET_COLUMNS),
    "four_factor": read_ok_forces,
    "four_factor_design": read_design,
    "four_factor_design_on_plan": _read_summary,
    "four_factor_distinct_on_plan": _read_summary,
    "four_factor_distinct_on_control": _read_summary,
}
"""The results that the claims are about, and how each is read."""


def read_results(inputs: Mapping[str, Path]) -> Results:
    """Read what the claims need, by the names of READERS.

    Raises InputError naming the file and what it lacks.
    """
    return Results(**{name: read(inputs[name]) for name, read in READERS.items()})
