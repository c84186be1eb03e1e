"""Where the arrows of a map stand: at places that do not depend on the mesh, so that meshes can be compared."""

from __future__ import annotations

import numpy as np

ROUNDING = 1e-9


def sample_arrows(
    across: np.ndarray, up: np.ndarray, size: tuple[float, float], most: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Take a vector field (z, x) to the middles of equal parts of a box of `size` (width, height), linearly.

    At most `most` of them stand side by side, and as far apart up as across; a coarse mesh has as many as cells. A
    place next to which a value is not finite, outside of a mesh or without particles, has nan.

    Returns: x over width, z over height, and the components there, each (rows, columns).
    """
    nz, nx = across.shape
    columns = min(most, nx)
    rows = min(max(1, round(columns * size[1] / size[0])), nz)
    along_x, along_z = _interpolation(nx, columns), _interpolation(nz, rows)
    x, z = np.meshgrid(_middles(columns), _middles(rows))
    known = np.isfinite(across) & np.isfinite(up)
    whole = along_z @ known @ along_x.T > 1.0 - ROUNDING
    taken = (along_z @ np.where(known, field, 0.0) @ along_x.T for field in (across, up))
    return x, z, *(np.where(whole, field, np.nan) for field in taken)


def _middles(parts: int) -> np.ndarray:
    return (np.arange(parts) + 0.5) / parts


def _interpolation(cells: int, parts: int) -> np.ndarray:
    """Matrix (parts, cells) that takes values at cell centres linearly to the middles of `parts` <= `cells` parts."""
    return np.stack([np.interp(_middles(parts), _middles(cells), unit) for unit in np.eye(cells)], axis=1)
