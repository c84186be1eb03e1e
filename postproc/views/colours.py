"""Colours of the 3-D views, for the pictures and for their colour bars."""

from __future__ import annotations

import numpy as np
from matplotlib import colormaps
from matplotlib.colors import Colormap, ListedColormap

SPEED = "viridis"


def voidage_map() -> Colormap:
    """Blue where the bed is dense, nearly white in gas, so that black arrows stand on it."""
    return ListedColormap(colormaps["Blues_r"](np.linspace(0.3, 1.0, 256)), name="voidage")


def list_colours() -> np.ndarray:
    """The 256 colours of an animation, uint8 (256, 3): speed in the light and in the shade, voidage, and greys."""
    fractions = [np.linspace(0.0, 1.0, count) for count in (96, 32, 32, 48, 48)]
    speed = colormaps[SPEED]
    parts = [speed(fractions[0]), 0.7 * speed(fractions[1]), 0.45 * speed(fractions[2]), voidage_map()(fractions[3])]
    parts.append(np.repeat(fractions[4][:, None], 4, axis=1))
    return np.round(255.0 * np.concatenate(parts)[:, :3]).astype(np.uint8)
