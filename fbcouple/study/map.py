"""The map of a stability study: scenes down, exchange forms across, a colour a verdict."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, Rectangle

from fbcouple.postproc.style import DPI, GREEN, GREY, ORANGE, PAGE, VERMILION, journal_style, save

MARKS = {"unfit": "U", "warn": "W"}
"""What the pre-flight check said -> the letter in the map."""
COLOURS = {"stable": GREEN, "inaccurate": ORANGE, "unstable": VERMILION, "unfinished": GREY}
_ROW = 0.155
"""Height of a scene [in]."""


def draw_map(rows: list[dict[str, Any]], title: str, path: Path) -> Path:
    """Draw the rows of `run_scenes`; what the pre-flight check called unfit has a U in it, what it warned of a W."""
    forms = list(dict.fromkeys(row["form"] for row in rows))
    scenes = list(dict.fromkeys((row["scene"], row["varied"]) for row in rows))
    with journal_style():
        picture = Figure(figsize=(PAGE, _ROW * len(scenes) + 0.9), dpi=DPI, layout="constrained")
        FigureCanvasAgg(picture)
        axes = picture.subplots()
        picture.suptitle(title, parse_math=False, fontsize=9)
        for row in rows:
            corner = forms.index(row["form"]), scenes.index((row["scene"], row["varied"]))
            axes.add_patch(Rectangle(corner, 0.96, 0.9, color=COLOURS[row["verdict"]]))
            mark = MARKS.get(row["predicted"], "")
            axes.text(corner[0] + 0.48, corner[1] + 0.45, mark, ha="center", va="center", size=5)
        axes.set(xlim=(0, len(forms)), ylim=(len(scenes), 0))
        axes.set_xticks([n + 0.48 for n in range(len(forms))], [form or "no exchange" for form in forms])
        axes.set_yticks([n + 0.45 for n in range(len(scenes))], [f"{a}: {b}".rstrip(": ") for a, b in scenes], size=5)
        axes.spines[:].set_visible(False)
        axes.tick_params(length=0, top=True, labeltop=True, bottom=False, labelbottom=False)
        handles: list[Any] = [Patch(color=colour, label=verdict) for verdict, colour in COLOURS.items()]
        handles += [
            Line2D(
                [],
                [],
                linestyle="none",
                marker=rf"$\mathrm{{{mark}}}$",
                color="black",
                markersize=5,
                label=f"`check`: {word}",
            )
            for word, mark in MARKS.items()
        ]
        axes.legend(handles=handles, loc="upper left", bbox_to_anchor=(1.0, 1.0))
        return save(picture, path, title)
