"""Bubbles in the snapshots of the depth-mean voidage: how many, how large, how fast they rise."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from scipy import ndimage
from scipy.optimize import linear_sum_assignment

from fbcouple.postproc.figures.registry import figure
from fbcouple.postproc.statistics import find_steady_time
from fbcouple.postproc.style import BLUE, COLUMN, GREY, VERMILION, inset_axes, new_figure
from fbcouple.postproc.symbols import explain
from fbcouple.results.reader import NotDrawableError, Results, format_without

EDGE = 0.7
"""Depth-mean voidage that bounds a bubble."""
SMALLEST = 5.0
"""Equivalent diameter, in particle diameters, below which a void is no bubble."""
SHORTEST_TRACK = 3
"""Snapshots that a bubble must be followed over for its rise to count."""
STANDING = 0.1
"""Share of the rise velocity of a lone bubble, 0.711 sqrt(g d) (Davidson and Harrison 1963), below which a void that is
followed stands still: a corner without particles, no bubble that rises."""
_LONE = 0.711
_AREA_CHANGE = 2.0


@dataclass(frozen=True)
class Bubble:
    """A region of high voidage in one snapshot: its centre (x, z) [m] and equivalent diameter [m]."""

    x: float
    z: float
    diameter: float


@dataclass(frozen=True)
class Track:
    """One bubble followed over snapshots: `times` [s] and what it was at each."""

    times: list[float]
    bubbles: list[Bubble]

    @property
    def rise(self) -> float:
        """Rise velocity [m/s]: slope of the straight line through height against time."""
        return float(np.polyfit(self.times, [bubble.z for bubble in self.bubbles], 1)[0])

    @property
    def diameter(self) -> float:
        """Mean equivalent diameter [m]."""
        return float(np.mean([bubble.diameter for bubble in self.bubbles]))

    @property
    def height(self) -> float:
        """Mean height [m]."""
        return float(np.mean([bubble.z for bubble in self.bubbles]))


@dataclass(frozen=True)
class Bubbling:
    """All bubbles of a run after its start-up: `found` at each of `times` [s], the long enough `tracks` of those that
    rise and of those that stand still, and how many voids at the floor were no bubbles yet."""

    times: np.ndarray
    found: list[list[Bubble]]
    tracks: list[Track]
    standing: list[Track]
    at_floor: int


def find_bubbles(voidage: np.ndarray, spacing: tuple[float, float], smallest: float) -> tuple[list[Bubble], int]:
    """Bubbles of one snapshot, their places counted from the lower left corner; and how many voids touch the floor.

    A bubble is a set of cells, joined by their edges, with a voidage over `EDGE` and no way to the top of the box:
    what is open to the top is freeboard. What reaches into the layer of cells at the floor has not left it: the gas
    comes in there, and no bubble has formed yet. The equivalent diameter is that of the circle of its area, at least
    `smallest` [m]. The centre is weighted with the voidage above the edge, so that it moves less in jumps of a cell.

    voidage: depth mean (z, x), nan outside of a mesh; spacing: dz, dx [m].
    """
    labels, count = ndimage.label(voidage > EDGE)
    freeboard, floor = (set(np.unique(row)) - {0} for row in (labels[-1], labels[0]))
    names = [name for name in range(1, count + 1) if name not in freeboard]
    if not names:
        return [], 0
    dz, dx = spacing
    areas = ndimage.sum_labels(np.ones_like(voidage), labels, names) * dz * dx
    centres = ndimage.center_of_mass(np.fmax(voidage - EDGE, 0.0), labels, names)
    diameters = dict(zip(names, np.sqrt(4.0 * areas / np.pi).tolist(), strict=True))
    large = {name for name, diameter in diameters.items() if diameter >= smallest}
    free = [
        Bubble((column + 0.5) * dx, (row + 0.5) * dz, diameters[name])
        for name, (row, column) in zip(names, centres, strict=True)
        if name in large - floor
    ]
    return free, len(large & floor)


def follow(times: np.ndarray, found: list[list[Bubble]]) -> list[Track]:
    """Join the bubbles of snapshots that follow each other to tracks.

    Pairs are chosen so that the sum of their distances is least (Hungarian method). A bubble that moved by more than
    its diameter, or whose area changed by more than a factor of 2 (it split, merged or burst), starts a new track.
    """
    open_tracks: list[Track] = []
    tracks: list[Track] = []
    for time, bubbles in zip(times, found, strict=True):
        pairs = _match([track.bubbles[-1] for track in open_tracks], bubbles)
        going_on = []
        for index, bubble in enumerate(bubbles):
            track = open_tracks[pairs[index]] if index in pairs else Track([], [])
            track.times.append(float(time))
            track.bubbles.append(bubble)
            if index not in pairs:
                tracks.append(track)
            going_on.append(track)
        open_tracks = going_on
    return [track for track in tracks if len(track.times) >= SHORTEST_TRACK]


def _match(before: list[Bubble], now: list[Bubble]) -> dict[int, int]:
    """Place in `now` -> place in `before` of the bubbles that are the same."""
    if not before or not now:
        return {}
    distance = np.array([[np.hypot(new.x - old.x, new.z - old.z) for new in now] for old in before])
    reach = np.array([[old.diameter for _ in now] for old in before])
    growth = np.array([[(new.diameter / old.diameter) ** 2 for new in now] for old in before])
    possible = (distance <= reach) & (growth <= _AREA_CHANGE) & (growth >= 1.0 / _AREA_CHANGE)
    cost = np.where(possible, distance, 1e3 + distance)
    rows, columns = linear_sum_assignment(cost)
    return {int(new): int(old) for old, new in zip(rows, columns, strict=True) if possible[old, new]}


def find_bubbling(results: Results) -> Bubbling:
    """Find and follow the bubbles of a run in its `voidage_snapshots`, from the end of the start-up on.

    Raises: NotDrawableError without snapshots after the start-up.
    """
    if "voidage_snapshots" not in results.data:
        raise NotDrawableError([format_without(results, "voidage_snapshots", "output.snapshots_every")])
    snapshots = results.data["voidage_snapshots"].transpose("snapshot_time", "z", "x")
    times = snapshots["snapshot_time"].values.astype(float)
    steady = times >= find_steady_time(results)
    if int(steady.sum()) < SHORTEST_TRACK:
        raise NotDrawableError([f"{results.path} has {int(steady.sum())} snapshots after the start-up; too few."])
    width, _, height = results.size
    spacing = height / snapshots.sizes["z"], width / snapshots.sizes["x"]
    smallest = SMALLEST * float(results.case["particles"]["diameter"])
    shots = [find_bubbles(field, spacing, smallest) for field in snapshots.values[steady].astype(float)]
    found = [bubbles for bubbles, _ in shots]
    tracks = follow(times[steady], found)
    rising, standing = part_tracks(tracks, float(results.case["gravity"]))
    return Bubbling(times[steady], found, rising, standing, sum(count for _, count in shots))


def part_tracks(tracks: list[Track], gravity: float) -> tuple[list[Track], list[Track]]:
    """Those that rise, and those slower than `STANDING` of a lone bubble of their size, with `gravity` [m s-2]."""
    rising: list[Track] = []
    standing: list[Track] = []
    for track in tracks:
        lone = _LONE * float(np.sqrt(gravity * track.diameter))
        (rising if track.rise > STANDING * lone else standing).append(track)
    return rising, standing


def summarise_bubbles(bubbling: Bubbling) -> dict[str, float]:
    """Numbers of a run's bubbles: snapshots, mean number at a time, mean diameter [m], tracks, rise velocity [m/s].

    Diameters are of all bubbles seen, rise velocities of the tracks that rise, each with the standard deviation over
    them; nan where there is none.
    """
    diameters = np.array([bubble.diameter for bubbles in bubbling.found for bubble in bubbles])
    rises = np.array([track.rise for track in bubbling.tracks])
    seen, followed = len(diameters) > 0, len(rises) > 0
    return {
        "snapshots": len(bubbling.times),
        "bubbles at a time": len(diameters) / len(bubbling.times),
        "voids at the floor at a time, left out": bubbling.at_floor / len(bubbling.times),
        "diameter": float(diameters.mean()) if seen else np.nan,
        "diameter, deviation": float(diameters.std()) if seen else np.nan,
        "tracks that rise": len(rises),
        "tracks that stand still, left out": len(bubbling.standing),
        "rise velocity": float(rises.mean()) if followed else np.nan,
        "rise velocity, deviation": float(rises.std()) if followed else np.nan,
    }


@figure
def bubbles(results: Results) -> Figure:
    """Equivalent diameter of every bubble seen against height, and rise velocity of each that was followed."""
    bubbling = find_bubbling(results)
    seen = [bubble for found in bubbling.found for bubble in found]
    if not seen:
        raise NotDrawableError([f"no bubble in the {len(bubbling.times)} snapshots after the start-up."])
    times = bubbling.times
    note = (
        f"{len(times)} snapshots, t = {times[0]:.3g}–{times[-1]:.3g} s; edge: voidage {EDGE:g}; no voids at the floor; "
        + explain("z/H")
    )
    picture = new_figure(results.title, COLUMN, 4.05, note)
    height = results.size[2]
    upper = inset_axes(picture, 0.56, 2.42, COLUMN - 0.7, 1.5)
    lower = inset_axes(picture, 0.56, 0.42, COLUMN - 0.7, 1.5)
    upper.plot([b.z / height for b in seen], [1e3 * b.diameter for b in seen], ".", color=BLUE, markersize=3, alpha=0.5)
    largest = 1.1e3 * max(bubble.diameter for bubble in seen)
    upper.set(ylabel="Equivalent diameter [mm]", ylim=(0.0, largest), xlabel="$z/H$ [–]")
    upper.xaxis.set_major_locator(MaxNLocator(5))
    sizes, rises = [1e3 * t.diameter for t in bubbling.tracks], [t.rise for t in bubbling.tracks]
    lower.plot(sizes, rises, "o", color=VERMILION, markersize=3, alpha=0.7, label="rises")
    if bubbling.standing:
        still = [(1e3 * track.diameter, track.rise) for track in bubbling.standing]
        lower.plot(*zip(*still, strict=True), "o", color=GREY, fillstyle="none", markersize=3, label="stands still")
        lower.legend(loc="best", handlelength=1.0)
    lower.set(xlabel="Equivalent diameter [mm]", ylabel="Rise velocity [m s$^{-1}$]", xlim=(0.0, largest))
    fastest = max([track.rise for track in bubbling.tracks + bubbling.standing], default=1.0)
    lower.set_ylim(min(lower.get_ylim()[0], 0.0), 1.15 * max(fastest, 0.0) or None)
    return picture
