"""Measures of how a bed moves, against the finest member: fluctuation, frequency, agitation, bubbles and mixing."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from fbcouple.errors import CaseError
from fbcouple.postproc.figures.bubbles import Bubble, find_bubbling
from fbcouple.postproc.figures.mixing import EDGE, HALVES, MIXED, find_largest_diameter, follow_mixing
from fbcouple.postproc.figures.spectrum import SIGNALS, find_spectrum
from fbcouple.postproc.joined_rows import require_every_row, require_own_rows
from fbcouple.postproc.measures import BLOCKS, Measured, bed_agitation, cut_to_window, in_window
from fbcouple.results.reader import NotDrawableError, Results
from fbcouple.results.variables import HISTORIES
from fbcouple.study.measures.registry import Error, Finished, measure


def _compare(
    name: str, unit: str, find: Callable[[Results], Measured], run: Finished, reference: Finished | None
) -> Error:
    """Distance of what `find` makes of a run from what it makes of the finest member, over that; `stderr` is that of
    both, nan where that of either is not known."""
    assert reference is not None
    here, there = find(run.results), find(reference.results)
    if not there.value:
        raise CaseError([f"{name}: the finest member's is 0, and nothing is a part of it."])
    error, chance = abs(here.value / there.value - 1.0), math.hypot(here.error, there.error) / abs(there.value)
    return Error(here.value, there.value, unit, error, chance)


@measure("fluctuation", arguments=tuple(HISTORIES), needs_reference=True)
def compare_fluctuation(run: Finished, argument: str, reference: Finished | None) -> Error:
    """Standard deviation of a history over the averaging window; its standard error from the variances of blocks."""

    def deviate(results: Results) -> Measured:
        require_own_rows(results, argument, is_of_spread=True)
        values = in_window(results, argument)
        if len(values) < 2 * BLOCKS:
            raise NotDrawableError([f"`{argument}` in {results.path} has {len(values)} rows in the window; too few."])
        deviation = float(values.std())
        parts = [((block - values.mean()) ** 2).mean() for block in np.array_split(values, BLOCKS)]
        error = float(np.std(parts, ddof=1)) / math.sqrt(BLOCKS)
        return Measured(deviation, error / (2.0 * deviation) if deviation else 0.0)

    return _compare(f"fluctuation:{argument}", HISTORIES[argument][0], deviate, run, reference)


@measure("frequency", arguments=tuple(SIGNALS), needs_reference=True)
def compare_frequency(run: Finished, argument: str, reference: Finished | None) -> Error:
    """Frequency of the highest peak in the spectrum of a history over the averaging window; `stderr` is half the
    distance at which two peaks are told apart, of both."""

    def find_peak(results: Results) -> Measured:
        require_every_row(results, "a spectrum")
        found = find_spectrum(argument, *cut_to_window(results, argument))
        return Measured(found.peak, 0.5 * found.resolution)

    return _compare(f"frequency:{argument}", "Hz", find_peak, run, reference)


@measure("agitation", needs_reference=True, needs=("[averages]",))
def compare_agitation(run: Finished, argument: str, reference: Finished | None) -> Error:
    """Mean agitation per mass of the dense bed; its standard error by blocks left out."""
    return _compare("agitation", "m2 s-2", bed_agitation, run, reference)


@measure("bubbles", arguments=("number", "diameter"), needs_reference=True, needs=("output.snapshots_every",))
def compare_bubbles(run: Finished, argument: str, reference: Finished | None) -> Error:
    """Mean number at a time, or mean equivalent diameter [m], of the bubbles in the snapshots of the depth mean."""
    number = argument == "number"

    def look(results: Results) -> Measured:
        bubbling = find_bubbling(results)
        if len(bubbling.found) < BLOCKS:
            text = f"{results.path} has {len(bubbling.found)} snapshots after the start-up, {BLOCKS} are needed."
            raise NotDrawableError([text])
        count, total = _sum_blocks(bubbling.found)
        if not count.sum():
            raise NotDrawableError([f"no bubble in the {len(bubbling.found)} snapshots of {results.path}."])
        above, below = (count, _count_blocks(bubbling.found)) if number else (total, count)
        return _find_ratio(above, below)

    return _compare(f"bubbles:{argument}", "1" if number else "m", look, run, reference)


def _sum_blocks(found: list[list[Bubble]]) -> tuple[np.ndarray, np.ndarray]:
    """Bubbles, and the sum of their diameters, of each of `BLOCKS` parts of the snapshots."""
    per_shot = np.array([(len(bubbles), sum(bubble.diameter for bubble in bubbles)) for bubbles in found])
    parts = np.array([block.sum(axis=0) for block in np.array_split(per_shot, BLOCKS)])
    return parts[:, 0], parts[:, 1]


def _count_blocks(found: list[list[Bubble]]) -> np.ndarray:
    return np.array([len(block) for block in np.array_split(np.arange(len(found)), BLOCKS)], dtype=float)


def _find_ratio(above: np.ndarray, below: np.ndarray) -> Measured:
    """Ratio of the sums of `above` and `below` (blocks,), with its standard error to first order in their deviations
    (Cochran 1977, Sampling Techniques, section 6)."""
    ratio, count = float(above.sum() / below.sum()), len(above)
    apart = above - ratio * below
    return Measured(ratio, math.sqrt(float((apart**2).sum()) * count / (count - 1)) / float(below.sum()))


@measure("mixing", arguments=tuple(HALVES), needs_reference=True, needs=("output.particles_every",))
def compare_mixing(run: Finished, argument: str, reference: Finished | None) -> Error:
    """Time [s] until a half of the bed as it began is mixed with the other (Lacey's index 0.9), in samples of one size
    for both, three of the larger of both their largest diameters; its standard error is not known, as each bed mixes
    once."""
    assert reference is not None
    edge = EDGE * max(find_largest_diameter(one.results) for one in (run, reference))

    def mix(results: Results) -> Measured:
        wanted = HALVES[argument]
        found = next((each for each in follow_mixing(results, edge) if each.name == wanted), None)
        if found is None:
            raise NotDrawableError([f"{results.path}: the bed is too short for halves of samples of {edge:.3g} m."])
        if math.isnan(found.reached):
            last = f"it has come to {found.index[-1]:.2f} at {found.time[-1]:.3g} s"
            raise NotDrawableError([f"{results.path}: the {wanted} is not mixed to {MIXED:g}: {last}."])
        return Measured(found.reached, math.nan)

    return _compare(f"mixing:{argument}", "s", mix, run, reference)
