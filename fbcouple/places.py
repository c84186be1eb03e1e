"""Where templates and shipped cases lie, inside an installed package or beside it in a checkout, and built things."""

import os
from pathlib import Path

_PACKAGE = Path(__file__).resolve().parent


def _find(name: str) -> Path:
    installed = _PACKAGE / name
    return installed if installed.is_dir() else _PACKAGE.parent / name


TEMPLATES = _find("templates")
CASES = _find("cases")
START = "grains/particles.data"
"""In a run folder: the particles as they start."""
WALLS = "grains/walls.stl"
"""In a run folder: the surface that the particles have for a wall, where the region is no plain box."""
PULSE = "logs/pulse"
"""In a run folder: touched while coupling steps are taken."""
FRAMES = "frames"
"""In a run folder: particles and gas at single moments, a netCDF file each."""


def cache_folder() -> Path:
    """Return the folder of built things: `FBCOUPLE_CACHE`, else `fbcouple` in the user's XDG cache folder."""
    if given := os.environ.get("FBCOUPLE_CACHE"):
        return Path(given).expanduser().resolve()
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "fbcouple"
