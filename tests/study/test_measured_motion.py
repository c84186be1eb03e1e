"""How a bed moves against the finest member: signals, bubbles and mixing that are known beforehand."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from mpi4py import MPI

from fbcouple.case.load import load_case
from fbcouple.coupling.box.cells import BoxCells
from fbcouple.errors import CaseError
from fbcouple.geometry.grid import Grid
from fbcouple.results.reader import Results
from fbcouple.simulation.tasks.frames import Frames
from fbcouple.study.measures import Finished, find_error

CASE = load_case("mueller/0.9")
WINDOW = {"averaging_start": 1.0, "averaging_end": 9.0}
TIME = 0.01 * np.arange(901)


def make_signal(frequency: float, amplitude: float, noise: float = 0.0) -> Finished:
    """A pressure drop that goes up and down for 9 s, its first second (ten times as much) outside of the window."""
    values = amplitude * np.sin(2.0 * np.pi * frequency * TIME) + noise * np.random.default_rng(3).standard_normal(901)
    values[TIME < 0.999] *= 10.0
    data = xr.Dataset({"pressure_drop": ("time", 600.0 + values)}, coords={"time": TIME})
    return Finished(Results(Path("none"), data.assign_attrs(WINDOW), {}), CASE)


def test_the_deviation_of_a_history():
    found = find_error("fluctuation:pressure_drop", make_signal(2.5, 30.0), make_signal(2.5, 40.0))
    assert found.value == pytest.approx(30.0 / np.sqrt(2.0), rel=2e-3)
    assert found.error == pytest.approx(0.25, abs=1e-9) and found.unit == "Pa"


def test_the_error_of_a_deviation_is_that_of_noise():
    """A deviation s of n independent values errs by s/sqrt(2 n), from ten blocks told within a third."""
    found = find_error("fluctuation:pressure_drop", make_signal(1.0, 0.0, 5.0), make_signal(1.0, 0.0, 5.0))
    assert found.error == 0.0 and found.stderr == pytest.approx(np.sqrt(2.0) * 0.025, rel=0.35)


def test_the_frequency_of_a_history():
    found = find_error("frequency:pressure_drop", make_signal(2.0, 30.0, 5.0), make_signal(2.5, 30.0, 5.0))
    assert found.value == pytest.approx(2.0, abs=0.05) and found.error == pytest.approx(0.2, abs=0.03)
    assert found.stderr == pytest.approx(0.5 * 0.25 * np.sqrt(2.0) / 2.5, rel=0.05)


SHOTS = np.arange(0.0, 4.0, 0.02)
WIDTH, HEIGHT = 0.08, 0.25


def make_bubbles(diameters) -> Finished:
    """A bed of 60 mm for 4 s with round voids of `diameters` side by side in every other snapshot."""
    x, z = (np.arange(80) + 0.5) * WIDTH / 80, (np.arange(250) + 0.5) * HEIGHT / 250
    field = np.where(z[:, None] < 0.06, 0.45, 1.0) * np.ones(80)
    holed = field.copy()
    for n, diameter in enumerate(diameters):
        centre = WIDTH * (n + 0.5) / len(diameters)
        holed[np.hypot(x[None] - centre, z[:, None] - 0.03) < 0.5 * diameter] = 0.9
    shots = np.array([holed if n % 2 else field for n in range(len(SHOTS))], np.float32)
    steady = 0.06 + 1e-4 * np.random.default_rng(1).standard_normal(401)
    fields = {"voidage_snapshots": (("snapshot_time", "z", "x"), shots), "bed_height": ("time", steady)}
    axes = {"snapshot_time": SHOTS, "time": 0.01 * np.arange(401), "x": x, "y": [0.005], "z": z}
    box = {"size": [WIDTH, 0.01, HEIGHT], "shape": "box"}
    case = {"gravity": 9.81, "particles": {"diameter": 1e-3}, "domain": box, "averages": {}}
    data = xr.Dataset(fields, axes).assign_attrs({"domain_size": box["size"], "domain_corner": [0.0, 0.0, 0.0]})
    return Finished(Results(Path("none"), data, case), CASE)


def test_bubbles_by_number_and_size():
    few, many = make_bubbles([0.02]), make_bubbles([0.016, 0.01])
    number = find_error("bubbles:number", few, many)
    assert number.value == pytest.approx(0.5, rel=0.01) and number.expected == pytest.approx(1.0, rel=0.01)
    assert number.error == pytest.approx(0.5) and number.stderr is not None and number.stderr < 0.05
    size = find_error("bubbles:diameter", few, many)
    assert size.value == pytest.approx(0.02, rel=0.02) and size.expected == pytest.approx(0.013, rel=0.03)
    with pytest.raises(CaseError, match="no bubble"):
        find_error("bubbles:number", make_bubbles([]), many)


def make_frames(folder: Path, mixed_at: int, side: int, size: float) -> Finished:
    """Five frames of a cube of spheres, stirred in frame `mixed_at` for the first time."""
    folder.mkdir()
    places = np.stack(np.meshgrid(*[np.arange(side)] * 3, indexing="ij"), axis=-1).reshape(-1, 3) * size + 0.5 * size
    cells = np.stack(np.meshgrid(*[np.arange(2)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    frames = Frames(MPI.COMM_SELF, BoxCells(Grid((2, 2, 2), (side * size,) * 3), cells), folder / "frames", every=0.1)
    stirred = np.random.default_rng(2).permutation(len(places))
    for n in range(5):
        where = places[stirred if n >= mixed_at else slice(None)]
        found = {"position": where, "velocity": 0.0 * where, "diameter": np.full(len(where), size)}
        frames.write(0.1 * n, np.arange(1, len(where) + 1), found, {})
    return Finished(Results(folder / "results.nc", xr.Dataset(), {}), CASE)


def test_mixing_of_parcels_is_told_by_samples_of_the_same_size(tmp_path):
    fine, coarse = (
        make_frames(tmp_path / name, *args) for name, args in (("fine", (2, 30, 1e-3)), ("coarse", (3, 15, 2e-3)))
    )
    found = find_error("mixing:right", coarse, fine)
    assert (found.value, found.expected) == (pytest.approx(0.3), pytest.approx(0.2))
    assert math.isnan(found.stderr) and found.unit == "s"
    with pytest.raises(CaseError, match=r"not mixed to 0\.9: it has come"):
        find_error("mixing:upper", make_frames(tmp_path / "never", 9, 30, 1e-3), fine)
