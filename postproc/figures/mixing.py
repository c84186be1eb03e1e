"""How particles mix, frame by frame: species, those that feeds brought, and parts of the bed as it began."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from fbcouple.physics.mixing import find_lacey_index, number_samples
from fbcouple.postproc.figures.registry import figure
from fbcouple.postproc.style import COLUMN, GREY, LINES, inset_axes, new_figure
from fbcouple.postproc.views.frames import Frame, choose_frames, list_frames, read_frame
from fbcouple.results.reader import NotDrawableError, NotMeantError, Results

EDGE = 3.0
"""Edge of a sample over the largest diameter: about 30 particles where they are packed."""
LEAST = 4.0
"""Length of a bed along an axis, in samples, from which its halves across that axis are followed."""
MIXED = 0.9
"""Index from which a bed is called mixed."""
_MOST = 200
HALVES = {axis: f"{axis} half at the start" for axis in ("right", "back", "upper")}
"""Halves of the bed that are followed, across x, y and z."""


@dataclass(frozen=True)
class Mixing:
    """Lacey's index of the particles of a `name` among the others at each of the times [s] (n,); nan where there are
    none of them, or no others."""

    name: str
    time: np.ndarray
    index: np.ndarray

    @property
    def reached(self) -> float:
        """First time [s] at which it is `MIXED`; nan if it is not."""
        mixed = np.flatnonzero(self.index >= MIXED)
        return float(self.time[mixed[0]]) if len(mixed) else float("nan")


def follow_mixing(results: Results, edge: float | None = None) -> list[Mixing]:
    """The mixing of a run with frames: of each species but the first, of each feed, of halves of the bed as it began.

    edge: that of a sample [m]; by default `EDGE` largest diameters.

    Raises: NotDrawableError if nothing is mixed with anything; NotMeantError if there are no frames, and one kind of
    particles that does not come and go.
    """
    try:
        paths = choose_frames(list_frames(results), _MOST)
    except NotDrawableError as lack:
        asked = "mass_fed" in results.data or "species_centre_z" in results.data
        raise lack if asked else NotMeantError(list(lack.problems)) from lack
    found = _follow(tuple(paths), paths[-1].stat().st_mtime_ns, edge)
    if not found:
        raise NotDrawableError([f"{results.path}: no frame has two kinds of particles, or parts of the first bed."])
    return list(found)


def find_largest_diameter(results: Results) -> float:
    """The largest diameter [m] in the first and the last frame; of parcels, theirs. Raises: NotDrawableError if there
    are no frames."""
    return _find_largest(list_frames(results))


def _find_largest(paths: Sequence[Path]) -> float:
    return max(float(read_frame(path).diameters.max(initial=0.0)) for path in (paths[0], paths[-1]))


@lru_cache(maxsize=2)
def _follow(paths: tuple[Path, ...], newest: int, edge: float | None) -> tuple[Mixing, ...]:
    first, largest, times = read_frame(paths[0]), _find_largest(paths), np.empty(len(paths))
    if not largest:
        return ()
    edge = edge or EDGE * largest
    halves = _find_halves(first, edge)
    rows: dict[str, np.ndarray] = {}
    for row, path in enumerate(paths):
        frame = read_frame(path)
        times[row] = frame.time
        for name, those, marked in _mark(frame, first.numbers, halves):
            positions = frame.positions[those].astype(float)
            samples = number_samples(positions, np.zeros(3), edge)
            rows.setdefault(name, np.full(len(paths), np.nan))[row] = find_lacey_index(marked, samples)
    return tuple(Mixing(name, times, index) for name, index in rows.items() if np.isfinite(index).any())


def _find_halves(first: Frame, edge: float) -> dict[str, np.ndarray]:
    """Numbers of the particles in halves of the bed `first`, across each axis along which it is long enough."""
    halves = {}
    for axis, name in enumerate(HALVES.values()):
        places = first.positions[:, axis]
        if len(places) and np.ptp(places) >= LEAST * edge:
            halves[name] = first.numbers[places > np.median(places)]
    return halves


def _mark(
    frame: Frame, known: np.ndarray, halves: dict[str, np.ndarray]
) -> Iterator[tuple[str, np.ndarray | slice, np.ndarray]]:
    """What is followed in a frame: its name, the rows of the particles that count, and which of them are marked."""
    if frame.species is not None:
        for species in range(2, int(frame.species.max(initial=0.0)) + 1):
            yield f"species {species}", slice(None), frame.species == species
    if frame.feeds is not None:
        for feed in range(1, int(frame.feeds.max(initial=0.0)) + 1):
            yield f"feed {feed}", slice(None), frame.feeds == feed
    there = np.flatnonzero(np.isin(frame.numbers, known))
    for name, half in halves.items():
        yield name, there, np.isin(frame.numbers[there], half)


@figure
def mixing(results: Results) -> Figure:
    """Lacey's mixing index against time, of species, of what feeds brought, and of halves of the bed as it began."""
    found = follow_mixing(results)
    note = f"1 mixed by chance, 0 apart; samples are cubes of {EDGE:g} largest diameters, counted by their particles"
    picture = new_figure(results.title, COLUMN, 2.6, note)
    axes = inset_axes(picture, 0.7, 0.45, COLUMN - 0.9, 2.0)
    for n, each in enumerate(found):
        style = LINES[n % len(LINES)] | {"marker": "" if len(each.time) > 30 else LINES[n % len(LINES)]["marker"]}
        axes.plot(each.time, each.index, label=each.name, markersize=3, **style)
    axes.axhline(1.0, color=GREY, linewidth=0.6)
    axes.set(
        xlabel="Time [s]", ylabel="Lacey's index", xlim=(0.0, float(found[0].time[-1]) or None), ylim=(-0.05, None)
    )
    axes.legend(loc="best")
    return picture
