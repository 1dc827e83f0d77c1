"""Comparison of a finished study with a small stored reference.

A study's quantities are listed in one place, each with its numbers as texts and its tolerance; a
reference holds the same, thinned out. Figures' data stand before what they are made from, for they
are what a reviewer looks at. How close a number must be follows from the tolerance that the solver
was asked for. On any machine and device a force lies within it of the truth, so that two machines
differ by no more than twice as much. What follows from forces differs in proportion
(docs/explanation/paper.md).
"""

import math
import re
import shutil
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from decimal import Decimal
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from matplotlib.testing.compare import compare_images
from matplotlib.testing.exceptions import ImageComparisonFailure

from squeezefilm.errors import InputError
from squeezefilm.files import write_text
from squeezefilm.models.data import factors_of_table
from squeezefilm_workflow.reporting.figures.style import PLAIN_PICTURE_SUFFIX
from squeezefilm_workflow.reporting.pages import Page
from squeezefilm_workflow.reporting.results import Results

PASSED, FAILED = "passed", "failed"
MISSING = "missing"
"""What a quantity has got whose file or row was not made."""
CHECK_COLUMNS = (
    *("verdict", "part", "item", "quantity", "of_tolerance", "expected", "got", "worst"),
    "tolerance",
)
"""What judges a quantity stands before what is long: a narrow window shows it."""
REFERENCE_INDEX = ("item", "cell")
"""Columns of a reference; the others are its quantities."""
MAX_CELL_CHARACTERS = 40
"""Characters of a cell on the screen; all of it is in the table."""
PICTURES_PART_NAME, PICTURES_FOLDER = "pictures", "check/figures"
FILE_TEMPLATE_OF_PART = {
    "simulations": "simulations/{}/forces.csv",
    "fits": "fits/{}.json",
    "designs": "designs/{}.csv",
    "results": "{}.csv",
    "numerics": "numerics/{}.csv",
    "tables": "tables/{}.csv",
    "figure data": "figures/{}.csv",
    PICTURES_PART_NAME: "check/figures/{}.plain.png",
    "claims": "claims.csv",
}
"""The file of an item, in the study's results; parts that others are made from stand first."""
UNREPRODUCIBLE_FIGURE = "fig09"
"""The figure of many searches: which of them ended where is chance."""
MAX_PICTURE_RMS = 1.5
"""Of the pixels (0 to 255) between two pictures. In the paper's figures a dropped curve makes 2.4
to 30, a line of the band 3.5, the zero line of Figure 14 3.5, forces off by 1e-4 0.1. A line of the
small film in `overview` makes 0.2 and is not seen, nor is one that others hide."""
PIXEL_RMS_LABEL = "RMS of the pixels"
_NUMBER_PATTERN = re.compile(r"[-−]?\d+(?:\.\d+)?(?:e[-−+]?\d+)?")

MAX_SAMPLED_ROWS = 100
"""Rows of a table that a reference keeps; least, mean and largest stand for the others."""
MAX_FORCES_ALL_KEPT = 100
"""Forces of a plan of which a reference keeps every one: of the screen and the positions."""
FIT_OF_DESIGN = {
    "two_factor": "screen",
    "four_factor": "four_factor",
    "four_factor_distinct": "four_factor",
}
TABLE_PATTERNS_OF_PART = {
    "figure data": ("figures/fig*",),
    "results": (
        *("simulations/*/error_budget", "simulations/*/response", "simulations/*/gains"),
        *("simulations/*/levitation", "simulations/*/film", "validation/*"),
    ),
    "tables": ("tables/*",),
}
"""Tables that the study's figures and pages are made from, all of whose columns are compared."""
COLUMNS_NOT_COMPARED = ("nx", "ny", "nt", "newton_steps", "krylov_iterations", "residual")
"""The way to a force, which depends on how the device rounds."""
POSITION_PATTERN = "(h0_m|hv_m|phi_r_m|phi_deg|x_m|y_m)"
FIXED_PLANS_PATTERN = r"(\w+_on_)?(screen|error_map|four_factor_control)(/\w+)?"
TOLERANCE_KIND_OF_QUANTITY = {
    r"(screen|error_map|four_factor_control) force_n": "force",
    r".*/levitation h0_m": "force",
    rf"(simulations/|validation/)?{FIXED_PLANS_PATTERN} {POSITION_PATTERN}": "given",
    rf"[a-z].* {POSITION_PATTERN}": "place",
    r".* (minimum|maximum)": "given",
    r"fig1[01236] (epsilon|h0_um|hv_um|phi_r_mm|phi_deg)": "place",
    r"fig.. (epsilon|\w+_(um|mm|deg)|amplitude_ratio|points|band_percent)": "given",
    r".* force_n": "model",
    r".* relative_error(_all)?(_percent)?": "relative error",
    r".* (value|model_n)": "parameters",
    r".* (?!.*modelling)\w+_error(_\w+)?": "error",
}
"""How close a column of numbers is, by its table and name; the first that fits, else derived."""

QuantityKey = tuple[str, str, str]
CellTexts = Mapping[str, str]
ReferenceCells = dict[QuantityKey, dict[str, str]]
"""The cells of every quantity, by part, item and name."""


@dataclass(frozen=True)
class CellTolerance:
    """Closeness of two texts: equal words, and numbers within the sum of the limits.

    Attributes:
        relative: a share of each value.
        fraction_of_largest: a share of the largest magnitude in the column.
        absolute: an amount.
        last_digit_units: units of the last digit that is shown.
    """

    relative: float = 0.0
    fraction_of_largest: float = 0.0
    absolute: float = 0.0
    last_digit_units: float = 0.0

    def __str__(self) -> str:
        parts = [f"{size:.2g} {name}" for name, size in vars(self).items() if size]
        return " + ".join(parts).replace("_", " ") or "equal"

    def deviation_ratios(self, expected: CellTexts, got: CellTexts) -> dict[str, float]:
        """Return each cell's difference over the allowed one; values up to 1 pass."""
        sizes = [
            abs(_numbers_in_text(text)[0])
            for text in expected.values()
            if _NUMBER_PATTERN.fullmatch(text)
        ]
        amount = self.absolute + self.fraction_of_largest * float(max(sizes, default=0))
        cells = dict.fromkeys([*expected, *got])
        return {
            cell: self._deviation_ratio(expected.get(cell), got.get(cell), amount) for cell in cells
        }

    def _deviation_ratio(self, expected: str | None, got: str | None, amount: float) -> float:
        if expected == got:
            return 0.0
        if (
            expected is None
            or got is None
            or _NUMBER_PATTERN.sub("#", expected) != _NUMBER_PATTERN.sub("#", got)
        ):
            return math.inf
        largest = 0.0
        for want, have in zip(_numbers_in_text(expected), _numbers_in_text(got), strict=True):
            unit = 10.0 ** max(int(number.as_tuple().exponent) for number in (want, have))
            allowed = amount + self.relative * abs(float(want)) + self.last_digit_units * unit
            if off := abs(float(want) - float(have)):  # just over one by rounding counts as one
                largest = max(largest, round(off / allowed, 6) if allowed else math.inf)
        return largest


ZERO_TOLERANCE = CellTolerance()


def _numbers_in_text(text: str) -> list[Decimal]:
    """The numbers in a text, with their digits."""
    return [Decimal(number.replace("−", "-")) for number in _NUMBER_PATTERN.findall(text)]


class CheckedQuantity(NamedTuple):
    """One column, list or text of a study: its cells by name, as text, and how close they must be.

    part and item say where it belongs: figure data, fig08. The first three are its key.
    """

    part: str
    item: str
    name: str
    cell_texts: CellTexts
    tolerance: CellTolerance = ZERO_TOLERANCE


def check_page(results: Results, *, reference: str) -> Page:
    """Every quantity of a study beside those of the reference in a folder."""
    table = check_table(results, Path(reference))
    shown = failures_first(table)
    shown["of_tolerance"] = shown["of_tolerance"].map("{:.2g}".format)
    # Long names may be broken in two, terms of a tolerance not: rows stay low, the table narrow.
    shown["item"] = shown["item"].str.replace("(/|_on_)", "\\1\u200b", regex=True)
    shown["tolerance"] = shown["tolerance"].str.replace(r"(?<!\+) ", "\u00a0", regex=True)
    values = {
        "study": results.folder.name,
        "summary": passed_and_failed_text(table, study=results.folder.name),
        "files": failed_files(table, results.folder),
        "worst": worst_of_each_part(table).assign(
            of_tolerance=lambda worst: worst["of_tolerance"].map("{:.2g}".format)
        ),
        "table": shown,
        "plan_size": MAX_FORCES_ALL_KEPT,
    }
    return Page(values, {"csv": table, "text": f"{terminal_text(table, results.folder)}\n"})


def check_table(results: Results, reference: Path) -> pd.DataFrame:
    """Return ``compare_quantities`` of a study's quantities and those of the reference in a
    folder, which has the study's name.

    Raises InputError for the reference of another study.
    """
    study, name = results.config.study, reference.absolute().name
    if name != study:
        raise InputError(
            f"{reference}: is the reference of the study {name}, and {results.folder} has results "
            f"of {study}; `make reference STUDIES={study}` makes one"
        )
    return compare_quantities(study_quantities(results, reference), read_reference(reference))


def compare_quantities(
    quantities: Iterable[CheckedQuantity], reference: Mapping[QuantityKey, CellTexts]
) -> pd.DataFrame:
    """A row for every quantity, then one for each that the reference has and the study lacks.

    A quantity that the reference does not have fails as well: it was never reviewed.
    """
    quantities = list(quantities)
    keys = {quantity[:3] for quantity in quantities}
    quantities += [CheckedQuantity(*key, {}) for key in reference if key not in keys]
    rows = []
    for quantity in quantities:
        expected = reference.get(quantity[:3], {})
        distances = quantity.tolerance.deviation_ratios(expected, quantity.cell_texts) or {
            "": math.inf
        }
        worst = max(distances, key=lambda cell: distances[cell])
        verdict = PASSED if distances[worst] <= 1 else FAILED
        values = expected.get(worst, "–"), quantity.cell_texts.get(worst, MISSING)
        tolerance = str(quantity.tolerance)
        rows.append((verdict, *quantity[:3], distances[worst], *values, worst, tolerance))
    return pd.DataFrame(rows, columns=list(CHECK_COLUMNS))


def missing_reference_text(folder: Path) -> str:
    """Return what is missing in a folder, which has the study's name, and the remedy."""
    return f"{folder}: there is no reference; `make reference STUDIES={folder.name}` makes one"


def read_reference(folder: Path) -> ReferenceCells:
    """Read the cells of every quantity, one file for each part.

    Raises InputError where there is no reference, or a file of it that is none.
    """
    paths = sorted(folder.glob("*.csv"))
    if not paths:
        raise InputError(missing_reference_text(folder))
    reference: ReferenceCells = {}
    for path in paths:
        try:
            table = pd.read_csv(path, dtype=str, keep_default_na=False)
        except ValueError as error:
            raise InputError(f"{path}: {error}") from error
        if tuple(table)[:2] != REFERENCE_INDEX or not table["cell"].all():
            raise InputError(f"{path}: each line has {', '.join(REFERENCE_INDEX)} and values")
        part, columns = path.stem.replace("_", " "), table.columns[2:]
        for item, cell, *values in table.itertuples(index=False, name=None):
            for quantity, value in zip(columns, values, strict=True):
                if value:
                    reference.setdefault((part, item, quantity), {})[cell] = value
    return reference | picture_reference(folder)


def write_reference(quantities: Iterable[CheckedQuantity], results: Path, folder: Path) -> None:
    """Write a study's quantities and pictures in the place of an old reference.

    Raises InputError where a file cannot be written.
    """
    rows = [
        (*quantity[:3], *cell)
        for quantity in quantities
        if quantity.part != PICTURES_PART_NAME
        for cell in quantity.cell_texts.items()
    ]
    for path in (*folder.glob("*.csv"), *folder.glob(f"*{PLAIN_PICTURE_SUFFIX}")):
        path.unlink()
    table = pd.DataFrame(rows, columns=["part", "item", "quantity", "cell", "value"])
    for part, cells in table.groupby("part"):
        cells = cells.set_index([*REFERENCE_INDEX, "quantity"])["value"].unstack(sort=False)
        file = folder / f"{str(part).replace(' ', '_')}.csv"
        write_text(cells.reset_index().to_csv(index=False), file)
    for _, name, _ in picture_reference(results / PICTURES_FOLDER):
        shutil.copy(results / PICTURES_FOLDER / f"{name}{PLAIN_PICTURE_SUFFIX}", folder)


def picture_reference(folder: Path) -> ReferenceCells:
    """Return the zero difference of each plain figure of a folder from itself."""
    names = sorted(
        path.name.removesuffix(PLAIN_PICTURE_SUFFIX)
        for path in folder.glob(f"*{PLAIN_PICTURE_SUFFIX}")
    )
    return {
        (PICTURES_PART_NAME, name, "difference"): {PIXEL_RMS_LABEL: "0"}
        for name in names
        if name != UNREPRODUCIBLE_FIGURE
    }


def compare_pictures(pictures: Path, reference: Path) -> Iterator[CheckedQuantity]:
    """Yield the MAX_PICTURE_RMS difference of each figure's picture from the reference's picture.

    Fonts change a picture by more than a dropped curve does, hence no texts. Where it is too far
    off, the difference is drawn beside it.
    """
    for key in sorted(picture_reference(pictures) | picture_reference(reference)):
        expected, got = (
            folder / f"{key[1]}{PLAIN_PICTURE_SUFFIX}" for folder in (reference, pictures)
        )
        apart = "one of the two is missing"
        if expected.exists() and got.exists():
            got.with_name(f"{got.stem}-failed-diff.png").unlink(missing_ok=True)
            try:
                difference = compare_images(
                    str(expected), str(got), tol=MAX_PICTURE_RMS, in_decorator=True
                )
                apart = f"{difference['rms']:.3g}" if difference else "0"
            except (ImageComparisonFailure, OSError, SyntaxError) as error:
                apart = " ".join(str(error).split())
        yield CheckedQuantity(
            *key, {PIXEL_RMS_LABEL: apart}, CellTolerance(absolute=MAX_PICTURE_RMS)
        )


def passed_and_failed_text(table: pd.DataFrame, *, study: str) -> str:
    """Return a sentence with the number of quantities that passed or failed."""
    failed = int((table["verdict"] != PASSED).sum())
    if failed:
        missing = (
            "A missing file was not made: `make check` makes it and the studies that it needs."
        )
        sentences = [
            f"{failed} of {len(table)} quantities failed.",
            "Compare `expected` and `got` of the first that failed.",
            f"For an intended change `make reference STUDIES={study}` makes a new reference.",
            "Else code or packages have changed since the reference, or a file is damaged: delete "
            f"it, and `snakemake check --configfile config/{study}.yaml` makes it and what follows "
            "from it.",
            missing if (table["got"] == MISSING).any() else "",
        ]
        return " ".join(filter(None, sentences))
    passed = f"All {len(table)} quantities that are compared passed"
    largest = table["of_tolerance"].max()
    if not largest:
        return f"{passed}; they equal the reference."
    return (
        f"{passed}; the largest difference from the reference is {largest:.2g} of the allowed one."
    )


def failures_first(table: pd.DataFrame) -> pd.DataFrame:
    """Return the rows that failed, then those that passed; of either, causes stand first."""
    causes = list(FILE_TEMPLATE_OF_PART)
    by_part = table.sort_values("part", key=lambda parts: parts.map(causes.index), kind="stable")
    return by_part.sort_values("verdict", key=lambda verdicts: verdicts == PASSED, kind="stable")


def failed_files(table: pd.DataFrame, folder: Path) -> dict[Path, str]:
    """Return the files in a folder of results that have what failed, causes first.

    The text of a file tells where it was not made.
    """
    rows = failures_first(table[table["verdict"] != PASSED])
    items = zip(rows["part"], rows["item"], strict=True)
    paths = (folder / FILE_TEMPLATE_OF_PART[part].format(item) for part, item in items)
    return {path: "" if path.exists() else ": not made yet" for path in paths}


def worst_of_each_part(table: pd.DataFrame) -> pd.DataFrame:
    """Return how many quantities of each part passed, and the worst of them.

    A part that equals the reference has no worst quantity.
    """
    parts = table[table["verdict"] == PASSED].groupby("part", sort=False)
    worst = table.loc[parts["of_tolerance"].idxmax(), ["part", "of_tolerance", "item", "quantity"]]
    worst.insert(1, "passed", parts.size().to_numpy())
    worst[["item", "quantity"]] = worst[["item", "quantity"]].where(worst["of_tolerance"] > 0, "–")
    return worst


def terminal_text(table: pd.DataFrame, folder: Path) -> str:
    """Return the worst of each part, what failed in a folder of results, and the summary."""
    kinds = {"Worst of each part, of what passed": worst_of_each_part(table)}
    rows = failures_first(table[table["verdict"] != PASSED])
    if len(rows):
        kinds["Failed"] = rows
    files = failed_files(table, folder)
    how: dict[str, Any] = {
        "index": False,
        "max_colwidth": MAX_CELL_CHARACTERS,
        "float_format": "{:.2g}".format,
    }
    shown = [f"{title}:\n{rows.to_string(**how)}\n\n" for title, rows in kinds.items() if len(rows)]
    lines = [f"{file}{state}\n" for file, state in files.items()]
    paths = ["Files that failed:\n", *lines, "\n"] if files else []
    return "".join([*shown, *paths, passed_and_failed_text(table, study=folder.name)])


def tolerance_by_kind(solver: float) -> dict[str, CellTolerance]:
    """Return the tolerance of each kind of quantity for a solver tolerance."""
    return {
        # What the configuration gives, through plain arithmetic.
        "given": CellTolerance(relative=1e-9, fraction_of_largest=1e-12),
        # Derived in several steps, and local pressures, which the solver's tolerance is not of.
        "derived": CellTolerance(fraction_of_largest=0.01),
        # An optimum is flat: its place is known to the root of its value's accuracy.
        "place": CellTolerance(fraction_of_largest=1e-3),
        "design": CellTolerance(relative=1e-3),
        "force": CellTolerance(relative=2 * solver),
        # Errors of forces pass to fitted ones about one to one, also from five points.
        "model": CellTolerance(fraction_of_largest=4 * solver + 1e-7),
        # Norms of residuals over those of the forces move no more than the forces do.
        "residual": CellTolerance(absolute=4 * solver + 1e-7),
        # Errors of forces reach parameters sevenfold, and more in combination.
        "parameters": CellTolerance(
            relative=100 * solver + 1e-4, fraction_of_largest=100 * solver + 1e-6
        ),
        # As a text shows it: where the digits shown are more than are known, those.
        "shown": CellTolerance(relative=20 * solver, last_digit_units=1),
        # Estimated from small differences, whose digits depend on how the device rounds.
        "error": CellTolerance(relative=0.5, fraction_of_largest=0.05),
        # A plan's smallest forces are hundreds of times smaller than the largest.
        "relative error": CellTolerance(fraction_of_largest=min(0.05, 1e4 * solver)),
    }


def study_quantities(results: Results, reference: Path) -> list[CheckedQuantity]:
    """All quantities of a finished study, in the order in which they are checked.

    A file that is missing has none; those that a reference has of it then fail.

    Raises InputError naming a file that cannot be read or lacks what it must have.

    Args:
        reference: the folder with the pictures to compare the study's with.
    """
    config, folder = results.config, results.folder

    def file_stems_matching(pattern: str) -> list[str]:
        return sorted(path.stem for path in folder.glob(pattern))

    def items_matching(part: str, pattern: str) -> list[str]:
        before, _, after = FILE_TEMPLATE_OF_PART[part].partition("{}")
        files = sorted(path.relative_to(folder) for path in folder.glob(f"{pattern}.csv"))
        return [file.as_posix().removeprefix(before).removesuffix(after) for file in files]

    closeness = tolerance_by_kind(float(config.solver.tolerance))
    plans = sorted(path.parent.name for path in folder.glob("simulations/*/forces.csv"))
    items = [
        *(
            (part, item, _table_quantities)
            for part, patterns in TABLE_PATTERNS_OF_PART.items()
            for pattern in patterns
            for item in items_matching(part, pattern)
            if item != UNREPRODUCIBLE_FIGURE
        ),
        *(("claims", name, _claim_quantities) for name in file_stems_matching("claims.csv")),
        *(
            ("simulations", plan, _simulation_quantities)
            for plan in plans
            if plan[:10] != "validation"
        ),
        *(("fits", name, _fit_quantities) for name in file_stems_matching("fits/*.json")),
        *(("designs", name, _design_quantities) for name in FIT_OF_DESIGN),
    ]
    # A reference has a sample of the films; all of them take minutes.
    if config.numerics.extent == "sample" and results.has_file("numerics/stability.csv"):
        items.append(("numerics", "stability", _stability_quantities))
    quantities = [
        quantity for part, item, make in items for quantity in make(results, closeness, part, item)
    ]
    return [*quantities, *compare_pictures(folder / PICTURES_FOLDER, reference)]


def cell_text(value: Any) -> str:
    """A cell's text: twelve digits of a number, so that 7e-06 reads so."""
    if isinstance(value, bool | np.bool_) or not isinstance(value, int | float | np.number):
        return str(value)
    return f"{float(value):.12g}"


def column_quantities(
    table: pd.DataFrame, closeness: Mapping[str, CellTolerance], part: str, item: str
) -> Iterator[CheckedQuantity]:
    """A table's number of rows, then its columns thinned out, each as close as in
    TOLERANCE_KIND_OF_QUANTITY.

    Of a longer table, MAX_SAMPLED_ROWS rows evenly spaced are kept, and of its columns of numbers
    the least, the mean and the largest value, of texts how often each occurs; but of a plan's
    forces, up to MAX_FORCES_ALL_KEPT of them, every one.
    """
    yield CheckedQuantity(part, item, "rows", {"rows": str(len(table))})
    for name in map(str, table):
        column, column_path = table[name], f"{item} {name}"
        kinds = (
            kind
            for pattern, kind in TOLERANCE_KIND_OF_QUANTITY.items()
            if re.fullmatch(pattern, column_path)
        )
        kind = next(kinds, "derived" if column.dtype == float else None)
        every = (part, name) == ("simulations", "force_n") and len(table) <= MAX_FORCES_ALL_KEPT
        rows = len(table) if every else MAX_SAMPLED_ROWS
        cells = _sampled_cell_texts(column, rows)
        if len(table) > rows:
            cells |= _summary_cell_texts(column)
        yield CheckedQuantity(part, item, name, cells, closeness[kind] if kind else ZERO_TOLERANCE)


def _sampled_cell_texts(column: pd.Series, rows: int = MAX_SAMPLED_ROWS) -> dict[str, str]:
    kept = sorted({round(row) for row in np.linspace(0, len(column) - 1, rows)})
    return {f"row {row + 1}": cell_text(column.iloc[row]) for row in kept}


def _summary_cell_texts(column: pd.Series) -> dict[str, str]:
    """Return extremes and mean of numbers, or how often each text occurs, unless all differ."""
    if pd.api.types.is_float_dtype(column):
        extremes = column.agg(["min", "mean", "max"]).set_axis(["least", "mean", "largest"])
        return {str(name): cell_text(value) for name, value in extremes.items()}
    counts = column.astype(str).value_counts(sort=False)
    if len(counts) > MAX_SAMPLED_ROWS:
        return {}
    return {f"number of {text}": str(count) for text, count in counts.items()}


CheckedQuantities = Iterator[CheckedQuantity]
ToleranceOfKind = Mapping[str, CellTolerance]


def _table_quantities(
    results: Results, closeness: ToleranceOfKind, part: str, item: str
) -> CheckedQuantities:
    """All columns of a table."""
    table = results.table(FILE_TEMPLATE_OF_PART[part].format(item))
    return column_quantities(table, closeness, part, item)


def _claim_quantities(
    results: Results, closeness: ToleranceOfKind, part: str, item: str
) -> CheckedQuantities:
    """Every claim's verdict and our value; of the run time, the verdict alone."""
    table = results.table(f"{item}.csv", "claim_id", "claim", "paper", "ours", "unit", "verdict")
    for claim in table.fillna("").astype(str).to_dict("records"):
        name = claim["claim_id"]
        agrees = claim["verdict"].partition(" ")[0]
        yield CheckedQuantity(part, name, "verdict", {claim["claim"]: agrees})
        if name != "seconds":
            cells = {f"ours, in {claim['unit']}; paper: {claim['paper']}": claim["ours"]}
            yield CheckedQuantity(part, name, "ours", cells, closeness["shown"])


def _simulation_quantities(
    results: Results, closeness: ToleranceOfKind, part: str, item: str
) -> CheckedQuantities:
    """The forces of a plan, and whether error estimates keep the tolerance."""
    forces = results.forces(item)
    compared = forces.drop(columns=list(COLUMNS_NOT_COMPARED))
    yield from column_quantities(compared, closeness, part, item)
    largest = (forces["force_error_n"] / forces["force_n"].abs()).max()
    kept = {"of all points": str(largest <= results.config.solver.tolerance)}
    yield CheckedQuantity(part, item, "estimated errors within the tolerance", kept)


def _fit_quantities(
    results: Results, closeness: ToleranceOfKind, part: str, item: str
) -> CheckedQuantities:
    """A fit's objective, and what it predicts at the points of its plan."""
    fit = results.fit(item)
    objective = {"|y − η|/|y|": f"{fit.global_error:.9g}"}
    yield CheckedQuantity(part, item, "objective", objective, closeness["residual"])
    forces = fit.force_model.evaluate(fit.theta, factors_of_table(results.scenes(item)))
    yield CheckedQuantity(
        part, item, "predicted forces", _sampled_cell_texts(pd.Series(forces)), closeness["model"]
    )


def _design_quantities(
    results: Results, closeness: ToleranceOfKind, part: str, item: str
) -> CheckedQuantities:
    """D-efficiency of a design for the model that it was made for, times that of the best
    design."""
    fit, design = results.fit(FIT_OF_DESIGN[item]), results.design(item)
    slopes = fit.force_model.gradient(fit.theta, factors_of_table(design))
    sign, logarithm = np.linalg.slogdet(slopes.T @ slopes / len(slopes))
    worth = {"det(F'F/N)^(1/p)": cell_text(sign * np.exp(logarithm / len(fit.theta)))}
    yield CheckedQuantity(part, item, "D-efficiency", worth, closeness["design"])


def _stability_quantities(
    results: Results, closeness: ToleranceOfKind, part: str, item: str
) -> CheckedQuantities:
    """The verdict on every stiff or extreme film."""
    table = results.table("numerics/stability.csv", "case", "verdict").astype(str)
    verdicts = dict(zip(table["case"], table["verdict"], strict=True))
    yield CheckedQuantity(part, item, "verdicts", verdicts)
