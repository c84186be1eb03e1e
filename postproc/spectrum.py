"""How fast the bed pulsates: power spectra of pressure drop and bed height, and their highest peaks."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure
from scipy.signal import welch

from postproc.dataset import NotDrawableError, Results
from postproc.figures import figure
from postproc.statistics import FEWEST, find_steady_time
from postproc.style import BLUE, COLUMN, GREY, VERMILION, inset_axes, new_figure

SIGNALS = {"pressure_drop": ("Pressure drop", "Pa", 1.0), "bed_height": ("Bed height", "mm", 1e3)}
SEGMENT = 4.0
"""Shortest segment [s] of a long record: a resolution of 0.25 Hz."""
HIGHEST = 10.0
"""Frequency [Hz] up to which spectra are drawn; beds of this size pulsate at 1-5 Hz."""
_FINER = 8


@dataclass(frozen=True)
class Spectrum:
    """One-sided power spectral density `power` [unit2/Hz] at `frequency` [Hz], its highest peak and its resolution."""

    name: str
    frequency: np.ndarray
    power: np.ndarray
    peak: float
    """Frequency [Hz] of the highest peak."""
    resolution: float
    """Distance [Hz] at which two peaks are told apart, one over the length of a segment."""
    segments: int


def find_spectrum(name: str, time: np.ndarray, values: np.ndarray) -> Spectrum:
    """Spectrum of `values` at `time` [s] by Welch's method (1967): Hann windows that overlap by half.

    Segments are a quarter of the record, but not shorter than `SEGMENT` unless the record is. Rows stand where the
    fluid steps allowed, so they are brought to equal distances, linearly. Slower changes than a segment are left out.
    """
    if len(time) < FEWEST:
        raise NotDrawableError([f"`{name}` has {len(time)} steady rows, {FEWEST} are needed for a spectrum."])
    step = (time[-1] - time[0]) / (len(time) - 1)
    if len(time) * step * HIGHEST < 1.0:
        text = f"`{name}` has {len(time) * step:.3g} s of steady rows, {1.0 / HIGHEST:g} s are needed for a spectrum."
        raise NotDrawableError([text])
    if np.ptp(values) == 0.0:
        raise NotDrawableError([f"`{name}` does not change: it has no spectrum."])
    even = np.interp(time[0] + step * np.arange(len(time)), time, values)
    length = min(len(even), max(len(even) // 4, int(SEGMENT / step)))
    finer = _FINER * length
    frequency, power = welch(even, 1.0 / step, "hann", length, length // 2, finer, detrend="linear")
    resolution = 1.0 / (length * step)
    inside = np.flatnonzero(frequency >= resolution)
    peak = float(frequency[inside[np.argmax(power[inside])]])
    return Spectrum(name, frequency, power, peak, resolution, 1 + (len(even) - length) // (length - length // 2))


def spectra_of(results: Results) -> list[Spectrum]:
    """Spectra of the `SIGNALS` that the run has, after its start-up."""
    start = find_steady_time(results)
    spectra = []
    for name in SIGNALS:
        if name in results.data:
            history = results.history(name)[1:]
            steady = history["time"].values >= start
            spectra.append(find_spectrum(name, history["time"].values[steady], history.values[steady]))
    return spectra


@figure
def spectrum(results: Results) -> Figure:
    """Power spectral density of pressure drop and bed height, with the highest peak of each."""
    spectra = spectra_of(results)
    each, gap, left, bottom = 1.25, 0.42, 0.66, 0.42
    start = find_steady_time(results)
    picture = new_figure(
        results.title, COLUMN, bottom + len(spectra) * (each + gap), f"from t = {start:.3g} s to the end"
    )
    for row, found in enumerate(reversed(spectra)):
        words, unit, factor = SIGNALS[found.name]
        axes = inset_axes(picture, left, bottom + row * (each + gap), COLUMN - left - 0.12, each)
        shown = (found.frequency > 0.0) & (found.frequency <= HIGHEST)
        axes.semilogy(found.frequency[shown], found.power[shown] * factor**2, color=BLUE)
        axes.axvline(found.peak, color=VERMILION, linestyle="--", linewidth=1.0)
        axes.axvspan(0.0, found.resolution, color=GREY, alpha=0.2, linewidth=0)
        top = float(found.power[shown].max()) * factor**2
        axes.set(xlim=(0.0, min(HIGHEST, found.frequency[-1])), ylim=(top * 1e-5, top * 3.0))
        axes.set_ylabel(f"PSD [{unit}$^2$ Hz$^{{-1}}$]")
        peak = f"{words}: peak at {found.peak:.2f} Hz, resolution {found.resolution:.2f} Hz"
        axes.set_title(peak, loc="left", size="small", pad=2.0)
        if row == 0:
            axes.set_xlabel("Frequency [Hz] (grey: slower than a segment)")
    return picture
