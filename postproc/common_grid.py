"""Fields of two runs on the grid that both can have: along each axis the coarser of theirs, each cell by its mean.

So nothing of a bed is left out: what lies at a wall is in the outermost cell of either mesh, wherever its centre is.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import xarray as xr
from scipy.interpolate import CubicSpline

from fbcouple.results.reader import NotDrawableError

_ROUNDING = 1e-9
"""Part of a cell that is none."""


def bring_together(
    one: xr.DataArray, other: xr.DataArray, size: Sequence[float], with_gaps: bool = False
) -> tuple[np.ndarray, np.ndarray]:
    """Both fields, of boxes of one `size` [m] along x, y and z, on the coarser of their grids along each axis.

    with_gaps: fields may have places of which nothing is known, nan; a coarser cell that holds a part of one is none.
    Raises: NotDrawableError if grids differ, and a field has such places without `with_gaps`.
    """
    fields = [one.values, other.values]
    for axis, dim in enumerate(one.dims):
        length = size["xyz".index(str(dim))]
        cells = min(one.sizes[dim], other.sizes[dim])
        is_whole = with_gaps or all(np.isfinite(values).all() for values in fields)
        if one.sizes[dim] != other.sizes[dim] and not is_whole:
            text = "their grids differ, and have places outside of the mesh; give all runs the same domain.cells."
            raise NotDrawableError([text])
        fields = [coarsen(values, axis, cells, length) for values in fields]
    return fields[0], fields[1]


def coarsen(values: np.ndarray, axis: int, cells: int, length: float) -> np.ndarray:
    """Cell means along `axis` on a grid of fewer equal `cells` over `length` [m].

    The running integral over the cells is known at their faces; a cubic spline takes it to the new faces. So the
    integral is kept, polynomials up to the second degree are exact, and on the same grid nothing changes. Along a line
    with gaps, nan, the cells are taken for constant, and a new one that holds a part of a gap is nan.
    """
    count = values.shape[axis]
    if count == cells:
        return values
    along = np.moveaxis(values, axis, 0)
    has_gaps = ~np.isfinite(along)
    filled = np.where(has_gaps, 0.0, along)
    integral = np.concatenate([np.zeros((1, *along.shape[1:])), np.cumsum(filled, axis=0)]) * (length / count)
    faces = CubicSpline(np.linspace(0.0, length, count + 1), integral, axis=0)(np.linspace(0.0, length, cells + 1))
    means = np.diff(faces, axis=0) * (cells / length)
    if has_gaps.any():
        shares = _share_cells(count, cells)
        constant = np.tensordot(shares, filled, axes=(1, 0))
        missing = np.tensordot(shares, has_gaps.astype(float), axes=(1, 0)) > _ROUNDING
        means = np.where(has_gaps.any(axis=0), np.where(missing, np.nan, constant), means)
    return np.moveaxis(means, 0, axis)


def _share_cells(count: int, cells: int) -> np.ndarray:
    """Of each of `cells` the parts that lie in each of `count` finer ones; shape (cells, count), rows add up to 1."""
    fine, coarse = np.linspace(0.0, 1.0, count + 1), np.linspace(0.0, 1.0, cells + 1)
    upper, lower = np.minimum.outer(coarse[1:], fine[1:]), np.maximum.outer(coarse[:-1], fine[:-1])
    shares: np.ndarray = np.clip(upper - lower, 0.0, None) * cells
    return shares
