"""Files for ParaView: every mean and every frame stands where it is in results.nc and the frames."""

from __future__ import annotations

from importlib import import_module

import numpy as np
import pytest
import pyvista
from click.testing import CliRunner

from fbcouple.cli.main import cli
from fbcouple.postproc.views.frames import list_frames, read_frame
from fbcouple.postproc.views.vtk_files import export
from fbcouple.results.reader import NotDrawableError, open_results
from tests.postproc.conftest import SIZE
from tests.postproc.frames_of_bed import write_frames
from tests.postproc.whole_run import write_whole


@pytest.fixture
def run(tmp_path):
    run = write_whole(tmp_path / "run")
    write_frames(run, SIZE, count=2)
    return run


def test_means_stand_in_their_cells(run):
    export(run)
    data, grid = open_results(run).data, pyvista.read(run / "vtk/means.vti")
    assert grid.bounds == pytest.approx((0.0, SIZE[0], 0.0, SIZE[1], 0.0, SIZE[2]), abs=1e-9)
    x, y, z = (data[axis].values[place] for axis, place in zip("xyz", (5, 1, 7), strict=True))
    cell = grid.find_containing_cell((x, y, z))
    for name in ("solids_fraction", "solids_flux", "gas_velocity"):
        found, expected = grid.cell_data[name][cell], data[name].sel(x=x, y=y, z=z).values
        assert found == pytest.approx(expected, rel=1e-12), name


def test_frames_are_a_collection_over_time(run):
    files = export(run)
    assert [file.name for file in files] == ["means.vti", "particles.pvd", "gas.pvd"]
    reader = pyvista.get_reader(run / "vtk/particles.pvd")
    frames = [read_frame(path) for path in list_frames(open_results(run))]
    assert reader.time_values == [frame.time for frame in frames]
    reader.set_active_time_value(reader.time_values[-1])
    cloud = reader.read()[0]
    assert np.allclose(cloud.points, frames[-1].positions) and np.allclose(cloud["velocity"], frames[-1].velocities)
    gas = pyvista.read(run / "vtk/gas-000001.vti")
    assert gas["gas_velocity"].shape == (gas.n_cells, 3) and np.all(gas["gas_velocity"][:, 2] == 2.0)
    assert np.allclose(gas["voidage"].reshape(frames[-1].voidage.shape), frames[-1].voidage)


def test_diameters_of_parcels_and_of_their_grains_are_told_apart(tmp_path):
    """As in the files of the frames: `diameter` is the grain's."""
    run = write_whole(tmp_path / "run")
    write_frames(run, SIZE, count=1, grain=0.5e-3)
    export(run)
    cloud = pyvista.read(run / "vtk/particles-000000.vtp")
    assert np.allclose(cloud["diameter"], 0.5e-3) and np.allclose(cloud["parcel_diameter"], 1e-3)
    (frame,) = map(read_frame, list_frames(open_results(run)))
    assert np.allclose(frame.diameters, 1e-3) and np.allclose(frame.grain_diameters, 0.5e-3)


def test_a_frame_without_particles_is_a_cloud_of_no_points(tmp_path):
    run = write_whole(tmp_path / "run")
    write_frames(run, SIZE, count=1, heat=True, drained=True)
    export(run)
    assert pyvista.read(run / "vtk/particles-000000.vtp").n_points == 8000
    assert pyvista.read(run / "vtk/particles-000001.vtp").n_points == 0


def test_temperatures_stand_beside_what_they_are_of(tmp_path):
    run = write_whole(tmp_path / "run")
    write_frames(run, SIZE, count=1, heat=True)
    export(run)
    cloud, gas = pyvista.read(run / "vtk/particles-000000.vtp"), pyvista.read(run / "vtk/gas-000000.vti")
    assert np.array_equal(cloud["temperature"], np.where(cloud["velocity"][:, 2] > 0.0, 360.0, 300.0))
    assert np.all(gas["gas_temperature"] == 310.0) and "species" not in cloud.point_data


def test_post_names_the_files(run):
    done = CliRunner().invoke(cli, ["post", str(run), "--vtk"])
    assert done.exit_code == 0 and f"{run}/vtk/particles.pvd" in done.output.replace("\n", "")


def test_without_the_library_it_is_told_how_to_install_it(tmp_path, monkeypatch):
    library = import_module("fbcouple.postproc.views.library")
    monkeypatch.setattr(library, "find_spec", lambda name: None)
    with pytest.raises(NotDrawableError, match=r"need pyvista, which is not installed; .*fbcouple\[views\]"):
        export(tmp_path)
