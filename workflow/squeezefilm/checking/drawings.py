"""What is really drawn: the figures' files, read as a reader would.

The SVG tells its axes with labels and ticks, its dots and where they lie on the page, its lines
and its legends; the PNG its size and how much of it is ink. Positions are on the page, in points:
they follow from the data and from the layout, which the pinned versions make the same everywhere.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import numpy as np

from squeezefilm.checking.quantities import Quantity, guarded
from squeezefilm.checking.tolerances import SAME, AtMost, Close
from squeezefilm.errors import InputError
from squeezefilm.figures import FIGURES

DRAWINGS = "drawings"
SVG = "{http://www.w3.org/2000/svg}"
LINK = "{http://www.w3.org/1999/xlink}href"
SLIDING = ("fig16",)
"""Figures that show where the points of the four-factor design lie, which rounding decides."""

ON_PAGE = Close(absolute=1.5)
STROKES = Close(relative=0.1, absolute=2)
INK = Close(relative=0.2)
LEAST_INK = 0.003

_AXIS = re.compile(r"(matplotlib\.axis|axis3d)_\d+")
_AXES = re.compile(r"axes_\d+")
_TICK = re.compile(r"[xyz]tick_\d+")
_LEGEND = re.compile(r"legend_\d+")
_TEXT = re.compile(r"text_\d+")
_NUMBER = re.compile(r"[-−]?\d+(\.\d+)?")


@dataclass
class Drawing:
    """What one SVG shows: sizes in points, an entry for each axis, its dots as (x, y)."""

    width_pt: float
    height_pt: float
    axes: int = 0
    labels: list[str] = field(default_factory=list)
    ticks: list[str] = field(default_factory=list)
    legends: list[str] = field(default_factory=list)
    dots: list[tuple[float, float]] = field(default_factory=list)
    strokes: int = 0


def read_drawing(path: Path) -> Drawing:
    """Read an SVG that matplotlib wrote with its text as text.

    Raises:
        InputError: for a file that is missing or is no such drawing.
    """
    try:
        root = ElementTree.fromstring(path.read_bytes(), ElementTree.XMLParser(target=_builder()))
        width, height = (float(root.attrib[key].removesuffix("pt")) for key in ("width", "height"))
    except FileNotFoundError:
        raise InputError(f"{path}: there is no such drawing") from None
    except (OSError, ElementTree.ParseError, KeyError, ValueError) as error:
        raise InputError(f"{path}: not a drawing by matplotlib: {error}") from None
    drawing = Drawing(width, height)
    _walk(root, drawing, inside="")
    return drawing


def _builder() -> ElementTree.TreeBuilder:
    """Comments are kept: there matplotlib writes a label with its formulae, in one piece."""
    return ElementTree.TreeBuilder(insert_comments=True)


def _walk(element: Element, drawing: Drawing, *, inside: str) -> None:
    """Count what an element draws; ``inside`` is the kind of group that it lies in."""
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
            _walk(child, drawing, inside="axes")
        elif child.tag == f"{SVG}use" and inside:
            drawing.dots.append((float(child.attrib["x"]), float(child.attrib["y"])))
        elif child.tag == f"{SVG}path" and inside:
            drawing.strokes += 1
        else:
            _walk(child, drawing, inside=inside)


def _read_axis(axis: Element, drawing: Drawing) -> None:
    ticks, label = [], ""
    for child in axis:
        name = child.attrib.get("id", "") if isinstance(child.tag, str) else ""
        if _TICK.fullmatch(name):
            ticks += _texts(child)
        elif _TEXT.fullmatch(name):
            label = " ".join(_texts(child))
    drawing.labels.append(label)
    drawing.ticks.append(" ".join(ticks))


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
    for name in FIGURES:
        folder = results / "figures"
        yield from guarded(DRAWINGS, name, partial(_svg, folder, name))
        yield from guarded(DRAWINGS, name, partial(_png, folder, name))


def _svg(folder: Path, name: str) -> Iterator[Quantity]:
    drawing = read_drawing(folder / f"{name}.svg")
    size = {"width": f"{drawing.width_pt:g}", "height": f"{drawing.height_pt:g}"}
    # The note below makes room for itself, and its length depends on the device's name.
    yield Quantity(DRAWINGS, name, "size in points", size, ON_PAGE)
    yield Quantity(DRAWINGS, name, "axes", {"number": str(drawing.axes)}, SAME)
    for what, texts in (("axis labels", drawing.labels), ("ticks", drawing.ticks)):
        cells = {f"axis {number}": text for number, text in enumerate(texts, start=1)}
        yield Quantity(DRAWINGS, name, what, cells, SAME)
    if drawing.legends:
        entries = {f"entry {number}": text for number, text in enumerate(drawing.legends, start=1)}
        yield Quantity(DRAWINGS, name, "legend", entries, SAME)
    yield Quantity(DRAWINGS, name, "dots", {"number": str(len(drawing.dots))}, SAME)
    if drawing.dots and name not in SLIDING:
        x, y = np.transpose(drawing.dots)
        cells = {
            f"{how} {axis}": f"{function(values):.2f}"
            for axis, values in (("x", x), ("y", y))
            for how, function in (("least", np.min), ("mean", np.mean), ("largest", np.max))
        }
        yield Quantity(DRAWINGS, name, "dots' places on the page, in points", cells, ON_PAGE)
    yield Quantity(DRAWINGS, name, "strokes", {"number": str(drawing.strokes)}, STROKES)


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
