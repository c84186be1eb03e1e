"""polyMesh folders: OpenFOAM's text files of a mesh, read as data only, and written.

OpenFOAM's own reader runs what `#calc` or `#codeStream` in such a file says. This one knows numbers, and of the file
`boundary` the name, type, start and number of faces of each patch. Runs get a mesh that was written here.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np

from fbcouple.errors import CaseError
from fbcouple.geometry.foam_boundary import read_patches
from fbcouple.geometry.foam_text import find_part, read_numbers
from fbcouple.geometry.polymesh import Patches, PolyMesh
from fbcouple.geometry.ragged import Ragged, pile_up

_CLASSES = {
    "points": "vectorField",
    "faces": "faceList",
    "owner": "labelList",
    "neighbour": "labelList",
    "boundary": "polyBoundaryMesh",
}
_AGAIN = "write the mesh again"


def read_polymesh(folder: Path) -> PolyMesh:
    """Read the text files points, faces, owner, neighbour and boundary in `folder`, plain or packed by gzip.

    Raises: CaseError (one text) naming the file that is missing, binary, or not a mesh.
    """
    points = _read_list(folder, "points", float, 3).reshape(-1, 3)
    owner, neighbour = (_read_list(folder, name, np.int64) for name in ("owner", "neighbour"))
    count, numbers = read_numbers(find_part(folder, "faces"), np.int64)
    faces = _split_rows(numbers, len(owner) if count is None else count, "faces")
    patches = read_patches(find_part(folder, "boundary"))
    neighbour = neighbour[neighbour >= 0]
    if not np.isfinite(points).all():
        raise CaseError(["points holds a coordinate that is not finite; fix it."])
    _require_fit(points, faces, owner, neighbour)
    _require_patches(patches, len(neighbour), len(owner))
    return PolyMesh(points, faces, owner, neighbour, patches)


def _read_list(folder: Path, name: str, kind: type, columns: int = 1) -> np.ndarray:
    count, numbers = read_numbers(find_part(folder, name), kind)
    if len(numbers) % columns or (count is not None and len(numbers) != count * columns):
        text = f"{name} holds {len(numbers) / columns:g} entries"
        raise CaseError([f"{text} and says {count}; the file is cut off or was edited: {_AGAIN}."])
    return numbers


def _split_rows(numbers: np.ndarray, count: int, name: str) -> Ragged:
    """Rows that each start with their length."""
    wrong = CaseError([f"{name} does not hold {count} faces, each the number of its points and the points; {_AGAIN}."])
    if numbers.min(initial=0) < 0:
        raise wrong
    if len(numbers) and count and len(numbers) == count * (numbers[0] + 1):
        table = numbers.reshape(count, -1)
        if np.all(table[:, 0] == numbers[0]):
            return pile_up(table[:, 0], table[:, 1:].ravel())
    starts, index, values = [], 0, numbers.tolist()
    while index < len(values):
        starts.append(index)
        index += values[index] + 1
    if index != len(values) or len(starts) != count:
        raise wrong
    heads = np.array(starts, dtype=np.int64)
    keep = np.ones(len(numbers), bool)
    keep[heads] = False
    return pile_up(numbers[heads], numbers[keep])


def _require_fit(points: np.ndarray, faces: Ragged, owner: np.ndarray, neighbour: np.ndarray) -> None:
    """Raise CaseError unless the four lists are of one mesh, in OpenFOAM's order."""
    inner = len(neighbour)
    if len(faces) != len(owner) or inner >= len(owner):
        text = f"there are {len(faces)} faces, {len(owner)} owners and {inner} neighbours"
        raise CaseError([f"{text}; each face has an owner and each inner one a neighbour: {_AGAIN}."])
    if faces.values.max(initial=0) >= len(points):
        raise CaseError([f"faces names point {faces.values.max()} and there are {len(points)} points; {_AGAIN}."])
    if faces.lengths.min() < 3:
        raise CaseError([f"faces has a face of {faces.lengths.min()} points, at least 3 are allowed; {_AGAIN}."])
    if owner.min() < 0 or max(owner.max(), neighbour.max(initial=0)) >= len(owner):
        raise CaseError([f"owner or neighbour names a cell that can have no face; {_AGAIN}."])
    order = owner[:inner] * len(owner) + neighbour
    if np.any(owner[:inner] >= neighbour) or np.any(np.diff(order) < 0):
        text = "the inner faces are not in OpenFOAM's order (owner below neighbour, then by neighbour)"
        raise CaseError([f"{text}; `renumberMesh -overwrite` puts them right."])


def _require_patches(patches: Patches, inner: int, faces: int) -> None:
    """Raise CaseError unless the patches have each outer face once."""
    at = inner
    for name, (first, count) in sorted(patches.items(), key=lambda item: item[1]):
        if first != at or count < 0:
            text = f"patch {name} has {count} faces from face {first} on, face {at} is the next without a patch"
            raise CaseError([f"boundary: {text}; {_AGAIN}."])
        at += count
    if at != faces:
        raise CaseError([f"boundary: its patches end at face {at} and there are {faces} faces; {_AGAIN}."])


def write_polymesh(mesh: PolyMesh, folder: Path, cyclic: Sequence[tuple[str, str]] = ()) -> None:
    """Write `mesh` into `folder`; the patches "inlet" and "outlet", or "outlet1" and so on, are open, the pairs
    `cyclic`, at the ends of an axis along which a box repeats itself, are that, all others walls."""
    folder.mkdir(parents=True, exist_ok=True)
    lists = {
        "points": (f"({x!r} {y!r} {z!r})" for x, y, z in mesh.points.tolist()),
        "faces": _format_faces(mesh.faces),
        "owner": map(str, mesh.owner.tolist()),
        "neighbour": map(str, mesh.neighbour.tolist()),
    }
    counts = {"points": len(mesh.points), "faces": len(mesh.faces), "owner": len(mesh.owner)}
    for name, lines in lists.items():
        with (folder / name).open("w", encoding="utf-8") as file:
            file.write(f"{_format_head(name)}{counts.get(name, len(mesh.neighbour))}\n(\n")
            file.writelines(f"{line}\n" for line in lines)
            file.write(")\n")
    partners = {name: pair[1 - n] for pair in cyclic for n, name in enumerate(pair)}
    with (folder / "boundary").open("w", encoding="utf-8") as file:
        file.write(f"{_format_head('boundary')}{len(mesh.patches)}\n(\n")
        for name, (start, count) in mesh.patches.items():
            kind = "patch" if name == "inlet" or name.startswith("outlet") else "wall"
            if name in partners:
                kind = f"cyclic; neighbourPatch {partners[name]}"
            file.write(f"{name} {{ type {kind}; nFaces {count}; startFace {start}; }}\n")
        file.write(")\n")


def _format_faces(faces: Ragged) -> Iterator[str]:
    values = faces.values.tolist()
    starts = faces.starts.tolist()
    for start, end in pairwise(starts):
        yield f"{end - start}({' '.join(map(str, values[start:end]))})"


def _format_head(name: str) -> str:
    entries = f"version 2.0; format ascii; class {_CLASSES[name]}; object {name};"
    return f"FoamFile {{ {entries} }}\n"
