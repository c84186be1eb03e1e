"""A small results.nc with analytic fields, written as a run writes it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

SIZE = (0.08, 0.015, 0.25)
CELLS = (8, 3, 25)
FLUX_X, FLUX_0, FLUX_Z, FLUX_Y = 100.0, 2.0, 40.0, 300.0  # kg m-2 s-1, and per m

CASE = """
title = "A $synthetic$ bed"
end_time = 20.0
gravity = 9.81
[domain]
size = [0.08, 0.015, 0.25]
cells = [8, 3, 25]
[gas]
density = 1.165
viscosity = 2e-5
inlet_velocity = 1.2
max_courant = 0.2
[particles]
diameter = 1e-3
density = 2500.0
mass = 0.075
[averages]
start = 1.0
"""


def synthetic(cells: tuple[int, int, int]) -> xr.Dataset:
    """Solids flux linear in x, y and z; solids fraction 0.5 below z = 0.07 m; two records of the history."""
    x, y, z = ((np.arange(n) + 0.5) * length / n for n, length in zip(cells, SIZE, strict=True))
    above, depth, across = np.meshgrid(z, y, x, indexing="ij")
    upward = FLUX_0 + FLUX_X * across + FLUX_Z * above + FLUX_Y * (depth - SIZE[1] / 2)
    flux = np.stack([np.full_like(upward, 3.0), np.zeros_like(upward), upward])
    mean, vector = ("z", "y", "x"), ("component", "z", "y", "x")
    time = np.array([0.01, 0.02])
    return xr.Dataset(
        {
            "solids_fraction": (mean, np.where(above < 0.07, 0.5, 0.0)),
            "solids_fraction_stderr": (mean, np.full_like(above, 0.01)),
            "solids_flux": (vector, flux),
            "solids_flux_stderr": (vector, np.stack([0.0 * above, 0.0 * above, 1.0 + 10.0 * above])),
            "bed_height": ("time", [0.05, 0.06]),
            "pressure_drop": ("time", [600.0, 620.0]),
            "substeps": ("time", np.array([7, 8])),
            "max_courant": ("time", [0.1, 0.2]),
            "wall_seconds": (("time", "stage"), [[1.0, 0.5, 0.25], [2.0, 4.0, 0.25]]),
        },
        coords={
            "x": x,
            "y": y,
            "z": z,
            "component": ["x", "y", "z"],
            "time": ("time", time, {"units": "s"}),
            "stage": ["dem", "cfd", "map"],
        },
        attrs={"case": CASE, "averaging_start": 1.0, "averaging_end": 20.0, "core_seconds": 16.0, "complete": 1},
    )


@pytest.fixture
def dataset() -> xr.Dataset:
    """The synthetic results, to be changed by a test before they are written."""
    return synthetic(CELLS)


@pytest.fixture
def fine_dataset() -> xr.Dataset:
    """The same fields on five times as many cells along x and z."""
    return synthetic((40, 3, 125))


@pytest.fixture
def write(tmp_path: Path) -> Callable[[xr.Dataset], Path]:
    """Write a dataset as RUN/results.nc; returns RUN."""

    def write_results(data: xr.Dataset) -> Path:
        data.to_netcdf(tmp_path / "results.nc")
        return tmp_path

    return write_results


@pytest.fixture
def run(dataset: xr.Dataset, write: Callable[[xr.Dataset], Path]) -> Path:
    """A run folder with the synthetic results."""
    return write(dataset)
