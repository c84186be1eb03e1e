"""Frames: what a file of one moment holds, and what is left of them where a run goes on from a checkpoint."""

import numpy as np
import pytest
import xarray as xr
from mpi4py import MPI

from fbcouple.coupling.box.cells import BoxCells
from fbcouple.geometry.grid import Grid
from fbcouple.results.frames import read_frame
from fbcouple.simulation.tasks.frames import FIELDS, PARTICLES, Frames

GRID = Grid((4, 3, 5), (0.4, 0.3, 0.5))


@pytest.fixture
def frames(tmp_path):
    cells = np.stack(np.meshgrid(*(np.arange(n) for n in GRID.cells), indexing="ij"), axis=-1).reshape(-1, 3)
    owned = np.random.default_rng(5).permutation(cells)
    return Frames(MPI.COMM_SELF, BoxCells(GRID, owned), tmp_path / "frames", every=0.1)


def write(frames, time):
    """Particle n is at x = n/100 with the velocity (0, 0, n); the fields say which cell is which."""
    numbers = np.array([3, 1, 2], dtype=np.int32)
    nothing = np.zeros(3)
    particles = {
        "position": np.column_stack([numbers / 100.0, nothing, nothing]),
        "velocity": np.column_stack([nothing, nothing, numbers]),
        "diameter": 1e-3 * numbers,
    }
    i, j, k = frames._cells.owned.T
    fields = {"voidage": (i + 10.0 * j + 100.0 * k)[:, None], "gas_velocity": np.column_stack([i, j, k]) * 1.0}
    frames.write(time, numbers, particles, fields)


def test_particles_are_in_the_order_of_their_numbers_and_cells_in_their_places(frames, tmp_path):
    write(frames, 0.25)
    with xr.open_dataset(tmp_path / "frames/frame-000000.nc") as frame:
        assert float(frame["time"]) == 0.25 and frame["time"].attrs["units"] == "s"
        assert frame["position"].dims == frame["velocity"].dims == ("particle", "component")
        assert frame["position"].values[:, 0] == pytest.approx([0.01, 0.02, 0.03])
        assert frame["velocity"].values[:, 2].tolist() == [1.0, 2.0, 3.0]
        assert frame["diameter"].values == pytest.approx([1e-3, 2e-3, 3e-3])
        assert frame["voidage"].dims == ("z", "y", "x") and frame["gas_velocity"].dims == ("component", "z", "y", "x")
        assert frame["voidage"].values[4, 2, 3] == 423.0 and frame["gas_velocity"].values[:, 4, 2, 3].tolist() == [
            3,
            2,
            4,
        ]
        assert frame["x"].values == pytest.approx([0.05, 0.15, 0.25, 0.35])
        for name in (*PARTICLES, *FIELDS):
            assert frame[name].attrs["units"] and frame[name].attrs["long_name"] and frame[name].dtype == np.float32


def test_parcels_have_the_size_of_their_grains_and_are_drawn_as_they_are(frames, tmp_path):
    columns = {name: np.zeros((2, 3)) for name in ("position", "velocity")}
    frames.write(
        1.0, np.array([1, 2]), columns | {"diameter": np.full(2, 1e-3), "parcel_diameter": np.full(2, 2e-3)}, {}
    )
    path = tmp_path / "frames/frame-000000.nc"
    with xr.open_dataset(path) as frame:
        assert frame["diameter"].values == pytest.approx(1e-3) and frame["parcel_diameter"].attrs["units"] == "m"
    assert read_frame(path).diameters == pytest.approx(2e-3)


def test_particles_that_come_and_go_have_their_numbers(frames, tmp_path):
    columns = {"entry_time": np.array([0.5, 0.0]), "feed": np.array([2.0, 0.0])}
    frames.write(1.0, np.array([2**40 + 1, 7]), columns | {"diameter": np.full(2, 1e-3)}, {})
    with xr.open_dataset(tmp_path / "frames/frame-000000.nc") as frame:
        assert frame["number"].values.tolist() == [7, 2**40 + 1]
        assert frame["entry_time"].values.tolist() == [0.0, 0.5] and frame["feed"].values.tolist() == [0.0, 2.0]


def test_a_run_that_goes_on_has_the_frames_up_to_its_checkpoint(frames, tmp_path):
    for time in (0.0, 0.1, 0.2):
        write(frames, time)
    (tmp_path / "frames/frame-000003.nc.part").write_bytes(b"cut short")
    frames.cut(1)
    assert [path.name for path in (tmp_path / "frames").iterdir()] == ["frame-000000.nc"]
    write(frames, 0.15)
    names = sorted(path.name for path in (tmp_path / "frames").iterdir())
    assert names == ["frame-000000.nc", "frame-000001.nc"]
    with xr.open_dataset(tmp_path / "frames/frame-000001.nc") as frame:
        assert float(frame["time"]) == 0.15
