"""Text files of a polyMesh folder: found, unpacked, freed of header and comments, and their lists of numbers.

Everything here takes time that grows with the length of a file: the files may come from anybody.
"""

from __future__ import annotations

import gzip
import re
import zlib
from pathlib import Path

import numpy as np

from fbcouple.errors import CaseError
from fbcouple.geometry.number_text import parse_numbers

FILES = ("points", "faces", "owner", "neighbour", "boundary")
LARGEST = 4_000_000_000
"""Bytes of text that a list of a mesh may have."""
LARGEST_BOUNDARY = 1_000_000
PACKED = ".gz"
AS_TEXT = "write it as text (`foamFormatConvert -constant` with `writeFormat ascii;` in system/controlDict)."
_BLANK = re.compile(rb"\s*")
_BRACKETS = bytes.maketrans(b"()", b"  ")


def list_parts(folder: Path) -> list[str]:
    """Names of the five files in the polyMesh `folder`, of each the plain one or the one packed by gzip.

    A file that is not there is in the list under its plain name. Raises: CaseError (one text) if both are there.
    """
    names = []
    for name in FILES:
        plain, packed = (folder / name).exists(), (folder / f"{name}{PACKED}").exists()
        if plain and packed:
            raise CaseError([f"{folder.name} has {name} and {name}{PACKED}; remove the one that is out of date."])
        names.append(f"{name}{PACKED}" if packed else name)
    return names


def find_part(folder: Path, name: str) -> Path:
    """The file `name` of the polyMesh `folder`, plain or packed by gzip."""
    return folder / list_parts(folder)[FILES.index(name)]


def read_body(path: Path, most: int) -> bytes:
    """What comes after the header of an OpenFOAM file in text form, plain or packed, of at most `most` bytes.

    Raises: CaseError (one text) if it cannot be read, is larger, or is binary.
    """
    data = _read(path, most)
    start = _skip_blank(data, 0)
    if data.startswith(b"FoamFile", start):
        opening, closing = data.find(b"{", start), data.find(b"}", start)
        if not start < opening < closing:
            raise CaseError([f"{path.name}: its header FoamFile {{ ... }} has no end; write the mesh again."])
        if re.search(rb"\bformat\s+binary", data[opening:closing]):
            raise CaseError([f"{path.name} is binary; {AS_TEXT}"])
        start = closing + 1
    return data[_skip_blank(data, start) :]


def _read(path: Path, most: int) -> bytes:
    try:
        if path.stat().st_size > most:
            raise CaseError([f"{path.name} is larger than {most / 1e6:g} MB; that is no mesh for one machine."])
        if path.suffix != PACKED:
            return path.read_bytes()
        with gzip.open(path) as file:
            data = file.read(most + 1)
    except (EOFError, zlib.error, gzip.BadGzipFile) as error:
        text = f"{path.name} cannot be unpacked ({error})"
        raise CaseError([f"{text}; write the mesh again with `writeCompression off;` in system/controlDict."]) from None
    except OSError as error:
        text = f"{path.name} cannot be read: {error.strerror}"
        raise CaseError([f"{text}; a polyMesh folder has {', '.join(FILES)}."]) from None
    if len(data) > most:
        raise CaseError([f"{path.name} is larger than {most / 1e6:g} MB; that is no mesh for one machine."])
    return data


def _skip_blank(data: bytes, at: int) -> int:
    """The first place from `at` on that is neither blank nor comment."""
    while True:
        match = _BLANK.match(data, at)
        at = match.end() if match else at
        if data.startswith(b"//", at):
            ending, length = b"\n", 1
        elif data.startswith(b"/*", at):
            ending, length = b"*/", 2
        else:
            return at
        end = data.find(ending, at)
        at = len(data) if end < 0 else end + length


def strip_comments(text: str) -> str:
    """The text with a blank in place of each comment."""
    kept, at = [], 0
    while (start := text.find("/", at)) >= 0:
        if text.startswith("//", start):
            end = text.find("\n", start)
        elif text.startswith("/*", start):
            end = text.find("*/", start + 2)
            end = end + 2 if end >= 0 else end
        else:
            kept.append(text[at : start + 1])
            at = start + 1
            continue
        kept += [text[at:start], " "]
        at = len(text) if end < 0 else end
    return "".join([*kept, text[at:]])


def read_numbers(path: Path, kind: type) -> tuple[int | None, np.ndarray]:
    """All numbers of a list, without brackets, and the count in front of the list, None if there is none.

    Raises: CaseError (one text) if it is no list of numbers.
    """
    body = read_body(path, LARGEST)
    start, end = body.find(b"("), body.rfind(b")")
    try:
        if body.find(b"{") >= 0 and not 0 <= start < body.find(b"{"):
            return _read_repeated(body, kind)
        if not 0 <= start < end:
            raise ValueError("it has no list in brackets")
        count = parse_numbers(body[:start], np.int64)
        return (int(count[0]) if len(count) else None), parse_numbers(body[start + 1 : end].translate(_BRACKETS), kind)
    except ValueError as error:
        raise CaseError([f"{path.name} is not a list of numbers: {error}; write the mesh again, as text."]) from None


def _read_repeated(body: bytes, kind: type) -> tuple[int, np.ndarray]:
    """OpenFOAM's short form `N{value}` of a list of equal numbers."""
    match = re.fullmatch(rb"(\d{1,10})\s*\{\s*(\d{1,10})\s*\}\s*(//.*)?", body.strip()[:1000], re.DOTALL)
    if match is None or int(match.group(1)) > LARGEST // 8:
        raise ValueError("it has a list of equal numbers that is not `N{value}`")
    count = int(match.group(1))
    return count, np.full(count, int(match.group(2)), kind)
