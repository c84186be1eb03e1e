"""How fast the bed pulsates: power spectra of pressure drop, bed height and probes, and their highest peaks."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from scipy.signal import detrend, welch
from scipy.stats import chi2

from fbcouple.postproc.figures.probes import is_map
from fbcouple.postproc.figures.registry import figure
from fbcouple.postproc.joined_rows import require_every_row
from fbcouple.postproc.statistics import find_steady_time
from fbcouple.postproc.style import BLUE, COLUMN, GREY, INK, VERMILION, inset_axes, new_figure
from fbcouple.postproc.value_text import with_error
from fbcouple.results.probes import read_probes
from fbcouple.results.reader import NotDrawableError, Results
from fbcouple.results.steady_part import FEWEST

SIGNALS = {
    "pressure_drop": ("Pressure drop", "Pa", 1.0),
    "solids_centre_z": ("Centre of mass", "mm", 1e3),
    "bed_height": ("Bed height", "mm", 1e3),
}
SEGMENT = 4.0
"""Shortest segment [s] of a long record: a resolution of 0.25 Hz."""
HIGHEST = 10.0
"""Frequency [Hz] up to which spectra are drawn; beds of this size pulsate at 1-5 Hz."""
SURE = 0.95
"""Probability of the bands."""
RARE = 0.01
"""Probability with which red noise has a peak that stands out."""
_FINER = 8
_OVERLAP = 1.0 / 6.0
"""Correlation of two Hann windows that overlap by half (Welch 1967)."""


@dataclass(frozen=True)
class Spectrum:
    """One-sided power spectral density `power` [unit2/Hz] at the frequencies [Hz] that a segment tells apart."""

    name: str
    frequency: np.ndarray
    power: np.ndarray
    peak: float
    """Frequency [Hz] of the highest peak."""
    resolution: float
    """Distance [Hz] at which two peaks are told apart, one over the length of a segment."""
    segments: int
    band: tuple[float, float]
    """True density over the one found, from and to, with the probability `SURE`."""
    noise: np.ndarray
    """Density of red noise of the same variance and the same correlation of neighbours."""
    stands_out: bool
    """Is the peak higher than red noise has any but with the probability `RARE`?"""


def find_spectrum(name: str, time: np.ndarray, values: np.ndarray) -> Spectrum:
    """Spectrum of `values` at `time` [s] by Welch's method (1967): Hann windows that overlap by half.

    Segments are a quarter of the record, but not shorter than `SEGMENT` unless the record is. Rows stand where the
    fluid steps allowed, so they are brought to equal distances, linearly. Slower changes than a segment are left out.
    """
    even, step = _lay_evenly(name, time, values)
    length = min(len(even), max(len(even) // 4, int(SEGMENT / step)))
    frequency, power = welch(even, 1.0 / step, "hann", length, length // 2, detrend="linear")
    resolution = 1.0 / (length * step)
    segments = 1 + (len(even) - length) // (length - length // 2)
    freedom = 2.0 * segments / (1.0 + 2.0 * _OVERLAP**2 * (1.0 - 1.0 / segments))
    known = frequency > 0.5 * resolution
    noise = _make_red_noise(even, step, frequency, float(power[known].mean()))
    limit = chi2.ppf((1.0 - RARE) ** (1.0 / known.sum()), freedom) / freedom
    band = tuple(float(freedom / chi2.ppf(share, freedom)) for share in (0.5 + SURE / 2, 0.5 - SURE / 2))
    peak = _find_peak(even, step, length, resolution)
    near = known & (np.abs(frequency - peak) <= resolution)
    stands_out = bool((power[near] > limit * noise[near]).any())
    return Spectrum(name, frequency, power, peak, resolution, segments, (band[0], band[1]), noise, stands_out)


def _lay_evenly(name: str, time: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, float]:
    """The values at equal distances, and these [s]. Raises: NotDrawableError if they are too few or do not change."""
    if len(time) < FEWEST:
        raise NotDrawableError([f"`{name}` has {len(time)} steady rows, {FEWEST} are needed for a spectrum."])
    step = (time[-1] - time[0]) / (len(time) - 1)
    if len(time) * step * HIGHEST < 1.0:
        text = f"`{name}` has {len(time) * step:.3g} s of steady rows, {1.0 / HIGHEST:g} s are needed for a spectrum."
        raise NotDrawableError([text])
    if np.ptp(values) == 0.0:
        raise NotDrawableError([f"`{name}` does not change: it has no spectrum."])
    return np.interp(time[0] + step * np.arange(len(time)), time, values), step


def _find_peak(even: np.ndarray, step: float, length: int, resolution: float) -> float:
    """Frequency of the highest peak, sought between the frequencies that are told apart by padding with zeros."""
    fine, power = welch(even, 1.0 / step, "hann", length, length // 2, _FINER * length, detrend="linear")
    inside = np.flatnonzero(fine >= resolution)
    return float(fine[inside[np.argmax(power[inside])]])


def _make_red_noise(even: np.ndarray, step: float, frequency: np.ndarray, mean: float) -> np.ndarray:
    """Spectrum of an autoregressive series of first order with the values' correlation of neighbours, of this `mean`
    density (Gilman et al. 1963, J. Atmos. Sci. 20:182; as in Torrence and Compo 1998, Bull. Am. Meteorol. Soc. 79:61).
    """
    apart = detrend(even)
    lag = float(apart[1:] @ apart[:-1]) / float(apart @ apart)
    shape = 1.0 / (1.0 + lag**2 - 2.0 * lag * np.cos(2.0 * np.pi * frequency * step))
    return mean * shape / shape[1:].mean()


def describe_signal(name: str) -> tuple[str, str, float]:
    """Words, unit and factor to it of a signal: one of `SIGNALS`, or the pressure at a probe."""
    return SIGNALS.get(name, (name, "Pa", 1.0))


def spectra_of(results: Results) -> list[Spectrum]:
    """Spectra of the `SIGNALS` that the run has, and of the pressure at points of its probes, after its start-up.

    Raises: NotDrawableError if the record is too short, or its rows are joined.
    """
    require_every_row(results, "spectra")
    start = find_steady_time(results)
    spectra = []
    for name in SIGNALS:
        if name in results.data:
            history = results.history(name)[1:]
            steady = history["time"].values >= start
            spectra.append(find_spectrum(name, history["time"].values[steady], history.values[steady]))
    for found in read_probes(results.data, results.case):
        steady = found.times >= start
        if "pressure" in found.values and not is_map(found):
            for number, values in enumerate(found.values["pressure"].T, start=1):
                with suppress(NotDrawableError):  # too few samples, or none that change: the others stay
                    name = f"Pressure at {found.name} {number}"
                    spectra.append(find_spectrum(name, found.times[steady], values[steady]))
    return spectra


@figure
def spectrum(results: Results) -> Figure:
    """Power spectral density of pressure drop, bed height and the pressure at probes, with the highest peak of each."""
    spectra = spectra_of(results)
    each, gap, left, bottom = 1.25, 0.42, 0.66, 0.42
    start = find_steady_time(results)
    note = f"from t = {start:.3g} s to the end; bar: {100 * SURE:g} % band of a point; dotted: red noise"
    picture = new_figure(results.title, COLUMN, bottom + len(spectra) * (each + gap), note)
    for row, found in enumerate(reversed(spectra)):
        axes = inset_axes(picture, left, bottom + row * (each + gap), COLUMN - left - 0.12, each)
        _draw(axes, found)
        if row == 0:
            axes.set_xlabel("Frequency [Hz] (grey: slower than a segment)")
    return picture


def _draw(axes: Axes, found: Spectrum) -> None:
    """The density where a segment tells it, the band that each point of it has, and its peak if it stands out."""
    words, unit, factor = describe_signal(found.name)
    shown = (found.frequency > 0.0) & (found.frequency <= HIGHEST)
    frequency, power = found.frequency[shown], found.power[shown] * factor**2
    axes.semilogy(frequency, power, color=BLUE, marker=".", markersize=3)
    axes.semilogy(frequency, found.noise[shown] * factor**2, color=GREY, linestyle=":", linewidth=0.9)
    axes.axvspan(0.0, found.resolution, color=GREY, alpha=0.2, linewidth=0)
    top, right = float(power.max()), min(HIGHEST, found.frequency[-1])
    axes.set(xlim=(0.0, right), ylim=(top * 1e-5, top * 30.0))
    bar = [[1.0 - found.band[0]], [found.band[1] - 1.0]]
    middle = top * 1e-4 if found.band[1] > 5.0 else top
    axes.errorbar([0.95 * right], [middle], yerr=np.multiply(bar, middle), color=INK, capsize=2, linewidth=0.8)
    axes.set_ylabel(f"PSD [{unit}$^2$ Hz$^{{-1}}$]")
    if found.stands_out:
        axes.axvline(found.peak, color=VERMILION, linestyle="--", linewidth=1.0)
        text = f"{words}: peak at {with_error(found.peak, found.resolution / 2)} Hz"
    else:
        text = f"{words}: no peak stands out of red noise (largest at {found.peak:.2f} Hz)"
    axes.set_title(text, loc="left", size="small", pad=2.0)
