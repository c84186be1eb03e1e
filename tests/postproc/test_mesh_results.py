"""Results over the cells of a mesh: sampled on the regular grid, nothing of what is outside counts."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

from fbcouple.errors import CaseError
from fbcouple.geometry.grid import Grid
from fbcouple.input_files.measured_lines import parse_reference, read_line
from fbcouple.postproc.experiment import compare_with, gather_references, read_run
from fbcouple.postproc.figures.bubbles import bubbles
from fbcouple.postproc.figures.measured_lines import draw_measured_lines
from fbcouple.postproc.report.monitors import MONITORS
from fbcouple.postproc.report.tables import tabulate_solved
from fbcouple.results.depth_means import depth_average
from fbcouple.results.reader import NotDrawableError, open_results
from fbcouple.results.writer import MeshTable, write_results

CELLS, SIZE = (4, 4, 5), (0.08, 0.08, 0.25)
CASE = """
title = "A round bed"
end_time = 20.0
gravity = 9.81
[domain]
shape = "cylinder"
size = [0.08, 0.08, 0.25]
cells = [4, 4, 5]
[gas]
density = 1.165
viscosity = 2e-5
inlet_velocity = 1.2
[averages]
start = 1.0
"""


@pytest.fixture
def run(tmp_path):
    """Twelve of sixteen places of each layer are in the mesh, whose cells are numbered from the top down."""
    grid = Grid(CELLS, SIZE)
    z, y, x = np.meshgrid(*(np.arange(n) for n in CELLS[::-1]), indexing="ij")
    inside = ~(np.isin(x, (0, 3)) & np.isin(y, (0, 3)))
    samples = np.full(inside.shape, -1)
    samples[inside] = np.arange(inside.sum())[::-1]
    places = np.stack([grid.centres(axis)[index[inside]] for axis, index in zip(range(3), (x, y, z), strict=True)])
    centres = places.T[::-1]
    upward = 2.0 + 100.0 * centres[:, 0] + 40.0 * centres[:, 2]
    means = {"pressure": 10.0 * centres[:, 2], "gas_flux": np.stack([0 * upward, 0 * upward, upward])}
    history = [{"time": 0.1, "pressure_drop": 3.0, "wall": dict.fromkeys(("dem", "cfd", "map", "drag"), 0.0)}]
    history[0]["wall"] |= dict.fromkeys(("react", "average", "record", "wait"), 0.0)
    about = {"case": CASE, "averaging_start": 1.0, "averaging_end": 20.0, "complete": 1, "bed_section": 0.005}
    volumes = np.full(len(centres), 1e-6)
    table = {"centres": centres, "volumes": volumes, "samples": samples}
    write_results(tmp_path / "results.nc", grid, means, history, about, mesh=MeshTable(**table))
    return tmp_path


def test_the_file_is_over_cells(run):
    with xr.open_dataset(run / "results.nc") as data:
        assert data["pressure"].dims == ("cell",) and data["gas_flux"].dims == ("component", "cell")
        assert np.allclose(data["pressure"], 10.0 * data["cell_z"]) and data["cell_volume"].attrs["units"] == "m3"


def test_means_stand_at_their_places(run):
    results = open_results(run)
    pressure = results.mean("pressure")
    assert pressure.dims == ("z", "y", "x") and int(np.isfinite(pressure).sum()) == 60
    assert np.allclose(pressure[:, 1, 1], 10.0 * results.data["z"])
    assert np.isnan(pressure[0, 0, 0])
    flux = results.mean("gas_flux").sel(component="z")
    assert float(flux[2, 1, 3]) == pytest.approx(2.0 + 100.0 * 0.07 + 40.0 * 0.125)


def test_depth_means_are_those_of_the_inside(run):
    flux = depth_average(open_results(run).mean("gas_flux").sel(component="z"))
    x, z = np.meshgrid(flux["x"], flux["z"])
    assert np.allclose(flux.transpose("z", "x"), 2.0 + 100.0 * x + 40.0 * z, rtol=1e-12)


def test_a_hole_inside_is_told(run, tmp_path):
    with xr.open_dataset(run / "results.nc") as stored:
        data = stored.load()
    data["pressure"][7] = np.nan
    data.to_netcdf(run / "results.nc")
    with pytest.raises(NotDrawableError, match="1 of"):
        open_results(run).mean("pressure")


def test_flux_over_the_inlets_velocity_is_said_only_where_the_floor_is_the_inlet(run):
    assert MONITORS["gas_flux"](open_results(run)).value > 1.0
    with xr.open_dataset(run / "results.nc") as opened:
        changed = opened.load()
    changed.attrs["case"] = changed.attrs["case"].replace('"cylinder"', '"file"')
    changed.to_netcdf(run / "results.nc")
    with pytest.raises(NotDrawableError, match="area at every height"):
        MONITORS["gas_flux"](open_results(run))


def test_a_measured_line_is_compared_with_what_is_inside(run, tmp_path):
    """The pressure is 10 z, and columns beyond the mesh at that height do not count."""
    (tmp_path / "line.csv").write_text("x,value\n0.001,1.25\n0.04,1.35\n0.079,1.25\n")
    results = open_results(run)
    (measured,) = gather_references([results], [f"pressure@0.125={tmp_path / 'line.csv'}"])
    found = compare_with(results, measured)
    assert found.points == 3 and found.largest == pytest.approx(0.1) and found.bias == pytest.approx(-0.1 / 3)
    outside = results.data["inside"].copy()
    outside[:, :, 0] = False
    data = results.data.assign_coords(inside=outside)
    data["pressure"] = data["pressure"].where(outside)
    assert compare_with(replace(results, data=data), measured).largest == pytest.approx(0.1)


def test_a_part_of_the_depth_has_the_columns_that_are_inside_there(run, tmp_path):
    """The front quarter of the round bed is two columns wide."""
    (tmp_path / "line.csv").write_text("x,value\n0.03,1.25\n0.05,1.25\n")
    results = open_results(run)
    (measured,) = gather_references([results], [f"pressure@0.125,0:0.02={tmp_path / 'line.csv'}"])
    assert compare_with(results, measured).largest == pytest.approx(0.0, abs=1e-9)
    x, line, _ = read_run(results, measured.reference)
    assert x == pytest.approx([0.03, 0.05]) and line == pytest.approx([1.25, 1.25])


def test_a_line_over_the_radius_is_compared_with_means_over_rings(run, tmp_path):
    """Upward 2 + 100 x + 40 z: means over a ring about x = 0.04 do not depend on its radius."""
    (tmp_path / "ring.csv").write_text("r [mm],value\n2,11.1\n30,11.3\n")
    (measured,) = gather_references([open_results(run)], [f"gas_flux@0.125,r={tmp_path / 'ring.csv'}"])
    found = compare_with(open_results(run), measured)
    assert found.points == 2 and found.bias == pytest.approx(-0.2) and found.largest == pytest.approx(0.3)
    axes = draw_measured_lines([open_results(run)], [measured]).axes[0]
    assert axes.get_xlabel() == "r [mm]" and axes.get_title(loc="left") == "z = 125 mm, over the radius"


def test_a_line_beyond_the_mesh_is_refused_in_its_coordinates(run, tmp_path):
    (tmp_path / "line.csv").write_text("x,value\n0.07,1.25\n0.09,1.25\n")
    with pytest.raises(CaseError, match=r"0 to 0\.08 m is allowed"):
        gather_references([open_results(run)], [f"pressure@0.125={tmp_path / 'line.csv'}"])
    with pytest.raises(CaseError, match=r"-0.05 to 0.03 m is allowed .*as the mesh has it"):
        read_line(parse_reference("pressure@0.1=line.csv"), tmp_path / "line.csv", SIZE, (-0.05, 0.0, 0.0))
    with pytest.raises(CaseError, match=r"the mesh goes from -0.2 to 0.05 m"):
        read_line(parse_reference("pressure@0.1=line.csv"), tmp_path / "line.csv", SIZE, (0.0, 0.0, -0.2))
    with pytest.raises(CaseError, match=r"is at 0\.1 m, the mesh goes from 1 to 1\.25 m; give m, as the mesh has them"):
        read_line(parse_reference("pressure@0.1=line.csv"), tmp_path / "line.csv", SIZE, (0.0, 0.0, 1.0))
    (tmp_path / "line.csv").write_text("x,value\n0.07,1.25\n")
    below = parse_reference("pressure@-0.1=line.csv")
    assert read_line(below, tmp_path / "line.csv", SIZE, (0.0, 0.0, -0.2)).value.tolist() == [1.25]
    with pytest.raises(CaseError, match=r"is at -0\.1 m, the box is 0\.25 m high"):
        read_line(below, tmp_path / "line.csv", SIZE)


def test_a_report_tells_the_cells_of_the_mesh_and_not_of_the_grid(run):
    solved = {row["what"]: row["value"] for row in tabulate_solved(open_results(run))}
    assert solved["cells of the mesh"] == 60 and "cylinder, width x depth x height [m]" in solved


def test_a_run_of_gas_alone_does_not_ask_for_what_it_cannot_have(run):
    with pytest.raises(NotDrawableError, match="has no `voidage_snapshots`: it is of gas alone"):
        bubbles(open_results(run))
