"""The bed in three dimensions: particles coloured by speed, and by temperature where there is heat, and the gas in the
middle of the depth, still and moving."""

from __future__ import annotations

import json
import re
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, cast

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Colormap, Normalize
from matplotlib.figure import Figure
from matplotlib.image import AxesImage, imread
from PIL import Image

from fbcouple.machine.environment import child_environment
from fbcouple.paths import find_home
from fbcouple.postproc.figures.registry import figure
from fbcouple.postproc.figures.snapshots import LOWEST
from fbcouple.postproc.files import write_whole
from fbcouple.postproc.scales import format_scale, velocity_scale
from fbcouple.postproc.style import DPI, inset_axes, journal_style, new_figure, shorten_numbers
from fbcouple.postproc.symbols import explain
from fbcouple.postproc.views.colours import SPEED, TEMPERATURE, list_colours, voidage_map
from fbcouple.postproc.views.frames import choose_frames, list_frames, read_frame
from fbcouple.postproc.views.library import require_pyvista
from fbcouple.results.reader import NotDrawableError, Results, open_results

STILLS = 3
MOST_MOVING = 80
"""Frames in an animation; of more, as many are taken evenly."""
SECONDS = 8.0
"""Length of an animation."""
SLOWEST = 0.04  # s, shortest time that a picture of an animation stands
HEIGHT, HEIGHT_MOVING = 3.6, 2.9  # inches of a picture of the bed
DPI_MOVING = 150
SAMPLE = 12
"""Frames that the scales are taken from, evenly."""
LEAST_SPAN = 0.1  # K from end to end of the colour scale of temperatures
BUSY = 99.0  # per cent of the particles that are slower than the end of the colour scale


@dataclass(frozen=True)
class Scales:
    """Ends of the colour scale of the particles' speed and of the length of the gas's arrows [m/s], and both ends of
    that of their temperature [K], None in a case without heat."""

    speed: float
    gas: float
    temperature: tuple[float, float] | None = None

    @property
    def last_views(self) -> list[str]:
        """What is drawn beside the particles' speeds."""
        return ["gas"] * (self.gas > 0.0) + ["temperature"] * (self.temperature is not None)


@figure
def bed_views(results: Results) -> Figure:
    """Particles coloured by speed at moments of the second half of the run; at the last of them voidage and gas, and
    the temperature of the particles where there is heat."""
    paths = list_frames(results)
    chosen = choose_frames(paths, STILLS, 0.5)
    scales = replace(find_scales(paths), temperature=find_warmth(chosen[-1:]))
    with tempfile.TemporaryDirectory() as folder:
        wanted = [(path, "particles") for path in chosen]
        wanted += [(chosen[-1], name) for name in scales.last_views]
        pictures = [imread(file) for file in render(results, wanted, scales, round(HEIGHT * DPI), Path(folder))]
    names = [f"{name.capitalize()}, t = {read_frame(path).time:.3f} s" for path, name in wanted]
    box = " x ".join(f"{1e3 * length:.4g}" for length in results.size)
    fastest = max(float(read_frame(path).speeds.max(initial=0.0)) for path in chosen)
    beyond = f"; scale up to the speed of {BUSY:g} of 100 particles" if fastest > scales.speed else ""
    note = f"box {box} mm{beyond}"
    return compose(results, pictures, names, scales, HEIGHT, note)[0]


def find_scales(paths: Sequence[Path]) -> Scales:
    """Common scales of all frames: the speed that 99 of 100 particles stay below, the fastest gas of a cell, and the
    temperatures of the particles."""
    chosen, speeds, fastest = choose_frames(list(paths), SAMPLE), [], 0.0
    for path in chosen:
        frame = read_frame(path)
        speeds.append(frame.speeds)
        if frame.gas_velocity is not None:
            fastest = max(fastest, float(np.nanmax(np.linalg.norm(frame.gas_velocity, axis=0))))
    known = np.concatenate(speeds)
    busy = float(np.percentile(known, BUSY)) if known.size else 0.0
    return Scales(busy or 1.0, fastest, find_warmth(chosen))


def find_warmth(paths: Sequence[Path]) -> tuple[float, float] | None:
    """Temperatures [K] that 98 of 100 particles of the frames lie between; None in a case without heat."""
    columns = [read_frame(path).temperatures for path in paths]
    warm = [column for column in columns if column is not None and column.size]
    if not warm:
        return None
    low, high = np.percentile(np.concatenate(warm), [100.0 - BUSY, BUSY]).tolist()
    return (low, high) if high - low > LEAST_SPAN else (low - 0.5 * LEAST_SPAN, low + 0.5 * LEAST_SPAN)


def render(
    results: Results, wanted: Sequence[tuple[Path, str]], scales: Scales, height: int, folder: Path
) -> list[Path]:
    """Draw pairs of frame and view, `height` pixels each, into `folder`; returns their PNG files.

    A process of its own draws them: where this machine has nothing to draw with, the 3-D library ends its process.

    Raises: NotDrawableError if it did.
    """
    require_pyvista()
    files = [folder / f"{number}.png" for number in range(len(wanted))]
    request = {
        "corner": results.corner,
        "size": results.size,
        "height": height,
        "speed": scales.speed,
        "gas_speed": scales.gas,
        "voidage": (LOWEST, 1.0),
        "temperature": scales.temperature,
        "pictures": [(str(path), name, str(file)) for (path, name), file in zip(wanted, files, strict=True)],
    }
    (folder / "request.json").write_text(json.dumps(request), encoding="utf-8")
    command = [sys.executable, "-m", "fbcouple.postproc.views.render", str(folder / "request.json")]
    done = subprocess.run(
        command,
        env=child_environment(),
        capture_output=True,
        text=True,
        encoding="utf-8",
        errors="replace",
        check=False,
    )
    if done.returncode:
        words = re.sub(r"\x1b\[[0-9;]*m", "", done.stderr).splitlines()
        last = next((line.strip() for line in reversed(words) if line.strip()), "no words")
        text = f"the 3-D pictures cannot be drawn (exit code {done.returncode}: {last})"
        raise NotDrawableError([f"{text}; `fbcouple doctor` says what is missing."])
    return files


def compose(
    results: Results, pictures: Sequence[np.ndarray], names: Sequence[str], scales: Scales, tall: float, note: str
) -> tuple[Figure, list[AxesImage]]:
    """Put pictures of the bed side by side, `tall` inches each, with their names and the colour bars of what they show.

    Returns: the figure and its pictures.
    """
    bottom, left, top, bar, room = 0.1, 0.1, 0.16, 0.12, 0.58
    widths = [tall * picture.shape[1] / picture.shape[0] for picture in pictures]
    scale, divisor, unit = velocity_scale(results)
    bars: list[tuple[str, float, float, str | Colormap, str]]
    bars = [(f"Particle speed $|\\mathbf{{u}}_p|{divisor}$ [{unit}]", 0.0, scales.speed / scale, SPEED, "max")]
    if scales.gas:
        bars.append((r"Voidage $\varepsilon$ at $y/D$ = 0.5 [–]", LOWEST, 1.0, voidage_map(), "neither"))
        note = f"{note}; longest arrow: gas at {scales.gas / scale:.3g}{' $U_f$' if divisor else ' m/s'}"
    if scales.temperature:
        bars.append(("Particle temperature [K]", *scales.temperature, TEMPERATURE, "both"))
    note += format_scale([results])
    note = f"{note}; {explain(*(words for words, *_ in bars), known=note)}"
    full = left + sum(widths) + 0.12 * len(widths) + len(bars) * (bar + room)
    picture = new_figure(results.title, max(full, 3.4), bottom + tall + top, note)
    images = []
    for width, pixels, name in zip(widths, pictures, names, strict=True):
        axes = inset_axes(picture, left, bottom, width, tall)
        images.append(axes.imshow(pixels, interpolation="none", aspect="auto"))
        axes.set_axis_off()
        axes.set_title(name, size="small", pad=2.0)
        left += width + 0.12
    for words, low, high, colours, arrow in bars:
        scalars = ScalarMappable(Normalize(low, high), colours)
        axes = inset_axes(picture, left, bottom + 0.1 * tall, bar, 0.8 * tall)
        picture.colorbar(scalars, cax=axes, extend=arrow, extendfrac=0.03, label=words)
        shorten_numbers(axes.yaxis)
        left += bar + room
    return picture, images


def animate(run: Path, folder: Path | None = None) -> Path:
    """Draw bed.gif into `folder`, by default RUN/figures: particles coloured by speed beside the gas, and by
    temperature where there is heat, over all frames.

    Raises: CaseError if there are no results or no frames; NotDrawableError if this machine cannot draw them.
    """
    results = open_results(run)
    paths = choose_frames(list_frames(results), MOST_MOVING)
    scales = find_scales(paths)
    views = ["particles", *scales.last_views]
    times = [read_frame(path).time for path in paths]
    with tempfile.TemporaryDirectory() as drawn, journal_style():
        wanted = [(path, name) for path in paths for name in views]
        files = render(results, wanted, scales, round(HEIGHT_MOVING * DPI_MOVING), Path(drawn))
        moments = [files[first : first + len(views)] for first in range(0, len(files), len(views))]
        shots = list(_film(results, moments, times, views, scales))
    folder = folder or find_home(Path(run)) / "figures"
    return _save_film(shots, list_colours(scales.temperature is not None), folder / "bed.gif")


def _film(
    results: Results, moments: list[list[Path]], times: list[float], views: list[str], scales: Scales
) -> Iterator[Image.Image]:
    """A whole picture for each moment; only what changes is drawn anew."""
    names = [view.capitalize() for view in views]
    picture, images = compose(
        results, [imread(file) for file in moments[0]], names, scales, HEIGHT_MOVING, "t = 0.000 s"
    )
    picture.set_dpi(DPI_MOVING)
    canvas, note = cast(FigureCanvasAgg, picture.canvas), picture.texts[1]
    words = note.get_text()
    for files, time in zip(moments, times, strict=True):
        for image, file in zip(images, files, strict=True):
            image.set_data(imread(file))
        note.set_text(words.replace("t = 0.000 s", f"t = {time:.3f} s"))
        canvas.draw()
        yield Image.fromarray(np.asarray(canvas.buffer_rgba())[..., :3].copy())


def _save_film(shots: list[Image.Image], colours: np.ndarray, path: Path) -> Path:
    """One palette for all of them, or colours would flicker; of a picture each its time."""
    palette = Image.new("P", (1, 1))
    palette.putpalette(colours.tobytes())
    films = [shot.quantize(palette=palette, dither=Image.Dither.NONE) for shot in shots]
    each = max(SLOWEST, SECONDS / len(films))
    look: dict[str, Any] = {"format": "GIF", "save_all": True, "append_images": films[1:], "loop": 0}
    return write_whole(path, lambda place: films[0].save(place, duration=round(1e3 * each), **look))
