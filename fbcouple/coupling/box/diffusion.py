"""Diffusion of local fields for a prescribed width: implicit, conservative, reflected at walls.

Sun and Xiao 2015 (Int. J. Multiphase Flow 77, 142): diffusion over the time b^2/4 (diffusivity 1) is a Gaussian kernel
exp(-r^2/b^2). Here it takes `STEPS` backward Euler steps, each split into one tridiagonal solve an axis; on a box of
equal cells the three commute, so that nothing is lost by that. A step adds the variance b^2/(2 STEPS) along each axis,
to rounding. Like the filter the operator keeps totals and is symmetric, which makes reading through it the transpose of
writing through it; both hold on each rank's local grid by itself, whatever the local does not see.
"""

from __future__ import annotations

import numpy as np

from fbcouple.coupling.box.halo import LocalGrid
from fbcouple.physics.jit import compiled, inlined

STEPS = 6
"""Six steps differ from the Gaussian by 6 % of its content, one by 29 %, eight by 5 % (b of 6 cells)."""
UNSEEN = 1e-13
"""Part of what a particle writes that may lie beyond the local grid: so much depends on the number of ranks."""


class Diffusion:
    """Smooths fields of a local grid by the bandwidth b [m]."""

    def __init__(self, local: LocalGrid, bandwidth: float) -> None:
        ratios = _find_ratios(local.grid.spacing, bandwidth)
        self._axes = [(ratio, _find_pivots(layers, ratio)) for ratio, layers in zip(ratios, local.shape, strict=True)]

    def smooth(self, field: np.ndarray) -> None:
        """Smooth local `field` (z + 1, y + 1, x + 1, c), or its lowest layers and one extra, in place.

        The extra upper layers keep no meaning.
        """
        z, y, x, components = field.shape
        lines = (components, x), (x * components, y), (y * x * components, z)
        for (stride, layers), (ratio, pivots) in zip(lines, self._axes, strict=True):
            _diffuse(field.reshape(-1), stride, layers - 1, ratio, pivots)


def find_margin(spacing: np.ndarray, bandwidth: float) -> np.ndarray:
    """Cells (3,) around a particle's own beyond which less than `UNSEEN` of it is spread; `spacing` (3,), b [m]."""
    if bandwidth == 0.0:
        return np.zeros(3, int)
    return np.array([_find_tail(ratio) for ratio in _find_ratios(spacing, bandwidth)])


def _find_ratios(spacing: np.ndarray, bandwidth: float) -> np.ndarray:
    """Time of a step times diffusivity over cell size squared, (3,)."""
    return bandwidth**2 / (4.0 * STEPS * np.asarray(spacing) ** 2)


def _find_tail(ratio: float) -> int:
    """Cells on either side that hold all but `UNSEEN` of what one cell is spread to."""
    length = 64
    while True:
        line = np.zeros(length + 1)
        line[0] = 1.0  # the wall beside it makes this the kernel's right half, doubled
        _diffuse(line, 1, length, ratio, _find_pivots(length, ratio))
        beyond = np.cumsum(line[length - 1 :: -1])[::-1]
        if beyond[-1] < 1e-3 * UNSEEN:
            return int(np.argmax(beyond < UNSEEN))
        length *= 2


def _find_pivots(layers: int, ratio: float) -> np.ndarray:
    """Inverse pivots (layers,) of I - ratio times the second difference, with a wall below and none above."""
    pivots = np.empty(layers)
    pivots[0] = 1.0 / (1.0 + ratio)
    for n in range(1, layers):
        pivots[n] = 1.0 / (1.0 + 2.0 * ratio - ratio**2 * pivots[n - 1])
    return pivots


@compiled
def _diffuse(flat, stride, layers, ratio, pivots):
    """`STEPS` solves along one axis of a flat field: blocks of `layers` of `stride` values, and one extra layer each.

    There is a wall, or no more to be seen, above the last layer too.
    """
    if layers == 1:
        return
    top = 1.0 / (1.0 / pivots[layers - 1] - ratio)
    for first in range(0, len(flat), (layers + 1) * stride):
        for _ in range(STEPS):
            _scale(flat[first : first + stride], pivots[0])
            for n in range(1, layers):
                here = first + n * stride
                pivot = pivots[n] if n < layers - 1 else top
                _eliminate(flat[here - stride : here], flat[here : here + stride], ratio, pivot)
            for n in range(layers - 2, -1, -1):
                here = first + n * stride
                _substitute(flat[here : here + stride], flat[here + stride : here + 2 * stride], ratio * pivots[n])


@inlined
def _scale(values, factor):
    for q in range(len(values)):
        values[q] *= factor


@inlined
def _eliminate(before, here, ratio, pivot):
    for q in range(len(here)):
        here[q] = (here[q] + ratio * before[q]) * pivot


@inlined
def _substitute(here, after, factor):
    for q in range(len(here)):
        here[q] += factor * after[q]
