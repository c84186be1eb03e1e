"""Distance of time means from the finest member's: fields whose distance is known, on one mesh and on two."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from fbcouple.case.load import load_case
from fbcouple.results.reader import Results
from fbcouple.study.measures import Finished, find_error

CASE = load_case("mueller/0.9")


def make(cells: tuple[int, int, int], field, error: float) -> Finished:
    """A finished run whose time-mean solids fraction is `field` of x and z in a unit box, with one standard error."""
    axes = {name: (np.arange(n) + 0.5) / n for name, n in zip("xyz", cells, strict=True)}
    z, _, x = np.meshgrid(axes["z"], axes["y"], axes["x"], indexing="ij")
    fields = {"solids_fraction": field(x, z), "solids_fraction_stderr": np.full(x.shape, error)}
    data = xr.Dataset({name: (("z", "y", "x"), values) for name, values in fields.items()}, coords=axes)
    return Finished(Results(Path("none"), data, {}), CASE)


def test_a_shift_is_the_distance_and_the_errors_of_both_its_bar():
    one = make((8, 2, 10), lambda x, z: x + 0.03, 0.04)
    finest = make((8, 2, 10), lambda x, z: x, 0.03)
    found = find_error("means:solids_fraction", one, finest)
    scale = 7 / 8
    assert found.error == pytest.approx(0.03 / scale) and found.stderr == pytest.approx(0.05 / scale)
    assert found.value - found.expected == pytest.approx(0.03)


def test_another_mesh_is_read_at_the_finest_s_cells_and_not_beyond_its_own():
    finest = make((16, 2, 40), lambda x, z: 2.0 * x + z, 0.0)
    assert find_error("means:solids_fraction", make((6, 1, 10), lambda x, z: 2.0 * x + z, 0.0), finest).error < 1e-12
    away = find_error("means:solids_fraction", make((6, 1, 10), lambda x, z: 2.0 * x + z + 0.1, 0.0), finest)
    assert away.error == pytest.approx(0.1 / (2 * 15 / 16 + 39 / 40))
