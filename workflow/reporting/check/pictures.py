"""The figures' pictures without their texts, beside small stored ones.

Fonts change a picture by more than a dropped curve does, and a note has the device's name: for the
check a figure is drawn without any text (NAME.plain.png of `squeezefilm figure`). The numbers drawn
are compared by column; what axes and legend say is read in a figure's module, not here.
"""

import shutil
from collections.abc import Iterator
from functools import partial
from pathlib import Path

from matplotlib.testing.compare import compare_images
from matplotlib.testing.exceptions import ImageComparisonFailure

from reporting.check.quantities import Quantity, by_name, guarded
from reporting.check.tolerances import AtMost
from reporting.figures import PLAIN
from squeezefilm.io.errors import InputError

PICTURES = "pictures"
DIFFERENCE = "difference"
PLACE = "check/figures"
"""Of the pictures among a study's results."""
BY_CHANCE = ("fig09",)
"""Figures of many searches: how many ended where is chance, and a rare pattern may be missing."""
TOLERANCE = 1.5
"""RMS of the pixels (0 to 255). In the paper's figures a dropped curve makes 2.4 to 30, a line of
the band 4.4, the zero line of Figure 14 1.8, forces off by 1e-4 0.1. A line of the small film in
`overview` makes 0.2 and is not seen, nor is one that others hide."""


def picture_quantities(results: Path, reference: Path) -> Iterator[Quantity]:
    """How far each figure's picture is from the one in a reference's folder."""
    for name in _names(results):
        pictures = (folder / f"{name}{PLAIN}" for folder in (results / PLACE, reference))
        yield from guarded(PICTURES, name, partial(_beside, name, *pictures))


def _names(results: Path) -> list[str]:
    return [name for name in by_name(results / "figures", "*.csv") if name not in BY_CHANCE]


def _beside(name: str, got: Path, expected: Path) -> Iterator[Quantity]:
    """One picture; where it is too far off, the difference is drawn beside it."""
    if not got.exists():
        raise InputError(f"{got}: there is no such picture")
    apart = "no picture in the reference"
    if expected.exists():
        try:
            found = compare_images(str(expected), str(got), tol=TOLERANCE, in_decorator=True)
            apart = f"{found['rms']:.3g}" if found else "0"
        except (ImageComparisonFailure, OSError, SyntaxError) as error:
            apart = " ".join(str(error).split())
    yield Quantity(PICTURES, name, DIFFERENCE, {"RMS of the pixels": apart}, AtMost(TOLERANCE))


def expected_pictures(reference: Path) -> dict[tuple[str, str, str], dict[str, str]]:
    """What a picture of a reference is apart from itself, as cells."""
    return {
        (PICTURES, name.removesuffix(".plain"), DIFFERENCE): {"RMS of the pixels": "0"}
        for name in by_name(reference, f"*{PLAIN}")
    }


def write_pictures(results: Path, reference: Path) -> None:
    """Make a study's pictures those of the reference."""
    for old in reference.glob(f"*{PLAIN}"):
        old.unlink()
    for name in _names(results):
        shutil.copy(results / PLACE / f"{name}{PLAIN}", reference)
