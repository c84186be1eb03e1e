"""Bubbles that pass a horizontal section through the bed: what tomography sees of a bed of three dimensions."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy import ndimage

from fbcouple.postproc.figures.bubbles import EDGE
from fbcouple.results.probes import Probed, read_probes
from fbcouple.results.reader import NotDrawableError, Results

OPEN = 0.9
"""Share of the section that a void covers at some time from which on it is the space above the bed, or a slug."""


@dataclass(frozen=True)
class Section:
    """Voidage of a section: `times` (t,) [s], `voidage` (t, y, x), nan outside of the bed, the area [m2] of a point,
    where its points lie along x [m] and its height [m]."""

    times: np.ndarray
    voidage: np.ndarray
    area: float
    x: np.ndarray
    height: float


@dataclass(frozen=True)
class Passing:
    """Bubbles that passed a section: equivalent `diameters` [m] of each at its widest, and how many voids covered the
    whole section."""

    diameters: np.ndarray
    open: int


def list_sections(results: Results) -> list[str]:
    """Names of the sets of probes that are sections, in the order of the case."""
    return [one.name for one in read_probes(results.data, results.case) if _lay_out(one) is not None]


def read_section(results: Results, name: str) -> Section:
    """The section that the set of probes `name` took. Raises: NotDrawableError if there is no such set with voidage at
    a height."""
    probed = {one.name: one for one in read_probes(results.data, results.case)}.get(name)
    section = _lay_out(probed) if probed else None
    if section is None:
        raise NotDrawableError([f"{results.path} has no set of probes `{name}` with the voidage at one height."])
    return section


def _lay_out(probed: Probed) -> Section | None:
    """The section that a set of probes is; None if it is none."""
    if "voidage" not in probed.values or np.ptp(probed.points[:, 2]) > 0.0:
        return None
    (x, column), (y, row) = (np.unique(np.round(probed.points[:, axis], 12), return_inverse=True) for axis in (0, 1))
    if min(len(x), len(y)) < 2:
        return None
    voidage = np.full((len(probed.times), len(y), len(x)), np.nan)
    voidage[:, row, column] = probed.values["voidage"]
    area = float(np.diff(x).min() * np.diff(y).min())
    return Section(probed.times, voidage, area, x, float(probed.points[0, 2]))


def cut_section(section: Section, span: tuple[float, float] | None) -> Section:
    """The section from the first to the second of the times [s] alone; all of it without them."""
    if span is None:
        return section
    inside = (section.times >= span[0]) & (section.times <= span[1])
    return replace(section, times=section.times[inside], voidage=section.voidage[inside])


def find_passing(section: Section, smallest: float) -> Passing:
    """Bubbles of a section through time.

    A bubble is a set of points, joined to neighbours in the section and from sample to sample, with a voidage over
    `EDGE`; its equivalent diameter is that of the circle of its largest area in one sample, at least `smallest` [m].
    What covers `OPEN` of the section is none, nor what is there in the first sample or the last: it is not whole.
    """
    labels, count = ndimage.label(section.voidage > EDGE)
    samples = len(section.times)
    if not samples or not count:
        return Passing(np.empty(0), 0)
    covered = np.zeros((samples, count + 1))
    for sample in range(samples):
        covered[sample] = np.bincount(labels[sample].ravel(), minlength=count + 1)
    widest = covered[:, 1:].max(axis=0)
    whole = (covered[0, 1:] == 0.0) & (covered[-1, 1:] == 0.0)
    is_open = widest >= OPEN * np.isfinite(section.voidage[0]).sum()
    diameters = np.sqrt(4.0 * widest * section.area / np.pi)
    return Passing(diameters[whole & ~is_open & (diameters >= smallest)], int(is_open.sum()))
