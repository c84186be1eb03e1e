"""Colours of the 3-D views, for the pictures and for their colour bars."""

from __future__ import annotations

import numpy as np
from matplotlib import colormaps
from matplotlib.colors import Colormap, ListedColormap

SPEED, TEMPERATURE = "viridis", "plasma"


def voidage_map() -> Colormap:
    """Blue where the bed is dense, nearly white in gas, so that black arrows stand on it."""
    return ListedColormap(colormaps["Blues_r"](np.linspace(0.3, 1.0, 256)), name="voidage")


def list_colours(has_heat: bool = False) -> np.ndarray:
    """The 256 colours of an animation, uint8 (256, 3): speed, and temperature where there is heat, in the light and in
    the shade, voidage, and greys."""
    maps, counts = ([SPEED, TEMPERATURE], (56, 20, 20)) if has_heat else ([SPEED], (96, 32, 32))
    parts = []
    for name in maps:
        for light, count in zip((1.0, 0.7, 0.45), counts, strict=True):
            parts.append(light * colormaps[name](np.linspace(0.0, 1.0, count)))
    left = 256 - sum(map(len, parts))
    parts.append(voidage_map()(np.linspace(0.0, 1.0, left // 2)))
    parts.append(np.repeat(np.linspace(0.0, 1.0, left - left // 2)[:, None], 4, axis=1))
    return np.round(255.0 * np.concatenate(parts)[:, :3]).astype(np.uint8)
