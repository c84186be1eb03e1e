"""Regions that are no boxes: what is refused with which words, and the files that a case brings."""

from __future__ import annotations

import gzip
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from fbcouple.case.bed.lattice import lattice_positions
from fbcouple.case.bed.region import find_region, read_mesh
from fbcouple.case.bed.region_lattice import Inside, fill_region
from fbcouple.case.changes import list_changes, list_values
from fbcouple.case.load import load_case
from fbcouple.case.preflight import estimate
from fbcouple.decks.set_up import lay_out
from fbcouple.errors import CaseError
from fbcouple.geometry.cylinder import find_section, make_cylinder
from fbcouple.geometry.foam_files import read_polymesh, write_polymesh
from fbcouple.geometry.foam_text import FILES, list_parts
from fbcouple.geometry.polyhedra import find_centres
from fbcouple.geometry.quality import measure_cells

sys.path.append(str(Path(__file__).parents[1] / "geometry"))
from test_meshes import write_gmsh

CASE = """
title = "cylinder"
end_time = 0.05
[domain]
shape = "cylinder"
size = [0.03, 0.03, 0.06]
cells = [6, 6, 12]
[gas]
density = 1.165
viscosity = 2e-5
inlet_velocity = 1.2
[particles]
diameter = 1e-3
density = 2500.0
count = 2000
[contact]
restitution = 0.97
wall_restitution = 0.97
friction = 0.1
wall_friction = 0.1
[start]
[exchange]
"""
FILE = {
    'shape = "cylinder"': 'shape = "file"\nmesh = "mesh.msh"\ninlet = "in"\noutlet = "out"',
}


def write(folder, *changes, text=CASE):
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    (folder / "case.toml").write_text(text)
    return str(folder / "case.toml")


@pytest.fixture
def with_mesh(tmp_path):
    """A case with a gmsh file of the same cylinder."""
    write_gmsh(make_cylinder(0.03, 0.06, 6, 12, "tetrahedra"), tmp_path / "mesh.msh")
    return write(tmp_path, *FILE.items(), ("[0.03, 0.03, 0.06]", str(list(box_of(0.03, 0.06, 6)))))


def box_of(diameter, height, across):
    mesh = make_cylinder(diameter, height, across, 1, "tetrahedra")
    width, depth, _ = (mesh.high - mesh.low).tolist()
    return width, depth, height


def test_numbers_of_a_cylinder(tmp_path):
    case = load_case(write(tmp_path))
    numbers = {number.name: number.value for number in estimate(case, folder=tmp_path)}
    assert numbers["cells"] == 6 * 9 * 12 * 3
    weight = 2000 * np.pi / 6 * 1e-9 * (2500 - 1.165) * 9.81
    assert numbers["pressure drop"] == pytest.approx(weight / find_section(0.03, 6), rel=1e-12)


def test_a_mesh_from_a_file_is_the_same_region(with_mesh, tmp_path):
    case = load_case(with_mesh)
    found, made = find_region(case, tmp_path), find_region(load_case(write(tmp_path)))
    assert found.cells == made.cells and found.volume == pytest.approx(made.volume, rel=1e-12)
    assert found.inlet == pytest.approx(made.inlet, rel=1e-12)


def test_slivers_of_a_mesh_from_a_file_are_told(with_mesh, tmp_path):
    """A point in the middle of the column is moved until cells beside it are 0.02 of the others' width along z."""
    case = load_case(with_mesh)
    (number,) = (one for one in estimate(case, folder=tmp_path) if one.name == "thinnest cell")
    assert number.verdict == "fit" and number.value > 0.2 and "thinner" not in number.meaning
    mesh = make_cylinder(0.03, 0.06, 6, 12, "tetrahedra")
    middle = np.linalg.norm(mesh.points - mesh.points.mean(axis=0), axis=1).argmin()
    above = mesh.points[:, 2][mesh.points[:, 2] > mesh.points[middle, 2] + 1e-6].min()
    points = mesh.points.copy()
    points[middle, 2] += 0.98 * (above - points[middle, 2])
    write_gmsh(replace(mesh, points=points), tmp_path / "mesh.msh")
    (number,) = (one for one in estimate(load_case(with_mesh), folder=tmp_path) if one.name == "thinnest cell")
    assert number.verdict == "warn" and number.value < 0.1 and "Mesh.OptimizeNetgen = 1" in number.meaning


def test_cells_of_a_mesh_that_are_smaller_than_a_particle_are_told(with_mesh, tmp_path):
    volumes = measure_cells(mesh := make_cylinder(0.03, 0.06, 6, 12, "tetrahedra"), find_centres(mesh))[0]
    numbers = {}
    for diameter in (1e-3, 1.1 * (6.0 * volumes.min() / np.pi) ** (1 / 3)):
        case = load_case(with_mesh, [f"particles.diameter={diameter}", "particles.count=500"])
        (numbers[diameter],) = (one for one in estimate(case, folder=tmp_path) if one.name == "smallest cell")
    small, large = numbers.values()
    assert small.verdict == "fit" and small.value == pytest.approx(volumes.min() / (np.pi / 6 * 1e-9), rel=1e-6)
    assert large.verdict == "warn" and large.value == pytest.approx(1.1**-3, rel=1e-6)
    assert f"{(volumes < volumes.min() * 1.1**3).sum()} of {len(volumes)} cells are smaller" in large.meaning


def test_setup_takes_the_mesh_along(with_mesh, tmp_path):
    run = tmp_path / "run"
    lay_out(with_mesh, run, (), False, forced=True)
    assert (run / "mesh.msh").read_bytes() == (tmp_path / "mesh.msh").read_bytes()
    assert (run / "DEM/walls.stl").exists()
    assert load_case(str(run)).domain.mesh == "mesh.msh"


def test_a_polymesh_folder(tmp_path):
    folder = tmp_path / "polyMesh"
    write_polymesh(make_cylinder(0.03, 0.06, 6, 12, "prisms"), folder)
    (folder / "cellZones").write_text('#codeStream "evil"')
    size = ("[0.03, 0.03, 0.06]", str(list(box_of(0.03, 0.06, 6))))
    case = write(tmp_path, ('shape = "cylinder"', 'shape = "file"\nmesh = "polyMesh"'), size)
    lay_out(case, tmp_path / "run", (), False, forced=True)
    assert sorted(path.name for path in (tmp_path / "run/polyMesh").iterdir()) == sorted(FILES)
    assert read_polymesh(tmp_path / "run/polyMesh").count == 6 * 9 * 12


def test_a_box_of_tetrahedra_is_counted_in_tetrahedra(tmp_path):
    case = load_case(write(tmp_path, ('shape = "cylinder"', 'elements = "tetrahedra"')))
    region = find_region(case)
    assert region.cells == read_mesh(case).count == 6 * 6 * 6 * 12
    assert region.volume == pytest.approx(0.03 * 0.03 * 0.06) and region.inlet == pytest.approx(0.03 * 0.03)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ([("[0.03, 0.03,", "[0.03, 0.04,")], ["domain.size", "same diameter"]),
        ([("[6, 6, 12]", "[7, 7, 12]")], ["domain.cells", "even"]),
        ([("[6, 6, 12]", "[6, 8, 12]")], ["domain.cells", "twice"]),
        ([('shape = "cylinder"', 'shape = "cylinder"\nperiodic = ["x"]')], ["domain.periodic", "only a box"]),
        ([("inlet_velocity = 1.2", "inlet_velocity = 1.2\nclosed_nozzle = [2, 2]")], ["closed_nozzle", "only a box"]),
        ([("[exchange]", '[exchange]\nvoidage = "divided"')], ["exchange.voidage", "trilinear"]),
        ([("[exchange]", "[exchange]\ndiffusion_width = 3.0")], ["diffusion_width", "only a box"]),
        ([("[start]", "[start]\nregion = [[0.0, 0.03], [0.0, 0.03], [0.01, 0.07]]")], ["start.region", "along z"]),
        ([("[start]", "[start]\nregion = [[0.0, 0.03], [0.02, 0.01], [0.0, 0.05]]")], ["start.region", "lower end"]),
        ([('shape = "cylinder"', 'shape = "file"\nelements = "prisms"')], ["domain.elements", "cylinder"]),
        ([('shape = "cylinder"', 'mesh = "a.msh"')], ["domain.mesh", "file"]),
        ([('shape = "cylinder"', 'shape = "cylinder"\nscale = 1e-3')], ["domain.scale", "file"]),
        ([('shape = "cylinder"', 'shape = "file"\nmesh = "a.msh"\nscale = 0.0')], ["domain.scale", "above 0"]),
        ([('shape = "cylinder"', 'shape = "file"')], ["domain.mesh", "beside"]),
        ([('shape = "cylinder"', 'shape = "file"\nmesh = "../a.msh"')], ["domain.mesh", "bare name"]),
        ([('shape = "cylinder"', 'shape = "file"\nmesh = "none.msh"')], ["domain.mesh", "cannot be read"]),
        ([("count = 2000", "count = 60000")], ["particles.count", "do not fit"]),
    ],
)
def test_what_cannot_be_is_told(changes, words, tmp_path):
    with pytest.raises(CaseError) as refused:
        load_case(write(tmp_path, *changes))
    assert all(word in str(refused.value) for word in words), str(refused.value)


def test_a_link_to_a_mesh_elsewhere_is_refused(tmp_path):
    home, away = tmp_path / "home", tmp_path / "away"
    home.mkdir()
    write_polymesh(make_cylinder(0.03, 0.06, 6, 12, "prisms"), away)
    (home / "polyMesh").symlink_to(away)
    with pytest.raises(CaseError, match=r"domain\.mesh"):
        load_case(write(home, ('shape = "cylinder"', 'shape = "file"\nmesh = "polyMesh"')))


def test_no_gas_no_mesh(tmp_path):
    text = CASE[: CASE.index("[gas]")] + CASE[CASE.index("[particles]") : CASE.index("[exchange]")]
    with pytest.raises(CaseError, match="holds the mesh"):
        load_case(write(tmp_path, text=text))


def test_sizes_and_patches_are_compared(with_mesh, tmp_path):
    text = Path(with_mesh).read_text()
    with pytest.raises(CaseError, match=r"domain\.size.*box around"):
        load_case(write(tmp_path, (str(list(box_of(0.03, 0.06, 6))), "[30.0, 30.0, 60.0]"), text=text))
    with pytest.raises(CaseError, match=r"out and out share 54 faces"):
        load_case(write(tmp_path, ('inlet = "in"', 'inlet = "out"'), text=text))
    with pytest.raises(CaseError, match=r"no patch floor.*in, out, walls"):
        load_case(write(tmp_path, ('inlet = "in"', 'inlet = "floor"'), text=text))


def test_a_size_within_one_percent_will_do(with_mesh, tmp_path):
    """A round wall is meshed by flat faces: the box around it is a little narrower than the circle."""
    text = Path(with_mesh).read_text()
    size = str(list(box_of(0.03, 0.06, 6)))
    load_case(write(tmp_path, (size, "[0.03, 0.0298, 0.0602]"), text=text))
    with pytest.raises(CaseError, match=r"domain\.size.*within 1% is allowed; give that, in m"):
        load_case(write(tmp_path, (size, "[0.03, 0.03, 0.062]"), text=text))


def test_a_mesh_in_millimetres_is_scaled(tmp_path):
    mesh = make_cylinder(0.03, 0.06, 6, 12, "tetrahedra")
    write_gmsh(replace(mesh, points=mesh.points * 1e3), tmp_path / "mesh.msh")
    text = CASE.replace(*next(iter(FILE.items()))).replace("[0.03, 0.03, 0.06]", str(list(box_of(0.03, 0.06, 6))))
    with pytest.raises(CaseError, match=r"domain\.size.*give domain\.scale = 0\.001"):
        load_case(write(tmp_path, text=text))
    case = load_case(write(tmp_path, ('inlet = "in"', 'scale = 1e-3\ninlet = "in"'), text=text))
    found = find_region(case, tmp_path)
    assert found.volume == pytest.approx(mesh.volume, rel=1e-12)
    assert found.spacing == pytest.approx(np.cbrt(mesh.volume / mesh.count), rel=1e-12)
    unscaled = case.model_copy(update={"domain": case.domain.model_copy(update={"scale": None})})
    assert ["domain.scale" in str(change) for change in list_changes(list_values(case), unscaled)] == [True]
    write(tmp_path, ('inlet = "in"', 'scale = 1e-3\ninlet = "in"'), text=text)
    lay_out(str(tmp_path / "case.toml"), tmp_path / "run", (), False, forced=True)
    assert load_case(str(tmp_path / "run")).domain.scale == 1e-3
    corners = [
        line.split()[1:] for line in (tmp_path / "run/DEM/walls.stl").read_text().splitlines() if "vertex" in line
    ]
    assert np.abs(np.array(corners, float)).max() == pytest.approx(0.06)


def test_lengths_that_are_no_metres_are_unfit(tmp_path):
    """Mesh and size both in millimetres: nothing contradicts, and the cells are thousands of diameters wide."""
    mesh = make_cylinder(0.03, 0.06, 6, 12, "tetrahedra")
    write_gmsh(replace(mesh, points=mesh.points * 1e3), tmp_path / "mesh.msh")
    size = [edge * 1e3 for edge in box_of(0.03, 0.06, 6)]
    write(tmp_path, *FILE.items(), ("[0.03, 0.03, 0.06]", str(size)))
    with pytest.raises(CaseError, match=r"cell size x: \d+ d is expected, .*domain\.scale"):
        lay_out(str(tmp_path / "case.toml"), tmp_path / "run", (), False)
    with pytest.raises(CaseError, match="cell size x"):
        lay_out(write(tmp_path, ("[0.03, 0.03, 0.06]", "[30.0, 30.0, 60.0]")), tmp_path / "run", (), False)


def test_few_particles_in_a_wide_region_cost_little(tmp_path, monkeypatch):
    """3e7 sites in a layer, and 500 particles: they are spread over the floor, and few of the sites are looked at."""
    case = load_case(
        write(tmp_path, ("[0.03, 0.03, 0.06]", "[6.0, 6.0, 12.0]"), ("[6, 6, 12]", "[6, 6, 6]"), ("2000", "500"))
    )
    asked = []
    is_clear = Inside.is_clear
    monkeypatch.setattr(
        Inside, "is_clear", lambda self, sites, distance: asked.append(len(sites)) or is_clear(self, sites, distance)
    )
    places = lattice_positions(case)
    assert sum(asked) < 200_000
    assert places.shape == (500, 3) and np.ptp(places[:, 2]) < 0.03e-3 and places[:, 2].max() < 2e-3
    counts, *_ = np.histogram2d(places[:, 0], places[:, 1], bins=4, range=[[0, 6], [0, 6]])
    assert counts[1:3, 1:3].min() > 30 and counts.min() > 10


def test_a_narrow_end_is_filled_layer_by_layer(tmp_path):
    """A layer has sites where the region is, however wide it is higher up: a mesh like a funnel."""
    mesh = make_cylinder(0.03, 0.06, 8, 24, "tetrahedra")
    points = mesh.points.copy()
    points[:, :2] = 0.015 + (points[:, :2] - 0.015) * (0.2 + 10.0 * points[:, 2:] / 0.06)
    places, _ = fill_region(load_case(write(tmp_path)), replace(mesh, points=points))
    layers = np.round((places[:, 2] - 0.515e-3) / 1.03e-3)
    found, counts = np.unique(layers, return_counts=True)
    assert len(places) == 2000 and (np.diff(found) == 1).all() and (np.diff(counts[:-1]) > 0).all()
    lowest = places[layers == found[0]]
    assert np.linalg.norm(lowest[:, :2] - 0.015, axis=1).max() < 0.015 * (0.2 + 10.0 * lowest[0, 2] / 0.06)


@pytest.mark.parametrize("packed", ["all", "points"])
def test_a_packed_polymesh_folder_goes_along(packed, tmp_path):
    folder = tmp_path / "polyMesh"
    write_polymesh(make_cylinder(0.03, 0.06, 6, 12, "prisms"), folder)
    for name in FILES if packed == "all" else [packed]:
        (folder / f"{name}.gz").write_bytes(gzip.compress((folder / name).read_bytes()))
        (folder / name).unlink()
    size = ("[0.03, 0.03, 0.06]", str(list(box_of(0.03, 0.06, 6))))
    case = write(tmp_path, ('shape = "cylinder"', 'shape = "file"\nmesh = "polyMesh"'), size)
    lay_out(case, tmp_path / "run", (), False, forced=True)
    assert sorted(path.name for path in (tmp_path / "run/polyMesh").iterdir()) == sorted(list_parts(folder))
    assert load_case(str(tmp_path / "run")).domain.mesh == "polyMesh"


def test_a_surface_inside_is_told(tmp_path):
    """A surface that somebody meant as a wall: its faces have a cell on either side."""
    mesh = make_cylinder(0.03, 0.06, 6, 12, "tetrahedra")
    patches = {name: mesh.list_patch(name) for name in ("inlet", "outlet")}
    write_gmsh(mesh, tmp_path / "mesh.msh", {"in": patches["inlet"], "out": patches["outlet"], "tube": np.arange(5)})
    case = load_case(write(tmp_path, *FILE.items(), ("[0.03, 0.03, 0.06]", str(list(box_of(0.03, 0.06, 6))))))
    (number,) = (number for number in estimate(case, folder=tmp_path) if number.name == "inner faces")
    assert number.value == 5 and number.verdict == "warn" and "tube" in number.meaning


def test_more_particles_than_sites_are_told_at_setup(tmp_path):
    case = write(tmp_path, ("count = 2000", "count = 40000"))
    with pytest.raises(CaseError, match=r"start\.spacing.*sites inside"):
        lay_out(case, tmp_path / "run", (), False, forced=True)
    assert not (tmp_path / "run").exists()


def test_positions_outside_of_the_cylinder_are_told(tmp_path):
    (tmp_path / "beads.csv").write_text("x,y,z\n0.015,0.015,0.03\n0.001,0.001,0.03\n")
    case = write(tmp_path, ("count = 2000", 'count = 2\npositions = "beads.csv"'), ("[start]\n", ""))
    with pytest.raises(CaseError, match=r"1 particles are not inside the cylinder, first is particle 2"):
        load_case(case)


def test_a_start_fills_the_part_that_it_is_told(tmp_path):
    """From its lowest layer up, clear of the walls, in a mesh as in a box; without it nothing changes."""
    region = ("[start]", "[start]\nregion = [[0.005, 0.025], [0.006, 0.03], [0.02, 0.05]]")
    for number, shape in enumerate(("cylinder", "box")):
        text = CASE.replace('shape = "cylinder"', f'shape = "{shape}"')
        case = load_case(write(tmp_path, region, text=text))
        places = lattice_positions(case, tmp_path)
        assert len(places) == 2000 and np.ptp(places, axis=0).min() > 4e-3, number
        low, high = np.array(case.start.region).T
        assert (places >= low + 0.499e-3).all() and (places <= high - 0.499e-3).all()
        assert places[:, 2].min() < 0.0216, "the lowest layer is the first"
    plain = lattice_positions(load_case(write(tmp_path, text=text)), tmp_path)
    all_of_it = "[start]\nregion = [[0.0, 0.03], [0.0, 0.03], [0.0, 0.06]]"
    whole = load_case(write(tmp_path, ("[start]", all_of_it), text=text))
    assert np.abs(lattice_positions(whole, tmp_path) - plain).max() == 0.0
