"""Frames of a run as 3-D views want them: those that there are, and some of them."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from fbcouple.paths import FRAMES
from fbcouple.results.frames import Frame, read_frame
from fbcouple.results.reader import NotDrawableError, Results, format_without

__all__ = ["Frame", "choose_frames", "list_frames", "number_of", "read_frame"]


def list_frames(results: Results) -> list[Path]:
    """Files of the frames of a run in the order of time. Raises: NotDrawableError if it has none."""
    found = sorted((results.path.parent / FRAMES).glob("frame-*.nc"))
    if not found:
        raise NotDrawableError([format_without(results, "frames", "output.particles_every")])
    return found


def number_of(path: Path) -> int:
    """Number of a frame, counted from 0, from its file's name."""
    return int(path.stem.rpartition("-")[2])


def choose_frames(paths: list[Path], most: int, start: float = 0.0) -> list[Path]:
    """At most `most` of the files, evenly, the last among them; `start`: part of them that is left out first."""
    first = int(start * (len(paths) - 1))
    indices = np.linspace(first, len(paths) - 1, min(most, len(paths) - first))
    return [paths[index] for index in dict.fromkeys(indices.round().astype(int).tolist())]
