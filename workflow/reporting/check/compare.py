"""Quantities beside their references: one table with a verdict for each."""

import math
import re
import shutil
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pandas as pd
from matplotlib.testing.compare import compare_images
from matplotlib.testing.exceptions import ImageComparisonFailure

from reporting.figures.style import PLAIN
from squeezefilm.errors import InputError
from squeezefilm.tables import write_table

PASSED, FAILED = "passed", "failed"
COLUMNS = (
    *("part", "item", "quantity", "expected", "got", "tolerance", "verdict", "worst"),
    "of_tolerance",
)
"""``worst`` names the cell that is farthest off, ``expected`` and ``got`` are its two values,
``of_tolerance`` is how much of the tolerance it takes."""
REFERENCE_COLUMNS = ("item", "quantity", "cell", "value")
WIDEST = 40
"""Characters of a cell on the screen; all of it is in the table."""
PICTURES, PLACE_OF_PICTURES = "pictures", "check/figures"
BY_CHANCE = "fig09"
"""The figure of many searches: which of them ended where is chance."""
RMS = 1.5
"""Of the pixels (0 to 255) between two pictures. In the paper's figures a dropped curve makes 2.4
to 30, a line of the band 4.4, the zero line of Figure 14 1.8, forces off by 1e-4 0.1. A line of the
small film in `overview` makes 0.2 and is not seen, nor is one that others hide."""
PIXELS = "RMS of the pixels"
_NUMBER = re.compile(r"[-−]?\d+(?:\.(\d+))?(?:e([-−+]?\d+))?")

Key = tuple[str, str, str]
Cells = Mapping[str, str]
Reference = dict[Key, dict[str, str]]
"""The cells of every quantity, by part, item and name."""


@dataclass(frozen=True)
class Close:
    """Texts of equal words, and numbers in them within the sum of what is given.

    Attributes:
        relative: a share of each value.
        of_largest: a share of the largest magnitude in the column.
        absolute: an amount.
        digits: units of the last digit that is shown.
    """

    relative: float = 0.0
    of_largest: float = 0.0
    absolute: float = 0.0
    digits: float = 0.0

    def __str__(self) -> str:
        parts = [f"{size:.2g} {name}" for name, size in vars(self).items() if size]
        return " + ".join(parts).replace("_", " ") or "equal"

    def distances(self, expected: Cells, got: Cells) -> dict[str, float]:
        """The difference of each cell over what is allowed there: at most one passes."""
        sizes = [abs(_value(text)) for text in expected.values() if _NUMBER.fullmatch(text)]
        amount = self.absolute + self.of_largest * max(sizes, default=0.0)
        cells = dict.fromkeys([*expected, *got])
        return {cell: self._distance(expected.get(cell), got.get(cell), amount) for cell in cells}

    def _distance(self, expected: str | None, got: str | None, amount: float) -> float:
        if expected == got:
            return 0.0
        if expected is None or got is None or _NUMBER.sub("#", expected) != _NUMBER.sub("#", got):
            return math.inf
        largest = 0.0
        for one, other in zip(_NUMBER.finditer(expected), _NUMBER.finditer(got), strict=True):
            want, have = _value(one.group()), _value(other.group())
            unit = max(_last_digit(one), _last_digit(other))
            allowed = amount + self.relative * abs(want) + self.digits * unit
            if want != have:  # just over one by rounding counts as one
                share = round(abs(want - have) / allowed, 6) if allowed else math.inf
                largest = max(largest, share)
        return largest


SAME = Close()


@dataclass(frozen=True)
class Quantity:
    """One column, list or text of a study: its cells by name, as text, and how close they must be.

    part and item say where it belongs: figure data, fig08.
    """

    part: str
    item: str
    name: str
    cells: Cells = field(default_factory=dict)
    tolerance: Close = SAME

    @property
    def key(self) -> Key:
        """Part, item and name."""
        return self.part, self.item, self.name


def _value(text: str) -> float:
    return float(text.replace("−", "-"))


def _last_digit(number: re.Match[str]) -> float:
    decimals, exponent = number.group(1) or "", (number.group(2) or "0").replace("−", "-")
    return float(10.0 ** (int(exponent) - len(decimals)))


def compare(quantities: Iterable[Quantity], reference: Mapping[Key, Cells]) -> pd.DataFrame:
    """A row for every quantity, then one for each that the reference has and the study lacks.

    A quantity that the reference does not have fails as well: it was never reviewed.
    """
    quantities = list(quantities)
    keys = {each.key for each in quantities}
    quantities += [Quantity(*key) for key in reference if key not in keys]
    rows = []
    for each in quantities:
        expected = reference.get(each.key, {})
        distances = each.tolerance.distances(expected, each.cells) or {"": math.inf}
        worst = max(distances, key=lambda cell: distances[cell])
        verdict = PASSED if distances[worst] <= 1 else FAILED
        values = expected.get(worst, "–"), each.cells.get(worst, "missing")
        rows.append((*each.key, *values, str(each.tolerance), verdict, worst, distances[worst]))
    return pd.DataFrame(rows, columns=list(COLUMNS))


def read_reference(folder: Path) -> Reference:
    """Read the cells of every quantity, one file for each part.

    Raises InputError where there is no reference, or a file of it that is none.
    """
    paths = sorted(folder.glob("*.csv"))
    if not paths:
        raise InputError(f"{folder}: there is no reference; `make reference` makes one")
    reference: Reference = {}
    for path in paths:
        try:
            table = pd.read_csv(path, dtype=str, keep_default_na=False)
        except ValueError as error:
            raise InputError(f"{path}: {error}") from error
        if tuple(table) != REFERENCE_COLUMNS or not table["cell"].all():
            raise InputError(f"{path}: each line has {', '.join(REFERENCE_COLUMNS)}")
        part = path.stem.replace("_", " ")
        for item, quantity, cell, value in table.itertuples(index=False, name=None):
            reference.setdefault((part, item, quantity), {})[cell] = value
    return reference | pictures_of(folder)


def write_reference(quantities: Iterable[Quantity], results: Path, folder: Path) -> None:
    """Write a study's quantities and pictures in the place of an old reference.

    Raises InputError where a file cannot be written.
    """
    parts: dict[str, list[tuple[str, ...]]] = {}
    for each in quantities:
        rows = parts.setdefault(each.part, [])
        rows += [(each.item, each.name, *cell) for cell in each.cells.items()]
    for path in folder.glob("*.csv"):
        path.unlink()
    folder.mkdir(parents=True, exist_ok=True)
    for path in folder.glob(f"*{PLAIN}"):
        path.unlink()
    for _, name, _ in pictures_of(results / PLACE_OF_PICTURES):
        shutil.copy(results / PLACE_OF_PICTURES / f"{name}{PLAIN}", folder)
    parts.pop(PICTURES, None)
    for part, rows in parts.items():
        table = pd.DataFrame(rows, columns=list(REFERENCE_COLUMNS))
        write_table(table, folder / f"{part.replace(' ', '_')}.csv")


def pictures_of(folder: Path) -> Reference:
    """What each figure of a folder, drawn small and without texts, is apart from itself."""
    names = sorted(path.name.removesuffix(PLAIN) for path in folder.glob(f"*{PLAIN}"))
    return {(PICTURES, name, "difference"): {PIXELS: "0"} for name in names if name != BY_CHANCE}


def picture_quantities(pictures: Path, reference: Path) -> Iterator[Quantity]:
    """How far each figure's picture is from the one in a reference's folder.

    Fonts change a picture by more than a dropped curve does, hence no texts. Where it is too far
    off, the difference is drawn beside it.
    """
    for key in sorted(pictures_of(pictures) | pictures_of(reference)):
        expected, got = (folder / f"{key[1]}{PLAIN}" for folder in (reference, pictures))
        apart = "one of the two is missing"
        if expected.exists() and got.exists():
            try:
                found = compare_images(str(expected), str(got), tol=RMS, in_decorator=True)
                apart = f"{found['rms']:.3g}" if found else "0"
            except (ImageComparisonFailure, OSError, SyntaxError) as error:
                apart = " ".join(str(error).split())
        yield Quantity(*key, {PIXELS: apart}, Close(absolute=RMS))


def summary(table: pd.DataFrame) -> str:
    """How many quantities passed, in a sentence."""
    failed = int((table["verdict"] != PASSED).sum())
    if failed:
        return f"{failed} of {len(table)} quantities failed."
    return f"All {len(table)} quantities passed."


def on_screen(table: pd.DataFrame) -> str:
    """Return each part's worst quantity, all that failed, and the summary."""
    failed = table["verdict"] != PASSED
    worst = table.loc[table.groupby("part", sort=False)["of_tolerance"].idxmax()]
    kinds = {"Worst of each part": worst[["part", "item", "quantity", "of_tolerance"]]}
    if failed.any():
        kinds["Failed"] = table[failed]
    how: dict[str, Any] = {"index": False, "max_colwidth": WIDEST, "float_format": "{:.2g}".format}
    shown = [f"{title}:\n{rows.to_string(**how)}\n\n" for title, rows in kinds.items()]
    return "".join([*shown, summary(table)])
