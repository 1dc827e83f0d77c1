"""Figures drawn small and without texts, beside those of a reference."""

import shutil
from pathlib import Path

from matplotlib.testing.compare import compare_images
from matplotlib.testing.exceptions import ImageComparisonFailure

from reporting.figures.style import PLAIN

Key = tuple[str, str, str]

PICTURES, PLACE_OF_PICTURES = "pictures", "check/figures"
BY_CHANCE = "fig09"
"""The figure of many searches: which of them ended where is chance."""
RMS = 1.5
"""Of the pixels (0 to 255) between two pictures. In the paper's figures a dropped curve makes 2.4
to 30, a line of the band 4.4, the zero line of Figure 14 1.8, forces off by 1e-4 0.1. A line of the
small film in `overview` makes 0.2 and is not seen, nor is one that others hide."""
PIXELS = "RMS of the pixels"


def pictures_of(folder: Path) -> dict[Key, dict[str, str]]:
    """What each picture of a folder is apart from itself."""
    names = sorted(path.name.removesuffix(PLAIN) for path in folder.glob(f"*{PLAIN}"))
    return {(PICTURES, name, "difference"): {PIXELS: "0"} for name in names if name != BY_CHANCE}


def apart(key: Key, pictures: Path, reference: Path) -> dict[str, str]:
    """How far a figure's picture is from the one in a reference's folder.

    Fonts change a picture by more than a dropped curve does, hence no texts. Where it is too far
    off, the difference is drawn beside it.
    """
    expected, got = (folder / f"{key[1]}{PLAIN}" for folder in (reference, pictures))
    if not (expected.exists() and got.exists()):
        return {PIXELS: "one of the two is missing"}
    try:
        found = compare_images(str(expected), str(got), tol=RMS, in_decorator=True)
    except (ImageComparisonFailure, OSError, SyntaxError) as error:
        return {PIXELS: " ".join(str(error).split())}
    return {PIXELS: f"{found['rms']:.3g}" if found else "0"}


def write_pictures(pictures: Path, reference: Path) -> None:
    """Make a study's pictures those of the reference, which may be new."""
    reference.mkdir(parents=True, exist_ok=True)
    for old in reference.glob(f"*{PLAIN}"):
        old.unlink()
    for _, name, _ in pictures_of(pictures):
        shutil.copy(pictures / f"{name}{PLAIN}", reference)
