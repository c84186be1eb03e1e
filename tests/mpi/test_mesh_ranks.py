"""A cylinder of tetrahedra on 1, 2 and 4 ranks, over 20 coupling steps from the same start: the same fields."""

import numpy as np
import pytest
import pyvista
import xarray as xr

from fbcouple.case.schema.sections import Case
from fbcouple.decks.render import set_up
from fbcouple.launcher.launch import launch
from fbcouple.postproc.views.vtk_files import export

FIELDS = ["solids_fraction", "solids_flux", "voidage", "gas_velocity", "gas_flux", "pressure"]
CASE = {
    "title": "cylinder",
    "end_time": 1.4e-3,
    "domain": {"shape": "cylinder", "size": [0.016, 0.016, 0.032], "cells": [6, 6, 12]},
    "gas": {"density": 1.165, "viscosity": 2e-5, "inlet_velocity": 1.5, "pressure_tolerance": 1e-13},
    "particles": {"diameter": 1e-3, "density": 2500.0, "count": 1200},
    "contact": {"restitution": 0.97, "wall_restitution": 0.97, "friction": 0.1, "wall_friction": 0.1},
    "start": {},
    "exchange": {"filter_passes": 1},
    "averages": {"start": 0.0, "every": 1e-5, "blocks": 2},
    "output": {
        "record_every": 1e-4,
        "particles_every": 7e-4,
        "snapshots_every": 7e-4,
        "probes": [
            {
                "name": "axis",
                "line": [[0.008, 0.008, 0.0], [0.008, 0.008, 0.032]],
                "count": 17,
                "every": 1e-5,
                "quantities": ["pressure", "gas_velocity", "solids_fraction", "solids_flux"],
            }
        ],
    },
}
PROBED = [f"probe_axis_{quantity}" for quantity in CASE["output"]["probes"][0]["quantities"]]


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """Ranks -> run folder."""
    folders = {}
    for ranks in (1, 2, 4):
        folders[ranks] = tmp_path_factory.mktemp("ranks") / f"n{ranks}"
        set_up(Case.model_validate(CASE), folders[ranks])
        launch(folders[ranks], ranks, lambda row: None)
    return folders


@pytest.fixture(scope="module")
def found(runs):
    """Ranks -> results."""
    results = {}
    for ranks, run in runs.items():
        with xr.open_dataset(run / "results.nc") as opened:
            results[ranks] = opened.load()
    return results


@pytest.mark.parametrize("ranks", [2, 4])
@pytest.mark.parametrize("name", FIELDS + PROBED)
def test_fields_do_not_depend_on_ranks(found, ranks, name):
    one, many = found[1][name].values, found[ranks][name].values
    scale = np.nanmax(np.abs(one))
    difference = np.nanmax(np.abs(one - many)) / scale
    print(f"{name} on {ranks} ranks: {difference:.2e} of {scale:.3g}")
    assert scale > 0
    assert difference < 1e-9


@pytest.mark.parametrize("ranks", [2, 4])
def test_frames_and_snapshots_do_not_depend_on_ranks(runs, found, ranks):
    one, many = (found[n]["voidage_snapshots"].values for n in (1, ranks))
    assert one.shape == (3, 12, 6) and np.isfinite(one).all() and one.min() < 0.7
    assert np.abs(one - many).max() < 1e-6, "float32"
    frames = []
    for n in (1, ranks):
        with xr.open_dataset(runs[n] / "frames/frame-000002.nc") as opened:
            frames.append(opened.load())
    for name in ("voidage", "gas_velocity", "position"):
        first, other = (frame[name].values for frame in frames)
        assert (np.isnan(first) == np.isnan(other)).all() and np.nanmax(np.abs(first - other)) < 1e-6
    assert np.isnan(frames[0]["voidage"].values).mean() == pytest.approx(4 / 36)


def test_probes_on_the_axis_have_the_means_of_cells_that_meet_there(found):
    results = found[1]
    probed = results["probe_axis_solids_fraction"].mean("probe_axis_time").values
    for height, value in zip(results["probe_axis_z"].values, probed, strict=True):
        near = np.abs(results["cell_z"] - height) < 0.032 / 12
        assert np.abs(results["solids_fraction"].values[near] - value).min() < 1e-12
    assert probed[1] > 0.2 and probed[-1] == 0.0


@pytest.mark.parametrize("ranks", [1, 2, 4])
def test_cells_of_the_results(found, ranks):
    results = found[ranks]
    assert results["solids_fraction"].dims == ("cell",) and results["gas_velocity"].dims == ("component", "cell")
    assert results.sizes["cell"] == 6 * 9 * 12 * 3
    area = 9 * 0.008**2 * np.sin(2 * np.pi / 18)
    assert float(results["cell_volume"].sum()) == pytest.approx(area * 0.032, rel=1e-12)
    volume = float((results["solids_fraction"] * results["cell_volume"]).sum())
    assert volume == pytest.approx(1200 * np.pi / 6 * 1e-9, rel=1e-12)
    sampled = results["sampled_cell"].values
    inside = sampled >= 0
    assert inside.mean() == 32 / 36  # the corners of six by six places are outside
    place = np.broadcast_to(results["z"].values[:, None, None], inside.shape)[inside]
    assert np.abs(results["cell_z"].values[sampled[inside]] - place).max() < 0.032 / 12


@pytest.mark.parametrize("ranks", [1, 4])
def test_the_mesh_stands_in_the_results_and_in_the_files_for_paraview(runs, found, ranks):
    means = next(path for path in export(runs[ranks]) if path.name == "means.vtu")
    grid, results = pyvista.read(means), found[ranks]
    assert means.name == "means.vtu" and grid.n_cells == results.sizes["cell"]
    assert set(grid.celltypes) == {pyvista.CellType.TETRA}
    assert grid.compute_cell_sizes()["Volume"] == pytest.approx(results["cell_volume"].values, rel=1e-9)
    centres = np.column_stack([results[f"cell_{axis}"] for axis in "xyz"])
    assert grid.cell_centers().points == pytest.approx(centres, abs=1e-9)
    assert (grid["solids_fraction"] == results["solids_fraction"].values).all()
    assert (grid["gas_velocity"] == results["gas_velocity"].values.T).all()


@pytest.mark.parametrize("ranks", [1, 2, 4])
def test_conservation(found, ranks):
    results = found[ranks]
    assert int(results.attrs["complete"])
    assert results["momentum_error"].max() < 1e-10
    assert np.abs(results["solids_volume"] / (1200 * np.pi / 6 * 1e-9) - 1.0).max() < 1e-12
    assert (results["particles"] == 1200).all()
    assert (results["substeps"].values == found[1]["substeps"].values).all()


def test_cells_that_are_no_tetrahedra_are_polyhedra_of_the_same_volume(tmp_path):
    domain = CASE["domain"] | {"elements": "prisms"}
    set_up(Case.model_validate(CASE | {"domain": domain, "end_time": 1e-4}), tmp_path / "run")
    launch(tmp_path / "run", 1, lambda row: None)
    means = next(path for path in export(tmp_path / "run") if path.name == "means.vtu")
    grid = pyvista.read(means)
    with xr.open_dataset(tmp_path / "run/results.nc") as results:
        volumes = results["cell_volume"].values
    assert set(grid.celltypes) == {pyvista.CellType.POLYHEDRON}
    assert grid.compute_cell_sizes()["Volume"] == pytest.approx(volumes, rel=1e-9)
