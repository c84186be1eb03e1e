"""Drag of particles of several sizes: that of the cell's mean diameter, times a factor of the particle's own."""

from __future__ import annotations

from fbcouple.physics.jit import inlined


@inlined
def size_factor(eps, ratio):
    """eps y + phi y^2 + 0.064 eps y^3, y = d/<d> the `ratio`, on the drag F = force/(3 pi mu d U) taken at <d>, where
    1/<d> is the mean of 1/d by volume of solids; 1 + 0.064 eps, not 1, at y = 1.

    Beetstra, van der Hoef and Kuipers 2007, AIChE J. 53:489.
    """
    return ratio * (eps + ratio * ((1.0 - eps) + 0.064 * eps * ratio))
