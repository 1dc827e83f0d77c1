"""Common style of the figures: size, type, colour, the note below, and saving."""

import logging
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path
from textwrap import wrap
from typing import Any

import matplotlib as mpl
import pandas as pd
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.legend import Legend
from matplotlib.text import Text
from matplotlib.ticker import LogLocator, NullFormatter, StrMethodFormatter

from squeezefilm.errors import InputError
from squeezefilm.files import atomic_file, read_text

SINGLE_COLUMN_IN = 3.5
DOUBLE_COLUMN_IN = 7.16
PNG_DPI = 300
CHECK_PICTURE_DPI = 50
PLAIN_PICTURE_SUFFIX = ".plain.png"
"""How the name of a small picture without texts ends."""

# Okabe and Ito's colours, told apart with every common colour vision.
BLUE, VERMILLION, GREEN, ORANGE, PURPLE = "#0072B2", "#D55E00", "#009E73", "#E69F00", "#CC79A7"
GREY = "#6E6E6E"
DASHED_LINE = (0, (4, 2))
SEQUENTIAL_COLOURMAP = "viridis"
DIVERGING_COLOURMAP = "PuOr_r"

NOTE_SIZE_PT = 6.0
_NOTE_LETTERS_PER_IN = 22
_NOTE_LINE_IN = NOTE_SIZE_PT * 1.3 / 72
_MARGIN_IN = 0.03
_NOTE_INDENT_IN = 0.05

_STYLE_FILE = Path(__file__).with_name("squeezefilm.mplstyle")

# Dates and versions would make equal drawings differ.
_NO_METADATA: dict[str, dict[str, None]] = {
    ".png": {"Software": None},
    ".svg": {"Date": None, "Creator": None},
    ".pdf": {"CreationDate": None, "Creator": None, "Producer": None},
}


_notes_enabled: ContextVar[bool] = ContextVar("with_notes", default=True)


def read_style(file: Path) -> dict[Any, Any]:
    """Return the settings in a style file of matplotlib.

    Raises InputError naming the file and the line that matplotlib does not take.
    """
    read_text(file, what="style file")
    log, problems = logging.getLogger("matplotlib"), list[logging.LogRecord]()
    keep: Any = problems.append
    log.addFilter(keep)  # what matplotlib does not take it logs, and goes on
    settings = dict(mpl.rc_params_from_file(file, use_default_template=False))
    log.removeFilter(keep)
    for problem in problems:
        reason = problem.getMessage().strip().splitlines()[0]
        raise InputError(f"{file}: not a style file of matplotlib: {reason}")
    return settings


@contextmanager
def figure_style(*, notes: bool = True, file: Path | None = None) -> Iterator[None]:
    """The style, as a context in which figures are drawn and saved, with their notes or without.

    Args:
        file: a style file of matplotlib, whose settings are used beside those here.
    """
    chosen: dict[Any, Any] = dict(mpl.rcParamsDefault) | read_style(_STYLE_FILE)
    chosen |= (read_style(file) if file else {}) | {"backend": "agg"}
    token = _notes_enabled.set(notes)
    with mpl.rc_context(chosen):
        yield
    _notes_enabled.reset(token)


def new_figure(*, wide: bool = False, height_in: float = 2.7) -> Figure:
    """An empty figure, one journal column wide or two, whose parts make room for each other."""
    width_in = DOUBLE_COLUMN_IN if wide else SINGLE_COLUMN_IN
    return Figure(figsize=(width_in, height_in), layout="constrained")


def subplots(*shape: int, wide: bool = False, height_in: float = 2.7, **how: Any) -> Any:
    """A new figure and its axes: one, or an array of so many rows and columns."""
    figure = new_figure(wide=wide, height_in=height_in)
    return figure, figure.subplots(*shape, **how)


def add_note(figure: Figure, *lines: str) -> float:
    """Write lines below the figure, as wide as it; returns the share of the height they take.

    Without any there is room for one.
    """
    width_in, height_in = figure.get_size_inches()
    letters = int(_NOTE_LETTERS_PER_IN * width_in)
    shown = [part for line in lines if _notes_enabled.get() for part in wrap(line, letters)] or [""]
    look: dict[str, Any] = {"fontsize": NOTE_SIZE_PT, "color": "0.25", "linespacing": 1.2}
    corner = _NOTE_INDENT_IN / width_in, _MARGIN_IN / height_in
    figure.text(*corner, "\n".join(shown), va="bottom", **look)
    taken = float((2 * _MARGIN_IN + len(shown) * _NOTE_LINE_IN) / height_in)
    engine = figure.get_layout_engine()
    if isinstance(engine, ConstrainedLayoutEngine):
        engine.set(rect=(0, taken, 1, 1 - taken))
    return taken


def set_plain_log_ticks(axis: Axis, *, at: Sequence[float] = (1, 2, 5)) -> None:
    """A logarithmic axis with plain numbers at these places of each decade."""
    axis.set_major_locator(LogLocator(subs=at))
    axis.set_major_formatter(StrMethodFormatter("{x:g}"))
    axis.set_minor_formatter(NullFormatter())


def layer_rows(data: pd.DataFrame, layer: str) -> pd.DataFrame:
    """The rows of one layer, in the table's order."""
    return data[data["layer"] == layer]


def freeze_layout(figure: Figure) -> None:
    """Run the layout engine once and freeze axes positions at nine digits, equal in each run.

    Without an engine it is drawn once for a file, not twice.
    """
    engine = figure.get_layout_engine()
    if engine is not None:
        engine.execute(figure)
        figure.set_layout_engine(None)
    if isinstance(engine, ConstrainedLayoutEngine):
        for part in figure.subfigs:
            part.bbox_relative.set_points(part.bbox_relative.get_points().round(9))
        for axes in figure.axes:
            bounds = axes.get_position(original=True).bounds
            axes.set_position((*(round(bound, 9) for bound in bounds),), which="both")


def save_without_text(figure: Figure, paths: Iterable[Path | str]) -> None:
    """Save small pictures that no font changes: without texts, numbers at axes and legends."""
    for axis in figure.findobj(Axis):
        axis.set_major_formatter(NullFormatter())
        axis.set_minor_formatter(NullFormatter())
    for part in (*figure.findobj(Text), *figure.findobj(Legend)):
        part.set_visible(False)
    figure.set_dpi(CHECK_PICTURE_DPI)
    save_figure(figure, paths, dpi=CHECK_PICTURE_DPI)


def save_figure(figure: Figure, paths: Iterable[Path | str], *, dpi: float = PNG_DPI) -> None:
    """Save in the formats that the names ask for, byte for byte the same each time."""
    freeze_layout(figure)
    for path in map(Path, paths):
        with atomic_file(path) as part:
            kind = path.suffix.removeprefix(".")
            figure.savefig(part, format=kind, dpi=dpi, metadata=_NO_METADATA[path.suffix])
