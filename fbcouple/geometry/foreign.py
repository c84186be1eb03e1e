"""What a file is that is no mesh of gmsh, told by how it starts, and the command that makes a mesh of it."""

from __future__ import annotations

from pathlib import Path

from fbcouple.errors import CaseError

_LOOKED_AT = 4096
_REWRITE = "`gmsh OLD.msh -save -format msh41 -o NEW.msh` rewrites it"
_FLUENT = "`fluent3DMeshToFoam FILE` (or `fluentMeshToFoam`) makes a polyMesh folder of it"
_MESHIO = "`meshio convert --output-format gmsh22 FILE NEW.msh` makes a gmsh file of it (groups may become numbers)"
STARTS: dict[bytes, tuple[str, str]] = {
    b"(": ("a mesh of Fluent", _FLUENT),
    b"\x89HDF": ("an HDF5 file (Fluent's .msh.h5, CGNS or MED)", f"save it as text, then {_FLUENT}"),
    b"$NOD": ("a gmsh file of format 1", _REWRITE),
    b"\x1f\x8b": ("packed by gzip", "unpack it: `gunzip FILE`"),
    b"# vtk": ("a VTK file", _MESHIO),
    b"<": ("an XML file (VTK or other)", _MESHIO),
    b"CDF": ("an Exodus file", _MESHIO),
    b"*": ("a file of Abaqus", _MESHIO),
    b"solid": ("an STL surface", "mesh its inside first (gmsh or snappyHexMesh)"),
    b"MeshVersionFormatted": ("a file of Medit", _MESHIO),
    b"FoamFile": ("a file of OpenFOAM", "give the whole folder polyMesh"),
}
"""First bytes of a file -> what it is, and how it becomes a mesh that can be read."""


def refuse_foreign_format(path: Path) -> None:
    """Raise CaseError (one text) if the file is no mesh of gmsh, saying what it is where that can be told."""
    try:
        with path.open("rb") as file:
            head = file.read(_LOOKED_AT).lstrip()
    except OSError as error:
        raise CaseError([f"it cannot be read: {error.strerror}; put it beside the case file."]) from None
    if head.startswith((b"$MeshFormat", b"$Comments")):
        return
    for start, (what, mend) in STARTS.items():
        if head.startswith(start):
            raise CaseError([f"it is {what}, gmsh's format 4.1 or 2.2 is allowed; {mend}."])
    line = head.split(b"\n")[0][:40].decode("ascii", "replace").strip()
    text = f"it is no mesh of gmsh: its first line is `{line}`, $MeshFormat is expected"
    raise CaseError([f"{text}; write it with `gmsh -3 -format msh41`, or give a polyMesh folder."])
