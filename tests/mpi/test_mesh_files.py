"""Meshes that a case brings, about their own axis, from set-up to results on several ranks; gone on with on another."""

from __future__ import annotations

import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from fbcouple.decks.set_up import lay_out
from fbcouple.errors import StoppedError
from fbcouple.geometry.cylinder import find_section, make_cylinder
from fbcouple.geometry.foam_files import write_polymesh
from fbcouple.geometry.imported import read_mesh_file
from fbcouple.launcher.launch import launch

sys.path.append(str(Path(__file__).parents[1] / "geometry"))
from test_meshes import make_bricks, write_gmsh

CASE = """
title = "a mesh about its own axis"
end_time = 8e-4
[domain]
shape = "file"
mesh = "MESH"
inlet = "IN"
outlet = "OUT"
size = SIZE
cells = [8, 8, 16]
[gas]
density = 1.165
viscosity = 2e-5
inlet_velocity = 1.5
pressure_tolerance = 1e-12
[particles]
diameter = 1e-3
density = 2500.0
count = 900
[contact]
restitution = 0.97
wall_restitution = 0.97
friction = 0.1
wall_friction = 0.1
[start]
[exchange]
filter_passes = 1
[averages]
start = 0.0
every = 1e-5
blocks = 2
[output]
record_every = 1e-4
[checkpoint]
moment_steps = 4
"""
VOLUME = 900 * np.pi / 6 * 1e-9


def make_mesh(elements):
    mesh = make_cylinder(0.016, 0.032, 6, 10, elements)
    return replace(mesh, points=mesh.points - [0.008, 0.008, 0.002])


def write_case(folder, mesh, *words):
    text = CASE.replace("SIZE", str((mesh.high - mesh.low).tolist()))
    for old, new in zip(("MESH", "IN", "OUT"), words, strict=True):
        text = text.replace(f'"{old}"', f'"{new}"')
    (folder / "case.toml").write_text(text)


def run_case(folder, ranks, **options):
    run = folder / f"run-{ranks}"
    if not options.get("resume"):
        lay_out(str(folder / "case.toml"), run, (), False, forced=True)
    launch(run, ranks, lambda row: None, **options)
    return read(run)


def read(run):
    with xr.open_dataset(run / "results.nc") as opened:
        return opened.load()


def judge(results, cells):
    assert results.sizes["cell"] == cells and int(results.attrs["complete"])
    assert results["momentum_error"].max() < 1e-10 and (results["particles"] == 900).all()
    assert np.abs(results["solids_volume"] / VOLUME - 1.0).max() < 1e-12
    assert float((results["solids_fraction"] * results["cell_volume"]).sum()) == pytest.approx(VOLUME, rel=1e-12)
    assert results.attrs["bed_section"] == pytest.approx(find_section(0.016, 6), rel=1e-9)
    assert float(results["gas_inflow_error"].max()) < 1e-12 and (results["particles_at_outlet"] == 0).all()
    assert float(results["gas_flux_error"][1:].max()) < 1e-6
    assert float(results["cell_z"].min()) < 0.0 and float(results["cell_x"].min()) < -0.006
    assert float(results["z"][0]) == pytest.approx(-0.001) and abs(float(results["x"].mean())) < 1e-12
    assert 0.0 < float(results["bed_height"][-1]) < 0.02
    centre = float((results["solids_fraction"] * results["cell_volume"] * results["cell_z"]).sum()) / VOLUME
    told = float(results["solids_centre_z"][-1])
    assert told - 0.002 == pytest.approx(centre, abs=5e-4), "heights are above the floor, which is at z = -2 mm"


def test_gmsh_file_on_two_ranks(tmp_path):
    mesh = make_mesh("tetrahedra")
    write_gmsh(mesh, tmp_path / "column.msh")
    write_case(tmp_path, mesh, "column.msh", "in", "out")
    judge(run_case(tmp_path, 2), 6 * 9 * 10 * 3)


def test_polymesh_of_prisms_gone_on_with_on_another_number_of_ranks(tmp_path):
    mesh = make_mesh("prisms")
    write_polymesh(mesh, tmp_path / "polyMesh")
    write_case(tmp_path, mesh, "polyMesh", "inlet", "outlet")
    whole = run_case(tmp_path, 1)
    judge(whole, 6 * 9 * 10)
    run = tmp_path / "run-2"
    lay_out(str(tmp_path / "case.toml"), run, (), False, forced=True)
    with pytest.raises(StoppedError):
        launch(run, 2, lambda row: None, wall_limit=1e-3)
    launch(run, 3, lambda row: None, resume=True)
    resumed = read(run)
    judge(resumed, 6 * 9 * 10)
    for name in ("solids_fraction", "gas_velocity", "pressure"):
        scale = float(np.abs(whole[name]).max())
        assert float(np.abs(resumed[name] - whole[name]).max()) < 1e-9 * scale, name


def test_a_box_of_bricks_from_a_file_is_the_built_in_box(tmp_path):
    """On three ranks and on one: the same sampler, weights and filter, and the same schemes of the gas. With those of
    meshes the pressure drop was 7 % lower."""
    shape, size = (6, 6, 14), (0.012, 0.012, 0.028)
    z, y, x = np.meshgrid(np.arange(8), np.arange(11), np.arange(11), indexing="ij")
    sites = 0.00073 + 0.00105 * np.stack([x.ravel(), y.ravel(), z.ravel()], axis=1)[:900]
    mesh = make_bricks(shape, size)
    write_case(tmp_path, mesh, "polyMesh", "inlet", "outlet")
    text = (tmp_path / "case.toml").read_text().replace("[8, 8, 16]", str(list(shape)))
    text = text.replace("[start]\n", "").replace("count = 900\n", 'count = 900\npositions = "bed.csv"\n')
    in_box = [line for line in text.splitlines() if not line.startswith(("shape", "mesh", "inlet =", "outlet ="))]
    found = {}
    for name, case, ranks in (("file", text, 3), ("box", "\n".join(in_box), 1)):
        folder = tmp_path / name
        folder.mkdir()
        (folder / "case.toml").write_text(case)
        np.savetxt(folder / "bed.csv", sites, delimiter=",", header="x,y,z", comments="")
        if name == "file":
            write_polymesh(mesh, folder / "polyMesh")
        found[name] = run_case(folder, ranks)
    for name in ("solids_fraction", "voidage", "gas_velocity", "pressure"):
        wanted = found["box"][name]
        values = found["file"][name].isel(cell=found["file"]["sampled_cell"]).transpose(*wanted.dims).values
        assert np.abs(values - wanted.values).max() < 1e-9 * np.abs(wanted).max(), name
    assert np.allclose(found["file"]["pressure_drop"][1:], found["box"]["pressure_drop"][1:], rtol=1e-9, atol=0.0)
    assert np.abs(found["file"]["solids_volume"] / VOLUME - 1.0).max() < 1e-12
    assert found["file"]["momentum_error"].max() < 1e-10


@pytest.fixture(scope="module")
def by_gmsh(tmp_path_factory):
    """Meshes by gmsh of the shapes that differ most, and gmsh's numbers of them."""
    folder = tmp_path_factory.mktemp("gmsh")
    program = Path(__file__).parents[1] / "geometry/gmsh_shapes.py"
    subprocess.run([sys.executable, program, folder], check=True)
    return folder, json.loads((folder / "numbers.json").read_text())


@pytest.mark.slow
@pytest.mark.parametrize("name", ["01-cylinder", "02-cone", "03-spout", "04-tee", "07-recombined", "08-mixed"])
def test_meshes_by_gmsh_run(by_gmsh, name, tmp_path):
    """Set up as it is, gas and particles on two ranks: nothing is lost, whatever the shape and the elements."""
    folder, numbers = by_gmsh
    (file,) = (file for file in numbers if file.startswith(name))
    (tmp_path / "mesh.msh").write_bytes((folder / file).read_bytes())
    found = read_mesh_file(tmp_path / "mesh.msh")
    write_case(tmp_path, found.mesh, "mesh.msh", "Zulauf ö(1)", "top")
    text = (tmp_path / "case.toml").read_text()
    (tmp_path / "case.toml").write_text(text.replace("count = 900", "count = 200").replace("filter_passes = 1", ""))
    results = run_case(tmp_path, 2)
    assert results.sizes["cell"] == numbers[file]["cells"] and int(results.attrs["complete"])
    assert results["momentum_error"].max() < 1e-10 and (results["particles"] == 200).all()
    assert np.abs(results["solids_volume"] * 900 / 200 / VOLUME - 1.0).max() < 1e-12
    assert float(results["cell_volume"].sum()) == pytest.approx(numbers[file]["volume"], rel=1e-9)
    speeds = results["gas_velocity"].isel(component=2)
    flow = float((speeds * results["cell_volume"]).sum() / results["cell_volume"].sum())
    assert flow > 0.1
