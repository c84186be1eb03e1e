"""How far computed values are from measured ones: by root mean square, at most, and in how much they vary."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Deviation:
    """Computed less measured values at the same points, in their unit.

    `rms`, `bias` (the mean) and `largest` (the greatest distance); `rms_error`: the largest that the standard
    error of `rms` can be: points share cells, and cells the same slow swings, so that the errors of all may go
    together; nan where the error of a point is not known; `amplitude`: largest less smallest computed value over the
    same of the measured ones, nan of a single point: below 1 the computed profile is too flat; `amplitude_error`: the
    largest that its standard error can be, as those of the two points add up where one is up when the other is down.
    """

    rms: float
    bias: float
    largest: float
    rms_error: float
    amplitude: float
    amplitude_error: float


def find_deviation(computed: np.ndarray, measured: np.ndarray, stderr: np.ndarray | None = None) -> Deviation:
    """The distance of `computed` from `measured`, (n,) each; `stderr` (n,): standard errors of the computed values."""
    apart = computed - measured
    rms = float(np.sqrt(np.mean(apart**2)))
    spread = float(np.ptp(measured))
    error = swing = math.nan
    if stderr is not None:
        swing = float(stderr[np.argmax(computed)] + stderr[np.argmin(computed)])
        error = float(np.mean(np.abs(apart) * stderr)) / rms if rms else float(np.sqrt(np.mean(stderr**2)))
    return Deviation(
        rms,
        float(np.mean(apart)),
        float(np.max(np.abs(apart))),
        error,
        float(np.ptp(computed)) / spread if spread else math.nan,
        swing / spread if spread else math.nan,
    )
