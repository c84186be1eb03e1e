"""Meshes of polyhedra: made, read, cut into tetrahedra, and points found in them."""

from __future__ import annotations

from dataclasses import replace

import meshio
import numpy as np
import pytest

from fbcouple.errors import CaseError
from fbcouple.geometry.block import make_block
from fbcouple.geometry.cylinder import count_cells, find_section, make_cylinder
from fbcouple.geometry.foam_files import read_polymesh, write_polymesh
from fbcouple.geometry.foam_text import FILES
from fbcouple.geometry.imported import choose_patches, read_mesh_file
from fbcouple.geometry.locator import Locator
from fbcouple.geometry.numbering import build_mesh
from fbcouple.geometry.polyhedra import find_centres, join, take_apart
from fbcouple.geometry.tetrahedra import cut, find_neighbours, share_volumes

KINDS = ("tetrahedra", "prisms")


def make_bricks(cells, size):
    """A box of hexahedra: floor, top and sides are inlet, outlet and walls."""
    nx, ny, nz = cells
    axes = [np.linspace(0.0, length, n + 1) for length, n in zip(size, cells, strict=True)]
    z, y, x = np.meshgrid(*axes[::-1], indexing="ij")
    points = np.stack([x.ravel(), y.ravel(), z.ravel()], axis=1)
    k, j, i = np.meshgrid(np.arange(nz), np.arange(ny), np.arange(nx), indexing="ij")
    corner = (k * (ny + 1) + j) * (nx + 1) + i
    up, right, back = (ny + 1) * (nx + 1), 1, nx + 1
    steps = [0, right, right + back, back]
    cell = np.stack([corner.ravel() + step for step in (*steps, *(up + step for step in steps))], axis=1)

    def name(rows):
        heights = points[rows, 2]
        return np.where((heights == 0.0).all(axis=1), 0, np.where((heights == size[2]).all(axis=1), 1, 2))

    return build_mesh(points, [("hexahedron", cell)], ("inlet", "outlet", "walls"), name)


def break_up(mesh):
    return take_apart(mesh, find_centres(mesh), np.arange(mesh.count), np.arange(len(mesh.points)))


@pytest.fixture(params=[*KINDS, "bricks"])
def mesh(request):
    if request.param == "bricks":
        return make_bricks((4, 3, 5), (0.04, 0.03, 0.05))
    return make_cylinder(0.04, 0.08, 8, 10, request.param)


def test_bricks_along_the_axes_are_told_from_other_cells(mesh, request):
    """Graded bricks, too; none that are turned, sheared, or cut by a slanted face."""
    is_brick = request.node.callspec.params["mesh"] == "bricks"
    assert mesh.is_rectilinear == is_brick
    if is_brick:
        x, y, z = mesh.points.T
        graded = replace(mesh, points=np.stack([x**2, y, np.round(np.exp(20 * z), 9)], axis=1))
        assert graded.is_rectilinear
        for points in ([x + 1e-3 * z, y, z], [x, y + 1e-3 * x, z], [0.6 * x - 0.8 * z, y, 0.8 * x + 0.6 * z]):
            assert not replace(mesh, points=np.stack(points, axis=1)).is_rectilinear


@pytest.mark.parametrize(("kind", "each"), [("tetrahedra", 6), ("prisms", 2)])
def test_block(kind, each):
    size = (0.04, 0.03, 0.05)
    mesh = make_block(size, (4, 3, 5), kind)
    assert mesh.count == 60 * each and mesh.volume == pytest.approx(np.prod(size), rel=1e-12)
    assert [mesh.find_area(name) for name in ("inlet", "outlet")] == pytest.approx([0.04 * 0.03] * 2, rel=1e-12)
    assert np.allclose([mesh.low, mesh.high], [[0, 0, 0], size], atol=1e-15)
    parts = cut(break_up(mesh))
    assert np.bincount(parts.owners, parts.volumes) == pytest.approx(mesh.volume / mesh.count, rel=1e-9)


@pytest.mark.parametrize("kind", KINDS)
def test_cylinder(kind):
    mesh = make_cylinder(0.04, 0.08, 8, 10, kind)
    assert mesh.count == count_cells(8, 10, kind)
    assert mesh.volume == pytest.approx(find_section(0.04, 8) * 0.08, rel=1e-12)
    assert find_section(0.04, 8) == pytest.approx(np.pi * 0.02**2, rel=0.02)
    assert mesh.find_area("inlet") == pytest.approx(find_section(0.04, 8), rel=1e-12)
    assert np.allclose([mesh.low, mesh.high], [[0, 0, 0], [0.04, 0.04, 0.08]], atol=1e-3)
    volumes = np.bincount(cut(break_up(mesh)).owners, cut(break_up(mesh)).volumes)
    assert volumes.max() / volumes.min() < 1.4


def test_tetrahedra_fill_the_cells(mesh):
    parts = cut(break_up(mesh))
    assert parts.volumes.min() > 0.0 and parts.volumes.sum() == pytest.approx(mesh.volume, rel=1e-12)
    shares = share_volumes(parts)
    volumes = np.bincount(parts.owners, parts.volumes)
    assert np.abs(np.asarray(shares.sum(axis=1)).ravel() - volumes).max() < 1e-14 * volumes.max()
    # Sides without a neighbour are those of the surface, triangle for triangle.
    surface = mesh.cut_faces(np.arange(len(mesh.neighbour), len(mesh.owner)))
    assert (find_neighbours(parts.corners) < 0).sum() == len(surface)


def test_points_are_found_with_weights_that_give_them_back(mesh):
    parts = cut(break_up(mesh))
    rng = np.random.default_rng(1)
    chosen = rng.integers(len(parts.corners), size=2000)
    points = np.einsum("pk,pkd->pd", rng.dirichlet(np.ones(4), 2000), parts.nodes[parts.corners[chosen]])
    found, weights = np.full(2000, -1), np.empty((2000, 4))
    locator = Locator(parts)
    assert locator.locate(points, found, weights) == -1
    assert (locator.corners[found, 0] == parts.owners[chosen]).all()
    assert weights.min() >= 0.0 and np.abs(weights.sum(axis=1) - 1.0).max() < 1e-14
    assert np.abs(np.einsum("pk,pkd->pd", weights, parts.nodes[locator.corners[found]]) - points).max() < 1e-15
    outside = mesh.high + 0.01
    assert locator.locate(np.array([points[0], outside]), found[:2], weights[:2]) == 1
    assert locator.find_cells(np.array([outside]))[0] == -1
    assert locator.locate(np.array([points[0], [0.01, np.nan, 0.01]]), found[:2], weights[:2]) == 1


def test_what_is_looked_at_first_does_not_change_what_is_found(mesh):
    """Points inside, and at corners and middles of sides, where several tetrahedra could be taken."""
    parts = cut(break_up(mesh))
    rng = np.random.default_rng(3)
    chosen = rng.integers(len(parts.corners), size=3000)
    shares = rng.dirichlet(np.ones(4), 3000)
    shares[1000:2000] = np.eye(4)[rng.integers(4, size=1000)]
    shares[2000:, 0] = 0.0
    shares[2000:] /= shares[2000:].sum(axis=1)[:, None]
    points = np.einsum("pk,pkd->pd", shares, parts.nodes[parts.corners[chosen]])
    locator = Locator(parts)
    from_nowhere, wanted = np.full(3000, -1), np.empty((3000, 4))
    assert locator.locate(points, from_nowhere, wanted) == -1
    for first in (chosen, from_nowhere, rng.integers(len(parts.corners), size=3000)):
        found, weights = first.copy(), np.empty((3000, 4))
        assert locator.locate(points, found, weights) == -1
        assert (found == from_nowhere).all() and (weights == wanted).all()


def test_a_walk_around_a_corner_ends_at_the_point():
    """In an L of bricks the straight way from one leg to the other leaves it."""
    whole = break_up(make_bricks((6, 1, 6), (6.0, 1.0, 6.0)))
    leg = whole.select(np.flatnonzero((whole.centres[:, 0] < 1) | (whole.centres[:, 2] < 1)))
    locator = Locator(cut(leg))
    points = leg.centres + 0.3
    cells = locator.find_cells(points)
    assert (cells == np.arange(len(leg))).all()


def test_cells_travel(mesh):
    cells = break_up(mesh)
    rows = np.random.default_rng(2).permutation(len(cells))
    parts = np.array_split(rows, 3)
    back = join([cells.select(part) for part in parts])
    assert (back.ids == rows).all() and (back.point_ids == np.arange(len(mesh.points))).all()
    one, other = cut(cells), cut(back)
    assert other.volumes.sum() == pytest.approx(one.volumes.sum(), rel=1e-13)
    assert (find_neighbours(other.corners) < 0).sum() == (find_neighbours(one.corners) < 0).sum()


def test_polymesh_files_go_round(mesh, tmp_path):
    write_polymesh(mesh, tmp_path)
    back = read_polymesh(tmp_path)
    for name in ("points", "owner", "neighbour"):
        assert np.array_equal(getattr(back, name), getattr(mesh, name))
    assert np.array_equal(back.faces.values, mesh.faces.values) and back.patches == mesh.patches


@pytest.mark.parametrize(
    ("name", "change", "words"),
    [
        ("points", lambda text: text.replace("ascii", "binary"), "binary"),
        ("points", lambda text: text.replace("(0.0", "(nan", 1), "nan"),
        ("owner", lambda text: text.replace("(\n0\n", '(\n#calc "1"\n', 1), "owner"),
        ("boundary", lambda text: text.replace("inlet", "#codeStream {} inlet"), "#"),
        ("boundary", lambda text: text.replace("type wall", "type cyclic"), "cyclic"),
        ("boundary", lambda text: text.replace("nFaces", "faces"), "nFaces"),
        ("faces", lambda text: text[: len(text) // 2] + ")", "faces"),
        ("neighbour", lambda text: text.replace("(\n", "(\n1\n1\n", 1), "cut off or was edited"),
    ],
)
def test_what_is_no_mesh_is_refused(name, change, words, tmp_path):
    write_polymesh(make_cylinder(0.04, 0.08, 4, 2, "tetrahedra"), tmp_path)
    (tmp_path / name).write_text(change((tmp_path / name).read_text()))
    with pytest.raises(CaseError) as refused:
        read_polymesh(tmp_path)
    assert words in str(refused.value)


@pytest.mark.parametrize("missing", FILES)
def test_a_missing_file_is_named(missing, tmp_path):
    write_polymesh(make_cylinder(0.04, 0.08, 4, 2, "tetrahedra"), tmp_path)
    (tmp_path / missing).unlink()
    with pytest.raises(CaseError, match=missing):
        read_polymesh(tmp_path)


def write_gmsh(mesh, path, surfaces=None):
    """The cells of a mesh of tetrahedra and some `surfaces` (name -> faces; absent: in and out) as a gmsh file."""
    surfaces = surfaces or {"in": mesh.list_patch("inlet"), "out": mesh.list_patch("outlet")}
    cells = break_up(mesh)
    corners = cells.corners
    tetrahedra = np.array(
        [np.unique(corners.values[a:b]) for a, b in zip(corners.starts, corners.starts[1:], strict=False)]
    )
    sides = [mesh.faces.take(faces).values.reshape(-1, 3) for faces in surfaces.values()]
    blocks = [("tetra", tetrahedra), *(("triangle", side) for side in sides)]
    tags = [np.full(len(data), tag) for (_, data), tag in zip(blocks, (99, *range(1, 1 + len(sides))), strict=True)]
    names = {name: np.array([tag, 2]) for tag, name in enumerate(surfaces, start=1)} | {"gas": np.array([99, 3])}
    data = {"gmsh:physical": tags, "gmsh:geometrical": tags}
    meshio.gmsh.write(path, meshio.Mesh(mesh.points, blocks, cell_data=data, field_data=names), "2.2", binary=False)


def test_gmsh_file(tmp_path):
    mesh = make_cylinder(0.04, 0.08, 6, 5, "tetrahedra")
    write_gmsh(mesh, tmp_path / "mesh.msh")
    found = read_mesh_file(tmp_path / "mesh.msh")
    assert found.mesh.count == mesh.count and found.mesh.volume == pytest.approx(mesh.volume, rel=1e-12)
    assert {name: len(faces) for name, faces in found.surfaces.items()} == {"in": 54, "out": 54, "walls": 180}
    ordered = choose_patches(found, "in", "out")
    assert list(ordered.patches) == ["inlet", "outlet", "walls"]
    assert ordered.find_area("inlet") == pytest.approx(mesh.find_area("inlet"), rel=1e-12)
    assert np.all(ordered.points[ordered.faces.take(ordered.list_patch("inlet")).values, 2] == 0.0)
    (tmp_path / "mesh.msh").write_text("no mesh\n")
    with pytest.raises(CaseError, match="gmsh"):
        read_mesh_file(tmp_path / "mesh.msh")
