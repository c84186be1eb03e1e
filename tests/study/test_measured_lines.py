"""Distance and amplitude of measured lines: Mueller's bed with a velocity that is linear across it, as known."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

from fbcouple.case.load import load_case
from fbcouple.errors import CaseError
from fbcouple.input_files.measured_lines import parse_reference, read_line
from fbcouple.results.reader import Results
from fbcouple.study.measures import Finished, find_error
from fbcouple.validate.source import read_bed

CASE = load_case("mueller/0.9")
FOLDER = read_bed("mueller/0.9").folder
SIZE = (0.044, 0.01, 0.12)
SLOPE, ERROR = 5.0, 0.01


def make_run() -> Finished:
    """Velocity SLOPE x + 0.3 in the half of the depth with solids of 0.4, SLOPE x - 0.1 in that with 0.1."""
    cells = (220, 2, 60)
    axes = {name: (np.arange(n) + 0.5) * length / n for name, n, length in zip("xyz", cells, SIZE, strict=True)}
    _, y, x = np.meshgrid(axes["z"], axes["y"], axes["x"], indexing="ij")
    velocity = np.zeros((3, *x.shape))
    velocity[2] = SLOPE * x + np.where(y < 0.005, 0.3, -0.1)
    vector, scalar = ("component", "z", "y", "x"), ("z", "y", "x")
    fields = {
        "solids_fraction": (scalar, np.where(y < 0.005, 0.4, 0.1)),
        "solids_velocity": (vector, velocity),
        "solids_velocity_stderr": (vector, np.full_like(velocity, ERROR)),
    }
    data = xr.Dataset(fields, coords=axes | {"component": list("xyz")})
    return Finished(Results(FOLDER / "results.nc", data, {"domain": {"size": SIZE}}), CASE)


def read_measured(run: Finished):
    references = [parse_reference(text) for text in CASE.output.references if text.startswith("solids_velocity")]
    return [read_line(one, FOLDER / one.file, run.results.size, run.results.corner) for one in references]


def test_lines_of_particles_are_weighted_with_the_solids():
    """0.4 parts of +0.3 and 0.1 of -0.1 are +0.22; a plain mean of the depth would be +0.1."""
    run = make_run()
    points = read_measured(run)
    away = np.concatenate([SLOPE * one.x + 0.22 - one.value for one in points])
    scale = np.ptp(np.concatenate([one.value for one in points]))
    found = find_error("experiment:solids_velocity", run, None)
    assert found.error == pytest.approx(np.sqrt((away**2).mean()) / scale, rel=1e-3)
    assert found.stderr == pytest.approx(ERROR * np.abs(away).mean() / np.sqrt((away**2).mean()) / scale, rel=1e-3)


def test_amplitude_is_the_mean_of_the_lines():
    run = make_run()
    lines = [SLOPE * np.ptp(one.x) / np.ptp(one.value) for one in read_measured(run)]
    found = find_error("amplitude:solids_velocity", run, None)
    assert found.value == pytest.approx(np.mean(lines), rel=1e-3) and found.expected == 1.0
    assert found.error == pytest.approx(np.sqrt(np.mean((np.array(lines) - 1.0) ** 2)), rel=1e-3)
    assert found.stderr == pytest.approx(np.mean([2 * ERROR / np.ptp(one.value) for one in read_measured(run)]))


def test_a_quantity_without_a_line_is_told():
    with pytest.raises(CaseError, match="amplitude:agitation: the case names no such line"):
        find_error("amplitude:agitation", make_run(), None)
