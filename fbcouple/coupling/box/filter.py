"""The conservative filter: (1/4, 1/2, 1/4) along each axis, reflected at walls (paper, eq. 33).

It acts on extensive quantities (solids volume, force) before they are divided by the cell volume, so that totals are
kept to rounding (eq. 34). One pass adds a variance of half a cell size squared along each axis. The operator is
symmetric, so filtering what is read at the particles makes reading the transpose of writing.
"""

from __future__ import annotations

import numpy as np

from fbcouple.physics.jit import compiled, inlined


def filtered(field: np.ndarray, passes: int, scratch: np.ndarray) -> np.ndarray:
    """Local `field` (z + 1, y + 1, x + 1, c) filtered `passes` times: in it or in `scratch`, another of its shape.

    Both are overwritten. Walls reflect. An edge of the local grid inside the domain reflects too, which is wrong there:
    the local is widened by one cell a pass for that reason.
    """
    _filter(field.ravel(), scratch.ravel(), field.shape, passes)
    return scratch if passes % 2 else field


@compiled
def _filter(field, scratch, shape, passes):
    z, y, x, components = shape
    for _ in range(passes):
        _smooth(field, scratch, x * y * components, z)
        _smooth(scratch, field, x * components, y)
        _smooth(field, scratch, components, x)
        field, scratch = scratch, field


@compiled
def _smooth(source, target, stride, layers):
    """Along one axis of a flat field: `stride` values from layer to layer, blocks of `layers`, the last one extra.

    The extra layers get values without meaning; nothing reads them but with weight zero.
    """
    count = len(source)
    below, here, above = source[: count - 2 * stride], source[stride : count - stride], source[2 * stride :]
    inside = target[stride : count - stride]
    for q in range(len(inside)):
        inside[q] = 0.25 * (below[q] + above[q]) + 0.5 * here[q]
    inner = stride if layers > 2 else 0
    for first in range(0, count, layers * stride):
        last = first + (layers - 2) * stride
        _reflect(source[first : first + stride], source[first + inner :], target[first:])
        _reflect(source[last : last + stride], source[last - inner :], target[last:])


@inlined
def _reflect(wall, inner, target):
    for q in range(len(wall)):
        target[q] = 0.75 * wall[q] + 0.25 * inner[q]
