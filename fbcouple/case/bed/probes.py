"""Where the probes of a case are."""

from __future__ import annotations

import numpy as np

from fbcouple.case.schema.probes import Probe


def list_points(probe: Probe) -> np.ndarray:
    """The points (n, 3) [m] of a set: those given, or those on its line."""
    if probe.points is not None:
        return np.array(probe.points, dtype=float)
    assert probe.line is not None and probe.count is not None, "the checks of the case ask for one of both"
    first, last = np.array(probe.line)
    return first + np.linspace(0.0, 1.0, probe.count)[:, None] * (last - first)
