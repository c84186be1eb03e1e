"""The library that draws in three dimensions: 566 MB of VTK, an extra of the installation."""

from __future__ import annotations

from importlib.util import find_spec

from fbcouple.results.reader import NotDrawableError


def require_pyvista() -> None:
    """Raise NotDrawableError, with the way to install it, where pyvista is missing."""
    if find_spec("pyvista") is None:
        text = "3-D pictures, films and files for ParaView need pyvista, which is not installed"
        raise NotDrawableError([f"{text}; install it with: pip install 'fbcouple[views]'."])
