"""What is really drawn: the figures' files, read as a reader would.

The SVG tells its axes with labels and ticks, its dots and where they lie in their axes, its lines
and its legends; the PNG its size and how much of it is ink. The note below a figure names the
device and makes the axes smaller by its lines: places are shares of the axes, and of the ticks only
the range is compared. In space, where a place on the page is none in the axes, dots are counted.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import numpy as np

from reporting.check.quantities import Quantity, by_name, guarded
from reporting.check.tolerances import SAME, AtMost, Close
from squeezefilm.io.errors import InputError

DRAWINGS = "drawings"
SVG = "{http://www.w3.org/2000/svg}"
BY_CHANCE = ("fig09",)
"""Figures of many searches: how many ended where is chance, and a rare pattern may be missing."""

ON_PAGE = Close(absolute=0.5)
IN_AXES = Close(absolute=0.01)
TICKS = Close(of_largest=0.35)
STROKES = Close(relative=0.1, absolute=2)
INK = Close(relative=0.2)
LEAST_INK = 0.003

_AXIS = re.compile(r"(matplotlib\.axis|axis3d)_\d+")
_AXES = re.compile(r"axes_\d+")
_TICK = re.compile(r"[xyz]tick_\d+")
_LEGEND = re.compile(r"legend_\d+")
_TEXT = re.compile(r"text_\d+")
_PATCH = re.compile(r"patch_\d+")
_DECIMAL = re.compile(r"-?\d+(?:\.\d+)?")
_NUMBER = re.compile(r"[-−]?\d+(\.\d+)?")


@dataclass
class Drawing:
    """What one SVG shows: sizes in points, an entry for each axis.

    dots counts the dots; places are theirs, as shares of the width and height of their axes.
    """

    width_pt: float
    height_pt: float
    axes: int = 0
    labels: list[str] = field(default_factory=list)
    ticks: list[list[str]] = field(default_factory=list)
    legends: list[str] = field(default_factory=list)
    dots: int = 0
    places: list[tuple[float, float]] = field(default_factory=list)
    strokes: int = 0


def read_drawing(path: Path) -> Drawing:
    """Read an SVG that matplotlib wrote with its text as text.

    Raises InputError for a file that is missing or is no such drawing.
    """
    try:
        root = ElementTree.fromstring(path.read_bytes(), ElementTree.XMLParser(target=_builder()))
        width, height = (float(root.attrib[key].removesuffix("pt")) for key in ("width", "height"))
    except FileNotFoundError:
        raise InputError(f"{path}: there is no such drawing") from None
    except (OSError, ElementTree.ParseError, KeyError, ValueError) as error:
        raise InputError(f"{path}: not a drawing by matplotlib: {error}") from None
    drawing = Drawing(width, height)
    _walk(root, drawing, frame=None)
    return drawing


def _builder() -> ElementTree.TreeBuilder:
    """Comments are kept: there matplotlib writes a label with its formulae, in one piece."""
    return ElementTree.TreeBuilder(insert_comments=True)


@dataclass(frozen=True)
class _Frame:
    """The box of some axes on the page, where it is known: in space it is not."""

    left: float = np.nan
    top: float = np.nan
    width: float = np.nan
    height: float = np.nan

    def place(self, x: float, y: float) -> tuple[float, float]:
        """Shares of the width from the left and of the height from below."""
        return (x - self.left) / self.width, 1 - (y - self.top) / self.height


def _walk(element: Element, drawing: Drawing, *, frame: _Frame | None) -> None:
    """Count what an element draws; ``frame`` is that of the axes that it lies in, if any."""
    for child in element:
        name = child.attrib.get("id", "") if isinstance(child.tag, str) else ""
        if child.tag == f"{SVG}defs":
            continue
        if _AXIS.fullmatch(name):
            _read_axis(child, drawing)
        elif _LEGEND.fullmatch(name):
            drawing.legends += [_masked(text) for text in _texts(child)]
        elif _AXES.fullmatch(name):
            drawing.axes += 1
            _walk(child, drawing, frame=_frame_of(child))
        elif child.tag == f"{SVG}use" and frame:
            drawing.dots += 1
            drawing.places.append(frame.place(float(child.attrib["x"]), float(child.attrib["y"])))
        elif child.tag == f"{SVG}path" and frame:
            drawing.strokes += 1
        else:
            _walk(child, drawing, frame=frame)


def _frame_of(axes: Element) -> _Frame:
    """The box of axes in a plane: their background, which is drawn before everything else."""
    first = next(iter(axes), None)
    path = None if first is None else first.find(f"{SVG}path")
    if first is None or path is None or not _PATCH.fullmatch(first.attrib.get("id", "")):
        return _Frame()
    numbers = np.array([float(text) for text in _DECIMAL.findall(path.attrib["d"])])
    x, y = numbers[0::2], numbers[1::2]
    return _Frame(x.min(), y.min(), np.ptp(x), np.ptp(y))


def _read_axis(axis: Element, drawing: Drawing) -> None:
    ticks, label = [], ""
    for child in axis:
        name = child.attrib.get("id", "") if isinstance(child.tag, str) else ""
        if _TICK.fullmatch(name):
            ticks += _texts(child)
        elif _TEXT.fullmatch(name):
            label = " ".join(_texts(child))
    drawing.labels.append(label)
    drawing.ticks.append(ticks)


def _texts(element: Element) -> list[str]:
    """Every text below an element: with formulae from the comment, else as it stands."""
    found = []
    for child in element.iter():
        text = (child.text or "").strip()
        if text and child.tag in (ElementTree.Comment, f"{SVG}text"):
            found.append(text)
    return found


def _masked(text: str) -> str:
    """Numbers of a legend may be results."""
    return _NUMBER.sub("#", text)


def drawing_quantities(results: Path) -> Iterator[Quantity]:
    """The structure of every figure's two files."""
    folder = results / "figures"
    for name in by_name(folder, "*.csv"):
        yield from guarded(DRAWINGS, name, partial(_svg, folder, name))
        yield from guarded(DRAWINGS, name, partial(_png, folder, name))


def _svg(folder: Path, name: str) -> Iterator[Quantity]:
    drawing = read_drawing(folder / f"{name}.svg")
    size = {"width": f"{drawing.width_pt:g}", "height": f"{drawing.height_pt:g}"}
    yield Quantity(DRAWINGS, name, "size in points", size, ON_PAGE)
    yield Quantity(DRAWINGS, name, "axes", {"number": str(drawing.axes)}, SAME)
    labels = {f"axis {number}": text for number, text in enumerate(drawing.labels, start=1)}
    yield Quantity(DRAWINGS, name, "axis labels", labels, SAME)
    for number, texts in enumerate(drawing.ticks, start=1):
        if texts:
            yield _ticks(name, f"ticks of axis {number}", texts)
    if drawing.legends and name not in BY_CHANCE:
        entries = {f"entry {number}": text for number, text in enumerate(drawing.legends, start=1)}
        yield Quantity(DRAWINGS, name, "legend", entries, SAME)
    yield Quantity(DRAWINGS, name, "dots", {"number": str(drawing.dots)}, SAME)
    if drawing.dots and name not in BY_CHANCE and np.all(np.isfinite(drawing.places)):
        x, y = np.transpose(drawing.places)
        cells = {
            f"{how} {axis}": f"{function(values):.4f}"
            for axis, values in (("x", x), ("y", y))
            for how, function in (("least", np.min), ("mean", np.mean), ("largest", np.max))
        }
        yield Quantity(DRAWINGS, name, "dots' places, as shares of their axes", cells, IN_AXES)
    yield Quantity(DRAWINGS, name, "strokes", {"number": str(drawing.strokes)}, STROKES)


def _ticks(figure: str, name: str, texts: list[str]) -> Quantity:
    """The range of the ticks, where they are numbers: how many there are depends on the room."""
    try:
        numbers = [float(text.replace("−", "-")) for text in texts]
    except ValueError:
        return Quantity(DRAWINGS, figure, name, {"texts": " ".join(texts)}, SAME)
    cells = {"least": f"{min(numbers):g}", "largest": f"{max(numbers):g}"}
    return Quantity(DRAWINGS, figure, name, cells, TICKS)


def _png(folder: Path, name: str) -> Iterator[Quantity]:
    from matplotlib.image import imread

    path = folder / f"{name}.png"
    try:
        pixels = imread(path)
    except FileNotFoundError:
        raise InputError(f"{path}: there is no such drawing") from None
    except (OSError, SyntaxError, ValueError) as error:
        raise InputError(f"{path}: not a PNG: {error}") from None
    ink = float(np.mean(np.any(pixels[..., :3] < 0.9, axis=-1)))
    size = {"width": str(pixels.shape[1]), "height": str(pixels.shape[0])}
    yield Quantity(DRAWINGS, name, "size in pixels", size, Close(absolute=6))
    blank = {"least ink over that found": f"{LEAST_INK / ink:.3g}" if ink else "inf"}
    yield Quantity(DRAWINGS, name, "not blank", blank, AtMost(1.0))
    yield Quantity(DRAWINGS, name, "ink", {"share of the pixels": f"{ink:.4f}"}, INK)
