"""Bubbles that pass a horizontal section through the bed: what tomography sees of a bed of three dimensions."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from fbcouple.postproc.figures.bubbles import EDGE
from fbcouple.results.probes import read_probes
from fbcouple.results.reader import NotDrawableError, Results

OPEN = 0.9
"""Share of the section that a void covers at some time from which on it is the space above the bed, or a slug."""


@dataclass(frozen=True)
class Section:
    """Voidage of a section: `times` (t,) [s], `voidage` (t, y, x), nan outside of the bed, and the area [m2] of a
    point."""

    times: np.ndarray
    voidage: np.ndarray
    area: float


@dataclass(frozen=True)
class Passing:
    """Bubbles that passed a section: equivalent `diameters` [m] of each at its widest, and how many voids covered the
    whole section."""

    diameters: np.ndarray
    open: int


def read_section(results: Results, name: str) -> Section:
    """The section that the set of probes `name` took. Raises: NotDrawableError if there is no such set with voidage at
    a height."""
    lack = NotDrawableError([f"{results.path} has no set of probes `{name}` with the voidage at one height."])
    probed = {one.name: one for one in read_probes(results.data, results.case)}.get(name)
    if probed is None or "voidage" not in probed.values or np.ptp(probed.points[:, 2]) > 0.0:
        raise lack
    (x, column), (y, row) = (np.unique(np.round(probed.points[:, axis], 12), return_inverse=True) for axis in (0, 1))
    if min(len(x), len(y)) < 2:
        raise lack
    voidage = np.full((len(probed.times), len(y), len(x)), np.nan)
    voidage[:, row, column] = probed.values["voidage"]
    return Section(probed.times, voidage, float(np.diff(x).min() * np.diff(y).min()))


def find_passing(section: Section, smallest: float) -> Passing:
    """Bubbles of a section through time.

    A bubble is a set of points, joined to neighbours in the section and from sample to sample, with a voidage over
    `EDGE`; its equivalent diameter is that of the circle of its largest area in one sample, at least `smallest` [m].
    What covers `OPEN` of the section is none, nor what is there in the first sample or the last: it is not whole.
    """
    labels, count = ndimage.label(section.voidage > EDGE)
    samples = len(section.times)
    covered = np.zeros((samples, count + 1))
    for sample in range(samples):
        covered[sample] = np.bincount(labels[sample].ravel(), minlength=count + 1)
    widest = covered[:, 1:].max(axis=0)
    whole = (covered[0, 1:] == 0.0) & (covered[-1, 1:] == 0.0)
    is_open = widest >= OPEN * np.isfinite(section.voidage[0]).sum()
    diameters = np.sqrt(4.0 * widest * section.area / np.pi)
    return Passing(diameters[whole & ~is_open & (diameters >= smallest)], int(is_open.sum()))
