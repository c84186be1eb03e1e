"""gmsh's files, formats 2 and 4.1, text and binary: points, elements, and every group that an element is in.

The groups come from the file's own tables ($PhysicalNames, $Entities), by dimension and number: a name may stand for
a surface and a volume at once, a surface may be in several groups, and a group may have no name.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

import numpy as np

from fbcouple.errors import CaseError
from fbcouple.geometry.gmsh_numbers import AGAIN, CUT_OFF, Numbers

LARGEST = 4_000_000_000
"""Bytes that a file may have."""
ELEMENTS: dict[int, tuple[str, int, int]] = {
    1: ("line", 1, 2),
    2: ("triangle", 2, 3),
    3: ("quad", 2, 4),
    4: ("tetra", 3, 4),
    5: ("hexahedron", 3, 8),
    6: ("wedge", 3, 6),
    7: ("pyramid", 3, 5),
    15: ("vertex", 0, 1),
}
"""gmsh's number of an element -> its word, dimension and number of points."""
_CURVED = {9: "triangle6", 10: "quad9", 11: "tetra10", 12: "hexahedron27", 13: "wedge18", 14: "pyramid14"}
_CURVED |= {8: "line3", 16: "quad8", 17: "hexahedron20", 18: "wedge15", 19: "pyramid13"}
_ENOUGH = {"Nodes", "Elements"}
_NAMES = 8
_GROUPS_LOST = (
    "format 2 loses them with Mesh.SaveAll = 1; mesh it again in format 4.1 (`gmsh -3 -format msh41`), or with "
    "Mesh.SaveAll = 0 and the volume in a physical group"
)
_REWRITE = "`gmsh OLD.msh -save -format msh41 -o NEW.msh` rewrites it"


class Block(NamedTuple):
    """Elements of one word of `ELEMENTS` that are in the same groups: rows of points, and the groups' numbers."""

    kind: str
    corners: np.ndarray
    groups: tuple[int, ...]


@dataclass
class GmshFile:
    """Points (n, 3), blocks of elements, and the names of groups by dimension and number.

    repeats: an element stands in the file once for each of its groups (format 2).
    """

    repeats: bool
    points: np.ndarray = field(default_factory=lambda: np.empty((0, 3)))
    blocks: list[Block] = field(default_factory=list)
    names: dict[tuple[int, int], str] = field(default_factory=dict)


def read_gmsh_file(path: Path) -> GmshFile:
    """Read the points, elements and groups of a file. Raises: CaseError (one text) saying why it cannot be read."""
    try:
        if path.stat().st_size > LARGEST:
            raise CaseError([f"it is larger than {LARGEST / 1e9:g} GB; that is no mesh for one machine."])
        return _read(path.read_bytes())
    except ValueError as error:
        raise CaseError([f"it cannot be read as a gmsh mesh: {error}."]) from None


def _read(data: bytes) -> GmshFile:
    sections = dict(_split(data))
    header = sections.get("MeshFormat", b"").split(b"\n")[0].split()
    if len(header) != 3 or header[1] not in (b"0", b"1") or header[2] not in (b"4", b"8"):
        raise ValueError(f"it has no line like `4.1 0 8` after $MeshFormat; {AGAIN}")
    version, is_text, size = header[0].decode("ascii", "replace"), header[1] == b"0", int(header[2])
    if version not in ("2", "2.0", "2.1", "2.2", "4.1"):
        raise ValueError(f"it is of the format {version}, 2.2 and 4.1 are allowed; {_REWRITE}")
    if not is_text and sections["MeshFormat"].split(b"\n", 1)[1][:4] != np.array(1, "i4").tobytes():
        raise ValueError("its binary numbers are of another byte order; write it as text (Mesh.Binary = 0)")
    if "PartitionedEntities" in sections:
        raise ValueError(f"it is cut into partitions; remove them (Mesh > Unpartition): {AGAIN}")
    if not sections.keys() >= _ENOUGH:
        raise ValueError(f"it has no {' and '.join(sorted(_ENOUGH - sections.keys()))}; mesh it in 3D: {AGAIN}")
    found = GmshFile(version != "4.1")
    found.names = dict(_read_names(sections.get("PhysicalNames", b"0")))
    nodes, elements = (Numbers(sections[name], is_text, size) for name in ("Nodes", "Elements"))
    if found.repeats:
        tags, found.points = _read_nodes_2(nodes, is_text)
        rows = _read_elements_2(elements, is_text)
    else:
        entities = dict(
            _read_entities(Numbers(sections["Entities"], is_text, size) if "Entities" in sections else None)
        )
        tags, found.points = _read_nodes(nodes)
        rows = _read_elements(elements, entities)
    found.blocks = [Block(kind, _number(tags, corners), groups) for kind, corners, groups in rows]
    if found.names and found.blocks and not any(block.groups for block in found.blocks):
        names = list(dict.fromkeys(found.names.values()))
        shown = ", ".join(names[:_NAMES]) + (", ..." if len(names) > _NAMES else "")
        raise ValueError(f"it names the groups {shown}, and none of its elements is in one: {_GROUPS_LOST}")
    return found


def _split(data: bytes) -> Iterator[tuple[str, bytes]]:
    """Sections by name, up to the last that is needed: what lies between `$NAME` and `$EndNAME`."""
    at, needed = 0, set(_ENOUGH)
    while needed and (start := data.find(b"$", at)) >= 0:
        head = data.find(b"\n", start)
        name = data[start + 1 : head if head >= 0 else len(data)].strip()
        end = data.find(b"$End" + name, head)
        if head < 0 or end < 0 or not name.isalnum():
            raise ValueError(f"its section ${name[:40].decode('ascii', 'replace')} has no end; {CUT_OFF}")
        word = name.decode("ascii")
        yield word, data[head + 1 : end]
        needed.discard(word)
        at = end + len(b"$End" + name)


def _read_names(data: bytes) -> Iterator[tuple[tuple[int, int], str]]:
    """Dimension and number of each named group, and its name."""
    try:
        lines = data.decode().splitlines()
    except UnicodeDecodeError:
        raise ValueError("a name of a group is not UTF-8; rename it") from None
    for line in lines[1:]:
        numbers, _, name = line.partition('"')
        if name:
            dimension, tag = (int(word) for word in numbers.split())
            yield (dimension, tag), name.rpartition('"')[0]


def _read_entities(numbers: Numbers | None) -> Iterator[tuple[tuple[int, int], tuple[int, ...]]]:
    """Dimension and number of each entity, and the groups that it is in."""
    if numbers is None:
        return
    for dimension, count in enumerate(numbers.take("s", 4).tolist()):
        for _ in range(count):
            tag = numbers.one("i")
            numbers.take("d", 6 if dimension else 3)
            groups = np.abs(numbers.take("i", numbers.one("s")))
            if dimension:
                numbers.take("i", numbers.one("s"))
            yield (dimension, tag), tuple(groups.tolist())


def _read_nodes(numbers: Numbers) -> tuple[np.ndarray, np.ndarray]:
    blocks = numbers.one("s")
    numbers.take("s", 3)
    tags, coordinates = [np.empty(0, np.int64)], [np.empty((0, 3))]
    for _ in range(blocks):
        dimension, _, parametric = numbers.take("i", 3).tolist()
        count, columns = numbers.one("s"), 3 + (dimension if parametric else 0)
        tags.append(numbers.take("s", count))
        coordinates.append(numbers.take("d", count * columns).reshape(count, columns)[:, :3])
    return np.concatenate(tags), np.concatenate(coordinates)


Rows = Iterator[tuple[str, np.ndarray, tuple[int, ...]]]


def _read_elements(numbers: Numbers, entities: dict[tuple[int, int], tuple[int, ...]]) -> Rows:
    blocks = numbers.one("s")
    numbers.take("s", 3)
    for _ in range(blocks):
        dimension, entity, kind = numbers.take("i", 3).tolist()
        word, _, width = _find_element(kind)
        count = numbers.one("s")
        rows = numbers.take("s", count * (1 + width)).reshape(count, -1)
        yield word, rows[:, 1:], entities.get((dimension, entity), ())


def _read_nodes_2(numbers: Numbers, is_text: bool) -> tuple[np.ndarray, np.ndarray]:
    if is_text:
        table = numbers.take("d", 4 * numbers.count()).reshape(-1, 4)
        return table[:, 0].astype(np.int64), table[:, 1:]
    rows = numbers.take_rows(np.dtype([("tag", "i4"), ("place", "f8", 3)]), numbers.count())
    return rows["tag"].astype(np.int64), rows["place"]


def _read_elements_2(numbers: Numbers, is_text: bool) -> Rows:
    """Rows of format 2: number, kind, number of tags, tags (the first is the group), points."""
    for kind, tags, rows in _split_rows(numbers) if is_text else _split_binary_rows(numbers):
        word, _, width = _find_element(kind)
        group = np.abs(rows[:, -width - tags]) if tags else np.zeros(len(rows), np.int64)
        for tag in np.unique(group).tolist():
            yield word, rows[group == tag, -width:], (tag,) if tag else ()


def _split_rows(numbers: Numbers) -> Iterator[tuple[int, int, np.ndarray]]:
    """Runs of rows of one kind with one number of tags."""
    left = numbers.count()
    rest, at = numbers.take_rest(), 0
    while left > 0:
        if at + 3 > len(rest):
            raise ValueError(CUT_OFF)
        _, kind, tags = rest[at : at + 3].tolist()
        width = 3 + max(tags, 0) + _find_element(kind)[2]
        table = rest[at : at + min(left, (len(rest) - at) // width) * width].reshape(-1, width)
        count = _count_alike(table[:, 1:3])
        if not count:
            raise ValueError(CUT_OFF)
        yield kind, tags, table[:count]
        left, at = left - count, at + count * width


def _count_alike(rows: np.ndarray) -> int:
    """How many of the first rows are the same; the work is that of these rows."""
    count, window = 0, 256
    while count < len(rows):
        same = (rows[count : count + window] == rows[0]).all(axis=1)
        if not same.all():
            return count + int(same.argmin())
        count, window = min(count + window, len(rows)), 2 * window
    return count


def _split_binary_rows(numbers: Numbers) -> Iterator[tuple[int, int, np.ndarray]]:
    left = numbers.count()
    while left > 0:
        kind, count, tags = numbers.take("i", 3).tolist()
        if count <= 0 or tags < 0:
            raise ValueError(f"it has a block of no elements; {AGAIN}")
        width = 1 + tags + _find_element(kind)[2]
        yield kind, tags, numbers.take("i", count * width).reshape(count, width)
        left -= count


def _find_element(kind: int) -> tuple[str, int, int]:
    if kind in ELEMENTS:
        return ELEMENTS[kind]
    allowed = ", ".join(word for word, dimension, _ in ELEMENTS.values() if dimension == 3)
    if kind in _CURVED:
        text = f"it has curved elements ({_CURVED[kind]}), linear {allowed} are allowed"
        raise ValueError(f"{text}: mesh it with Mesh.ElementOrder = 1")
    raise ValueError(f"it has elements of the type {kind}, linear {allowed} are allowed: mesh it with these")


def _number(tags: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Rows of points in place of their tags, which may have gaps and any order."""
    if not len(corners):
        return corners.astype(np.int64)
    order = np.argsort(tags, kind="stable")
    coordinates = np.minimum(np.searchsorted(tags, corners, sorter=order), len(tags) - 1)
    rows = order[coordinates]
    if not len(tags) or np.any(tags[rows] != corners):
        raise ValueError(f"an element names a point that is not there; {AGAIN}")
    return rows
