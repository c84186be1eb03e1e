"""Measures against the measured lines that a case names."""

from __future__ import annotations

import numpy as np

from fbcouple.errors import CaseError
from fbcouple.input_files.companion_files import find_companion
from fbcouple.input_files.measured_lines import QUANTITIES, parse_reference, read_line
from fbcouple.postproc.deviation import find_deviation
from fbcouple.postproc.experiment import read_run
from fbcouple.study.measures.registry import Error, Finished, measure


@measure("experiment", arguments=tuple(QUANTITIES), needs=("[averages]", "output.references"))
def compare_experiment(run: Finished, argument: str, reference: Finished | None) -> Error:
    """Root mean square distance of the time means from the measured points of a quantity, over the points' range."""
    means, errors, wanted = np.concatenate(_read_lines(run, "experiment", argument), axis=1)
    away, scale = find_deviation(means, wanted, errors), float(np.ptp(wanted))
    found = away.rms / scale, away.rms_error / scale
    return Error(float(means.mean()), float(wanted.mean()), QUANTITIES[argument], *found)


@measure("amplitude", arguments=tuple(QUANTITIES), needs=("[averages]", "output.references"))
def compare_amplitude(run: Finished, argument: str, reference: Finished | None) -> Error:
    """How far the time means of a quantity vary along its measured lines, over what the measured points do: largest
    less smallest value, the mean over the lines; its `error` is the distance from 1, root mean square over them."""
    lines = [find_deviation(means, wanted, errors) for means, errors, wanted in _read_lines(run, "amplitude", argument)]
    found = np.array([line.amplitude for line in lines])
    chance = float(np.mean([line.amplitude_error for line in lines]))
    return Error(float(found.mean()), 1.0, "1", float(np.sqrt(np.mean((found - 1.0) ** 2))), chance)


def _read_lines(run: Finished, measure: str, quantity: str) -> list[np.ndarray]:
    """The lines of `quantity` that the case names, each as rows of time means at the measured points, their standard
    errors, and what was measured, (3, n)."""
    named = [parse_reference(text) for text in run.case.output.references]
    rows = []
    for line in (one for one in named if one.quantity == quantity):
        file = find_companion(run.results.path.parent, line.file, ".csv")
        points = read_line(line, file, run.results.size, run.results.corner)
        x, mean, error = read_run(run.results, line)
        spread = np.full(len(x), np.nan) if error is None else error
        rows.append(np.stack([np.interp(points.x, x, mean), np.interp(points.x, x, spread), points.value]))
    if not rows:
        raise CaseError([f"{measure}:{quantity}: the case names no such line in output.references."])
    return rows
