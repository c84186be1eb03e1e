"""Figures as data of a page: PNG, its size on the screen, and its words."""

from __future__ import annotations

import base64
import io
from collections.abc import Callable
from inspect import cleandoc
from typing import Any

from matplotlib.figure import Figure
from PIL import Image

from fbcouple.postproc.style import DPI, journal_style
from fbcouple.results.reader import NotDrawableError, NotMeantError

_SCREEN = 112.0
"""Dots of a screen an inch of a figure: its text is 11-12 dots high, and two columns fill a page of 1280."""
_COLOURS = 256


def make_picture(
    make: Callable[[], Figure], name: str, words: str | None, label: str, left_out: list[str]
) -> dict[str, Any]:
    """A figure as PNG data with its words; nothing, and the reason in `left_out`, if it cannot be drawn."""
    try:
        with journal_style():
            figure = make()
            data = encode(figure)
    except NotMeantError:
        return {}
    except NotDrawableError as lack:
        left_out.append(f"Figure {name} left out: {lack}")
        return {}
    width, height = figure.get_size_inches()
    sentence = " ".join(cleandoc(words or name).partition("\n\n")[0].split())
    return {
        "name": name,
        "words": f"{label}: {sentence}" if label else sentence,
        "source": "data:image/png;base64," + base64.b64encode(data).decode(),
        "width": round(width * _SCREEN),
        "height": round(height * _SCREEN),
    }


def encode(figure: Figure) -> bytes:
    """PNG data of a figure; one that shows views of the bed has 256 colours, a fourth of the data."""
    stream = io.BytesIO()
    figure.savefig(stream, format="png", dpi=DPI, pil_kwargs={"optimize": True})
    if any(axes.images for axes in figure.axes):
        drawn = Image.open(stream).convert("RGB")
        stream = io.BytesIO()
        drawn.quantize(_COLOURS, Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE).save(stream, "PNG", optimize=True)
    return stream.getvalue()
