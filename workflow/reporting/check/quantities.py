"""What a finished study is checked by: every quantity with its place, its numbers, its tolerance.

The order is that of the table: settings; figures' data and the paper's tables; claims; simulations,
fits and designs; pictures; numerics. Figures stand before what they are made from, for they are
what a reviewer looks at.
"""

import math
import re
import shutil
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.testing.compare import compare_images
from matplotlib.testing.exceptions import ImageComparisonFailure

from reporting.check.tolerances import (
    DERIVED,
    GIVEN,
    PLACE,
    SAME,
    AtMost,
    Close,
    Closeness,
    Efficient,
    Tolerance,
)
from reporting.figures.style import PLAIN
from reporting.results import Results
from squeezefilm.columns import POLAR, form_of
from squeezefilm.config.loading import Config
from squeezefilm.designs.box import coordinates, pair_distances
from squeezefilm.errors import InputError
from squeezefilm.models.data import factors_of
from squeezefilm.studies.plans import box_of

SAMPLE = 25
"""Rows of a table that a reference keeps; least, mean and largest stand for the others."""
NOT_DECIDING = {
    *("study", "paper", "numerics", "simulation", "outputs"),
    *("sweep", "models", "comparison", "optimal", "refine"),  # not the paper's
}
"""Sections of a study that decide nothing which is compared."""
OF_THE_PAPER = "four_factor_control"
"""The plan that only the paper's studies have."""
PLANS = {
    "screen": GIVEN,
    "two_factor_design": PLACE,
    "error_map": GIVEN,
    "extrapolation": PLACE,
    "four_factor": PLACE,
    OF_THE_PAPER: GIVEN,
    "four_factor_design": PLACE,
    "four_factor_design_distinct": PLACE,
}
"""The plans, and how their points come about: PLACE out of a design or a fit."""
FITS = {
    "screen": ("screen", "error_map", "extrapolation"),
    "two_factor_design": ("screen", "error_map", "extrapolation"),
    "four_factor": ("four_factor", OF_THE_PAPER),
    "four_factor_design": ("four_factor", OF_THE_PAPER),
    "four_factor_design_distinct": ("four_factor", OF_THE_PAPER),
}
"""Each fit, and the plans that it is validated on."""
FIT_OF_DESIGN = {
    "two_factor": "screen",
    "four_factor": "four_factor",
    "four_factor_distinct": "four_factor",
}
ROUNDING = 1e-9
LETTERS = "ABCDE"
"""Patterns whose searches are counted."""
TABLES = {
    "simulations/screen/budget": "h0_m|hv_m|(inertia|slip|heat|rim|left_out.*)_percent",
    "simulations/four_factor/budget": "(inertia|slip|heat|rim|left_out.*)_percent",
    "simulations/screen/response": "h0_m|hv_m|corner_hz|prompt_share|error",
    "simulations/screen/gains": "h0_m|hv_m|frequency_hz|gain|phase_deg",
    "simulations/screen/levitation": "load_n|hv_m|h0_m|stiffness_n_per_m|modified_reynolds",
    "simulations/extrapolation/film": "phase_deg|x_mm|surface_um|finger_um|overpressure_kpa",
    "validation/two_factor_design_on_error_map": "h0_m|hv_m|relative_error",
    "tables/uncertainty": "assumption|force_(low|high)_n|ours_n|verdict",
    "tables/uncertainty_curves": "assumption|change_percent|plausible|force_n",
}
"""Tables that the study's figures are drawn from, and their columns that are compared."""
BY_CHANCE = ("fig09",)
"""Figures of many searches: how many ended where is chance, and a rare pattern may be missing."""
PICTURES, PLACE_OF_PICTURES = "pictures", "check/figures"
RMS = 1.5
"""Of the pixels (0 to 255) between two pictures. In the paper's figures a dropped curve makes 2.4
to 30, a line of the band 4.4, the zero line of Figure 14 1.8, forces off by 1e-4 0.1. A line of the
small film in `overview` makes 0.2 and is not seen, nor is one that others hide."""


@dataclass(frozen=True)
class Quantity:
    """One column, list or text of a study: its cells by name, as text, and how close they must be.

    part and item say where it belongs: figure data, fig08. There is at least one cell, but for a
    missing file, which is a Quantity as well, with its name in ``missing``.
    """

    part: str
    item: str
    name: str
    cells: Mapping[str, str] = field(default_factory=dict)
    tolerance: Tolerance = SAME
    missing: str = ""

    @property
    def key(self) -> tuple[str, str, str]:
        """Part, item and name."""
        return self.part, self.item, self.name


def study_quantities(results: Results, reference: Path) -> list[Quantity]:
    """All quantities of a finished study, in the order in which they are judged.

    Args:
        reference: the folder with the pictures to compare the study's with.
    """
    config = results.config
    closeness = Closeness(solver=float(config["solver"]["tolerance"]))
    paper = bool(config["paper"])
    makers: list[tuple[str, str, Callable[..., Iterator[Quantity]]]] = [
        *(
            ("figure data", path.stem, partial(_figure, results, closeness))
            for path in sorted((results.folder / "figures").glob("fig*.csv"))
        ),
        *(
            ("results", name, partial(_table, results, closeness))
            for name in TABLES
            if paper or not name.startswith("tables/")
        ),
        *(
            ("tables", f"table {number}", partial(_paper_table, results, closeness))
            for number in ("1", "2", "3")
            if paper
        ),
        *([("claims", "claims.csv", partial(_claims, results, closeness))] if paper else []),
        *(
            ("simulations", plan, partial(_simulations, results, closeness))
            for plan in PLANS
            if paper or plan != OF_THE_PAPER
        ),
        *(("fits", name, partial(_fit, results, closeness)) for name in FITS),
        *(("designs", name, partial(_design, results)) for name in FIT_OF_DESIGN),
        ("designs", "two-factor searches", partial(_patterns, results, closeness)),
        *(
            ("validation", f"{fit}_on_{plan}", partial(_validation, results, closeness))
            for fit, plans in FITS.items()
            for plan in plans
            if paper or plan != OF_THE_PAPER
        ),
        *(
            (PICTURES, name, partial(_picture, results, reference))
            for name in _pictures(results.folder / PLACE_OF_PICTURES, reference)
        ),
    ]
    # A reference has a sample of the films; all of them take minutes.
    if config["numerics"]["extent"] == "sample" and results.exists("numerics/stability.csv"):
        makers.append(("numerics", "stability", partial(_stability, results)))
    return [
        *_settings(config),
        *(quantity for part, item, make in makers for quantity in _guarded(part, item, make)),
    ]


def _guarded(part: str, item: str, make: Callable[..., Iterator[Quantity]]) -> list[Quantity]:
    """The quantities of an item, or that a file of it is missing or cannot be read."""
    try:
        return list(make(part=part, item=item))
    except InputError as error:
        return [Quantity(part, item, "readable", missing=str(error))]


def text_of(value: Any) -> str:
    """A cell's text: twelve digits of a number, so that 7e-06 reads so."""
    if isinstance(value, bool | np.bool_) or not isinstance(value, int | float | np.number):
        return str(value)
    return f"{float(value):.12g}"


def column_quantities(
    table: pd.DataFrame, *, part: str, item: str, tolerances: Mapping[str, Tolerance]
) -> Iterator[Quantity]:
    """A table's number of rows, then its columns thinned out, by patterns of their names.

    Of a longer table, SAMPLE rows evenly spaced are kept, and of its columns of numbers the
    least, the mean and the largest value. A column is as close as the first pattern in
    ``tolerances`` that its whole name matches, else DERIVED where it has numbers with a point.
    """
    yield Quantity(part, item, "rows", {"rows": str(len(table))})
    kept = sorted({round(row) for row in np.linspace(0, len(table) - 1, SAMPLE)})
    for name in map(str, table):
        column = table[name]
        default = DERIVED if column.dtype == float else SAME
        known = (each for pattern, each in tolerances.items() if re.fullmatch(pattern, name))
        tolerance = next(known, default)
        cells = {f"row {row + 1}": text_of(column.iloc[row]) for row in kept}
        if tolerance != SAME and len(table) > len(kept):
            numbers = column.astype(float)
            for key, value in (
                ("least", numbers.min()),
                ("mean", numbers.mean()),
                ("largest", numbers.max()),
            ):
                cells[key] = text_of(value)
        yield Quantity(part, item, name, cells, tolerance)


def _settings(config: Config) -> Iterator[Quantity]:
    """Every key that decides a result: the study must be the one that the reference is of."""
    for section in (name for name in config if name not in NOT_DECIDING):
        yield Quantity("settings", section, "keys", dict(_leaves(section, config[section])))


def _leaves(place: str, value: Any) -> Iterator[tuple[str, str]]:
    if isinstance(value, Mapping):
        for key in sorted(value):
            yield from _leaves(f"{place}.{key}", value[key])
    elif place != "solver.device":  # a study is the same on every device
        yield place, text_of(value)


def _figure(results: Results, closeness: Closeness, *, part: str, item: str) -> Iterator[Quantity]:
    """The table that a figure of the paper draws."""
    data = results.table(f"figures/{item}.csv")
    if item == "fig09":
        # One search that ended in each scaling's best pattern: which others do is chance.
        best = data[data["pattern"] == "A"]
        first = best.groupby("scaling", sort=True)["search"].transform("min")
        data = best[best["search"] == first].drop(columns="search")
        data = data.sort_values(["scaling", "h0_um", "hv_um"], kind="stable")
    of_designs = re.fullmatch("fig(09|10|11|12|13|16)", item)
    tolerances = {
        "force_n": closeness.model,
        "relative_error_percent": closeness.relative_error,
        "objective": closeness.parameters,
        "epsilon|h0_um|hv_um|phi_r_mm|phi_deg": PLACE if of_designs else GIVEN,
        "(radius|x|y)_mm|angle_deg|amplitude_ratio|points|band_percent": GIVEN,
        "phi_r_limit_mm|phi_r_max_mm|phi_max_deg|(h0|hv)_(min|max)_um": GIVEN,
    }
    yield from column_quantities(data, part=part, item=item, tolerances=tolerances)


def _table(results: Results, closeness: Closeness, *, part: str, item: str) -> Iterator[Quantity]:
    """The table that a figure of the study is drawn from."""
    table = results.table(f"{item}.csv")
    tolerances = {
        # Gaps that carry a load are found: where a force is as large.
        "h0_m": closeness.force if item.endswith("levitation") else GIVEN,
        "hv_m": GIVEN,
        "force_n": closeness.model,
        "relative_error": closeness.relative_error,
    }
    chosen = [name for name in table if re.fullmatch(TABLES[item], str(name))]
    yield from column_quantities(table[chosen], part=part, item=item, tolerances=tolerances)


def _paper_table(
    results: Results, closeness: Closeness, *, part: str, item: str
) -> Iterator[Quantity]:
    """A table of the paper: parameters loosely, errors as what they are."""
    table = results.table(f"tables/{item.replace(' ', '')}.csv")
    if "value" not in table:
        tolerances = {"minimum|maximum": GIVEN}
        yield from column_quantities(table, part=part, item=item, tolerances=tolerances)
        return
    texts = table.drop(columns="value")
    yield from column_quantities(texts, part=part, item=item, tolerances={})
    for fit, rows in table.groupby("fit", sort=False):
        errors = rows["unit"] == "%"
        percent = Close(absolute=100 * closeness.residual.absolute)
        for name, chosen, tolerance in (
            ("parameters", rows[~errors], closeness.parameters),
            ("global error", rows[errors], percent),
        ):
            cells = dict(zip(chosen["quantity"], map(text_of, chosen["value"]), strict=True))
            yield Quantity(part, item, f"{name}, {fit}", cells, tolerance)


def _claims(results: Results, closeness: Closeness, *, part: str, item: str) -> Iterator[Quantity]:
    """Every claim's verdict and our value; of the run time, the verdict alone."""
    table = results.table(item, "claim_id", "claim", "paper", "ours", "unit", "verdict")
    for claim in table.fillna("").astype(str).to_dict("records"):
        name = claim["claim_id"]
        agrees = claim["verdict"].partition(" ")[0]
        yield Quantity(part, name, "verdict", {claim["claim"]: agrees})
        if name != "seconds":
            cells = {f"ours, in {claim['unit']}; paper: {claim['paper']}": claim["ours"]}
            yield Quantity(part, name, "ours", cells, closeness.shown)


def _simulations(
    results: Results, closeness: Closeness, *, part: str, item: str
) -> Iterator[Quantity]:
    """The points of a plan, their forces, and how error estimates keep the tolerance."""
    forces = results.forces(item)
    shown = forces[["point_id", "h0_m", "hv_m", *form_of(forces), "force_n"]]
    tolerances = {
        "point_id": SAME,
        "force_n": closeness.model if PLANS[item] == PLACE else closeness.force,
        ".*": PLANS[item],
    }
    yield from column_quantities(shown, part=part, item=item, tolerances=tolerances)
    largest = float((forces["force_error_n"] / forces["force_n"].abs()).max())
    cells = {"largest of all points": f"{largest / closeness.solver:.3g}"}
    name = "largest estimated error over the tolerance"
    yield Quantity(part, item, name, cells, AtMost(1.0))


def _fit(results: Results, closeness: Closeness, *, part: str, item: str) -> Iterator[Quantity]:
    """A fit's objective and what it predicts; its parameters loosely; which runs were made."""
    fit = results.fit(item)
    model, theta = fit.force_model, list(map(text_of, fit.theta))
    objective = {"|y − η|/|y|": f"{fit.global_error:.9g}"}
    yield Quantity(part, item, "objective", objective, closeness.residual)
    points = _prediction_points(results.config, centred=model.is_centred)
    forces = model.evaluate(fit.theta, factors_of(points))
    cells = dict(zip(_places(points), map(text_of, forces), strict=True))
    yield Quantity(part, item, "predicted forces", cells, closeness.model)
    cells = dict(zip(model.parameter_names, theta, strict=True))
    yield Quantity(part, item, "parameters", cells, closeness.parameters)
    runs = results.table(f"fits/{item}_runs.csv", "method", "bound", "seed")
    runs = runs[["method", "bound", "seed"]]
    yield from column_quantities(runs, part=part, item=f"{item}, runs", tolerances={".*": SAME})


def _prediction_points(config: Config, *, centred: bool) -> pd.DataFrame:
    """Corners, edges and middle of the experiment's space."""

    def three(levels: Mapping[str, float]) -> tuple[float, ...]:
        return levels["start"], (levels["start"] + levels["stop"]) / 2, levels["stop"]

    names = form_of(config["positions"])
    first, second = (max(config["positions"][name]) for name in names)
    places = [(0.0, 0.0)] if centred else [(0.0, 0.0), (first, 0.0), (first, second)]
    rows = [
        (gap, amplitude, *place)
        for gap in three(config["screen"]["h0_m"])
        for amplitude in three(config["screen"]["hv_m"])
        for place in places
    ]
    return pd.DataFrame(rows, columns=["h0_m", "hv_m", *names])


def _places(points: pd.DataFrame) -> list[str]:
    form = "φr {:g} mm φφ {:g}°" if form_of(points) == POLAR else "x {:g} mm y {:g} mm"
    scale = (1e6, 1e6, 1e3, 1 if form_of(points) == POLAR else 1e3)
    return [f"h0 {{:g}} µm hv {{:g}} µm {form}".format(*row) for row in points.to_numpy() * scale]


def _design(results: Results, *, part: str, item: str) -> Iterator[Quantity]:
    """A design's worth, whether it is within the space, and whether its points are distinct."""
    config, design = results.config, results.design(item)
    fit = results.fit(FIT_OF_DESIGN[item])
    box = box_of(config, centred=fit.force_model.is_centred)
    cells = dict(zip(fit.force_model.parameter_names, map(text_of, fit.theta), strict=True))
    for number, point in enumerate(design.to_dict("records"), start=1):
        cells |= {f"point {number} {factor}": text_of(point[factor]) for factor in box.names}
    yield Quantity(part, item, "D-efficiency", cells, Efficient(fit.model))
    points = design[list(box.names)].to_numpy()
    outside = max(0.0, float(np.max(np.abs(box.to_unit(points) - 0.5)) - 0.5))
    cells = {"largest, as a share of the space": f"{outside:.3g}"}
    yield Quantity(part, item, "outside the space", cells, AtMost(ROUNDING))
    if item == "four_factor_distinct":
        wanted = config["four_factor_design"]["separation"]
        least = float(pair_distances(coordinates("scene", box)(points)).min())
        share = wanted / least if least else math.inf
        cells = {"wanted least distance over that found": f"{share:.9g}"}
        yield Quantity(part, item, "nearer than wanted", cells, AtMost(1 + ROUNDING))


def _patterns(
    results: Results, closeness: Closeness, *, part: str, item: str
) -> Iterator[Quantity]:
    """The best value of criterion (12) in each scaling, and how many searches ended where."""
    summary = results.searches()
    searches = summary["searches"]
    for scaling, patterns in sorted(summary["scalings"].items()):
        of = f"{item}, {scaling}"
        best = {"least": text_of(patterns[0]["objective"])}
        yield Quantity(part, of, "criterion (12)", best, closeness.parameters)
        # Which search ends in which pattern is chance, a rare one may not be met at all: three
        # standard deviations of the difference of two counts, of a share that is never nought.
        found = {pattern["pattern"]: pattern["count"] for pattern in patterns}
        shares = [(count + 1) / (searches + 2) for count in found.values()]
        apart = 3 * max(math.sqrt(2 * searches * share * (1 - share)) for share in shares)
        counts = {letter: str(found.get(letter, 0)) for letter in LETTERS}
        yield Quantity(part, of, "searches", counts, Close(absolute=round(apart, 1)))


def _validation(
    results: Results, closeness: Closeness, *, part: str, item: str
) -> Iterator[Quantity]:
    """The errors of a fit on a plan."""
    fit, _, plan = item.partition("_on_")
    errors = results.validation(fit, plan)
    cells = {"|η − y|/|y|": text_of(errors["global_error"])}
    yield Quantity(part, item, "global error", cells, closeness.residual)
    # A point at the very edge of the band may change sides.
    inside = errors["share_within_band"] * errors["points"]
    cells = {"points": text_of(errors["points"]), "within the band": text_of(inside)}
    yield Quantity(part, item, "points", cells, Close(absolute=0.01))


def _stability(results: Results, *, part: str, item: str) -> Iterator[Quantity]:
    """The verdict on every stiff or extreme film; none of them may fail."""
    table = results.table("numerics/stability.csv", "case", "verdict", "reason").astype(str)
    verdicts = dict(zip(table["case"], table["verdict"], strict=True))
    yield Quantity(part, item, "verdicts", verdicts)
    failed = {"number of cases that failed": str((table["verdict"] == "failed").sum())}
    yield Quantity(part, item, "failed cases", failed, AtMost(0))


def _picture(results: Results, reference: Path, *, part: str, item: str) -> Iterator[Quantity]:
    """How far a figure's picture without texts is from the one in a reference's folder.

    Fonts change a picture by more than a dropped curve does, hence no texts. Where it is too far
    off, the difference is drawn beside it.
    """
    got = results.folder / PLACE_OF_PICTURES / f"{item}{PLAIN}"
    expected = reference / got.name
    if not got.exists():
        raise InputError(f"{got}: there is no such picture")
    apart = "no picture in the reference"
    if expected.exists():
        try:
            found = compare_images(str(expected), str(got), tol=RMS, in_decorator=True)
            apart = f"{found['rms']:.3g}" if found else "0"
        except (ImageComparisonFailure, OSError, SyntaxError) as error:
            apart = " ".join(str(error).split())
    yield Quantity(part, item, "difference", {"RMS of the pixels": apart}, AtMost(RMS))


def _pictures(*folders: Path) -> list[str]:
    """The names of the pictures that any of the folders has."""
    paths = (path for folder in folders for path in folder.glob(f"*{PLAIN}"))
    return sorted({path.name.removesuffix(PLAIN) for path in paths} - set(BY_CHANCE))


def pictures_of(reference: Path) -> dict[tuple[str, str, str], dict[str, str]]:
    """What a picture of a reference is apart from itself, as cells."""
    cells = {"RMS of the pixels": "0"}
    return {(PICTURES, name, "difference"): cells for name in _pictures(reference)}


def write_pictures(results: Path, reference: Path) -> None:
    """Make a study's pictures those of the reference."""
    for old in reference.glob(f"*{PLAIN}"):
        old.unlink()
    for name in _pictures(results / PLACE_OF_PICTURES):
        shutil.copy(results / PLACE_OF_PICTURES / f"{name}{PLAIN}", reference)
