"""polyMesh folders as OpenFOAM and people leave them: packed, with odd names, cut off, and hostile ones."""

from __future__ import annotations

import gzip
import time

import numpy as np
import pytest

from fbcouple.errors import CaseError
from fbcouple.geometry import foam_text
from fbcouple.geometry.cylinder import make_cylinder
from fbcouple.geometry.foam_boundary import read_patches
from fbcouple.geometry.foam_files import read_polymesh, write_polymesh
from fbcouple.geometry.foam_text import FILES, list_parts
from fbcouple.geometry.imported import choose_patches, read_mesh


@pytest.fixture
def mesh():
    return make_cylinder(0.04, 0.08, 4, 2, "prisms")


@pytest.fixture
def folder(mesh, tmp_path):
    write_polymesh(mesh, tmp_path)
    return tmp_path


def edit(folder, name, *changes):
    text = (folder / name).read_text()
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    (folder / name).write_text(text)


def pack(folder, name):
    (folder / f"{name}.gz").write_bytes(gzip.compress((folder / name).read_bytes()))
    (folder / name).unlink()


def test_packed_files_are_read(folder, mesh):
    for name in FILES:
        pack(folder, name)
    back = read_polymesh(folder)
    assert np.array_equal(back.points, mesh.points) and back.patches == mesh.patches
    assert list_parts(folder) == [f"{name}.gz" for name in FILES]


def test_a_plain_and_a_packed_file_of_one_name_are_refused(folder):
    (folder / "owner.gz").write_bytes(gzip.compress((folder / "owner").read_bytes()))
    with pytest.raises(CaseError, match=r"owner and owner\.gz; remove"):
        read_polymesh(folder)


@pytest.mark.parametrize("data", [b"no gzip", gzip.compress(b"x" * 1000, mtime=0)[:30], b""])
def test_what_cannot_be_unpacked_is_told(folder, data):
    (folder / "points").unlink()
    (folder / "points.gz").write_bytes(data)
    with pytest.raises(CaseError, match=r"points\.gz"):
        read_polymesh(folder)


@pytest.mark.parametrize("name", ["inlet(1)", '"inlet(1)"', "inlet@2", "Zulauf_ö", "入口", "2", "in.let:1+-", "a%b"])
def test_patch_names_are_kept_as_they_are(folder, name):
    edit(folder, "boundary", ("\ninlet", f"\n{name}\n"))
    found = read_mesh(folder)
    assert list(found.surfaces) == [name.strip('"'), "outlet", "walls"]
    assert choose_patches(found, name.strip('"'), "outlet").count == found.mesh.count


def test_entries_that_are_not_needed_are_passed_over(folder):
    more = "inGroups List<word> 2(wall all); transform { type none; nFaces 7; } // nFaces 8;\n/* startFace 9; */ nFaces"
    edit(folder, "boundary", ("nFaces", more))
    assert read_polymesh(folder).patches == read_patches(folder / "boundary")


def test_equal_numbers_in_short_form(tmp_path):
    """The owners of the faces of a single cell."""
    one = make_cylinder(0.04, 0.08, 4, 1, "prisms")
    cell = one.faces.take(np.flatnonzero(one.owner == 0))
    points = "".join(f"({x!r} {y!r} {z!r})\n" for x, y, z in one.points.tolist())
    rows = "".join(
        f"{n}({' '.join(map(str, row))})\n"
        for n, row in zip(cell.lengths, np.split(cell.values, cell.starts[1:-1]), strict=True)
    )
    for name, text in {
        "points": f"{len(one.points)}\n(\n{points})\n",
        "faces": f"{len(cell)}\n(\n{rows})\n",
        "owner": f"{len(cell)}{{0}}\n// ***** //\n",
        "neighbour": "0()\n",
        "boundary": f"1(walls{{type wall;nFaces {len(cell)};startFace 0;}})",
    }.items():
        (tmp_path / name).write_text(text)
    mesh = read_polymesh(tmp_path)
    assert mesh.count == 1 and len(mesh.neighbour) == 0 and mesh.volume != 0.0


@pytest.mark.parametrize(
    ("name", "changes", "words"),
    [
        ("boundary", [("\noutlet", "\ninlet")], "two patches of the name inlet"),
        ("boundary", [("nFaces 24; startFace 84", "nFaces 24; startFace 85")], "patch"),
        ("boundary", [("\ninlet {", "\ninlet ")], "is where a patch"),
        ("boundary", [("}\n)", "\n)")], "no closing brace"),
        ("boundary", [("nFaces", "$half; nFaces")], "macros are not run"),
        ("boundary", [("\ninlet", '\n#include "evil"\ninlet')], "directives and macros"),
        ("boundary", [("\ninlet", '\n"inlet')], "is where a patch"),
        ("owner", [("\n(\n0\n", "\n(\n500\n")], "order|no face"),
        ("faces", [("\n3(", "\n2(")], "faces"),
        ("faces", [("\n3(", "\n-1(")], "faces"),
        ("points", [("57\n(", "58\n(")], "holds 57 entries and says 58"),
        ("points", [("FoamFile {", "FoamFile { format binary; ")], "foamFormatConvert"),
        ("points", [("(0.0", "(0.0 #calc 1")], "#calc"),
    ],
)
def test_what_is_wrong_is_told(folder, name, changes, words):
    edit(folder, name, *changes)
    with pytest.raises(CaseError, match=words):
        read_polymesh(folder)


def test_inner_faces_in_another_order_are_refused(folder, mesh):
    """OpenFOAM's solvers take the order for granted."""
    lines = (folder / "neighbour").read_text().split("\n")
    start = lines.index("(") + 1
    lines[start], lines[start + 1] = lines[start + 1], lines[start]
    (folder / "neighbour").write_text("\n".join(lines))
    with pytest.raises(CaseError, match="renumberMesh"):
        read_polymesh(folder)


@pytest.mark.parametrize(
    "text",
    [
        "a" * 900_000,
        "a " * 450_000,
        "/*" * 450_000,
        "//" * 450_000,
        '"' * 900_000,
        "{" * 900_000,
        "(" * 900_000,
        "FoamFile{" * 100_000,
        "1(a{" + "b;" * 400_000,
        "1(" + "a{}" * 300_000,
        "1(" + '"\\' * 400_000 + ")",
    ],
    ids=lambda text: text[:12],
)
def test_no_boundary_takes_long(text, tmp_path):
    (tmp_path / "boundary").write_text(text)
    start = time.process_time()
    with pytest.raises(CaseError):
        read_patches(tmp_path / "boundary")
    assert time.process_time() - start < 2.0


@pytest.mark.parametrize("text", ["/*" * 500_000, "FoamFile " * 100_000, "{" * 900_000, "1{" * 400_000, "(" * 900_000])
def test_no_list_takes_long(folder, text):
    (folder / "owner").write_text(text)
    start = time.process_time()
    with pytest.raises(CaseError):
        read_polymesh(folder)
    assert time.process_time() - start < 2.0


def test_files_that_are_too_large_are_not_read(folder, monkeypatch):
    for name, size in {"points": 4_000_000_001, "boundary": 1_000_001}.items():
        kept = (folder / name).read_bytes()
        with (folder / name).open("r+b") as file:
            file.truncate(size)  # a hole: it takes no room
        with pytest.raises(CaseError, match=f"{name} is larger than"):
            read_polymesh(folder)
        (folder / name).write_bytes(kept)
    monkeypatch.setattr(foam_text, "LARGEST", 1000)
    (folder / "points").unlink()
    (folder / "points.gz").write_bytes(gzip.compress(b" " * 100_000))
    with pytest.raises(CaseError, match=r"points\.gz is larger than"):
        read_polymesh(folder)
