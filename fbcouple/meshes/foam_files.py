"""polyMesh folders: OpenFOAM's text files of a mesh, read as data only, and written.

OpenFOAM's own reader runs what `#calc` or `#codeStream` in such a file says. This one knows numbers, and of the file
`boundary` the name, type, start and number of faces of each patch. Runs get a mesh that was written here.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

import numpy as np

from fbcouple.errors import CaseError
from fbcouple.meshes.polymesh import Patches, PolyMesh
from fbcouple.meshes.ragged import Ragged, pile_up

FILES = ("points", "faces", "owner", "neighbour", "boundary")
LARGEST = 4_000_000_000
"""Bytes that a file of a mesh may have."""
_PATCH = re.compile(r"(\w[\w.:+-]*)\s*\{([^{}]*)\}")
_ENTRY = re.compile(r"(\w+)\s+([^;{}]*);")
_CLASSES = {
    "points": "vectorField",
    "faces": "faceList",
    "owner": "labelList",
    "neighbour": "labelList",
    "boundary": "polyBoundaryMesh",
}
_REPEATED = ("cyclic", "cyclicAMI", "cyclicACMI", "empty", "wedge", "processor", "symmetry", "symmetryPlane")


def read_polymesh(folder: Path) -> PolyMesh:
    """Read the text files points, faces, owner, neighbour and boundary in `folder`.

    Raises: CaseError (one text) naming the file that is missing, binary, or not a mesh.
    """
    points = _read_numbers(folder / "points", float).reshape(-1, 3)
    owner, neighbour = (_read_numbers(folder / name, np.int64) for name in ("owner", "neighbour"))
    faces = _split_rows(_read_numbers(folder / "faces", np.int64), len(owner), folder / "faces")
    patches = _read_patches(folder / "boundary")
    neighbour = neighbour[neighbour >= 0]
    if not np.isfinite(points).all():
        raise CaseError([f"{folder / 'points'} holds a coordinate that is not finite; mend it."])
    last = len(owner) - len(neighbour)
    bad = faces.values.min(initial=0) < 0 or faces.values.max(initial=0) >= len(points) or owner.min(initial=0) < 0
    if bad or last <= 0 or sum(count for _, count in patches.values()) != last:
        raise CaseError([f"{folder}: points, faces, cells and patches do not fit together; write the mesh again."])
    return PolyMesh(points, faces, owner, neighbour, patches)


def _read_text(path: Path) -> str:
    mend = "write the mesh as text (foamFormatConvert with writeFormat ascii, writeCompression off)."
    try:
        if path.stat().st_size > LARGEST:
            raise CaseError([f"{path.name} is larger than {LARGEST / 1e9:g} GB; {mend}"])
        text = path.read_bytes().decode("ascii")
    except OSError as error:
        raise CaseError(
            [f"{path} cannot be read: {error.strerror}; a polyMesh folder has {', '.join(FILES)}."]
        ) from None
    except UnicodeDecodeError:
        raise CaseError([f"{path} is not text; {mend}"]) from None
    header = re.search(r"FoamFile\s*\{([^{}]*)\}", text)
    if header and "binary" in header.group(1):
        raise CaseError([f"{path} is binary; {mend}"])
    body = text[header.end() :] if header else text
    return re.sub(r"//[^\n]*|/\*.*?\*/", " ", body, flags=re.DOTALL)


def _read_numbers(path: Path, kind: type) -> np.ndarray:
    """All numbers of a list, without the count in front of it."""
    text = _read_text(path)
    start, end = text.find("("), text.rfind(")")
    inner = text[start + 1 : end].replace("(", " ").replace(")", " ")
    if start < 0 or not re.fullmatch(r"[\s0-9eE.+-]*", inner):
        raise CaseError([f"{path} is not a list of numbers; write the mesh again, as text."])
    try:
        return np.array(inner.split(), dtype=kind)
    except ValueError as error:
        raise CaseError([f"{path} holds what is no number ({str(error)[:80]}); write the mesh again."]) from None


def _split_rows(numbers: np.ndarray, count: int, path: Path) -> Ragged:
    """Rows that each start with their length."""
    if len(numbers) and count and len(numbers) == count * (numbers[0] + 1):
        table = numbers.reshape(count, -1)
        if np.all(table[:, 0] == numbers[0]):
            return pile_up(table[:, 0], table[:, 1:].ravel())
    starts, place, values = [], 0, numbers.tolist()
    while place < len(values):
        starts.append(place)
        place += values[place] + 1
    if place != len(values) or len(starts) != count:
        raise CaseError([f"{path} does not have a face for each of the {count} owners; write the mesh again."])
    heads = np.array(starts, dtype=np.int64)
    keep = np.ones(len(numbers), bool)
    keep[heads] = False
    return pile_up(numbers[heads], numbers[keep])


def _read_patches(path: Path) -> Patches:
    text = _read_text(path)
    if "#" in text or "$" in text:
        raise CaseError([f"{path} has `#` or `$`: only plain patches are read; write them out."])
    patches: Patches = {}
    for name, body in _PATCH.findall(text):
        entries = dict(_ENTRY.findall(body))
        try:
            patches[name] = int(entries["startFace"]), int(entries["nFaces"])
        except (KeyError, ValueError):
            raise CaseError([f"{path}: patch {name} has no startFace and nFaces; mend it."]) from None
        if entries.get("type", "").strip() in _REPEATED and patches[name][1]:
            text = f"patch {name} is of the type {entries['type'].strip()}, `patch` and `wall` are allowed"
            raise CaseError([f"{path}: {text}; mend it in the mesher."])
    return patches


def write_polymesh(mesh: PolyMesh, folder: Path) -> None:
    """Write `mesh` into `folder`; the patches "inlet" and "outlet" are open, all others walls."""
    folder.mkdir(parents=True, exist_ok=True)
    lists = {
        "points": (f"({x!r} {y!r} {z!r})" for x, y, z in mesh.points.tolist()),
        "faces": _word_faces(mesh.faces),
        "owner": map(str, mesh.owner.tolist()),
        "neighbour": map(str, mesh.neighbour.tolist()),
    }
    counts = {"points": len(mesh.points), "faces": len(mesh.faces), "owner": len(mesh.owner)}
    for name, lines in lists.items():
        with (folder / name).open("w", encoding="utf-8") as file:
            file.write(f"{_word_head(name)}{counts.get(name, len(mesh.neighbour))}\n(\n")
            file.writelines(f"{line}\n" for line in lines)
            file.write(")\n")
    with (folder / "boundary").open("w", encoding="utf-8") as file:
        file.write(f"{_word_head('boundary')}{len(mesh.patches)}\n(\n")
        for name, (start, count) in mesh.patches.items():
            kind = "patch" if name in ("inlet", "outlet") else "wall"
            file.write(f"{name} {{ type {kind}; nFaces {count}; startFace {start}; }}\n")
        file.write(")\n")


def _word_faces(faces: Ragged) -> Iterator[str]:
    values = faces.values.tolist()
    starts = faces.starts.tolist()
    for start, end in pairwise(starts):
        yield f"{end - start}({' '.join(map(str, values[start:end]))})"


def _word_head(name: str) -> str:
    entries = f"version 2.0; format ascii; class {_CLASSES[name]}; object {name};"
    return f"FoamFile {{ {entries} }}\n"
