"""How much of a region lies below a height, and up to which height a volume fills it, from its surface alone.

By the divergence theorem with the vector field (0, 0, z - h), which is zero on the cut at the height h: the volume
below h is the integral of (z - h) n_z over the part of the surface below h, n the outward normal. Vertical walls add
nothing.
"""

from __future__ import annotations

import numpy as np

_HALVINGS = 60


class Filling:
    """The volume of a region below each height; `triangles` (n, 3, 3) [m]: its surface, anticlockwise from outside."""

    def __init__(self, triangles: np.ndarray) -> None:
        a, b, c = triangles.transpose(1, 0, 2)
        self._upward = 0.5 * np.cross(b - a, c - a)[:, 2]
        flat = np.abs(self._upward) > 0.0
        self._upward, heights = self._upward[flat], np.sort(triangles[flat][:, :, 2], axis=1)
        self.bottom = float(triangles[:, :, 2].min())
        """Height [m] of the lowest point."""
        self.top = float(triangles[:, :, 2].max())
        """Height [m] of the highest point."""
        self._low, self._middle, self._high = heights.T
        self.volume = self.find_volume(self.top)
        """Of the whole region [m3]."""

    def find_volume(self, height: float) -> float:
        """Volume [m3] below `height` [m]."""
        return float(self._upward @ -self._find_depth(height))

    def _find_depth(self, height: float) -> np.ndarray:
        """Mean over each triangle of max(height - z, 0) [m], in which z is distributed as a hat over its corners'."""
        low, middle, high = self._low, self._middle, self._high
        depth = np.where(height > low, height - (low + middle + high) / 3.0, 0.0)
        first = (height > low) & (height <= middle)
        last = (height > middle) & (height < high)
        a, b, c = low[first], middle[first], high[first]
        depth[first] = (height - a) ** 3 / (3.0 * (b - a) * (c - a))
        a, b, c = low[last], middle[last], high[last]
        depth[last] += (c - height) ** 3 / (3.0 * (c - a) * (c - b))
        return depth

    def find_level(self, volume: float) -> float:
        """Height [m] above the lowest point up to which `volume` [m3] fills the region from below.

        What does not fit stands on top of it, on its mean cross-section: the level is then above the region.
        """
        extent = self.top - self.bottom
        if volume >= self.volume:
            return extent * volume / self.volume
        low, high = self.bottom, self.top
        for _ in range(_HALVINGS):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if self.find_volume(middle) < volume else (low, middle)
        return high - self.bottom
