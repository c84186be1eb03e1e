"""The look of all figures, and how they reach the disk."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import Colormap
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.textpath import TextPath
from matplotlib.ticker import LogLocator, MaxNLocator, NullFormatter, ScalarFormatter

from fbcouple.postproc.files import write_whole

DPI = 200
FONT_SIZE = 8.0
COLUMN = 3.5  # inches, one column of a journal
PAGE = 7.0  # inches, both columns

# Okabe and Ito 2008: told apart with every kind of colour vision, and by lightness in grey.
BLUE, VERMILION, GREEN, ORANGE, SKY, INK, GREY = (
    "#0072B2",
    "#D55E00",
    "#009E73",
    "#E69F00",
    "#56B4E9",
    "#222222",
    "#6B6B6B",
)
_FORMULA = "\ue000"
ROUNDING = 1e-9
"""Part of a colour scale: the mean square about a mean, of what does not move, is -1e-17."""
WINDOW_SHADE = "#E9EEF4"
_MARKS = ((10.0, (1.0, 1.5, 2.0, 3.0, 5.0, 7.0)), (100.0, (1.0, 2.0, 5.0)), (1e4, (1.0, 3.0)))
"""Span of a logarithmic axis, and what is marked on a shorter one; on a longer one powers of ten alone."""
_LINEAR = 3.0
"""Span of a logarithmic axis below which it is marked as a linear one is."""
# Lines that are told apart by colour, dash and mark; beyond eight they repeat.
LINES: list[dict[str, Any]] = [
    {"color": BLUE, "linestyle": "-", "marker": "o"},
    {"color": VERMILION, "linestyle": "--", "marker": "s"},
    {"color": GREEN, "linestyle": "-.", "marker": "^"},
    {"color": INK, "linestyle": ":", "marker": "D"},
    {"color": ORANGE, "linestyle": "-", "marker": "v"},
    {"color": SKY, "linestyle": "--", "marker": "P"},
    {"color": "#CC79A7", "linestyle": "-.", "marker": "X"},
    {"color": GREY, "linestyle": ":", "marker": "*"},
]

_STYLE: Any = {
    "font.size": FONT_SIZE,
    "axes.labelsize": FONT_SIZE,
    "axes.titlesize": FONT_SIZE,
    "xtick.labelsize": FONT_SIZE - 1,
    "ytick.labelsize": FONT_SIZE - 1,
    "legend.fontsize": FONT_SIZE - 1,
    "legend.frameon": False,
    "axes.linewidth": 0.7,
    "axes.edgecolor": INK,
    "axes.labelcolor": INK,
    "text.color": INK,
    "xtick.color": INK,
    "ytick.color": INK,
    "xtick.direction": "out",
    "ytick.direction": "out",
    "xtick.major.width": 0.7,
    "ytick.major.width": 0.7,
    "xtick.major.size": 3.0,
    "ytick.major.size": 3.0,
    "lines.linewidth": 1.2,
    "figure.facecolor": "white",
}


@contextmanager
def journal_style() -> Iterator[None]:
    """Draw in the house style whatever a user's matplotlibrc says, and put the settings back afterwards."""
    with matplotlib.rc_context():
        matplotlib.rcdefaults()
        matplotlib.rcParams.update(_STYLE)
        yield


def new_figure(heading: str, width: float, body: float, note: str) -> Figure:
    """Figure with `width` x `body` inches for axes and, above them, `heading` (the case's title) and `note`.

    It stands on an Agg canvas of its own, with no global state behind it.
    """
    return _write_heading(heading, width, body, note)[0]


def lay_out(heading: str, width: float, body: float, note: str) -> Figure:
    """As `new_figure`, for axes that find their own places below heading and note (`Figure.subplots`), so that no
    label is cut, however long."""
    figure, below = _write_heading(heading, width, body, note)
    figure.set_layout_engine(ConstrainedLayoutEngine(rect=(0.0, 0.0, 1.0, below), w_pad=0.06, h_pad=0.05))
    return figure


def _write_heading(heading: str, width: float, body: float, note: str) -> tuple[Figure, float]:
    """The figure, and the share of its height that is left below its words."""
    left, line = 0.08, FONT_SIZE * 1.2 / 72
    title = textwrap.wrap(heading, int((width - 2 * left) / (FONT_SIZE * 0.53 / 72)))
    words = _wrap_note(note, int((width - 2 * left) / ((FONT_SIZE - 1) * 0.53 / 72)))
    height = body + 0.12 + (len(title) + max(len(words), 1)) * line
    figure = Figure(figsize=(width, height), dpi=DPI)
    FigureCanvasAgg(figure)
    figure.text(left / width, 1 - 0.07 / height, "\n".join(title), va="top", parse_math=False)
    below = 1 - (0.10 + len(title) * line) / height
    figure.text(left / width, below, "\n".join(words), va="top", color=GREY, size=FONT_SIZE - 1)
    return figure, (body + 0.02) / height


def _wrap_note(note: str, letters: int) -> list[str]:
    """The lines of a note, in which mathematics counts as the few letters that are seen of it, and is never broken."""
    formulas = re.findall(r"\$[^$]*\$", note)
    lines = textwrap.wrap(re.sub(r"\$[^$]*\$", _FORMULA * 3, note), letters, break_long_words=False)
    whole = iter(formulas)
    return [re.sub(_FORMULA * 3, lambda _: next(whole), line) for line in lines]


def inset_axes(figure: Figure, left: float, bottom: float, width: float, height: float) -> Axes:
    """Axes at a place given in inches from the lower left corner of the figure."""
    full_width, full_height = figure.get_size_inches()
    return figure.add_axes((left / full_width, bottom / full_height, width / full_width, height / full_height))


def colours(name: str, over: str) -> Colormap:
    """Colour map `name` with a colour of its own, `over`, for values over the limit."""
    return matplotlib.colormaps[name].with_extremes(over=over)


def extend(values: np.ndarray, low: float, high: float) -> str:
    """Which ends of a colour bar need an arrow because values lie beyond its limits by more than rounding."""
    rounding = ROUNDING * (high - low)
    below, above = bool(values.min() < low - rounding), bool(values.max() > high + rounding)
    return {(False, False): "neither", (True, False): "min", (False, True): "max", (True, True): "both"}[below, above]


def shorten_numbers(axis: Axis) -> None:
    """Numbers along a colour bar that its room holds: of four decimals at most, else times a power of ten."""
    formatter = ScalarFormatter(useMathText=True)
    formatter.set_powerlimits((-4, 5))
    axis.set_major_formatter(formatter)


def mark_logarithm(axis: Axis) -> None:
    """Marks of a logarithmic axis, three at least, whose numbers keep clear of each other; called when it is drawn."""
    low, high = axis.get_view_interval()
    subs = next((marks for span, marks in _MARKS if high < span * low), (1.0,))
    axis.set_major_locator(MaxNLocator(4) if high < _LINEAR * low else LogLocator(subs=subs))
    axis.set_major_formatter("{x:g}")
    axis.set_minor_formatter(NullFormatter())


def measure(text: str) -> float:
    """Length [inches] of a line of text, mathematics in it, in the size of labels."""
    return float(TextPath((0.0, 0.0), text, size=FONT_SIZE).get_extents().width) / 72.0


def wrap_label(text: str, letters: int = 30) -> str:
    """A label of a legend in lines of at most so many letters, a long name broken where it must be."""
    return textwrap.fill(text, letters)


def save(figure: Figure, path: Path, title: str) -> Path:
    """Write `figure` to `path` in the format of its ending. Raises: CaseError if it cannot be written."""
    look: dict[str, Any] = {"format": path.suffix[1:], "dpi": DPI, "metadata": {"Title": title}}
    return write_whole(path, lambda place: figure.savefig(place, **look))
