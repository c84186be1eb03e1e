"""Meshes of a real mesher: thirty by gmsh in its formats, against gmsh's own numbers; groups as people name them."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import meshio
import numpy as np
import pytest
from test_meshes import break_up, make_bricks, write_gmsh

from fbcouple.errors import CaseError
from fbcouple.geometry.cylinder import make_cylinder
from fbcouple.geometry.gmsh_file import read_gmsh_file
from fbcouple.geometry.imported import choose_patches, read_mesh_file
from fbcouple.geometry.locator import Locator
from fbcouple.geometry.polyhedra import find_centres
from fbcouple.geometry.quality import measure_cells, require_sound
from fbcouple.geometry.tetrahedra import cut

INLET, COUNT = "Zulauf ö(1)", 30


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """A folder of meshes, and what gmsh says of each."""
    folder = tmp_path_factory.mktemp("gmsh")
    subprocess.run([sys.executable, Path(__file__).with_name("gmsh_shapes.py"), folder], check=True)
    return folder, json.loads((folder / "numbers.json").read_text())


@pytest.mark.parametrize("number", range(COUNT))
def test_a_mesh_of_gmsh_is_read_as_gmsh_made_it(made, number):
    folder, numbers = made
    name, about = list(numbers.items())[number]
    found = read_mesh_file(folder / name)
    require_sound(found.mesh)
    mesh = choose_patches(found, INLET, "top")
    assert mesh.count == about["cells"]
    assert mesh.volume == pytest.approx(about["volume"], rel=1e-9)
    assert mesh.find_area("inlet") == pytest.approx(about["inlet"], rel=1e-9)
    assert mesh.find_area("outlet") == pytest.approx(about["outlet"], rel=1e-9)
    volumes, least, openness = measure_cells(mesh, find_centres(mesh))
    assert least.min() > 0.0 and openness.max() < 1e-13
    assert volumes.sum() == pytest.approx(mesh.volume, rel=1e-12)
    locator = Locator(cut(break_up(mesh)))
    assert np.array_equal(locator.find_cells(find_centres(mesh)), np.arange(mesh.count))


def test_the_last_cell_of_some_owns_no_face(made):
    """What makes the highest owner and the number of cells two things; without one of them the test above is blind."""
    folder, numbers = made
    meshes = [read_mesh_file(folder / name).mesh for name in numbers]
    assert any(mesh.owner.max() + 1 < mesh.count for mesh in meshes)


def test_all_formats_of_a_shape_are_there(made):
    kinds = {tuple(name.split("-")[1:]) for name in made[1]}
    assert len(made[1]) == COUNT
    assert {kind[1:] for kind in kinds if kind[0] == "box"} == {
        (version, of) for version in ("4.1", "2.2") for of in ("text.msh", "binary.msh")
    }


FORMAT_4 = """$MeshFormat
4.1 0 8
$EndMeshFormat
{names}$Entities
0 0 {surfaces} 1
{entities}1 0 0 0 1 1 2 {volume} 0
$EndEntities
$Nodes
1 {points} 1 {points}
3 1 0 {points}
{nodes}$EndNodes
$Elements
{blocks} {elements} 1 {elements}
{rows}$EndElements
"""
VOLUME = "1 99"


def write_4(path, mesh, groups, names="", volume=VOLUME):
    """The cells of a mesh of bricks, and patches as the entities 1, 2 and 3; `groups`: patch -> the groups of each."""
    corners = (mesh.cells_given + 1).tolist()
    rows, count = [f"3 1 5 {len(corners)}\n"], 0
    for cell in corners:
        count += 1
        rows.append(f"{count} {' '.join(map(str, cell))}\n")
    for entity, name in enumerate(groups, start=1):
        faces = mesh.mesh.faces.take(mesh.mesh.list_patch(name)).values.reshape(-1, 4) + 1
        rows.append(f"2 {entity} 3 {len(faces)}\n")
        for face in faces.tolist():
            count += 1
            rows.append(f"{count} {' '.join(map(str, face))}\n")
    tags = "".join(f"{k}\n" for k in range(1, len(mesh.mesh.points) + 1))
    places = "".join(f"{x!r} {y!r} {z!r}\n" for x, y, z in mesh.mesh.points.tolist())
    path.write_text(
        FORMAT_4.format(
            names=f"$PhysicalNames\n{names.count(chr(10))}\n{names}$EndPhysicalNames\n" if names else "",
            surfaces=len(groups),
            entities="".join(f"{k} 0 0 0 1 1 2 {tags} 0\n" for k, tags in enumerate(groups.values(), start=1)),
            volume=volume,
            points=len(mesh.mesh.points),
            nodes=tags + places,
            blocks=1 + len(groups),
            elements=count,
            rows="".join(rows),
        )
    )
    return path


class Bricks:
    """A small column of bricks, and the rows of points of its cells."""

    def __init__(self):
        self.mesh = make_bricks((2, 2, 4), (1.0, 1.0, 2.0))
        k, j, i = np.meshgrid(np.arange(4), np.arange(2), np.arange(2), indexing="ij")
        low = ((k * 3 + j) * 3 + i).ravel()
        self.cells_given = np.stack([low + step for step in (0, 1, 4, 3, 9, 10, 13, 12)], axis=1)


@pytest.fixture
def bricks():
    return Bricks()


def test_a_surface_in_two_groups_is_found_by_each(bricks, tmp_path):
    names = '2 50 "all boundaries"\n2 1 "bottom"\n2 2 "top"\n'
    path = write_4(tmp_path / "a.msh", bricks, {"inlet": "2 50 1", "outlet": "2 50 2", "walls": "1 50"}, names)
    found = read_mesh_file(path)
    assert {name: len(faces) for name, faces in found.surfaces.items()} == {
        "all boundaries": 40,
        "bottom": 4,
        "top": 4,
    }
    mesh = choose_patches(found, "bottom", "top")
    assert mesh.find_area("inlet") == mesh.find_area("outlet") == pytest.approx(1.0, rel=1e-12)
    with pytest.raises(CaseError, match="all boundaries and top share 4 faces"):
        choose_patches(found, "all boundaries", "top")


def test_inlet_and_outlet_are_not_the_same(bricks, tmp_path):
    found = read_mesh_file(write_4(tmp_path / "a.msh", bricks, {"inlet": "1 1", "outlet": "1 2"}))
    with pytest.raises(CaseError, match="1 and 1 share 4 faces"):
        choose_patches(found, "1", "1")


def test_all_elements_saved_with_groups_on_inlet_and_outlet_only(bricks, tmp_path):
    names = '2 1 "bottom"\n2 2 "top"\n'
    groups = {"inlet": "1 1", "outlet": "1 2", "walls": "0"}
    found = read_mesh_file(write_4(tmp_path / "a.msh", bricks, groups, names, "0"))
    mesh = choose_patches(found, "bottom", "top")
    assert mesh.patches == {"inlet": (28, 4), "outlet": (32, 4), "walls": (36, 32)}


def test_groups_without_names_are_called_by_their_numbers(bricks, tmp_path):
    found = read_mesh_file(write_4(tmp_path / "a.msh", bricks, {"inlet": "1 7", "outlet": "1 12", "walls": "1 3"}))
    assert choose_patches(found, "7", "12").find_area("inlet") == pytest.approx(1.0, rel=1e-12)
    with pytest.raises(CaseError, match=r"no patch inlet.* domain\.inlet = one of: 7, 12, 3\."):
        choose_patches(found, "inlet", "12")


def test_a_surface_and_a_volume_may_have_one_name(bricks, tmp_path):
    names = '2 1 "bed"\n2 2 "top"\n3 99 "bed"\n3 98 "gas"\n'
    found = read_mesh_file(write_4(tmp_path / "a.msh", bricks, {"inlet": "1 1", "outlet": "1 2"}, names))
    assert choose_patches(found, "bed", "top").find_area("inlet") == pytest.approx(1.0, rel=1e-12)
    with pytest.raises(CaseError, match="gas is a group of volumes"):
        choose_patches(found, "gas", "top")


def test_two_numbers_of_one_name_are_one_patch(bricks, tmp_path):
    names = '2 1 "open"\n2 3 "open"\n2 2 "top"\n'
    found = read_mesh_file(
        write_4(tmp_path / "a.msh", bricks, {"inlet": "1 1", "outlet": "1 2", "walls": "1 3"}, names)
    )
    assert len(found.surfaces["open"]) == 36 and "walls" not in found.surfaces


def test_a_group_called_walls_does_not_take_what_is_in_no_group(bricks, tmp_path):
    names = '2 1 "bottom"\n2 2 "walls"\n'
    found = read_mesh_file(write_4(tmp_path / "a.msh", bricks, {"inlet": "1 1", "outlet": "1 2"}, names))
    assert len(found.surfaces["walls"]) == 4
    assert choose_patches(found, "bottom", "walls").patches["walls"] == (36, 32)


def test_surfaces_alone_are_no_mesh(bricks, tmp_path):
    path = write_4(tmp_path / "a.msh", bricks, {"inlet": "1 1", "outlet": "1 2"})
    text = path.read_text()
    start = text.index("$Elements\n") + len("$Elements\n")
    rows = text[start:].split("\n")
    kept = [f"2 8 1 {8}", *rows[18:28], "$EndElements\n"]
    path.write_text(text[:start] + "\n".join(kept))
    with pytest.raises(CaseError, match=r"surfaces and no cells.*Physical Volume"):
        read_mesh_file(path)


def test_an_inlet_between_cells_and_one_beside_them_are_refused(bricks, tmp_path):
    path = write_4(tmp_path / "a.msh", bricks, {"inlet": "1 1", "outlet": "1 2", "walls": "1 3"})
    text = path.read_text()
    floor, middle = "1 4 5 2", "19 22 23 20"  # the same square of the floor and of the middle of the column
    assert f" {floor}\n" in text
    (tmp_path / "inner.msh").write_text(text.replace(f" {floor}\n", f" {middle}\n"))
    found = read_mesh_file(tmp_path / "inner.msh")
    assert found.inner == {"1": 1}
    with pytest.raises(CaseError, match="1 faces of 1 lie between two cells"):
        choose_patches(found, "1", "2")
    (tmp_path / "loose.msh").write_text(text.replace(f" {floor}\n", " 1 4 23 20\n"))
    with pytest.raises(CaseError, match="1 faces of 1 are no sides of cells"):
        choose_patches(read_mesh_file(tmp_path / "loose.msh"), "1", "2")


def test_cells_that_format_2_repeats_for_each_group_are_one(tmp_path):
    mesh = make_cylinder(0.04, 0.08, 4, 3, "tetrahedra")
    write_gmsh(mesh, tmp_path / "a.msh")
    lines = (tmp_path / "a.msh").read_text().split("\n")
    start = lines.index("$Elements") + 1
    rows = [line.split() for line in lines[start + 1 : start + 1 + int(lines[start])]]
    more = [[*row[:3], "8", *row[4:]] for row in rows if row[1] == "4"]
    assert len(more) == mesh.count
    lines[start : start + 1 + len(rows)] = [str(len(rows) + len(more)), *(" ".join(row) for row in [*rows, *more])]
    (tmp_path / "b.msh").write_text("\n".join(lines))
    found = read_mesh_file(tmp_path / "b.msh")
    assert found.mesh.count == mesh.count and found.mesh.volume == pytest.approx(mesh.volume, rel=1e-12)


@pytest.mark.parametrize("shape", ["hexahedron", "wedge", "pyramid", "tetra"])
def test_cells_inside_out_are_turned(shape, tmp_path):
    """A mirrored mesh is the same mesh."""
    cube = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]], float)
    corners = {"hexahedron": range(8), "wedge": (0, 1, 2, 4, 5, 6), "pyramid": (0, 1, 2, 3, 4), "tetra": (0, 1, 2, 5)}
    volume = {"hexahedron": 1.0, "wedge": 0.5, "pyramid": 1 / 3, "tetra": 1 / 6}[shape]
    for name, points in (("right", cube), ("mirrored", cube * [1, 1, -1])):
        cells = [(shape, np.array([list(corners[shape])]))]
        meshio.gmsh.write(tmp_path / f"{name}.msh", meshio.Mesh(points, cells), "2.2", binary=False)
        mesh = read_mesh_file(tmp_path / f"{name}.msh").mesh
        require_sound(mesh)
        assert mesh.volume == pytest.approx(volume, rel=1e-12)


@pytest.mark.parametrize(
    ("start", "words"),
    [
        (b'(0 "GAMBIT to Fluent File")\n(2 3)\n', "a mesh of Fluent.*fluent3DMeshToFoam"),
        (b"\x89HDF\r\n\x1a\n", "HDF5"),
        (b"$NOD\n1\n1 0 0 0\n$ENDNOD\n", "format 1"),
        (b"solid walls\n", "STL"),
        (b"\x1f\x8b\x08\x00", "gunzip"),
        (b"hello\n", "first line is `hello`"),
        (b"", "no mesh of gmsh"),
        (b"$MeshFormat\n4 0 8\n$EndMeshFormat\n", "format 4, 2.2 and 4.1 are allowed"),
        (b"$MeshFormat\n4.0 0 8\n$EndMeshFormat\n", "format 4.0.*rewrites"),
        (b"$MeshFormat\n4.1 1 8\n\0\0\0\1\n$EndMeshFormat\n", "byte order"),
        (b"$MeshFormat\n4.1\n$EndMeshFormat\n", "no line like `4.1 0 8`"),
        (b"$MeshFormat\n4.1 0 8\n", "has no end"),
        (b"$MeshFormat\n4.1 0 8\n$EndMeshFormat\n", "no Elements and Nodes"),
    ],
)
def test_what_the_file_is_in_place_of_a_mesh_is_told(start, words, tmp_path):
    (tmp_path / "a.msh").write_bytes(start)
    with pytest.raises(CaseError, match=words):
        read_mesh_file(tmp_path / "a.msh")


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("3 1 5 16\n", "3 1 12 16\n", r"curved elements \(hexahedron27\).*ElementOrder = 1"),
        ("3 1 5 16\n", "3 1 106 16\n", "type 106"),
        ("3 1 5 16\n", "3 1 5 1600000000000\n", "ends early"),
        ("3 1 5 16\n", "3 1 5 -1\n", "ends early"),
        ("3 1 5 16\n", "3 1 5.5 16\n", "not whole"),
        ("\n1 1 2 5 4 10", "\n1 1 2 5 4 1000", "names a point that is not there"),
        ("\n1 1 2 5 4 10", "\n1 1 two 5 4 10", "two"),
        ("$Entities", "$PartitionedEntities\n$EndPartitionedEntities\n$Entities", "partitions"),
    ],
)
def test_what_is_wrong_in_a_file_is_told(bricks, old, new, words, tmp_path):
    path = write_4(tmp_path / "a.msh", bricks, {"inlet": "1 1", "outlet": "1 2"})
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))
    with pytest.raises(CaseError, match=words):
        read_mesh_file(path)


@pytest.mark.parametrize("keep", [0.3, 0.6, 0.9, 0.99])
@pytest.mark.parametrize("number", range(9))
def test_a_file_that_is_cut_off_is_refused(made, number, keep, tmp_path):
    folder, numbers = made
    data = (folder / list(numbers)[number]).read_bytes()
    end = data.index(b"$EndElements")
    (tmp_path / "a.msh").write_bytes(data[: int(keep * end)])
    with pytest.raises(CaseError, match=r"has no end|ends early|has no "):
        read_mesh_file(tmp_path / "a.msh")


def test_points_with_gaps_in_their_numbers_and_with_parameters(bricks, tmp_path):
    path = write_4(tmp_path / "a.msh", bricks, {"inlet": "1 1", "outlet": "1 2"})
    head, nodes = path.read_text().split("3 1 0 45\n")
    nodes, elements = nodes.split("$EndNodes")
    lines = nodes.strip().split("\n")
    tags, places = [str(10 * int(tag)) for tag in lines[:45]], [f"{line} 0.5 0.5 0.5" for line in lines[45:]]
    rows = elements.split("\n")
    for n, row in enumerate(rows):
        words = row.split()
        if len(words) in (5, 9):
            rows[n] = " ".join([words[0], *(f"{word}0" for word in words[1:])])
    text = f"{head}3 1 1 45\n" + "\n".join([*tags[::-1], *places[::-1]]) + "\n$EndNodes" + "\n".join(rows)
    path.write_text(text)
    mesh = read_mesh_file(path).mesh
    assert mesh.count == 16 and mesh.volume == pytest.approx(2.0, rel=1e-12)


def test_numbers_are_whole_as_gmsh_writes_them(made):
    folder, numbers = made
    for name in numbers:
        found = read_gmsh_file(folder / name)
        assert {block.corners.dtype for block in found.blocks} == {np.dtype(np.int64)}
        assert sorted(found.names.values()) == sorted(["bed", INLET, "top"])


def test_every_face_of_a_surface_on_points_of_its_own_is_counted(tmp_path):
    """A disc that was meshed by itself, beside the floor of the column: none of its points is a cell's."""
    write_gmsh(make_cylinder(0.04, 0.08, 4, 3, "tetrahedra"), tmp_path / "a.msh")
    lines = (tmp_path / "a.msh").read_text().split("\n")
    at = lines.index("$Nodes") + 1
    points = int(lines[at])
    lines[at] = str(points + 4)
    lines[at + 1 : at + 1] = [f"{points + n} {x} {y} 0" for n, (x, y) in enumerate(((1, 1), (2, 1), (1, 2), (2, 2)), 1)]
    at = lines.index("$Elements") + 1
    lines[at] = str(int(lines[at]) + 2)
    lines[at + 1 : at + 1] = [f"9{n} 2 2 77 77 {points + n} {points + n + 1} {points + n + 2}" for n in (1, 2)]
    (tmp_path / "b.msh").write_text("\n".join(lines))
    found = read_mesh_file(tmp_path / "b.msh")
    assert found.loose["77"] == 2 and found.surfaces["77"].size == 0
    with pytest.raises(CaseError, match="2 faces of 77 are no sides of cells"):
        choose_patches(found, "77", "top")


TUBE = """SetFactory("OpenCASCADE");
Cylinder(1) = {0, 0, 0, 0, 0, 0.02, 0.008};
Mesh.MeshSizeMax = 0.004;
"""
NAMES = """Physical Surface("bottom") = {3};
Physical Surface("top") = {2};
Physical Volume("bed") = {1};
"""


def mesh_tube(folder, form, save_all, text=TUBE + NAMES, binary=0):
    (folder / "tube.geo").write_text(text)
    gmsh = [sys.executable, Path(sys.executable).with_name("gmsh"), "-3", "-nt", "1", "-v", "1", "-format", form]
    numbers = ["-setnumber", "Mesh.SaveAll", str(save_all), "-setnumber", "Mesh.Binary", str(binary)]
    subprocess.run([*gmsh, *numbers, "-o", folder / "tube.msh", folder / "tube.geo"], check=True)
    return folder / "tube.msh"


@pytest.mark.parametrize("binary", [0, 1])
def test_groups_that_format_2_loses_are_told(tmp_path, binary):
    """gmsh writes the names and group 0 for every element."""
    path = mesh_tube(tmp_path, "msh22", 1, binary=binary)
    words = r"it names the groups bottom, top, bed, and none of its elements is in one: format 2 loses them with "
    with pytest.raises(CaseError, match=rf"{words}Mesh\.SaveAll = 1; mesh it again in format 4\.1 .*SaveAll = 0"):
        read_mesh_file(path)


@pytest.mark.parametrize(("form", "save_all"), [("msh22", 0), ("msh41", 0), ("msh41", 1)])
def test_groups_that_gmsh_keeps(tmp_path, form, save_all):
    mesh = choose_patches(read_mesh_file(mesh_tube(tmp_path, form, save_all)), "bottom", "top")
    assert mesh.find_area("inlet") == pytest.approx(mesh.find_area("outlet"), rel=1e-3)


def test_a_mesh_without_groups_says_how_to_name_them(tmp_path):
    found = read_mesh_file(mesh_tube(tmp_path, "msh22", 1, TUBE))
    with pytest.raises(CaseError, match=r'one of: walls \(the file names no other; .*Physical Surface\("inlet"\)'):
        choose_patches(found, "inlet", "outlet")
