"""Weights of particles over blocks of cells, and the kernels that carry values both ways with them.

The block of a particle has `lengths` (3,) cells and starts at its place in `base`. `table` has a row of weights a
particle: one for each cell of the block, x fastest, or (`by_axes`) one for each layer along x, y and z, the weight of
a cell being the product of its three.
"""

from __future__ import annotations

import math
from functools import cache

import numpy as np

from fbcouple.coupling.box.halo import LocalGrid
from fbcouple.physics.compiler import njit
from fbcouple.physics.jit import compiled, inlined

CUT = 3.0
"""Bandwidths at which the Gaussian kernel ends."""


def block_offsets(local: LocalGrid, lengths: np.ndarray) -> np.ndarray:
    """Flat steps (cells of the block,) from its first cell, x fastest."""
    nx, ny, _ = local.shape
    x, y, z = (np.arange(n) for n in lengths)
    return ((z[:, None, None] * ny + y[:, None]) * nx + x).ravel().astype(np.uint64)


TURNS = (-0.85, -0.99, 0.60), (0.56, -0.21, -0.14)
"""Rotation vectors of the two shells of satellites: the best of 40 000 random pairs, see `satellites`."""


@cache
def satellites() -> np.ndarray:
    """Centres (29, 3), in radii, of 29 parts of equal volume of a sphere: its core and two shells of 14 parts each.

    The directions are those of the axes and of the diagonals of a cube, as in CFDEMcoupling's divided method (Goniva
    et al. 2012), but turned, so that no two points lie in a plane of the grid: what is on one side of a face differs
    from the volume there by 4.6 % of the particle at most, not 15.5 %. Each shell stands at its own root-mean-square
    radius, the inner one with what the core lacks, so that the points have the second moment of the sphere: a fifth of
    the radius squared along each axis.
    """
    corners = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) / math.sqrt(3.0)
    directions = np.concatenate([np.eye(3), -np.eye(3), corners])
    split = (15.0 / 29.0) ** (5.0 / 3.0)
    shells = [
        math.sqrt(3.0 / 5.0 * 29.0 / 14.0 * moment) * directions @ _turn(np.array(vector))
        for vector, moment in zip(TURNS, (split, 1.0 - split), strict=True)
    ]
    return np.concatenate([np.zeros((1, 3)), *shells])


def _turn(vector: np.ndarray) -> np.ndarray:
    """Matrix (3, 3) of the rotation about `vector` by its length (Rodrigues), for rows from the left."""
    angle = float(np.linalg.norm(vector))
    x, y, z = vector / angle
    cross = np.array([[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]])
    return np.eye(3) + math.sin(angle) * cross + (1.0 - math.cos(angle)) * cross @ cross


@njit(inline="always")
def _reflect(cell, first, last):
    """The cell that `cell` falls on when the walls beyond the cells `first` and `last` are mirrors."""
    if first <= cell <= last:
        return cell
    count = last - first + 1
    around = (cell - first) % (2 * count)
    return first + (around if around < count else 2 * count - 1 - around)


@njit(inline="always")
def _start(lowest, low, high, length):
    """First cell of a block that holds the cell `lowest` or, next to an edge of the local grid, what is reflected
    there."""
    return min(max(lowest, low), high - length)


@njit(inline="always")
def _lies_in(s, first, last):
    """A centre is in the box, or less than half a cell outside of it: no overlap of a contact puts it farther."""
    return first - 0.5 <= s <= last + 1.5


@njit(cache=True)
def divide(positions, radii, points, scale, low, high, walls, lengths, shape, base, table):
    """An equal part of each particle to the cell of each of `points` (k, 3) [radii]: fills base (n,), table (n, m).

    Returns the first particle that does not fit into the local grid, or -1.
    """
    share = 1.0 / len(points)
    start = np.empty(3, np.int64)
    for p in range(len(positions)):
        for axis in range(3):
            if not _lies_in(positions[p, axis] * scale[axis], walls[0, axis], walls[1, axis]):
                return p
            lowest = int(np.floor((positions[p, axis] - radii[p] * (len(points) > 1)) * scale[axis]))
            start[axis] = _start(lowest, low[axis], high[axis], lengths[axis])
        table[p, :] = 0.0
        for k in range(len(points)):
            index = 0
            for axis in (2, 1, 0):
                cell = int(np.floor((positions[p, axis] + radii[p] * points[k, axis]) * scale[axis]))
                step = _reflect(cell, walls[0, axis], walls[1, axis]) - start[axis]
                if not 0 <= step < lengths[axis]:
                    return p
                index = index * lengths[axis] + step
            table[p, index] += share
        base[p] = ((start[2] - low[2]) * shape[1] + start[1] - low[1]) * shape[0] + start[0] - low[0]
    return -1


@njit(cache=True)
def spread_out(positions, bandwidth, scale, low, high, walls, lengths, shape, base, table):
    """The parts of exp(-r^2/b^2) over layers of cells along each axis: fills base (n,) and table (n, layers).

    Returns the first particle that does not fit into the local grid, or -1.
    """
    start = np.empty(3, np.int64)
    whole = 2.0 * math.erf(CUT)
    for p in range(len(positions)):
        table[p, :] = 0.0
        column = 0
        for axis in range(3):
            s, width = positions[p, axis] * scale[axis], bandwidth * scale[axis]
            if not _lies_in(s, walls[0, axis], walls[1, axis]):
                return p
            first, last = int(np.floor(s - CUT * width)), int(np.floor(s + CUT * width))
            start[axis] = _start(first, low[axis], high[axis], lengths[axis])
            below = -math.erf(CUT)
            for layer in range(first, last + 1):
                above = math.erf(min((layer + 1 - s) / width, CUT))
                step = _reflect(layer, walls[0, axis], walls[1, axis]) - start[axis]
                if not 0 <= step < lengths[axis]:
                    return p
                table[p, column + step] += (above - below) / whole
                below = above
            column += lengths[axis]
        base[p] = ((start[2] - low[2]) * shape[1] + start[1] - low[1]) * shape[0] + start[0] - low[0]
    return -1


@inlined
def _expand(row, lengths, by_axes, weights):
    """The weights of a block's cells from its row of the table."""
    if not by_axes:
        weights[:] = row
        return
    nx, ny = lengths[0], lengths[1]
    for c in range(lengths[2]):
        for b in range(ny):
            both = row[nx + ny + c] * row[nx + b]
            for a in range(nx):
                weights[(c * ny + b) * nx + a] = both * row[a]


@compiled
def scatter(base, offsets, lengths, by_axes, table, rows, field):
    """Add the `rows` (n, c) of the particles to `field` (places, c), each shared by its weights."""
    weights = np.empty(len(offsets))
    for p in range(len(base)):
        _expand(table[p], lengths, by_axes, weights)
        for k in range(len(offsets)):
            index = base[p] + offsets[k]
            for q in range(rows.shape[1]):
                field[index, q] += weights[k] * rows[p, q]


@compiled
def gather(base, offsets, lengths, by_axes, table, field, rows):
    """Set the `rows` (n, c) of the particles to the mean of `field` (places, c) by their weights."""
    weights = np.empty(len(offsets))
    for p in range(len(base)):
        _expand(table[p], lengths, by_axes, weights)
        rows[p, :] = 0.0
        for k in range(len(offsets)):
            index = base[p] + offsets[k]
            for q in range(rows.shape[1]):
                rows[p, q] += weights[k] * field[index, q]
