"""How a measurement is compared with a finished run, as a registry. To add one: a function under
`@comparison("name", ...)`, which gives the run's numbers at the measured points."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr

from fbcouple.input_files.measured_lines import QUANTITIES, Points, Reference
from fbcouple.postproc.experiment import read_run
from fbcouple.postproc.figures.bubbles import SMALLEST
from fbcouple.postproc.figures.spectrum import SIGNALS, find_spectrum
from fbcouple.postproc.joined_rows import require_every_row, require_own_rows
from fbcouple.postproc.sections import cut_section, find_passing, read_section
from fbcouple.results.reader import NotDrawableError, Results
from fbcouple.results.steady_part import FEWEST, estimate_error
from fbcouple.results.variables import HISTORIES
from fbcouple.validate.schema import Measurement


@dataclass(frozen=True)
class Task:
    """A measurement with its points: of a number one, at x = nan; of a line where it lies, too."""

    measurement: Measurement
    points: Points
    line: Reference | None = None


@dataclass(frozen=True)
class Found:
    """What a run has at the measured points: `values` and their standard errors, (n,); for the picture its `curve`,
    where and what, (m,) both."""

    values: np.ndarray
    stderr: np.ndarray | None = None
    curve: tuple[np.ndarray, np.ndarray] | None = None


Function = Callable[[Results, Task], Found]


@dataclass(frozen=True)
class Comparison:
    """One of COMPARISONS: what of a run it takes, by name with the units, or LINE or SECTION; the axis of its points
    with the unit ("": it compares one number), and which keys of a measurement it needs, and takes besides."""

    name: str
    function: Function
    of: dict[str, str] | str
    axis: str
    unit: str
    needs: tuple[str, ...]
    takes: tuple[str, ...]


COMPARISONS: dict[str, Comparison] = {}
LINE, SECTION = "quantity@height", "a set of probes at a height"
"""What a comparison may take that each case names itself."""
UNITS = {name: unit for name, (unit, _) in HISTORIES.items()}
"""Histories that can be compared, and their units."""


def comparison(
    name: str,
    of: dict[str, str] | str,
    axis: str = "",
    unit: str = "",
    needs: Sequence[str] = ("value",),
    takes: Sequence[str] = (),
) -> Callable[[Function], Function]:
    """Register a comparison under the word by which a validation.toml calls it."""

    def register(function: Function) -> Function:
        COMPARISONS[name] = Comparison(name, function, of, axis, unit, tuple(needs), tuple(takes))
        return function

    return register


@comparison("line", LINE, "x", "m", needs=(), takes=("span",))
def compare_line(results: Results, task: Task) -> Found:
    """A line across the bed that the case names in `output.references`, of which `of` is quantity@height: the mean of
    the time mean there over the depth, or over the part that the line names, linear between cell centres."""
    assert task.line is not None
    x, line, errors = read_run(results, task.line)
    at = task.points.x
    return Found(np.interp(at, x, line), None if errors is None else np.interp(at, x, errors), (x, line))


@comparison("mean", UNITS, takes=("span", "error"))
def compare_mean(results: Results, task: Task) -> Found:
    """The time mean of a history against a number; its standard error from blocks (Flyvbjerg and Petersen),
    that of replicas from between them."""
    if task.measurement.span is None and (pooled := results.window_mean(task.measurement.of)):
        return Found(np.array(pooled[:1]), np.array(pooled[1:]))
    _, values = _read_history(results, task.measurement)
    return Found(np.array([values.mean()]), np.array([estimate_error(values)]))


@comparison("rate", UNITS, needs=("value", "span"), takes=("error", "origin"))
def compare_rate(results: Results, task: Task) -> Found:
    """The change of a history from the beginning to the end of `span`, over the time between, against a number."""
    wanted = task.measurement
    assert wanted.span is not None
    first, last = (wanted.origin + moment for moment in wanted.span)
    begin, end = _at_times(results, wanted.of, np.array([first, last]))
    return Found(np.array([(end - begin) / (last - first)]))


@comparison("curve", UNITS, "time", "s", needs=("file",), takes=("origin",))
def compare_curve(results: Results, task: Task) -> Found:
    """A history against measured values at the times of `file`, which begin at `origin`; linear between its rows."""
    origin, name = task.measurement.origin, task.measurement.of
    history = results.history(name)
    time = history["time"].values.astype(float) - origin
    shown = (time >= min(0.0, task.points.x[0])) & (time <= 1.1 * task.points.x[-1])
    values = _at_times(results, name, task.points.x + origin)
    return Found(values, None, (time[shown], history.values[shown]))


@comparison("fluctuation", UNITS, takes=("span", "error"))
def compare_fluctuation(results: Results, task: Task) -> Found:
    """The standard deviation of a history about its time mean against a number."""
    require_own_rows(results, task.measurement.of, is_of_spread=True)
    _, values = _read_history(results, task.measurement)
    return Found(np.array([values.std()]))


@comparison("frequency", dict.fromkeys(SIGNALS, "Hz"), takes=("span", "error"))
def compare_frequency(results: Results, task: Task) -> Found:
    """The frequency of the highest peak in the spectrum of a history (Welch) against a number; it is told to half the
    distance at which two peaks are told apart."""
    name = task.measurement.of
    require_every_row(results, "a spectrum")
    found = find_spectrum(name, *_read_history(results, task.measurement))
    if not found.stands_out:
        raise NotDrawableError([f"no peak of `{name}` in {results.path} stands out of red noise."])
    return Found(np.array([found.peak]), np.array([0.5 * found.resolution]))


@comparison("separation", {"species_centre_z": "1"}, takes=("span", "error"))
def compare_separation(results: Results, task: Task) -> Found:
    """How far the centre of mass of species 1 is above that of species 2, of a mixture of these two, over the bed's
    height, time means both, against a number."""
    centres = results.history("species_centre_z")
    if centres.sizes["species"] != 2:
        raise NotDrawableError([f"{results.path} has {centres.sizes['species']} species, and not two."])
    _, apart = _cut(results, task.measurement, centres[:, 0] - centres[:, 1])
    _, height = _read_history(results, task.measurement, "bed_height")
    return Found(np.array([apart.mean() / height.mean()]), np.array([estimate_error(apart) / height.mean()]))


@comparison("bubbles", SECTION, takes=("span", "error"))
def compare_bubbles(results: Results, task: Task) -> Found:
    """The mean equivalent diameter of the bubbles that pass a section (`output.probes` with a height and the voidage),
    each as it is at its widest, against a number."""
    section = cut_section(read_section(results, task.measurement.of), task.measurement.span or results.first_window)
    diameters = find_passing(section, SMALLEST * float(results.case["particles"]["diameter"])).diameters
    if len(diameters) < FEWEST:
        text = f"{len(diameters)} bubbles pass `{task.measurement.of}` in {results.path}"
        raise NotDrawableError([f"{text}, {FEWEST} are needed."])
    error = diameters.std(ddof=1) / math.sqrt(len(diameters))
    return Found(np.array([diameters.mean()]), np.array([error]))


@comparison("impact", {"rebound_angle": "deg", "tangential_restitution": "1"}, "angle of impact", "deg", ("file",))
def compare_impact(results: Results, task: Task) -> Found:
    """Tracked particles that strike the floor, each at an angle from its normal: angle of rebound, or tangential
    velocity after over before, against measured values at angles of impact."""
    if "tracked_velocity" not in results.data:
        raise NotDrawableError([f"{results.path} has no `tracked_velocity` (ask for it by output.tracked)."])
    motion = results.history("tracked_velocity").transpose("time", "tracked", "component").values
    before, after = motion[0], motion[-1]
    if not ((before[:, 2] < 0.0).all() and (after[:, 2] > 0.0).all()):
        raise NotDrawableError([f"not all tracked particles of {results.path} have met the floor and left it."])
    across = np.hypot(before[:, 0], before[:, 1])
    angle = np.degrees(np.arctan2(across, -before[:, 2]))
    along = np.divide((before[:, :2] * after[:, :2]).sum(axis=1), across, out=np.zeros_like(across), where=across > 0.0)
    values = np.degrees(np.arctan2(along, after[:, 2]))
    if task.measurement.of == "tangential_restitution":
        angle, along, across = angle[across > 0.0], along[across > 0.0], across[across > 0.0]
        values = along / across
    if not angle.size:
        raise NotDrawableError([f"no tracked particle of {results.path} strikes the floor at an angle."])
    order = np.argsort(angle)
    angle, values = angle[order], values[order]
    _require_within(results, task.points.x, angle, "angles of impact", "deg")
    return Found(np.interp(task.points.x, angle, values), None, (angle, values))


def _read_history(results: Results, measurement: Measurement, name: str = "") -> tuple[np.ndarray, np.ndarray]:
    """Times [s] and values of a history, by default that of the measurement, as `_cut` has them."""
    require_own_rows(results, name or measurement.of)
    return _cut(results, measurement, results.history(name or measurement.of))


def _cut(results: Results, measurement: Measurement, history: xr.DataArray) -> tuple[np.ndarray, np.ndarray]:
    """Times [s] and values within the span, by default the averaging window (of replicas the first's), without the
    first row."""
    span = measurement.span or results.first_window
    if span is None:
        text = f"{results.path} has no averaging window; say from when to when by `span`, or give the case [averages]."
        raise NotDrawableError([text])
    if measurement.span:
        _require_within(results, np.array(span), history["time"].values.astype(float), "rows", "s")
    history = history[1:]
    time = history["time"].values.astype(float)
    inside = (time >= span[0]) & (time <= span[1]) & np.isfinite(history.values)
    if inside.sum() < FEWEST:
        text = f"`{measurement.of}` in {results.path} has {inside.sum()} rows in {span[0]:g} to {span[1]:g} s"
        raise NotDrawableError([f"{text}, {FEWEST} are needed."])
    return time[inside], history.values[inside]


def _at_times(results: Results, name: str, moments: np.ndarray) -> np.ndarray:
    require_own_rows(results, name)
    history = results.history(name)
    time, known = history["time"].values.astype(float), np.isfinite(history.values)
    _require_within(results, moments, time[known], f"`{name}`", "s")
    return np.interp(moments, time[known], history.values[known])


def _require_within(results: Results, places: np.ndarray, known: np.ndarray, what: str, unit: str) -> None:
    """Nothing is extrapolated. Raises: NotDrawableError if `places` reach beyond those that are `known`."""
    if not known.size:
        raise NotDrawableError([f"{results.path} has no {what}."])
    slack = 1e-6 * float(np.ptp(known))
    if places.min() < known.min() - slack or places.max() > known.max() + slack:
        reach = f"{known.min():.4g} to {known.max():.4g} {unit}"
        text = f"{results.path} has {what} from {reach}, {places.min():.4g} to {places.max():.4g} {unit} are measured."
        raise NotDrawableError([text])


def find_unit(measurement: Measurement) -> str:
    """Unit of the measured values, SI; angles in degrees."""
    chosen = COMPARISONS[measurement.compare]
    if chosen.of == SECTION:
        return "m"
    if isinstance(chosen.of, str):
        return QUANTITIES[measurement.of.partition("@")[0]]
    unit = chosen.of[measurement.of]
    return unit if measurement.compare != "rate" else "s-1" if unit == "1" else f"{unit} s-1"
