"""Where the probes of a case are."""

from __future__ import annotations

import numpy as np

from fbcouple.case.schema.gas import Domain
from fbcouple.case.schema.probes import Probe

WAYS = ("points", "line", "height")
"""Ways to say where the points of a set are."""
_FROM_WALL = 0.25
"""Cells that a point of a section keeps from the wall of a cylinder, which its mesh has as a polygon."""


def list_points(probe: Probe, domain: Domain) -> np.ndarray:
    """The points (n, 3) [m] of a set: those given, those on its line, or those of its section through `domain`."""
    if probe.points is not None:
        return np.array(probe.points, dtype=float)
    if probe.height is not None:
        return _cut_section(probe.height, domain)
    assert probe.line is not None and probe.count is not None, "the checks of the case ask for one of these"
    first, last = np.array(probe.line)
    return first + np.linspace(0.0, 1.0, probe.count)[:, None] * (last - first)


def _cut_section(height: float, domain: Domain) -> np.ndarray:
    """Middles of the cells across, row by row along x."""
    size, cells = np.array(domain.size[:2]), np.array(domain.cells[:2])
    spacing = size / cells
    y, x = np.meshgrid(*((np.arange(cells[axis]) + 0.5) * spacing[axis] for axis in (1, 0)), indexing="ij")
    points = np.column_stack([x.ravel(), y.ravel(), np.full(x.size, height)])
    if domain.shape != "cylinder":
        return points
    from_axis = np.linalg.norm(points[:, :2] - 0.5 * size, axis=1)
    return points[from_axis <= 0.5 * size.min() - _FROM_WALL * spacing.max()]
